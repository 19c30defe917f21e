/**
 * Integration of a machine by steps of order 5(4), which end where a piecewise function changes its segment (a contact closes,
 * a schedule has a point), as `wucht.numerics.flow.compiled.leg_stepper`.
 */

import { DormandPrinceStep, sizeFactor } from "./dormand_prince.ts";
import { Equations } from "./equations.ts";
import { EventSearch, NEVER, type Side } from "./event_search.ts";
import type { MotionData } from "./machine.ts";

export type Ending = "end" | "steps exhausted" | "not finite";

const TINY = 1e-300;

/** Where the samples of a run are recorded. */
interface Samples {
  readonly grid: ArrayLike<number>;
  readonly states: Float64Array;
  readonly outputs: Float64Array | undefined;
}

export class Integrator {
  readonly equations: Equations;
  readonly mostSteps: number;
  /** Steps, also those that were repeated, and changes of segments, since the start. */
  stepCount = 0;
  switchCount = 0;
  private readonly _timed: number;
  private readonly _step: DormandPrinceStep;
  private readonly _search: EventSearch;
  private readonly _point: Float64Array;
  private readonly _shown: Float64Array;
  private _sampleCount = 0;
  /** Of the next step; 0 where nothing is known of it. */
  private _nextSize = 0;

  /**
   * @param tolerance the error allowed per step: relative, of an angle in radians
   * @param mostSteps since the start
   */
  constructor(machine: MotionData, tolerance = 1e-6, mostSteps = 2_000_000) {
    this.equations = new Equations(machine);
    this.mostSteps = mostSteps;
    this._timed = machine.segmentations.findIndex((table) => table.is_time);
    this._step = new DormandPrinceStep(this.equations, machine, tolerance);
    this._search = new EventSearch(this._step, this._timed);
    this._point = new Float64Array(machine.states.length);
    this._shown = new Float64Array(machine.outputs.length);
  }

  /** The time reached. */
  get time(): number {
    return this._step.time;
  }

  /** The state reached. */
  get state(): Float64Array {
    return this._step.state;
  }

  /** Place the machine at a time in a state. */
  start(time: number, state: ArrayLike<number>) {
    this._step.time = time;
    this._step.state.set(state);
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
    const samples = { grid, states, outputs };
    this._sampleCount = 0;
    this._step.collapse();
    this._record(samples, this.time);
    const ending = this._step.hasFiniteRates ? this._advanceTo(grid[grid.length - 1]!, samples) : "not finite";
    return { ending, count: this._sampleCount };
  }

  private _advanceTo(end: number, samples: Samples): Ending {
    const step = this._step;
    let isRepeated = false;
    while (step.time < end) {
      if (this.stepCount >= this.mostSteps) return "steps exhausted";
      this.stepCount += 1;
      if (!(this._nextSize > 0)) this._nextSize = step.firstSize(end - step.time);
      const timedEnd = this._timed >= 0 ? this.equations.high[this._timed]! : Infinity;
      const limit = Math.min(end, timedEnd);
      const isLast = step.time + 1.01 * this._nextSize >= limit;
      const size = isLast ? limit - step.time : this._nextSize;
      const error = step.attempt(size, isLast ? limit : step.time + size);
      const factor = sizeFactor(error);
      if (error <= 1) {
        const next = size * (isRepeated ? Math.min(1, factor) : factor);
        // A step that a sample or a point of a schedule has cut says little about those that follow.
        this._nextSize = isLast ? Math.max(this._nextSize, next) : next;
        isRepeated = false;
        this._accept(samples, timedEnd);
      } else {
        this._nextSize = size * factor;
        isRepeated = true;
        if (this._nextSize <= 4 * Number.EPSILON * Math.abs(step.time) || this._nextSize < TINY) return "not finite";
      }
    }
    return "end";
  }

  private _begin() {
    this.equations.locate(this.time, this.state);
    this._restart();
    this._nextSize = 0;
  }

  private _restart() {
    this._step.restart();
    this._search.restart();
  }

  /**
   * Record the samples of a step and go to its end, or to the first change of a segment within it.
   *
   * @param timedEnd the next point of a schedule
   */
  private _accept(samples: Samples, timedEnd: number) {
    const { _step: step, _search: search } = this;
    if (search.isNeeded || samples.grid[this._sampleCount]! < step.endTime) step.computeDense();
    const stop = search.isNeeded ? search.locate() : NEVER;
    if (stop < NEVER) {
      this._record(samples, step.time + stop * step.size);
      step.goOnAt(stop);
      this._switch(search.index, search.side);
      this._nextSize = 0;
      return;
    }
    this._record(samples, step.endTime);
    step.goOn();
    if (step.time >= timedEnd) this._switch(this._timed, 1);
    else search.goOn();
  }

  private _switch(index: number, side: Side) {
    this.equations.cross(this.time, this.state, index, side);
    this.switchCount += 1;
    this._restart();
  }

  /** Record the samples of a step up to a time. */
  private _record({ grid, states, outputs }: Samples, lastTime: number) {
    const step = this._step;
    const n = this._point.length;
    const m = this._shown.length;
    while (this._sampleCount < grid.length && grid[this._sampleCount]! <= lastTime) {
      const at = grid[this._sampleCount]!;
      const isWithin = at < step.endTime;
      if (isWithin) step.stateAt((at - step.time) / step.size, this._point);
      const sample = isWithin ? this._point : step.endState;
      for (let i = 0; i < n; i++) states[this._sampleCount * n + i] = sample[i]!;
      if (outputs) {
        this.equations.shown(at, sample, this._shown);
        for (let i = 0; i < m; i++) outputs[this._sampleCount * m + i] = this._shown[i]!;
      }
      this._sampleCount += 1;
    }
  }
}
