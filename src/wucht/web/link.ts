/** The page's state after `#` of its address: what differs from the file, in shortest decimals, which are exact. */

import type { LiveMachine } from "./machine.ts";
import type { Change, Scenario } from "./scenario.ts";

export interface Shown {
  readonly scenario: Scenario;
  readonly time: number;
  readonly stroboscopic: boolean;
}

/** A link that cannot be read: its message is a sentence. */
export class LinkError extends Error {}

type Table = Record<string, number>;

interface Stored {
  until?: number;
  parameters?: Table;
  start?: Table;
  changes?: { time: number; parameters?: Table; state?: readonly number[] }[];
  time?: number;
  stroboscopic?: boolean;
}

/** The text after `#`. */
export function linkText(shown: Shown, original: Scenario, machine: LiveMachine): string {
  const { scenario, time, stroboscopic } = shown;
  const stored: Stored = {};
  const parameters = changedValues(scenario.parameters, original.parameters, (i) => machine.parameters[i]!.path);
  const start = changedValues(scenario.start, original.start, (i) => machine.states[i]!.name);
  if (scenario.until !== original.until) stored.until = scenario.until;
  if (Object.keys(parameters).length > 0) stored.parameters = parameters;
  if (Object.keys(start).length > 0) stored.start = start;
  if (scenario.changes.length > 0) stored.changes = scenario.changes.map((change) => storedChange(change, machine));
  if (time !== 0) stored.time = time;
  if (stroboscopic) stored.stroboscopic = true;
  return encodeURIComponent(JSON.stringify(stored));
}

function storedChange(change: Change, machine: LiveMachine) {
  const parameters = Object.fromEntries(change.parameters.map(([index, value]) => [machine.parameters[index]!.path, value]));
  return {
    time: change.time,
    ...(change.parameters.length > 0 ? { parameters } : {}),
    ...(change.state ? { state: change.state } : {}),
  };
}

function changedValues(values: readonly number[], original: readonly number[], name: (index: number) => string): Table {
  return Object.fromEntries(values.flatMap((value, i) => (Object.is(value, original[i]) ? [] : [[name(i), value]])));
}

/** What a text after `#` shows. Throws `LinkError`. */
export function readLink(text: string, original: Scenario, machine: LiveMachine): Shown {
  let stored: Stored;
  try {
    stored = JSON.parse(decodeURIComponent(text)) as Stored;
  } catch {
    throw new LinkError("The link is damaged. The machine is shown with its file’s values.");
  }
  const paths = machine.parameters.map((parameter) => parameter.path);
  const names = machine.states.map((state) => state.name);
  const until = stored.until === undefined ? original.until : finiteNumber(stored.until, "until");
  if (!(until > 0))
    throw new LinkError(
      "The link cannot be used: until must be greater than 0. The machine is shown with its file’s values.",
    );
  return {
    scenario: {
      parameters: withTable(original.parameters, stored.parameters, paths),
      start: withTable(original.start, stored.start, names),
      until,
      changes: (stored.changes ?? []).map(({ time, parameters, state }) => ({
        time: finiteNumber(time, "time"),
        parameters: Object.entries(parameters ?? {}).map(
          ([path, value]) => [indexOf(paths, path), finiteNumber(value, path)] as const,
        ),
        state: state === undefined ? null : stateValues(state, names.length),
      })),
    },
    time: stored.time === undefined ? 0 : finiteNumber(stored.time, "time"),
    stroboscopic: stored.stroboscopic === true,
  };
}

function withTable(values: readonly number[], table: Table | undefined, names: readonly string[]): number[] {
  const changed = [...values];
  for (const [name, value] of Object.entries(table ?? {})) changed[indexOf(names, name)] = finiteNumber(value, name);
  return changed;
}

function indexOf(names: readonly string[], name: string): number {
  const index = names.indexOf(name);
  if (index < 0)
    throw new LinkError(`The link is of another machine: this one has no ${name}. It is shown with its file’s values.`);
  return index;
}

function finiteNumber(value: unknown, name: string): number {
  if (typeof value === "number" && Number.isFinite(value)) return value;
  throw new LinkError(`The link cannot be used: ${name} must be a number. The machine is shown with its file’s values.`);
}

function stateValues(state: readonly number[], count: number): number[] {
  if (!Array.isArray(state) || state.length !== count) {
    throw new LinkError(`The link is of another machine: this one has ${count} states. It is shown with its file’s values.`);
  }
  return state.map((value) => finiteNumber(value, "a state"));
}
