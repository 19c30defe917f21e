/** The time that is shown: it plays, stands, and is moved. */

/** Machine's time in a second of the clock: what can be chosen. */
export const SPEEDS: readonly number[] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
/** Turns in a second at most at first: faster ones are not followed by the eye. */
const TURNS = 3;
const LONGEST_FRAME = 0.1;

/** The speed at which somebody can follow the fastest turn. */
export function suggestedSpeed(turn: number): number {
  return SPEEDS.findLast((speed) => speed <= TURNS * turn) ?? SPEEDS[0]!;
}

export class Clock {
  time = 0;
  speed = 1;
  end = 1;
  isPlaying = false;
  private readonly _show: () => void;
  private _last = 0;

  /** show: is called in each frame, and when the time is moved. */
  constructor(show: () => void) {
    this._show = show;
  }

  play() {
    if (this.isPlaying) return;
    if (this.time >= this.end) this.time = 0;
    this.isPlaying = true;
    this._last = performance.now();
    requestAnimationFrame((now) => this._frame(now));
    this._show();
  }

  pause() {
    this.isPlaying = false;
    this._show();
  }

  /** Go to a time within the run. */
  move(time: number) {
    this.time = Math.min(this.end, Math.max(0, time));
    this._show();
  }

  private _frame(now: number) {
    if (!this.isPlaying) return;
    const elapsed = Math.min(LONGEST_FRAME, Math.max(0, (now - this._last) / 1000));
    this._last = now;
    this.time = Math.min(this.end, this.time + this.speed * elapsed);
    if (this.time >= this.end) this.isPlaying = false;
    this._show();
    if (this.isPlaying) requestAnimationFrame((next) => this._frame(next));
  }
}
