/** The verdict of the file's run. It is Python's: once anything has moved, nothing is judged. */

import { element } from "./dom.ts";

export class VerdictLine {
  readonly root: HTMLElement;
  private readonly _verdict: readonly [string, string] | null;

  constructor(verdict: readonly [string, string] | null) {
    this._verdict = verdict;
    this.root = element("p", { class: "verdict", role: "status" });
    this.show(true);
  }

  /** isOriginal: whether the run is that of the file. */
  show(isOriginal: boolean) {
    const verdict = isOriginal ? this._verdict : null;
    const words =
      verdict?.[1] ?? (isOriginal ? "this page was written without a verdict: wucht run gives it" : "values have changed");
    this.setVerdict(verdict?.[0] ?? null, words);
  }

  /** A label, null where nothing is judged, and a sentence. */
  setVerdict(label: string | null, sentence: string) {
    this.root.classList.toggle("judged", label !== null);
    this.root.replaceChildren(element("strong", {}, label ?? "not judged"), ` – ${sentence}`);
  }
}
