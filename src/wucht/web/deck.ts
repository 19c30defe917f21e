/** The deck of a machine: a carrier that turns in its plane, so that its ends move otherwise than its centre of mass. */

import type { Course } from "./course.ts";
import type { DrawingData } from "./drawing_data.ts";
import type { Pose } from "./pose.ts";
import { parametersAt } from "./scenario.ts";
import type { Pen } from "./shapes.ts";

/** Pixels: the mark of the newest point. */
const MARK = 2.6;

/** The orbits of the last turns as pairs x, y (m), the last the newest. */
export interface Orbits {
  /** Of the main rotor's axis. */
  readonly axis: Float64Array;
  /** Of the places of the deck: displacements from rest. Empty without a deck. */
  readonly deck: readonly Float64Array[];
}

/** Whether a carrier has ends whose orbits differ. Those of one that is not to scale are no places of the machine. */
export function hasDeck({ to_scale: toScale, turning, carrier }: DrawingData): boolean {
  return toScale && turning === "in plane" && carrier.some(({ label }) => label === "x" || label === "y");
}

/** Places x, y on the deck: its left end, its centre of mass, its right end. The ends are as high as the centre of mass. */
export function deckPlaces(pose: Pose): readonly (readonly [number, number])[] {
  const [left, bottom, right, top] = pose.machine.drawing.box;
  const height = Math.max(pose.length(bottom), Math.min(pose.length(top), 0));
  return [[pose.length(left), height], [0, 0], [pose.length(right), height]];
}

/** Set a pair to the displacement from rest of a place on the carrier. A turn is small, as it is in the machine's equations. */
export function displace(pose: Pose, a: number, b: number, state: ArrayLike<number>, pair: Float64Array): void {
  let [x, y] = [0, 0];
  for (const { label, position, rest } of pose.machine.drawing.carrier) {
    const moved = state[position]! - pose.length(rest);
    if (label === "x") x += moved;
    else if (label === "y") y += moved;
    else if (label === "r") {
      x -= b * moved;
      y += a * moved;
    }
  }
  pair[0] = x;
  pair[1] = y;
}

/** The orbit of each place of the deck over `count` states of n numbers each. */
export function deckOrbits(pose: Pose, states: Float64Array, n: number, count: number): Float64Array[] {
  return deckPlaces(pose).map(([a, b]) => {
    const orbit = new Float64Array(2 * count);
    for (let k = 0; k < count; k++) displace(pose, a, b, states.subarray(k * n, (k + 1) * n), orbit.subarray(2 * k, 2 * k + 2));
    return orbit;
  });
}

/** The largest displacement from rest of a place of the deck in a course. */
export function largestOfDeck(pose: Pose, course: Course, n: number): number {
  const { scenario, time, states } = course;
  const pair = new Float64Array(2);
  let largest = 0;
  let next = -Infinity;
  let places: ReturnType<typeof deckPlaces> = [];
  for (let k = 0; k < time.length; k++) {
    const state = states.subarray(k * n, (k + 1) * n);
    if (time[k]! >= next) {
      pose.update(state, [], parametersAt(scenario, time[k]!), 1);
      places = deckPlaces(pose);
      next = scenario.changes.find((change) => change.time > time[k]!)?.time ?? Infinity;
    }
    for (const [a, b] of places) {
      displace(pose, a, b, state, pair);
      largest = Math.max(largest, Math.hypot(pair[0]!, pair[1]!));
    }
  }
  return largest;
}

/** Draw the orbits of the deck's places from their rest, magnified as the carrier's motion, and mark the newest points. */
export function drawDeckOrbits(pen: Pen, pose: Pose, orbits: readonly Float64Array[]): void {
  const colour = pen.colours.accents[3];
  const places = deckPlaces(pose);
  orbits.forEach((orbit, i) => {
    const [a, b] = places[i]!;
    const x = (k: number): number => a + pose.magnification * orbit[2 * k]!;
    const y = (k: number): number => b + pose.magnification * orbit[2 * k + 1]!;
    const last = orbit.length / 2 - 1;
    pen.context.beginPath();
    for (let k = 0; k <= last; k++) pen.context.lineTo(pen.pixelX(x(k), y(k)), pen.pixelY(x(k), y(k)));
    pen.stroke(colour, 1.6);
    if (last >= 0) pen.circle(x(last), y(last), MARK, colour, null, 0);
  });
}
