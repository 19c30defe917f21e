/** Drawing of rotors and of the bodies on them: balls, pendulums, masses in guides. */

import type { BodyData, RotorData, SliderData } from "./drawing_data.ts";
import type { Pose } from "./pose.ts";
import type { Pen } from "./shapes.ts";

/** Smallest radii in pixels: of balls, and of the masses of pendulums. */
export const SMALLEST_BALL = 3.5;
const SMALLEST_BOB = 5;
const BOB = 0.066;
/** Pixels: the first of two pendulums is so much wider, so that it is seen behind the second. */
const HALO = 3;
/** Of the rotor's radius: the ring of its heavy side, inside its bodies or, without these, at the rim. */
const [INSIDE, RIM] = [[0.24, 0.46], [0.72, 0.92]] as const;
/** Half the angle of the heavy side at the largest unbalance. */
const HEAVY_ANGLE = 0.42;
const WIDEST = 1.5;
/** A slower rotor is marked with the sense of its drive: of 1 in its unit of speed. */
const STANDSTILL = 1e-3;

/** The radius at which a body is drawn, in pixels. */
export function drawnRadius(pose: Pose, body: BodyData, scale: number): number {
  const size = pose.length(body.size) * scale;
  if (size > 0) return Math.max(size, SMALLEST_BALL);
  return Math.max(BOB * pose.length(pose.machine.drawing.rotors[body.rotor]!.radius) * scale, SMALLEST_BOB);
}

/** The disc, its tracks and its heavy side. */
export function drawDisc(pen: Pen, pose: Pose, rotor: RotorData, index: number): void {
  const { ink, muted, surface, accents } = pen.colours;
  const { bodies } = pose.machine.drawing;
  const [x, y] = [pose.axisX(index), pose.axisY(index)];
  const radius = pose.length(rotor.radius) * pen.scale;
  const angle = pose.angles[rotor.body]!;
  pen.circle(x, y, radius, surface, ink, 1.6);
  for (const body of bodies) {
    const track = pose.length(body.track);
    if (body.rotor === index && track > 0) pen.circle(x, y, track * pen.scale, null, muted, 1);
  }
  const [ux, uy] = [Math.cos(angle) / pen.scale, Math.sin(angle) / pen.scale];
  const share = Math.abs(pose.length(bodies[rotor.body]!.unbalance)) / pose.largestUnbalance;
  pen.line(x - radius * ux, y - radius * uy, x - 0.86 * radius * ux, y - 0.86 * radius * uy, muted, 1.2);
  pen.line(x + 0.86 * radius * ux, y + 0.86 * radius * uy, x + radius * ux, y + radius * uy, ink, 1.8);
  if (share > 0) {
    const half = Math.min(WIDEST, Math.max(0.04, HEAVY_ANGLE * share));
    const isShared = bodies.some((body) => body.rotor === index && body.about !== null) || hasSliders(pose, rotor.body);
    const [inner, outer] = isShared ? INSIDE : RIM;
    pen.sector(x, y, inner * radius, outer * radius, angle, half, accents[1], ink);
  }
}

function hasSliders(pose: Pose, body: number): boolean {
  return pose.machine.drawing.sliders.some(({ about }) => about === body);
}

/** The axis, the sense of rotation and, among several rotors, the name. turn: of the view, in which the arrow stands still. */
export function drawAxis(pen: Pen, pose: Pose, rotor: RotorData, index: number, turn: number, isNamed: boolean): void {
  const { ink, muted, surface } = pen.colours;
  const [x, y] = [pose.axisX(index), pose.axisY(index)];
  const radius = pose.length(rotor.radius) * pen.scale;
  const speed = pose.speeds[rotor.body]!;
  const sense = Math.abs(speed) > STANDSTILL ? Math.sign(speed) : rotor.sense;
  pen.circle(x, y, Math.max(2.5, 0.035 * radius), surface, ink, 1.4);
  if (sense !== 0) {
    const middle = turn + Math.PI / 4;
    const half = 0.42 * sense;
    pen.arc(x, y, radius + 7, middle - half, middle + half, muted, 1.4);
  }
  if (isNamed) pen.text(rotor.name, pen.pixelX(x, y), pen.pixelY(x, y) + radius + 10, ink, 12, "center", surface);
}

/** A body on its rotor. `order`: its number among those of the rotor, from 0. */
export function drawBody(pen: Pen, pose: Pose, body: BodyData, index: number, order: number): void {
  const { accents } = pen.colours;
  if (body.guide !== null) drawSwitchable(pen, pose, body, index, accents[order % 2 === 0 ? 0 : 2]);
  else if (pose.length(body.track) > 0) drawBall(pen, pose, body, index, order);
  else drawPendulum(pen, pose, body, index, accents[order % 2 === 0 ? 0 : 2], order === 0 ? HALO : 0);
}

