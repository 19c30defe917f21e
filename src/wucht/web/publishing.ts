/** What is shown, for others: a server that judges it, and the page around this one. */

import { Debounced } from "./debounce.ts";
import { Judge } from "./judge.ts";
import type { Contents } from "./page_data.ts";
import type { Scenario } from "./scenario.ts";
import { isStudy, studyText } from "./study_text.ts";
import type { VerdictLine } from "./verdict_line.ts";

/** In ms, between two messages to the page around this one. */
const PAUSE = 100;
const NO_STUDY = "only study files are judged: they cannot hold changes during the run, or a motor that is off";

export class Publishing {
  private readonly _contents: Contents;
  private readonly _original: Scenario;
  private readonly _verdict: VerdictLine;
  private readonly _judge: Judge | null;
  private readonly _message: Debounced<string> | null;

  constructor(contents: Contents, original: Scenario, verdict: VerdictLine) {
    const { server, is_embedded: isEmbedded } = contents.page.text;
    this._contents = contents;
    this._original = original;
    this._verdict = verdict;
    this._judge = server === null ? null : new Judge(server, (label, sentence) => verdict.setVerdict(label, sentence));
    this._message = isEmbedded ? new Debounced(PAUSE, (study) => parent.postMessage({ wucht: "study", study }, "*")) : null;
  }

  /** Another scenario is shown. isJudged: whether its verdict is known. */
  show(scenario: Scenario, isJudged: boolean) {
    this._judge?.cancel();
    const { machine, page } = this._contents;
    if ((this._judge === null && this._message === null) || page.text.reason !== "") return;
    const text = studyText(scenario, this._original, machine, page);
    this._message?.call(text);
    if (this._judge === null || isJudged) return;
    if (isStudy(scenario, page)) {
      this._verdict.setVerdict(null, "wucht is judging this run …");
      this._judge.ask(text);
    } else this._verdict.setVerdict(null, NO_STUDY);
  }
}
