"""Question and machine -> plan -> findings: the machines, and the runs of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from wucht.analysis.switching import (
    Switching,
    preload_for,
    switchable,
    switching,
    with_rigid_pendulums,
    without_pendulums,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.verdicts.observation import speed_at_largest
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.studies.activation.spec import Activation
from wucht.studies.motion_variables import motion_quantities

SWITCHABLE, BALANCED_VARIANT, RIGID, NO_PENDULUMS = "switchable", "balanced", "rigid", "none"


@dataclass(frozen=True)
class PlannedRun:
    """One run. speed, orientation, phase: their indices in the plan, -1 if it has none."""

    name: str
    of: str
    machine: Machine
    start: Mapping[str, Any]
    settings: RunSettings
    speed: int = -1
    orientation: int = -1
    phase: int = -1

    def case(self) -> RunUpCase:
        """The run, ready to be integrated. Raises ``InputError`` where the start does not fit the machine."""
        return RunUpCase.of(self.machine, self.start, self.settings)


@dataclass(frozen=True)
class Plan:
    """The runs to be made. pendulums: by name. switching: of each, at each activation speed. speeds: of the first pendulum."""

    spec: Activation
    machine: Machine
    pendulums: tuple[str, ...]
    switching: tuple[tuple[Switching, ...], ...]
    phases: tuple[float, ...]
    runs: tuple[PlannedRun, ...]

    @property
    def speeds(self) -> tuple[float, ...]:
        """The activation speeds, those of the first pendulum."""
        return tuple(s[0].opening for s in self.switching)


def prepare(spec: Activation, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    pendulums = switchable(machine)
    if not pendulums:
        requirement = "this study needs a body of kind 'switchable-pendulum'"
        raise InputError("machine.bodies", [b.kind for b in machine.bodies], requirement)
    names = tuple(p.name for p in pendulums)
    for key in (*names, "psi", "delta"):
        if key in spec.start:
            reason = "study.orientations and study.phases say where the switchable pendulums start"
            raise InputError(f"study.start.{key}", spec.start[key], f"not allowed: {reason}")
    machines = [machine] if not spec.activation_speeds else [_machine_opening_at(machine, w) for w in spec.activation_speeds]
    phases = tuple(2 * math.pi * k / spec.phases for k in range(spec.phases))
    runs = [_plan_run(spec, SWITCHABLE, m, names, at, phases) for m, *at in _run_indices(spec, machines)]
    runs = runs if SWITCHABLE in spec.variants else []
    variant_machines = {BALANCED_VARIANT: _without_unbalances(machine), RIGID: with_rigid_pendulums(machine)}
    for of in (BALANCED_VARIANT, RIGID):
        if of in spec.variants:
            runs += [
                _plan_run(spec, of, m, names, (-1, *at[1:]), phases) for m, *at in _run_indices(spec, [variant_machines[of]])
            ]
    if NO_PENDULUMS in spec.variants:
        # With pendulums the study places them: the rotor starts from the same angle without.
        start = spec.start or {"carrier": {}}
        runs.append(PlannedRun(NO_PENDULUMS, NO_PENDULUMS, without_pendulums(machine), start, _settings(spec)))
    for run in runs[:: spec.phases]:  # impossible starts are refused before anything is computed
        run.case()
    switchings = tuple(tuple(switching(m, p) for p in pendulums) for m in machines)
    return Plan(spec, machine, names, switchings, phases, tuple(runs))


def _run_indices(spec: Activation, machines: list[Machine]) -> list[tuple[Machine, int, int, int]]:
    numbers = product(range(len(machines)), range(len(spec.orientations)), range(spec.phases))
    return [(machines[i], i, j, k) for i, j, k in numbers]


def _machine_opening_at(machine: Machine, speed: float) -> Machine:
    return machine.with_values({f"{p.path}.preload": preload_for(machine, p, speed) for p in switchable(machine)})


def _without_unbalances(machine: Machine) -> Machine:
    return machine.with_values({f"{p.path}.permanent_unbalance": 0.0 for p in switchable(machine)})


def _settings(spec: Activation) -> RunSettings:
    return RunSettings(until=spec.until, tolerance=spec.tolerance, engine=spec.engine)


def _plan_run(
    spec: Activation, of: str, machine: Machine, names: tuple[str, ...], at: Sequence[int], phases: tuple[float, ...]
) -> PlannedRun:
    """Plan the run with the indices ``at``: of the activation speed, the orientation, the phase."""
    _, j, k = at
    separation, middle = spec.orientations[j], (len(names) - 1) / 2
    angles = {name: phases[k] + (i - middle) * separation for i, name in enumerate(names)}
    return PlannedRun(f"{of} {' '.join(map(str, at))}", of, machine, dict(spec.start) | angles, _settings(spec), *at)


CURVE = 400  # points of the amplitude over the speed
_STOP_SHARE, _OPEN_SHARE = 0.01, 0.5  # of the stroke: below, the mass is at the inner stop; beyond, the pendulum is open


@dataclass(frozen=True)
class ActivationRun:
    """Results of a run.

    peak, peak_before, peak_after: the largest amplitude of all, before the first opening, and from it on (NaN if none opens).
    peak_speed: of the rotor, its mean over the turn about the peak (NaN where that lies in no whole turn). opened_at: speed of
    each switchable pendulum as its mass leaves the inner stop before
    it opens for the first time; open_at_end: whether it is open then. orientation: the angle from the first pendulum to the
    second as the first of all opens, in rad. curve: speed of the rotor, and the largest amplitude near it, (2, CURVE).
    """

    outcome: str
    final_speed: float
    final_amplitude: float
    peak: float
    peak_before: float
    peak_after: float
    peak_speed: float
    opened_at: tuple[float, ...]
    open_at_end: tuple[bool, ...]
    orientation: float
    energy_residual: float
    failure: str | None
    curve: np.ndarray


@dataclass(frozen=True)
class Findings:
    """The completed runs by name."""

    results: dict[str, ActivationRun]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compute the runs, each of which is a unit of work."""
    results: dict[str, ActivationRun] = {}
    yield Findings({})
    for k, planned_run in enumerate(plan.runs):
        part = work.part("", k / len(plan.runs), (k + 1) / len(plan.runs))
        results[planned_run.name] = part.unit(planned_run.name, partial(_compute_run, planned_run, plan.pendulums, part.report))
        part.report(1.0, planned_run.of)
        yield Findings(dict(results))


