/** Torques on the shafts of a machine over the speed, and the speeds at which they balance: 002 (3.51). */

import type { AvailableHills, HillMachine } from "./drawing_data.ts";
import { Equations } from "./equations.ts";
import { VibrationTorque } from "./vibration_torque.ts";

/** A steady speed, the torque of the drive there, and whether the resistance grows faster with the speed than that torque. */
export interface WorkingPoint {
  readonly speed: number;
  readonly torque: number;
  readonly stable: boolean;
}

/** A rotor that turns as another one within this share of its speed is in phase with it. */
const SAME_SPEED = 0.02;
const BISECTIONS = 60;
/**
 * rad/s: a drive whose torque exceeds the load up to there reaches no speed; the first step towards it, and the factor of the
 * next.
 */
const [FASTEST, FIRST, GROWTH] = [1e9, 1e-3, 1.5];
/** Of the speed without vibration: the range of speeds. */
const BEYOND = 1.2;

export class TorqueCurves {
  readonly hills: AvailableHills;
  private readonly equations: Equations;
  private readonly vibration: VibrationTorque;
  private readonly shown: Float64Array;
  private readonly speed = new Float64Array(1);
  private readonly angles: Float64Array;
  /** Whether the vibration of each body acts on the rotor steadily. */
  private readonly counts: Uint8Array;
  private readonly senses: Float64Array;
  private readonly members: Uint8Array;
  private time = 0;
  private rotor = -1;
  private rotorSenses: number[] = [];
  private rangeOfSpeed: [number, number] | null = null;
  private readonly parameters: Float64Array;
  private rotorSense = 1;

  constructor(machine: HillMachine, hills: AvailableHills) {
    const outputs = Array.from({ length: hills.output_count }, () => ({ name: "", unit: "", long_name: "" }));
    const states = [{ name: "speed", unit: hills.units.speed, long_name: "speed", start: 0 }];
    const { segmentations, rates, places, shown } = hills;
    const count = hills.bodies.length;
    this.hills = hills;
    // The speed is a state at rest: its piecewise functions are located as those of the motion.
    const parameters = machine.parameters.map(({ path, value }) => ({ path, value, unit: "", symbol: "", long_name: "" }));
    this.equations = new Equations({
      title: "", time_unit: "", angles: [], contacts: [], outputs, states, parameters, segmentations, rates, places, shown,
    });
    this.shown = new Float64Array(hills.output_count);
    this.parameters = new Float64Array(machine.parameters.length);
    this.vibration = new VibrationTorque(hills.directions, count);
    this.angles = new Float64Array(count);
    this.counts = new Uint8Array(count).fill(1);
    this.senses = new Float64Array(count).fill(1);
    this.members = new Uint8Array(count);
    const start = Float64Array.from(machine.states, (state) => state.start);
    this.set(Float64Array.from(machine.parameters, ({ value }) => value), 0, start, 0);
  }

  /**
   * Take values of the parameters, the time for those that schedules change, and the phases of the bodies in a state.
   *
   * rotor: on whose shaft the torques act. Of rotors that turn at another speed the vibration is left out: their phase to this
   * one goes round, so that the mean of their torque on it is zero. Machines at standstill are taken to turn at one speed.
   */
  set(parameters: ArrayLike<number>, time: number, state: ArrayLike<number>, rotor: number): void {
    const { bodies, rotors } = this.hills;
    if (this.isChanged(parameters, time, rotor)) {
      this.equations.setParameters(parameters);
      this.time = time;
      this.rotor = rotor;
      this.rangeOfSpeed = null;
      this.rotorSenses = rotors.map(({ is_driven: isDriven, sense }, i) => (isDriven ? this.sense(i) : sense));
    }
    const senses = this.rotorSenses;
    const speed = Math.abs(this.speedOf(rotor, state));
    bodies.forEach((body, i) => {
      const difference = Math.abs(Math.abs(this.speedOf(body.rotor, state)) - speed);
      this.angles[i] = state[body.angle]!;
      this.senses[i] = senses[body.rotor]!;
      this.members[i] = body.rotor === rotor ? 1 : 0;
      this.counts[i] = body.rotor === rotor || !(difference > SAME_SPEED * speed) ? 1 : 0;
    });
    this.rotorSense = senses[rotor]!;
    this.evaluate(0);
    this.vibration.set(this.shown.subarray(2 * rotors.length), this.angles, this.senses, this.counts, this.members);
  }

