/** The live machine in its page. */

import "uplot/dist/uPlot.min.css";
import "./live.css";
import type { Computer } from "./compute.ts";
import { LivePage } from "./live_page.ts";
import type { LiveMachine } from "./machine.ts";
import type { LevelCode, PageData } from "./page_data.ts";
import { originalScenario } from "./scenario.ts";

declare const machine: LiveMachine;
declare const page: PageData;
declare const levelCode: LevelCode;
declare const computing: { readonly computer: Computer };

const original = originalScenario(machine, page.until);
document.body.append(new LivePage({ machine, page, levelCode }, original, computing.computer).root);
