/** Axes of a small panel: a map from values to pixels, and ticks at round values. */

import type { Colours } from "./colours.ts";

const FONT = "11px system-ui, sans-serif";

export class Axis {
  low = 0;
  high = 1;
  lowPixel = 0;
  highPixel = 1;

  set(low: number, high: number, lowPixel: number, highPixel: number): void {
    this.low = low;
    this.high = high > low ? high : low + 1;
    this.lowPixel = lowPixel;
    this.highPixel = highPixel;
  }

  pixel(value: number): number {
    return this.lowPixel + ((value - this.low) / (this.high - this.low)) * (this.highPixel - this.lowPixel);
  }

  /** The distance of ticks: see `tickStep`. */
  step(spacing: number): number {
    return tickStep(this.low, this.high, Math.abs(this.highPixel - this.lowPixel), spacing);
  }
}

/** px: closer ticks cannot be read; ticks beside zero from which a scale can be read. */
const [CLOSEST, FEWEST] = [13, 2];

/**
 * The distance of ticks: 1, 2 or 5 times a power of ten, at least some pixels apart; nearer, where a small panel would have too
 * few.
 */
export function tickStep(low: number, high: number, pixels: number, spacing: number): number {
  for (let pitch = spacing; ; pitch = Math.max(CLOSEST, 0.7 * pitch)) {
    const least = ((high - low) * pitch) / Math.max(1, pixels);
    const power = 10 ** Math.floor(Math.log10(least));
    const digit = least / power;
    const step = power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10);
    const count = Math.floor(high / step) - Math.ceil(low / step) + (low <= 0 && high >= 0 ? 0 : 1);
    if (count >= FEWEST || pitch <= CLOSEST) return step;
  }
}

/** The multiples of a step from one value to another. */
export function ticks(low: number, high: number, step: number): number[] {
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, k) => (first + k) * step);
}

/** Draw grid, ticks, zero line and names of two axes. */
export function drawAxes(
  context: CanvasRenderingContext2D, x: Axis, y: Axis, names: readonly [string, string], colours: Colours,
): void {
  const [stepX, stepY] = [x.step(70), y.step(38)];
  const [ticksX, ticksY] = [ticks(x.low, x.high, stepX), ticks(y.low, y.high, stepY)];
  context.font = FONT;
  context.lineWidth = 1;
  context.strokeStyle = colours.muted;
  context.fillStyle = colours.muted;
  context.globalAlpha = 0.22;
  context.beginPath();
  for (const value of ticksX) {
    context.moveTo(x.pixel(value), y.lowPixel);
    context.lineTo(x.pixel(value), y.highPixel);
  }
  for (const value of ticksY) {
    context.moveTo(x.lowPixel, y.pixel(value));
    context.lineTo(x.highPixel, y.pixel(value));
  }
  context.stroke();
  context.globalAlpha = 1;
  context.beginPath();
  context.moveTo(x.lowPixel, y.highPixel);
  context.lineTo(x.lowPixel, y.lowPixel);
  context.lineTo(x.highPixel, y.lowPixel);
  if (y.low < 0 && y.high > 0) {
    context.moveTo(x.lowPixel, y.pixel(0));
    context.lineTo(x.highPixel, y.pixel(0));
  }
  context.stroke();
  context.textAlign = "center";
  context.textBaseline = "top";
  for (const value of ticksX) {
    context.fillText(tickText(value, stepX), x.pixel(value), y.lowPixel + 5);
  }
  context.fillStyle = colours.ink;
  context.fillText(names[0], (x.lowPixel + x.highPixel) / 2, y.lowPixel + 20);
  context.fillStyle = colours.muted;
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const value of ticksY) {
    context.fillText(tickText(value, stepY), x.lowPixel - 5, y.pixel(value));
  }
  context.fillStyle = colours.ink;
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.fillText(names[1], x.lowPixel - 38, y.highPixel - 8);
}

/** The number of a tick, with the digits that its distance to the next one has. */
export function tickText(value: number, step: number): string {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return value.toFixed(digits).replace("-", "−");
}
