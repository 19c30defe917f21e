/** Curves over time: a panel for each quantity, the drawing's time as cursor, measured values above the computed ones. */

import uPlot from "uplot";
import { ticks, tickStep } from "./axes.ts";
import type { Course } from "./course.ts";
import { element } from "./dom.ts";
import type { Level } from "./levels.ts";
import type { MeasuredCurve } from "./measured.ts";
import { largestSize, numberText, quantityText, withoutRounding } from "./numbers.ts";
import type { Curve, Panel } from "./page_data.ts";
import { paperOf, type Paper } from "./paper.ts";

const TURN = 2 * Math.PI;
/** Times what the curve reaches: a speed beyond is not marked, as it would flatten the curve. */
const REACH = 2;
const AXIS = 58;
const TOP = 8;
/** The height of letters. */
const LETTER = 13;
/** Neighbours differ in colour and dash; where two curves coincide, both are seen. */
const DASHES: readonly number[][] = [[], [8, 5], [3, 3], [9, 3, 2, 3]];
/** Names of more curves have no numbers beside them. */
const FEW = 3;

/** The place of a name, in pixels of the canvas. */
interface Name {
  readonly right: number;
  readonly top: number;
  readonly width: number;
}

type Values = Float64Array | (number | null)[];

/** The values of a curve over the samples of a course, in the panel's unit; a circular one breaks where it wraps. */
export function curveValues(course: Course, panel: Panel, curve: Curve): Values {
  const count = course.time.length;
  const [n, m] = [course.states.length / count, course.outputs.length / count];
  if (curve.output !== undefined) {
    const place = curve.output;
    return Float64Array.from({ length: count }, (_, k) => course.outputs[k * m + place]! / panel.size);
  }
  const values = Array.from<number | null>({ length: count });
  let last = 0;
  for (let k = 0; k < count; k++) {
    const phase = phaseOf(course.states, k * n, curve);
    values[k] = k > 0 && Math.abs(phase - last) > Math.PI ? null : phase / panel.size;
    last = phase;
  }
  return values;
}

/** px between ticks. */
const SPACE = 19;

/** The phase of a curve in a state that begins at a place, in [0, 2 pi). */
export function phaseOf(states: ArrayLike<number>, begin: number, curve: Curve): number {
  const [state, head] = [states[begin + (curve.state ?? 0)]!, states[begin + (curve.head ?? 0)]!];
  const difference = (curve.sense ?? 1) * state - (curve.head_sense ?? 1) * head;
  return difference - TURN * Math.floor(difference / TURN);
}

export class CurvePanel {
  readonly root: HTMLElement;
  private readonly _panel: Panel;
  private readonly _plot: uPlot;
  private readonly _cursor: HTMLElement;
  private readonly _numbers: HTMLElement[];
  private readonly _host: HTMLElement;
  private readonly _paper: Paper;
  private _levels: readonly Level[] = [];
  private _measured: readonly MeasuredCurve[] = [];
  private _until = 1;
  /** What each curve reaches in the course, in the panel's unit. */
  private _largest: readonly number[] = [];

  /** seek: is called with the time at which somebody points. */
  constructor(panel: Panel, timeName: string, isLast: boolean, seek: (time: number) => void) {
    this._panel = panel;
    this._numbers = panel.curves.map(() => element("output", { class: "number" }));
    this._host = element("div", { class: "plot" });
    const keys = panel.curves.map((curve, i) => this._key(curve, i));
    this.root = element(
      "section",
      { class: "panel", "aria-label": `${panel.title} over time` },
      element("h3", {}, this.title, element("span", { class: "keys" }, ...keys)),
      this._host,
    );
    this._paper = paperOf(document.documentElement);
    this._plot = new uPlot(this._options(timeName, isLast), [[0, 1], ...panel.curves.map(() => [null, null])], this._host);
    this._cursor = element("div", { class: "now" });
    this._plot.over.append(this._cursor);
    this._plot.over.addEventListener("pointerdown", (event) => {
      this._plot.over.setPointerCapture(event.pointerId);
      this._seek(event, seek);
    });
    this._plot.over.addEventListener("pointermove", (event) => {
      if (event.buttons === 1) this._seek(event, seek);
    });
  }

  private _key(curve: Curve, index: number): HTMLElement {
    const swatch = element("i", { class: `swatch accent-${(index % 5) + 1}`, "data-dash": String(index % DASHES.length) });
    const name = this._panel.curves.length > 1 || this._panel.circular ? `${curve.name} ` : "";
    const isFew = this._panel.curves.length <= FEW;
    return element("span", { class: "key" }, swatch, name.trimEnd(), ...(isFew ? [" ", this._numbers[index]!] : []));
  }

  /** Draw a course. */
  show(course: Course, levels: readonly Level[], measured: readonly MeasuredCurve[]) {
    this._levels = levels;
    this._measured = measured;
    this._until = course.scenario.until;
    const columns = this._panel.curves.map((curve) => curveValues(course, this._panel, curve));
    this._largest = columns.map(largestSize);
    this._plot.setData([course.time, ...columns] as uPlot.AlignedData);
  }

  /** Move the cursor to a time, with the state and outputs there. */
  move(time: number, state: ArrayLike<number>, outputs: ArrayLike<number>) {
    this._cursor.style.transform = `translateX(${this._plot.valToPos(time, "x")}px)`;
    for (const [i, curve] of this._panel.curves.entries()) {
      const value = curve.output === undefined ? phaseOf(state, 0, curve) : outputs[curve.output]!;
      const number = withoutRounding(value / this._panel.size, this._largest[i] ?? 0);
      this._numbers[i]!.textContent = quantityText(number, this._panel.unit, 3);
    }
  }

