"""Question and machine -> plan: the axes, and the start and the parameters of the run in each cell."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.varied import check_together
from wucht.dynamics.sampling.ensemble_question import EnsembleQuestion
from wucht.dynamics.sampling.ensemble_run import way_of
from wucht.dynamics.sampling.placed_members import impossible, left_out, members_at
from wucht.machines.machine import Machine
from wucht.studies.basin.map_axes import Axis, axis_of
from wucht.studies.basin.spec import Basin

_PROBES = 64  # cells that are looked at before the first run


@dataclass(frozen=True)
class Plan:
    """axes: over x and over y. question: what is asked of the run in each cell. way: how the runs are integrated, in words."""

    spec: Basin
    machine: Machine
    axes: tuple[Axis, Axis]
    question: EnsembleQuestion
    way: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def periodic(self) -> tuple[bool, bool]:
        """Whether rows and columns of the map close."""
        return self.axes[1].periodic, self.axes[0].periodic

    def shape(self, halvings: int) -> tuple[int, int]:
        """Of the map (y, x)."""
        return self.axes[1].cells * 2**halvings, self.axes[0].cells * 2**halvings

    def starts(self, halvings: int, cells: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """The states (n, M) in which the runs of some cells (M,) of a map begin, and the values (M,) of each parameter.

        cells: their numbers, row by row. Raises ``InputError`` for a value that the machine does not allow.
        """
        rows, columns = np.divmod(cells, self.shape(halvings)[1])
        places = np.array([axis.centres(halvings)[of] for axis, of in zip(self.axes, (columns, rows), strict=True)])
        return members_at(self.machine, self.spec.start, self.axes, places, "study.axes")

    def place(self, cell: int, halvings: int = 0) -> tuple[float, float]:
        """The centre (x, y) of a cell."""
        row, column = divmod(cell, self.shape(halvings)[1])
        return float(self.axes[0].centres(halvings)[column]), float(self.axes[1].centres(halvings)[row])


def prepare(spec: Basin, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    x, y = (axis_of(machine, name, given) for name, given in spec.axes.items())
    initial_state(machine, spec.start)
    check_together((x, y), spec.start, "axes", "the other axis")
    varied = tuple(axis.name for axis in (x, y) if axis.state is None)
    question = EnsembleQuestion(machine, varied, spec.model, spec.inertia, spec.order, spec.until, tolerance=spec.tolerance)
    plan = Plan(spec, machine, (x, y), question)
    return replace(plan, warnings=_left_out(plan), way=way_of(question))


def _left_out(plan: Plan) -> tuple[str, ...]:
    """What the averaged equations leave out.

    Raises ``InputError`` where there are none, where nothing would turn, and where a cell has what the machine does not allow.
    """
    rows, columns = plan.shape(0)
    corners = [0, columns - 1, (rows - 1) * columns, rows * columns - 1]  # what is not allowed is not allowed in a corner
    cells = np.unique([*corners, *np.linspace(0, rows * columns - 1, _PROBES).astype(int)])
    none = impossible(plan.machine, *plan.starts(0, cells))
    place = plan.place(int(next((c for m, c in enumerate(cells) if m not in none), 0)))
    return left_out(plan.question, plan.spec.start, plan.axes, place)
