/** The study file of what is shown, to be copied: that of the file, with changed values. */

import type { LiveMachine } from "./machine.ts";
import type { PageData, StartControl } from "./page_data.ts";
import type { Scenario } from "./scenario.ts";

/** TOML that `wucht run` reads. A study file has no place for changes during the run, nor for switches: they are comments. */
export function studyText(scenario: Scenario, original: Scenario, machine: LiveMachine, page: PageData): string {
  const paths = machine.parameters.map((parameter) => parameter.path);
  const switches = new Set(page.switches.map((one) => one.index));
  const isChanged = scenario.parameters.some((value, i) => !Object.is(value, original.parameters[i]) && !switches.has(i));
  // What follows from other numbers in the file would follow from the changed ones: it stays as it is here.
  const pins = new Set(isChanged ? page.derived : []);
  const settings = scenario.parameters.flatMap((value, i) =>
    (Object.is(value, original.parameters[i]) && !pins.has(i)) || switches.has(i)
      ? []
      : [`${JSON.stringify(paths[i])} = ${settingText(paths[i]!, value, machine.parameters[i]!.unit)}`],
  );
  const notes = [
    ...page.switches
      .filter((one) => scenario.parameters[one.index] === 0)
      .map((one) => `# the motor of ${one.name} was off from the start`),
    ...scenario.changes.flatMap((change) => [
      ...change.parameters.map(([i, value]) => `# from t = ${change.time} on: ${paths[i]} = ${value}`),
      ...(change.state ? [`# at t = ${change.time} the machine was moved by hand`] : []),
    ]),
  ];
  const isMoved = scenario.start.some((value, i) => !Object.is(value, original.start[i]));
  const start = isMoved ? startText(scenario.start, page) : page.text.start;
  return [
    ...notes,
    page.text.machine.trimEnd(),
    ...(settings.length > 0 ? ["", "[machine.set]", ...settings] : []),
    "",
    page.text.study.trimEnd(),
    `until = ${tomlNumber(scenario.until)}`,
    ...(start === "" ? [] : ["", start.trimEnd()]),
    "",
  ].join("\n");
}

/** Whether a study file can say what is shown: without changes during the run, all motors on. */
export function isStudy(scenario: Scenario, page: PageData): boolean {
  return scenario.changes.length === 0 && page.switches.every((one) => scenario.parameters[one.index] !== 0);
}

/** The start of all bodies and of the carrier, as files have it: angles from the body turned about, displacements from rest. */
function startText(state: readonly number[], page: PageData): string {
  const tables = new Map<string, string[]>();
  for (const control of page.start.flatMap((group) => group.controls)) {
    const [owner, key] = control.keys;
    const lines = tables.get(owner) ?? [];
    lines.push(`${key} = ${tomlNumber(startValue(control, state))}`);
    tables.set(owner, lines);
  }
  const texts = [...tables].map(([owner, lines]) => [`[study.start.${JSON.stringify(owner)}]`, ...lines].join("\n"));
  return [...texts, page.text.start_of_parts].join("\n\n");
}

/** The value of a start control in a state, in SI. */
export function startValue(control: StartControl, state: ArrayLike<number>): number {
  return state[control.index]! - control.offset - (control.head === null ? 0 : state[control.head]!);
}

/** A frequency without a unit could be turns or radians: files refuse it. */
function settingText(path: string, value: number, unit: string): string {
  return path.endsWith("frequency") && unit === "rad/s" ? `"${value} rad/s"` : tomlNumber(value);
}

/** A number with all its digits; TOML wants a point or an exponent in one that is not whole. */
function tomlNumber(value: number): string {
  const text = String(value);
  return /^-?\d+$/.test(text) ? `${text}.0` : text.replace(/^(-?\d+)e/, "$1.0e").replace("e+", "e");
}
