/** A machine, drawn and moving; its parts can be grabbed. */

import { fitCanvas, Theme } from "./colours.ts";
import { drawDeckOrbits, hasDeck, type Orbits } from "./deck.ts";
import type { DrawnMachine } from "./drawing_data.ts";
import { Grip, type Part } from "./grip.ts";
import { Pose } from "./pose.ts";
import { drawAxis, drawBody, drawDisc, drawSlider, SMALLEST_BALL } from "./rotors.ts";
import { ScaleBars } from "./scale_bars.ts";
import { Pen } from "./shapes.ts";
import { drawAttachment, drawFixture, drawMount, drawPivot } from "./supports.ts";
import { BORDER, Viewport } from "./viewport.ts";

export type { Part } from "./grip.ts";

/** magnification: of the carrier's motion. */
export interface View {
  readonly stroboscopic: boolean;
  readonly magnification: number;
}

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
  private readonly viewport: Viewport;
  private readonly scaleBars = new ScaleBars();
  private view: View = { stroboscopic: false, magnification: 1 };
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
    this.viewport = new Viewport(this.pose);
  }

  /**
   * Draw the machine.
   *
   * outputs: in the machine's order, or empty. trace: the orbits of the main rotor's axis and of the deck, drawn from where
   * these are at rest, magnified as the carrier's motion. In the stroboscopic view, which turns with the main rotor, they
   * are left out with all that stands still.
   */
  draw(
    time: number, state: ArrayLike<number>, outputs: ArrayLike<number>, parameters: ArrayLike<number>, view: View,
    trace: Orbits | null,
  ): void {
    void time;
    this.view = view;
    this.pen.colours = this.theme.current;
    if (!fitCanvas(this.canvas, this.context)) return;
    this.pose.update(state, outputs, parameters, view.magnification);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.context.clearRect(0, 0, width, height);
    this.context.lineCap = "round";
    this.context.lineJoin = "round";
    if (view.stroboscopic) {
      this.viewport.showRotor(this.pen, width, height);
      this.drawRotating(state);
    } else {
      this.viewport.showWhole(this.pen, width, height);
      this.drawSupports();
      this.drawCarrier();
      this.drawRotors(state);
      if (trace !== null) {
        this.drawTrace(trace.axis);
        drawDeckOrbits(this.pen, this.pose, trace.deck);
      }
      this.drawScale(height);
    }
    this.isEnlarged = this.hasEnlargedBall();
  }

  /** See `Viewport`. */
  suggestedMagnification(largestAmplitude: number): number {
    return this.viewport.suggestedMagnification(largestAmplitude);
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
  stateWithPartAt(part: Part, x: number, y: number, state: ArrayLike<number>): Float64Array {
    return this.grip.stateWithPartAt(part, x, y, state);
  }

  /** What the drawing shows, as its caption. */
  get description(): string {
    const { to_scale: toScale, rotors, carrier } = this.machine.drawing;
    const { stroboscopic, magnification } = this.view;
    const sizes = toScale ? "Places, tracks and arms drawn to scale" : "Schematic, not to scale";
    const motion = `${sizes}; motion of the carrier magnified ${magnification} times`;
    const sentences = [carrier.length === 0 || !toScale || magnification === 1 ? sizes : motion];
    if (hasDeck(this.machine.drawing) && !stroboscopic) sentences.push("orbits of the carrier's ends and centre of mass");
    if (this.isEnlarged) sentences.push("balls drawn larger than they are");
    if (stroboscopic) sentences.push(`seen turning with ${rotors[0]!.name}; arrow: displacement of its axis`);
    return `${sentences.join("; ")}.`;
  }

  private hasEnlargedBall(): boolean {
    const { pose, pen } = this;
    const { bodies } = this.machine.drawing;
    return bodies.some((body) => pose.length(body.size) > 0 && pose.length(body.size) * pen.scale < SMALLEST_BALL);
  }

  private drawSupports(): void {
    const { pen, pose } = this;
    const { unit } = this.viewport;
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
    const rounding = 0.05 * this.viewport.unit * pen.scale;
    context.save();
    context.translate(pen.pixelX(pose.placeX(l, t), pose.placeY(l, t)), pen.pixelY(pose.placeX(l, t), pose.placeY(l, t)));
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
    const [fromX, fromY, toX, toY] = [pen.pixelX(x0, y0), pen.pixelY(x0, y0), pen.pixelX(x, y), pen.pixelY(x, y)];
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
      if (i === 0) context.moveTo(pen.pixelX(x, y), pen.pixelY(x, y));
      else context.lineTo(pen.pixelX(x, y), pen.pixelY(x, y));
    }
    pen.stroke(pen.colours.accents[3], 1.6);
  }

  private drawScale(height: number): void {
    const { pen } = this;
    const y = height - BORDER;
    const { to_scale: isToScale, carrier } = this.machine.drawing;
    const magnification = carrier.length > 0 ? this.view.magnification : 1;
    if (isToScale) this.scaleBars.draw(pen, BORDER, y, this.viewport.unit, magnification);
    else pen.text("not to scale", BORDER, y, pen.colours.muted, 12, "left", null);
  }
}
