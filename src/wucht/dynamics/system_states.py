"""States of a table ``[system]`` as a study file gives them, and keys of a study that are of machines only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from wucht.errors import InputError, nearest
from wucht.schema import Unit, read_quantity
from wucht.system import System


class _GivenKeys(Protocol):
    """A spec that says which of its keys were given."""

    @property
    def model_fields_set(self) -> set[str]: ...


def states_from(system: System, given_values: Mapping[str, Any], location: str) -> np.ndarray:
    """Return the states (n,) that a table gives, zero where it gives none. Raises ``InputError`` for an unknown one."""
    for name in given_values:
        if name not in system.state_names:
            raise InputError(f"{location}.{name}", name, f"unknown state; {nearest(name, system.state_names)}")
    return np.array([state_value(name, given_values.get(name, 0.0), f"{location}.{name}") for name in system.state_names])


def state_value(name: str, value: Any, location: str) -> float:
    """Return the value of a state. Raises ``InputError`` where it is no number."""
    if isinstance(value, Mapping | list | tuple):
        raise InputError(location, value, "must be a number")
    return read_quantity(Unit("", f"state {name}"), value, location)


def refuse_machine_keys(
    spec: _GivenKeys, keys: Sequence[str], requirement: str = "allowed for a machine only, not for a table [system]"
) -> None:
    """Raise ``InputError`` for a given key that holds for machines only, or as the requirement says."""
    for key in keys:
        value = getattr(spec, key)
        if key in spec.model_fields_set and value not in (None, (), {}):
            raise InputError(f"study.{key}", value, requirement, code="machine-only")
