"""The types of keys that several studies have: each with its checks, and the sentence on what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from wucht.earlier_names import present_engine
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE
from wucht.schema import Unit
from wucht.schema.key_values import TrueOrFalse, Value, Whole, is_bool, is_whole, validator


def _is_list(raw: Any, of: type = object) -> bool:
    return isinstance(raw, list | tuple) and all(isinstance(one, of) for one in raw)


def _is_path(raw: Any) -> bool:
    return isinstance(raw, str) and raw.strip() != ""


def _to_tables(raw: list[Mapping[str, Any]]) -> tuple[dict[str, Any], ...]:
    return tuple(map(dict, raw))


def _check_order(raw: tuple[float, float]) -> tuple[float, float]:
    if not raw[0] < raw[1]:
        raise ValueError("must be a pair [low, high] with low below high")
    return raw


_start = validator(
    lambda raw: isinstance(raw, Mapping), "must be a table: start = { BODY = ANGLE } or { BODY = { speed = SPEED } }", dict
)
_starts = validator(
    lambda raw: _is_list(raw, Mapping), "must be a list of tables: starts = [{ BODY = ANGLE }, ...]", _to_tables
)
_path = validator(_is_path, "must be the path of a parameter, such as drive.slope")
_values = validator(_is_list, "must be a list of values of the parameter that along names", tuple)
_pair = validator(lambda raw: _is_list(raw) and len(raw) == 2, "must be a pair [low, high]", tuple)
_order = validator(lambda raw: not is_bool(raw) and raw in (1, 2), "must be 1 or 2: the order of the averaged equations", int)
_inertia = validator(is_bool, "must be true or false: true keeps the inertia in the averaged equations")

Start = Annotated[dict[str, Any], _start, Field(title="initial state", description=(
    'angles and speeds at the start by the names of the bodies, `{ p1 = "0.3 rad" }`; by default at rest, hanging under gravity'
))]  # fmt: skip
Starts = Annotated[tuple[dict[str, Any], ...], _starts, Field(title="initial states")]
Path = Annotated[str, _path, Field(title="path of a parameter")]
Values = Annotated[tuple[Value, ...], _values, Field(title="values of the parameter")]
Pair = Annotated[tuple[Value, Value], _pair, Field(title="pair [low, high] of the parameter")]
Interval = Annotated[tuple[float, float], _pair, AfterValidator(_check_order)]  # of a quantity declared by ``si``
Order = Annotated[Literal[1, 2], _order, Field(description=(
    "order of the averaged equations, 1 or 2; they hold over times 1/epsilon, but for undamped librations of rotors or "
    "bodies over a few librations only"
))]  # fmt: skip
Inertia = Annotated[bool, _inertia, Field(description=(
    "whether the averaged equations keep the inertia of the balancing bodies, by default if one of them is not damped"
))]  # fmt: skip
BalancingBodies = Annotated[Literal["steady", "held"] | None, Field(description=(
    'where bodies are: `"steady"`, balancing bodies in the steady phases of each speed, a curve for each configuration, '
    "as in `synchronous-states`, several rotors and the bodies about them in their stable synchronous configurations, a curve "
    "for each, whose phases are the same at all speeds (phases in `start` select the nearest one); "
    '`"held"`, at the phases of `start`, at all speeds. By default steady if these phases are known, else held with a warning'
))]  # fmt: skip
Tolerance = Annotated[
    float,
    BeforeValidator(Unit("", "tolerance").parse_quantity),
    Field(ge=1e-16, le=1e-2, description="tolerance of the integration"),
]
Engine = Annotated[
    Literal["compiled", "radau"],
    BeforeValidator(lambda raw: present_engine(raw) if isinstance(raw, str) else raw),
    Field(description="engine of the integration: compiled, the default, or radau for stiff equations"),
]

__all__ = [
    "DEFAULT_TOLERANCE",
    "BalancingBodies",
    "Engine",
    "Inertia",
    "Interval",
    "Order",
    "Pair",
    "Path",
    "Start",
    "Starts",
    "Tolerance",
    "TrueOrFalse",
    "Value",
    "Values",
    "Whole",
    "is_whole",
]  # fmt: skip
