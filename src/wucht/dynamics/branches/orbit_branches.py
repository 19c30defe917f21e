"""Branches of orbits: followed each way from their first orbit, and the data that are stored of each orbit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from wucht.dynamics.branches.first_orbits import SeedOrbit, cycles_of
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.periodic.branch_ends import CLOSED_BRANCH, BranchEnd, branch_end
from wucht.numerics.periodic.cycle import BRANCH_POINT, DOUBLING, Cycle, HiddenPoint
from wucht.numerics.periodic.cycle_starts import crossing_branch, cycle_at, doubled_branch
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.zeros_and_peaks import values_at_passages

ValueReport = Callable[[float], None]  # the parameter's value so far

_STORE_EVERY, _STORE_GROWTH = 0.02, 1.1  # of the range; of the period: distance between orbits that are stored whole
_LAST = 3  # orbits by which the end is judged
_SAME = 1e-2  # relative: an orbit that lies on a branch, by period and range of the ordinate between neighbours
_MIRROR_TOLERANCE = 1e-6  # relative: two orbits beside a branch point that are mirror images


@dataclass(frozen=True)
class StoredOrbit:
    """Orbit as stored, to be recomputed: see ``SeedOrbit``. kind: of a special one."""

    mesh: Mesh
    states: np.ndarray
    period: float
    value: float
    kind: str


@dataclass(frozen=True)
class PeriodicBranch:
    """Branch of orbits, in order along it.

    seed: its first orbit, from which it is followed onward, and backwards as well. values, periods, mean, low, high (of the
    ordinate), least, largest (of the amplitude): (N,). logarithms (n-1, N): ln mu by collocation. is_trusted (N,): True where
    these are accurate. product_error (N,): error of their sum. unstable (N,): number of growing disturbances. excess_error
    (N,): error of the states between mesh points, by their sizes, where that is larger than required, else 0. kinds: "" or that
    of a special orbit. hidden_points: of an unresolved one, its possible kind and place, else None. stored_orbits: some of the
    orbits, whole: the first and the last one, special ones and their neighbours, others in between. ends: the last one onward;
    before it that backwards, if it is followed so. offshoots: first orbits of other branches, or sentences why there is none.
    """

    seed: SeedOrbit
    values: np.ndarray
    periods: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    least: np.ndarray
    largest: np.ndarray
    logarithms: np.ndarray
    is_trusted: np.ndarray
    product_error: np.ndarray
    unstable: np.ndarray
    excess_error: np.ndarray
    kinds: tuple[str, ...]
    hidden_points: tuple[HiddenPoint | None, ...]
    stored_orbits: tuple[StoredOrbit, ...]
    ends: tuple[BranchEnd, ...]
    offshoots: tuple[SeedOrbit | str, ...] = field(default_factory=tuple)

    @property
    def stable(self) -> np.ndarray:
        """True where all disturbances decay (N,), except for those that neither grow nor decay on a special orbit."""
        return np.asarray(self.unstable == 0)

    def with_backward(self, backward: PeriodicBranch) -> PeriodicBranch:
        """Return the branch with a part that is followed backwards from its first orbit, which it has once."""
        whole = dict[str, Any]()
        for name in (f.name for f in fields(self) if f.name not in ("seed", "ends", "offshoots")):
            before, onward = getattr(backward, name), getattr(self, name)
            is_array = isinstance(onward, np.ndarray)
            whole[name] = np.concatenate([before[..., :0:-1], onward], axis=-1) if is_array else before[:0:-1] + onward
        return replace(self, **whole, ends=backward.ends + self.ends, offshoots=self.offshoots + backward.offshoots)

    @property
    def is_closed(self) -> bool:
        """True if it leads back to its first orbit."""
        return self.ends[-1].kind == CLOSED_BRANCH

    @property
    def stable_ranges(self) -> list[tuple[float, float]]:
        """Ranges of the parameter in which orbits are stable, up to special orbits and to the ends of the branch."""
        special = np.array([bool(kind) for kind in self.kinds])
        stretches = _stable_stretches(self.stable & ~special, special)
        ranges = [self._range_of(begin, end) for begin, end in stretches]
        if len(ranges) > 1 and self.is_closed and stretches[0][0] == 0 and stretches[-1][1] == len(self.values):
            (low, high), (last_low, last_high) = ranges[0], ranges.pop()  # one stretch, on either side of the first orbit
            ranges[0] = min(low, last_low), max(high, last_high)
        return ranges

    def _range_of(self, begin: int, end: int) -> tuple[float, float]:
        """Return the range of a stretch of orbits, extended to the end of the branch if its last orbit is one of them."""
        inside = self.values[begin:end].tolist()
        if end == len(self.values):
            inside.append(self.ends[-1].parameter)
        if begin == 0 and len(self.ends) > 1:
            inside.append(self.ends[0].parameter)
        return float(min(inside)), float(max(inside))

    def passes(self, value: float, period: float) -> bool:
        """True if it has an orbit of a period, between neighbours, at a value of the parameter."""
        _, there = values_at_passages(self.values, value, self.periods)
        return bool((np.abs(there / period - 1) < _SAME).any())

    def is_same_branch(self, candidate: PeriodicBranch) -> bool:
        """True if another branch is this one, started at another special point: its middle orbits lie on this one."""
        k = len(candidate.values) // 2
        value, low, high = candidate.values[k], candidate.low[k], candidate.high[k]
        i = int(np.abs((self.values - value) / np.ptp(self.values).clip(1e-300)).argmin())
        alike = abs(self.low[i] - low) + abs(self.high[i] - high) < _SAME * max(high - low, 1e-300)
        return alike and self.passes(float(value), float(candidate.periods[k]))


def _stable_stretches(stable: np.ndarray, special: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and one past the last orbit of each stable stretch, with the special orbits at its ends."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (stable | special).astype(int), [0]])))
    pairs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    return [(i, j) for i, j in pairs if stable[i:j].any()]


def half_branch(subject: OrbitProblem, seed: SeedOrbit, onward: bool, switch: bool, report: ValueReport) -> PeriodicBranch:
    """Follow the branch from a first orbit on, or backwards. Raises ``RunError`` where that orbit cannot be recomputed."""
    cycles, start = cycles_through(subject, seed)
    walk = cycles.walk(start if onward else cycles.backwards(start))
    numbers, stored_orbits, offshoots, last = (
        [_numbers(subject, cycles, start)],
        [stored_orbit(start)],
        list[SeedOrbit | str](),
        [start],
    )
    logarithms, kinds, hidden_points = [start.logarithms], [""], [start.hidden_point]
    for cycle in walk:
        report(cycle.parameter)
        numbers.append(_numbers(subject, cycles, cycle))
        logarithms.append(cycle.logarithms)
        kinds.append(cycle.kind)
        hidden_points.append(cycle.hidden_point)
        latest = stored_orbits[-1]
        has_moved = abs(cycle.parameter - latest.value) > _STORE_EVERY * subject.width
        has_grown = not 1 / _STORE_GROWTH < cycle.period / latest.period < _STORE_GROWTH
        if cycle.kind and not latest.kind and latest.value != last[-1].parameter:
            stored_orbits.append(stored_orbit(last[-1]))
        if has_moved or has_grown or cycle.kind or latest.kind:
            stored_orbits.append(stored_orbit(cycle))
        if cycle.kind and switch:
            offshoots += _offshoots(cycles, cycle)
        if not cycle.kind:
            last = [*last, cycle][-_LAST:]
    if not stored_orbits[-1].kind and stored_orbits[-1].value != last[-1].parameter:
        stored_orbits.append(stored_orbit(last[-1]))
    columns = np.array(numbers).T
    regular = np.array([not kind for kind in kinds])
    end = branch_end(cycles, columns[0, regular], columns[1, regular], last, walk.end)
    values, periods, mean, low, high, least, largest, is_trusted, product_error, unstable, excess_error = columns
    logarithm_rows = np.array(logarithms).reshape(len(kinds), -1).T
    return PeriodicBranch(
        seed=seed, values=values, periods=periods, mean=mean, low=low, high=high, least=least, largest=largest,
        logarithms=logarithm_rows, is_trusted=is_trusted > 0, product_error=product_error, unstable=unstable.astype(int),
        excess_error=excess_error, kinds=tuple(kinds), hidden_points=tuple(hidden_points), stored_orbits=tuple(stored_orbits),
        ends=(end,), offshoots=tuple(offshoots),
    )  # fmt: skip


def cycles_through(problem: OrbitProblem, seed: SeedOrbit, *, draws: bool = True) -> tuple[Cycles, Cycle]:
    """Return the branches of an orbit's winding, and the orbit as the first of its branch. Raises ``RunError``.

    draws: True for orbits so many that their curves look smooth; else those are followed that lead to the ends soonest.
    """
    cycles = cycles_of(problem, seed.winding, seed.scale, seed.longest)
    if not draws:
        cycles = replace(cycles, predicts_shifts=True, steps=replace(cycles.steps, predicts_correction=True))
    unknowns = np.concatenate([seed.states.ravel(), [seed.period, seed.value]])
    on_mesh = cycles.problem(seed.mesh, seed.period)
    on_mesh = replace(on_mesh, reference=on_mesh.reference_from(unknowns))
    towards = seed.towards
    if not len(towards):
        towards = np.zeros(len(unknowns))
        towards[-1] = on_mesh.scale[-1]
    curve = cycles.curve(on_mesh)
    return cycles, cycles.cycle_from_point(curve, curve.start(unknowns, towards))


def _numbers(subject: OrbitProblem, cycles: Cycles, cycle: Cycle) -> list[float]:
    """Return value, period, mean and range of the ordinate, range of the amplitude, whether multipliers are known, the error of
    their product, the number outside the unit circle, and the error between mesh points where it is too large."""
    orbit = _accurate(cycles, cycle)
    mean = orbit.integral(subject.observables(orbit.states, cycle.parameter)[0]) / orbit.period
    low, high, least, largest = orbit_extremes(subject, orbit.problem.mesh, orbit.states.T, cycle.parameter)
    multiplier_numbers = float(cycle.is_trusted), abs(cycle.product_error), float(cycle.unstable)
    excess_error = 0.0 if orbit.is_accurate else orbit.error
    return [cycle.parameter, cycle.period, mean, low, high, least, largest, *multiplier_numbers, excess_error]


def _accurate(cycles: Cycles, cycle: Cycle) -> Cycle:
    """Return an orbit of a branch on a mesh of its own where that of the orbit before is too coarse."""
    if not cycle.is_accurate:
        with suppress(WuchtError):
            orbit = cycle_at(cycles, cycle, cycle.parameter)
            return orbit if abs(orbit.period / cycle.period - 1) < _SAME else cycle
    return cycle


def orbit_extremes(subject: OrbitProblem, mesh: Mesh, states: np.ndarray, value: float) -> tuple[float, float, float, float]:
    """Return the least and largest ordinate, and the same of the amplitude, along an orbit.

    They are reached where the derivative of their polynomials is zero: between samples of a relaxation oscillation there would
    be whole peaks. states (K, n): at the nodes.
    """
    courses = subject.observables(states.T, value)
    places = np.concatenate([mesh.nodes, *(mesh.stationary_places(course) for course in courses)])
    ordinate, amplitude = subject.observables(mesh.interpolate(states, places).T, value)
    return float(ordinate.min()), float(ordinate.max()), float(amplitude.min()), float(amplitude.max())


def stored_orbit(cycle: Cycle) -> StoredOrbit:
    """Return the stored form of an orbit."""
    return StoredOrbit(cycle.problem.mesh, cycle.states.T, cycle.period, cycle.parameter, cycle.kind)


def _offshoots(cycles: Cycles, at: Cycle) -> Sequence[SeedOrbit | str]:
    """Return the first orbits of other branches at a special one, one of mirror images; or a sentence why there is none."""
    place = f"the {at.kind.replace('-', ' ')} at {cycles.equations.parameter_names[-1]} = {at.parameter:.6g}"
    sides: Sequence[tuple[Cycles, Cycle]] = ()
    try:
        if at.kind == DOUBLING:
            sides = [doubled_branch(cycles, at)]
        elif at.kind == BRANCH_POINT:
            one, opposite = crossing_branch(cycles, at)
            alike = all(
                abs(getattr(one, name) / getattr(opposite, name) - 1) < _MIRROR_TOLERANCE for name in ("period", "parameter")
            )
            sides = [(cycles, side) for side in ((one,) if alike else (one, opposite))]
    except RunError as error:
        return [f"the branch from {place} is not followed: {error}"]
    return [SeedOrbit.from_cycle(branches, side, place, both_ways=False) for branches, side in sides]
