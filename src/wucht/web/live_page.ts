/** The page: one scenario, its course, the time that is shown, and what draws them. */

import { ChangeList } from "./change_list.ts";
import { Clock, suggestedSpeed } from "./clock.ts";
import type { Computer } from "./compute.ts";
import { overlapSentence } from "./contacts.ts";
import { ControlColumn } from "./control_column.ts";
import { Instant, sentenceOf, type Course } from "./course.ts";
import { CurvePanel } from "./curves.ts";
import { button, element } from "./dom.ts";
import { MachineDrawing, type View } from "./drawing.ts";
import { enableDragging } from "./grabbing.ts";
import { pageLayout } from "./layout.ts";
import { Levels } from "./levels.ts";
import { LinkError, linkText, readLink } from "./link.ts";
import type { MeasuredCurve } from "./measured.ts";
import type { Contents, StartControl } from "./page_data.ts";
import { paperOf } from "./paper.ts";
import { paintedSheet, savePicture } from "./picture.ts";
import { Publishing } from "./publishing.ts";
import {
  areEqual,
  parametersAt,
  withStartValues,
  withStateAt,
  withValuesFrom,
  type Scenario,
} from "./scenario.ts";
import { isStudy, studyText } from "./study_text.ts";
import { Toolbar } from "./toolbar.ts";
import { TorqueHill } from "./torque_hill.ts";
import { Trails } from "./trails.ts";
import { Transport } from "./transport.ts";
import { VerdictLine } from "./verdict_line.ts";

/** Of the run: changes of one parameter that are nearer are one. */
const MERGE = 1 / 500;
const DRAG = "Drag a body, the rotor or the carrier.";

export class LivePage {
  readonly root: HTMLElement;
  private readonly _contents: Contents;
  private readonly _original: Scenario;
  private readonly _clock: Clock;
  private readonly _computer: Computer;
  private readonly _instant: Instant;
  private readonly _drawing: MachineDrawing;
  private readonly _canvas: HTMLCanvasElement;
  private readonly _hill: TorqueHill;
  private readonly _trails: Trails;
  private readonly _levels: Levels;
  private readonly _transport: Transport;
  private readonly _verdict: VerdictLine;
  private readonly _publishing: Publishing;
  private readonly _column: ControlColumn;
  private readonly _toolbar: Toolbar;
  private readonly _changes: ChangeList;
  private readonly _curves: HTMLElement;
  private readonly _caption = element("figcaption");
  private readonly _warning = element("p", { class: "warning", role: "status" });
  private readonly _switches: HTMLButtonElement[];
  private readonly _strobe = element("input", { type: "checkbox" });
  private _panels: CurvePanel[] = [];
  private _measured: readonly MeasuredCurve[] = [];
  private _scenario: Scenario;
  private _course: Course | null = null;
  private _held: Float64Array | null = null;
  private _hasDragged = false;
  private _magnification = 1;
  private _overlap = "";

