/** The live machine: in a window the page, in a worker what computes for it. */

import "uplot/dist/uPlot.min.css";
import "./live.css";
import { serve } from "./compute.ts";
import { LivePage } from "./live_page.ts";
import type { LiveMachine } from "./machine.ts";
import type { LevelCode, PageData } from "./page_data.ts";

declare const machine: LiveMachine;
declare const page: PageData;
declare const levelCode: LevelCode;

const contents = { machine, page, levelCode };
if (typeof document === "undefined") serve(contents);
else document.body.append(new LivePage(contents).root);
