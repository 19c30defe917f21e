/** The places of the page's parts, and what it says of itself. */

import { button, element } from "./dom.ts";
import type { Card, PageData } from "./page_data.ts";

/** The page: heading, machine, curves and controls. */
export function pageLayout(
  title: string,
  page: PageData,
  verdict: HTMLElement,
  stage: readonly HTMLElement[],
  middle: readonly HTMLElement[],
  side: readonly HTMLElement[],
): HTMLElement {
  const card = page.text.card === null ? [] : [cardOf(page.text.card)];
  const words =
    `wucht ${page.version}. Computed here, to six digits a step, from the machine's own equations. A run is judged by wucht, ` +
    "not by this page, which also does not check whether values fit together.";
  return element(
    "main",
    {},
    element("header", {}, element("h1", {}, title), verdict, element("p", { class: "file" }, page.text.file)),
    element("section", { class: "stage", "aria-label": "the machine" }, ...stage),
    element("div", { class: "middle" }, ...card, ...middle),
    element("div", { class: "side" }, ...side),
    element("footer", {}, words),
  );
}

/** What the machine teaches, until it is closed. */
function cardOf(card: Card): HTMLElement {
  const made = element(
    "section",
    { class: "card", "aria-label": "what this machine shows" },
    element("h2", {}, card.title),
    element("p", {}, card.text),
    element("p", { class: "task" }, card.task),
  );
  made.append(button("×", () => made.remove(), { class: "close", "aria-label": "close this card" }));
  return made;
}
