"""The keys of studies that ask for a load of a machine, and for the damage that it does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.fatigue.damage import WoehlerLine, slope_below
from wucht.schema import Described, Unit, checked, read_quantity, si
from wucht.studies.spec import Quantity

_STEEPEST = 100.0  # slope of a Woehler line: those of materials are 3 to 20
MachineSignalName = Literal["displacement", "spring-force", "bearing-force", "acceleration"]


class Woehler(Described):
    """A Woehler line N = ND (S/SD)^-k of amplitudes S, half the range."""

    k: float = si("", "slope of the Woehler line", gt=0, le=_STEEPEST)
    ND: float = si("cycles", "number of cycles at the knee", gt=0)
    SD: Quantity = Field(title="amplitude at the knee", description="amplitude at the knee, in the signal's unit")
    miner: Literal["original", "elementary", "haibach"] | None = Field(None, description=(
        'what amplitudes below the knee do: `"original"` nothing, `"elementary"` the line goes on, `"haibach"` with the slope '
        "2 k - 1"
    ))  # fmt: skip
    k2: float | None = si(
        "", "slope below the knee", default=None, gt=0, le=_STEEPEST, help="slope below the knee, instead of `miner`"
    )

    def check(self, where: str) -> None:
        """One rule for what lies below the knee."""
        if self.k2 is not None and self.miner is not None:
            raise InputError(f"{where}.k2", self.k2, "give either k2 or miner")


def woehler_at(where: str) -> BeforeValidator:
    """Reads a Woehler line from the table at a place."""

    def read(given: Any) -> Any:
        if isinstance(given, Mapping):
            return checked(Woehler, given, where)
        if given is not None and not isinstance(given, Woehler):
            raise ValueError("must be a table: woehler = { k = SLOPE, ND = CYCLES, SD = AMPLITUDE }")
        return given

    return BeforeValidator(read)


def woehler_line(given: Woehler, unit: str, where: str) -> WoehlerLine:
    """The Woehler line in the signal's unit. where: its table. Raises ``InputError``."""
    knee = read_quantity(Unit(unit, "amplitude at the knee"), given.SD, f"{where}.SD")
    if knee <= 0:
        raise InputError(f"{where}.SD", given.SD, "must be an amplitude greater than 0")
    below = slope_below(given.k, given.miner or "elementary") if given.k2 is None else given.k2
    return WoehlerLine(given.k, given.ND, knee, below)
