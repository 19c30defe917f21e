"""Run-ups of a machine with switchable pendulums, and of its variants: what becomes of each run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.verdicts.observation import speed_at_largest
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine
from wucht.studies.motion_variables import motion_quantities

SWITCHABLE, BALANCED_VARIANT, RIGID, NO_PENDULUMS = "switchable", "balanced", "rigid", "none"
CURVE = 400  # points of the amplitude over the speed
_STOP_SHARE, _OPEN_SHARE = 0.01, 0.5  # of the stroke: below, the mass is at the inner stop; beyond, the pendulum is open


@dataclass(frozen=True)
class ActivationCase:
    """One run. of: the variant. speed, orientation, phase: their indices, -1 if it has none."""

    of: str
    machine: Machine
    start: Mapping[str, Any]
    settings: RunSettings
    speed: int = -1
    orientation: int = -1
    phase: int = -1

    @property
    def cell(self) -> tuple[str, int, int, int]:
        """Its variant and indices."""
        return self.of, self.speed, self.orientation, self.phase

    def run_up_case(self) -> RunUpCase:
        """Return the run, ready to be integrated. Raises ``InputError`` where the start does not fit the machine."""
        return RunUpCase.of(self.machine, self.start, self.settings)


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


def activation_runs(pendulums: tuple[str, ...], case: ActivationCase, work: Work) -> Iterator[ActivationRun]:
    """Yield the one run of a case, a unit of work. pendulums: names of the switchable ones."""
    result = work.unit("run", partial(_compute_run, case, pendulums, work.report))
    work.report(1.0, case.of)
    yield result


def _compute_run(
    planned_run: ActivationCase, pendulums: tuple[str, ...], report: Callable[[float, str], None]
) -> ActivationRun:
    case = planned_run.run_up_case()
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
