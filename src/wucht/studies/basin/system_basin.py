"""A map of the attractors of equations of a table ``[system]``: question and equations -> plan -> findings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.limit_sets.basins import StartOutcomes, start_outcomes
from wucht.dynamics.limit_sets.conservation import CONSERVATIVE, preserves_volume
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.system_states import refuse_machine_keys, state_range, state_row, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.numerics.angles import TURN
from wucht.studies.basin.spec import Basin

_KEYS_OF_MACHINES = ("model", "inertia", "order", "refine")
_WHOLE_TURN = 1e-4  # of a turn


@dataclass(frozen=True)
class StateAxis:
    """An axis of a map. row: of the state in the equations."""

    name: str
    row: int
    low: float
    high: float
    cells: int
    is_angle: bool

    @property
    def is_periodic(self) -> bool:
        """True if the last cell is adjacent to the first: an angle over whole turns."""
        turns = (self.high - self.low) / TURN
        return self.is_angle and round(turns) >= 1 and abs(turns - round(turns)) < _WHOLE_TURN

    @property
    def centres(self) -> np.ndarray:
        """The centres (cells,) of the cells."""
        return np.asarray(self.low + (self.high - self.low) * (np.arange(self.cells) + 0.5) / self.cells)


@dataclass(frozen=True, eq=False)
class SystemBasinPlan:
    """The map. axes: over x and over y. starts: (n, M), of the cells row by row."""

    spec: Basin
    subject: UserSystem
    axes: tuple[StateAxis, StateAxis]
    starts: np.ndarray
    settings: LongRunSettings

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the map (y, x)."""
        return self.axes[1].cells, self.axes[0].cells


@dataclass(frozen=True, eq=False)
class SystemBasinFindings:
    """The finished map."""

    plan: SystemBasinPlan
    outcomes: StartOutcomes


def system_basin_plan(spec: Basin, subject: UserSystem) -> SystemBasinPlan:
    """Return the plan. Raises ``InputError`` where the question does not fit the equations."""
    refuse_machine_keys(spec, _KEYS_OF_MACHINES)
    if preserves_volume(subject):
        raise InputError("system", subject.title or None, f"has no basins: {CONSERVATIVE}", code="conservative")
    start = states_from(subject.system, spec.start, "study.start")
    x, y = (_axis(subject, name, definition) for name, definition in spec.axes.items())
    for name in (*spec.axes, *spec.ranges):
        if name in spec.start or (name in spec.axes and name in spec.ranges):
            raise InputError(f"study.{'start' if name in spec.start else 'ranges'}.{name}", name, "the state is given twice")
    starts = np.repeat(start[:, None], x.cells * y.cells, axis=1)
    rows, columns = np.divmod(np.arange(x.cells * y.cells), x.cells)
    starts[x.row], starts[y.row] = x.centres[columns], y.centres[rows]
    random = np.random.default_rng(spec.seed)
    for name, pair in spec.ranges.items():
        row = state_row(subject.system, name, f"study.ranges.{name}")
        starts[row] = random.uniform(*state_range(name, pair, f"study.ranges.{name}"), starts.shape[1])
    return SystemBasinPlan(spec, subject, (x, y), starts, LongRunSettings(spec.until, spec.tolerance))


def _axis(subject: UserSystem, name: str, definition: tuple[object, object, int]) -> StateAxis:
    location = f"study.axes.{name}"
    row = state_row(subject.system, name, location)
    low, high = state_range(name, definition, location, "must be [lo, hi, cells] with lo below hi")
    return StateAxis(name, row, low, high, definition[2], subject.system.states[row] in subject.system.angles)


def compute_system_basin(plan: SystemBasinPlan, work: Work) -> Iterator[SystemBasinFindings]:
    """Yield the finished map."""

    def report(share: float) -> None:
        work.open_ended.report(share, "all cells")

    unit = partial(start_outcomes, plan.subject, plan.starts, plan.settings, report)
    yield SystemBasinFindings(plan, work.unit("map", unit))
