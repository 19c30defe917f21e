"""Keys of ``[study]`` that hold quantities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.parts.fields import Parameter
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


def positive(table: Mapping[str, Any], key: str, unit: Unit) -> float | None:
    """The value of a key, greater than 0, None if it is not given. Raises ``InputError``."""
    value = quantity(table, key, unit)
    if value is not None and value <= 0:
        raise InputError(f"study.{key}", table[key], f"allowed is a {unit.what} greater than 0")
    return value


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
    return machine.parameters[given]
