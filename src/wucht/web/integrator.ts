/**
 * Integration of a machine: Dormand and Prince's method of order 5(4) with dense output, whose steps end where a piecewise
 * function changes its segment (a contact closes, a schedule has a point), as `wucht.numerics.flow.compiled.leg_stepper`.
 *
 * E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
 * II.5 (coefficients) and II.6 (dense output).
 */

import { Equations } from "./equations.ts";
import type { MotionData } from "./machine.ts";

export type Ending = "end" | "steps exhausted" | "not finite";

type Side = 1 | -1;
type Stages = [Float64Array, Float64Array, Float64Array, Float64Array, Float64Array, Float64Array, Float64Array];

const STAGES = 7;
const LAST = 6;
const [N3, N4, N5] = [3 / 10, 4 / 5, 8 / 9];
const N2 = 1 / 5;
const A21 = 1 / 5;
const [A31, A32] = [3 / 40, 9 / 40];
const [A41, A42, A43] = [44 / 45, -56 / 15, 32 / 9];
const [A51, A52, A53, A54] = [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729];
const [A61, A62, A63, A64, A65] = [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656];
const [A71, A73, A74, A75, A76] = [35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84];
const [E1, E3, E4, E5, E6, E7] = [71 / 57600, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40];
const [D1, D3, D4] = [-12715105075 / 11282082432, 87487479700 / 32700410799, -10690763975 / 1880347072];
const [D5, D6, D7] = [701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423];
const [SAFETY, SHRINK, GROW] = [0.9, 0.2, 6];
const EXPONENT = -1 / 5;
/** Of the relative tolerance: the absolute one. */
const ABSOLUTE = 1e-2;
const TINY = 1e-300;
const EPSILON = Number.EPSILON;
/** Parts of a step, at whose ends the arguments of piecewise functions are compared with the ends of their segments. */
const PARTS = 4;
/** Parabolas, until an argument that nears the end of its segment within a part is taken to have stayed in it. */
const VERTICES = 3;
/** Of the way of an argument in a step: farther from the ends of its segment it is not looked at more closely. */
const FAR = 1 / 4;
/** A part of a step. */
const NEVER = 2;
/** Relative to the time: just after a change of segments the arguments' places are rounding noise. */
const COOL_DOWN = 1e-9;

export class Integrator {
  readonly equations: Equations;
  readonly tolerance: number;
  readonly mostSteps: number;
  time = 0;
  readonly state: Float64Array;
  /** Steps, also those that were repeated, and changes of segments, since the start. */
  stepCount = 0;
  switchCount = 0;
  private readonly _isAngle: Uint8Array;
  private readonly _timed: number;
  private readonly _k: Stages;
  private readonly _dense: readonly [Float64Array, Float64Array, Float64Array, Float64Array];
  private readonly _later: Float64Array;
  private readonly _point: Float64Array;
  private readonly _values: Float64Array[];
  private readonly _scratch: Float64Array;
  private readonly _isFar: Uint8Array;
  private readonly _shown: Float64Array;
  private _sampleCount = 0;
  private _step = 0;
  private _coolEnd = -Infinity;
  private _crossing = -1;
  private _direction: Side = 1;

