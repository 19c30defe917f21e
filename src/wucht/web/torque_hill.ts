/** The torque hill: the drive's characteristic against load and vibration over the speed; the working point climbs it. */

import { Axis, drawAxes } from "./axes.ts";
import { type Colours, fitCanvas, Theme } from "./colours.ts";
import type { HillMachine } from "./drawing_data.ts";
import { TorqueCurves, type WorkingPoint } from "./torque_curves.ts";
import { TorqueGrid } from "./torque_grid.ts";

const RPM = 30 / Math.PI;
/** Of the drive's largest torque: limits of the scale for resonances, and for the braking torque. */
const [TALLEST, BRAKING] = [2.5, 0.5];
/** Times the opposing torques: limit of the scale for the starting torque of a motor. */
const STARTING = 3;
/** Of the drive's largest torque: what opposes it less is not there. */
const NEGLIGIBLE = 1e-6;
const [LEFT, RIGHT, TOP, BOTTOM] = [54, 12, 42, 40];
/** Of the unit of torque, with its factor: the first in which the highest torque is no small number. */
const PREFIXES: readonly (readonly [string, number])[] = [["k", 1e-3], ["", 1], ["m", 1e3], ["µ", 1e6]];
const SMALLEST_LABEL = 0.5;
/** px from the top: the line of the marks' meanings. */
const MARKS = 30;
const FONT = "11px system-ui, sans-serif";

export class TorqueHill {
  /** Whether the machine has a balance of torques; if not, the reason. */
  readonly available: boolean;
  readonly reason: string;
  /** Names of the driven rotors; the hill is that of one of them. */
  readonly rotors: readonly string[];
  private readonly canvas: HTMLCanvasElement;
  private readonly context: CanvasRenderingContext2D;
  private readonly theme: Theme;
  private readonly curves: TorqueCurves | null;
  private readonly start: Float64Array;
  private readonly x = new Axis();
  private readonly y = new Axis();
  /** The same in the units that are shown. */
  private readonly shownX = new Axis();
  private readonly shownY = new Axis();
  private readonly grid = new TorqueGrid();
  private readonly torque = new Float64Array(3);
  private points: readonly WorkingPoint[] = [];
  private rotor = 0;

  constructor(host: HTMLElement, machine: HillMachine) {
    const { hills } = machine;
    this.canvas = host.ownerDocument.createElement("canvas");
    this.canvas.style.cssText = "display: block; width: 100%; height: 100%";
    this.canvas.setAttribute("role", "img");
    host.append(this.canvas);
    const context = this.canvas.getContext("2d");
    if (context === null) throw new Error("this browser draws nothing on a canvas");
    this.context = context;
    this.theme = new Theme(this.canvas);
    this.available = hills.available;
    this.reason = hills.reason;
    this.curves = hills.available ? new TorqueCurves(machine, hills) : null;
    this.rotors = hills.available ? hills.rotors.filter((rotor) => rotor.is_driven).map((rotor) => rotor.name) : [];
    this.start = Float64Array.from(machine.states, (state) => state.start);
    this.select(this.rotors[0] ?? "");
  }

  /** Show the hill of another driven rotor. */
  select(name: string): void {
    const { curves } = this;
    this.rotor = Math.max(0, curves === null ? 0 : curves.hills.rotors.findIndex((rotor) => rotor.name === name));
    const words = this.available ? `torques at ${name} over its speed` : `no torques over the speed: ${this.reason}`;
    this.canvas.setAttribute("aria-label", words);
  }

  /** The steady speeds that were drawn last. */
  get workingPoints(): readonly WorkingPoint[] {
    return this.points;
  }

  /**
   * Draw the hill.
   *
   * speedTrace, torqueTrace: recent speeds of the rotor and torques of its drive, the last the newest; without torques those of
   * the characteristic at these speeds. now: the time, to which
   * schedules are evaluated. state: balancing bodies are held at the phases that they have in it, by default at the start.
   */
  draw(
    parameters: ArrayLike<number>, speedTrace: Float64Array | null, torqueTrace: Float64Array | null, now: number,
    state: ArrayLike<number> = this.start,
  ): void {
    const { context, canvas, curves } = this;
    if (!fitCanvas(canvas, context)) return;
    const colours = this.theme.current;
    context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    if (curves === null) {
      context.font = FONT;
      context.fillStyle = colours.muted;
      context.textAlign = "left";
      context.textBaseline = "top";
      wrap(context, `No torque hill: ${this.reason}.`, 12, 12, canvas.clientWidth - 24);
      return;
    }
    curves.set(parameters, now, state, this.rotor);
    this.grid.evaluate(curves, speedTrace?.at(-1));
    this.points = curves.workingPoints(this.grid.count, this.grid.speeds, this.grid.torques);
    this.scale();
    this.drawPanel(curves, colours);
    this.drawCurves(colours);
    this.drawPoints(colours);
    if (speedTrace !== null && speedTrace.length > 0) {
      const torques = torqueTrace ?? Float64Array.from(speedTrace, (speed) => this.driveAt(curves, speed));
      this.drawTrace(speedTrace, torques, colours);
    }
    this.drawLegend(colours);
  }

