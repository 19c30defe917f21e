"""One comparison of the study ``approximation``: a run-up of both models."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.outcomes import Outcome
from wucht.studies.deviations import Deviations, at_equal_angle
from wucht.studies.kinds import Progress
from wucht.studies.run_up.both import both_runs, course_of

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.approximation.study import Approximation

CURVE = 400  # samples of a curve over the rotor's angle
_NOWHERE = (np.nan, np.nan)


@dataclass(frozen=True)
class Comparison:
    """What became of both models. value: of the parameter, NaN for the machine's own.

    largest: deviations of speed (of those ``watched``) and amplitude up to ``until_phi``, NaN where the runs have nothing in
    common. relative: the same, relative to the largest speed and the largest distance of the axis of the full run up to there.
    curves (2, CURVE): their magnitudes over the rotor's angle. failure: a sentence, where one of the runs failed.
    """

    value: float
    outcome: str
    slow_outcome: str
    largest: tuple[float, float]
    relative: tuple[float, float]
    curves: np.ndarray
    failure: str = ""

    @property
    def same_outcome(self) -> bool | None:
        """Whether both end alike; None where a run was not long enough to tell."""
        if Outcome.UNIDENTIFIED in (self.outcome, self.slow_outcome) and not self.failure:
            return None
        return self.outcome == self.slow_outcome and not self.failure


def angles(until_phi: float) -> np.ndarray:
    """The rotor's angles (CURVE,) at which the curves are kept."""
    return np.linspace(0.0, until_phi, CURVE)


def comparison(machine: Machine, question: Approximation, value: float, progress: Progress | None = None) -> Comparison:
    """Run both models of a machine. Ctrl-C raises ``KeyboardInterrupt``."""
    full, slow = both_runs(machine, question.run_up(), progress)
    for run in (full, slow):
        if run is not None and not run.attrs["finished"] and not run.attrs["failure"]:
            raise KeyboardInterrupt
    failure = "; ".join(str(r.attrs["failure"]) for r in (full, slow) if r is not None and r.attrs["failure"])
    outcome, other = _outcome(full), "failed" if slow is None else _outcome(slow)
    apart = None if slow is None else at_equal_angle(course_of(machine, full), course_of(machine, slow), question.until_phi)
    if apart is None:
        return Comparison(value, outcome, other, _NOWHERE, _NOWHERE, np.full((2, CURVE), np.nan), failure)
    speed, radius = (
        d / s if s else 0.0 if not d else np.nan for d, s in zip(apart.largest, _scale(machine, full, question), strict=True)
    )
    return Comparison(value, outcome, other, apart.largest, (speed, radius), _curves(apart, question.until_phi), failure)


def _outcome(run: xr.Dataset) -> str:
    return str(json.loads(run.attrs["summary"])["outcome"])


def _scale(machine: Machine, full: xr.Dataset, question: Approximation) -> tuple[float, float]:
    mine = course_of(machine, full)
    inside = mine.angle - mine.angle[0] <= question.until_phi
    return float(np.abs(mine.speed[:, inside]).max()), float(np.abs(mine.radius[inside]).max())


def _curves(found: Deviations, until_phi: float) -> np.ndarray:
    at = angles(until_phi)
    return np.array([np.interp(at, found.at, np.abs(y), np.nan, np.nan) for y in (found.speed, found.radius)])


def restored(earlier: xr.Dataset) -> list[Comparison]:
    """The comparisons in a result of the study, in the order in which they were made: the machine's own first."""
    count = earlier.sizes["value"]
    found = [
        Comparison(
            float(row.value),
            str(row.outcome.values),
            str(row.slow_outcome.values),
            (float(row.speed_deviation), float(row.amplitude_deviation)),
            (float(row.relative_speed_deviation), float(row.relative_amplitude_deviation)),
            np.array([row.speed_over_angle.values, row.amplitude_over_angle.values]),
            str(row.failed.values),
        )
        for row in (earlier.isel(value=k) for k in range(count))
    ]
    return found[-1:] + found[:-1]
