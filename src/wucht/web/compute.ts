/** Courses computed in a worker, so that the page answers while a run is computed: one at a time, the newest wins. */

import { computeCourse, type Course } from "./course.ts";
import type { Contents } from "./page_data.ts";
import type { Scenario } from "./scenario.ts";

/** The worker: computes the scenarios that it is sent. */
export function serve({ machine, page }: Contents) {
  self.addEventListener("message", (event: MessageEvent<Scenario>) => {
    const course = computeCourse(machine, event.data, page.turn);
    const buffers = [course.time.buffer, course.states.buffer, course.outputs.buffer];
    (self as unknown as Worker).postMessage(course, buffers as ArrayBuffer[]);
  });
}

/** The page's side of the worker. Where a browser runs none, as in some frames, the page computes itself. */
export class Computer {
  private _worker: Worker | null = null;
  private readonly _contents: Contents;
  private readonly _receive: (course: Course) => void;
  private _isBusy = false;
  private _latest: Scenario | null = null;
  private _next: Scenario | null = null;

  /** receive: what is done with a course. */
  constructor(contents: Contents, receive: (course: Course) => void) {
    this._contents = contents;
    this._receive = receive;
    const text = ["machine", "engine"].map((id) => document.getElementById(id)?.textContent ?? "");
    const address = URL.createObjectURL(
      new Blob(
        text.map((part) => `${part};\n`),
        { type: "text/javascript" },
      ),
    );
    try {
      this._worker = new Worker(address);
    } catch {
      return;
    }
    this._worker.addEventListener("message", (event: MessageEvent<Course>) => this._finish(event.data));
    this._worker.addEventListener("error", () => {
      this._worker = null;
      if (this._latest !== null) this._computeHere(this._latest);
    });
  }

  /** Compute a scenario; of several that wait, only the last one is computed. */
  compute(scenario: Scenario) {
    if (this._isBusy) {
      this._next = scenario;
      return;
    }
    this._isBusy = true;
    this._latest = scenario;
    if (this._worker === null) this._computeHere(scenario);
    else this._worker.postMessage(scenario);
  }

  private _computeHere(scenario: Scenario) {
    const { machine, page } = this._contents;
    setTimeout(() => this._finish(computeCourse(machine, scenario, page.turn)));
  }

  private _finish(course: Course) {
    this._isBusy = false;
    const next = this._next;
    this._next = null;
    if (next !== null) this.compute(next);
    this._receive(course);
  }
}
