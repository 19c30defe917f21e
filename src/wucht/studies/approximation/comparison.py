"""One comparison of the study ``approximation``: a run-up of both models."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from wucht.results.outcomes import Outcome
from wucht.studies.approximation.prepare import Plan
from wucht.studies.deviations import Course, Deviations, at_equal_angle
from wucht.studies.memory import Memory
from wucht.studies.run_up.both import course_of
from wucht.studies.run_up.run import run_case
from wucht.studies.work import Work

CURVE = 400  # samples of a curve over the rotor's angle
_NOWHERE = (math.nan, math.nan)


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


def comparison(plan: Plan, k: int, work: Work) -> Comparison:
    """Run both models of the k-th case. Raises ``KeyboardInterrupt`` where the user has asked to stop."""
    # What is remembered is the comparison: the legs of its two runs would be some ten megabytes each time.
    [motions] = deque(run_case(plan.run_up, plan.cases[k], replace(work, memory=Memory())), maxlen=1)
    failure = "; ".join(m.trajectory.failure for m in motions if m.trajectory.failure)
    outcome, slow_outcome, *_ = [*(str(m.verdict.outcome) for m in motions), str(Outcome.FAILED)]
    value, until, courses = plan.values[k], plan.spec.until_phi, [course_of(m) for m in motions]
    apart = at_equal_angle(courses[0], courses[1], until) if len(courses) == 2 else None
    if apart is None:
        return Comparison(value, outcome, slow_outcome, _NOWHERE, _NOWHERE, np.full((2, CURVE), np.nan), failure)
    speed, radius = (_share(d, of) for d, of in zip(apart.largest, _largest(courses[0], until), strict=True))
    return Comparison(value, outcome, slow_outcome, apart.largest, (speed, radius), _curves(apart, until), failure)


def _largest(full: Course, until_phi: float) -> tuple[float, float]:
    """The largest speed and distance of the axis, up to an angle."""
    inside = full.angle - full.angle[0] <= until_phi
    return float(np.abs(full.speed[:, inside]).max()), float(np.abs(full.radius[inside]).max())


def _share(part: float, whole: float) -> float:
    if not whole:
        return math.nan if part else 0.0
    return part / whole


def _curves(apart: Deviations, until_phi: float) -> np.ndarray:
    at = angles(until_phi)
    return np.array([np.interp(at, apart.at, np.abs(y), np.nan, np.nan) for y in (apart.speed, apart.radius)])