/** A ball with a line that shows how it rolls, or its number where it is large enough. */
function drawBall(pen: Pen, pose: Pose, body: BodyData, index: number, order: number): void {
  const { ink, surface, accents } = pen.colours;
  const [x, y] = [pose.centres[2 * index]!, pose.centres[2 * index + 1]!];
  const radius = drawnRadius(pose, body, pen.scale);
  pen.circle(x, y, radius, accents[0], ink, 1);
  if (radius < 5) return;
  const [track, size] = [pose.length(body.track), pose.length(body.size)];
  const about = body.about === null ? 0 : pose.angles[body.about]!;
  const spin = (track * about - (track - size) * pose.angles[index]!) / size;
  const [ux, uy] = [Math.cos(spin) / pen.scale, Math.sin(spin) / pen.scale];
  pen.line(x + 0.55 * radius * ux, y + 0.55 * radius * uy, x + 0.95 * radius * ux, y + 0.95 * radius * uy, surface, 1.6);
  if (radius < NUMBERED) return;
  const number = NUMBERS[order % NUMBERS.length]!;
  pen.text(number, pen.pixelX(x, y), pen.pixelY(x, y) + 0.5, surface, Math.min(14, radius), "center", null);
}

/** Pixels: larger balls have their number. */
const NUMBERED = 13;
const NUMBERS = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"] as const;

function drawPendulum(pen: Pen, pose: Pose, body: BodyData, index: number, colour: string, halo: number): void {
  const { ink, surface } = pen.colours;
  const [px, py] = [pose.pivots[2 * index]!, pose.pivots[2 * index + 1]!];
  const [x, y] = [pose.centres[2 * index]!, pose.centres[2 * index + 1]!];
  pen.line(px, py, x, y, ink, 5 + halo);
  pen.line(px, py, x, y, colour, 3 + halo);
  pen.circle(px, py, 3, surface, ink, 1.2);
  pen.circle(x, y, drawnRadius(pose, body, pen.scale) + (pose.length(body.size) > 0 ? 0 : halo), colour, ink, 1.2);
}

/** A frame with a mass in a radial guide between two stops. */
function drawSwitchable(pen: Pen, pose: Pose, body: BodyData, index: number, colour: string): void {
  const { ink, muted } = pen.colours;
  const [px, py] = [pose.pivots[2 * index]!, pose.pivots[2 * index + 1]!];
  const [x, y] = [pose.centres[2 * index]!, pose.centres[2 * index + 1]!];
  const angle = pose.angles[index]!;
  const [ux, uy] = [Math.cos(angle), Math.sin(angle)];
  const [inner, outer] = [pose.length(body.guide!.inner_stop), pose.length(body.guide!.outer_stop)];
  const radius = drawnRadius(pose, body, pen.scale);
  const [end, half] = [radius / pen.scale, 0.9 * (radius / pen.scale)];
  pen.line(px - 0.45 * inner * ux, py - 0.45 * inner * uy, px, py, ink, 7);
  pen.line(px, py, px + (outer + end) * ux, py + (outer + end) * uy, muted, 1.6);
  pen.spring(px, py, x, y, 4, colour);
  for (const at of [inner - end, outer + end]) {
    const [sx, sy] = [px + at * ux, py + at * uy];
    pen.line(sx - half * uy, sy + half * ux, sx + half * uy, sy - half * ux, ink, 2.4);
  }
  pen.circle(x, y, radius, colour, ink, 1.2);
}

/** A mass in a guide of a turning body. */
export function drawSlider(pen: Pen, pose: Pose, slider: SliderData, state: ArrayLike<number>): void {
  const { ink, muted, accents } = pen.colours;
  const body = pose.machine.drawing.bodies[slider.about]!;
  const direction = pose.angles[slider.about]! + pose.length(slider.angle);
  const [ux, uy] = [Math.cos(direction), Math.sin(direction)];
  const [x, y] = [pose.axisX(body.rotor), pose.axisY(body.rotor)];
  const radius = pose.length(pose.machine.drawing.rotors[body.rotor]!.radius);
  const at = pose.length(slider.arm) + state[slider.displacement]!;
  const half = 0.07 * radius;
  for (const side of [-half, half]) {
    pen.line(x + 0.12 * radius * ux - side * uy, y + 0.12 * radius * uy + side * ux,
      x + 0.98 * radius * ux - side * uy, y + 0.98 * radius * uy + side * ux, muted, 1.2);
  }
  pen.spring(x + 0.1 * radius * ux, y + 0.1 * radius * uy, x + at * ux, y + at * uy, 0.6 * half * pen.scale, ink);
  pen.circle(x + at * ux, y + at * uy, Math.max(SMALLEST_BOB, half * pen.scale), accents[0], ink, 1.2);
}
