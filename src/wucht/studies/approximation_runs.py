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
from wucht.studies.run_up_both import both_runs, course_of

if TYPE_CHECKING:
    from wucht.studies.approximation import Approximation


@dataclass(frozen=True)
class Comparison:
    """What became of both models. value: of the parameter, NaN for the machine's own.

    deviations: up to ``until_phi``, None where the runs have nothing in common. scale: the largest speed and the largest
    distance of the axis of the full run up to there. failure: a sentence, where one of them failed.
    """

    value: float
    outcome: str
    slow_outcome: str
    deviations: Deviations | None
    scale: tuple[float, float]
    failure: str = ""

    @property
    def same_outcome(self) -> bool | None:
        """Whether both end alike; None where neither run was long enough to tell."""
        if self.outcome == self.slow_outcome == Outcome.UNIDENTIFIED and not self.failure:
            return None
        return self.outcome == self.slow_outcome and not self.failure

    @property
    def largest(self) -> tuple[float, float]:
        """Largest deviations of speed and amplitude, NaN where there are none."""
        return self.deviations.largest if self.deviations is not None else (np.nan, np.nan)

    @property
    def relative(self) -> tuple[float, float]:
        """The same, relative to the largest speed and amplitude."""
        speed, amplitude = (d / s if s else np.nan for d, s in zip(self.largest, self.scale, strict=True))
        return speed, amplitude


def comparison(machine: Machine, question: Approximation, value: float, progress: Progress | None = None) -> Comparison:
    """Run both models of a machine. Ctrl-C raises ``KeyboardInterrupt``."""
    full, slow = both_runs(machine, question.run_up(), progress)
    for run in (full, slow):
        if run is not None and not run.attrs["finished"] and not run.attrs["failure"]:
            raise KeyboardInterrupt
    failures = [str(r.attrs["failure"]) for r in (full, slow) if r is not None and r.attrs["failure"]]
    outcome = json.loads(full.attrs["summary"])["outcome"]
    if slow is None:
        return Comparison(value, outcome, "failed", None, (np.nan, np.nan), "; ".join(failures))
    mine, other = course_of(machine, full), course_of(machine, slow)
    until = question.until_phi
    inside = mine.angle - mine.angle[0] <= until
    scale = float(np.abs(mine.speed[inside]).max()), float(np.abs(mine.radius[inside]).max())
    return Comparison(
        value,
        outcome,
        json.loads(slow.attrs["summary"])["outcome"],
        at_equal_angle(mine, other, until),
        scale,
        "; ".join(failures),
    )
