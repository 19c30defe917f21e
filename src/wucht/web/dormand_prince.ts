/**
 * A step of Dormand and Prince's method of order 5(4): the state at its end, its error, and its dense output.
 *
 * E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
 * II.5 (coefficients) and II.6 (dense output).
 */

import type { Equations } from "./equations.ts";
import type { MotionData } from "./machine.ts";

type Stages = [Float64Array, Float64Array, Float64Array, Float64Array, Float64Array, Float64Array, Float64Array];
type DenseOutput = readonly [Float64Array, Float64Array, Float64Array, Float64Array];

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

/** The size of the next step over that of one with this error, which may be no number. */
export function sizeFactor(error: number) {
  return Number.isNaN(error) ? SHRINK : Math.min(GROW, Math.max(SHRINK, SAFETY * error ** EXPONENT));
}

export class DormandPrinceStep {
  readonly equations: Equations;
  readonly tolerance: number;
  /** At the beginning. */
  time = 0;
  readonly state: Float64Array;
  size = 0;
  endTime = 0;
  readonly endState: Float64Array;
  private readonly _isAngle: Uint8Array;
  private readonly _k: Stages;
  private readonly _dense: DenseOutput;
  private readonly _point: Float64Array;

  constructor(equations: Equations, { states, angles }: MotionData, tolerance: number) {
    const n = states.length;
    this.equations = equations;
    this.tolerance = tolerance;
    this.state = Float64Array.from(states, (state) => state.start);
    this.endState = new Float64Array(n);
    this._isAngle = new Uint8Array(n);
    for (const i of angles) this._isAngle[i] = 1;
    this._k = Array.from({ length: STAGES }, () => new Float64Array(n)) as Stages;
    this._dense = [new Float64Array(n), new Float64Array(n), new Float64Array(n), new Float64Array(n)];
    this._point = new Float64Array(n);
  }

  /** Compute the rates at the beginning, after a change of the time, the state or the equations. */
  restart() {
    this.equations.rates(this.time, this.state, this._k[0]);
  }

  get hasFiniteRates(): boolean {
    return this._k[0].every(Number.isFinite);
  }

  /** End at the beginning. */
  collapse() {
    this.size = 0;
    this.endTime = this.time;
    this.endState.set(this.state);
  }

  /** A size for the first of the steps in a span, from the rates at the beginning and after a small step: section II.4. */
  firstSize(span: number) {
    const { state, _k: k, _point: point, endState: later } = this;
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

  /** Compute the state at the end; return the error, at most 1 where the step is accepted. */
  attempt(size: number, endTime: number) {
    this.size = size;
    this.endTime = endTime;
    const { state, time, equations, _point: point, endState: later } = this;
    const [k1, k2, k3, k4, k5, k6, k7] = this._k;
    const n = state.length;
    for (let i = 0; i < n; i++) point[i] = state[i]! + size * A21 * k1[i]!;
    equations.rates(time + N2 * size, point, k2);
    for (let i = 0; i < n; i++) point[i] = state[i]! + size * (A31 * k1[i]! + A32 * k2[i]!);
    equations.rates(time + N3 * size, point, k3);
    for (let i = 0; i < n; i++) point[i] = state[i]! + size * (A41 * k1[i]! + A42 * k2[i]! + A43 * k3[i]!);
    equations.rates(time + N4 * size, point, k4);
    for (let i = 0; i < n; i++) point[i] = state[i]! + size * (A51 * k1[i]! + A52 * k2[i]! + A53 * k3[i]! + A54 * k4[i]!);
    equations.rates(time + N5 * size, point, k5);
    for (let i = 0; i < n; i++) {
      point[i] = state[i]! + size * (A61 * k1[i]! + A62 * k2[i]! + A63 * k3[i]! + A64 * k4[i]! + A65 * k5[i]!);
    }
    equations.rates(endTime, point, k6);
    for (let i = 0; i < n; i++) {
      later[i] = state[i]! + size * (A71 * k1[i]! + A73 * k3[i]! + A74 * k4[i]! + A75 * k5[i]! + A76 * k6[i]!);
    }
    equations.rates(endTime, later, k7);
    let total = 0;
    for (let i = 0; i < n; i++) {
      const error = size * (E1 * k1[i]! + E3 * k3[i]! + E4 * k4[i]! + E5 * k5[i]! + E6 * k6[i]! + E7 * k7[i]!);
      const share = error / this._allowedError(i, state[i]!, later[i]!);
      total += share * share;
    }
    return Math.sqrt(total / n);
  }

  /** Compute the coefficients of the dense output: section II.6. */
  computeDense() {
    const { state, size, endState: later } = this;
    const [k1, , k3, k4, k5, k6, k7] = this._k;
    const [d1, d2, d3, d4] = this._dense;
    for (let i = 0; i < state.length; i++) {
      const gain = later[i]! - state[i]!;
      const bend = size * k1[i]! - gain;
      d1[i] = gain;
      d2[i] = bend;
      d3[i] = gain - size * k7[i]! - bend;
      d4[i] = size * (D1 * k1[i]! + D3 * k3[i]! + D4 * k4[i]! + D5 * k5[i]! + D6 * k6[i]! + D7 * k7[i]!);
    }
  }

  /** The state at a part x of the step, by the dense output. */
  stateAt(x: number, point: Float64Array) {
    const { state } = this;
    const [d1, d2, d3, d4] = this._dense;
    const y = 1 - x;
    for (let i = 0; i < state.length; i++) point[i] = state[i]! + x * (d1[i]! + y * (d2[i]! + x * (d3[i]! + y * d4[i]!)));
  }

  /** Begin the next step at the end of this one, whose last rates are its first. */
  goOn() {
    this.state.set(this.endState);
    this.time = this.endTime;
    const first = this._k[0];
    this._k[0] = this._k[LAST];
    this._k[LAST] = first;
  }

  /** Begin the next step at a part x of this one, with a `restart`. */
  goOnAt(x: number) {
    this.stateAt(x, this.endState);
    this.endTime = this.time + x * this.size;
    this.goOn();
  }

  private _allowedError(i: number, value: number, later: number) {
    if (this._isAngle[i] === 1) return this.tolerance;
    return this.tolerance * (ABSOLUTE + Math.max(Math.abs(value), Math.abs(later)));
  }
}
