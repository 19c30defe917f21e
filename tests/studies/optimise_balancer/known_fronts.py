"""An engine of runs with known outcomes, in place of the integration: Schaffer's problem of two parabolas."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.studies.study_file import read_study

_OWN, END = 5e-5, 30.0  # damping of the machine as it is; how far each run is followed
MACHINE = read_study("drozdetskaya-2020/r1").subject.with_values({"p1.damping": _OWN, "p2.damping": _OWN})
RANGE = [1e-6, 1e-2]  # of the damping: x from -1 to 3


def x_of(damping: np.ndarray) -> np.ndarray:
    """-1 to 3 over the range, by the logarithm."""
    return np.asarray(np.log10(damping) + 5)


class Parabolas:
    """Settling time x^2, peak (x - 2)^2. captured, open_: which runs are, and which have no verdict, by x and their number.
    members: how many were run; full: with the full equations; starts: with which."""

    def __init__(
        self, captured: Any = None, offset: float = 0.0, open_: Any = None, without: Outcome = Outcome.UNIDENTIFIED
    ) -> None:
        self.captured, self.offset, self.open, self.without = captured, offset, open_, without
        self.members, self.full, self.starts = 0, 0, list[np.ndarray]()

    def __call__(self, question: Any, starts: np.ndarray, values: Any, report: Any = None) -> MemberOutcomes:
        x, count = x_of(values.get("p1.damping", np.full(starts.shape[1], _OWN))), starts.shape[1]
        self.members += count
        self.starts.append(starts)
        self.full += count if question.model == "full" else 0
        (report or (lambda _: None))(0.5)
        outcome = np.full(count, OUTCOMES.index(Outcome.COMPENSATED), np.int8)
        if self.captured is not None:
            outcome[self.captured(x, np.arange(count))] = OUTCOMES.index(Outcome.CAPTURED)
        settling = x**2 + (self.offset if question.model == "full" else 0.0)
        if self.open is not None:
            none = self.open(x, np.arange(count))
            outcome[none], settling[none] = OUTCOMES.index(self.without), np.nan
        return MemberOutcomes(outcome, settling, (x - 2) ** 2, np.full(count, END))
