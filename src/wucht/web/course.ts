/** The course of a scenario: the states and outputs of a run at many times, and the state at any time between. */

import { Integrator, type Ending } from "./integrator.ts";
import type { LiveMachine } from "./machine.ts";
import { parametersAt, type Scenario } from "./scenario.ts";

const SAMPLES_PER_TURN = 16;
const FEWEST = 1000;
/** Of an interval between two changes. */
const LEAST = 2;
/** Steps from one change to the next: where a run needs more, the page would stand still. */
const MOST_STEPS = 3_000_000;
/** Samples after which a computation can be left. */
const PART = 250;

/** tolerance: of a step. most: number of samples. */
export interface Accuracy {
  readonly tolerance: number;
  readonly most: number;
}

export const FINE: Accuracy = { tolerance: 1e-6, most: 12000 };
/** For the picture while a slider moves; at rest all curves and numbers are those of the fine run. */
export const PREVIEW: Accuracy = { tolerance: 1e-4, most: 4000 };

export interface Course {
  readonly scenario: Scenario;
  readonly isPreview: boolean;
  /** (N) Times. At a change there are two samples, before and after it. */
  readonly time: Float64Array;
  /** (N n) and (N m). */
  readonly states: Float64Array;
  readonly outputs: Float64Array;
  readonly ending: Ending;
}

/** Compute the course of a scenario. turn: the time of the fastest motion expected. */
export function computeCourse(machine: LiveMachine, scenario: Scenario, turn: number, accuracy = FINE): Course {
  const parts = courseInParts(machine, scenario, turn, accuracy);
  for (;;) {
    const part = parts.next();
    if (part.done) return part.value;
  }
}

/** The same in parts, between which something else may be done, or the rest be left. */
export function* courseInParts(
  machine: LiveMachine,
  scenario: Scenario,
  turn: number,
  accuracy: Accuracy,
): Generator<undefined, Course, undefined> {
  const [n, m] = [machine.states.length, machine.outputs.length];
  const grids = pieces(scenario, turn, accuracy.most);
  const total = grids.reduce((sum, grid) => sum + grid.length, 0);
  const time = new Float64Array(total);
  const states = new Float64Array(total * n);
  const outputs = new Float64Array(total * m);
  const integrator = new Integrator(machine, accuracy.tolerance, MOST_STEPS);
  let state: ArrayLike<number> = scenario.start;
  let place = 0;
  let ending: Ending = "end";
  for (const grid of grids) {
    const begin = grid[0]!;
    const values = parametersAt(scenario, begin);
    for (const change of scenario.changes) if (change.time === begin && change.state !== null) state = change.state;
    integrator.equations.setParameters(values);
    integrator.start(begin, state);
    for (let first = 0; first < grid.length && ending === "end"; first += PART) {
      const part = grid.subarray(first, first + PART);
      const result = integrator.advance(part, states.subarray(place * n), outputs.subarray(place * m));
      time.set(part.subarray(0, result.count), place);
      place += result.count;
      ending = result.ending;
      yield undefined;
    }
    if (ending !== "end") break;
    state = integrator.state.slice();
  }
  return {
    scenario,
    isPreview: accuracy === PREVIEW,
    time: time.subarray(0, place),
    states: states.subarray(0, place * n),
    outputs: outputs.subarray(0, place * m),
    ending,
  };
}

/** The times of the samples, from each change to the next. */
function pieces(scenario: Scenario, turn: number, most: number): Float64Array[] {
  const { until } = scenario;
  const times = [0, ...new Set(scenario.changes.map((change) => change.time)), until].filter((t) => t >= 0 && t <= until);
  const ends = [...new Set(times)].sort((a, b) => a - b);
  const count = Math.min(most, Math.max(FEWEST, Math.ceil((until / turn) * SAMPLES_PER_TURN)));
  return ends.slice(1).map((end, k) => {
    const begin = ends[k]!;
    const parts = Math.max(LEAST, Math.round((count * (end - begin)) / until));
    return Float64Array.from({ length: parts + 1 }, (_, i) => (i === parts ? end : begin + ((end - begin) * i) / parts));
  });
}

/** The last sample up to a time. */
export function sampleAt(course: Course, time: number): number {
  let low = 0;
  let high = course.time.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (course.time[middle]! <= time) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** States and outputs at any time: integrated from the sample before it. */
export class Instant {
  readonly state: Float64Array;
  readonly outputs: Float64Array;
  parameters: number[] = [];
  private readonly _integrator: Integrator;

  constructor(machine: LiveMachine) {
    this.state = new Float64Array(machine.states.length);
    this.outputs = new Float64Array(machine.outputs.length);
    this._integrator = new Integrator(machine, FINE.tolerance);
  }

  /** Go to a time of a course. */
  move(course: Course, time: number) {
    const sample = sampleAt(course, time);
    const [n, m] = [this.state.length, this.outputs.length];
    const begin = course.time[sample]!;
    this.parameters = parametersAt(course.scenario, time);
    this.state.set(course.states.subarray(sample * n, (sample + 1) * n));
    this.outputs.set(course.outputs.subarray(sample * m, (sample + 1) * m));
    if (time <= begin || sample + 1 >= course.time.length) return;
    this._integrator.equations.setParameters(this.parameters);
    this._integrator.start(begin, this.state);
    this._integrator.advance([time], this.state, this.outputs);
  }
}

/** A sentence for a run that did not reach its end. */
export function sentenceOf(course: Course, unit: string): string {
  const reached = `${Number((course.time[course.time.length - 1] ?? 0).toPrecision(4))} ${unit}`.trim();
  if (course.ending === "not finite") {
    return `The motion cannot be computed beyond ${reached}: forces or speeds grow without bound with these values.`;
  }
  if (course.ending === "steps exhausted") {
    return `The motion is computed up to ${reached} only: with these values it is too fast for this page.`;
  }
  return "";
}
