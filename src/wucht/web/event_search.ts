/** Search for the first event in a step: an argument of a piecewise function passes an end of its segment. */

import type { DormandPrinceStep } from "./dormand_prince.ts";
import type { Equations } from "./equations.ts";

/** The end of a segment. */
export type Side = 1 | -1;

/** In place of a part of a step: no event in it. */
export const NEVER = 2;

/** Parts of a step, at whose ends the arguments of piecewise functions are compared with the ends of their segments. */
const PARTS = 4;
/** Parabolas, until an argument that nears the end of its segment within a part is taken to have stayed in it. */
const VERTICES = 3;
/** Share of an argument's range in a step: one farther than this from the ends of its segment stays in it. */
const FAR = 1 / 4;
/** Relative to the time: just after a change of segments the arguments' places are rounding noise. */
const COOL_DOWN = 1e-9;
const EPSILON = Number.EPSILON;

export class EventSearch {
  /** The latest event. */
  index = -1;
  side: Side = 1;
  /** Whether an argument depends on the state. */
  readonly isNeeded: boolean;
  private readonly _equations: Equations;
  private readonly _step: DormandPrinceStep;
  private readonly _timed: number;
  /** Arguments at the ends of the parts. */
  private readonly _values: readonly Float64Array[];
  private readonly _scratch: Float64Array;
  private readonly _point: Float64Array;
  private readonly _isFar: Uint8Array;
  private _coolEnd = -Infinity;

  /**
   * @param step whose dense output is searched
   * @param timed the function of time alone, at whose breakpoints steps end; -1 without one
   */
  constructor(step: DormandPrinceStep, timed: number) {
    const count = step.equations.segmentationCount;
    this.isNeeded = count > (timed >= 0 ? 1 : 0);
    this._equations = step.equations;
    this._step = step;
    this._timed = timed;
    this._values = Array.from({ length: PARTS + 1 }, () => new Float64Array(count));
    this._scratch = new Float64Array(count);
    this._point = new Float64Array(step.state.length);
    this._isFar = new Uint8Array(count);
  }

  /** Begin anew where segments or the state have changed. */
  restart() {
    const { time, state } = this._step;
    this._coolEnd = time + COOL_DOWN * Math.max(1, Math.abs(time));
    if (this.isNeeded) this._equations.places(time, state, this._values[0]!);
  }

  /** Keep the arguments at the end of the step, where the next one begins. */
  goOn() {
    this._values[0]!.set(this._values[PARTS]!);
  }

  /** Return the part of the step at which the first argument leaves its segment, or never; `index` and `side` say which. */
  locate() {
    const { time, size, endTime, endState } = this._step;
    for (let part = 1; part < PARTS; part++) {
      this._step.stateAt(part / PARTS, this._point);
      this._equations.places(time + (part / PARTS) * size, this._point, this._values[part]!);
    }
    this._equations.places(endTime, endState, this._values[PARTS]!);
    let near = 0;
    for (let index = 0; index < this._equations.segmentationCount; index++) {
      this._isFar[index] = this._isWithin(index) ? 1 : 0;
      near += 1 - this._isFar[index]!;
    }
    if (near === 0) return NEVER;
    const cool = (this._coolEnd - time) / size;
    let stop = NEVER;
    for (let part = 0; part < PARTS && stop === NEVER; part++) {
      for (let index = 0; index < this._equations.segmentationCount; index++) {
        if (index === this._timed || this._isFar[index] === 1) continue;
        for (let side: Side = 1; side >= -1; side = (side - 2) as Side) {
          const x = this._crossingIn(part, index, side, cool);
          if (x < stop) {
            stop = x;
            this.index = index;
            this.side = side;
          }
        }
      }
    }
    return stop;
  }

  /** How far an argument is beyond the end of its segment. */
  private _beyond(index: number, side: Side, value: number) {
    return side > 0 ? value - this._equations.high[index]! : this._equations.low[index]! - value;
  }

  /** The same at a part x of the step. */
  private _beyondAt(index: number, side: Side, x: number) {
    this._step.stateAt(x, this._point);
    this._equations.places(this._step.time + x * this._step.size, this._point, this._scratch);
    return this._beyond(index, side, this._scratch[index]!);
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
    return lowest - room > this._equations.low[index]! && highest + room < this._equations.high[index]!;
  }

  /**
   * Return the place in a part of the step at which an argument passes an end of its segment, or never.
   *
   * @param cool the part of the step up to which the argument counts as in its segment
   */
  private _crossingIn(part: number, index: number, side: Side, cool: number) {
    const high = (part + 1) / PARTS;
    if (high <= cool) return NEVER;
    const begin = part / PARTS;
    const low = Math.max(begin, cool);
    const partValue = this._beyond(index, side, this._values[part]![index]!);
    const lowValue = low > begin ? this._beyondAt(index, side, low) : partValue;
    if (lowValue > 0) return low;
    const highValue = this._beyond(index, side, this._values[part + 1]![index]!);
    if (highValue > 0) return this._root(index, side, low, lowValue, high, highValue);
    if (lowValue === -Infinity || low > begin) return NEVER;
    const top = this._top(part, index, side);
    return top < high ? this._root(index, side, low, lowValue, top, this._beyondAt(index, side, top)) : NEVER;
  }

  /** Return the place at which an argument passes the end of its segment, to rounding: secants within a bracket. */
  private _root(index: number, side: Side, low: number, lowValue: number, high: number, highValue: number) {
    if (lowValue === 0) return low;
    const smallest = 2 * EPSILON * Math.max(1, Math.abs(this._step.time) / this._step.size);
    let stay = 0;
    for (let count = 0; count < 200 && high - low > smallest; count++) {
      let x = (low * highValue - high * lowValue) / (highValue - lowValue);
      if (count % 4 === 3 || !(low < x && x < high)) x = 0.5 * (low + high);
      x = Math.min(Math.max(x, low + 0.5 * smallest), high - 0.5 * smallest);
      const value = this._beyondAt(index, side, x);
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
  private _top(part: number, index: number, side: Side) {
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
      const value = this._beyondAt(index, side, x);
      if (value > 0) return x;
      [third, thirdValue] = [x, value];
    }
    return NEVER;
  }
}
