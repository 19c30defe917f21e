/** Measured values from a CSV file, to be laid over the curves: columns by name, with their units in the heading. */

import { readNumber } from "./numbers.ts";
import type { Panel } from "./page_data.ts";

export interface MeasuredCurve {
  /** The panel over which it is laid. */
  readonly panel: number;
  readonly name: string;
  /** In the machine's time, and in SI. */
  readonly time: Float64Array;
  readonly values: Float64Array;
}

/** A file that cannot be read: its message is a sentence. */
export class FileError extends Error {}

const TURN = 2 * Math.PI;
const SIZES: Readonly<Record<string, number>> = {
  s: 1,
  ms: 1e-3,
  min: 60,
  "rad/s": 1,
  rpm: TURN / 60,
  "1/min": TURN / 60,
  "u/min": TURN / 60,
  hz: TURN,
  m: 1,
  mm: 1e-3,
  um: 1e-6,
  µm: 1e-6,
  rad: 1,
  deg: TURN / 360,
  "°": TURN / 360,
  w: 1,
  kw: 1e3,
  "%": 0.01,
  "": 1,
};
const UNITS = "s, ms, min, rad/s, rpm, Hz, m, mm, µm, rad, °, W, kW, %";
const MOST_POINTS = 20_000;

interface Column {
  readonly name: string;
  readonly size: number;
  readonly values: (number | null)[];
}

/** Read the measured curves of a CSV file. Throws `FileError`. */
export function readMeasured(text: string, panels: readonly Panel[]): MeasuredCurve[] {
  const columns = readColumns(text);
  const times = columns.find((column) => /^(time|zeit|t)\b/i.test(column.name));
  if (times === undefined) {
    throw new FileError(
      `no column is named "time"; given: ${columns.map((column) => `"${column.name}"`).join(", ")}.`,
    );
  }
  const curves: MeasuredCurve[] = [];
  for (const column of columns) {
    const panel = column === times ? -1 : panels.findIndex((one) => belongs(column.name, one));
    if (panel < 0) continue;
    const rows = times.values.map((_, i) => i).filter((i) => times.values[i] !== null && column.values[i] !== null);
    const every = Math.ceil(rows.length / MOST_POINTS);
    const kept = rows.filter((_, k) => k % every === 0);
    curves.push({
      panel,
      name: column.name,
      time: Float64Array.from(kept, (i) => times.values[i]! * times.size),
      values: Float64Array.from(kept, (i) => column.values[i]! * column.size),
    });
  }
  if (curves.length === 0) {
    const names = panels.map((panel) => `"${panel.title}"`).join(", ");
    throw new FileError(`no column beside the time has the name of a curve; allowed: ${names}.`);
  }
  return curves;
}

/** Words of titles that name no quantity. */
const LITTLE = ["of", "the", "on", "to", "relative", "rotor", "rotors", "motor", "motors"];

/** Whether a column is of a panel: its name begins with a quantity of the title, or is that of one of its curves. */
function belongs(name: string, panel: Panel): boolean {
  const lower = name.toLowerCase();
  const words = panel.title.toLowerCase().split(" ");
  const quantities = words.filter((word) => !LITTLE.includes(word)).map((word) => word.replace(/s$/, ""));
  const isOfTitle = quantities.some((quantity) => lower.startsWith(quantity));
  return isOfTitle || panel.curves.some((curve) => curve.name.toLowerCase() === lower);
}

function readColumns(text: string): Column[] {
  const lines = text
    .replace(/^\ufeff/, "")
    .split(/\r?\n/)
    .filter((line) => line.trim() !== "" && !line.startsWith("#"));
  const [heading, ...rows] = lines;
  if (heading === undefined || rows.length === 0) throw new FileError("no rows below a heading.");
  const separator = [";", "\t", ","].find((mark) => heading.includes(mark));
  if (separator === undefined) throw new FileError("no table: the first line has one name only, without commas.");
  const cells = rows.map((row) => row.split(separator));
  return heading.split(separator).map((title, k) => {
    const { name, unit } = titleParts(title);
    const size = SIZES[unit.toLowerCase()];
    if (size === undefined) throw new FileError(`column "${name}": given the unit "${unit}", allowed: ${UNITS}.`);
    const values = cells.map((row) => readNumber(row[k] ?? ""));
    if (values.every((value) => value === null)) throw new FileError(`column "${name}": no numbers.`);
    return { name, size, values };
  });
}

/** "speed (rpm)", "speed [rpm]", "speed in rpm". */
function titleParts(title: string): { name: string; unit: string } {
  const plain = title.trim().replace(/^"|"$/g, "");
  const match = /^(.*?)\s*(?:[([]([^)\]]*)[)\]]|\bin\s+(\S+))$/.exec(plain);
  return { name: (match?.[1] ?? plain).trim(), unit: (match?.[2] ?? match?.[3] ?? "").trim() };
}
