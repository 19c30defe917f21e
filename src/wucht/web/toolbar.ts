/** What can be taken along: a link, the study file, a picture; and measured values that are laid over the curves. */

import { button, element } from "./dom.ts";
import { FileError, readMeasured, type MeasuredCurve } from "./measured.ts";
import type { PageData } from "./page_data.ts";

const LARGEST = 50e6;

export interface Takings {
  link(): string;
  study(): string;
  picture(): void;
  measured(curves: readonly MeasuredCurve[]): void;
}

export class Toolbar {
  readonly root: HTMLElement;
  private readonly _message: HTMLElement;
  private readonly _text: HTMLTextAreaElement;
  private readonly _page: PageData;
  private readonly _takings: Takings;

  constructor(takings: Takings, page: PageData) {
    this._takings = takings;
    this._page = page;
    this._message = element("p", { class: "message", role: "status" });
    this._text = element("textarea", { readonly: true, hidden: true, rows: 8, "aria-label": "text to copy" });
    const file = element("input", { type: "file", accept: ".csv,.txt,text/csv", id: "measured", class: "unseen" });
    file.addEventListener("change", () => {
      const [chosen] = file.files ?? [];
      if (chosen) void this._read(chosen);
      file.value = "";
    });
    this.root = element(
      "section",
      { class: "toolbar", "aria-label": "take along" },
      element(
        "div",
        { class: "buttons" },
        // A frame of another page has no address to which a link could lead.
        ...(page.text.is_embedded
          ? []
          : [button("Copy link", () => void this._copy(takings.link(), "The link is copied: it shows what is seen here."))]),
        button("Copy study file", () => this._copyStudy()),
        button("Picture", () => takings.picture(), { title: "Save a picture of what is seen" }),
        element("label", { for: "measured", class: "button", tabindex: 0, role: "button" }, "Measured values…"),
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

  /** Say something about what was asked for. */
  say(sentence: string) {
    this._message.textContent = sentence;
  }

  private _copyStudy() {
    const { reason } = this._page.text;
    if (reason !== "") this.say(reason);
    else void this._copy(this._takings.study(), "The study file is copied: save it, and run it with wucht.");
  }

  private async _copy(text: string, sentence: string) {
    this._text.hidden = true;
    try {
      await navigator.clipboard.writeText(text);
      this.say(sentence);
    } catch {
      this._text.value = text;
      this._text.hidden = false;
      this._text.select();
      this.say("This browser lets no page copy: the text is selected below.");
    }
  }

  private async _read(file: File) {
    try {
      if (file.size > LARGEST) throw new FileError("it is larger than 50 MB.");
      const curves = readMeasured(await file.text(), this._page.panels);
      this._takings.measured(curves);
      this.say(`${file.name}: ${curves.map((curve) => curve.name).join(", ")} over the curves.`);
    } catch (error) {
      if (!(error instanceof FileError)) throw error;
      this.say(`${file.name}: ${error.message}`);
    }
  }
}
