/** Where the parts of a machine are in a state: geometry without a canvas. Lengths in m, the carrier's motion magnified. */

import type { DrawnMachine } from "./drawing_data.ts";

const FULL_TURN = 2 * Math.PI;
/** Of a turn about the normal that is magnified: beyond, nothing could be recognised. */
const LARGEST_TILT = 0.6;

export class Pose {
  readonly machine: DrawnMachine;
  /** All lengths at the parameters. */
  readonly lengths: Float64Array;
  /** Changes whenever the parameters do. */
  version = 0;
  /** The displacement of the carrier and its turn, of the foundation, and of the springs' upper ends. */
  x = 0;
  y = 0;
  turn = 0;
  foundationX = 0;
  foundationY = 0;
  /** The centre about which the carrier turns. */
  pivotX = 0;
  pivotY = 0;
  magnification = 1;
  /** The centres of the bodies, and the pivots about which they turn. */
  readonly centres: Float64Array;
  readonly pivots: Float64Array;
  readonly angles: Float64Array;
  readonly speeds: Float64Array;
  /** The largest unbalance of a rotor at the values of the file; 1 where there is none. */
  readonly largestUnbalance: number;
  private readonly constants: Float64Array;
  private readonly parameters: Float64Array;
  private readonly foundationDirection: "x" | "y";

  constructor(machine: DrawnMachine) {
    const count = machine.drawing.bodies.length;
    this.machine = machine;
    this.lengths = new Float64Array(machine.drawing.length_count);
    this.constants = new Float64Array(machine.lengths.constantCount);
    this.parameters = Float64Array.from(machine.parameters, (parameter) => parameter.value);
    this.centres = new Float64Array(2 * count);
    this.pivots = new Float64Array(2 * count);
    this.angles = new Float64Array(count);
    this.speeds = new Float64Array(count);
    this.foundationDirection = machine.drawing.mounts.find((mount) => mount.is_on_foundation)?.dx ? "x" : "y";
    this.measure();
    const unbalances = machine.drawing.rotors.map((rotor) => this.length(machine.drawing.bodies[rotor.body]!.unbalance));
    this.largestUnbalance = Math.max(...unbalances.map(Math.abs), 0) || 1;
    this.update(Float64Array.from(machine.states, (state) => state.start), [], this.parameters, 1);
  }

  length(index: number): number {
    return this.lengths[index]!;
  }

  /** Place all parts. */
  update(state: ArrayLike<number>, outputs: ArrayLike<number>, parameters: ArrayLike<number>, magnification: number): void {
    this.setParameters(parameters);
    this.magnification = magnification;
    const { drawing } = this.machine;
    this.x = this.y = this.turn = this.foundationX = this.foundationY = 0;
    for (const direction of drawing.carrier) {
      const moved = magnification * (state[direction.position]! - this.length(direction.rest));
      if (direction.label === "x") this.x = moved;
      else if (direction.label === "y") this.y = moved;
      else if (direction.label === "r") this.turn = LARGEST_TILT * Math.tanh(moved / LARGEST_TILT);
      else if (this.foundationDirection === "x") this.foundationX = moved;
      else this.foundationY = moved;
    }
    drawing.bodies.forEach((body, i) => {
      this.angles[i] = state[body.angle]!;
      // Without outputs, as while a part is held, a prescribed speed is what it was.
      this.speeds[i] = outputs[i] ?? (body.velocity >= 0 ? state[body.velocity]! : this.speeds[i]!);
    });
    for (let i = 0; i < drawing.bodies.length; i++) this.placeBody(i, state);
  }

  /** The turn of the carrier that is drawn as this one. */
  turnDrawnAs(turn: number): number {
    const share = Math.max(-0.999, Math.min(0.999, turn / LARGEST_TILT));
    return (LARGEST_TILT * Math.atanh(share)) / this.magnification;
  }

  /** x of a place on the carrier. */
  placeX(a: number, b: number): number {
    return this.x + this.pivotX + Math.cos(this.turn) * (a - this.pivotX) - Math.sin(this.turn) * (b - this.pivotY);
  }

  placeY(a: number, b: number): number {
    return this.y + this.pivotY + Math.sin(this.turn) * (a - this.pivotX) + Math.cos(this.turn) * (b - this.pivotY);
  }

  axisX(rotor: number): number {
    const { x, y } = this.machine.drawing.rotors[rotor]!;
    return this.placeX(this.length(x), this.length(y));
  }

  axisY(rotor: number): number {
    const { x, y } = this.machine.drawing.rotors[rotor]!;
    return this.placeY(this.length(x), this.length(y));
  }

  /** The angle next to that of a body that points as a given one, as far as its neighbours on a track let it. */
  reachableAngle(body: number, direction: number, state: ArrayLike<number>): number {
    const { bodies, contacts } = this.machine.drawing;
    const before = state[bodies[body]!.angle]!;
    let angle = before + wrapAngle(direction - before);
    for (const contact of contacts) {
      const [first, second] = contact.bodies;
      const offset = this.length(contact.offset);
      // The gap is second - first + offset.
      if (second === body) angle = Math.max(angle, state[bodies[first]!.angle]! - offset);
    }
    for (const contact of contacts) {
      const [first, second] = contact.bodies;
      if (first === body) angle = Math.min(angle, state[bodies[second]!.angle]! + this.length(contact.offset));
    }
    return angle;
  }

  private placeBody(index: number, state: ArrayLike<number>): void {
    const body = this.machine.drawing.bodies[index]!;
    let x = this.axisX(body.rotor);
    let y = this.axisY(body.rotor);
    if (body.about !== null) {
      const phi = this.angles[body.about]!;
      const a = this.length(body.pivot[0]);
      const b = this.length(body.pivot[1]);
      x += a * Math.cos(phi) - b * Math.sin(phi);
      y += a * Math.sin(phi) + b * Math.cos(phi);
    }
    const { guide } = body;
    const arm = guide === null ? this.length(body.arm) : this.length(guide.inner_stop) + state[guide.displacement]!;
    this.pivots[2 * index] = x;
    this.pivots[2 * index + 1] = y;
    this.centres[2 * index] = x + arm * Math.cos(this.angles[index]!);
    this.centres[2 * index + 1] = y + arm * Math.sin(this.angles[index]!);
  }

  private setParameters(parameters: ArrayLike<number>): void {
    let isSame = true;
    for (let i = 0; i < this.parameters.length; i++) {
      isSame = isSame && this.parameters[i] === parameters[i];
      this.parameters[i] = parameters[i]!;
    }
    if (!isSame) this.measure();
  }

  private measure(): void {
    const { lengths, drawing } = this.machine;
    lengths.constants(this.parameters, this.constants);
    lengths.values(0, this.parameters, this.constants, this.lengths);
    this.version += 1;
    if (drawing.turning === "tilting") this.pivotY = this.length(drawing.box[1]);
  }
}

/** An angle between -pi and pi. */
export function wrapAngle(angle: number): number {
  return angle - FULL_TURN * Math.round(angle / FULL_TURN);
}
