/** Stand-in until the drawing is merged. */
import type { LiveMachine } from "./machine.ts";
export interface View {
  readonly stroboscopic: boolean;
  readonly magnification: number;
}
export interface Part {
  readonly kind: "carrier" | "body";
  readonly index: number;
}
export class MachineDrawing {
  readonly description = "";
  private readonly _canvas: HTMLCanvasElement;
  constructor(canvas: HTMLCanvasElement, _machine: LiveMachine) {
    this._canvas = canvas;
  }
  draw(
    time: number,
    _state: ArrayLike<number>,
    _outputs: ArrayLike<number>,
    _parameters: ArrayLike<number>,
    _view: View,
    _trace: Float64Array | null,
  ) {
    const context = this._canvas.getContext("2d");
    context?.clearRect(0, 0, this._canvas.width, this._canvas.height);
    context?.fillText(String(time), 10, 20);
  }
  suggestedMagnification(_largestAmplitude: number): number {
    return 10;
  }
  partAt(_x: number, _y: number): Part | null {
    return null;
  }
  moved(_part: Part, _x: number, _y: number, state: ArrayLike<number>): Float64Array {
    return Float64Array.from(state);
  }
}
