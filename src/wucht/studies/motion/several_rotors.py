"""What became of each of several rotors at its resonance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.results.outcomes import Outcome, classify
from wucht.studies.motion.evidence import FEWEST_TURNS, Standing, standing
from wucht.studies.motion.locking import Locked
from wucht.studies.motion.observation import Observation


def rotor_outcomes(machine: Machine, seen: Observation, means: Locked) -> dict[str, Outcome]:
    """What became of each of several rotors that are free to turn; rotors that are locked excite the vibration together."""
    end, stands, free = seen.end_time, dict[str, Standing](), [r for r in machine.rotors if r.coordinate.prescribed is None]
    for rotor in free if len(free) > 1 else []:
        if (record := seen.rotors[rotor.name]).turns >= FEWEST_TURNS:
            stands[rotor.name] = standing(machine, rotor, record, free_speed(machine, rotor, end), end, seen.noise)
    each = {name: s.evidence for name, s in stands.items()}
    if means.evidence.locked and seen.vibration is None and len(stands) == len(machine.rotors):
        phases = {
            body.name: means.phases.get(rotor.name, 0.0) + phase
            for rotor in machine.rotors
            for body, phase in zip(machine.group(rotor), stands[rotor.name].final_phases, strict=True)
        }
        vibration, in_order = Vibration.of(machine), np.array([phases[b.name] for b in machine.bodies])
        for name, e in each.items():
            if e.free_speed != 0:
                each[name] = replace(e, resonance=vibration.last_maximum(e.free_speed, in_order))
    return {name: classify(e) for name, e in each.items()}
