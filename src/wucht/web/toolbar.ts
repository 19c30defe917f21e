/** A link, the study file and a picture to take away; and measured values to be laid over the curves. */

import { button, element } from "./dom.ts";
import { FileError, readMeasured, type MeasuredCurve } from "./measured.ts";
import type { PageData } from "./page_data.ts";

const LARGEST = 50e6;
const LINK_COPIED =
  location.protocol === "file:"
    ? "Link copied: it works where this file lies at the same place."
    : "Link copied: it opens this machine with these values at this time.";
const STUDY_COPIED = "Study file copied: save it, and run it with wucht run.";
const PART_COPIED =
  "Study file copied. Changes during the run and motors that are off are comments in it: " +
  "wucht run computes the run without them.";
const COLUMNS = "A CSV file: a column time (s), and columns named as the curves, each with its unit";

/** isWhole: whether all that is shown is in the study file. */
export interface Study {
  readonly text: string;
  readonly isWhole: boolean;
}

export interface ToolbarActions {
  link(): string;
  study(): Study;
  picture(): void;
  measured(curves: readonly MeasuredCurve[]): void;
}

export class Toolbar {
  readonly root: HTMLElement;
  private readonly _message: HTMLElement;
  private readonly _text: HTMLTextAreaElement;
  private readonly _page: PageData;
  private readonly _actions: ToolbarActions;

  constructor(actions: ToolbarActions, page: PageData) {
    this._actions = actions;
    this._page = page;
    this._message = element("p", { class: "message", role: "status" });
    this._text = element("textarea", { readonly: true, hidden: true, rows: 8, "aria-label": "text to copy" });
    const file = element("input", { type: "file", accept: ".csv,.txt,text/csv", id: "measured", class: "visually-hidden" });
    file.addEventListener("change", () => {
      const [chosen] = file.files ?? [];
      if (chosen) void this._read(chosen);
      file.value = "";
    });
    this.root = element(
      "section",
      { class: "toolbar", "aria-label": "copy, save, add" },
      element(
        "div",
        { class: "buttons" },
        // A frame of another page has no address to which a link could lead.
        ...(page.text.is_embedded
          ? []
          : [button("Copy link", () => void this._copy(actions.link(), LINK_COPIED))]),
        button("Copy study file", () => this._copyStudy()),
        button("Save picture", () => actions.picture()),
        element(
          "label",
          { for: "measured", class: "button", tabindex: 0, role: "button", title: COLUMNS },
          "Add measured data…",
        ),
      ),
      file,
      this._message,
      this._text,
    );
    this.root.querySelector("label")!.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      file.click();
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      const [dropped] = event.dataTransfer?.files ?? [];
      if (dropped) void this._read(dropped);
    });
  }

  /** Show a sentence below the buttons. */
  showMessage(sentence: string) {
    this._message.textContent = sentence;
  }

  private _copyStudy() {
    const { reason } = this._page.text;
    if (reason !== "") return this.showMessage(reason);
    const { text, isWhole } = this._actions.study();
    void this._copy(text, isWhole ? STUDY_COPIED : PART_COPIED);
  }

  private async _copy(text: string, sentence: string) {
    this._text.hidden = true;
    try {
      await navigator.clipboard.writeText(text);
      this.showMessage(sentence);
    } catch {
      this._text.value = text;
      this._text.hidden = false;
      this._text.select();
      this.showMessage("This browser does not let the page copy: the text is selected below, press Ctrl-C.");
    }
  }

  private async _read(file: File) {
    try {
      if (file.size > LARGEST) throw new FileError("it is larger than 50 MB.");
      const curves = readMeasured(await file.text(), this._page.panels);
      this._actions.measured(curves);
      this.showMessage(`${file.name}: ${curves.map((curve) => curve.name).join(", ")} over the curves.`);
    } catch (error) {
      if (!(error instanceof FileError)) throw error;
      this.showMessage(`${file.name}: ${error.message}`);
    }
  }
}
