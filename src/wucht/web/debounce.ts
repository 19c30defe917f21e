/** An action that waits for a pause: of many values in a row only the last one counts. */

export class Debounced<T> {
  private readonly _pause: number;
  private readonly _action: (value: T) => void;
  private _timer = 0;

  /** pause: in ms. */
  constructor(pause: number, action: (value: T) => void) {
    this._pause = pause;
    this._action = action;
  }

  /** Act on this value after a pause, unless another one comes. */
  call(value: T) {
    this.cancel();
    this._timer = setTimeout(() => this._action(value), this._pause);
  }

  cancel() {
    clearTimeout(this._timer);
  }
}
