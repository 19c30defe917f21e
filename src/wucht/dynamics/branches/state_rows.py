"""Stable steady states and the branch of modulated motions at one value of the second parameter.

And the curves in the plane on which such a motion turns, doubles, loses its stability, or becomes a saddle connection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, pairwise, takewhile
from typing import Any

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch, StabilityLevel
from wucht.dynamics.branches.first_orbits import SeedOrbit
from wucht.dynamics.branches.modulated_motion import ModulatedMotion, lost_states
from wucht.dynamics.branches.orbit_branches import StoredOrbit, cycles_through, half_branch, stored_orbit
from wucht.dynamics.branches.orbit_endings import BranchToEnd, OrbitEnd, branch_to_end, connections_at, orbit_beyond_loss
from wucht.dynamics.branches.plane_regions import PlaneCurve
from wucht.dynamics.branches.second_parameter import SecondParameter
from wucht.dynamics.branches.steady_states import Heartbeat
from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION
from wucht.numerics.periodic.cycle import BRANCH_POINT, Cycle
from wucht.numerics.periodic.cycle_curves import CycleCurve
from wucht.numerics.periodic.cycles import Cycles

ONE_STABLE = "one stable state"
STABLE = 2  # a place's level: see ``LEVELS``
_LONGEST = 3.0  # times the period of the first orbit: up to there stability is computed
_LONGER = 8.0  # times the period of the orbit with which a curve begins
_POINTS = 401  # of a curve, each way
_SAME = 1e-3  # of the range
_ORBITS_BETWEEN = 150  # of neighbouring rows: a branch with more of them has stopped at an end on the way


@dataclass(frozen=True)
class ExaminedPlace:
    """Motions at a place (x, y). names: of stable steady states, or the number of those without names. level: of modulated
    motions: 0 none, 1 unstable, 2 stable."""

    x: float
    y: float
    names: tuple[str, ...]
    level: int = 0

    def key(self, without: frozenset[str] = frozenset()) -> str:
        """Return what is compared with other places. without: names that are left out."""
        return f"{self.level};{','.join(sorted(set(self.names) - without))}"


def steady_row(second: float, branches: Sequence[EquilibriumBranch], values: np.ndarray) -> tuple[ExaminedPlace, ...]:
    """Return the steady states at values of the first parameter, from their branches over it."""
    places = []
    for value in values.tolist():
        names, unnamed_count = set[str](), 0
        for b in branches:
            v, stable = b.parameter_values, b.stability > StabilityLevel.UNSTABLE
            for i in np.flatnonzero((v[:-1] - value) * (v[1:] - value) <= 0).tolist():
                if stable[i] and stable[i + 1]:
                    unnamed_count += not b.kind.name
                    names |= {b.kind.name} if b.kind.name else set()
        names |= {ONE_STABLE if unnamed_count == 1 else f"{unnamed_count} stable states"} if unnamed_count else set()
        places.append(ExaminedPlace(value, second, tuple(sorted(names))))
    return tuple(places)


@dataclass(frozen=True)
class OrbitRow:
    """Branch of modulated motions over the first parameter.

    sides: its ends, at lower and higher values. values, stable (N,): of its orbits, in order along the branch, which may turn
    back at folds, or be closed. special: orbits at which stability changes or the branch turns, in the whole equations.
    middle: one that lies well within the branch.
    """

    second: float
    sides: tuple[OrbitEnd, OrbitEnd]
    values: np.ndarray
    stable: np.ndarray
    special: tuple[StoredOrbit, ...]
    middle: SeedOrbit
    whole: SeedOrbit

    def has_orbit(self, value: float, winding: np.ndarray) -> bool:
        """True if it has a stable orbit of a winding (n,), of all equations, at a value."""
        return self.state_at(value) == STABLE and bool((self.whole.winding == winding).all())

    def state_at(self, value: float) -> int:
        """Return 0 where there is no orbit, 1 where none is stable, 2 where one is."""
        passages = (self._along[:-1] - value) * (self._along[1:] - value) < 0
        passages[1:] |= self._along[1:-1] == value
        i = np.flatnonzero(passages)
        if not len(i):
            return 0
        later = np.abs(self._along[i + 1] - value) < np.abs(self._along[i] - value)
        orbits = np.clip(i + later - 1, 0, len(self.stable) - 1)  # the nearer one of both; ends have the orbit beside them
        return STABLE if self.stable[orbits].any() else 1

    @cached_property
    def _along(self) -> np.ndarray:
        """Values (N+2,) along the branch, from end to end."""
        low, high = (s.value for s in self.sides)
        if abs(self.values[0] - low) + abs(self.values[-1] - high) > abs(self.values[0] - high) + abs(self.values[-1] - low):
            low, high = high, low
        return np.array([low, *self.values, high])


@dataclass(frozen=True, eq=False)
class RowCase:
    """Row at a value of the second parameter, that of ``motion``. path: of that parameter.

    In the place of a row that does not exist stands the reason.
    """

    motion: ModulatedMotion
    path: str
    second: float
    report: Heartbeat

    def row(self, near: OrbitRow | str | None) -> OrbitRow | str:
        """Follow the branch of modulated motions. near: that at a neighbouring value."""
        sentences, (low, high) = list[str](), self.motion.subject.bounds
        seed = self.seed_from_neighbour(near)
        for point, way in lost_states(self.motion.steady_branches()) if seed is None else ():
            if seed is None and low < point.parameter < high:
                seed = orbit_beyond_loss(self.motion, point, way, sentences, self.report)
        if seed is None:
            return "; ".join(dict.fromkeys(sentences)) or "no stable steady state is lost there"
        return self.row_through(seed)

    def further_row(self, near: OrbitRow | str | None, seeds: tuple[SeedOrbit, ...]) -> OrbitRow | str:
        """Follow the branch of a motion that runs have reached: through a seed, or through the neighbouring branch's orbit."""
        beside = self.seed_from_neighbour(near)
        row: OrbitRow | str = "the neighbouring motion cannot be followed to this value"
        for seed in (*([beside] if beside is not None else []), *seeds):
            row = self.row_through(seed)
            if isinstance(row, OrbitRow):
                break
        return row

    def row_through(self, seed: SeedOrbit) -> OrbitRow | str:
        """Follow the branch through an orbit both ways."""
        try:
            back, onward = (branch_to_end(self.motion, seed, way, self.report) for way in (-1, 1))
            low, high = sorted((back.end, onward.end), key=lambda end: end.value)
            value = (low.value + high.value) / 2
            middle = self._orbit_within(seed, onward if value > seed.value else back, value)
            e = self.motion.subject.embedding
            if e is not None and e.shape[0] == e.shape[1] + 1:
                return self._row_in_section((low, high), middle, (back, onward))
            return self._row_by_collocation((low, high), middle)
        except WuchtError as error:
            return str(error)

    def _orbit_within(self, seed: SeedOrbit, half: BranchToEnd, value: float) -> SeedOrbit:
        """Return the orbit of a branch at a value, or as near to it as the branch is followed.

        half: the branch from the seed on, towards that value.
        """
        passages = (a for a, b in pairwise(half.orbits) if (a.parameter - value) * (b.parameter - value) <= 0)
        near = next(passages, half.orbits[0])
        seed = replace(SeedOrbit.from_cycle(half.cycles, near, "within a branch", both_ways=True), longest=seed.longest)
        low, high = sorted((seed.value, value))
        if high - low < 1e-6 * self.motion.subject.width:
            return seed
        cycles, start = cycles_through(replace(self.motion.subject, bounds=(low, high)), seed, draws=False)
        last = _last_of(cycles, start, value > seed.value)
        return replace(SeedOrbit.from_cycle(cycles, last, "within a branch", both_ways=True), longest=seed.longest)

    def _row_by_collocation(self, sides: tuple[OrbitEnd, OrbitEnd], middle: SeedOrbit) -> OrbitRow:
        """Compute the row with the stability by collocation, in all equations."""
        whole_seed = self.motion.lift(replace(middle, longest=_LONGEST * middle.period))
        back, onward = (
            half_branch(self.motion.whole, whole_seed, way, False, lambda _: self.report()) for way in (False, True)
        )
        values, is_trusted, stable = (
            np.concatenate([getattr(back, name)[::-1], getattr(onward, name)]) for name in ("values", "is_trusted", "stable")
        )
        special = tuple(k for p in (back, onward) for k in p.stored_orbits if k.kind)
        usable = is_trusted if is_trusted.any() else np.ones(len(values), bool)
        return OrbitRow(self.second, sides, values[usable], stable[usable], special, middle, whole_seed)

    def _row_in_section(
        self, sides: tuple[OrbitEnd, OrbitEnd], middle: SeedOrbit, halves: tuple[BranchToEnd, BranchToEnd]
    ) -> OrbitRow:  # fmt: skip
        """Compute the row where one direction leads out of the section: its exponent is a mean, accurate for any period.

        halves: the branch as it was followed, both from its first orbit.
        """
        seed = replace(middle, longest=_LONGEST * middle.period)
        exponent = transverse_exponent(self.motion)
        orbits = self._orbits_around(seed, *halves)
        values, out = np.array([c.parameter for c in orbits]), np.array([exponent(c) for c in orbits])
        inside = np.array([not c.is_trusted or c.unstable == 0 for c in orbits])
        i = np.flatnonzero(out[:-1] * out[1:] < 0)
        loss_values = values[i] + out[i] / (out[i] - out[i + 1]) * (values[i + 1] - values[i])
        special = tuple(
            replace(stored_orbit(orbits[k]), value=at, kind=BRANCH_POINT)
            for k, at in zip(i.tolist(), loss_values.tolist(), strict=True)
        )
        return OrbitRow(self.second, sides, values, inside & (out < 0), special, middle, self.motion.lift(seed))

    def _orbits_around(self, middle: SeedOrbit, back: BranchToEnd, onward: BranchToEnd) -> list[Cycle]:
        """Return the regular orbits of a branch around its middle one, both ways up to the longest period of that seed.

        They are in order along the branch. Where an end was reached before, the branch is followed on.
        """
        orbits, width = [*back.orbits[:0:-1], *onward.orbits], self.motion.subject.width
        away = [abs(c.parameter - middle.value) / width + abs(c.period / middle.period - 1) for c in orbits]
        k, parts = int(np.argmin(away)), list[list[Cycle]]()
        for half, way in ((back, orbits[k::-1]), (onward, orbits[k + 1 :])):
            short = list(takewhile(lambda c: c.period <= middle.longest, way))
            beyond = half.cycles.walk(half.orbits[-1]) if len(short) == len(way) else ()
            for cycle in takewhile(lambda c: c.period <= middle.longest, beyond):
                self.report()
                short += [] if cycle.kind else [cycle]
            parts.append(short)
        return [*parts[0][::-1], *parts[1]]

    def seed_from_neighbour(self, near: OrbitRow | str | None) -> SeedOrbit | None:
        """Follow the middle orbit of a neighbouring branch to the value of the second parameter; None where that fails."""
        if not isinstance(near, OrbitRow) or near.second == self.second:
            return near.middle if isinstance(near, OrbitRow) else None
        seed = near.middle
        low, high = sorted((near.second, self.second))
        here = self.motion.with_values({self.motion.subject.path: seed.value}).subject
        begin = replace(seed, value=near.second, scale=np.append(seed.scale[:-1], high - low))
        try:
            cycles, start = cycles_through(replace(here, path=self.path, bounds=(low, high)), begin, draws=False)
            last = _last_of(cycles, start, self.second > near.second, _ORBITS_BETWEEN)
            if not math.isclose(last.parameter, self.second, rel_tol=1e-9):
                return None
            orbit = SeedOrbit.from_cycle(cycles, last, "a neighbouring branch", both_ways=True)
        except RunError:
            return None
        return replace(orbit, value=seed.value, scale=seed.scale, longest=seed.longest)