  /** Draw the axes, in rpm, and in N·m or parts of it. */
  private drawPanel(curves: TorqueCurves, colours: Colours): void {
    const { x, y } = this;
    const { speed, torque } = curves.hills.units;
    const isRadian = speed === "rad/s";
    const factor = isRadian ? RPM : 1;
    const largest = Math.max(Math.abs(y.low), Math.abs(y.high));
    const fitting = PREFIXES.find(([, unit]) => largest * unit >= SMALLEST_LABEL);
    const [prefix, scale] = torque === "" || fitting === undefined ? ["", 1] : fitting;
    this.shownX.set(x.low * factor, x.high * factor, x.lowPixel, x.highPixel);
    this.shownY.set(y.low * scale, y.high * scale, y.lowPixel, y.highPixel);
    const titles = [
      axisTitle("speed", isRadian ? "rpm" : speed),
      axisTitle("torque", prefix + torque.replace("N m", "N·m")),
    ] as const;
    drawAxes(this.context, this.shownX, this.shownY, titles, colours);
  }

  private driveAt(curves: TorqueCurves, speed: number): number {
    curves.torques(speed, this.torque);
    return this.torque[0]!;
  }

  /** Set the axes so that the drive is visible, however high the resonance, and all working points and the present speed. */
  private scale(): void {
    const { points } = this;
    const { speeds, torques, count } = this.grid;
    const [lowX, highX] = [this.grid.range[0]!, this.grid.range[1]!];
    let [low, high, driveLow, driveHigh, opposing] = [0, 0, 0, 0, 0];
    for (let i = 0; i < count; i++) {
      const [drive, opposed] = [torques[3 * i]!, this.grid.opposingTorque(i)];
      [low, high] = [Math.min(low, drive, opposed), Math.max(high, drive, opposed)];
      opposing = Math.max(opposing, Math.abs(opposed));
      if (drive * speeds[i]! >= 0) [driveLow, driveHigh] = [Math.min(driveLow, drive), Math.max(driveHigh, drive)];
    }
    const largest = Math.max(-driveLow, driveHigh);
    if (largest > 0) {
      for (const point of points) opposing = Math.max(opposing, Math.abs(point.torque));
      const most = opposing > NEGLIGIBLE * largest ? STARTING * opposing : largest;
      const [above, below] = driveHigh >= -driveLow ? [TALLEST, BRAKING] : [BRAKING, TALLEST];
      low = Math.max(low, -below * largest, -most);
      high = Math.min(high, above * largest, most);
    }
    for (const point of points) [low, high] = [Math.min(low, point.torque), Math.max(high, point.torque)];
    const room = high - low || 1;
    this.x.set(lowX, highX, LEFT, this.canvas.clientWidth - RIGHT);
    this.y.set(low < 0 ? low - 0.05 * room : 0, high + 0.08 * room, this.canvas.clientHeight - BOTTOM, TOP);
  }

  private drawCurves(colours: Colours): void {
    const { context, x, y } = this;
    context.save();
    context.beginPath();
    context.rect(x.lowPixel, y.highPixel, x.highPixel - x.lowPixel, y.lowPixel - y.highPixel);
    context.clip();
    context.lineJoin = "round";
    this.path(2, colours.accents[0]);
    context.lineTo(x.pixel(this.grid.speeds[this.grid.count - 1]!), y.pixel(0));
    context.lineTo(x.pixel(this.grid.speeds[0]!), y.pixel(0));
    context.globalAlpha = 0.13;
    context.fillStyle = colours.accents[0];
    context.fill();
    context.globalAlpha = 1;
    context.setLineDash([7, 3, 1.5, 3]);
    if (this.hasLoad()) {
      this.path(1, colours.accents[2]);
      context.stroke();
    }
    context.setLineDash([]);
    this.path(2, colours.accents[0]);
    context.stroke();
    context.setLineDash([8, 4]);
    this.path(0, colours.accents[1]);
    context.stroke();
    context.setLineDash([]);
    context.restore();
  }

  private hasLoad(): boolean {
    for (let i = 0; i < this.grid.count; i++) if (this.grid.torques[3 * i + 1] !== 0) return true;
    return false;
  }

