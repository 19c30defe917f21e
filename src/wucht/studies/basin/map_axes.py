"""The axes of a map: their ranges, and the centres of its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.dynamics.parameters import range_of
from wucht.dynamics.run_ups.varied import Varied, varied_of
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.studies.spec import Quantity

VARIABLES = ("outcome", "settling_time", "peak_amplitude", "end_time", "level")  # of a map; its axes have other names
_WHOLE_TURN = 1e-4  # of a period: so nearly an axis that goes round is taken to close


@dataclass(frozen=True)
class Axis(Varied):
    """low, high: its ends, in SI. cells: of the coarsest map."""

    low: float
    high: float
    cells: int

    @property
    def periodic(self) -> bool:
        """Whether its last cell is beside its first: an angle over whole turns."""
        if self.state is None or self.state.period is None:
            return False
        turns = (self.high - self.low) / self.state.period
        return round(turns) >= 1 and abs(turns - round(turns)) < _WHOLE_TURN

    @property
    def angle(self) -> bool:
        """Whether it is an angle."""
        return self.unit == "rad" or (self.state is not None and self.state.period is not None)

    def centres(self, halvings: int = 0) -> np.ndarray:
        """The centres (cells 2^halvings,) of its cells."""
        count = self.cells * 2**halvings
        return np.asarray(self.low + (self.high - self.low) * (np.arange(count) + 0.5) / count)


def axis_of(machine: Machine, name: str, given: tuple[Quantity, Quantity, int]) -> Axis:
    """An axis by its name, which is that of a dimension of the map. Raises ``InputError`` at ``study.axes.<name>``."""
    key = f"axes.{name}"
    if name.removeprefix("refined_") in VARIABLES:
        raise InputError(f"study.{key}", name, "not allowed: a variable of the result has this name; rename the body")
    one = varied_of(machine, name, key)
    low, high = range_of(one.quantity, given[:2], key)
    return Axis(one.name, one.state, one.what, one.unit, low, high, given[2])