def transverse_exponent(motion: ModulatedMotion) -> Callable[[Cycle], float]:
    """Return a function for ln mu of the one direction that leads out of the section, by an integral over an orbit."""
    whole, e = motion.whole, motion.subject.embedding
    assert e is not None
    equations = EquilibriumEquations.from_system(whole.system, [whole.path], whole.fixed_values(whole.path))
    out = np.linalg.qr(e, mode="complete")[0][:, -1]

    def exponent(cycle: Cycle) -> float:
        states = e @ cycle.states
        matrix = equations.values(np.concatenate([states, np.full((1, states.shape[1]), cycle.parameter)]))[1][:, :-1]
        return cycle.integral(np.einsum("i,ijk,j->k", out, matrix, out))

    return exponent


def _last_of(cycles: Cycles, start: Cycle, onward: bool, most: int | None = None) -> Cycle:
    """Return the last regular orbit of a branch, one way from its first. most: orbits after which it is left."""
    last = start
    for cycle in islice(cycles.walk(start if onward else cycles.backwards(start)), most):
        last = last if cycle.kind else cycle
    return last


def orbit_curve(motion: ModulatedMotion, second: SecondParameter, row: OrbitRow, special: StoredOrbit) -> PlaneCurve:
    """Follow the curve through a special orbit of a row both ways. motion: at the row. Raises ``WuchtError``."""
    subject, seed = motion.whole, row.whole
    paths, bounds = (subject.path, second.path), (subject.bounds, second.bounds)
    widths = {p: b[1] - b[0] for p, b in zip(paths, bounds, strict=True)}
    sizes = dict(zip(subject.system.state_names, seed.scale[:-1].tolist(), strict=True)) | widths
    longest = _LONGER * special.period
    at = _locate_special(*cycles_through(subject, replace(seed, longest=longest)), special)
    curves = CycleCurve.of(
        special.kind, subject.system, paths, subject.fixed_values(*paths), bounds,
        winding=subject.turns(seed.winding), scale=sizes, periods=(0.0, longest),
    )  # fmt: skip
    return _curve_both_ways(special.kind, curves, curves.start(at, row.second))


