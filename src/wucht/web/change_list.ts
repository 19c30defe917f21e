/** What the hand has changed during the run, each with its time, and a button to take it back. */

import { button, element } from "./dom.ts";
import { numberText, quantityText } from "./numbers.ts";
import type { Contents } from "./page_data.ts";
import type { Change, Scenario } from "./scenario.ts";

/** So many are listed one by one. */
const MOST = 6;

export class ChangeList {
  readonly root = element("ul", { class: "changes", "aria-label": "changes during the run" });
  private readonly _contents: Contents;
  private readonly _undo: (scenario: Scenario) => void;

  /** undo: receives the scenario without a change. */
  constructor(contents: Contents, undo: (scenario: Scenario) => void) {
    this._contents = contents;
    this._undo = undo;
  }

  /** Show the changes of a scenario. */
  show(scenario: Scenario) {
    const { changes } = scenario;
    const rows = changes.slice(0, MOST).map((change) => {
      const words = this._words(change);
      const without = () => this._undo({ ...scenario, changes: changes.filter((other) => other !== change) });
      return element("li", {}, words, button("×", without, { "aria-label": `take back: ${words}` }));
    });
    if (changes.length > MOST) rows.push(element("li", {}, `and ${changes.length - MOST} more`));
    this.root.replaceChildren(...rows);
  }

  private _words(change: Change): string {
    const { machine, page } = this._contents;
    const at = `${numberText(change.time)} ${machine.time_unit}`.trim();
    const controls = page.groups.flatMap((group) => group.controls.map((control) => ({ control, title: group.title })));
    const parts = change.parameters.flatMap(([index, value]) => {
      const motor = page.switches.find((one) => one.index === index);
      if (motor) return [`motor of ${motor.name} ${value === 0 ? "off" : "on"}`];
      const place = controls.find(({ control }) => control.indices[0] === index);
      if (place === undefined) return [];
      const { control, title } = place;
      return [`${lowerFirst(title)}, ${control.name} ${quantityText(value / control.size, control.unit)}`];
    });
    return `${at}: ${[...parts, ...(change.state ? ["dragged"] : [])].join(", ")}`;
  }
}

function lowerFirst(text: string): string {
  return text.charAt(0).toLowerCase() + text.slice(1);
}
