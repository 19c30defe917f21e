/** Numbers as people read and write them. */

/** A number with few digits: 0.0195, 1234, 1.2e-7. */
export function numberText(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** A number and its unit; degrees stand at the number. */
export function quantityText(value: number, unit: string, digits = 4): string {
  return unit === "" ? numberText(value, digits) : `${numberText(value, digits)}${unit === "°" ? "" : "\u00a0"}${unit}`;
}

/** A number that somebody typed, also with a decimal comma; null where it is none. */
export function readNumber(text: string): number | null {
  const plain = text.trim().replace("−", "-").replace(",", ".");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : null;
}

/** 1, 2, 5, 10, ... up to a number. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1);
}
