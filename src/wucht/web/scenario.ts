/** A run as plain data: values, a start, and what the hand changes on the way. It is never changed: others follow from it. */

import type { LiveMachine } from "./machine.ts";

/** At a time, parameters get other values, and the machine may be placed in another state. */
export interface Change {
  readonly time: number;
  readonly parameters: readonly (readonly [index: number, value: number])[];
  readonly state: readonly number[] | null;
}

export interface Scenario {
  readonly parameters: readonly number[];
  readonly start: readonly number[];
  readonly until: number;
  /** In the order of their times. */
  readonly changes: readonly Change[];
}

/** The run of the file. */
export function originalScenario(machine: LiveMachine, until: number): Scenario {
  return {
    parameters: machine.parameters.map((parameter) => parameter.value),
    start: machine.states.map((state) => state.start),
    until,
    changes: [],
  };
}

/** The values of the parameters at a time, after the changes there. */
export function parametersAt(scenario: Scenario, time: number): number[] {
  const values = [...scenario.parameters];
  for (const change of scenario.changes) {
    if (change.time > time) break;
    for (const [index, value] of change.parameters) values[index] = value;
  }
  return values;
}

/** With other values of parameters from the start on: changes of these during the run are given up. */
export function withStartValues(scenario: Scenario, indices: readonly number[], value: number): Scenario {
  const parameters = [...scenario.parameters];
  for (const index of indices) parameters[index] = value;
  const changes = scenario.changes
    .map((change) => ({ ...change, parameters: change.parameters.filter(([index]) => !indices.includes(index)) }))
    .filter((change) => change.parameters.length > 0 || change.state !== null);
  return { ...scenario, parameters, changes };
}

/** With other values of parameters from a time on; a change of the same ones shortly before, within `merge`, is replaced. */
export function withValuesFrom(
  scenario: Scenario,
  time: number,
  indices: readonly number[],
  value: number,
  merge: number,
): Scenario {
  const last = scenario.changes.findLast((change) => change.time <= time);
  const isSame =
    last !== undefined &&
    last.state === null &&
    last.time >= time - merge &&
    last.parameters.every(([index]) => indices.includes(index));
  const change = { time: isSame ? last.time : time, parameters: indices.map((i) => [i, value] as const), state: null };
  return withChange(isSame ? { ...scenario, changes: scenario.changes.filter((c) => c !== last) } : scenario, change);
}

/** With the machine placed in another state at a time; an earlier placement at that very time is replaced. */
export function withStateAt(scenario: Scenario, time: number, state: readonly number[]): Scenario {
  const changes = scenario.changes.filter((change) => change.time !== time || change.state === null);
  return withChange({ ...scenario, changes }, { time, parameters: [], state });
}

function withChange(scenario: Scenario, change: Change): Scenario {
  const before = scenario.changes.filter((c) => c.time <= change.time);
  const after = scenario.changes.filter((c) => c.time > change.time);
  return { ...scenario, changes: [...before, change, ...after] };
}

/** Whether two scenarios are the same run. */
export function areEqual(a: Scenario, b: Scenario): boolean {
  return JSON.stringify(a) === JSON.stringify(b);
}
