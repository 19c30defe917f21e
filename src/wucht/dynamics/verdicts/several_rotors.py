"""What became of each of several rotors at its resonance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.dynamics.verdicts.evidence import FEWEST_TURNS, Standing, standing
from wucht.dynamics.verdicts.locking import Locked
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import Evidence, Outcome, classify
from wucht.machines.machine import Machine
from wucht.machines.operation import common_free_speed, free_speed, sense_of


def rotor_outcomes(machine: Machine, seen: Observation, means: Locked) -> tuple[dict[str, Outcome], Evidence[float] | None]:
    """What became of each of several rotors that are free to turn; and the evidence of their common motion, if they are locked.

    Rotors that are locked excite the vibration together, in the phases they have, and one speed belongs to them, at which all
    drives together are in balance. What they do to each other meanwhile, with phases at rest, is no part of that.
    """
    end, stands, free = seen.end_time, dict[str, Standing](), [r for r in machine.rotors if r.coordinate.prescribed is None]
    for rotor in free if len(free) > 1 else []:
        if (record := seen.rotors[rotor.name]).turns >= FEWEST_TURNS:
            stands[rotor.name] = standing(machine, rotor, record, free_speed(machine, rotor, end), end, seen.noise)
    common = _common(machine, seen, means, stands)
    each = {name: s.evidence if common is None else _as_one(s, common) for name, s in stands.items()}
    return {name: classify(e) for name, e in each.items()}, common


def _common(machine: Machine, seen: Observation, means: Locked, stands: dict[str, Standing]) -> Evidence[float] | None:
    """The evidence of the common motion of rotors that are locked; None where they are not, or one is not free to turn."""
    record, locked = seen.common, means.evidence.locked and seen.vibration is None and len(stands) == len(machine.rotors)
    # Without a drive a rotor may turn either way, but vibration and mean angle are those of one that turns counter-clockwise.
    as_driven = all(means.speeds[r.name] * sense_of(machine, r) > 0 for r in machine.rotors)
    if not locked or not as_driven or record is None or record.turns < FEWEST_TURNS:
        return None
    phases = {
        body.name: means.phases.get(rotor.name, 0.0) + phase
        for rotor in machine.rotors
        for body, phase in zip(machine.group(rotor), stands[rotor.name].final_phases, strict=True)
    }
    reached, in_order = common_free_speed(machine), np.array([phases[b.name] for b in machine.bodies])
    resonance = Vibration.of(machine).last_maximum(reached, in_order)
    evidence = standing(machine, machine.rotor, record, reached, seen.end_time, seen.noise).evidence
    return replace(evidence, resonance=resonance)


def _as_one(stands: Standing, common: Evidence[float]) -> Evidence[float]:
    """The evidence of a rotor in the common motion: the bodies about it are its own, and a swing that lasts."""
    own = stands.evidence
    return replace(
        common,
        settled=common.settled and not stands.growing,
        residual=own.residual,
        lags=own.lags,
        modulation=own.modulation if own.modulated else common.modulation,
    )
