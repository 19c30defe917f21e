/** Lengths below a drawing to compare with: of the machine, and of the magnified motion. */

import { roundDown } from "./numbers.ts";
import type { Pen } from "./shapes.ts";

/** Of the larger side of the carrier: the longest bar. */
const LONGEST = 0.25;
/** Pixels: half the height of a bar's ends, the way to its words, and from one bar to the next. */
const [HALF, NEAR, GAP] = [4, 6, 18];

interface Bar {
  /** In m of the drawing. */
  readonly length: number;
  readonly words: string;
}

export class ScaleBars {
  private unit = -1;
  private magnification = -1;
  private machine: Bar = { length: 0, words: "" };
  private motion: Bar = { length: 0, words: "" };

  /**
   * Draw the bars from a pixel on.
   *
   * unit: the larger side of the carrier, in m. magnification: 1 leaves out the bar of the motion.
   */
  draw(pen: Pen, x: number, y: number, unit: number, magnification: number): void {
    this.measure(unit, magnification);
    const { ink, accents } = pen.colours;
    const end = drawBar(pen, x, y, this.machine, ink);
    if (magnification !== 1) drawBar(pen, end + GAP, y, this.motion, accents[3]);
  }

  private measure(unit: number, magnification: number): void {
    if (this.unit === unit && this.magnification === magnification) return;
    [this.unit, this.magnification] = [unit, magnification];
    const length = roundDown(LONGEST * unit);
    const motion = roundDown((LONGEST * unit) / magnification);
    this.machine = { length, words: lengthText(length) };
    this.motion = { length: motion * magnification, words: `${lengthText(motion)} of motion` };
  }
}

/** Draw a bar and its words; return where they end. */
function drawBar(pen: Pen, x: number, y: number, { length, words }: Bar, colour: string): number {
  const { context } = pen;
  const end = x + length * pen.scale;
  context.beginPath();
  context.moveTo(x, y - HALF);
  context.lineTo(x, y + HALF);
  context.moveTo(x, y);
  context.lineTo(end, y);
  context.moveTo(end, y - HALF);
  context.lineTo(end, y + HALF);
  pen.stroke(colour, 1.6);
  pen.text(words, end + NEAR, y, pen.colours.ink, 12, "left", null);
  return end + NEAR + context.measureText(words).width;
}

function threeDigits(value: number): string {
  return String(Number(value.toPrecision(3)));
}

/** A length in m as text. */
function lengthText(length: number): string {
  if (length >= 1) return `${threeDigits(length)} m`;
  return length >= 1e-3 ? `${threeDigits(1e3 * length)} mm` : `${threeDigits(1e6 * length)} µm`;
}
