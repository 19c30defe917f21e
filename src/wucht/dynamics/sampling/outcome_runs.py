"""The runs of a machine in the cells of a map: where they start, and their outcomes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from wucht.dynamics.run_ups.run_variations import VariedQuantity, varied_quantity
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle, is_screened
from wucht.dynamics.sampling.ensemble_run import outcomes_at
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    Start,
    omissions_among,
)
from wucht.dynamics.sampling.outcome_maps import MISSING, CellOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import TaskReport

# Runs in a unit of work: those that are screened in batches; those that are each followed until the end, which take far longer.
_TILE, _SMALL_TILE = {"full": 8192, "slow": 32_768}, 256


@dataclass(frozen=True)
class OutcomeRuns:
    """See ``CellRuns``. question: for the run in each cell. start: the rest of the start."""

    question: EnsembleQuestion
    start: Start

    number_type: ClassVar[type] = np.int8
    has_named_axes: ClassVar[bool] = True
    unstable_labels: ClassVar[Sequence[int]] = ()

    @property
    def readings(self) -> Mapping[str, tuple[str, str]]:
        """See ``CellRuns``."""
        of_mean = ", without ripple" if self.question.model == "slow" else ""  # the amplitude of the averaged vibration
        return {
            "settling_time": ("settling time", "time"),
            "peak_amplitude": (f"peak amplitude{of_mean}", self.question.machine.orbit_unit),
            "end_time": ("time until which the motion was integrated", "time"),
        }

    @property
    def runs_in_a_unit(self) -> int:
        """See ``CellRuns``."""
        is_fast = batching_obstacle(self.question) is None and is_screened(self.question.machine)
        return _TILE[self.question.model] if is_fast else _SMALL_TILE

    def labels(self, numbers: np.ndarray) -> dict[int, str]:
        """See ``CellRuns``: all outcomes, whether they occur or not."""
        return {MISSING: "not-computed", **{k: str(outcome) for k, outcome in enumerate(OUTCOMES)}}

    def quantity(self, name: str, key: str) -> VariedQuantity:
        """See ``CellRuns``: a start state or a parameter."""
        return varied_quantity(self.question.machine, name, key)

    def doubts(self, quantities: Sequence[VariedQuantity], places: np.ndarray) -> tuple[str, ...]:
        """See ``CellRuns``: the effects that averaged equations omit.

        Raises ``InputError`` if there are no such equations, if nothing would turn, and if a value is forbidden.
        """
        return omissions_among(self.question, self.start, quantities, places, "study.axes")

    def outcomes(self, quantities: Sequence[VariedQuantity], places: np.ndarray, report: TaskReport) -> MemberOutcomes:
        """See ``CellRuns``."""
        return outcomes_at(self.question, self.start, quantities, places, "study.axes", report)

    def with_outcomes(self, outcomes: Sequence[CellOutcomes]) -> Self:
        """See ``CellRuns``: the outcomes are the same for all."""
        return self
