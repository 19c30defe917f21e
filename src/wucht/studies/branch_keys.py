"""Keys that questions about branches of steady states and of orbits share, and the names that their results keep free."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.dynamics.parameters import parameter_of
from wucht.errors import InputError
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.schema import Parameter, Unit

NAMES = ("compensating", "together", "opposed")
RESERVED = frozenset({  # keys of the summary, beside which stands the name of a parameter of equations
    "kind", "speed", "state", "amplitude", "branch", "frequency", "type", "name", "label", "stable", "stable_speeds",
    "partly_stable", "partly_stable_speeds", "partly_stable_shares",
    "range", "second_range", "ends", "family_dimension", "multiplicity", "of",
    "coefficients", "special_points",
})  # fmt: skip


def free_parameter(subject: Machine | OwnEquations, path: str, key: str) -> Parameter:
    """The parameter of a path. Raises ``InputError`` where there is none, or where results have a key of its name."""
    parameter = parameter_of(subject, path, key)
    if isinstance(subject, OwnEquations) and path in RESERVED:
        raise InputError(f"study.{key}", path, "in the results this is the name of something else: rename the parameter")
    return parameter


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
Names = Annotated[
    tuple[str, ...], BeforeValidator(_names), Field(description="names of steady states that are kept, others are left out")
]
