"""Rotors that may be entrained: the evidence for a common mean speed, and the outcome of each at its resonance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.dynamics.verdicts.evidence import RotorAssessment, assess_rotor
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import FEWEST_TURNS, Bounds, Evidence, Locking, Outcome, classify
from wucht.machines.machine import Machine
from wucht.machines.operation import common_free_speed, free_speed, sense_of
from wucht.numerics.angles import wrap_angle
from wucht.numerics.observers.projection import AHEAD, falling_projection, project, windows_of
from wucht.numerics.observers.records import Blocks
from wucht.numerics.observers.turns import MARKS_PER_TURN

_ROUNDING = 1e-8  # of the speed: how mean speeds over whole periods change below is rounding
_AT_REST = 1e-4  # rad: a phase that moves less from window to window is at rest
_BOUNDED_SHARE = 0.2  # of the mean speed: it will not change by more if the rotors are permanently not locked
_SHARE = 0.5  # of the run: the last part, over which is averaged


@dataclass(frozen=True)
class LockingAssessment:
    """The evidence of locking, and numbers for the summary.

    speeds: of all rotors over whole periods in the last half of the run, with their signs. phases: of the other rotors to the
    main one, or of the main rotor to the vibration (key ``vibration``), as sigma phi, means over the last whole periods,
    wrapped to [0, 2 pi). window: begin and end time of that half. smooth_speeds: the same as ``speeds``, for a modulation that
    is cut at the ends. change: the largest between the halves of the window. creep: the motion of the slow phases in the
    second half of it, in rad. final: the final window, in whole beats where rotors turn at different speeds; final_speeds: of
    all rotors there, on a shaken carrier the same as ``speeds``.
    """

    evidence: Locking
    speeds: dict[str, float]
    phases: dict[str, float]
    window: tuple[float, float]
    smooth_speeds: dict[str, float]
    change: float
    creep: float
    final: Blocks
    final_speeds: dict[str, float]


def is_locking(machine: Machine) -> bool:
    """True if a machine is judged by locking: its carrier is shaken harmonically, or several of its rotors are free to turn."""
    free = sum(r.coordinate.prescribed_velocity is None for r in machine.rotors)
    return free > 1 or (free == 1 and machine.shaken_coordinate is not None and machine.shaking_frequency is not None)


def assess_locking(machine: Machine, observation: Observation) -> LockingAssessment | None:
    """Assess mean speeds and phases of a run; None if the main rotor does not make a single period in its last half."""
    main, names = machine.rotor.name, [b.name for b in machine.bodies]
    by_vibration = observation.vibration is not None
    record = observation.rotors[main] if observation.vibration is None else observation.vibration
    leading = [*(["vibration"] if by_vibration else [main]), *(n for n in names if by_vibration or n != main)]
    half = record.whole_turns(_SHARE)
    periods = round((len(half) - 1) * half.size / MARKS_PER_TURN)
    if periods < 1:
        return None

    def rotor_values(values: np.ndarray) -> dict[str, Any]:
        """Select the values of the rotors from those of the leading motion and of its followers."""
        return {r.name: values[leading.index(r.name)] for r in machine.rotors}

    speeds, smooth = (rotor_values((half.sense * x).tolist()) for x in (half.mean_speeds, half.smooth_mean_speeds))
    earlier, later = (rotor_values(part.smooth_mean_speeds) for part in (half.part(slice(len(half) // 2)), half.last(0.5)))
    phases = rotor_phases(machine, half.time, rotor_values(np.array([half.angle, *half.angles])))
    evidence = _evidence(machine, record.whole, periods, rotor_values, observation.noise)
    # Rotors that turn at different speeds have no period in common.
    is_apart = not by_vibration and evidence.is_locked is False
    rows = [leading.index(r.name) for r in machine.rotors if leading.index(r.name)]
    beat = (1.0, 0) if evidence.is_locked or not rows else _slowest_beat(half, rows)
    final = record.final_turns(beat[0])
    final_means = _means_over_beats(half, *beat, final) if is_apart and beat[1] else final.mean_speeds
    return LockingAssessment(
        evidence,
        speeds=smooth if is_apart else speeds,
        phases={name: float(wrap_angle(p[-max(1, len(half) // 10) :].mean())) for name, p in phases.items()},
        window=(float(half.time[0]), float(half.time[-1])),
        smooth_speeds=smooth,
        change=max(float(abs(later[name] - earlier[name])) for name in speeds),
        creep=max((float(abs(p[-1] - p[len(half) // 2])) for p in phases.values()), default=0.0),
        final=final,
        final_speeds=speeds if by_vibration else rotor_values((final.sense * final_means).tolist()),
    )


def _slowest_beat(half: Blocks, rows: Sequence[int]) -> tuple[float, int]:
    """Return the number of turns of the leading motion in its slowest beat with one of the rows, and this row.

    Beats longer than the half of the run are not complete; without a beat it is one turn, with row 0.
    """
    speeds, longest = half.smooth_mean_speeds, len(half) * half.size / MARKS_PER_TURN
    differences = {row: abs(abs(float(speeds[row] / speeds[0])) - 1) for row in rows}
    beats = [(1 / difference, row) for row, difference in differences.items() if difference > 1 / longest]
    return max(beats, default=(1.0, 0))


def _means_over_beats(half: Blocks, beat: float, row: int, final: Blocks) -> np.ndarray:
    """Return the mean speeds (1 + n,) over as many whole beats with a row as the final window has, to a part of a turn."""
    angles = half.sense * np.array([half.angle, *half.angles])
    apart = angles[0] - math.copysign(1.0, half.smooth_mean_speeds[row]) * angles[row]
    way = math.copysign(1.0, apart[-1] - apart[0])
    cycles = max(1, round((len(final) - 1) * final.size / MARKS_PER_TURN / beat))
    before = way * (apart - apart[-1]) + cycles * 2 * math.pi <= 0
    if not before.any():
        return final.mean_speeds
    i = int(np.flatnonzero(before)[-1])
    share = (way * (apart[-1] - apart[i]) - cycles * 2 * math.pi) / (way * (apart[i + 1] - apart[i]))
    begin = np.array([half.time, *angles])[:, i] + share * np.diff(np.array([half.time, *angles])[:, i : i + 2], axis=1)[:, 0]
    return np.asarray((angles[:, -1] - begin[1:]) / (half.time[-1] - begin[0]))


def _evidence(
    machine: Machine, whole: Blocks, periods: int, rotor_values: Callable[[np.ndarray], dict[str, Any]], noise: Noise
) -> Locking:
    """Return what the criteria need. rotor_values: selects those of the rotors from the leading motion and its followers."""
    phases = rotor_phases(machine, whole.time, rotor_values(np.array([whole.angle, *whole.angles])))
    rotor_speeds = rotor_values(np.array([whole.speed, *whole.followers]))
    main, frequency = machine.rotor.name, machine.shaking_frequency
    durations = windows_of(1 / whole.speed).mean(axis=1)
    means = {name: np.abs(windows_of(x / whole.speed).mean(axis=1)) / durations for name, x in rotor_speeds.items()}
    compared_means = [means[main]] if frequency is not None else [x for name, x in means.items() if name != main]
    reference = abs(frequency) if frequency is not None else means[main]
    if not durations.size or not np.isfinite(durations).all():
        return Locking(0, (), ())
    rounding, at_rest = max(_ROUNDING, noise.speed), max(_AT_REST, noise.angle)
    mean_projection = project(means[main], AHEAD, rounding * float(means[main][-1]))
    return Locking(
        periods,
        tuple(_difference_bounds(x / reference - 1, rounding) for x in compared_means),
        tuple(project(windows_of(p).mean(axis=1), AHEAD, at_rest).bounds for p in phases.values()),
        mean_projection.width <= _BOUNDED_SHARE * abs(mean_projection.last),
    )


def _difference_bounds(means: np.ndarray, rounding: float) -> Bounds:
    """Return the bounds between which a difference of speeds will stay: one that mostly falls continues to do so."""
    way = math.copysign(1.0, means[-1])
    p = falling_projection(way * means, AHEAD, rounding)
    return (p.low, p.high) if way > 0 else (-p.high, -p.low)


def rotor_phases(machine: Machine, time: np.ndarray, angles: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return sigma phi (N,) of the main rotor to the vibration (``vibration``), or of other rotors to it. angles: of all."""
    forward_angles = {name: math.copysign(1.0, angle[-1] - angle[0]) * angle for name, angle in angles.items()}
    origin, frequency = forward_angles.pop(machine.rotor.name), machine.shaking_frequency
    return {n: a - origin for n, a in forward_angles.items()} if frequency is None else {"vibration": origin - frequency * time}


