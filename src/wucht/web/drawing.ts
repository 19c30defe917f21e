/** A machine, drawn and moving; its parts can be grabbed. */

import { fitCanvas, Theme } from "./colours.ts";
import type { DrawnMachine } from "./drawing_data.ts";
import { Grip, type Part } from "./grip.ts";
import { Pose, roundDown } from "./pose.ts";
import { drawAxis, drawBody, drawDisc, drawSlider, SMALLEST_BALL } from "./rotors.ts";
import { Pen } from "./shapes.ts";
import { drawAttachment, drawFixture, drawMount, drawPivot, FOUNDATION, GROUND, SPRING } from "./supports.ts";

export type { Part } from "./grip.ts";

/** magnification: of the carrier's motion. */
export interface View {
  readonly stroboscopic: boolean;
  readonly magnification: number;
}

/** Pixels: the border, and the band below for the scale. */
const [BORDER, BAND] = [14, 26];
/** Of the larger side of the carrier: the largest motion that is drawn. */
const ROOM = 0.1;
/** Of the smaller side of the canvas: the rotor in the stroboscopic view. */
const CLOSE = 0.36;
/** Of the larger side of the carrier: the scale's length. */
const RULER = 0.25;

export class MachineDrawing {
  private readonly canvas: HTMLCanvasElement;
  private readonly machine: DrawnMachine;
  private readonly context: CanvasRenderingContext2D;
  private readonly theme: Theme;
  private readonly pose: Pose;
  private readonly pen: Pen;
  /** The order of each body among those of its rotor. */
  private readonly orders: readonly number[];
  private readonly grip: Grip;
  private view: View = { stroboscopic: false, magnification: 1 };
  private version = -1;
  /** Left, bottom, right and top of all that is drawn, and the larger side of the carrier. */
  private readonly extent = new Float64Array(4);
  private unit = 1;
  private ruler = "";
  private motionRuler = "";
  private motionLength = 0;
  private magnificationOfRuler = 0;
  private isEnlarged = false;

  constructor(canvas: HTMLCanvasElement, machine: DrawnMachine) {
    const context = canvas.getContext("2d");
    if (context === null) throw new Error("this browser draws nothing on a canvas");
    this.canvas = canvas;
    this.machine = machine;
    this.context = context;
    this.theme = new Theme(canvas);
    this.pose = new Pose(machine);
    this.pen = new Pen(context, this.theme.current);
    const counts = machine.drawing.rotors.map(() => 0);
    this.orders = machine.drawing.bodies.map((body) => (body.about === null ? 0 : counts[body.rotor]!++));
    this.grip = new Grip(this.pose, this.pen);
  }

  /**
   * Draw the machine.
   *
   * outputs: in the machine's order, or empty. trace: pairs x, y (m) of the main rotor's axis, the last the newest; drawn
   * from the axis at rest, magnified as the carrier's motion. In the stroboscopic view, which turns with the main rotor, it
   * is left out with all that stands still.
   */
  draw(
    time: number, state: ArrayLike<number>, outputs: ArrayLike<number>, parameters: ArrayLike<number>, view: View,
    trace: Float64Array | null,
  ): void {
    void time;
    this.view = view;
    this.pen.colours = this.theme.current;
    if (!fitCanvas(this.canvas, this.context)) return;
    this.pose.update(state, outputs, parameters, view.magnification);
    this.measure();
    this.context.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    this.context.lineCap = "round";
    this.context.lineJoin = "round";
    this.look();
    if (view.stroboscopic) this.drawRotating(state);
    else {
      this.drawSupports();
      this.drawCarrier();
      this.drawRotors(state);
      if (trace !== null) this.drawTrace(trace);
      this.drawRuler();
    }
  }

  /** The magnification, of 1, 2, 5, 10, ..., at which a motion of the carrier is easily seen: in m, in rad of one that only turns. */
  suggestedMagnification(largestAmplitude: number): number {
    this.measure();
    const { to_scale: toScale, carrier, turning } = this.machine.drawing;
    const isAngle = turning !== "no" && carrier.length === 1;
    const suggestion = largestAmplitude > 0 ? roundDown((isAngle ? ROOM : ROOM * this.unit) / largestAmplitude) : 1;
    return toScale || isAngle ? Math.max(1, suggestion) : suggestion;
  }

  /**
   * The part at a point of the canvas as it was drawn last, in CSS pixels from its corner.
   *
   * Around a rotor's axis, and beside the rotors, it is the carrier. The point is where the carrier is held by `moved`.
   */
  partAt(x: number, y: number): Part | null {
    return this.grip.partAt(x, y, this.view.stroboscopic);
  }

  /**
   * The state with a part at a point of the canvas, in CSS pixels.
   *
   * The carrier translates, or turns where it can do nothing else; its velocities become zero. A body that turns about another
   * one gets its angle, as far as its neighbours on a track let it, and the speed of its rotor, so that it goes on turning with
   * it. A rotor gets its angle and stands still. What has a prescribed motion keeps its velocity.
   */
  moved(part: Part, x: number, y: number, state: ArrayLike<number>): Float64Array {
    return this.grip.moved(part, x, y, state);
  }

