"""Rotors that may be entrained: the evidence for a common mean speed, and the outcome of each at its resonance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.dynamics.verdicts.evidence import Standing, standing
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import FEWEST_TURNS, Bounds, Evidence, Locking, Outcome, classify
from wucht.machines.machine import Machine
from wucht.machines.operation import common_free_speed, free_speed, sense_of
from wucht.numerics.angles import wrapped
from wucht.numerics.observers.projection import AHEAD, falling, projected, windows_of
from wucht.numerics.observers.records import Blocks
from wucht.numerics.observers.turns import PER_TURN

_ROUNDING = 1e-8  # of the speed: how mean speeds over whole periods change below is rounding
_AT_REST = 1e-4  # rad: a phase that moves less from window to window is at rest
_BOUNDED = 0.2  # of the mean speed: it will not change by more if the rotors are permanently not locked
_SHARE = 0.5  # of the run: the last part, over which is averaged


@dataclass(frozen=True)
class Locked:
    """The evidence of locking, and numbers for the summary.

    speeds: of all rotors over whole periods, with their signs. phases: of the other rotors to the main one, or of the main
    rotor to the vibration (key ``vibration``), as sigma phi, means over the last whole periods, wrapped to [0, 2 pi). window:
    begin and end time. amplitudes: mean, least and greatest there. smooth_speeds: the same as ``speeds``, for a modulation that
    is cut at the ends. change: the largest between the halves of the window. creep: the motion of the slow phases in the
    second half of it, in rad.
    """

    evidence: Locking
    speeds: dict[str, float]
    phases: dict[str, float]
    window: tuple[float, float]
    amplitudes: tuple[float, float, float]
    smooth_speeds: dict[str, float]
    change: float
    creep: float


def is_locking(machine: Machine) -> bool:
    """True if a machine is judged by locking: its carrier is shaken harmonically, or several of its rotors are free to turn."""
    free = sum(r.coordinate.prescribed is None for r in machine.rotors)
    return free > 1 or (free == 1 and machine.shaken is not None and machine.shaking_frequency is not None)


def locked(machine: Machine, seen: Observation) -> Locked | None:
    """Assess mean speeds and phases of a run; None if the main rotor does not make a single period in its last half."""
    main, names = machine.rotor.name, [b.name for b in machine.bodies]
    by_vibration = seen.vibration is not None
    record = seen.rotors[main] if seen.vibration is None else seen.vibration
    leading = [*(["vibration"] if by_vibration else [main]), *(n for n in names if by_vibration or n != main)]
    half = record.whole_turns(_SHARE)
    periods = round((len(half) - 1) * half.size / PER_TURN)
    if periods < 1:
        return None

    def of_rotors(values: np.ndarray) -> dict[str, Any]:
        """Select the values of the rotors from those of the leading motion and of its followers."""
        return {r.name: values[leading.index(r.name)] for r in machine.rotors}

    speeds, smooth = (of_rotors((half.sense * x).tolist()) for x in (half.mean_speeds, half.smooth_mean_speeds))
    earlier, later = (of_rotors(part.smooth_mean_speeds) for part in (half.part(slice(len(half) // 2)), half.last(0.5)))
    phases = rotor_phases(machine, half.time, of_rotors(np.array([half.angle, *half.angles])))
    evidence = _evidence(machine, record.whole, periods, of_rotors, seen.noise)
    # Rotors that turn at different speeds have no period in common.
    apart = not by_vibration and evidence.locked is False
    return Locked(
        evidence,
        speeds=smooth if apart else speeds,
        phases={name: float(wrapped(p[-max(1, len(half) // 10) :].mean())) for name, p in phases.items()},
        window=(float(half.time[0]), float(half.time[-1])),
        amplitudes=half.amplitudes,
        smooth_speeds=smooth,
        change=max(float(abs(later[name] - earlier[name])) for name in speeds),
        creep=max((float(abs(p[-1] - p[len(half) // 2])) for p in phases.values()), default=0.0),
    )


def _evidence(
    machine: Machine, whole: Blocks, periods: int, of_rotors: Callable[[np.ndarray], dict[str, Any]], noise: Noise
) -> Locking:
    """Return what the criteria need. rotor_values: selects those of the rotors from the leading motion and its followers."""
    phases = rotor_phases(machine, whole.time, of_rotors(np.array([whole.angle, *whole.angles])))
    each = of_rotors(np.array([whole.speed, *whole.followers]))
    main, frequency = machine.rotor.name, machine.shaking_frequency
    durations = windows_of(1 / whole.speed).mean(axis=1)
    means = {name: np.abs(windows_of(x / whole.speed).mean(axis=1)) / durations for name, x in each.items()}
    compared = [means[main]] if frequency is not None else [x for name, x in means.items() if name != main]
    reference = abs(frequency) if frequency is not None else means[main]
    if not durations.size or not np.isfinite(durations).all():
        return Locking(0, (), ())
    rounding, at_rest = max(_ROUNDING, noise.speed), max(_AT_REST, noise.angle)
    bounded = projected(means[main], AHEAD, rounding * float(means[main][-1]))
    return Locking(
        periods,
        tuple(_apart(x / reference - 1, rounding) for x in compared),
        tuple(projected(windows_of(p).mean(axis=1), AHEAD, at_rest).bounds for p in phases.values()),
        bounded.width <= _BOUNDED * abs(bounded.last),
    )


def _apart(means: np.ndarray, rounding: float) -> Bounds:
    """Return the bounds between which a difference of speeds will stay: one that mostly falls continues to do so."""
    way = math.copysign(1.0, means[-1])
    p = falling(way * means, AHEAD, rounding)
    return (p.low, p.high) if way > 0 else (-p.high, -p.low)


def rotor_phases(machine: Machine, time: np.ndarray, angles: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return sigma phi (N,) of the main rotor to the vibration (``vibration``), or of other rotors to it. angles: of all."""
    turned = {name: math.copysign(1.0, angle[-1] - angle[0]) * angle for name, angle in angles.items()}
    origin, frequency = turned.pop(machine.rotor.name), machine.shaking_frequency
    return {n: a - origin for n, a in turned.items()} if frequency is None else {"vibration": origin - frequency * time}


