/** Shapes of machine drawings on a canvas. Points are in m, sizes of symbols in CSS pixels. */

import type { Colours } from "./colours.ts";

const FULL_TURN = 2 * Math.PI;
const FONT = "system-ui, sans-serif";

/** A canvas with a map from m to pixels: X = x0 + a x + b y, Y = y0 + c x + d y. */
export class Pen {
  readonly context: CanvasRenderingContext2D;
  colours: Colours;
  /** Pixels per m. */
  scale = 1;
  private a = 1;
  private b = 0;
  private c = 0;
  private d = -1;
  private x0 = 0;
  private y0 = 0;

  constructor(context: CanvasRenderingContext2D, colours: Colours) {
    this.context = context;
    this.colours = colours;
  }

  /** Show a point of the machine at a pixel, what has the direction `turn` (rad) to the right. */
  setView(x: number, y: number, turn: number, scale: number, pixelX: number, pixelY: number): void {
    this.scale = scale;
    this.a = scale * Math.cos(turn);
    this.b = scale * Math.sin(turn);
    this.c = scale * Math.sin(turn);
    this.d = -scale * Math.cos(turn);
    this.x0 = pixelX - this.a * x - this.b * y;
    this.y0 = pixelY - this.c * x - this.d * y;
  }

  pixelX(x: number, y: number): number {
    return this.x0 + this.a * x + this.b * y;
  }

  pixelY(x: number, y: number): number {
    return this.y0 + this.c * x + this.d * y;
  }

  /** The point of the machine at a pixel. */
  worldX(pixelX: number, pixelY: number): number {
    return (this.a * (pixelX - this.x0) + this.c * (pixelY - this.y0)) / (this.scale * this.scale);
  }

  worldY(pixelX: number, pixelY: number): number {
    return (this.b * (pixelX - this.x0) + this.d * (pixelY - this.y0)) / (this.scale * this.scale);
  }

  /** The angle on the canvas, clockwise, of a direction. */
  canvasAngle(direction: number): number {
    return -direction + Math.atan2(this.c, this.a);
  }

  stroke(colour: string, width: number): void {
    this.context.strokeStyle = colour;
    this.context.lineWidth = width;
    this.context.stroke();
  }

  fill(colour: string): void {
    this.context.fillStyle = colour;
    this.context.fill();
  }

  line(x1: number, y1: number, x2: number, y2: number, colour: string, width: number): void {
    this.context.beginPath();
    this.context.moveTo(this.pixelX(x1, y1), this.pixelY(x1, y1));
    this.context.lineTo(this.pixelX(x2, y2), this.pixelY(x2, y2));
    this.stroke(colour, width);
  }

  /** A circle about a point, of a radius in pixels. */
  circle(x: number, y: number, radius: number, fill: string | null, edge: string | null, width: number): void {
    this.context.beginPath();
    this.context.arc(this.pixelX(x, y), this.pixelY(x, y), radius, 0, FULL_TURN);
    if (fill !== null) this.fill(fill);
    if (edge !== null) this.stroke(edge, width);
  }

  /** A part of a ring about a direction, of half an angle to each side. */
  sector(
    x: number, y: number, inner: number, outer: number, direction: number, half: number, fill: string, edge: string,
  ): void {
    const middle = this.canvasAngle(direction);
    const [cx, cy] = [this.pixelX(x, y), this.pixelY(x, y)];
    this.context.beginPath();
    this.context.arc(cx, cy, outer, middle - half, middle + half);
    this.context.arc(cx, cy, inner, middle + half, middle - half, true);
    this.context.closePath();
    this.fill(fill);
    this.stroke(edge, 0.8);
  }

  /** An arrow along a circle (radius in pixels) from one direction to another. */
  arc(x: number, y: number, radius: number, from: number, to: number, colour: string, width: number): void {
    const [cx, cy] = [this.pixelX(x, y), this.pixelY(x, y)];
    const [start, end] = [this.canvasAngle(from), this.canvasAngle(to)];
    this.context.beginPath();
    this.context.arc(cx, cy, radius, start, end, end < start);
    this.stroke(colour, width);
    const forward = end < start ? -1 : 1;
    const [tx, ty] = [cx + radius * Math.cos(end), cy + radius * Math.sin(end)];
    const heading = end + (forward * Math.PI) / 2 + (forward * 3) / radius;
    this.arrowHead(tx, ty, heading, colour);
  }

  /** The head of an arrow at a pixel that points in an angle on the canvas. */
  arrowHead(x: number, y: number, heading: number, colour: string): void {
    const [ux, uy] = [Math.cos(heading), Math.sin(heading)];
    this.context.beginPath();
    this.context.moveTo(x + 5 * ux, y + 5 * uy);
    this.context.lineTo(x - 2.5 * ux - 3.4 * uy, y - 2.5 * uy + 3.4 * ux);
    this.context.lineTo(x - 2.5 * ux + 3.4 * uy, y - 2.5 * uy - 3.4 * ux);
    this.context.closePath();
    this.fill(colour);
  }

