"""Keys that several studies share: of branches of steady states, of ensembles, of searches, of loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from wucht.errors import InputError
from wucht.fatigue.damage import WoehlerLine, slope_below
from wucht.schema import Described, Unit, checked, read_quantity, refuse_unknown, si
from wucht.studies import spec as common
from wucht.studies.spec import Value

NAMES = ("compensating", "together", "opposed")
VALUES = ("value", "second_value")
_TOLERANCE = 1e-6  # there are many members, and borders of basins are not known more precisely
_KEYS = ("of", "range")
_STEEPEST = 100.0  # slope of a Woehler line: those of materials are 3 to 20
MachineSignalName = Literal["displacement", "spring-force", "bearing-force", "acceleration"]


def with_values(
    entry: Mapping[str, Any], paths: Sequence[str], values: Sequence[float], optional: Sequence[str] = ()
) -> dict[str, Any]:
    """Add the values of its parameters to an entry of a summary: under ``value`` and ``second_value``, and under their names.

    A name that is also another key of the table keeps that meaning. optional: keys of only some entries of the table.
    """
    named = {path: value for path, value in zip(paths, values, strict=True) if path not in optional}
    return named | dict(zip(VALUES, values, strict=False)) | dict(entry)


def _names(given: Any) -> Any:
    listed = [given] if isinstance(given, str) else given
    if not isinstance(listed, list | tuple) or not listed or any(one not in NAMES for one in listed):
        raise ValueError(f"must be one or more of: {', '.join(NAMES)}")
    return tuple(dict.fromkeys(listed))


def _ranges(given: Any) -> Any:
    if not isinstance(given, Mapping):
        raise ValueError("must be a table: ranges = { STATE = [low, high], ... }")
    read = dict[str, tuple[float, float]]()
    for name, pair in given.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2 or any(isinstance(x, bool) for x in pair):
            raise ValueError(f"must give a pair [low, high] for {name}")
        low, high = (Unit("", f"end of the range of {name}").parse(x) for x in pair)
        if not low < high:
            raise ValueError(f"must give a pair [low, high] with low below high for {name}")
        read[str(name)] = low, high
    return read


Ranges = Annotated[
    dict[str, tuple[float, float]],
    BeforeValidator(_ranges),
    Field(description="ranges of the states of a system, by name, in which equilibria are searched"),
]
Names = Annotated[tuple[str, ...], BeforeValidator(_names), Field(description="names of the steady states to be kept")]


class EnsembleSpec(common.Spec):
    """Spec of a study of the outcomes of many starts or variants of a machine."""

    horizon: ClassVar[tuple[str, ...]] = ("until",)
    tiled: ClassVar[bool] = True
    without_inertia: ClassVar[bool] = True

    start: common.Start = Field(default_factory=dict, description="common initial state, except for the varied quantities")
    model: Literal["full", "slow"] = Field("full", description='the `"full"` equations or the averaged ones (`"slow"`)')
    inertia: common.Inertia | None = None
    order: common.Order = 1
    until: float | None = si("s", "time", default=None, gt=0, help="duration of each run, by default until it has settled")
    tolerance: common.Tolerance = _TOLERANCE

    @model_validator(mode="before")
    @classmethod
    def _until_settled(cls, given: Any) -> Any:
        """Accept ``until = "settled"``, the default in words."""
        if isinstance(given, Mapping) and given.get("until") == "settled":
            return {k: v for k, v in given.items() if k != "until"}
        return given

    def check(self) -> None:
        """Check that keys of averaged equations are given only with them."""
        for key in ("inertia", "order") if self.model == "full" else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with model = 'slow'")


def paths_of(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """The entries of a table by path: TOML reads ``drive.slope = [...]`` as a table within a table."""
    given: list[tuple[str, Any]] = []
    for key, value in table.items():
        given += paths_of(value, f"{path}{key}.") if isinstance(value, Mapping) else [(f"{path}{key}", value)]
    return given


def _vary(given: Any) -> Any:
    if not isinstance(given, Mapping) or not given:
        raise ValueError(
            "must be a table of ranges: vary = { damping = [lo, hi], mass = { of = [BODY, ...], range = [lo, hi] } }"
        )
    return {name: _group(f"study.vary.{name}", one) for name, one in _by_path(given)}


def _by_path(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """The varied quantities by name: TOML reads ``b1.damping = [...]`` as a table within a table."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        nested = isinstance(value, Mapping) and not set(value) & set(_KEYS)
        found += _by_path(value, f"{path}{key}.") if nested else [(f"{path}{key}", value)]
    return found


def _group(where: str, given: Any) -> dict[str, Any]:
    table = given if isinstance(given, Mapping) else {"range": given}
    refuse_unknown(table, _KEYS, where)
    names, ends = table.get("of"), table.get("range")
    if not isinstance(ends, list | tuple) or len(ends) != 2 or any(isinstance(e, bool) for e in ends):
        raise InputError(where, ends, "must be a pair [low, high]")
    if names is not None and (not isinstance(names, list | tuple) or not names or not all(isinstance(n, str) for n in names)):
        raise InputError(f"{where}.of", names, "must be a list of names of bodies")
    return {"of": None if names is None else list(names), "range": list(ends)}


Vary = Annotated[dict[str, dict[str, Any]], BeforeValidator(_vary), Field(title="quantities to vary, and their ranges")]


class Woehler(Described):
    """A Woehler line N = ND (S/SD)^-k of amplitudes S, half the range."""

    k: float = si("", "slope of the Woehler line", gt=0, le=_STEEPEST)
    ND: float = si("cycles", "number of cycles at the knee", gt=0)
    SD: Value = Field(title="amplitude at the knee", description="amplitude at the knee, in the signal's unit")
    miner: Literal["original", "elementary", "haibach"] | None = Field(None, description=(
        'damage by amplitudes below the knee: `"original"` none, `"elementary"` the line continues, `"haibach"` with the slope '
        "2 k - 1"
    ))  # fmt: skip
    k2: float | None = si(
        "", "slope below the knee", default=None, gt=0, le=_STEEPEST, help="slope below the knee, instead of `miner`"
    )

    def check(self, where: str) -> None:
        """Check that there is only one rule for amplitudes below the knee."""
        if self.k2 is not None and self.miner is not None:
            raise InputError(f"{where}.k2", self.k2, "give either k2 or miner")


def woehler_at(where: str) -> BeforeValidator:
    """Validator that reads a Woehler line from the table at a location."""

    def read(given: Any) -> Any:
        if isinstance(given, Mapping):
            return checked(Woehler, given, where)
        if given is not None and not isinstance(given, Woehler):
            raise ValueError("must be a table: woehler = { k = SLOPE, ND = CYCLES, SD = AMPLITUDE }")
        return given

    return BeforeValidator(read)


def woehler_line(given: Woehler, unit: str, where: str) -> WoehlerLine:
    """The Woehler line in the signal's unit. location: of its table. Raises ``InputError``."""
    knee = read_quantity(Unit(unit, "amplitude at the knee"), given.SD, f"{where}.SD")
    if knee <= 0:
        raise InputError(f"{where}.SD", given.SD, "must be an amplitude greater than 0")
    below = slope_below(given.k, given.miner or "elementary") if given.k2 is None else given.k2
    return WoehlerLine(given.k, given.ND, knee, below)
