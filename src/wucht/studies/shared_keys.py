"""Keys that several studies share: of branches of steady states, of ensembles, of searches, of loads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from wucht.errors import InputError
from wucht.fatigue.damage import WoehlerLine, slope_below
from wucht.schema import SI, Composite, TableModel, Unit, composite, read_quantity, refuse_unknown, si, validate_table
from wucht.studies import key_types as common
from wucht.studies.key_types import Value
from wucht.studies.study import Study

NAMES = ("compensating", "together", "opposed")
_TOLERANCE = 1e-6  # there are many members, and borders of basins are not known more precisely
_KEYS = ("of", "range")
_STEEPEST = 100.0  # slope of a Woehler line: those of materials are 3 to 20
MachineSignalName = Literal["displacement", "spring-force", "bearing-force", "acceleration"]


def _names(raw: Any) -> Any:
    names = [raw] if isinstance(raw, str) else raw
    if not isinstance(names, list | tuple) or not names or any(one not in NAMES for one in names):
        raise ValueError(f"must be one or more of: {', '.join(NAMES)}")
    return tuple(dict.fromkeys(names))


def _ranges(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table: ranges = { STATE = [low, high], ... }")
    ranges = dict[str, tuple[float, float]]()
    for name, pair in raw.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2 or any(isinstance(x, bool) for x in pair):
            raise ValueError(f"must give a pair [low, high] for {name}")
        low, high = (Unit("", f"end of the range of {name}").parse_quantity(x) for x in pair)
        if not low < high:
            raise ValueError(f"must give a pair [low, high] with low below high for {name}")
        ranges[str(name)] = low, high
    return ranges


Ranges = Annotated[
    dict[str, tuple[float, float]],
    BeforeValidator(_ranges),
    Field(description="ranges of the states of a system, by name, in which equilibria are searched for"),
]
Names = Annotated[tuple[str, ...], BeforeValidator(_names), Field(description="names of the steady states to be kept")]


class EnsembleStudy(Study):
    """Spec of a study of the outcomes of many starts or variants of a machine."""

    horizon: ClassVar[tuple[str, ...]] = ("until",)
    tiled: ClassVar[bool] = True
    without_inertia: ClassVar[bool] = True

    start: Composite[common.Start] = composite(
        default_factory=dict, description="common initial state, except for the varied quantities"
    )
    model: Literal["full", "slow"] = Field(default="full", description='the `"full"` equations or the averaged ones (`"slow"`)')
    inertia: common.Inertia | None = None
    order: common.Order = 1
    until: SI[float | None] = si("s", "time", default=None, gt=0, help="duration of each run, by default until it has settled")
    tolerance: common.Tolerance = _TOLERANCE

    @model_validator(mode="before")
    @classmethod
    def _expand_until(cls, raw: Any) -> Any:
        """Accept ``until = "settled"``, the default in words."""
        if isinstance(raw, Mapping) and raw.get("until") == "settled":
            return {k: v for k, v in raw.items() if k != "until"}
        return raw

    def check(self) -> None:
        """Check that keys of averaged equations are given only with them."""
        for key in ("inertia", "order") if self.model == "full" else ():
            if key in self.model_fields_set and getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with model = 'slow'")


def entries_by_path(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """The entries of a table by path: TOML reads ``drive.slope = [...]`` as a table within a table."""
    entries: list[tuple[str, Any]] = []
    for key, value in table.items():
        entries += entries_by_path(value, f"{path}{key}.") if isinstance(value, Mapping) else [(f"{path}{key}", value)]
    return entries


def _vary(raw: Any) -> Any:
    if not isinstance(raw, Mapping) or not raw:
        raise ValueError(
            "must be a table of ranges: vary = { damping = [lo, hi], mass = { of = [BODY, ...], range = [lo, hi] } }"
        )
    return {name: _check_group(f"study.vary.{name}", one) for name, one in _varied_entries(raw)}


def _varied_entries(table: Mapping[str, Any], path: str = "") -> list[tuple[str, Any]]:
    """The varied quantities by name: TOML reads ``b1.damping = [...]`` as a table within a table."""
    entries: list[tuple[str, Any]] = []
    for key, value in table.items():
        is_nested = isinstance(value, Mapping) and not set(value) & set(_KEYS)
        entries += _varied_entries(value, f"{path}{key}.") if is_nested else [(f"{path}{key}", value)]
    return entries


def _check_group(location: str, raw: Any) -> dict[str, Any]:
    table = raw if isinstance(raw, Mapping) else {"range": raw}
    refuse_unknown(table, _KEYS, location)
    names, ends = table.get("of"), table.get("range")
    if not isinstance(ends, list | tuple) or len(ends) != 2 or any(isinstance(e, bool) for e in ends):
        raise InputError(location, ends, "must be a pair [low, high]")
    if names is not None and (not isinstance(names, list | tuple) or not names or not all(isinstance(n, str) for n in names)):
        raise InputError(f"{location}.of", names, "must be a list of names of bodies")
    return {"of": None if names is None else list(names), "range": list(ends)}


Vary = Annotated[dict[str, dict[str, Any]], BeforeValidator(_vary), Field(title="quantities to vary, and their ranges")]


class Woehler(TableModel):
    """A Woehler line N = ND (S/SD)^-k of amplitudes S, half the range."""

    k: SI[float] = si("", "slope of the Woehler line", gt=0, le=_STEEPEST)
    ND: SI[float] = si("cycles", "number of cycles at the knee", gt=0)
    SD: Value = Field(title="amplitude at the knee", description="amplitude at the knee, in the signal's unit")
    miner: Literal["original", "elementary", "haibach"] | None = Field(default=None, description=(
        'damage by amplitudes below the knee: `"original"` none, `"elementary"` the line continues, `"haibach"` with the slope '
        "2 k - 1"
    ))  # fmt: skip
    k2: SI[float | None] = si(
        "", "slope below the knee", default=None, gt=0, le=_STEEPEST, help="slope below the knee, instead of `miner`"
    )

    def check(self, location: str) -> None:
        """Check that there is only one rule for amplitudes below the knee."""
        if self.k2 is not None and self.miner is not None:
            raise InputError(f"{location}.k2", self.k2, "give either k2 or miner")


def woehler_validator(location: str) -> BeforeValidator:
    """Validator that reads a Woehler line from the table at a location."""

    def read_line(raw: Any) -> Any:
        if isinstance(raw, Mapping):
            return validate_table(Woehler, raw, location)
        if raw is not None and not isinstance(raw, Woehler):
            raise ValueError("must be a table: woehler = { k = SLOPE, ND = CYCLES, SD = AMPLITUDE }")
        return raw

    return BeforeValidator(read_line)


def woehler_line(keys: Woehler, unit: str, location: str) -> WoehlerLine:
    """The Woehler line in the signal's unit. location: of its table. Raises ``InputError``."""
    knee = read_quantity(Unit(unit, "amplitude at the knee"), keys.SD, f"{location}.SD")
    if knee <= 0:
        raise InputError(f"{location}.SD", keys.SD, "must be an amplitude greater than 0")
    below = slope_below(keys.k, keys.miner or "elementary") if keys.k2 is None else keys.k2
    return WoehlerLine(keys.k, keys.ND, knee, below)
