/** Numbers as people read and write them. */

/** Of the largest value of a curve: a smaller one is what rounding has left of zero. */
const ROUNDING = 1e-12;

/** A number with few digits: 0.0195, 1234, 1.2e-7. */
export function numberText(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replaceAll("-", "−");
}

/** A number and its unit; degrees stand at the number. */
export function quantityText(value: number, unit: string, digits = 4): string {
  return unit === "" ? numberText(value, digits) : `${numberText(value, digits)}${unit === "°" ? "" : "\u00a0"}${unit}`;
}

/** The largest size of values; what is not finite, or missing, does not count. */
export function largestSize(values: Iterable<number | null>): number {
  let largest = 0;
  for (const value of values) if (Number.isFinite(value)) largest = Math.max(largest, Math.abs(value!));
  return largest;
}

/** A value of a curve, 0 where it is rounding. largest: what the curve reaches. */
export function withoutRounding(value: number, largest: number): number {
  return Math.abs(value) < ROUNDING * largest ? 0 : value;
}

/** A number that somebody typed, also with a decimal comma; null where it is none. */
export function readNumber(text: string): number | null {
  const plain = text.trim().replaceAll("−", "-").replace(",", ".");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : null;
}

/** The largest of 1, 2, 5 times a power of ten that is no more than a number. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-12);
  const digit = value / power + 1e-9;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}
