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
      verdict?.[1] ?? (isOriginal ? "wucht judges the run of a file: wucht run" : "the run is no longer that of the file");
    this.tell(verdict?.[0] ?? null, words);
  }

  /** A label, null where nothing is judged, and a sentence. */
  tell(label: string | null, sentence: string) {
    this.root.classList.toggle("judged", label !== null);
    this.root.replaceChildren(element("strong", {}, label ?? "not judged"), ` – ${sentence}`);
  }
}