def _locate_special(cycles: Cycles, start: Cycle, special: StoredOrbit) -> Cycle:
    """Recompute the special orbit on the branch of another one. Raises ``RunError``."""
    for cycle in cycles.walk(start if special.value > start.parameter else cycles.backwards(start)):
        if cycle.kind == special.kind and abs(cycle.parameter - special.value) < _SAME * (cycles.bounds[1] - cycles.bounds[0]):
            return cycle
    raise RunError("the special orbit could not be recomputed")


def _curve_both_ways(kind: str, curves: Any, start: Any) -> PlaneCurve:
    """Follow the curve through a point of a ``CycleCurve``, or of ``Connections``, both ways."""
    back, onward = (
        [p.parameter_values[:2] for p in islice(curves.walk(first), _POINTS)] for first in (curves.backwards(start), start)
    )
    x, y = np.array([*back[::-1], start.parameter_values[:2], *onward], float).T
    return PlaneCurve(kind, x, y)


def connection_curve(motion: ModulatedMotion, second: SecondParameter, row: OrbitRow, end: OrbitEnd) -> PlaneCurve:
    """Follow the curve of saddle connections through the end of a row both ways. Raises ``WuchtError`` if there is none."""
    return _curve_both_ways(SADDLE_CONNECTION, *connections_at(motion, second.path, second.bounds, end, row.second))
