"""What a search varies of a machine: keys of the balancing bodies together, or one parameter after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.dynamics.parameters import parameter_of
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.schema import Unit, read_quantity

_WIDE = 10.0  # ratio of the ends of a range: from here on it is searched by its logarithm


@dataclass(frozen=True)
class Variable:
    """A number that is varied. key: of which bodies, or None: the parameter of one path. unit, what: of it."""

    name: str
    key: str | None
    paths: tuple[str, ...]
    low: float
    high: float
    unit: str
    what: str

    @property
    def wide(self) -> bool:
        """Whether its range is searched by its logarithm."""
        return self.low > 0 and self.high / self.low >= _WIDE

    def at(self, share: np.ndarray) -> np.ndarray:
        """Values at shares (N,), 0 to 1, of the range."""
        if self.wide:
            return np.asarray(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))
        return np.asarray(self.low + (self.high - self.low) * share)

    def share(self, value: float) -> float:
        """Where a value lies in the range."""
        if self.wide:
            return float(np.log(value / self.low) / np.log(self.high / self.low)) if value > 0 else -1.0
        return (value - self.low) / (self.high - self.low)


def balancing(machine: Machine) -> list[str]:
    """The names of the bodies about the main rotor."""
    return [b.name for b in machine.group(machine.rotor)[1:]]


def variables_of(machine: Machine, vary: Mapping[str, Mapping[str, Any]], together: bool) -> tuple[Variable, ...]:
    """What is varied. together: whether all bodies must be. Raises ``InputError``."""
    found, taken = list[Variable](), dict[str, str]()
    for name, given in vary.items():
        where = f"study.vary.{name}"
        paths = _paths(machine, name, given["of"], where)
        if (
            together
            and set(paths) != {f"{b}.{name}" for b in balancing(machine)}
            and any(p.split(".")[0] in balancing(machine) for p in paths)
        ):
            raise InputError(where, given["of"], "with study.bodies all bodies are varied together")
        for path in paths:
            if path in taken:
                raise InputError(where, path, f"this parameter is varied by study.vary.{taken[path]} too")
            taken[path] = name
        one = parameter_of(machine, paths[0], f"vary.{name}")
        unit = Unit(one.unit, one.what)
        low, high = (read_quantity(unit, end, f"{where}[{i}]") for i, end in enumerate(given["range"]))
        if not low < high:
            raise InputError(where, given["range"], "must be a pair [low, high] with low below high")
        found.append(Variable(name, None if "." in name else name, paths, low, high, one.unit, one.what))
    return tuple(found)


def _paths(machine: Machine, name: str, of: Sequence[str] | None, where: str) -> tuple[str, ...]:
    """The paths that a name stands for."""
    if "." in name or name in machine.parameters:
        if of is not None:
            raise InputError(f"{where}.of", list(of), "allowed only with a key of bodies, such as damping")
        parameter_of(machine, name, "vary")
        return (name,)
    bodies = balancing(machine)
    for body in of or ():
        if body not in bodies:
            raise InputError(f"{where}.of", body, f"this is no balancing body; {nearest(body, bodies)}")
    paths = tuple(f"{b}.{name}" for b in (of or bodies))
    missing = [p for p in paths if p not in machine.parameters]
    if missing:
        body = missing[0].split(".")[0]
        keys = [p.removeprefix(f"{body}.") for p in machine.parameters if p.startswith(f"{body}.")]
        raise InputError("study.vary", name, f"{body!r} has no such parameter; {nearest(name, keys)}")
    return paths


def values_at(machine: Machine, variables: Sequence[Variable], numbers: Sequence[float]) -> dict[str, float]:
    """The values of a candidate by path; a pendulum's own inertia keeps its ratio to m l^2."""
    values = {path: float(x) for v, x in zip(variables, numbers, strict=True) for path in v.paths}
    for body in balancing(machine):
        mass, length, inertia = (f"{body}.{key}" for key in ("mass", "length", "inertia"))
        if inertia in machine.values and inertia not in values and {mass, length} & values.keys():
            m, l = (values.get(p, machine.values[p]) / machine.values[p] for p in (mass, length))  # noqa: E741
            values[inertia] = machine.values[inertia] * m * l * l
    return values