  /** Begin the path of a torque: 0 of the drive, 1 of the load, 2 of load and vibration. */
  private path(kind: 0 | 1 | 2, colour: string): void {
    const { context, x, y } = this;
    const { speeds, torques } = this.grid;
    context.beginPath();
    context.strokeStyle = colour;
    context.lineWidth = 2;
    // Beyond the panel a resonance may be a million times as high, where canvases draw no lines.
    const [below, above] = [y.low - (y.high - y.low), y.high + (y.high - y.low)];
    for (let i = 0; i < this.grid.count; i++) {
      const value = kind === 2 ? this.grid.opposingTorque(i) : torques[3 * i + kind]!;
      const height = y.pixel(Math.max(below, Math.min(above, value)));
      if (i === 0) context.moveTo(x.pixel(speeds[i]!), height);
      else context.lineTo(x.pixel(speeds[i]!), height);
    }
  }

  private drawPoints(colours: Colours): void {
    const { x, y } = this;
    for (const { speed, torque, stable } of this.points) {
      this.mark(stable ? "stable" : "unstable", x.pixel(speed), y.pixel(torque), colours);
    }
  }

  private drawTrace(speeds: Float64Array, torques: Float64Array, colours: Colours): void {
    const { context, x, y } = this;
    const last = Math.min(speeds.length, torques.length) - 1;
    const height = (torque: number): number => Math.max(y.highPixel, Math.min(y.lowPixel, y.pixel(torque)));
    context.save();
    context.beginPath();
    context.rect(x.lowPixel, y.highPixel, x.highPixel - x.lowPixel, y.lowPixel - y.highPixel);
    context.clip();
    context.beginPath();
    for (let i = 0; i <= last; i++) {
      if (i === 0) context.moveTo(x.pixel(speeds[i]!), y.pixel(torques[i]!));
      else context.lineTo(x.pixel(speeds[i]!), y.pixel(torques[i]!));
    }
    context.lineJoin = "round";
    context.strokeStyle = colours.accents[3];
    context.lineWidth = 1.6;
    context.stroke();
    context.restore();
    context.beginPath();
    this.mark("now", x.pixel(speeds[last]!), height(torques[last]!), colours);
  }

  /** The mark of a working point, or of the present one, which leaves visible what it lies on. */
  private mark(kind: "stable" | "unstable" | "now", x: number, y: number, colours: Colours): void {
    const { context } = this;
    const isNow = kind === "now";
    context.beginPath();
    context.arc(x, y, isNow ? 7.5 : 4.5, 0, 2 * Math.PI);
    context.fillStyle = kind === "stable" ? colours.ink : colours.surface;
    if (!isNow) context.fill();
    context.strokeStyle = isNow ? colours.accents[3] : colours.ink;
    context.lineWidth = isNow ? 3 : 1.5;
    context.stroke();
  }

  /** What the marks mean, on the right of the axis' name. */
  private drawMarkNames(colours: Colours, end: number): void {
    const { context } = this;
    context.textAlign = "right";
    let at = end;
    for (const kind of ["now", "unstable", "stable"] as const) {
      if (kind !== "now" && !this.points.some((point) => point.stable === (kind === "stable"))) continue;
      context.fillStyle = colours.ink;
      context.fillText(kind, at, MARKS);
      at -= context.measureText(kind).width + 13;
      this.mark(kind, at, MARKS, colours);
      at -= 20;
    }
  }

  private drawLegend(colours: Colours): void {
    const { context } = this;
    const hasLoad = this.hasLoad();
    const entries: [string, string, number[]][] = [
      ["motor", colours.accents[1], [8, 4]],
      [hasLoad ? "load and vibration" : "vibration", colours.accents[0], []],
    ];
    if (hasLoad) entries.push(["load", colours.accents[2], [7, 3, 1.5, 3]]);
    context.font = FONT;
    context.textAlign = "left";
    context.textBaseline = "middle";
    let at = LEFT;
    for (const [words, colour, dashes] of entries) {
      context.beginPath();
      context.setLineDash(dashes);
      context.moveTo(at, 10);
      context.lineTo(at + 24, 10);
      context.strokeStyle = colour;
      context.lineWidth = 2;
      context.stroke();
      context.setLineDash([]);
      context.fillStyle = colours.ink;
      context.fillText(words, at + 29, 10);
      at += 41 + context.measureText(words).width;
    }
    const name = this.rotors.length > 1 ? this.curves!.hills.rotors[this.rotor]!.name : "";
    const end = this.canvas.clientWidth - RIGHT;
    if (at + context.measureText(name).width < end) {
      context.textAlign = "right";
      context.fillText(name, end, 10);
    }
    this.drawMarkNames(colours, end);
  }
}

function axisTitle(name: string, unit: string): string {
  return unit === "" ? name : `${name} in ${unit}`;
}

/** Text in lines of a width. */
function wrap(context: CanvasRenderingContext2D, words: string, x: number, y: number, width: number): void {
  let [line, height] = ["", y];
  for (const word of words.split(" ")) {
    const longer = line === "" ? word : `${line} ${word}`;
    if (line !== "" && context.measureText(longer).width > width) {
      context.fillText(line, x, height);
      [line, height] = [word, height + 16];
    } else line = longer;
  }
  context.fillText(line, x, height);
}
