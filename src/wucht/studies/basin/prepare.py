"""Question and machine -> plan: the axes, and the start and the parameters of the run in each cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.studies.basin.map_axes import Axis, axis_of, check_together, with_states
from wucht.studies.basin.spec import Basin
from wucht.studies.ensembles.ensemble_question import EnsembleQuestion
from wucht.studies.ensembles.ensemble_run import way_of
from wucht.studies.initial_state import initial_state, placed
from wucht.studies.run_up.model import slow_model
from wucht.studies.run_up.prepare import placed_at_start

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
        x, y = (axis.centres(halvings)[of] for axis, of in zip(self.axes, (columns, rows), strict=True))
        values = {axis.name: at for axis, at in zip(self.axes, (x, y), strict=True) if axis.state is None}
        machines: dict[tuple[float, ...], Machine] = {}
        starts = np.empty((len(self.machine.state_names), len(x)))
        for m, place in enumerate(zip(x.tolist(), y.tolist(), strict=True)):
            own = tuple(v for axis, v in zip(self.axes, place, strict=True) if axis.state is None)
            if own not in machines:  # where the carrier rests depends on the parameters
                machines[own] = self.machine_at(place)
            starts[:, m] = initial_state(machines[own], self.start_at(place), "study.axes")
        return starts, values

    def place(self, cell: int, halvings: int = 0) -> tuple[float, float]:
        """The centre (x, y) of a cell."""
        row, column = divmod(cell, self.shape(halvings)[1])
        return float(self.axes[0].centres(halvings)[column]), float(self.axes[1].centres(halvings)[row])

    def machine_at(self, place: tuple[float, float]) -> Machine:
        """The machine with its parameters at a place. Raises ``InputError``."""
        own = {axis.name: v for axis, v in zip(self.axes, place, strict=True) if axis.state is None}
        try:
            return self.machine.with_values(own) if own else self.machine
        except InputError as error:
            raise error.within("study.axes") from None

    def impossible(self, starts: np.ndarray, values: Mapping[str, np.ndarray]) -> dict[int, str]:
        """Why members with these starts (n, M) and values (M,) of parameters cannot be run, by their index.

        The bodies of a track overlap there.
        """
        why: dict[int, str] = {}
        for m, start in enumerate(starts.T if self.machine.tracks else ()):
            own = {name: float(at[m]) for name, at in values.items()}
            try:
                placed(self.machine.with_values(own) if own else self.machine, start)
            except InputError as error:
                why[m] = error.allowed
        return why

    def start_at(self, place: tuple[float, float]) -> dict[str, Any]:
        """The start at a place, as in a study file."""
        own = [(axis.state, v) for axis, v in zip(self.axes, place, strict=True) if axis.state is not None]
        return with_states(self.spec.start, own)


def prepare(spec: Basin, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    x, y = (axis_of(machine, name, given) for name, given in spec.axes.items())
    initial_state(machine, spec.start)
    check_together((x, y), spec.start)
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
    impossible = plan.impossible(*plan.starts(0, cells))
    place = plan.place(int(next((c for m, c in enumerate(cells) if m not in impossible), 0)))
    spec = plan.spec
    machine, initial = placed_at_start(plan.machine_at(place), plan.start_at(place), spec.until or 0.0)
    return () if spec.model == "full" else slow_model(machine, initial, spec.inertia, spec.order).warnings
