"""Keys of ``[study]`` that several studies have, and quantities in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.errors import InputError, nearest
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.machines.parts.fields import Parameter
from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE
from wucht.quantities import Unit


def quantity(table: Mapping[str, Any], key: str, unit: Unit) -> float | None:
    """The value of a key, None if it is not given. Raises ``InputError``."""
    given = table.get(key)
    if given is None:
        return None
    try:
        return unit.parse(given)
    except ValueError as error:
        raise InputError(f"study.{key}", given, str(error)) from None


def allowed_value(machine: Machine, path: str, value: float, where: str) -> None:
    """Raises ``InputError`` where the part to which a parameter belongs does not allow a value."""
    check_values(machine.parts, {path: value}, where)


def positive(table: Mapping[str, Any], key: str, unit: Unit) -> float | None:
    """The value of a key, greater than 0, None if it is not given. Raises ``InputError``."""
    value = quantity(table, key, unit)
    if value is not None and value <= 0:
        raise InputError(f"study.{key}", table[key], f"allowed is {_a(unit.what)} greater than 0")
    return value


def _a(noun: str) -> str:
    return f"{'an' if noun[:1] in 'aeio' else 'a'} {noun}"


def span(table: Mapping[str, Any], key: str, unit: Unit) -> tuple[float, float] | None:
    """A pair [low, high], None if it is not given. Raises ``InputError``."""
    given = table.get(key)
    if given is None:
        return None
    if not isinstance(given, list) or len(given) != 2:
        raise InputError(f"study.{key}", given, f"allowed is a pair [low, high] of a {unit.what}")
    low, high = (quantity({f"{key}[{i}]": g}, f"{key}[{i}]", unit) or 0.0 for i, g in enumerate(given))
    if not low < high:
        raise InputError(f"study.{key}", given, "allowed is a pair [low, high] with low below high")
    return low, high


def parameter(table: Mapping[str, Any], key: str, machine: Machine) -> Parameter:
    """The parameter of the machine that a key names. Raises ``InputError``."""
    given = table.get(key)
    if given is None:
        raise InputError(f"study.{key}", None, "this key is missing; needed is the path of a parameter, such as drive.slope")
    if not isinstance(given, str) or given not in machine.parameters:
        raise InputError(f"study.{key}", given, f"unknown parameter; {nearest(str(given), machine.parameters)}")
    if any(s.parameter == given for s in machine.schedules):
        raise InputError(f"study.{key}", given, "not allowed: this parameter follows a schedule")
    return machine.parameters[given]


ENGINES = ("heyoka", "scipy", "scipy-radau")


def within(table: Mapping[str, Any], key: str, default: float, low: float, high: float) -> float:
    """A number between two limits. Raises ``InputError``."""
    given = positive(table, key, Unit("", key.replace("_", " "))) or default
    if not low <= given <= high:
        raise InputError(f"study.{key}", given, f"allowed is between {low:g} and {high:g}")
    return given


def whole(table: Mapping[str, Any], key: str, default: int, low: int, high: int) -> int:
    """A whole number between two limits; ``5.0``, as ``--set`` has it, is one. Raises ``InputError``."""
    given = table.get(key, default)
    number = isinstance(given, int | float) and not isinstance(given, bool)
    if not number or not low <= given <= high or given != int(given):
        raise InputError(f"study.{key}", given, f"allowed is a whole number from {low} to {high}")
    return int(given)


def tolerance_of(table: Mapping[str, Any]) -> float:
    """The tolerance of the integration. Raises ``InputError``."""
    return within(table, "tolerance", DEFAULT_TOLERANCE, 1e-16, 1e-2)


def engine_of(table: Mapping[str, Any]) -> str | None:
    """The engine that is asked for, None for the best installed. Raises ``InputError``."""
    engine: str | None = table.get("engine")
    if engine is not None and engine not in ENGINES:
        raise InputError("study.engine", engine, f"allowed is {', '.join(map(repr, ENGINES))}")
    return engine


def start_of(table: Mapping[str, Any]) -> dict[str, Any]:
    """The start as written: see ``start_state``. Raises ``InputError``."""
    start = table.get("start", {})
    if not isinstance(start, Mapping):
        raise InputError("study.start", start, "allowed is a table: start = { BODY = ANGLE } or { BODY = { speed = SPEED } }")
    return dict(start)
