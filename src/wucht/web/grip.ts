/** Grabbing: the part of a machine under a finger, and the state with the part where the finger moves. */

import type { CarrierDirection } from "./drawing_data.ts";
import { type Pose, wrapAngle } from "./pose.ts";
import { drawnRadius } from "./rotors.ts";
import type { Pen } from "./shapes.ts";

/** index: among the machine's bodies that turn; 0 of the carrier. */
export interface Part {
  readonly kind: "carrier" | "body";
  readonly index: number;
}

/** Pixels: how near a finger meets a body. */
const REACH = 14;
/** Of a rotor's radius, and pixels: around its axis the carrier is grabbed. */
const [HUB, SMALLEST_HUB] = [0.2, 10];

export class Grip {
  private readonly pose: Pose;
  private readonly pen: Pen;
  private readonly free: readonly CarrierDirection[];
  /** Where the carrier was grabbed, from the place that its centre has, and in which direction from its pivot. */
  private grabX = 0;
  private grabY = 0;
  private grabTurn = 0;

  constructor(pose: Pose, pen: Pen) {
    this.pose = pose;
    this.pen = pen;
    this.free = pose.machine.drawing.carrier.filter(({ label, velocity }) => velocity >= 0 && label !== "foundation");
  }

  /** See `MachineDrawing`. */
  partAt(x: number, y: number, isRotating: boolean): Part | null {
    const { bodies, rotors } = this.pose.machine.drawing;
    const canMove = this.free.length > 0 && !isRotating;
    let nearest = -1;
    let least = Infinity;
    bodies.forEach((body, i) => {
      if (body.about === null || (isRotating && body.rotor > 0)) return;
      const distance = this.pixelsFrom(this.pose.centres[2 * i]!, this.pose.centres[2 * i + 1]!, x, y);
      if (distance <= Math.max(drawnRadius(this.pose, body, this.pen.scale), REACH) && distance < least) {
        least = distance;
        nearest = i;
      }
    });
    if (nearest >= 0) return { kind: "body", index: nearest };
    for (let i = isRotating ? 0 : rotors.length - 1; i >= 0; i--) {
      const rotor = rotors[i]!;
      const radius = this.pose.length(rotor.radius) * this.pen.scale;
      const distance = this.pixelsFrom(this.pose.axisX(i), this.pose.axisY(i), x, y);
      if (distance > radius) continue;
      const isHub = distance <= Math.max(HUB * radius, SMALLEST_HUB) && canMove;
      return isHub ? this.grabCarrier(x, y) : { kind: "body", index: rotor.body };
    }
    return canMove && this.isInCarrier(x, y) ? this.grabCarrier(x, y) : null;
  }

  /** See `MachineDrawing`. */
  stateWithPartAt(part: Part, x: number, y: number, state: ArrayLike<number>): Float64Array {
    const changed = Float64Array.from(state);
    if (part.kind === "carrier") this.moveCarrier(x, y, changed);
    else this.moveBody(part.index, x, y, changed);
    return changed;
  }

  private pixelsFrom(worldX: number, worldY: number, x: number, y: number): number {
    return Math.hypot(this.pen.pixelX(worldX, worldY) - x, this.pen.pixelY(worldX, worldY) - y);
  }

  private isInCarrier(x: number, y: number): boolean {
    const { pose } = this;
    const [dx, dy] = [this.pen.worldX(x, y) - pose.x - pose.pivotX, this.pen.worldY(x, y) - pose.y - pose.pivotY];
    const a = Math.cos(pose.turn) * dx + Math.sin(pose.turn) * dy + pose.pivotX;
    const b = -Math.sin(pose.turn) * dx + Math.cos(pose.turn) * dy + pose.pivotY;
    const [left, bottom, right, top] = this.pose.machine.drawing.box;
    return a >= pose.length(left) && a <= pose.length(right) && b >= pose.length(bottom) && b <= pose.length(top);
  }

  private grabCarrier(x: number, y: number): Part {
    const { pose } = this;
    this.grabX = this.pen.worldX(x, y) - pose.x;
    this.grabY = this.pen.worldY(x, y) - pose.y;
    this.grabTurn = Math.atan2(this.grabY - pose.pivotY, this.grabX - pose.pivotX) - pose.turn;
    return { kind: "carrier", index: 0 };
  }

  private moveCarrier(x: number, y: number, state: Float64Array): void {
    const { pose, pen, free } = this;
    const turnsOnly = free.every(({ label }) => label === "r");
    const [worldX, worldY] = [pen.worldX(x, y), pen.worldY(x, y)];
    for (const { label, position, velocity, rest } of free) {
      state[velocity] = 0;
      if (label === "x") state[position] = pose.length(rest) + (worldX - this.grabX) / pose.magnification;
      else if (label === "y") state[position] = pose.length(rest) + (worldY - this.grabY) / pose.magnification;
      else if (turnsOnly) {
        const turn = wrapAngle(Math.atan2(worldY - pose.pivotY, worldX - pose.pivotX) - this.grabTurn);
        state[position] = pose.length(rest) + pose.turnDrawnAs(turn);
      }
    }
  }

  private moveBody(index: number, x: number, y: number, state: Float64Array): void {
    const { pose, pen } = this;
    const { bodies, rotors } = this.pose.machine.drawing;
    const body = bodies[index]!;
    const [dx, dy] = [pen.worldX(x, y) - pose.pivots[2 * index]!, pen.worldY(x, y) - pose.pivots[2 * index + 1]!];
    if (dx === 0 && dy === 0) return;
    state[body.angle] = pose.reachableAngle(index, Math.atan2(dy, dx), state);
    if (body.velocity < 0) return;
    const rotor = rotors[body.rotor]!.body;
    const rotorVelocity = bodies[rotor]!.velocity;
    state[body.velocity] = body.about === null ? 0 : rotorVelocity < 0 ? pose.speeds[rotor]! : state[rotorVelocity]!;
  }
}
