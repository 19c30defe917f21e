"""States of a table ``[system]`` as a study file gives them, starts from which nothing can run, and keys of machines only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from wucht.errors import InputError, RunError, nearest
from wucht.machines.subject import Subject
from wucht.numerics.flow.program import Evaluator
from wucht.schema import Unit, read_quantity
from wucht.system import System


class _GivenKeys(Protocol):
    """A spec that says which of its keys were given."""

    @property
    def model_fields_set(self) -> set[str]: ...


def states_from(system: System, given_values: Mapping[str, Any], location: str) -> np.ndarray:
    """Return the states (n,) that a table gives, zero where it gives none. Raises ``InputError`` for an unknown one."""
    for name in given_values:
        state_row(system, name, f"{location}.{name}")
    return np.array([state_value(name, given_values.get(name, 0.0), f"{location}.{name}") for name in system.state_names])


def refuse_singular_start(subject: Subject, start: np.ndarray, location: str) -> None:
    """Raise ``InputError`` for a start (n,) at which the derivative of a state is no finite number."""
    system, names = subject.system, subject.system.state_names
    try:
        with np.errstate(all="ignore"):
            rates = Evaluator.of_rates(system).array(np.zeros(1), start[:, None], system.values(subject.values))[:, 0]
    except RunError as error:  # a part that depends on parameters alone
        raise InputError("system.parameters", dict(subject.values), str(error)) from None
    at = dict(zip(names, start.tolist(), strict=True))
    for name, rate in zip(names, rates.tolist(), strict=True):
        if not np.isfinite(rate):
            place = ", ".join(f"{n} = {x:.6g}" for n, x in {**at, **subject.values}.items())
            raise InputError(location, at, f"the derivative of {name} is no finite number there, with {place}")


def state_row(system: System, name: str, location: str) -> int:
    """Return the number of a state in the equations. Raises ``InputError`` for an unknown one."""
    if name not in system.state_names:
        raise InputError(location, name, f"unknown state; {nearest(name, system.state_names)}")
    return system.state_names.index(name)


def state_range(
    name: str, definition: Sequence[Any], location: str, requirement: str = "must be a pair [low, high] with low below high"
) -> tuple[float, float]:
    """Return the lowest and the highest value of a state, the first two of a definition. Raises ``InputError``."""
    low, high = (state_value(name, value, location) for value in definition[:2])
    if not low < high:
        raise InputError(location, list(definition), requirement)
    return low, high


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