  /** What the drawing shows, as its caption. */
  get description(): string {
    const { to_scale: toScale, rotors, carrier } = this.machine.drawing;
    const { stroboscopic, magnification } = this.view;
    const sizes = toScale ? "Places, tracks and arms drawn to scale" : "Schematic, not to scale";
    const motion = `${sizes}; motion of the carrier magnified ${magnification} times`;
    const sentences = [carrier.length === 0 || !toScale || magnification === 1 ? sizes : motion];
    if (this.isEnlarged) sentences.push("balls drawn larger than they are");
    if (stroboscopic) sentences.push(`seen turning with ${rotors[0]!.name}; arrow: displacement of its axis`);
    return `${sentences.join("; ")}.`;
  }

  /** The extent of the drawing, when parameters have changed. */
  private measure(): void {
    const { pose, extent } = this;
    if (this.version === pose.version) return;
    this.version = pose.version;
    const { box, mounts, carrier, attachments, turning } = this.machine.drawing;
    for (let i = 0; i < 4; i++) extent[i] = pose.length(box[i]!);
    this.unit = Math.max(extent[2]! - extent[0]!, extent[3]! - extent[1]!);
    const length = SPRING * this.unit;
    let [left, bottom, right, top] = [extent[0]!, extent[1]!, extent[2]!, extent[3]!];
    for (const mount of mounts) {
      const whole = mount.is_on_foundation ? 2 * length + FOUNDATION * this.unit : length;
      const [x, y] = [pose.length(mount.x) + mount.dx * whole, pose.length(mount.y) + mount.dy * whole];
      const [halfX, halfY] = [GROUND * this.unit * Math.abs(mount.dy), GROUND * this.unit * Math.abs(mount.dx)];
      [left, right] = [Math.min(left, x - halfX), Math.max(right, x + halfX)];
      [bottom, top] = [Math.min(bottom, y - halfY), Math.max(top, y + halfY)];
    }
    if (attachments.some(({ angle }) => angle !== null)) {
      [left, right, bottom] = [
        Math.min(left, extent[0]! - 1.4 * length), Math.max(right, extent[2]! + 1.4 * length), Math.min(bottom, extent[1]! - length),
      ];
    }
    if (turning !== "no" && mounts.length === 0) bottom -= 0.15 * this.unit;
    if (carrier.length === 0) [left, right, bottom, top] = [left, right, bottom - 0.06 * this.unit, top + 0.02 * this.unit];
    const room = carrier.length > 0 ? 0.5 * ROOM * this.unit : 0;
    extent.set([left - room, bottom, right + room, top + room]);
    this.magnificationOfRuler = 0;
    const ruler = roundDown(RULER * this.unit);
    this.ruler = lengthText(ruler);
  }

  /** Set the map from the machine to the canvas. */
  private look(): void {
    const { pose, extent, pen } = this;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (this.view.stroboscopic) {
      const rotor = this.machine.drawing.rotors[0]!;
      const scale = (CLOSE * Math.min(width, height)) / pose.length(rotor.radius);
      pen.look(pose.axisX(0), pose.axisY(0), pose.angles[rotor.body]!, scale, width / 2, height / 2);
    } else {
      const [left, bottom, right, top] = [extent[0]!, extent[1]!, extent[2]!, extent[3]!];
      const scale = Math.max(1e-9, Math.min((width - 2 * BORDER) / (right - left), (height - 2 * BORDER - BAND) / (top - bottom)));
      pen.look((left + right) / 2, (bottom + top) / 2, 0, scale, width / 2, (height - BAND) / 2);
    }
    const { bodies } = this.machine.drawing;
    this.isEnlarged = bodies.some((body) => pose.length(body.size) > 0 && pose.length(body.size) * pen.scale < SMALLEST_BALL);
  }

  private drawSupports(): void {
    const { pen, pose, unit } = this;
    const { mounts, carrier, attachments, turning } = this.machine.drawing;
    if (carrier.length === 0) drawFixture(pen, pose);
    if (turning !== "no" && mounts.length === 0 && carrier.length === 1) drawPivot(pen, pose, unit);
    for (const mount of mounts) {
      const label = mount.dx !== 0 ? "x" : "y";
      const isPrescribed = carrier.some((direction) => direction.label === label && direction.velocity < 0);
      drawMount(pen, pose, mount, unit, isPrescribed);
    }
    for (const attachment of attachments) drawAttachment(pen, pose, attachment, unit);
  }

  private drawCarrier(): void {
    const { pen, pose, context } = this;
    const [left, bottom, right, top] = this.machine.drawing.box;
    const [l, b, r, t] = [pose.length(left), pose.length(bottom), pose.length(right), pose.length(top)];
    const rounding = 0.05 * this.unit * pen.scale;
    context.save();
    context.translate(pen.px(pose.placeX(l, t), pose.placeY(l, t)), pen.py(pose.placeX(l, t), pose.placeY(l, t)));
    context.rotate(-pose.turn);
    context.beginPath();
    context.roundRect(0, 0, (r - l) * pen.scale, (t - b) * pen.scale, rounding);
    context.globalAlpha = 0.12;
    pen.fill(pen.colours.muted);
    context.globalAlpha = 1;
    pen.stroke(pen.colours.ink, 1.5);
    context.restore();
  }

