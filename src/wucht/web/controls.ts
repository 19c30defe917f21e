/** Sliders with number fields: what can be moved, between limits, and a sentence for a value that cannot be. */

import { element } from "./dom.ts";
import { numberText, quantityText, readNumber } from "./numbers.ts";

const STEPS = 1000;
const DIGITS = 6;
/** In SI, as in files. */
const LARGEST = 1e30;
/** Significant digits of a value that a slider gives. */
const SLIDER_DIGITS = 3;
/** Could be thousands, or a number with a decimal comma. */
const THOUSANDS = /^[-+−]?[1-9]\d{0,2}(,\d{3})+$/;

/** A value in SI, shown as value / size in a unit. */
export interface Scale {
  readonly name: string;
  readonly unit: string;
  readonly size: number;
  readonly bottom: number;
  readonly top: number;
  readonly logarithmic: boolean;
  readonly low: number | null;
  readonly high: number | null;
  readonly open: boolean;
  readonly whole: boolean;
}

/** The sentence that refuses a value in SI, or nothing. */
export function refusal(scale: Scale, value: number): string {
  const shown = (x: number) => quantityText(x / scale.size, scale.unit, DIGITS);
  if (!(Math.abs(value) <= LARGEST)) return `must be at most ${shown(LARGEST)}`;
  if (scale.whole && !Number.isInteger(value)) return "must be a whole number";
  if (scale.low !== null && (scale.open ? value <= scale.low : value < scale.low)) {
    return `must be ${scale.open ? "greater than" : "at least"} ${shown(scale.low)}`;
  }
  return scale.high !== null && value > scale.high ? `must be at most ${shown(scale.high)}` : "";
}

/** The value of a place on the slider, of few digits in its unit, and the place of a value. */
export function valueAt(scale: Scale, place: number): number {
  const { bottom, top, logarithmic, size } = scale;
  const value = logarithmic ? bottom * (top / bottom) ** (place / STEPS) : bottom + ((top - bottom) * place) / STEPS;
  if (scale.whole) return Math.round(value);
  const step = (top - bottom) / STEPS / size;
  if (logarithmic) return Number((value / size).toPrecision(SLIDER_DIGITS)) * size;
  const decimals = Math.max(0, Math.min(15, Math.ceil(-Math.log10(step))));
  return (Number((value / size).toFixed(decimals)) + 0) * size;
}

/** The place of a value on the slider. */
export function placeOf(scale: Scale, value: number): number {
  const { bottom, top, logarithmic } = scale;
  const share = logarithmic
    ? Math.log(Math.max(value, bottom) / bottom) / Math.log(top / bottom)
    : (value - bottom) / (top - bottom);
  return Math.round(STEPS * Math.min(1, Math.max(0, share)));
}

let count = 0;

/** A slider and its number field. */
export class SliderField {
  readonly root: HTMLElement;
  private readonly _scale: Scale;
  private readonly _slider: HTMLInputElement;
  private readonly _field: HTMLInputElement;
  private readonly _message: HTMLElement;
  private readonly _original: number;
  private _value: number;

  /** change: receives a value that is allowed. */
  constructor(scale: Scale, value: number, change: (value: number) => void) {
    const id = `value-${count++}`;
    this._scale = scale;
    this._original = this._value = value;
    const words = scale.unit === "" ? scale.name : `${scale.name} in ${scale.unit}`;
    this._slider = element("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": scale.name });
    this._field = element("input", { type: "text", inputmode: "decimal", id, autocomplete: "off", spellcheck: "false" });
    this._field.setAttribute("aria-label", words);
    this._field.setAttribute("aria-describedby", `${id}-message`);
    this._message = element("p", { class: "refusal", role: "alert", id: `${id}-message` });
    this.root = element(
      "div",
      { class: "control" },
      element("label", { for: id }, scale.name),
      this._slider,
      element("span", { class: "field" }, this._field, element("span", { class: "unit" }, scale.unit)),
      this._message,
    );
    this.set(value);
    this._slider.addEventListener("input", () => {
      const moved = valueAt(scale, this._slider.valueAsNumber);
      this.set(moved);
      change(moved);
    });
    this._field.addEventListener("change", () => this._read(change));
  }

  /** Show a value. */
  set(value: number) {
    this._value = value;
    this._slider.value = String(placeOf(this._scale, value));
    this._slider.setAttribute("aria-valuetext", quantityText(value / this._scale.size, this._scale.unit));
    this._field.value = numberText(value / this._scale.size, DIGITS);
    this._message.textContent = "";
    this._field.removeAttribute("aria-invalid");
    this.root.classList.toggle("changed", !Object.is(value, this._original));
  }

  private _read(change: (value: number) => void) {
    const typed = readNumber(this._field.value);
    const { name, unit, size } = this._scale;
    // A number that reads as the present one is that one, with all its digits.
    const isSame = typed !== null && typed === readNumber(numberText(this._value / size, DIGITS));
    const value = typed === null ? Number.NaN : isSame ? this._value : typed * size + 0;
    const isAmbiguous = THOUSANDS.test(this._field.value.trim());
    const reason = isAmbiguous
      ? "must be written without a comma before three digits"
      : typed === null
        ? `must be a number${unit ? ` in ${unit}` : ""}`
        : refusal(this._scale, value);
    if (reason !== "") {
      const old = quantityText(this._value / size, unit, DIGITS);
      this._message.textContent = `${name}: given “${this._field.value}”, ${reason}; ${old} is kept.`;
      this._field.setAttribute("aria-invalid", "true");
      return;
    }
    this.set(value);
    if (!isSame) change(value);
  }
}