  /**
   * @param tolerance the error allowed per step: relative, of an angle in radians
   * @param mostSteps since the start
   */
  constructor(machine: MotionData, tolerance = 1e-6, mostSteps = 2_000_000) {
    const n = machine.states.length;
    const m = machine.segmentations.length;
    this.equations = new Equations(machine);
    this.tolerance = tolerance;
    this.mostSteps = mostSteps;
    this.state = Float64Array.from(machine.states, (state) => state.start);
    this._isAngle = new Uint8Array(n);
    for (const i of machine.angles) this._isAngle[i] = 1;
    this._timed = machine.segmentations.findIndex((table) => table.is_time);
    this._k = Array.from({ length: STAGES }, () => new Float64Array(n)) as Stages;
    this._dense = [new Float64Array(n), new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    this._later = new Float64Array(n);
    this._point = new Float64Array(n);
    this._values = Array.from({ length: PARTS + 1 }, () => new Float64Array(m));
    this._scratch = new Float64Array(m);
    this._isFar = new Uint8Array(m);
    this._shown = new Float64Array(machine.outputs.length);
  }

  /** Place the machine at a time in a state. */
  start(time: number, state: ArrayLike<number>) {
    this.time = time;
    this.state.set(state);
    this.stepCount = 0;
    this.switchCount = 0;
    this._begin();
  }

  /** Give the machine other values of its parameters, in its order. */
  setParameters(values: ArrayLike<number>) {
    this.equations.setParameters(values);
    this._begin();
  }

  /**
   * Advance to the end of a grid.
   *
   * @param grid (N) increasing times, the first at the time reached or later
   * @param states (N n) receives the states at these times
   * @param outputs (N m) receives the outputs
   * @returns how it ended, and the number of samples up to there
   */
  advance(grid: ArrayLike<number>, states: Float64Array, outputs?: Float64Array): { ending: Ending; count: number } {
    const end = grid[grid.length - 1]!;
    this._sampleCount = 0;
    this._later.set(this.state);
    this._record(grid, states, outputs, 1, this.time, this.time);
    if (!isFinite(this._sum(this._k[0]))) return { ending: "not finite", count: this._sampleCount };
    let shortened = false;
    while (this.time < end) {
      if (this.stepCount >= this.mostSteps) return { ending: "steps exhausted", count: this._sampleCount };
      this.stepCount += 1;
      if (!(this._step > 0)) this._step = this._firstStep(end - this.time);
      const timedEnd = this._timed >= 0 ? this.equations.high[this._timed]! : Infinity;
      const limit = Math.min(end, timedEnd);
      const isLast = this.time + 1.01 * this._step >= limit;
      const step = isLast ? limit - this.time : this._step;
      const laterTime = isLast ? limit : this.time + step;
      const error = this._attempt(step, laterTime);
      if (error <= 1) {
        const factor = error === 0 ? GROW : Math.min(GROW, Math.max(SHRINK, SAFETY * error ** EXPONENT));
        const next = step * (shortened ? Math.min(1, factor) : factor);
        // A step that a sample or a point of a schedule has cut says little about those that follow.
        this._step = isLast ? Math.max(this._step, next) : next;
        shortened = false;
        this._accept(grid, states, outputs, step, laterTime, timedEnd);
      } else {
        this._step = step * (error > 1 ? Math.max(SHRINK, SAFETY * error ** EXPONENT) : SHRINK);
        shortened = true;
        if (this._step <= 4 * EPSILON * Math.abs(this.time) || this._step < TINY) {
          return { ending: "not finite", count: this._sampleCount };
        }
      }
    }
    return { ending: "end", count: this._sampleCount };
  }

  private _begin() {
    this.equations.locate(this.time, this.state);
    this._restart();
    this._step = 0;
  }

  /** Compute what the first step after a change needs. */
  private _restart() {
    this._coolEnd = this.time + COOL_DOWN * Math.max(1, Math.abs(this.time));
    this.equations.rates(this.time, this.state, this._k[0]);
    if (this.equations.segmentationCount > 0) this.equations.places(this.time, this.state, this._values[0]!);
  }

  private _sum(values: Float64Array) {
    let total = 0;
    for (let i = 0; i < values.length; i++) total += 0 * values[i]!;
    return total;
  }

  private _allowedError(i: number, value: number, later: number) {
    if (this._isAngle[i] === 1) return this.tolerance;
    return this.tolerance * (ABSOLUTE + Math.max(Math.abs(value), Math.abs(later)));
  }

  /** A first step size, from the rates at the beginning and after a small step: section II.4. */
  private _firstStep(span: number) {
    const { state, _k: k, _point: point, _later: later } = this;
    const n = state.length;
    let size = 0;
    let speed = 0;
    let change = 0;
    for (let i = 0; i < n; i++) {
      const scale = this._allowedError(i, state[i]!, state[i]!);
      size += (state[i]! / scale) ** 2;
      speed += (k[0][i]! / scale) ** 2;
    }
    size = Math.sqrt(size / n);
    speed = Math.sqrt(speed / n);
    const small = Math.min(size < 1e-5 || speed < 1e-5 ? 1e-6 : (0.01 * size) / speed, span);
    for (let i = 0; i < n; i++) point[i] = state[i]! + small * k[0][i]!;
    this.equations.rates(this.time + small, point, later);
    for (let i = 0; i < n; i++) change += ((later[i]! - k[0][i]!) / this._allowedError(i, state[i]!, state[i]!)) ** 2;
    const largest = Math.max(speed, Math.sqrt(change / n) / small);
    const step = largest <= 1e-15 ? Math.max(1e-6, small * 1e-3) : (0.01 / largest) ** -EXPONENT;
    return Math.min(100 * small, step > 0 ? step : small, span); // not a number where the rates are not finite
  }

  /** Attempt a step; return its error, at most 1 where it is accepted. */
  private _attempt(step: number, laterTime: number) {
    const { state, time, equations, _point: point, _later: later } = this;
    const [k1, k2, k3, k4, k5, k6, k7] = this._k;
    const n = state.length;
    for (let i = 0; i < n; i++) point[i] = state[i]! + step * A21 * k1[i]!;
    equations.rates(time + N2 * step, point, k2);
    for (let i = 0; i < n; i++) point[i] = state[i]! + step * (A31 * k1[i]! + A32 * k2[i]!);
    equations.rates(time + N3 * step, point, k3);
    for (let i = 0; i < n; i++) point[i] = state[i]! + step * (A41 * k1[i]! + A42 * k2[i]! + A43 * k3[i]!);
    equations.rates(time + N4 * step, point, k4);
    for (let i = 0; i < n; i++) point[i] = state[i]! + step * (A51 * k1[i]! + A52 * k2[i]! + A53 * k3[i]! + A54 * k4[i]!);
    equations.rates(time + N5 * step, point, k5);
    for (let i = 0; i < n; i++) {
      point[i] = state[i]! + step * (A61 * k1[i]! + A62 * k2[i]! + A63 * k3[i]! + A64 * k4[i]! + A65 * k5[i]!);
    }
    equations.rates(laterTime, point, k6);
    for (let i = 0; i < n; i++) {
      later[i] = state[i]! + step * (A71 * k1[i]! + A73 * k3[i]! + A74 * k4[i]! + A75 * k5[i]! + A76 * k6[i]!);
    }
    equations.rates(laterTime, later, k7);
    let total = 0;
    for (let i = 0; i < n; i++) {
      const error = step * (E1 * k1[i]! + E3 * k3[i]! + E4 * k4[i]! + E5 * k5[i]! + E6 * k6[i]! + E7 * k7[i]!);
      const share = error / this._allowedError(i, state[i]!, later[i]!);
      total += share * share;
    }
    return Math.sqrt(total / n);
  }

  /**
   * Record the samples of a step and go to its end, or to the first change of a segment within it.
   *
   * @param timedEnd the next point of a schedule
   */
  private _accept(
    grid: ArrayLike<number>,
    states: Float64Array,
    outputs: Float64Array | undefined,
    step: number,
    laterTime: number,
    timedEnd: number,
  ) {
    const hasPlaces = this.equations.segmentationCount > (this._timed >= 0 ? 1 : 0);
    let stop = NEVER;
    if (hasPlaces || grid[this._sampleCount]! < laterTime) this._computeDense(step);
    if (hasPlaces) stop = this._locateSwitch(step, laterTime);
    const lastTime = stop < NEVER ? this.time + stop * step : laterTime;
    this._record(grid, states, outputs, step, laterTime, lastTime);
    if (stop < NEVER) this._densePoint(stop, this._later);
    this.state.set(this._later);
    this.time = lastTime;
    if (stop < NEVER) {
      this._switch(this._crossing, this._direction);
      this._step = 0;
    } else if (laterTime >= timedEnd) {
      this._switch(this._timed, 1);
    } else {
      const first = this._k[0];
      this._k[0] = this._k[LAST];
      this._k[LAST] = first;
      this._values[0]!.set(this._values[PARTS]!);
    }
  }

  private _switch(index: number, direction: Side) {
    this.equations.cross(this.time, this.state, index, direction);
    this.switchCount += 1;
    this._restart();
  }

  /** The coefficients of the dense output of a step: section II.6. */
  private _computeDense(step: number) {
    const { state, _later: later } = this;
    const [k1, , k3, k4, k5, k6, k7] = this._k;
    const [d1, d2, d3, d4] = this._dense;
    for (let i = 0; i < state.length; i++) {
      const gain = later[i]! - state[i]!;
      const bend = step * k1[i]! - gain;
      d1[i] = gain;
      d2[i] = bend;
      d3[i] = gain - step * k7[i]! - bend;
      d4[i] = step * (D1 * k1[i]! + D3 * k3[i]! + D4 * k4[i]! + D5 * k5[i]! + D6 * k6[i]! + D7 * k7[i]!);
    }
  }

  /** The state at a part x of the step. */
  private _densePoint(x: number, point: Float64Array) {
    const { state } = this;
    const [d1, d2, d3, d4] = this._dense;
    const y = 1 - x;
    for (let i = 0; i < state.length; i++) point[i] = state[i]! + x * (d1[i]! + y * (d2[i]! + x * (d3[i]! + y * d4[i]!)));
  }

  /** Record the samples of a step up to a time. */
  private _record(
    grid: ArrayLike<number>,
    states: Float64Array,
    outputs: Float64Array | undefined,
    step: number,
    laterTime: number,
    lastTime: number,
  ) {
    const n = this.state.length;
    const m = this._shown.length;
    while (this._sampleCount < grid.length && grid[this._sampleCount]! <= lastTime) {
      const at = grid[this._sampleCount]!;
      const isWithin = at < laterTime;
      if (isWithin) this._densePoint((at - this.time) / step, this._point);
      const sample = isWithin ? this._point : this._later;
      for (let i = 0; i < n; i++) states[this._sampleCount * n + i] = sample[i]!;
      if (outputs) {
        this.equations.shown(at, sample, this._shown);
        for (let i = 0; i < m; i++) outputs[this._sampleCount * m + i] = this._shown[i]!;
      }
      this._sampleCount += 1;
    }
  }

  /** How far an argument is beyond the end of its segment. */
  private _beyond(index: number, side: Side, value: number) {
    return side > 0 ? value - this.equations.high[index]! : this.equations.low[index]! - value;
  }

  /** The same at a part x of the step. */
  private _beyondAt(index: number, side: Side, step: number, x: number) {
    this._densePoint(x, this._point);
    this.equations.places(this.time + x * step, this._point, this._scratch);
    return this._beyond(index, side, this._scratch[index]!);
  }

  /** Return the part of a step at which the first argument leaves its segment, or never: `_crossing` in `_direction`. */
  private _locateSwitch(step: number, laterTime: number) {
    for (let part = 1; part < PARTS; part++) {
      this._densePoint(part / PARTS, this._point);
      this.equations.places(this.time + (part / PARTS) * step, this._point, this._values[part]!);
    }
    this.equations.places(laterTime, this._later, this._values[PARTS]!);
    let near = 0;
    for (let index = 0; index < this.equations.segmentationCount; index++) {
      this._isFar[index] = this._isWithin(index) ? 1 : 0;
      near += 1 - this._isFar[index]!;
    }
    if (near === 0) return NEVER;
    const cool = (this._coolEnd - this.time) / step;
    let stop = NEVER;
    for (let part = 0; part < PARTS && stop === NEVER; part++) {
      for (let index = 0; index < this.equations.segmentationCount; index++) {
        if (index === this._timed || this._isFar[index] === 1) continue;
        for (let side: Side = 1; side >= -1; side = (side - 2) as Side) {
          const x = this._crossingIn(part, index, side, step, cool);
          if (x < stop) {
            stop = x;
            this._crossing = index;
            this._direction = side;
          }
        }
      }
    }
    return stop;
  }

  /**
   * Whether an argument is so far within its segment, compared with its way in the step, that no parabola through three of its
   * values comes near an end: its vertex lies at most an eighth of the way beyond them.
   */
  private _isWithin(index: number) {
    let [lowest, highest] = [Infinity, -Infinity];
    for (let part = 0; part <= PARTS; part++) {
      const value = this._values[part]![index]!;
      if (value < lowest) lowest = value;
      if (value > highest) highest = value;
    }
    const room = FAR * (highest - lowest);
    return lowest - room > this.equations.low[index]! && highest + room < this.equations.high[index]!;
  }

  /**
   * Return the place in a part of the step at which an argument passes an end of its segment, or never.
   *
   * @param cool the part of the step up to which the argument counts as in its segment
   */
  private _crossingIn(part: number, index: number, side: Side, step: number, cool: number) {
    const high = (part + 1) / PARTS;
    if (high <= cool) return NEVER;
    const begin = part / PARTS;
    const low = Math.max(begin, cool);
    const partValue = this._beyond(index, side, this._values[part]![index]!);
    const lowValue = low > begin ? this._beyondAt(index, side, step, low) : partValue;
    if (lowValue > 0) return low;
    const highValue = this._beyond(index, side, this._values[part + 1]![index]!);
    if (highValue > 0) return this._root(index, side, step, low, lowValue, high, highValue);
    if (lowValue === -Infinity || low > begin) return NEVER;
    const top = this._top(part, index, side, step);
    return top < high ? this._root(index, side, step, low, lowValue, top, this._beyondAt(index, side, step, top)) : NEVER;
  }

  /** Return the place at which an argument passes the end of its segment, to rounding: secants within a bracket. */
  private _root(index: number, side: Side, step: number, low: number, lowValue: number, high: number, highValue: number) {
    if (lowValue === 0) return low;
    const smallest = 2 * EPSILON * Math.max(1, Math.abs(this.time) / step);
    let stay = 0;
    for (let count = 0; count < 200 && high - low > smallest; count++) {
      let x = (low * highValue - high * lowValue) / (highValue - lowValue);
      if (count % 4 === 3 || !(low < x && x < high)) x = 0.5 * (low + high);
      x = Math.min(Math.max(x, low + 0.5 * smallest), high - 0.5 * smallest);
      const value = this._beyondAt(index, side, step, x);
      if (value === 0) return x;
      if (value > 0) {
        [high, highValue] = [x, value];
        if (stay === 1) lowValue *= 0.5; // the other end has stayed: the next secant shall pass it
        stay = 1;
      } else {
        [low, lowValue] = [x, value];
        if (stay === -1) highValue *= 0.5;
        stay = -1;
      }
    }
    return high;
  }

  /**
   * Return a place in a part of the step at which an argument that is in its segment at both ends is not, or never: it is
   * sought at the vertices of parabolas.
   */
  private _top(part: number, index: number, side: Side, step: number) {
    const neighbour = part > 0 ? part - 1 : part + 2;
    const [low, high] = [part / PARTS, (part + 1) / PARTS];
    const lowValue = this._beyond(index, side, this._values[part]![index]!);
    const highValue = this._beyond(index, side, this._values[part + 1]![index]!);
    let third = neighbour / PARTS;
    let thirdValue = this._beyond(index, side, this._values[neighbour]![index]!);
    for (let count = 0; count < VERTICES; count++) {
      const slope = (highValue - lowValue) / (high - low);
      const curvature = ((thirdValue - lowValue) / (third - low) - slope) / (third - high);
      if (curvature >= 0) return NEVER; // it is bent away from the end
      const x = 0.5 * (low + high) - (0.5 * slope) / curvature;
      const vertexValue = lowValue + (x - low) * (slope + curvature * (x - high));
      if (!(low < x && x < high) || vertexValue < 0.1 * lowValue) return NEVER;
      const value = this._beyondAt(index, side, step, x);
      if (value > 0) return x;
      [third, thirdValue] = [x, value];
    }
    return NEVER;
  }
}