  private drawRotors(state: ArrayLike<number>): void {
    const { pen, pose } = this;
    const { stroboscopic } = this.view;
    const { rotors, bodies, sliders } = this.machine.drawing;
    const turn = stroboscopic ? pose.angles[rotors[0]!.body]! : 0;
    for (let i = 0; i < (stroboscopic ? 1 : rotors.length); i++) {
      const rotor = rotors[i]!;
      drawDisc(pen, pose, rotor, i);
      for (const slider of sliders) if (bodies[slider.about]!.rotor === i) drawSlider(pen, pose, slider, state);
      for (let k = 0; k < bodies.length; k++) {
        const body = bodies[k]!;
        if (body.rotor === i && body.about !== null) drawBody(pen, pose, body, k, this.orders[k]!);
      }
      drawAxis(pen, pose, rotor, i, turn, rotors.length > 1);
    }
  }

  /** The rotor at rest, and an arrow from where its axis is at rest to where it is: so its phase to the unbalance is seen. */
  private drawRotating(state: ArrayLike<number>): void {
    const { pen, pose, context } = this;
    this.drawRotors(state);
    const rotor = this.machine.drawing.rotors[0]!;
    const [x0, y0] = [pose.length(rotor.x), pose.length(rotor.y)];
    const [x, y] = [pose.axisX(0), pose.axisY(0)];
    const [fromX, fromY, toX, toY] = [pen.px(x0, y0), pen.py(x0, y0), pen.px(x, y), pen.py(x, y)];
    if (Math.hypot(toX - fromX, toY - fromY) < 4) return;
    context.beginPath();
    context.moveTo(fromX, fromY);
    context.lineTo(toX, toY);
    pen.stroke(pen.colours.accents[3], 2.4);
    pen.arrowHead(toX, toY, Math.atan2(toY - fromY, toX - fromX), pen.colours.accents[3]);
    pen.circle(x0, y0, 3, pen.colours.surface, pen.colours.accents[3], 1.6);
  }

  private drawTrace(trace: Float64Array): void {
    const { pen, pose, context } = this;
    const { rotors, carrier } = this.machine.drawing;
    if (trace.length < 4) return;
    const [a, b] = [pose.length(rotors[0]!.x), pose.length(rotors[0]!.y)];
    let [restX, restY] = [0, 0];
    for (const { label, rest } of carrier) {
      if (label === "x") restX += pose.length(rest);
      if (label === "y") restY += pose.length(rest);
      if (label === "r") {
        restX -= b * pose.length(rest);
        restY += a * pose.length(rest);
      }
    }
    context.beginPath();
    for (let i = 0; i + 1 < trace.length; i += 2) {
      const x = a + pose.magnification * (trace[i]! - restX);
      const y = b + pose.magnification * (trace[i + 1]! - restY);
      if (i === 0) context.moveTo(pen.px(x, y), pen.py(x, y));
      else context.lineTo(pen.px(x, y), pen.py(x, y));
    }
    pen.stroke(pen.colours.accents[3], 1.6);
  }

  /** Lengths to compare with: of the machine, and of the magnified motion. */
  private drawRuler(): void {
    const { pen } = this;
    const { ink, muted, accents } = pen.colours;
    const y = this.canvas.clientHeight - 14;
    if (!this.machine.drawing.to_scale) {
      pen.text("not to scale", BORDER, y, muted, 12, "left", null);
      return;
    }
    const { magnification } = this.view;
    if (this.magnificationOfRuler !== magnification) {
      this.magnificationOfRuler = magnification;
      const motion = roundDown((RULER * this.unit) / magnification);
      this.motionLength = motion * magnification;
      this.motionRuler = `motion: ${lengthText(motion)}`;
    }
    const end = this.bar(BORDER, y, roundDown(RULER * this.unit), this.ruler, ink);
    if (magnification !== 1 && this.machine.drawing.carrier.length > 0) this.bar(end + 18, y, this.motionLength, this.motionRuler, accents[3]);
  }

  private bar(x: number, y: number, length: number, words: string, colour: string): number {
    const { context, pen } = this;
    const end = x + length * pen.scale;
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y + 4);
    context.moveTo(x, y);
    context.lineTo(end, y);
    context.moveTo(end, y - 4);
    context.lineTo(end, y + 4);
    pen.stroke(colour, 1.6);
    pen.text(words, end + 6, y, colour, 12, "left", null);
    return end + 6 + context.measureText(words).width;
  }
}

/** A length in m as text. */
function lengthText(length: number): string {
  const number = (value: number): string => String(Number(value.toPrecision(3)));
  if (length >= 1) return `${number(length)} m`;
  return length >= 1e-3 ? `${number(1e3 * length)} mm` : `${number(1e6 * length)} µm`;
}
