/** The sliders: parameters by part, the initial state, the duration; and whether they change values from t = 0. */

import { button, element } from "./dom.ts";
import type { Control, Group, PageData, StartControl } from "./page_data.ts";
import { SliderField, type Scale } from "./controls.ts";
import { startValue } from "./study_text.ts";
import type { Scenario } from "./scenario.ts";

export interface ControlActions {
  parameter(control: Control, value: number): void;
  start(control: StartControl, value: number): void;
  until(value: number): void;
  reset(): void;
}

export class ControlColumn {
  readonly root: HTMLElement;
  private readonly _parameters: [Control, SliderField][] = [];
  private readonly _starts: [StartControl, SliderField][] = [];
  private readonly _until: SliderField;
  private readonly _fromShown: HTMLInputElement;

  constructor(page: PageData, scenario: Scenario, timeUnit: string, actions: ControlActions) {
    const groups = page.groups.map((group, i) =>
      this._group(group, i === 0, (control) => this._parameter(control, scenario, actions)),
    );
    const start = page.start.map((group) => this._group(group, false, (control) => this._start(control, scenario, actions)));
    const until: Scale = {
      name: "duration of the run",
      unit: timeUnit,
      size: 1,
      bottom: page.until / 10,
      top: 2 * page.until,
      logarithmic: true,
      low: 0,
      high: 100 * page.until,
      open: true,
      whole: false,
    };
    this._until = new SliderField(until, scenario.until, actions.until);
    this._fromShown = element("input", { type: "radio", name: "from", value: "now" });
    const begin = element("input", { type: "radio", name: "from", value: "start", checked: true });
    this.root = element(
      "aside",
      { class: "controls", "aria-label": "what can be moved" },
      element(
        "fieldset",
        { class: "from" },
        element("legend", {}, "A slider changes the value"),
        element("label", {}, begin, "from t = 0"),
        element("label", {}, this._fromShown, "from the time shown"),
      ),
      ...groups,
      element("details", { class: "start" }, element("summary", {}, "initial state"), ...start),
      element("details", {}, element("summary", {}, "duration"), this._until.root),
      button("Reset to the file’s values", actions.reset, { class: "reset" }),
    );
  }

  /** Whether a slider changes the value from the time that is shown. */
  get isFromNow(): boolean {
    return this._fromShown.checked;
  }

  /** Show the values of a scenario; parameters: those at the time shown, or at the start. */
  show(scenario: Scenario, parameters: readonly number[]) {
    for (const [control, field] of this._parameters) field.set(parameters[control.indices[0]!]!);
    for (const [control, field] of this._starts) field.set(startValue(control, scenario.start));
    this._until.set(scenario.until);
  }

  private _group<T>(group: Group<T>, isOpen: boolean, field: (control: T) => SliderField): HTMLElement {
    const fields = group.controls.map((control) => field(control).root);
    const names = group.over_time ?? [];
    const words = `${names.join(", ")}: ${names.length > 1 ? "follow" : "follows"} the file’s schedule`;
    const note = names.length > 0 ? [element("p", { class: "note" }, words)] : [];
    return element("details", { open: isOpen }, element("summary", {}, group.title), ...fields, ...note);
  }

  private _parameter(control: Control, scenario: Scenario, actions: ControlActions): SliderField {
    const value = scenario.parameters[control.indices[0]!]!;
    const field = new SliderField(control, value, (moved) => actions.parameter(control, moved));
    this._parameters.push([control, field]);
    return field;
  }

  private _start(control: StartControl, scenario: Scenario, actions: ControlActions): SliderField {
    const scale: Scale = { ...control, logarithmic: false, low: null, high: null, open: false, whole: false };
    const field = new SliderField(scale, startValue(control, scenario.start), (moved) => actions.start(control, moved));
    this._starts.push([control, field]);
    return field;
  }
}
