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
    `wucht ${page.version}. Integrated in this page with a relative error tolerance of 1e-6 per step (wucht run: 1e-12). ` +
    "Verdicts come from wucht; the page does not check combinations of values.";
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
  const section = element(
    "section",
    { class: "card", "aria-label": "what this machine shows" },
    element("h2", {}, card.title),
    element("p", {}, card.text),
    element("p", { class: "task" }, card.task),
  );
  section.append(button("×", () => section.remove(), { class: "close", "aria-label": "close this card" }));
  return section;
}
