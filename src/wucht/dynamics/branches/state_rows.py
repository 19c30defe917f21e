"""What there is at one value of the second parameter: stable steady states, and the branch of modulated motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch, Stability
from wucht.dynamics.branches.first_orbits import SeedOrbit, cycles_of
from wucht.dynamics.branches.modulated_motion import ModulatedMotion, lost_states
from wucht.dynamics.branches.orbit_branches import StoredOrbit, first_cycle, half_branch
from wucht.dynamics.branches.orbit_endings import born_at, followed_to_end
from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.periodic.cycle import BRANCH_POINT, Cycle

ONE = "one stable state"
STABLE = 2  # a place's level: see ``LEVELS``
_LONGEST = 3.0  # times the period of the first orbit: so far stability is looked at

Bounds = tuple[float, float]


@dataclass(frozen=True)
class SteadyRow:
    """second: the value. stable: of each value of the first parameter, the names of the states that are stable, or
    how many there are without names."""

    second: float
    stable: tuple[tuple[str, ...], ...]


def steady_row(second: float, branches: Sequence[EquilibriumBranch], values: np.ndarray) -> SteadyRow:
    """From the branches of steady states over the first parameter."""
    found = []
    for value in values.tolist():
        names, unnamed = set[str](), 0
        for b in branches:
            v, stable = b.values, b.stability > Stability.NONE
            for i in np.flatnonzero((v[:-1] - value) * (v[1:] - value) <= 0).tolist():
                if stable[i] and stable[i + 1]:
                    unnamed += not b.kind.name
                    names |= {b.kind.name} if b.kind.name else set()
        names |= {ONE if unnamed == 1 else f"{unnamed} stable states"} if unnamed else set()
        found.append(tuple(sorted(names)))
    return SteadyRow(second, tuple(found))


@dataclass(frozen=True)
class OrbitSide:
    """One end of the branch of orbits: its kind, the parameter's value, the last orbit, and the equilibrium it comes to."""

    kind: str
    value: float
    sentence: str
    last: SeedOrbit
    equilibrium: np.ndarray


@dataclass(frozen=True)
class OrbitRow:
    """The branch of modulated motions over the first parameter.

    sides: its ends, at lower and higher values. values, stable (N,): of its orbits, in order. special: orbits at which
    stability changes or the branch turns, in the whole equations. middle: one that lies well within the branch.
    """

    second: float
    sides: tuple[OrbitSide, OrbitSide]
    values: np.ndarray
    stable: np.ndarray
    special: tuple[StoredOrbit, ...]
    middle: SeedOrbit
    whole: SeedOrbit

    def has(self, value: float, winding: np.ndarray) -> bool:
        """Whether it has a stable orbit of a winding (n,), of all equations, at a value."""
        return self.state_at(value) == STABLE and bool((self.whole.winding == winding).all())

    def state_at(self, value: float) -> int:
        """0 where there is no orbit, 1 where none is stable, 2 where one is."""
        low, high = sorted(s.value for s in self.sides)
        if not low < value < high:
            return 0
        return STABLE if self.stable[np.abs(self.values - value).argmin()] else 1


@dataclass(frozen=True)
class NoOrbit:
    """Why there is no branch of orbits at a value of the second parameter."""

    second: float
    sentence: str


def orbit_row(
    motion: ModulatedMotion,
    paths: tuple[str, str],
    bounds: Bounds,
    second: float,
    near: OrbitRow | None,
    watch: Callable[[], None],
) -> OrbitRow | NoOrbit:
    """The branch at a value of the second parameter. motion: at that value. near: the branch at a neighbouring one."""
    sentences = list[str]()
    seed = carried(motion, paths, near, second) if near is not None else None
    if seed is None:
        for fold in lost_states(motion.steady(paths[0], bounds)):
            if bounds[0] < fold.value < bounds[1]:
                seed = born_at(motion, paths[0], bounds, fold, sentences, watch)
            if seed is not None:
                break
    if seed is None:
        return NoOrbit(second, "; ".join(dict.fromkeys(sentences)) or "no stable steady state is lost there")
    return row_through(motion, paths, bounds, second, seed, watch)


def further_row(
    motion: ModulatedMotion, paths: tuple[str, str], bounds: Bounds, second: float, near: OrbitRow | None,
    given: tuple[SeedOrbit, ...], watch: Callable[[], None],
) -> OrbitRow | NoOrbit:  # fmt: skip
    """The branch of a motion that runs have reached: through one of the given orbits, or the neighbouring branch's."""
    beside = carried(motion, paths, near, second) if near is not None else None
    seeds = [*([beside] if beside is not None else []), *given]
    rows = [row_through(motion, paths, bounds, second, seed, watch) for seed in seeds[:1]]
    while len(rows) < len(seeds) and isinstance(rows[-1], NoOrbit):
        rows.append(row_through(motion, paths, bounds, second, seeds[len(rows)], watch))
    return rows[-1] if rows else NoOrbit(second, "the neighbouring motion is not followed to there")


def row_through(
    motion: ModulatedMotion, paths: tuple[str, str], bounds: Bounds, second: float, seed: SeedOrbit, watch: Callable[[], None]
) -> OrbitRow | NoOrbit:
    """The branch through an orbit, followed both ways. motion: at the value of the second parameter."""
    try:
        sides = [_side(motion, paths[0], bounds, seed, way, watch) for way in (-1, 1)]
        sides.sort(key=lambda s: s.value)
        middle = _within(motion, paths[0], bounds, seed, (sides[0].value + sides[1].value) / 2)
        e = motion.subject.embedding
        if e is not None and e.shape[0] == e.shape[1] + 1:
            return _beside(motion, paths[0], bounds, second, (sides[0], sides[1]), middle, watch)
        return _as_walked(motion, bounds, second, (sides[0], sides[1]), middle, watch)
    except WuchtError as error:
        return NoOrbit(second, str(error))


