/** The machine as it moves: its drawing, in which parts are dragged, the torque hill, the clock, and the motors' switches. */

import type { Clock } from "./clock.ts";
import { Instant, type Course } from "./course.ts";
import { button, element } from "./dom.ts";
import { MachineDrawing, type View } from "./drawing.ts";
import { enableDragging } from "./grabbing.ts";
import type { Contents } from "./page_data.ts";
import type { Scenario } from "./scenario.ts";
import { TorqueHill } from "./torque_hill.ts";
import { Trails } from "./trails.ts";
import { Transport } from "./transport.ts";

const DRAG = "Drag a body, the rotor or the carrier.";

export interface StageActions {
  /** Draw the page again. */
  redraw(): void;
  /** Switch a motor on or off; index: of the parameter. */
  switchMotor(index: number): void;
  /** A part was dragged, and let go in another state. */
  release(state: Float64Array): void;
}

/** What is shown of a course at a time. */
export interface ShownInstant {
  readonly time: number;
  readonly state: ArrayLike<number>;
  readonly outputs: ArrayLike<number>;
}

export class Stage {
  readonly elements: readonly HTMLElement[];
  private readonly _contents: Contents;
  private readonly _clock: Clock;
  private readonly _actions: StageActions;
  private readonly _canvas = element("canvas", { class: "drawing", role: "img", "aria-label": "the machine, moving" });
  private readonly _caption = element("figcaption");
  private readonly _drawing: MachineDrawing;
  private readonly _hill: TorqueHill;
  private readonly _transport: Transport;
  private readonly _switches: readonly HTMLButtonElement[];
  private readonly _strobe = element("input", { type: "checkbox" });
  private readonly _instant: Instant;
  private readonly _trails: Trails;
  private _course: Course | null = null;
  private _magnification = 1;
  private _heldState: Float64Array | null = null;
  private _hasDragged = false;

  constructor(contents: Contents, clock: Clock, actions: StageActions) {
    const { machine, page } = contents;
    this._contents = contents;
    this._clock = clock;
    this._actions = actions;
    this._instant = new Instant(machine);
    this._trails = new Trails(contents);
    this._drawing = new MachineDrawing(this._canvas, machine);
    const hill = element("div", { class: "hill" });
    this._hill = new TorqueHill(hill, machine);
    this._transport = new Transport(clock, machine.time_unit);
    this._switches = page.switches.map(({ name, index }) =>
      button(`Motor of ${name}`, () => actions.switchMotor(index), {
        class: "switch",
        role: "switch",
        "aria-checked": "true",
      }),
    );
    this._strobe.addEventListener("change", () => actions.redraw());
    const turning = element("label", { class: "check" }, this._strobe, "rotate the view with the rotor");
    this.elements = [
      element("figure", {}, this._canvas, this._caption),
      this._transport.root,
      element("div", { class: "views" }, ...this._switches, turning, ...this._hillChoice()),
      ...(this._hill.available ? [hill] : []),
    ];
    this._enableDragging();
    new ResizeObserver(() => actions.redraw()).observe(this._canvas);
  }

  /** Whether the view turns with the main rotor. */
  get isStroboscopic(): boolean {
    return this._strobe.checked;
  }

  set isStroboscopic(isStroboscopic: boolean) {
    this._strobe.checked = isStroboscopic;
  }

  /** What the drawing shows, and how. */
  get description(): string {
    return this._drawing.description;
  }

  /** Another course. */
  show(course: Course) {
    this._course = course;
    const place = this._contents.machine.outputs.findIndex((output) => output.name === "amplitude");
    this._magnification = this._drawing.suggestedMagnification(this._trails.largest(course, place));
  }

  /** Draw the time of the clock; return what is shown. Before the first course it is the start of a scenario: null. */
  draw({ start, parameters: startParameters }: Scenario): ShownInstant | null {
    const view: View = { stroboscopic: this._strobe.checked, magnification: this._magnification };
    const course = this._course;
    if (course === null) {
      this._drawing.draw(0, start, [], startParameters, { ...view, stroboscopic: false }, null);
      return null;
    }
    const time = Math.min(this._clock.time, course.time[course.time.length - 1]!);
    this._instant.move(course, time);
    const { outputs, parameters } = this._instant;
    const held = this._heldState;
    const state = held ?? this._instant.state;
    this._trails.move(course, time, this._instant);
    this._drawing.draw(time, state, held ? [] : outputs, parameters, view, held ? null : this._trails.orbit);
    this._caption.textContent = `${this._drawing.description}${this._hasDragged ? "" : ` ${DRAG}`}`;
    if (this._hill.available) this._hill.draw(parameters, this._trails.speeds, this._trails.torques, time, state);
    for (const [i, { index }] of this._contents.page.switches.entries()) {
      this._switches[i]!.setAttribute("aria-checked", String(parameters[index] !== 0));
    }
    this._transport.show();
    return { time, state, outputs };
  }

  /** Of several driven rotors, that of the hill. */
  private _hillChoice(): HTMLElement[] {
    const { rotors } = this._hill;
    const select = (name: string) => {
      this._hill.select(name);
      this._trails.select(name);
    };
    if (rotors[0] !== undefined) select(rotors[0]);
    if (rotors.length < 2) return [];
    const choice = element("select", {}, ...rotors.map((name) => element("option", {}, name)));
    choice.addEventListener("change", () => {
      select(choice.value);
      this._actions.redraw();
    });
    return [element("label", { class: "check" }, "torques at rotor", choice)];
  }

  private _enableDragging() {
    const { _clock: clock, _actions: actions } = this;
    let wasPlaying = false;
    enableDragging(this._canvas, this._drawing, {
      state: () => this._instant.state,
      take: () => {
        wasPlaying = clock.isPlaying;
        clock.pause();
      },
      hold: (state) => {
        this._heldState = state;
        actions.redraw();
      },
      release: (state) => {
        this._heldState = null;
        this._hasDragged = true;
        if (state === null) actions.redraw();
        else actions.release(state);
        if (wasPlaying) clock.play();
      },
    });
  }
}