def rotor_outcomes(machine: Machine, seen: Observation, means: Locked) -> tuple[dict[str, Outcome], Evidence[float] | None]:
    """Return the outcome of each of several rotors that are free to turn, and the evidence of their common motion if locked.

    Rotors that are locked excite the vibration together, in the phases they have, and have one common free speed, at which all
    drives together are in balance. The torques between them, with phases at rest, do not count.
    """
    end, stands, free = seen.end_time, dict[str, Standing](), [r for r in machine.rotors if r.coordinate.prescribed is None]
    for rotor in free if len(free) > 1 else []:
        if (record := seen.rotors[rotor.name]).turns >= FEWEST_TURNS:
            stands[rotor.name] = standing(machine, rotor, record, free_speed(machine, rotor, end), end, seen.noise)
    common = _common(machine, seen, means, stands)
    each = {name: s.evidence if common is None else _as_one(s, common) for name, s in stands.items()}
    return {name: classify(e) for name, e in each.items()}, common


def _common(machine: Machine, seen: Observation, means: Locked, stands: dict[str, Standing]) -> Evidence[float] | None:
    """Return the evidence of the common motion of locked rotors; None if they are not locked, or one is not free to turn."""
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
    """Return the evidence of a rotor in the common motion, with its bodies, and its modulation if that lasts."""
    own = stands.evidence
    return replace(
        common,
        settled=common.settled and not stands.growing,
        residual=own.residual,
        lags=own.lags,
        modulation=own.modulation if own.modulated else common.modulation,
    )
