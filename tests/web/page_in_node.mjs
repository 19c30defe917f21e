// What the built page draws of measured values: node page_in_node.mjs PAGE.html MEASURED.csv, prints rectangles by panel.
// Of a browser there is what the page needs to start: nothing is laid out, and a canvas keeps the rectangles filled on it.
import { readFileSync } from "node:fs";

const [page, measured] = process.argv.slice(2).map((file) => readFileSync(file, "utf8"));
const scriptOf = (id) => new RegExp(`(?<=<script id="${id}">)[\\s\\S]*?(?=</script>)`).exec(page)[0];
const nothing = () => {};

class Element extends EventTarget {
  children = [];
  attributes = {};
  dataset = {};
  style = { setProperty: nothing };
  classList = { add: nothing, remove: nothing, toggle: nothing, contains: nothing };
  rectangles = [];
  clientWidth = 640;
  clientHeight = 200;
  ownerDocument = globalThis.document;

  constructor(tag) {
    super();
    this.tag = tag;
    const drawing = { measureText: () => ({ width: 0 }), fillRect: (...sides) => this.rectangles.push(sides), canvas: this };
    this.context = new Proxy(drawing, { get: (target, name) => target[name] ?? nothing });
  }
  append(...nodes) {
    this.children.push(...nodes);
  }
  appendChild(node) {
    this.append(node);
  }
  insertBefore(node) {
    this.append(node);
  }
  replaceChildren(...nodes) {
    this.children = nodes;
  }
  remove() {}
  setAttribute(name, value) {
    this.attributes[name] = value;
  }
  removeAttribute(name) {
    delete this.attributes[name];
  }
  getContext() {
    return this.context;
  }
  getBoundingClientRect() {
    return { left: 0, top: 0, width: this.clientWidth, height: this.clientHeight };
  }
  querySelector(tag) {
    return this.all.find((node) => node.tag === tag);
  }
  /** This element and all in it. */
  get all() {
    return [this, ...this.children.flatMap((node) => node.all ?? [])];
  }
}

globalThis.document = {
  createElement: (tag) => new Element(tag),
  getElementById: (id) => ({ textContent: scriptOf(id) }),
  addEventListener: nothing,
};
const [root, body, whole] = [new Element("html"), new Element("body"), new EventTarget()];
Object.assign(document, { documentElement: root, body });
Object.assign(globalThis, {
  window: globalThis,
  HTMLElement: Element,
  devicePixelRatio: 1,
  location: { protocol: "file:", hash: "", pathname: "/" },
  addEventListener: whole.addEventListener.bind(whole),
  dispatchEvent: whole.dispatchEvent.bind(whole),
  matchMedia: () => ({ addEventListener: nothing }),
  getComputedStyle: () => ({ colorScheme: "light", getPropertyValue: () => "" }),
  Path2D: class {
    moveTo() {}
    lineTo() {}
    rect() {}
  },
  ResizeObserver: class {
    observe() {}
  },
  MutationObserver: class {
    observe() {}
  },
});
const shortly = () => new Promise((done) => setTimeout(done, 5));
new Function(`${scriptOf("machine")};\n${scriptOf("engine")}`)();
while (root.dataset.courses === undefined) await shortly();
await shortly();

const panels = body.all.filter((node) => node.attributes.class === "panel");
const rectangles = () =>
  panels.map((panel) => [panel.attributes["aria-label"], panel.querySelector("canvas").rectangles.splice(0)]);
const before = rectangles();
const input = body.all.find((node) => node.attributes.id === "measured");
input.files = [{ name: "run.csv", size: measured.length, text: async () => measured }];
input.dispatchEvent(new Event("change"));
await shortly();
const after = Object.fromEntries(rectangles());
const isNew = (sides, earlier) => !earlier.some((other) => `${other}` === `${sides}`);
const added = before.map(([label, earlier]) => [label, after[label].filter((sides) => isNew(sides, earlier))]);
console.log(JSON.stringify(Object.fromEntries(added)));
