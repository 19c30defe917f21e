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

const INSTEAD = "The machine is shown with its file’s values.";
const OTHER = "The link is of another machine: this one has";

type Table = Record<string, number>;

/** What a link is written from. */
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

/** What a text after `#` shows: it may be anything. Throws `LinkError`. */
export function readLink(text: string, original: Scenario, machine: LiveMachine): Shown {
  let content: unknown;
  try {
    content = JSON.parse(decodeURIComponent(text));
  } catch {
    throw new LinkError(`The link is damaged. ${INSTEAD}`);
  }
  const stored = asTable(content, "its content");
  const until = stored.until === undefined ? original.until : asNumber(stored.until, "until");
  if (!(until > 0)) throw unusable("until", "greater than 0");
  return {
    scenario: {
      parameters: withTable(original.parameters, stored.parameters, machine.parameters.map((one) => one.path), "parameters"),
      start: withTable(original.start, stored.start, machine.states.map((one) => one.name), "start"),
      until,
      changes: stored.changes === undefined ? [] : readChanges(stored.changes, machine),
    },
    time: stored.time === undefined ? 0 : asNumber(stored.time, "time"),
    stroboscopic: stored.stroboscopic !== undefined && asBoolean(stored.stroboscopic, "stroboscopic"),
  };
}

function readChanges(content: unknown, machine: LiveMachine): Change[] {
  const paths = machine.parameters.map((parameter) => parameter.path);
  const changes = asList(content, "changes").map((one): Change => {
    const { time, parameters, state } = asTable(one, "a change");
    return {
      time: asNumber(time, "the time of a change"),
      parameters: parameters === undefined ? [] : entries(parameters, paths, "parameters of a change"),
      state: state === undefined ? null : asState(state, machine.states.length),
    };
  });
  if (changes.some((change, i) => change.time < (i === 0 ? 0 : changes[i - 1]!.time)))
    throw unusable("changes", "in the order of their times, from 0 on");
  return changes;
}

function withTable(values: readonly number[], table: unknown, names: readonly string[], name: string): number[] {
  const changed = [...values];
  if (table !== undefined) for (const [index, value] of entries(table, names, name)) changed[index] = value;
  return changed;
}

/** The numbers of a table, each with the index of its name. */
function entries(content: unknown, names: readonly string[], name: string): (readonly [number, number])[] {
  return Object.entries(asTable(content, name)).map(([key, value]) => {
    const index = names.indexOf(key);
    if (index < 0) throw new LinkError(`${OTHER} no ${key}. ${INSTEAD}`);
    return [index, asNumber(value, key)] as const;
  });
}

function asState(content: unknown, count: number): number[] {
  const state = asList(content, "the state of a change");
  if (state.length !== count)
    throw new LinkError(`${OTHER} ${count} states. ${INSTEAD}`);
  return state.map((value) => asNumber(value, "a state"));
}

function asTable(content: unknown, name: string): Readonly<Record<string, unknown>> {
  if (typeof content === "object" && content !== null && !Array.isArray(content)) return content as Record<string, unknown>;
  throw unusable(name, "a table");
}

function asList(content: unknown, name: string): readonly unknown[] {
  if (Array.isArray(content)) return content;
  throw unusable(name, "a list");
}

function asNumber(content: unknown, name: string): number {
  if (typeof content === "number" && Number.isFinite(content)) return content;
  throw unusable(name, "a number");
}

function asBoolean(content: unknown, name: string): boolean {
  if (typeof content === "boolean") return content;
  throw unusable(name, "true or false");
}

function unusable(name: string, expected: string): LinkError {
  return new LinkError(`The link cannot be used: ${name} must be ${expected}. ${INSTEAD}`);
}
