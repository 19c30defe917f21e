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

_WIDE = 10.0  # ratio of the ends of a range: at or above it the range is searched by its logarithm


@dataclass(frozen=True)
class Variable:
    """A varied number. key: of bodies, or None: the parameter of one path. unit, description: of it."""

    name: str
    key: str | None
    paths: tuple[str, ...]
    low: float
    high: float
    unit: str
    what: str

    @property
    def wide(self) -> bool:
        """True if its range is searched by its logarithm."""
        return self.low > 0 and self.high / self.low >= _WIDE

    def at(self, share: np.ndarray) -> np.ndarray:
        """Return values at shares (N,), 0 to 1, of the range."""
        if self.wide:
            return np.asarray(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))
        return np.asarray(self.low + (self.high - self.low) * share)

    def share(self, value: float) -> float:
        """Return the position of a value in the range, 0 to 1."""
        if self.wide:
            return float(np.log(value / self.low) / np.log(self.high / self.low)) if value > 0 else -1.0
        return (value - self.low) / (self.high - self.low)


def balancing(machine: Machine) -> list[str]:
    """Return the names of the bodies about the main rotor."""
    return [b.name for b in machine.group(machine.rotor)[1:]]


def variables_of(machine: Machine, vary: Mapping[str, Mapping[str, Any]], together: bool) -> tuple[Variable, ...]:
    """Return the varied numbers. together: all bodies must be varied together. Raises ``InputError``."""
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
    """Return the paths that a name denotes."""
    if "." in name or name in machine.parameters:
        if of is not None:
            raise InputError(f"{where}.of", list(of), "allowed only with a key of bodies, such as damping")
        parameter_of(machine, name, "vary")
        return (name,)
    bodies = balancing(machine)
    for body in of or ():
        if body not in bodies:
            raise InputError(f"{where}.of", body, f"this is not a balancing body; {nearest(body, bodies)}")
    paths = tuple(f"{b}.{name}" for b in (of or bodies))
    missing = [p for p in paths if p not in machine.parameters]
    if missing:
        body = missing[0].split(".")[0]
        keys = [p.removeprefix(f"{body}.") for p in machine.parameters if p.startswith(f"{body}.")]
        raise InputError("study.vary", name, f"{body!r} has no such parameter; {nearest(name, keys)}")
    return paths


def values_at(machine: Machine, variables: Sequence[Variable], numbers: Sequence[float]) -> dict[str, float]:
    """Return the values of a candidate by path; a given inertia of a pendulum keeps its ratio to m l^2."""
    values = {path: float(x) for v, x in zip(variables, numbers, strict=True) for path in v.paths}
    for body in balancing(machine):
        mass, length, inertia = (f"{body}.{key}" for key in ("mass", "length", "inertia"))
        if inertia in machine.values and inertia not in values and {mass, length} & values.keys():
            m, l = (values.get(p, machine.values[p]) / machine.values[p] for p in (mass, length))  # noqa: E741
            values[inertia] = machine.values[inertia] * m * l * l
    return values


_NEAR = 1e-3  # of the range: the accuracy of the smallest value


@dataclass(frozen=True)
class Bounds:
    """Confidence bounds of the probability at a value of the parameter."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Fall:
    """A certain fall of the probability: its band at a value lies above that at a larger one."""

    before: Bounds
    after: Bounds


def fall_of(seen: Sequence[Bounds]) -> Fall | None:
    """Return the deepest fall of the probability, from bounds in the order of their values; None: no fall is certain."""
    falls = [Fall(a, b) for i, a in enumerate(seen) for b in seen[i + 1 :] if b.high < a.low]
    return max(falls, key=lambda f: f.before.low - f.after.high, default=None)


def smallest(seen: Sequence[Bounds], wanted: float) -> float | None:
    """Return the smallest of some values, in order, from which on the lower bounds reach a target.

    None: they do not, or the probability falls.
    """
    if not seen or fall_of(seen) is not None or seen[-1].low < wanted:
        return None
    short = [k for k, one in enumerate(seen) if one.low < wanted]
    return seen[short[-1] + 1 if short else 0].value


def to_look_at(seen: Sequence[Bounds], wanted: float) -> float | None:
    """Return the value to sample next to refine the smallest one; None: it is known well enough, or there is none."""
    found = smallest(seen, wanted)
    if found is None or found == seen[0].value:
        return None
    before = max(one.value for one in seen if one.value < found)
    if found - before <= _NEAR * (seen[-1].value - seen[0].value):
        return None
    return (before + found) / 2


_NONE = 1e30  # in place of an objective that a candidate does not have


def needed(kind: str) -> None:
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
    of: Callable[[str], Any] = import_module
    problem = of("pymoo.core.problem").Problem(n_var=first.shape[1], n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm = of("pymoo.algorithms.moo.nsga2").NSGA2(pop_size=len(first), sampling=first)
    algorithm.setup(problem, termination=("n_gen", count), seed=seed, verbose=False)
    evaluator, static = of("pymoo.core.evaluator").Evaluator(), of("pymoo.problems.static").StaticProblem
    for number in range(count):
        asked = algorithm.ask()
        found, allowed = value(number, np.clip(asked.get("X").astype(float), 0.0, 1.0))
        fit = allowed & np.isfinite(found).all(axis=1)
        shown = np.where(fit[:, None], found, _NONE)
        evaluator.eval(static(problem, F=shown, G=np.where(fit, -1.0, 1.0)[:, None]), asked)
        algorithm.tell(infills=asked)
        yield number


def not_dominated(objectives: np.ndarray) -> np.ndarray:
    """Mask (N,) of the points (N, o) that no other one dominates: is at least as good in all, better in one."""
    kept = np.ones(len(objectives), bool)
    for i, one in enumerate(objectives):
        others = (objectives <= one).all(axis=1)
        kept[i] = not (others & (objectives < one).any(axis=1)).any()
    return kept


def spread_out(objectives: np.ndarray, count: int) -> np.ndarray:
    """Return the indices (c,) of at most ``count`` points (N, o): the best in each objective, then those farthest from them."""
    size = np.ptp(objectives, axis=0)
    scaled = (objectives - objectives.min(axis=0)) / np.where(size > 0, size, 1.0)
    chosen = list(dict.fromkeys(int(k) for k in objectives.argmin(axis=0)))[:count]
    while len(chosen) < min(count, len(objectives)):
        away = np.sqrt(((scaled[:, None] - scaled[chosen]) ** 2).sum(axis=2)).min(axis=1)
        if away.max() <= 0:  # the rest are the same in all
            break
        chosen.append(int(away.argmax()))
    return np.array(sorted(chosen), int)
