/**
 * What computes for the page. It is the first script: its worker starts while the browser reads the rest of the page, as the
 * first run takes longest.
 */

import { Computer, serve, type Request } from "./compute.ts";
import type { LiveMachine } from "./machine.ts";
import type { PageData } from "./page_data.ts";
import { originalScenario } from "./scenario.ts";

declare const machine: LiveMachine;
declare const page: PageData;
declare const firstRequest: Request | null;

function startComputer(): Computer {
  const scripts = [document.getElementById("machine"), document.currentScript].map((script) => script?.textContent ?? "");
  return new Computer({ machine, page }, scripts, location.hash.length > 1 ? null : originalScenario(machine, page.until));
}

/** In the page; in the worker there is none. */
export const computer = typeof document === "undefined" ? serve({ machine, page }, firstRequest) : startComputer();
