/** What `wucht.web.live_page` writes beside the machine. Quantities in SI; indices begin at 0. */

import type { Code, LiveMachine } from "./machine.ts";

/** A number that can be moved; see `Control` in `wucht/web/sliders.py`. */
export interface Control {
  readonly name: string;
  readonly indices: readonly number[];
  readonly unit: string;
  readonly size: number;
  readonly low: number | null;
  readonly high: number | null;
  readonly open: boolean;
  readonly whole: boolean;
  readonly bottom: number;
  readonly top: number;
  readonly logarithmic: boolean;
}

/** A start value; see `StartControl` in `wucht/web/start_controls.py`. */
export interface StartControl {
  readonly name: string;
  readonly index: number;
  readonly head: number | null;
  readonly offset: number;
  readonly keys: readonly [string, string];
  readonly unit: string;
  readonly size: number;
  readonly bottom: number;
  readonly top: number;
}

export interface Group<T> {
  readonly title: string;
  readonly controls: readonly T[];
  /** Names of what follows a schedule. */
  readonly over_time?: readonly string[];
}

/** An output, or the difference of two states, each with its sense. */
export interface Curve {
  readonly name: string;
  readonly output?: number;
  readonly state?: number;
  readonly head?: number;
  readonly sense?: number;
  readonly head_sense?: number;
}

export interface Panel {
  readonly title: string;
  readonly unit: string;
  readonly size: number;
  readonly circular: boolean;
  readonly curves: readonly Curve[];
}

export interface Card {
  readonly title: string;
  readonly text: string;
  readonly task: string;
}

export interface LevelData {
  readonly size: number;
  readonly rotors: readonly { readonly name: string; readonly speed: number | null; readonly depends: readonly number[] }[];
}

export interface PageData {
  readonly version: string;
  readonly until: number;
  readonly turn: number;
  readonly text: {
    readonly file: string;
    readonly machine: string;
    readonly study: string;
    readonly start: string;
    readonly start_of_parts: string;
    readonly verdict: readonly [string, string] | null;
    readonly card: Card | null;
    /** The address at which a server judges what is shown. */
    readonly server: string | null;
    /** Whether the page around this one is told what is shown. */
    readonly is_embedded: boolean;
    /** Why there is no study file; empty where there is one. */
    readonly reason: string;
  };
  readonly dimensionless: boolean;
  readonly groups: readonly Group<Control>[];
  readonly start: readonly Group<StartControl>[];
  /** Indices of parameters that follow from others in the file. */
  readonly derived: readonly number[];
  readonly switches: readonly { readonly name: string; readonly index: number }[];
  readonly panels: readonly Panel[];
  readonly levels: LevelData;
}

export interface LevelCode {
  /** Entries of the carrier's mass matrix, then of its stiffness matrix. */
  readonly matrices: Code;
}

export interface Contents {
  readonly machine: LiveMachine;
  readonly page: PageData;
  readonly levelCode: LevelCode;
}