def _compute_run(planned_run: PlannedRun, pendulums: tuple[str, ...], report: Callable[[float, str], None]) -> ActivationRun:
    case = planned_run.case()
    for (motion,) in run_up(case, Work()):
        report(min(motion.last.trajectory.end_time / case.horizon.expected_end, 1.0), planned_run.of)
    data = {
        q.name: q.value for q in motion_quantities(case.machine, motion.rows, motion.machine_motion, motion.observation.largest)
    }
    speed, angle = (dict(zip(data["body"], data[key], strict=True)) for key in ("speed", "angle"))
    rotor, amplitude = np.abs(speed[case.machine.rotor.name]), np.asarray(data["amplitude"])
    stroke = _strokes(case.machine, pendulums) if planned_run.of in (SWITCHABLE, BALANCED_VARIANT) else {}
    slider_shares = {
        x.name: motion.rows[x.coordinate.position.name] / stroke[x.name] for x in case.machine.sliders if x.name in stroke
    }
    opening = {name: _opening(s) for name, s in slider_shares.items()}
    first = min((i for i in opening.values() if i is not None), default=None)
    pendulum_angles = [float(angle[n][first]) for n in pendulums[:2]] if first is not None else []
    peak_speed = speed_at_largest(case.machine, motion.observation)
    return ActivationRun(
        str(motion.verdict.outcome),
        motion.verdict.speed,
        float(amplitude[-1]),
        motion.observation.largest,
        math.nan if first is None else float(amplitude[: first + 1].max()),
        math.nan if first is None else float(amplitude[first:].max()),
        math.nan if peak_speed is None else abs(peak_speed),
        tuple(math.nan if (i := opening[n]) is None else float(abs(speed[n][i])) for n in pendulums if n in opening),
        tuple(bool(slider_shares[n][-1] > _OPEN_SHARE) for n in pendulums if n in slider_shares),
        (pendulum_angles[1] - pendulum_angles[0]) % (2 * math.pi) if len(pendulum_angles) == 2 else math.nan,
        float(np.max(data["energy_residual"])),
        motion.trajectory.failure,
        _curve(motion.machine_motion.time, rotor, amplitude),
    )


def _strokes(machine: Machine, pendulums: tuple[str, ...]) -> dict[str, float]:
    return {n: machine.values[f"{n}.outer_stop"] - machine.values[f"{n}.inner_stop"] for n in pendulums}


def _opening(share: np.ndarray) -> int | None:
    """Index of the last sample at the inner stop before the pendulum opens for the first time. share: of the stroke (N,)."""
    is_out = share > _OPEN_SHARE
    if not is_out.any():
        return None
    return int(np.flatnonzero(share[: int(is_out.argmax())] <= _STOP_SHARE).max(initial=0))


def _curve(time: np.ndarray, speed: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Speed and amplitude at the largest amplitude of successive parts of the run (2, CURVE).

    In all parts the change of the speed and the duration, as shares of those of the whole run, have the same sum.
    """
    speed_path = np.append(0.0, np.cumsum(np.abs(np.diff(speed))))
    progress = speed_path / (speed_path[-1] or 1.0) + (time - time[0]) / ((time[-1] - time[0]) or 1.0)
    bounds = np.unique(np.searchsorted(progress, np.linspace(0.0, progress[-1], CURVE + 1)))
    at = [a + int(amplitude[a:b].argmax()) for a, b in pairwise(bounds.tolist())]
    curve = np.full((2, CURVE), math.nan)
    curve[:, : len(at)] = speed[at], amplitude[at]
    return curve