def rotor_outcomes(
    machine: Machine, observation: Observation, locking: LockingAssessment
) -> tuple[dict[str, Outcome], Evidence[float] | None]:
    """Return the outcome of each of several rotors that are free to turn, and the evidence of their common motion if locked.

    Rotors that are locked excite the vibration together, in the phases they have, and have one common free speed, at which all
    drives together are in balance. The torques between them, with phases at rest, do not count.
    """
    assessments = _assessments(machine, observation)
    common = _common_evidence(machine, observation, locking, assessments)
    evidence_by_rotor = {name: s.evidence if common is None else _joint_evidence(s, common) for name, s in assessments.items()}
    return {name: classify(e) for name, e in evidence_by_rotor.items()}, common


def turning_outcomes(machine: Machine, observation: Observation) -> dict[str, Outcome]:
    """Return the outcome of each of several rotors that turns, on its own."""
    return {name: classify(s.evidence) for name, s in _assessments(machine, observation).items()}


def _assessments(machine: Machine, observation: Observation) -> dict[str, RotorAssessment]:
    """Return the assessments of the rotors that turn, of several that are free to."""
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    turning = [r for r in free if len(free) > 1 and observation.rotors[r.name].turns >= FEWEST_TURNS]
    end, noise, records = observation.end_time, observation.noise, observation.rotors
    return {r.name: assess_rotor(machine, r, records[r.name], free_speed(machine, r, end), end, noise) for r in turning}


