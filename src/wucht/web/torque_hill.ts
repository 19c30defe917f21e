/** Stand-in until the torque hill is merged. */
import type { LiveMachine } from "./machine.ts";
export class TorqueHill {
  readonly available = false;
  constructor(_host: HTMLElement, _machine: LiveMachine) {}
  draw(
    _parameters: ArrayLike<number>,
    _speedTrace: Float64Array | null,
    _torqueTrace: Float64Array | null,
    _now: number,
  ) {}
}
