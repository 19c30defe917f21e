/**
 * Courses computed in a worker, so that the page answers while a run is computed: the newest scenario wins.
 *
 * Of each scenario there is first a preview, then, where no other scenario has come, the fine run; of quick ones the fine run
 * only.
 */

import { computeCourse, courseInParts, FINE, PREVIEW, type Course } from "./course.ts";
import type { Contents } from "./page_data.ts";
import { areEqual, type Scenario } from "./scenario.ts";

/** ms: after a preview the fine run waits so long for a slider that goes on moving; it then computes so long at a time. */
const [REST, SLICE] = [40, 8];
/** ms: after a fine run that took less there is no preview. */
const QUICK = 25;

export interface Request {
  readonly number: number;
  readonly scenario: Scenario;
}

interface Answer {
  readonly number: number;
  readonly course: Course;
}

/** Answers a request twice, with the preview and with the fine run, until another one comes. */
class Calculator {
  private readonly _contents: Contents;
  private readonly _send: (answer: Answer) => void;
  private _newest = -1;
  /** ms: of the last fine run. */
  private _duration = Infinity;

  constructor(contents: Contents, send: (answer: Answer) => void) {
    this._contents = contents;
    this._send = send;
  }

  async answer({ number, scenario }: Request) {
    const { machine, page } = this._contents;
    this._newest = number;
    if (this._duration > QUICK) {
      this._send({ number, course: computeCourse(machine, scenario, page.turn, PREVIEW) });
      await new Promise((done) => setTimeout(done, REST));
    }
    const parts = courseInParts(machine, scenario, page.turn, FINE);
    let duration = 0;
    while (this._newest === number) {
      const begin = performance.now();
      let part = parts.next();
      while (!part.done && performance.now() < begin + SLICE) part = parts.next();
      duration += performance.now() - begin;
      if (part.done) {
        this._duration = duration;
        return this._send({ number, course: part.value });
      }
      await messages();
    }
  }
}

/** Lets messages in: at once, unlike a timer. */
function messages(): Promise<void> {
  return new Promise((done) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      done();
    };
    port2.postMessage(null);
  });
}

/** The worker: computes the scenarios that it is sent, and the one that it begins with. */
export function serve(contents: Contents, first: Request | null) {
  const calculator = new Calculator(contents, (answer) => {
    const { time, states, outputs } = answer.course;
    (self as unknown as Worker).postMessage(answer, [time.buffer, states.buffer, outputs.buffer] as ArrayBuffer[]);
  });
  self.addEventListener("message", (event: MessageEvent<Request>) => calculator.answer(event.data));
  if (first !== null) void calculator.answer(first);
}

/** The page's side of the worker. Where a browser runs none, as in some frames, the page computes itself. */
export class Computer {
  private _worker: Worker | null = null;
  private readonly _calculator: Calculator;
  private _receive: ((course: Course) => void) | null = null;
  /** A course that came before somebody listened. */
  private _early: Course | null = null;
  private _isBusy = false;
  private _latest: Request | null = null;
  private _next: Scenario | null = null;

  /** first: what is computed as soon as the worker runs; it need not wait for a message, for which the page must be idle. */
  constructor(contents: Contents, first: Scenario | null) {
    this._calculator = new Calculator(contents, (answer) => this._finish(answer));
    if (first !== null) [this._latest, this._isBusy] = [{ number: 0, scenario: first }, true];
    const text = ["machine", "engine"].map((id) => document.getElementById(id)?.textContent ?? "");
    const address = URL.createObjectURL(
      new Blob(
        [`const firstRequest = ${JSON.stringify(this._latest)}`, ...text].map((part) => `${part};\n`),
        { type: "text/javascript" },
      ),
    );
    try {
      this._worker = new Worker(address);
    } catch {
      if (this._latest !== null) this._computeHere(this._latest);
      return;
    }
    this._worker.addEventListener("message", (event: MessageEvent<Answer>) => this._finish(event.data));
    this._worker.addEventListener("error", () => {
      this._worker = null;
      if (this._latest !== null) this._computeHere(this._latest);
    });
  }

  /** receive: what is done with a preview or a fine course of the newest scenario. */
  listen(receive: (course: Course) => void) {
    this._receive = receive;
    if (this._early !== null) receive(this._early);
    this._early = null;
  }

  /** Compute another scenario; of several that wait for the preview of an earlier one, only the last one is computed. */
  compute(scenario: Scenario) {
    const newest = this._next ?? this._latest?.scenario;
    if (newest !== undefined && areEqual(scenario, newest)) return;
    if (this._isBusy) {
      this._next = scenario;
      return;
    }
    this._isBusy = true;
    this._latest = { number: (this._latest?.number ?? 0) + 1, scenario };
    if (this._worker === null) this._computeHere(this._latest);
    else this._worker.postMessage(this._latest);
  }

  private _computeHere(request: Request) {
    setTimeout(() => this._calculator.answer(request));
  }

  private _finish({ number, course }: Answer) {
    if (number !== this._latest?.number) return; // a fine run whose scenario is no longer the newest
    this._isBusy = false;
    const next = this._next;
    this._next = null;
    if (next !== null) this.compute(next);
    if (this._receive === null) this._early = course;
    else this._receive(course);
  }
}
