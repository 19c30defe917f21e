/** Torques over the range of speeds, at more of them where the curves bend. */

import type { TorqueCurves } from "./torque_curves.ts";

/** Speeds at equal distances; how often these are halved where a curve bends, by which share of its height; most speeds. */
const [POINTS, HALVINGS, BEND, MOST] = [100, 7, 2e-3, 1500];
/** Times a present speed outside of the usual range: there the curves end. */
const BEYOND = 1.1;

export class TorqueGrid {
  readonly range = new Float64Array(2);
  count = 0;
  readonly speeds = new Float64Array(MOST);
  /** Of drive, load and vibration, in turn. */
  readonly torques = new Float64Array(3 * MOST);
  private readonly torque = new Float64Array(3);
  /** The largest torque of the drive. */
  private height = 0;

  /** present: the speed at which the rotor turns, which the range includes. */
  evaluate(curves: TorqueCurves, present = 0): void {
    const range = curves.range();
    const low = present < range[0]! ? BEYOND * present : range[0]!;
    const high = present > range[1]! ? BEYOND * present : range[1]!;
    this.range[0] = low;
    this.range[1] = high;
    this.count = 0;
    this.height = 0;
    this.add(curves, low);
    for (let i = 1; i < POINTS; i++) this.refine(curves, low + ((high - low) * i) / (POINTS - 1), HALVINGS);
  }

  /** The torque of load and vibration at a speed of the grid. */
  opposingTorque(index: number): number {
    return this.torques[3 * index + 1]! + this.torques[3 * index + 2]!;
  }

  /** Add the speeds up to one, from the last one on. */
  private refine(curves: TorqueCurves, speed: number, halvings: number): void {
    const last = this.count - 1;
    curves.torques(speed, this.torque);
    const drive = (this.torques[3 * last]! + this.torque[0]!) / 2;
    const opposing = (this.opposingTorque(last) + this.torque[1]! + this.torque[2]!) / 2;
    const middle = (this.speeds[last]! + speed) / 2;
    curves.torques(middle, this.torque);
    const bend = Math.abs(this.torque[1]! + this.torque[2]! - opposing);
    const driveBend = Math.abs(this.torque[0]! - drive);
    if (Math.max(bend, driveBend) > BEND * this.height && halvings > 0 && this.count < MOST - POINTS) {
      this.refine(curves, middle, halvings - 1);
      this.refine(curves, speed, halvings - 1);
    } else this.add(curves, speed);
  }

  private add(curves: TorqueCurves, speed: number): void {
    curves.torques(speed, this.torque);
    this.speeds[this.count] = speed;
    this.torques.set(this.torque, 3 * this.count);
    this.count += 1;
    this.height = Math.max(this.height, Math.abs(this.torque[0]!));
  }
}
