"""An engine of runs with known outcomes, in place of the integration: Schaffer's problem of two parabolas."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.results.outcomes import Outcome
from wucht.studies.ensembles.member_outcomes import OUTCOMES, MemberOutcomes
from wucht.studies.study_file import read_study

MACHINE = read_study("sperling-rollers/figure-9").subject
RANGE = [1e-6, 1e-2]  # of the damping: x from -1 to 3


def x_of(damping: np.ndarray) -> np.ndarray:
    """-1 to 3 over the range, by the logarithm."""
    return np.asarray(np.log10(damping) + 5)


class Parabolas:
    """Settling time x^2, peak (x - 2)^2. captured: where, by x. members: how many were run; full: with the full equations."""

    def __init__(self, captured: Any = lambda x: np.zeros(len(x), bool), offset: float = 0.0) -> None:
        self.captured, self.offset, self.members, self.full = captured, offset, 0, 0

    def __call__(self, question: Any, starts: np.ndarray, values: Any, report: Any = None) -> MemberOutcomes:
        damping = values.get("r1.damping", np.full(starts.shape[1], question.machine.values["r1.damping"]))
        x, count = x_of(damping), starts.shape[1]
        self.members += count
        self.full += count if question.model == "full" else 0
        (report or (lambda _: None))(0.5)
        outcome = np.where(self.captured(x), OUTCOMES.index(Outcome.CAPTURED), OUTCOMES.index(Outcome.COMPENSATED))
        off = self.offset if question.model == "full" else 0.0
        return MemberOutcomes(outcome.astype(np.int8), x**2 + off, (x - 2) ** 2, np.ones(count))
