// @ts-check
/**
 * The equations of a machine with numbers for its parameters, and the segments of its piecewise functions that are in use.
 *
 * As in `wucht.numerics.flow.segments`, a piecewise function is one polynomial at a time, whose origin and coefficients are
 * parameters; they change where its argument reaches an end of its segment.
 *
 * @typedef {import("./machine.mjs").LiveMachine} LiveMachine
 * @typedef {import("./machine.mjs").Code} Code
 */

const EPSILON = Number.EPSILON;
/** Of the largest number that occurs: a nearer argument is on its breakpoint. */
const ROUNDING = 1000 * EPSILON;
/** Relative to the time: so much later arguments on a breakpoint are evaluated, to know to which side they move; the second from rest. */
const LOOKAHEAD = [1e-9, 1e-5];

/** Number of breakpoints up to a value, by bisection. @param {readonly number[]} breakpoints @param {number} value */
function segmentOf(breakpoints, value) {
  let low = 0;
  let high = breakpoints.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (breakpoints[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

export class Equations {
  /** @param {LiveMachine} machine */
  constructor(machine) {
    const count = machine.segmentations.length;
    this.machine = machine;
    /** Number of states. */
    this.size = machine.states.length;
    /** Number of segmentations. */
    this.segmentationCount = count;
    /** The segments in use. */
    this.segments = new Int32Array(count);
    /** Their ends, infinite where there is none. */
    this.low = new Float64Array(count);
    this.high = new Float64Array(count);
    /** Where the coefficients of each segmentation are among the parameters. */
    this._first = new Int32Array(count);
    let place = machine.parameters.length;
    machine.segmentations.forEach((table, i) => {
      this._first[i] = place;
      place += table.rows[0].length;
    });
    this._parameters = new Float64Array(place);
    machine.parameters.forEach((parameter, i) => {
      this._parameters[i] = parameter.value;
    });
    this._constants = [machine.rates, machine.places, machine.shown].map((code) => new Float64Array(code.constantCount));
    this._arguments = new Float64Array(count);
    this._ahead = new Float64Array(count);
    this._later = new Float64Array(count);
    this._rate = new Float64Array(this.size);
    this._point = new Float64Array(this.size);
    for (let i = 0; i < count; i++) this._enter(i, 0);
    this._refresh();
  }

  /** Give the parameters of the machine other values, in its order. @param {ArrayLike<number>} values */
  setParameters(values) {
    if (values.length !== this.machine.parameters.length) {
      throw new RangeError(`${values.length} values for ${this.machine.parameters.length} parameters`);
    }
    this._parameters.set(values);
    this._refresh();
  }

  /** @param {number} time @param {Float64Array} state @param {Float64Array} results (n) */
  rates(time, state, results) {
    this.machine.rates.values(time, state, this._constants[0], results);
  }

  /** The arguments of the segmentations. @param {number} time @param {Float64Array} state @param {Float64Array} results */
  places(time, state, results) {
    this.machine.places.values(time, state, this._constants[1], results);
  }

  /** The outputs. @param {number} time @param {Float64Array} state @param {Float64Array} results */
  shown(time, state, results) {
    this.machine.shown.values(time, state, this._constants[2], results);
  }

  /** Find the segments at the start of a run. @param {number} time @param {Float64Array} state */
  locate(time, state) {
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

  /**
   * Change the segment of an argument that has reached an end of it, and those of others that lie on a breakpoint too.
   *
   * @param {number} time @param {Float64Array} state @param {number} index @param {1 | -1} direction
   */
  cross(time, state, index, direction) {
    this._enter(index, this.segments[index] + direction);
    this._refresh();
    this._lookAhead(time, state);
    this._enterLocated(time, state, index);
  }

  /** @param {number} time @param {Float64Array} state @param {number} except an index that is in its segment */
  _enterLocated(time, state, except) {
    let changed = false;
    for (let i = 0; i < this.segmentationCount; i++) {
      const segment = i === except ? this.segments[i] : this._locateOne(i, time, state);
      changed = changed || segment !== this.segments[i];
      this._enter(i, segment);
    }
    if (changed) this._refresh();
  }

  /** @param {number} i @param {number} time @param {Float64Array} state */
  _locateOne(i, time, state) {
    const { breakpoints, indices, scale } = this.machine.segmentations[i];
    const value = this._arguments[i];
    let size = scale;
    for (const j of indices) size = Math.max(size, Math.abs(j === this.size ? time : state[j]));
    const segment = segmentOf(breakpoints, value);
    const below = segment > 0 ? value - breakpoints[segment - 1] : Infinity;
    const above = segment < breakpoints.length ? breakpoints[segment] - value : Infinity;
    if (Math.min(below, above) > ROUNDING * size || this._ahead[i] === value) return segment;
    const first = below <= above ? segment - 1 : segment; // the segment that ends at the nearest breakpoint
    return this._ahead[i] > value ? first + 1 : first;
  }

  /** Compute the arguments now, and a little later. @param {number} time @param {Float64Array} state */
  _lookAhead(time, state) {
    this.places(time, state, this._arguments);
    this._ahead.set(this._arguments);
    for (const share of LOOKAHEAD) {
      const step = share * Math.max(1, Math.abs(time));
      this.rates(time, state, this._rate);
      for (let i = 0; i < this.size; i++) this._point[i] = state[i] + (step / 2) * this._rate[i];
      this.rates(time + step / 2, this._point, this._rate);
      for (let i = 0; i < this.size; i++) this._point[i] = state[i] + step * this._rate[i];
      this.places(time + step, this._point, this._later);
      for (let i = 0; i < this.segmentationCount; i++) {
        if (this._ahead[i] === this._arguments[i]) this._ahead[i] = this._later[i];
      }
    }
  }

  /** @param {number} i @param {number} segment */
  _enter(i, segment) {
    const { breakpoints, rows } = this.machine.segmentations[i];
    this.segments[i] = segment;
    this.low[i] = segment > 0 ? breakpoints[segment - 1] : -Infinity;
    this.high[i] = segment < breakpoints.length ? breakpoints[segment] : Infinity;
    this._parameters.set(rows[segment], this._first[i]);
  }

  _refresh() {
    this.machine.rates.constants(this._parameters, this._constants[0]);
    this.machine.places.constants(this._parameters, this._constants[1]);
    this.machine.shown.constants(this._parameters, this._constants[2]);
  }
}