def _common_evidence(
    machine: Machine, observation: Observation, locking: LockingAssessment, assessments: dict[str, RotorAssessment]
) -> Evidence[float] | None:
    """Return the evidence of the common motion of locked rotors; None if they are not locked, or one is not free to turn."""
    record, is_locked = (
        observation.common,
        locking.evidence.is_locked and observation.vibration is None and len(assessments) == len(machine.rotors),
    )
    # Without a drive a rotor may turn either way, but vibration and mean angle are those of one that turns counter-clockwise.
    as_driven = all(locking.speeds[r.name] * sense_of(machine, r) > 0 for r in machine.rotors)
    if not is_locked or not as_driven or record is None or record.turns < FEWEST_TURNS:
        return None
    phases = {
        body.name: locking.phases.get(rotor.name, 0.0) + phase
        for rotor in machine.rotors
        for body, phase in zip(machine.group(rotor), assessments[rotor.name].final_phases, strict=True)
    }
    common_speed, ordered_phases = common_free_speed(machine), np.array([phases[b.name] for b in machine.bodies])
    resonance = Vibration.of(machine).last_maximum(common_speed, ordered_phases)
    evidence = assess_rotor(machine, machine.rotor, record, common_speed, observation.end_time, observation.noise).evidence
    return replace(evidence, resonance=resonance)


def _joint_evidence(assessment: RotorAssessment, common: Evidence[float]) -> Evidence[float]:
    """Return the evidence of a rotor in the common motion, with its bodies, and its modulation if that lasts."""
    rotor_evidence = assessment.evidence
    return replace(
        common,
        has_settled=common.has_settled and not assessment.growing,
        residual=rotor_evidence.residual,
        lags=rotor_evidence.lags,
        modulation=rotor_evidence.modulation if rotor_evidence.is_modulated else common.modulation,
    )
