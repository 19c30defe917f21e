/** The live machine: in a window the page, in a worker what computes for it. */

import "uplot/dist/uPlot.min.css";
import "./live.css";
import { Computer, serve, type Request } from "./compute.ts";
import { LivePage } from "./live_page.ts";
import type { LiveMachine } from "./machine.ts";
import type { LevelCode, PageData } from "./page_data.ts";
import { originalScenario } from "./scenario.ts";

declare const machine: LiveMachine;
declare const page: PageData;
declare const levelCode: LevelCode;
declare const firstRequest: Request | null;

/** ms: in these the browser starts the worker, which then computes while the page is built. */
const START = 20;

const contents = { machine, page, levelCode };
if (typeof document === "undefined") serve(contents, firstRequest);
else {
  if (page.text.server !== null) history.replaceState(null, "", location.pathname + location.hash); // without the key
  const original = originalScenario(machine, page.until);
  const computer = new Computer(contents, location.hash.length > 1 ? null : original);
  setTimeout(() => document.body.append(new LivePage(contents, original, computer).root), START);
}
