/** Bodies of one track that would lie within each other: a start that no machine has. */

import { Equations } from "./equations.ts";
import type { LiveMachine } from "./machine.ts";

/** rad: a gap that is negative by rounding. */
const ROUNDING = 1e-9;

/** A sentence where neighbours on a track overlap in a state, or have changed places; else nothing. */
export function overlapSentence(machine: LiveMachine, parameters: ArrayLike<number>, state: Float64Array): string {
  if (machine.contacts.length === 0) return "";
  const equations = new Equations(machine);
  const places = new Float64Array(machine.segmentations.length);
  equations.setParameters(parameters);
  equations.places(0, state, places);
  const contact = machine.contacts.find((one) => places[one.segmentation]! < -ROUNDING);
  return contact === undefined
    ? ""
    : `${contact.bodies.join(" and ")} would overlap there: the initial state stays as it was.`;
}
