/** The data of the moving drawing and of the torque hill, as `wucht.dynamics.live_drawing` and `.torque_hills` write them. */

import type { Code, SegmentationTable } from "./machine.ts";

/** The index of a length among the results of `lengths`; those are computed from the parameters, in m. */
export type Length = number;

export interface CarrierDirection {
  readonly label: "x" | "y" | "r" | "foundation";
  /** Indices of states; -1 for a velocity that is prescribed. */
  readonly position: number;
  readonly velocity: number;
  /** The position at rest. */
  readonly rest: Length;
}

export interface MountData {
  readonly name: string;
  readonly x: Length;
  readonly y: Length;
  /** The direction away from the carrier. */
  readonly dx: number;
  readonly dy: number;
  readonly has_damper: boolean;
  readonly is_on_foundation: boolean;
}

export interface RotorData {
  readonly name: string;
  /** Its index among the bodies. */
  readonly body: number;
  readonly x: Length;
  readonly y: Length;
  readonly radius: Length;
  /** The sense in which its drive turns it, 0 without one. */
  readonly sense: number;
}

export interface BodyData {
  readonly name: string;
  readonly kind: string;
  /** The body it turns about, null on the carrier. */
  readonly about: number | null;
  /** The index of its rotor among the rotors. */
  readonly rotor: number;
  /** Indices of states: the absolute angle; the velocity, -1 where it is prescribed. */
  readonly angle: number;
  readonly velocity: number;
  readonly unbalance: Length;
  /** Its pivot in the frame of the body it turns about. */
  readonly pivot: readonly [Length, Length];
  /** From pivot to centre; its radius; the radius of its track. */
  readonly arm: Length;
  readonly size: Length;
  readonly track: Length;
  /** The mass that slides in it outward from its inner stop. */
  readonly guide: { readonly displacement: number; readonly inner_stop: Length; readonly outer_stop: Length } | null;
}

export interface SliderData {
  readonly name: string;
  readonly about: number;
  /** The index of a state: outward from the radius `arm`. */
  readonly displacement: number;
  readonly arm: Length;
  /** The direction of the guide in the body's frame, in rad. */
  readonly angle: Length;
}

export interface AttachmentData {
  readonly name: string;
  readonly kind: string;
  readonly is_two_sided: boolean;
  readonly x: Length;
  readonly y: Length;
  /** The direction of its line in rad, and the gap to a stop. */
  readonly angle: Length | null;
  readonly gap: Length | null;
  /** The displacement along the line from which the gap counts. */
  readonly rest: Length | null;
}

export interface DrawingData {
  readonly to_scale: boolean;
  readonly is_shaken: boolean;
  readonly turning: "no" | "in plane" | "tilting";
  /** Left, bottom, right, top of the carrier. */
  readonly box: readonly [Length, Length, Length, Length];
  readonly carrier: readonly CarrierDirection[];
  readonly mounts: readonly MountData[];
  readonly rotors: readonly RotorData[];
  /** In the order of the machine, as are the speeds that begin its outputs. */
  readonly bodies: readonly BodyData[];
  readonly sliders: readonly SliderData[];
  readonly attachments: readonly AttachmentData[];
  /** Neighbours on a track, the second ahead of the first: the gap is the difference of their angles plus an offset (rad). */
  readonly contacts: readonly { readonly bodies: readonly [number, number]; readonly offset: Length }[];
  readonly length_count: number;
}

export interface HillBody {
  /** Indices of states; -1 for a velocity that is prescribed. */
  readonly angle: number;
  readonly velocity: number;
  /** The index of its rotor. */
  readonly rotor: number;
  readonly is_rotor: boolean;
}

export interface HillRotor {
  readonly name: string;
  readonly is_driven: boolean;
  /** The sense in which it turns in operation. */
  readonly sense: number;
}

/** Torques over the speed. Its functions have the speed as their only state. */
export interface AvailableHills {
  readonly available: true;
  readonly reason: string;
  /** The number of directions in which the carrier is free. */
  readonly directions: number;
  readonly output_count: number;
  readonly segmentations: readonly SegmentationTable[];
  /** A speed beyond all resonances; null without a unit of time. */
  readonly reach: number | null;
  /** The end of the range where a drive reaches no speed. */
  readonly largest_speed: number;
  readonly units: { readonly speed: string; readonly torque: string };
  readonly bodies: readonly HillBody[];
  readonly rotors: readonly HillRotor[];
  readonly rates: Code;
  readonly places: Code;
  /** Drive and load of each rotor; M, C, K by rows; the forces of the bodies at speed 1: real parts, then imaginary ones. */
  readonly shown: Code;
}

export type HillData = AvailableHills | { readonly available: false; readonly reason: string };

interface Value {
  readonly path: string;
  readonly value: number;
}

/** What the drawing needs of a machine. */
export interface DrawnMachine {
  readonly drawing: DrawingData;
  readonly lengths: Code;
  readonly parameters: readonly Value[];
  readonly states: readonly { readonly start: number }[];
}

/** What the torque hill needs of a machine. */
export interface HillMachine {
  readonly hills: HillData;
  readonly parameters: readonly Value[];
  readonly states: readonly { readonly start: number }[];
}