  /**
   * Torque of the drive, positive in the direction of positive speeds; of load and bearings, and of the vibration, against it.
   *
   * results: (3).
   */
  torques(speed: number, results: Float64Array): void {
    this.evaluate(speed);
    results[0] = this.shown[2 * this.rotor]!;
    results[1] = this.shown[2 * this.rotor + 1]!;
    results[2] = this.rotorSense * this.vibration.torque(this.rotorSense * speed);
  }

  /** The speed that the drive reaches from standstill without vibration; null where it reaches none. */
  freeSpeed(): number | null {
    const { rotor } = this;
    const start = this.net(rotor, 0);
    if (start === 0) return null;
    let [low, high] = [0, Math.sign(start) * FIRST];
    while (this.net(rotor, high) * start > 0) {
      [low, high] = [high, GROWTH * high];
      if (!(Math.abs(high) < FASTEST)) return null;
    }
    for (let i = 0; i < BISECTIONS; i++) {
      const middle = (low + high) / 2;
      if (this.net(rotor, middle) * start > 0) low = middle;
      else high = middle;
    }
    return (low + high) / 2;
  }

  /** Lowest and highest speed of a rotor in operation: to 1.2 times its speed without vibration, or beyond the resonances. */
  range(): readonly [number, number] {
    this.rangeOfSpeed ??= this.rangeInOperation();
    return this.rangeOfSpeed;
  }

  private rangeInOperation(): [number, number] {
    const free = this.freeSpeed();
    const { reach, largest_speed: largest } = this.hills;
    const sense = free === null ? this.sense(this.rotor) : Math.sign(free);
    const end = free !== null && Math.abs(free) <= (reach ?? Infinity) ? BEYOND * free : sense * largest;
    return [Math.min(0, end), Math.max(0, end)];
  }

  /** The steady speeds within a grid (N), each with its stability. torques: (3 N), as of `torques`, at the grid's speeds. */
  workingPoints(count: number, speeds: ArrayLike<number>, torques: ArrayLike<number>): WorkingPoint[] {
    const results = new Float64Array(3);
    const points: WorkingPoint[] = [];
    const surplus = (speed: number): number => {
      this.torques(speed, results);
      return results[0]! - results[1]! - results[2]!;
    };
    const at = (i: number): number => torques[3 * i]! - torques[3 * i + 1]! - torques[3 * i + 2]!;
    for (let i = 0; i + 1 < count; i++) {
      const [before, after] = [at(i), at(i + 1)];
      if (!(before * after < 0 || (after === 0 && before !== 0))) continue;
      let [low, high] = [speeds[i]!, speeds[i + 1]!];
      for (let k = 0; k < BISECTIONS && high - low > 1e-14 * Math.abs(high); k++) {
        const middle = (low + high) / 2;
        if (surplus(middle) * before > 0) low = middle;
        else high = middle;
      }
      const speed = after === 0 ? speeds[i + 1]! : (low + high) / 2;
      surplus(speed);
      // At the set speed of a controlled drive its torque jumps: what opposes it does not.
      points.push({ speed, torque: results[1]! + results[2]!, stable: before > 0 });
    }
    return points;
  }

  /** Take the parameters; whether they, or what depends on the time, or the rotor are others than before. */
  private isChanged(parameters: ArrayLike<number>, time: number, rotor: number): boolean {
    const isTimed = this.hills.segmentations.some((table) => table.is_time);
    let changed = rotor !== this.rotor || (isTimed && time !== this.time);
    for (let i = 0; i < this.parameters.length; i++) {
      changed = changed || this.parameters[i] !== parameters[i];
      this.parameters[i] = parameters[i]!;
    }
    return changed;
  }

  private sense(rotor: number): number {
    const start = this.net(rotor, 0);
    return start === 0 ? this.hills.rotors[rotor]!.sense : Math.sign(start);
  }

  private net(rotor: number, speed: number): number {
    this.evaluate(speed);
    return this.shown[2 * rotor]! - this.shown[2 * rotor + 1]!;
  }

  private evaluate(speed: number): void {
    this.speed[0] = speed;
    if (this.equations.segmentationCount > 0) this.equations.locate(this.time, this.speed);
    this.equations.shown(this.time, this.speed, this.shown);
  }

  /** The speed of a rotor, NaN where it is prescribed. */
  private speedOf(rotor: number, state: ArrayLike<number>): number {
    const { velocity } = this.hills.bodies.find((body) => body.rotor === rotor && body.is_rotor)!;
    return velocity < 0 ? NaN : state[velocity]!;
  }
}
