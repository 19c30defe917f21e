/** The page: one scenario, its course, the time that is shown, and what draws them. */

import { ChangeList } from "./change_list.ts";
import { Clock, suggestedSpeed } from "./clock.ts";
import type { Computer } from "./compute.ts";
import { overlapSentence } from "./contacts.ts";
import { ControlColumn } from "./control_column.ts";
import { sentenceOf, type Course } from "./course.ts";
import { CurvePanel } from "./curves.ts";
import { element } from "./dom.ts";
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
import { Stage } from "./stage.ts";
import { isStudy, studyText } from "./study_text.ts";
import { Toolbar } from "./toolbar.ts";
import { VerdictLine } from "./verdict_line.ts";

/** Of the run: changes of one parameter that are nearer are one. */
const MERGE = 1 / 500;

export class LivePage {
  readonly root: HTMLElement;
  private readonly _contents: Contents;
  private readonly _original: Scenario;
  private readonly _clock: Clock;
  private readonly _computer: Computer;
  private readonly _stage: Stage;
  private readonly _levels: Levels;
  private readonly _verdict: VerdictLine;
  private readonly _publishing: Publishing;
  private readonly _column: ControlColumn;
  private readonly _toolbar: Toolbar;
  private readonly _changes: ChangeList;
  private readonly _curves: HTMLElement;
  private readonly _warning = element("p", { class: "warning", role: "status" });
  private _panels: CurvePanel[] = [];
  private _measured: readonly MeasuredCurve[] = [];
  private _scenario: Scenario;
  private _course: Course | null = null;
  private _overlap = "";

  constructor(contents: Contents, original: Scenario, computer: Computer) {
    const { machine, page } = contents;
    this._contents = contents;
    this._original = this._scenario = original;
    this._computer = computer;
    this._clock = new Clock(() => this._draw());
    this._clock.end = page.until;
    this._clock.speed = suggestedSpeed(page.turn);
    this._levels = new Levels(contents);
    this._stage = new Stage(contents, this._clock, {
      redraw: () => this._draw(),
      switchMotor: (index) => this._switch(index),
      release: (state) => this._release(state),
    });
    this._verdict = new VerdictLine(page.text.verdict);
    this._publishing = new Publishing(contents, this._original, this._verdict);
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
    const middle = [this._warning, this._changes.root, this._curves];
    const side = [this._column.root, this._toolbar.root];
    this.root = pageLayout(machine.title, page, this._verdict.root, this._stage.elements, middle, side);
    this._buildCurves();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this._buildCurves());
    new ResizeObserver(() => this._fit()).observe(this._curves);
    addEventListener("hashchange", () => this._readLink());
    if (location.hash.length > 1) this._readLink();
    else this._change(this._original);
    computer.listen((course) => this._receive(course));
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

  /** A part was dragged: the machine goes on from another state. */
  private _release(state: Float64Array) {
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
    this._stage.show(course);
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
    const shown = this._stage.draw(this._scenario);
    if (shown !== null) for (const panel of this._panels) panel.move(shown.time, shown.state, shown.outputs);
  }

  private _link(): string {
    const shown = { scenario: this._scenario, time: this._clock.time, stroboscopic: this._stage.isStroboscopic };
    const text = linkText(shown, this._original, this._contents.machine);
    history.replaceState(null, "", `#${text}`);
    return location.href;
  }

  private _readLink() {
    try {
      const shown = readLink(location.hash.slice(1), this._original, this._contents.machine);
      this._stage.isStroboscopic = shown.stroboscopic;
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
    const lines = [this._verdict.root.textContent ?? "", this._stage.description];
    const drawings = [...this.root.querySelectorAll<HTMLCanvasElement>(".stage canvas")];
    savePicture(
      paintedSheet({ title: machine.title, lines, drawings, curves, surface: paper.surface, ink: paper.ink }),
      "machine.png",
    );
  }
}
