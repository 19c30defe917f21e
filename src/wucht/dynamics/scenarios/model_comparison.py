"""Comparison of the full and the averaged equations: a run-up of both from one start, and their deviations."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.run_ups.deviations import compared_motion, deviations_by_angle
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work

CURVE = 400  # samples of a curve over the rotor's angle


@dataclass(frozen=True)
class ModelComparison:
    """Comparison of the runs of both models. value: of the parameter, NaN for the nominal machine.

    largest: deviations of the compared speeds and of the amplitude up to ``until_phi``, NaN if the runs have no angle in
    common. relative: the same, relative to the largest speed and the largest distance of the axis of the full run up to there.
    curves (2, CURVE): their magnitudes over the rotor's angle. failure: a sentence, if one of the runs failed.
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
        """True if both have the same outcome; None if a run was too short for one."""
        if Outcome.UNIDENTIFIED in (self.outcome, self.slow_outcome) and not self.failure:
            return None
        return self.outcome == self.slow_outcome and not self.failure


def angles_at_curves(until_phi: float) -> np.ndarray:
    """The rotor's angles (CURVE,) at which the curves are stored."""
    return np.linspace(0.0, until_phi, CURVE)


def compare_models(case: RunUpCase, value: float, until_phi: float, work: Work) -> ModelComparison:
    """Run both models of a case, at a value of the parameter. Raises ``KeyboardInterrupt`` if the user interrupts."""
    # Only the comparison is stored: the legs of its two runs would take some ten megabytes each time.
    [motions] = deque(run_up(case, work.without_memory), maxlen=1)
    failure = "; ".join(m.trajectory.failure for m in motions if m.trajectory.failure)
    outcome, slow_outcome, *_ = [*(str(m.verdict.outcome) for m in motions), str(Outcome.FAILED)]
    at, courses = angles_at_curves(until_phi), [compared_motion(m) for m in motions]
    deviations = deviations_by_angle(courses[0], courses[1], until_phi) if len(courses) == 2 else None
    largest = relative = (math.nan, math.nan)
    curves = np.full((2, CURVE), np.nan)
    if deviations is not None:
        largest, inside = deviations.largest, courses[0].angle - courses[0].angle[0] <= until_phi
        largest_values = (float(np.abs(y[..., inside]).max()) for y in (courses[0].speed, courses[0].radius))
        speed, radius = (d / of if of else math.nan if d else 0.0 for d, of in zip(largest, largest_values, strict=True))
        relative = speed, radius
        curves = np.array(
            [np.interp(at, deviations.abscissa, np.abs(y), np.nan, np.nan) for y in (deviations.speed, deviations.radius)]
        )
    return ModelComparison(value, outcome, slow_outcome, largest, relative, curves, failure)
