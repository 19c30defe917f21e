"""One comparison of the study ``approximation``: a run-up of both models."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.run_ups.deviations import at_equal_angle, course_of
from wucht.dynamics.run_ups.run_up import run_up
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.studies.approximation.prepare import Plan

CURVE = 400  # samples of a curve over the rotor's angle


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
    """The rotor's angles (CURVE,) at which the curves are stored."""
    return np.linspace(0.0, until_phi, CURVE)


def comparison(plan: Plan, k: int, work: Work) -> Comparison:
    """Run both models of the k-th case. Raises ``KeyboardInterrupt`` where the user has asked to stop."""
    # What is remembered is the comparison: the legs of its two runs would be some ten megabytes each time.
    [motions] = deque(run_up(plan.cases[k], work.unkept), maxlen=1)
    failure = "; ".join(m.trajectory.failure for m in motions if m.trajectory.failure)
    outcome, slow_outcome, *_ = [*(str(m.verdict.outcome) for m in motions), str(Outcome.FAILED)]
    until, at, courses = plan.spec.until_phi, angles(plan.spec.until_phi), [course_of(m) for m in motions]
    apart = at_equal_angle(courses[0], courses[1], until) if len(courses) == 2 else None
    largest = relative = (math.nan, math.nan)
    curves = np.full((2, CURVE), np.nan)
    if apart is not None:
        largest, inside = apart.largest, courses[0].angle - courses[0].angle[0] <= until
        reached = (float(np.abs(y[..., inside]).max()) for y in (courses[0].speed, courses[0].radius))
        speed, radius = (d / of if of else math.nan if d else 0.0 for d, of in zip(largest, reached, strict=True))
        relative = speed, radius
        curves = np.array([np.interp(at, apart.at, np.abs(y), np.nan, np.nan) for y in (apart.speed, apart.radius)])
    return Comparison(plan.values[k], outcome, slow_outcome, largest, relative, curves, failure)
