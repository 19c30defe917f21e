"""Searches over several variables: their ranges, the smallest value of a function, and the Pareto front of several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from wucht.dynamics.parameters import parameter_of
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.schema import Unit, read_quantity

_LOGARITHMIC_RATIO = 10.0  # ratio of the ends of a range: at or above it the range is searched by its logarithm


@dataclass(frozen=True)
class Variable:
    """A varied number. key: of bodies, or None: the parameter of one path. unit, description: of it."""

    name: str
    key: str | None
    paths: tuple[str, ...]
    low: float
    high: float
    unit: str
    description: str

    @property
    def is_logarithmic(self) -> bool:
        """True if its range is searched by its logarithm."""
        return self.low > 0 and self.high / self.low >= _LOGARITHMIC_RATIO

    def value_at(self, share: np.ndarray) -> np.ndarray:
        """Return values at shares (N,), 0 to 1, of the range."""
        if self.is_logarithmic:
            return np.asarray(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))
        return np.asarray(self.low + (self.high - self.low) * share)

    def share(self, value: float) -> float:
        """Return the position of a value in the range, 0 to 1."""
        if self.is_logarithmic:
            return float(np.log(value / self.low) / np.log(self.high / self.low)) if value > 0 else -1.0
        return (value - self.low) / (self.high - self.low)


def balancer_names(machine: Machine) -> list[str]:
    """Return the names of the bodies about the main rotor."""
    return [b.name for b in machine.group(machine.rotor)[1:]]


def variables_of(machine: Machine, vary: Mapping[str, Mapping[str, Any]], all_bodies: bool) -> tuple[Variable, ...]:
    """Return the varied numbers. all_bodies: True if all bodies must be varied together. Raises ``InputError``."""
    variables, names_by_path = list[Variable](), dict[str, str]()
    for name, entry in vary.items():
        location = f"study.vary.{name}"
        paths = _paths(machine, name, entry["of"], location)
        if (
            all_bodies
            and set(paths) != {f"{b}.{name}" for b in balancer_names(machine)}
            and any(p.split(".")[0] in balancer_names(machine) for p in paths)
        ):
            raise InputError(location, entry["of"], "with study.bodies all bodies are varied together")
        for path in paths:
            if path in names_by_path:
                raise InputError(location, path, f"this parameter is varied by study.vary.{names_by_path[path]} too")
            names_by_path[path] = name
        parameter = parameter_of(machine, paths[0], f"vary.{name}")
        unit = Unit(parameter.unit, parameter.long_name)
        low, high = (read_quantity(unit, end, f"{location}[{i}]") for i, end in enumerate(entry["range"]))
        if not low < high:
            raise InputError(location, entry["range"], "must be a pair [low, high] with low below high")
        variables.append(Variable(name, None if "." in name else name, paths, low, high, parameter.unit, parameter.long_name))
    return tuple(variables)


def _paths(machine: Machine, name: str, body_names: Sequence[str] | None, location: str) -> tuple[str, ...]:
    """Return the paths that a name denotes."""
    if "." in name or name in machine.parameters:
        if body_names is not None:
            raise InputError(f"{location}.of", list(body_names), "allowed only with a key of bodies, such as damping")
        parameter_of(machine, name, "vary")
        return (name,)
    bodies = balancer_names(machine)
    for body in body_names or ():
        if body not in bodies:
            raise InputError(f"{location}.of", body, f"this is not a balancing body; {nearest(body, bodies)}")
    paths = tuple(f"{b}.{name}" for b in (body_names or bodies))
    missing = [p for p in paths if p not in machine.parameters]
    if missing:
        body = missing[0].split(".")[0]
        keys = [p.removeprefix(f"{body}.") for p in machine.parameters if p.startswith(f"{body}.")]
        raise InputError("study.vary", name, f"{body!r} has no such parameter; {nearest(name, keys)}")
    return paths


def values_at(machine: Machine, variables: Sequence[Variable], numbers: Sequence[float]) -> dict[str, float]:
    """Return the values of a candidate by path; a given inertia of a pendulum keeps its ratio to m l^2."""
    values = {path: float(x) for v, x in zip(variables, numbers, strict=True) for path in v.paths}
    for body in balancer_names(machine):
        mass, length, inertia = (f"{body}.{key}" for key in ("mass", "length", "inertia"))
        if inertia in machine.values and inertia not in values and {mass, length} & values.keys():
            m, l = (values.get(p, machine.values[p]) / machine.values[p] for p in (mass, length))  # noqa: E741
            values[inertia] = machine.values[inertia] * m * l * l
    return values


_NO_OBJECTIVE = 1e30  # in place of an objective that a candidate does not have


def require_pymoo(kind: str) -> None:
    """Raise ``InputError`` if pymoo is not installed, which a study of this kind needs."""
    try:
        import_module("pymoo.algorithms.moo.nsga2")
    except ImportError:
        raise InputError("study.kind", kind, "this study needs the extra: pip install wucht[optimise]") from None


def generations(
    count: int, first: np.ndarray, objectives: int, seed: int, value: Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray]]
) -> Iterator[int]:
    """Compute a number of generations, each as large as the first one (P, k), of shares from 0 to 1.

    value: of a generation, by its number, and candidates (P, k): objectives (P, o), and a mask of the feasible ones (P,).
    Yields the number of each generation that is done. The same values give the same search.
    """
    load_module: Callable[[str], Any] = import_module
    problem = load_module("pymoo.core.problem").Problem(n_var=first.shape[1], n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm = load_module("pymoo.algorithms.moo.nsga2").NSGA2(pop_size=len(first), sampling=first)
    algorithm.setup(problem, termination=("n_gen", count), seed=seed, verbose=False)
    evaluator, static = load_module("pymoo.core.evaluator").Evaluator(), load_module("pymoo.problems.static").StaticProblem
    for number in range(count):
        population = algorithm.ask()
        values, is_feasible = value(number, np.clip(population.get("X").astype(float), 0.0, 1.0))
        is_valid = is_feasible & np.isfinite(values).all(axis=1)
        penalised_values = np.where(is_valid[:, None], values, _NO_OBJECTIVE)
        evaluator.eval(static(problem, F=penalised_values, G=np.where(is_valid, -1.0, 1.0)[:, None]), population)
        algorithm.tell(infills=population)
        yield number


def is_pareto_optimal(objectives: np.ndarray) -> np.ndarray:
    """Mask (N,) of the points (N, o) that no other one dominates: is at least as good in all, better in one."""
    is_optimal = np.ones(len(objectives), bool)
    for i, point in enumerate(objectives):
        is_as_good = (objectives <= point).all(axis=1)
        is_optimal[i] = not (is_as_good & (objectives < point).any(axis=1)).any()
    return is_optimal


def spread_selection(objectives: np.ndarray, count: int) -> np.ndarray:
    """Return the indices (c,) of at most ``count`` points (N, o): the best in each objective, then those farthest from them."""
    size = np.ptp(objectives, axis=0)
    scaled_objectives = (objectives - objectives.min(axis=0)) / np.where(size > 0, size, 1.0)
    indices = list(dict.fromkeys(int(k) for k in objectives.argmin(axis=0)))[:count]
    while len(indices) < min(count, len(objectives)):
        distances = np.sqrt(((scaled_objectives[:, None] - scaled_objectives[indices]) ** 2).sum(axis=2)).min(axis=1)
        if distances.max() <= 0:  # the rest are the same in all
            break
        indices.append(int(distances.argmax()))
    return np.array(sorted(indices), int)