  /** A zigzag between two points, of half a width in pixels. */
  spring(x1: number, y1: number, x2: number, y2: number, width: number, colour: string): void {
    const along = this.along(x1, y1, x2, y2);
    const turns = 12;
    this.context.beginPath();
    this.to(along, 0, 0, true);
    this.to(along, 0.16, 0, false);
    for (let k = 1; k < turns; k++) this.to(along, 0.16 + (0.68 * k) / turns, k % 2 === 0 ? -width : width, false);
    this.to(along, 0.84, 0, false);
    this.to(along, 1, 0, false);
    this.stroke(colour, 1.3);
  }

  /** A dashpot between two points: its pot moves with the second, its piston with the first. rest: its length in pixels. */
  dashpot(x1: number, y1: number, x2: number, y2: number, width: number, rest: number, colour: string): void {
    const along = this.along(x1, y1, x2, y2);
    const share = along.length > 0 ? rest / along.length : 1;
    const bottom = 1 - 0.3 * share;
    const mouth = bottom - 0.36 * share;
    const piston = Math.max(0.05, mouth + 0.04 * share, Math.min(0.52 * share, bottom - 0.03));
    this.context.beginPath();
    this.to(along, 0, 0, true);
    this.to(along, piston, 0, false);
    this.to(along, piston, -0.75 * width, true);
    this.to(along, piston, 0.75 * width, false);
    this.to(along, mouth, -width, true);
    this.to(along, bottom, -width, false);
    this.to(along, bottom, width, false);
    this.to(along, mouth, width, false);
    this.to(along, bottom, 0, true);
    this.to(along, 1, 0, false);
    this.stroke(colour, 1.3);
  }

  /** A hatched line across a direction, of a width in pixels, with the hatches on the far side. */
  ground(x: number, y: number, dx: number, dy: number, width: number, colour: string): void {
    const [cx, cy] = [this.pixelX(x, y), this.pixelY(x, y)];
    const size = Math.hypot(dx, dy);
    const ux = (this.a * dx + this.b * dy) / (this.scale * size);
    const uy = (this.c * dx + this.d * dy) / (this.scale * size);
    const count = Math.max(3, Math.round(width / 8));
    const depth = 6;
    this.context.beginPath();
    this.context.moveTo(cx - (uy * width) / 2, cy + (ux * width) / 2);
    this.context.lineTo(cx + (uy * width) / 2, cy - (ux * width) / 2);
    this.stroke(colour, 1.5);
    this.context.beginPath();
    for (let k = 0; k < count; k++) {
      const t = width * ((k + 0.8) / count - 0.5);
      const [hx, hy] = [cx - uy * t, cy + ux * t];
      this.context.moveTo(hx, hy);
      this.context.lineTo(hx + depth * (ux + uy), hy + depth * (uy - ux));
    }
    this.stroke(colour, 0.8);
  }

  /** Text at a pixel; on a background, so that lines do not cross it. */
  text(
    words: string, x: number, y: number, colour: string, size: number, align: CanvasTextAlign, background: string | null,
  ): void {
    const { context } = this;
    context.font = `${size}px ${FONT}`;
    context.textAlign = align;
    context.textBaseline = "middle";
    if (background !== null) {
      context.lineWidth = 3;
      context.lineJoin = "round";
      context.strokeStyle = background;
      context.strokeText(words, x, y);
    }
    context.fillStyle = colour;
    context.fillText(words, x, y);
  }

  private along(x1: number, y1: number, x2: number, y2: number): Segment {
    const segment = this.segment;
    segment.x = this.pixelX(x1, y1);
    segment.y = this.pixelY(x1, y1);
    segment.dx = this.pixelX(x2, y2) - segment.x;
    segment.dy = this.pixelY(x2, y2) - segment.y;
    segment.length = Math.hypot(segment.dx, segment.dy);
    return segment;
  }

  private to(segment: Segment, share: number, side: number, isStart: boolean): void {
    const { dx, dy, length } = segment;
    const x = segment.x + share * dx + (length > 0 ? (side * dy) / length : 0);
    const y = segment.y + share * dy - (length > 0 ? (side * dx) / length : 0);
    if (isStart) this.context.moveTo(x, y);
    else this.context.lineTo(x, y);
  }

  private readonly segment: Segment = { x: 0, y: 0, dx: 0, dy: 0, length: 0 };
}

interface Segment {
  x: number;
  y: number;
  dx: number;
  dy: number;
  length: number;
}