  constructor(contents: Contents, original: Scenario, computer: Computer) {
    const { machine, page } = contents;
    this._contents = contents;
    this._original = this._scenario = original;
    this._computer = computer;
    this._clock = new Clock(() => this._draw());
    this._clock.end = page.until;
    this._clock.speed = suggestedSpeed(page.turn);
    this._instant = new Instant(machine);
    this._trails = new Trails(contents);
    this._levels = new Levels(contents);
    this._canvas = element("canvas", { class: "drawing", role: "img", "aria-label": "the machine, moving" });
    this._drawing = new MachineDrawing(this._canvas, machine);
    const hill = element("div", { class: "hill" });
    this._hill = new TorqueHill(hill, machine);
    this._transport = new Transport(this._clock, machine.time_unit);
    this._verdict = new VerdictLine(page.text.verdict);
    this._publishing = new Publishing(contents, this._original, this._verdict);
    this._switches = page.switches.map(({ name, index }) =>
      button(`Motor of ${name}`, () => this._switch(index), { class: "switch", role: "switch", "aria-checked": "true" }),
    );
    this._strobe.addEventListener("change", () => this._draw());
    this._curves = element("section", { class: "curves", "aria-label": "curves over time" });
    this._column = new ControlColumn(page, this._scenario, machine.time_unit, {
      parameter: (control, value) => this._set(control.indices, value),
      start: (control, value) => this._start(control, value),
      until: (value) => this._change({ ...this._scenario, until: value }),
      reset: () => this._change(this._original),
    });
    this._changes = new ChangeList(contents, (scenario) => this._change(scenario));
    this._toolbar = new Toolbar(
      {
        link: () => this._link(),
        study: () => ({
          text: studyText(this._scenario, this._original, machine, page),
          isWhole: isStudy(this._scenario, page),
        }),
        picture: () => this._picture(),
        measured: (curves) => {
          this._measured = curves;
          this._showCourse();
        },
      },
      page,
    );
    this.root = this._layout(hill);
    let wasPlaying = false;
    enableDragging(this._canvas, this._drawing, {
      state: () => this._instant.state,
      take: () => {
        wasPlaying = this._clock.isPlaying;
        this._clock.pause();
      },
      hold: (state) => {
        this._held = state;
        this._draw();
      },
      release: (state) => {
        this._release(state);
        if (wasPlaying) this._clock.play();
      },
    });
    this._buildCurves();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this._buildCurves());
    new ResizeObserver(() => this._fit()).observe(this._curves);
    new ResizeObserver(() => this._draw()).observe(this._canvas);
    addEventListener("hashchange", () => this._readLink());
    if (location.hash.length > 1) this._readLink();
    else this._change(this._original);
    computer.listen((course) => this._receive(course));
  }

  private _layout(hill: HTMLElement): HTMLElement {
    const { machine, page } = this._contents;
    const turning = element("label", { class: "check" }, this._strobe, "rotate the view with the rotor");
    const stage = [
      element("figure", {}, this._canvas, this._caption),
      this._transport.root,
      element("div", { class: "views" }, ...this._switches, turning, ...this._hillChoice()),
      ...(this._hill.available ? [hill] : []),
    ];
    const middle = [this._warning, this._changes.root, this._curves];
    return pageLayout(machine.title, page, this._verdict.root, stage, middle, [this._column.root, this._toolbar.root]);
  }

  /** Of several driven rotors, that of the hill. */
  private _hillChoice(): HTMLElement[] {
    const { rotors } = this._hill;
    const select = (name: string) => {
      this._hill.select(name);
      this._trails.select(name);
      this._draw();
    };
    if (rotors[0] !== undefined) select(rotors[0]);
    if (rotors.length < 2) return [];
    const choice = element("select", {}, ...rotors.map((name) => element("option", {}, name)));
    choice.addEventListener("change", () => select(choice.value));
    return [element("label", { class: "check" }, "torques at rotor", choice)];
  }

  private _buildCurves() {
    for (const panel of this._panels) panel.destroy();
    const { machine, page } = this._contents;
    const timeName = machine.time_unit === "" ? "time τ" : `time (${machine.time_unit})`;
    const last = page.panels.length - 1;
    this._panels = page.panels.map((panel, i) => new CurvePanel(panel, timeName, i === last, (time) => this._clock.move(time)));
    this._curves.replaceChildren(...this._panels.map((panel) => panel.root));
    this._showCourse();
    this._fit();
  }

  private _fit() {
    for (const panel of this._panels) panel.fit();
    this._draw();
  }

  /** A parameter gets a value, from the start or from now. */
  private _set(indices: readonly number[], value: number) {
    const { time } = this._clock;
    const isFromNow = this._column.isFromNow && time > 0;
    const merge = MERGE * this._scenario.until;
    this._change(
      isFromNow ? withValuesFrom(this._scenario, time, indices, value, merge) : withStartValues(this._scenario, indices, value),
      false,
    );
  }

  private _switch(index: number) {
    const { time } = this._clock;
    const value = parametersAt(this._scenario, time)[index] === 0 ? 1 : 0;
    this._change(
      time > 0 ? withValuesFrom(this._scenario, time, [index], value, 0) : withStartValues(this._scenario, [index], value),
    );
  }

  /** A start value; what is measured from this state moves with it. */
  private _start(control: StartControl, value: number) {
    const start = [...this._scenario.start];
    const head = control.head === null ? 0 : start[control.head]!;
    const before = start[control.index]!;
    start[control.index] = value + control.offset + head;
    const followers = this._contents.page.start.flatMap((group) => group.controls).filter((one) => one.head === control.index);
    for (const one of followers) start[one.index] = start[one.index]! - before + start[control.index]!;
    const overlap = overlapSentence(this._contents.machine, this._scenario.parameters, Float64Array.from(start));
    if (overlap === "") this._change({ ...this._scenario, start }, false);
    else this._change(this._scenario);
    this._overlap = overlap;
    this._warn();
  }

  private _release(state: Float64Array | null) {
    this._held = null;
    this._hasDragged = true;
    if (state === null) return this._draw();
    const { time } = this._clock;
    const values = Array.from(state, (x) => x + 0);
    this._change(time > 0 ? withStateAt(this._scenario, time, values) : { ...this._scenario, start: values });
  }

  /** Another scenario. isShown: whether its values are to be shown by the controls, which did not give them. */
  private _change(scenario: Scenario, isShown = true) {
    this._overlap = "";
    this._scenario = scenario;
    this._clock.end = scenario.until;
    const isOriginal = areEqual(scenario, this._original);
    this._verdict.show(isOriginal);
    this._publishing.show(scenario, isOriginal && this._contents.page.text.verdict !== null);
    this._changes.show(scenario);
    if (isShown) this._column.show(scenario, parametersAt(scenario, this._column.isFromNow ? this._clock.time : 0));
    this._computer.compute(scenario);
  }

  private _receive(course: Course) {
    this._course = course;
    const place = this._contents.machine.outputs.findIndex((output) => output.name === "amplitude");
    this._magnification = this._drawing.suggestedMagnification(this._trails.largest(course, place));
    this._warn();
    this._showCourse();
    this._draw();
    const { dataset } = document.documentElement;
    const kind = course.isPreview ? "previews" : "courses";
    dataset[kind] = String(Number(dataset[kind] ?? 0) + 1);
  }

  private _warn() {
    const sentence = this._course === null ? "" : sentenceOf(this._course, this._contents.machine.time_unit);
    this._warning.textContent = this._overlap || sentence;
  }

  private _showCourse() {
    const { page } = this._contents;
    const course = this._course;
    if (course === null) return;
    const end = course.scenario.until;
    const levels = this._levels.at(parametersAt(course.scenario, end), Math.max(end, page.until));
    for (const [i, panel] of this._panels.entries()) {
      panel.show(
        course,
        page.panels[i]!.title === "speed" ? levels : [],
        this._measured.filter((curve) => curve.panel === i),
      );
    }
  }

  private _draw() {
    const course = this._course;
    if (course === null) return this._drawStart();
    const time = Math.min(this._clock.time, course.time[course.time.length - 1]!);
    this._instant.move(course, time);
    const { outputs, parameters } = this._instant;
    const state = this._held ?? this._instant.state;
    const view: View = { stroboscopic: this._strobe.checked, magnification: this._magnification };
    this._trails.move(course, time, this._instant);
    this._drawing.draw(time, state, this._held ? [] : outputs, parameters, view, this._held ? null : this._trails.orbit);
    this._caption.textContent = `${this._drawing.description}${this._hasDragged ? "" : ` ${DRAG}`}`;
    if (this._hill.available) this._hill.draw(parameters, this._trails.speeds, this._trails.torques, time, state);
    for (const panel of this._panels) panel.move(time, state, outputs);
    for (const [i, one] of this._contents.page.switches.entries()) {
      this._switches[i]!.setAttribute("aria-checked", String(parameters[one.index] !== 0));
    }
    this._transport.show();
  }

  /** The machine before its first course is there. */
  private _drawStart() {
    const { start, parameters } = this._scenario;
    this._drawing.draw(0, start, [], parameters, { stroboscopic: false, magnification: this._magnification }, null);
  }

  private _link(): string {
    const shown = { scenario: this._scenario, time: this._clock.time, stroboscopic: this._strobe.checked };
    const text = linkText(shown, this._original, this._contents.machine);
    history.replaceState(null, "", `#${text}`);
    return location.href;
  }

  private _readLink() {
    try {
      const shown = readLink(location.hash.slice(1), this._original, this._contents.machine);
      this._strobe.checked = shown.stroboscopic;
      this._clock.end = shown.scenario.until;
      this._clock.move(shown.time);
      this._change(shown.scenario);
    } catch (error) {
      if (!(error instanceof LinkError)) throw error;
      this._toolbar.showMessage(error.message);
      this._change(this._original);
    }
  }

  private _picture() {
    const { machine } = this._contents;
    const paper = paperOf(document.documentElement);
    const curves = this._panels.map((panel) => ({ title: panel.title, canvas: panel.canvas }));
    const lines = [this._verdict.root.textContent ?? "", this._drawing.description];
    const drawings = [...this.root.querySelectorAll<HTMLCanvasElement>(".stage canvas")];
    savePicture(
      paintedSheet({ title: machine.title, lines, drawings, curves, surface: paper.surface, ink: paper.ink }),
      "machine.png",
    );
  }
}
