/** A machine as `wucht.dynamics.live_machine` writes it. Quantities in SI; indices begin at 0. */

import type { DrawingData, HillData } from "./drawing_data.ts";

/** Functions printed from a Program: constants from parameters, results from time, states and constants. */
export interface Code {
  readonly constantCount: number;
  constants(parameters: Float64Array, constants: Float64Array): void;
  values(time: number, states: Float64Array, constants: Float64Array, results: Float64Array): void;
}

export interface Quantity {
  readonly name: string;
  readonly unit: string;
  readonly long_name: string;
}

/** The piecewise functions of one argument: segment i begins at breakpoint i - 1. */
export interface SegmentationTable {
  readonly breakpoints: readonly number[];
  /** The size of the breakpoints. */
  readonly scale: number;
  /** Origins and coefficients of the functions on each segment. */
  readonly rows: readonly (readonly number[])[];
  /** The states in the argument; the number of states stands for the time. */
  readonly indices: readonly number[];
  /** Whether the argument is the time itself. */
  readonly is_time: boolean;
}

export interface Contact {
  readonly track: string;
  readonly bodies: readonly [string, string];
  /** The segmentation whose argument is the gap. */
  readonly segmentation: number;
}

/** What is integrated. */
export interface MotionData {
  readonly title: string;
  readonly time_unit: string;
  readonly states: readonly (Quantity & { readonly start: number })[];
  readonly angles: readonly number[];
  readonly parameters: readonly {
    readonly path: string;
    readonly unit: string;
    readonly symbol: string;
    readonly long_name: string;
    readonly value: number;
  }[];
  readonly outputs: readonly Quantity[];
  readonly segmentations: readonly SegmentationTable[];
  readonly contacts: readonly Contact[];
  /** The rates of the states. */
  readonly rates: Code;
  /** The arguments of the segmentations. */
  readonly places: Code;
  /** The outputs. */
  readonly shown: Code;
}

/** `drawing` and `lengths`: how it is drawn; `hills`: its torques over the speed. */
export interface LiveMachine extends MotionData {
  readonly drawing: DrawingData;
  readonly lengths: Code;
  readonly hills: HillData;
}
