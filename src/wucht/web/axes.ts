/** Axes of a small panel: a map from values to pixels, and ticks at round values. */

import type { Colours } from "./colours.ts";

const FONT = "11px system-ui, sans-serif";

export class Axis {
  low = 0;
  high = 1;
  /** Pixels of the low and of the high end. */
  from = 0;
  to = 1;

  set(low: number, high: number, from: number, to: number): void {
    this.low = low;
    this.high = high > low ? high : low + 1;
    this.from = from;
    this.to = to;
  }

  pixel(value: number): number {
    return this.from + ((value - this.low) / (this.high - this.low)) * (this.to - this.from);
  }

  /** The distance of ticks: 1, 2 or 5 times a power of ten, at least some pixels apart. */
  step(apart: number): number {
    const least = ((this.high - this.low) * apart) / Math.max(1, Math.abs(this.to - this.from));
    const power = 10 ** Math.floor(Math.log10(least));
    const digit = least / power;
    return power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10);
  }
}

/** Draw grid, ticks, zero line and names of two axes. */
export function drawAxes(
  context: CanvasRenderingContext2D, x: Axis, y: Axis, names: readonly [string, string], colours: Colours,
): void {
  const [stepX, stepY] = [x.step(70), y.step(38)];
  context.font = FONT;
  context.lineWidth = 1;
  context.strokeStyle = colours.muted;
  context.fillStyle = colours.muted;
  context.globalAlpha = 0.22;
  context.beginPath();
  for (let k = Math.ceil(x.low / stepX); k * stepX <= x.high; k++) {
    context.moveTo(x.pixel(k * stepX), y.from);
    context.lineTo(x.pixel(k * stepX), y.to);
  }
  for (let k = Math.ceil(y.low / stepY); k * stepY <= y.high; k++) {
    context.moveTo(x.from, y.pixel(k * stepY));
    context.lineTo(x.to, y.pixel(k * stepY));
  }
  context.stroke();
  context.globalAlpha = 1;
  context.beginPath();
  context.moveTo(x.from, y.to);
  context.lineTo(x.from, y.from);
  context.lineTo(x.to, y.from);
  if (y.low < 0 && y.high > 0) {
    context.moveTo(x.from, y.pixel(0));
    context.lineTo(x.to, y.pixel(0));
  }
  context.stroke();
  context.textAlign = "center";
  context.textBaseline = "top";
  for (let k = Math.ceil(x.low / stepX); k * stepX <= x.high; k++) {
    context.fillText(tickText(k * stepX, stepX), x.pixel(k * stepX), y.from + 5);
  }
  context.fillStyle = colours.ink;
  context.fillText(names[0], (x.from + x.to) / 2, y.from + 20);
  context.fillStyle = colours.muted;
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (let k = Math.ceil(y.low / stepY); k * stepY <= y.high; k++) {
    context.fillText(tickText(k * stepY, stepY), x.from - 5, y.pixel(k * stepY));
  }
  context.fillStyle = colours.ink;
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.fillText(names[1], x.from - 38, y.to - 8);
}

/** The number of a tick, with the digits that its distance to the next one has. */
export function tickText(value: number, step: number): string {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return value.toFixed(digits).replace("-", "−");
}
