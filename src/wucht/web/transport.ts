/** The row below the drawing: play, scrub, speed. The keyboard does the same everywhere on the page. */

import { SPEEDS, type Clock } from "./clock.ts";
import { button, element } from "./dom.ts";
import { numberText } from "./numbers.ts";

const STEPS = 2000;
/** Of the run: what an arrow key moves, and with the shift key. */
const [STEP, FINE] = [1 / 100, 1 / 1000];

export class Transport {
  readonly root: HTMLElement;
  private readonly _clock: Clock;
  private readonly _unit: string;
  private readonly _play: HTMLButtonElement;
  private readonly _scrub: HTMLInputElement;
  private readonly _now: HTMLElement;

  constructor(clock: Clock, unit: string) {
    this._clock = clock;
    this._unit = unit;
    this._play = button("", () => this.toggle(), { class: "play" });
    this._scrub = element("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": "time", class: "scrub" });
    this._scrub.addEventListener("input", () => clock.move((clock.end * this._scrub.valueAsNumber) / STEPS));
    this._now = element("output", { class: "number", "aria-hidden": "true" });
    const speeds = element("select", { "aria-label": "speed of play" }, ...SPEEDS.map((speed) => this._option(speed)));
    speeds.addEventListener("change", () => {
      clock.speed = Number(speeds.value);
    });
    this.root = element("div", { class: "transport" }, this._play, this._scrub, this._now, speeds);
    addEventListener("keydown", (event) => this._key(event));
    this.show();
  }

  private _option(speed: number): HTMLOptionElement {
    const words = this._unit === "s" ? `${numberText(speed)} × real time` : `${numberText(speed)} units a second`;
    return element("option", { value: speed, selected: speed === this._clock.speed }, words);
  }

  toggle() {
    if (this._clock.isPlaying) this._clock.pause();
    else this._clock.play();
  }

  /** Show the time. */
  show() {
    const { time, end, isPlaying } = this._clock;
    const words = `${numberText(time, time < 10 ? 3 : 4)} ${this._unit}`.trim();
    if (this._play.dataset["playing"] !== String(isPlaying)) {
      this._play.dataset["playing"] = String(isPlaying);
      this._play.setAttribute("aria-label", isPlaying ? "pause" : "play");
      this._play.title = `${isPlaying ? "Pause" : "Play"} (space)`;
    }
    this._scrub.value = String(Math.round((STEPS * time) / end));
    this._scrub.setAttribute("aria-valuetext", words);
    this._now.textContent = words;
  }

  private _key(event: KeyboardEvent) {
    const target = event.target as HTMLElement;
    const isTyping = target instanceof HTMLInputElement && target.type === "text";
    if (isTyping || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const isSlider = target instanceof HTMLInputElement && target.type === "range" && target !== this._scrub;
    const onElement = target instanceof HTMLButtonElement || target.tagName === "SUMMARY" || target instanceof HTMLInputElement;
    if (event.key === " " && (!onElement || (target instanceof HTMLInputElement && target.type === "range"))) {
      event.preventDefault();
      this.toggle();
      return;
    }
    if (isSlider || (target instanceof HTMLInputElement && target.type === "radio")) return;
    const direction = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (direction !== undefined) {
      event.preventDefault();
      this._clock.move(this._clock.time + direction * (event.shiftKey ? FINE : STEP) * this._clock.end);
    } else if (event.key === "Home" || event.key === "End") {
      event.preventDefault();
      this._clock.move(event.key === "Home" ? 0 : this._clock.end);
    }
  }
}
