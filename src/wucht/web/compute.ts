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

/** The page's side of the worker. */
export class Computer {
  private readonly _worker: Worker;
  private _isBusy = false;
  private _next: Scenario | null = null;

  /** receive: what is done with a course. */
  constructor(receive: (course: Course) => void) {
    const text = ["machine", "engine"].map((id) => document.getElementById(id)?.textContent ?? "");
    const address = URL.createObjectURL(
      new Blob(
        text.map((part) => `${part};\n`),
        { type: "text/javascript" },
      ),
    );
    this._worker = new Worker(address);
    this._worker.addEventListener("message", (event: MessageEvent<Course>) => {
      this._isBusy = false;
      const next = this._next;
      this._next = null;
      if (next !== null) this.compute(next);
      receive(event.data);
    });
  }

  /** Compute a scenario; of several that wait, only the last one is computed. */
  compute(scenario: Scenario) {
    if (this._isBusy) {
      this._next = scenario;
      return;
    }
    this._isBusy = true;
    this._worker.postMessage(scenario);
  }
}
