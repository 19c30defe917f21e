/**
 * The equations of a machine with numbers for its parameters, and the segments of its piecewise functions that are in use.
 *
 * As in `wucht.numerics.flow.segments`, a piecewise function is one polynomial at a time, whose origin and coefficients are
 * parameters; they change where its argument reaches an end of its segment.
 */

import type { MotionData } from "./machine.ts";

const EPSILON = Number.EPSILON;
/** Of the largest number that occurs: a nearer argument is on its breakpoint. */
const ROUNDING = 1000 * EPSILON;
/**
 * Relative to the time: so much later arguments on a breakpoint are evaluated, to know to which side they move; the second from
 * rest.
 */
const LOOKAHEAD = [1e-9, 1e-5];

/** Number of breakpoints up to a value, by bisection. */
function segmentOf(breakpoints: readonly number[], value: number) {
  let low = 0;
  let high = breakpoints.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (breakpoints[middle]! <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

export class Equations {
  readonly machine: MotionData;
  /** Number of states. */
  readonly size: number;
  /** Number of segmentations. */
  readonly segmentationCount: number;
  /** The segments in use. */
  readonly segments: Int32Array;
  /** Their ends, infinite where there is none. */
  readonly low: Float64Array;
  readonly high: Float64Array;
  /** Where the coefficients of each segmentation are among the parameters. */
  private readonly _first: Int32Array;
  private readonly _parameters: Float64Array;
  private readonly _constants: { readonly rates: Float64Array; readonly places: Float64Array; readonly shown: Float64Array };
  private readonly _arguments: Float64Array;
  private readonly _ahead: Float64Array;
  private readonly _later: Float64Array;
  private readonly _rate: Float64Array;
  private readonly _point: Float64Array;

  constructor(machine: MotionData) {
    const count = machine.segmentations.length;
    this.machine = machine;
    this.size = machine.states.length;
    this.segmentationCount = count;
    this.segments = new Int32Array(count);
    this.low = new Float64Array(count);
    this.high = new Float64Array(count);
    this._first = new Int32Array(count);
    let place = machine.parameters.length;
    machine.segmentations.forEach((table, i) => {
      this._first[i] = place;
      place += table.rows[0]!.length;
    });
    this._parameters = new Float64Array(place);
    machine.parameters.forEach((parameter, i) => {
      this._parameters[i] = parameter.value;
    });
    this._constants = {
      rates: new Float64Array(machine.rates.constantCount),
      places: new Float64Array(machine.places.constantCount),
      shown: new Float64Array(machine.shown.constantCount),
    };
    this._arguments = new Float64Array(count);
    this._ahead = new Float64Array(count);
    this._later = new Float64Array(count);
    this._rate = new Float64Array(this.size);
    this._point = new Float64Array(this.size);
    for (let i = 0; i < count; i++) this._enter(i, 0);
    this._refresh();
  }

  /** Give the parameters of the machine other values, in its order. */
  setParameters(values: ArrayLike<number>) {
    if (values.length !== this.machine.parameters.length) {
      throw new RangeError(`${values.length} values for ${this.machine.parameters.length} parameters`);
    }
    this._parameters.set(values);
    this._refresh();
  }

  /** The rates of the states (n). */
  rates(time: number, state: Float64Array, results: Float64Array) {
    this.machine.rates.values(time, state, this._constants.rates, results);
  }

  /** The arguments of the segmentations. */
  places(time: number, state: Float64Array, results: Float64Array) {
    this.machine.places.values(time, state, this._constants.places, results);
  }

  /** The outputs. */
  shown(time: number, state: Float64Array, results: Float64Array) {
    this.machine.shown.values(time, state, this._constants.shown, results);
  }

  /** Find the segments at the start of a run. */
  locate(time: number, state: Float64Array) {
    // An argument may depend on the segment of another one: that is known after it.
    for (let pass = 0; pass < this.segmentationCount; pass++) {
      this.places(time, state, this._arguments);
      this._ahead.set(this._arguments);
      this._enterLocated(time, state, -1);
    }
    for (let pass = 0; pass <= this.segmentationCount && this.segmentationCount > 0; pass++) {
      this._lookAhead(time, state);
      this._enterLocated(time, state, -1);
    }
  }

  /** Change the segment of an argument that has reached an end of it, and those of others that lie on a breakpoint too. */
  cross(time: number, state: Float64Array, index: number, direction: 1 | -1) {
    this._enter(index, this.segments[index]! + direction);
    this._refresh();
    this._lookAhead(time, state);
    this._enterLocated(time, state, index);
  }

  /** except: an index that is in its segment. */
  private _enterLocated(time: number, state: Float64Array, except: number) {
    let changed = false;
    for (let i = 0; i < this.segmentationCount; i++) {
      const segment = i === except ? this.segments[i]! : this._locateOne(i, time, state);
      changed = changed || segment !== this.segments[i];
      this._enter(i, segment);
    }
    if (changed) this._refresh();
  }

  private _locateOne(i: number, time: number, state: Float64Array) {
    const { breakpoints, indices, scale } = this.machine.segmentations[i]!;
    const value = this._arguments[i]!;
    let size = scale;
    for (const j of indices) size = Math.max(size, Math.abs(j === this.size ? time : state[j]!));
    const segment = segmentOf(breakpoints, value);
    const below = segment > 0 ? value - breakpoints[segment - 1]! : Infinity;
    const above = segment < breakpoints.length ? breakpoints[segment]! - value : Infinity;
    if (Math.min(below, above) > ROUNDING * size || this._ahead[i] === value) return segment;
    const first = below <= above ? segment - 1 : segment; // the segment that ends at the nearest breakpoint
    return this._ahead[i]! > value ? first + 1 : first;
  }

  /** Compute the arguments now, and a little later. */
  private _lookAhead(time: number, state: Float64Array) {
    this.places(time, state, this._arguments);
    this._ahead.set(this._arguments);
    for (const share of LOOKAHEAD) {
      const step = share * Math.max(1, Math.abs(time));
      this.rates(time, state, this._rate);
      for (let i = 0; i < this.size; i++) this._point[i] = state[i]! + (step / 2) * this._rate[i]!;
      this.rates(time + step / 2, this._point, this._rate);
      for (let i = 0; i < this.size; i++) this._point[i] = state[i]! + step * this._rate[i]!;
      this.places(time + step, this._point, this._later);
      for (let i = 0; i < this.segmentationCount; i++) {
        if (this._ahead[i] === this._arguments[i]) this._ahead[i] = this._later[i]!;
      }
    }
  }

  private _enter(i: number, segment: number) {
    const { breakpoints, rows } = this.machine.segmentations[i]!;
    this.segments[i] = segment;
    this.low[i] = segment > 0 ? breakpoints[segment - 1]! : -Infinity;
    this.high[i] = segment < breakpoints.length ? breakpoints[segment]! : Infinity;
    this._parameters.set(rows[segment]!, this._first[i]);
  }

  private _refresh() {
    this.machine.rates.constants(this._parameters, this._constants.rates);
    this.machine.places.constants(this._parameters, this._constants.places);
    this.machine.shown.constants(this._parameters, this._constants.shown);
  }
}