  /** Fit the panel to the size of its place. */
  fit() {
    const { clientWidth: width, clientHeight: height } = this._host;
    if (width > 0 && height > 0) this._plot.setSize({ width, height });
  }

  /** The quantity with its unit. */
  get title(): string {
    return `${this._panel.title}${this._panel.unit === "" ? "" : ` (${this._panel.unit})`}`;
  }

  /** The canvas with the curves, for a picture. */
  get canvas(): HTMLCanvasElement {
    return this._plot.ctx.canvas;
  }

  destroy() {
    this._plot.destroy();
  }

  private _seek(event: PointerEvent, seek: (time: number) => void) {
    const left = event.clientX - this._plot.over.getBoundingClientRect().left;
    seek(Math.min(this._until, Math.max(0, this._plot.posToVal(left, "x"))));
  }

  private _options(timeName: string, isLast: boolean): uPlot.Options {
    const { ink, grid, font, accents } = this._paper;
    const axis = { stroke: ink, font, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1, size: 4 } };
    const circular = this._panel.circular && this._panel.unit === "°";
    return {
      width: 300,
      height: 100,
      pxAlign: 1,
      cursor: { show: false },
      legend: { show: false },
      padding: [TOP, 20, 0, 0],
      scales: {
        x: { time: false, range: () => [0, this._until] },
        y: { range: (_, low, high) => this._range(low ?? 0, high ?? 1) },
      },
      series: [
        {},
        ...this._panel.curves.map((_, i) => ({
          stroke: accents[i % accents.length]!,
          width: 1.4,
          dash: [...DASHES[i % DASHES.length]!],
          points: { show: false },
          spanGaps: false,
        })),
      ],
      axes: [
        {
          ...axis,
          gap: 4,
          ...(isLast
            ? { size: 22, label: timeName, labelFont: font, labelSize: 18, labelGap: 2 }
            : { size: 6, values: () => [] }),
        },
        {
          ...axis,
          size: AXIS,
          gap: 6,
          splits: (plot, _, low, high) =>
            circular ? [0, 180, 360] : ticks(low, high, tickStep(low, high, plot.bbox.height / devicePixelRatio, SPACE)),
          values: (_, splits) => splits.map((value) => numberText(value)),
        },
      ],
      hooks: { draw: [(plot) => this._drawAbove(plot)] },
    };
  }

  private _range(low: number, high: number): [number, number] {
    if (this._panel.circular) return [0, TURN / this._panel.size];
    const inside = this._levels
      .map((level) => level.speed / this._panel.size)
      .filter((speed) => speed <= REACH * Math.max(high, 0));
    const top = Math.max(high, ...inside);
    const bottom = Math.min(0, low);
    const margin = 0.06 * (top - bottom || 1);
    return [bottom < 0 ? bottom - margin : 0, top + margin];
  }

  /** Marked speeds and measured values. */
  private _drawAbove(plot: uPlot) {
    const { ctx, bbox } = plot;
    const ratio = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const places: Name[] = [];
    const isVisible = ({ speed }: Level) => plot.valToPos(speed / this._panel.size, "y", true) >= bbox.top;
    const visible = this._levels.filter(isVisible).toSorted((a, b) => b.speed - a.speed);
    const natural = visible.filter((level) => level.isNatural);
    for (const level of visible) {
      // Lines of one kind are named once.
      const name = !level.isNatural || natural.length === 1 ? level.name : level === natural[0] ? "natural frequencies" : "";
      this._drawLevel(plot, { ...level, name }, ratio, places);
    }
    ctx.fillStyle = this._paper.ink;
    for (const curve of this._measured) {
      for (const [i, time] of curve.time.entries()) {
        const [x, y] = [plot.valToPos(time, "x", true), plot.valToPos(curve.values[i]! / this._panel.size, "y", true)];
        ctx.fillRect(x - ratio, y - ratio, 2 * ratio, 2 * ratio);
      }
    }
    ctx.restore();
  }

  /** A marked speed: a line, and its name where no other name is. names: their places so far. */
  private _drawLevel(plot: uPlot, level: Level, ratio: number, names: Name[]) {
    const { ctx, bbox } = plot;
    const y = Math.round(plot.valToPos(level.speed / this._panel.size, "y", true)) + 0.5;
    ctx.lineWidth = ratio;
    ctx.strokeStyle = this._paper.muted;
    ctx.setLineDash((level.isNatural ? [2, 3] : [9, 3]).map((length) => length * ratio));
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    if (level.name === "") return;
    const line = LETTER * ratio;
    const below = y - 1.4 * line < bbox.top;
    const top = below ? y + 2 * ratio : y - 2 * ratio - line;
    ctx.font = this._paper.canvasFont(ratio);
    const width = ctx.measureText(level.name).width;
    const right = [bbox.left + bbox.width - 6 * ratio, bbox.left + 0.5 * bbox.width].find((place) =>
      names.every(
        (other) =>
          other.right - other.width > place + line || other.right < place - width - line || Math.abs(other.top - top) > line,
      ),
    );
    if (right === undefined) return;
    names.push({ right, top, width });
    ctx.textAlign = "right";
    ctx.textBaseline = below ? "top" : "bottom";
    ctx.fillStyle = this._paper.surface;
    ctx.globalAlpha = 0.8;
    ctx.fillRect(right - width - 3 * ratio, top, width + 6 * ratio, line);
    ctx.globalAlpha = 1;
    ctx.fillStyle = this._paper.ink;
    ctx.fillText(level.name, right, below ? top : top + line);
  }
}
