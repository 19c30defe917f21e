/** The judge is Python, at a server: it is asked for a verdict on what is shown, after a pause; the newest question wins. */

import { Debounced } from "./debounce.ts";
import { tokenHeaders } from "./session.ts";

/** In ms. */
const PAUSE = 40;
const SUPERSEDED = "wucht judges one run at a time, and another page needed a verdict: change a value to try again";
const NO_ANSWER = "no answer from `wucht app`: is it still running?";

interface Answer {
  readonly label?: string;
  readonly sentence?: string;
  readonly error?: string;
  readonly superseded?: boolean;
}

/** A verdict: label and sentence. Or null, and why there is none. */
export type Receive = (label: string | null, sentence: string) => void;

export class Judge {
  private readonly _address: string;
  private readonly _receive: Receive;
  private readonly _question: Debounced<string>;
  private _request: AbortController | null = null;

  constructor(address: string, receive: Receive) {
    this._address = address;
    this._receive = receive;
    this._question = new Debounced(PAUSE, (study: string) => void this._send(study));
  }

  /** Ask for a verdict on a study file. */
  ask(study: string) {
    this.cancel();
    this._question.call(study);
  }

  /** The last question is of no interest any longer. */
  cancel() {
    this._question.cancel();
    this._request?.abort();
    this._request = null;
  }

  private async _send(study: string) {
    const request = new AbortController();
    this._request = request;
    let answer: Answer;
    try {
      const response = await fetch(this._address, {
        method: "POST",
        body: study,
        headers: { "content-type": "text/plain; charset=utf-8", ...tokenHeaders() },
        signal: request.signal,
      });
      answer = readAnswer(await response.text(), response.status);
    } catch {
      answer = { error: NO_ANSWER };
    }
    if (request.signal.aborted) return;
    const reason = answer.superseded === true ? SUPERSEDED : (answer.error ?? NO_ANSWER);
    this._receive(answer.label ?? null, answer.sentence ?? reason);
  }
}

/** What a server has answered; what is no JSON is its reason, as of a proxy. */
function readAnswer(text: string, status: number): Answer {
  try {
    return JSON.parse(text) as Answer;
  } catch {
    return { error: `the server answers with status ${status}: ${text.trim() || "nothing more"}` };
  }
}
