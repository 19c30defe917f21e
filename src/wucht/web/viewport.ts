/** What part of a machine a canvas shows, at which scale, and how far the carrier's motion is magnified. */

import { hasDeck } from "./deck.ts";
import { roundDown } from "./numbers.ts";
import type { Pose } from "./pose.ts";
import type { Pen } from "./shapes.ts";
import { FOUNDATION, GROUND, SPRING } from "./supports.ts";

/** Pixels: the border, and the band below for the scale. */
export const BORDER = 14;
const BAND = 26;
/** Of the larger side of the carrier: the largest motion that is drawn, of a deck at its ends. */
const [ROOM, DECK_ROOM] = [0.1, 0.2];
/** Of the smaller side of the canvas: the rotor in the stroboscopic view. */
const CLOSE = 0.36;

/** Left, bottom, right and top. */
type Sides = readonly [number, number, number, number];

export class Viewport {
  /** The larger side of the carrier, in m. */
  unit = 1;
  private readonly pose: Pose;
  private version = -1;
  /** Of all that is drawn, in m. */
  private extent: Sides = [0, 0, 1, 1];

  constructor(pose: Pose) {
    this.pose = pose;
  }

  /**
   * The magnification (1, 2, 5, 10, ...) that makes a motion visible.
   *
   * @param largestAmplitude in m, in rad of a carrier that only turns
   */
  suggestedMagnification(largestAmplitude: number): number {
    this.measure();
    const { to_scale: toScale, carrier, turning } = this.pose.machine.drawing;
    const isAngle = turning !== "no" && carrier.length === 1;
    const room = hasDeck(this.pose.machine.drawing) ? DECK_ROOM : ROOM;
    const suggestion = largestAmplitude > 0 ? roundDown((isAngle ? ROOM : room * this.unit) / largestAmplitude) : 1;
    return toScale || isAngle ? Math.max(1, suggestion) : suggestion;
  }

  /** Show the whole machine on a canvas of a size in pixels. */
  showWhole(pen: Pen, width: number, height: number): void {
    this.measure();
    const [left, bottom, right, top] = this.extent;
    const [scaleX, scaleY] = [(width - 2 * BORDER) / (right - left), (height - 2 * BORDER - BAND) / (top - bottom)];
    const scale = Math.max(1e-9, Math.min(scaleX, scaleY));
    pen.setView((left + right) / 2, (bottom + top) / 2, 0, scale, width / 2, (height - BAND) / 2);
  }

  /** Show the main rotor, and turn with it. */
  showRotor(pen: Pen, width: number, height: number): void {
    this.measure();
    const { pose } = this;
    const rotor = pose.machine.drawing.rotors[0]!;
    const scale = (CLOSE * Math.min(width, height)) / pose.length(rotor.radius);
    pen.setView(pose.axisX(0), pose.axisY(0), pose.angles[rotor.body]!, scale, width / 2, height / 2);
  }

  /** The extent of the drawing, when parameters have changed. */
  private measure(): void {
    const { pose } = this;
    if (this.version === pose.version) return;
    this.version = pose.version;
    const { box, mounts, carrier, attachments, turning } = pose.machine.drawing;
    const [boxLeft, boxBottom, boxRight, boxTop] = box.map((side) => pose.length(side)) as [...Sides];
    this.unit = Math.max(boxRight - boxLeft, boxTop - boxBottom);
    const length = SPRING * this.unit;
    let [left, bottom, right, top] = [boxLeft, boxBottom, boxRight, boxTop];
    for (const mount of mounts) {
      const whole = mount.is_on_foundation ? 2 * length + FOUNDATION * this.unit : length;
      const [x, y] = [pose.length(mount.x) + mount.dx * whole, pose.length(mount.y) + mount.dy * whole];
      const [halfX, halfY] = [GROUND * this.unit * Math.abs(mount.dy), GROUND * this.unit * Math.abs(mount.dx)];
      [left, right] = [Math.min(left, x - halfX), Math.max(right, x + halfX)];
      [bottom, top] = [Math.min(bottom, y - halfY), Math.max(top, y + halfY)];
    }
    if (attachments.some(({ angle }) => angle !== null)) {
      [left, right] = [Math.min(left, boxLeft - 1.4 * length), Math.max(right, boxRight + 1.4 * length)];
      bottom = Math.min(bottom, boxBottom - length);
    }
    if (turning !== "no" && mounts.length === 0) bottom -= 0.15 * this.unit;
    if (carrier.length === 0) [bottom, top] = [bottom - 0.06 * this.unit, top + 0.02 * this.unit];
    const share = hasDeck(pose.machine.drawing) ? DECK_ROOM : carrier.length > 0 ? 0.5 * ROOM : 0;
    const room = share * this.unit;
    this.extent = [left - room, bottom, right + room, top + room];
  }
}
