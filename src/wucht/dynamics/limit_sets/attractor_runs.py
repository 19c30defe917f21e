"""The runs of equations of a table ``[system]`` in the cells of a map, and the attractors that they tend to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from wucht.dynamics.limit_sets.basins import DIVERGES, FAILED, NEUTRAL, NOT_SETTLED, StartOutcomes, start_outcomes
from wucht.dynamics.limit_sets.conservation import CONSERVATIVE, preserves_volume
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.run_ups.run_variations import StartState, VariedQuantity
from wucht.dynamics.system_states import state_row, states_from
from wucht.dynamics.work import TaskReport
from wucht.errors import InputError
from wucht.machines.subject import Subject
from wucht.numerics.angles import TURN
from wucht.schema import Unit

_WITHOUT_ATTRACTOR = {NOT_SETTLED: "unsettled", DIVERGES: "diverges", FAILED: "failed", NEUTRAL: "neutral"}
_MOST = 2048 * 2048  # runs in a unit of work: all of a round, as each may find an attractor that later ones compare with


@dataclass(frozen=True, eq=False)
class AttractorRuns:
    """See ``CellRuns``. start: the states (n,) but for those that differ. until, tolerance: see ``long_run``. known_sets: what
    earlier runs have found."""

    subject: Subject
    start: np.ndarray
    until: float | None
    tolerance: float
    known_sets: tuple[LimitSet, ...] = ()

    number_type: ClassVar[type] = np.int16
    has_named_axes: ClassVar[bool] = False
    readings: ClassVar[Mapping[str, tuple[str, str]]] = {}
    runs_in_a_unit: ClassVar[int] = _MOST

    @classmethod
    def of(cls, subject: Subject, start: Mapping[str, Any], until: float | None, tolerance: float) -> Self:
        """Build them with the states that a study gives. Raises ``InputError``, also for equations without attractors."""
        if preserves_volume(subject):
            raise InputError("system", subject.title or None, f"has no basins: {CONSERVATIVE}", code="conservative")
        return cls(subject, states_from(subject.system, start, "study.start"), until, tolerance)

    @property
    def unstable_labels(self) -> Sequence[int]:
        """See ``CellRuns``: what is unstable."""
        return [k for k, one in enumerate(self.known_sets) if one.attracts is False]

    def labels(self, numbers: np.ndarray) -> dict[int, str]:
        """See ``CellRuns``: the kinds, numbered where there are several of one, that of most starts first."""
        labels = dict(_WITHOUT_ATTRACTOR)
        for kind in {one.kind for one in self.known_sets}:
            of_kind = sorted((k for k, s in enumerate(self.known_sets) if s.kind == kind), key=lambda k: -(numbers == k).sum())
            labels |= {k: f"{kind}-{i + 1}" if len(of_kind) > 1 else str(kind) for i, k in enumerate(of_kind)}
        return {k: labels[k] for k in (*_WITHOUT_ATTRACTOR, *range(len(self.known_sets)))}

    def quantity(self, name: str, key: str) -> VariedQuantity:
        """See ``CellRuns``: a state."""
        system = self.subject.system
        turning = system.states[state_row(system, name, f"study.{key}")] in system.angles
        return VariedQuantity(name, StartState((name,), Unit("", f"state {name}"), name, TURN if turning else None), name, "")

    def doubts(self, quantities: Sequence[VariedQuantity], places: np.ndarray) -> tuple[str, ...]:
        """See ``CellRuns``: equations are taken as they are."""
        return ()

    def outcomes(self, quantities: Sequence[VariedQuantity], places: np.ndarray, report: TaskReport) -> StartOutcomes:
        """See ``CellRuns``."""
        starts, names = np.repeat(self.start[:, None], places.shape[1], axis=1), self.subject.system.state_names
        starts[[names.index(quantity.name) for quantity in quantities]] = places
        return start_outcomes(self.subject, starts, self.until, self.tolerance, report, self.known_sets)

    def with_outcomes(self, outcomes: Sequence[Any]) -> Self:
        """See ``CellRuns``."""
        return replace(self, known_sets=outcomes[-1].attractors) if outcomes else self