def _as_walked(
    motion: ModulatedMotion, bounds: Bounds, second: float, sides: tuple[OrbitSide, OrbitSide], middle: SeedOrbit,
    watch: Callable[[], None],
) -> OrbitRow:  # fmt: skip
    """The row with stability as collocation has it, in all equations."""
    whole = motion.whole or motion.subject
    lifted = motion.lifted(replace(middle, longest=_LONGEST * middle.period))
    parts = [half_branch(whole, bounds, lifted, onward, False, lambda _: watch()) for onward in (False, True)]
    values = np.concatenate([p.values for p in parts])
    order = np.argsort(values)
    trusted = np.concatenate([p.trusted for p in parts])[order]
    stable = np.concatenate([p.stable for p in parts])[order]
    special = tuple(k for p in parts for k in p.kept if k.kind)
    known = trusted if trusted.any() else np.ones(len(values), bool)
    return OrbitRow(second, sides, values[order][known], stable[known], special, middle, lifted)


def _beside(
    motion: ModulatedMotion, path: str, bounds: Bounds, second: float, sides: tuple[OrbitSide, OrbitSide], middle: SeedOrbit,
    watch: Callable[[], None],
) -> OrbitRow:  # fmt: skip
    """The row where one direction leads out of the section: there the exponent is a mean, right however long the period is."""
    seed = replace(middle, longest=_LONGEST * middle.period)
    cycles = cycles_of(replace(motion.subject, path=path), bounds, seed.winding, seed.scale, seed.longest)
    start, exponent = first_cycle(cycles, seed), transverse_exponent(motion, path)
    seen = [start]
    for first in (start, cycles.backwards(start)):
        for cycle in cycles.walk(first):
            watch()
            seen += [] if cycle.kind else [cycle]
    seen.sort(key=lambda c: c.parameter)
    values, out = np.array([c.parameter for c in seen]), np.array([exponent(c) for c in seen])
    inside = np.array([not c.trusted or c.unstable == 0 for c in seen])
    i = np.flatnonzero(out[:-1] * out[1:] < 0)
    lost = values[i] + out[i] / (out[i] - out[i + 1]) * (values[i + 1] - values[i])
    special = tuple(
        StoredOrbit(c.problem.mesh.edges, c.problem.mesh.degree, c.states.T, c.period, float(at), BRANCH_POINT)
        for c, at in zip([seen[k] for k in i.tolist()], lost.tolist(), strict=True)
    )
    return OrbitRow(second, sides, values, inside & (out < 0), special, middle, motion.lifted(seed))


def transverse_exponent(motion: ModulatedMotion, path: str) -> Callable[[Cycle], float]:
    """ln mu of the one direction that leads out of the section, by an integral over an orbit."""
    whole, e = motion.whole, motion.subject.embedding
    assert whole is not None and e is not None
    fixed = {n: whole.values[n] for n in whole.system.parameter_names if n != path}
    equations = Equations.of(whole.system, [path], fixed)
    out = np.linalg.qr(e, mode="complete")[0][:, -1]

    def exponent(cycle: Cycle) -> float:
        states = e @ cycle.states
        matrix = equations.values(np.concatenate([states, np.full((1, states.shape[1]), cycle.parameter)]))[1][:, :-1]
        return cycle.integral(np.einsum("i,ijk,j->k", out, matrix, out))

    return exponent


def _side(
    motion: ModulatedMotion, path: str, bounds: Bounds, seed: SeedOrbit, way: int, watch: Callable[[], None]
) -> OrbitSide:
    kind, value, sentence, last, at = followed_to_end(motion, path, bounds, seed, way, watch)
    return OrbitSide(kind, value, sentence, SeedOrbit.of(*last, "the end of a branch", both_ways=True), np.asarray(at))


def _within(motion: ModulatedMotion, path: str, bounds: Bounds, seed: SeedOrbit, value: float) -> SeedOrbit:
    """The orbit of a branch at a value, or as near to it as it is followed."""
    low, high = sorted((seed.value, value))
    if high - low < 1e-6 * (bounds[1] - bounds[0]):
        return seed
    cycles = cycles_of(replace(motion.subject, path=path), (low, high), seed.winding, seed.scale, seed.longest)
    start = first_cycle(cycles, seed)
    last = _last_of(cycles.walk(start if value > seed.value else cycles.backwards(start)), start)
    return replace(SeedOrbit.of(cycles, last, "within a branch", both_ways=True), longest=seed.longest)


def _last_of(walk: object, start: Cycle) -> Cycle:
    last = start
    for cycle in walk:  # type: ignore[attr-defined]
        last = last if cycle.kind else cycle
    return last


def carried(motion: ModulatedMotion, paths: tuple[str, str], near: OrbitRow, second: float) -> SeedOrbit | None:
    """The middle orbit of a neighbouring branch, followed to another value of the second parameter; None where that fails."""
    seed, first = near.middle, near.middle.value
    if near.second == second:
        return seed
    there = motion.at({paths[0]: first}, paths[1]).subject
    low, high = sorted((near.second, second))
    scale = np.append(seed.scale[:-1], high - low)
    cycles = cycles_of(there, (low, high), seed.winding, scale, seed.longest)
    try:
        start = first_cycle(cycles, replace(seed, value=near.second))
        last = _last_of(cycles.walk(start if second > near.second else cycles.backwards(start)), start)
        if not math.isclose(last.parameter, second, rel_tol=1e-9):
            return None
        found = SeedOrbit.of(cycles, last, "a neighbouring branch", both_ways=True)
    except RunError:
        return None
    return replace(found, value=first, scale=seed.scale, longest=seed.longest)
