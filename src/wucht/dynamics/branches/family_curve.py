"""Branches of states that form families: followed modulo the family.

The states in which the bodies' unbalances compensate each other, S = 0, form a continuum where there are more bodies than the
force polygon needs. There is no vibration, so the drives' torques alone determine the speed, whatever the member:
sum tau_i(w, p) = 0 is followed. Some members may be stable and others not: many are sampled, and the points are located
from which on some of them are stable, and from which on all. One member represents the family where a state is shown; its
exponents are those transverse to the family.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.analysis.configurations.closed_form import State, compensating_phases, family_members
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.equilibrium_branches import (
    ALL_STABLE,
    SOME_STABLE,
    EquilibriumBranch,
    StabilityLevel,
    describe_ends,
    stability_levels,
)
from wucht.dynamics.branches.steady_states import Kind
from wucht.errors import RunError
from wucht.machines.structure import SPEED
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import Branch, Equilibrium, EquilibriumContinuation
from wucht.numerics.zeros_and_peaks import first_where
from wucht.system import System

# Members of a family whose stability is computed; the first represents all. All of 64 may be stable where 1 of 500 is not.
SAMPLED_MEMBERS = 512
_BISECTIONS = 50
_EQUAL = 1e-12  # relative: unbalances that have not changed
_NEAR = 1e-6  # of the fastest speed: two branches of speeds that are one


@dataclass(frozen=True)
class _Members:
    """Sample of members: phases (n, k), the first representing the family, and their transverse exponents (k, m)."""

    phases: np.ndarray
    exponents: np.ndarray

    @cached_property
    def share(self) -> float:
        """Fraction of the members that are stable."""
        return float((stability_levels(self.exponents.T) == StabilityLevel.STABLE).mean())

    @property
    def first(self) -> int:
        """Index of the member whose disturbances decay fastest."""
        return int(self.exponents[:, 0].real.argmin())

    @property
    def last(self) -> int:
        """Index of the member in which a disturbance decays most slowly, or grows."""
        return int(self.exponents[:, 0].real.argmax())


@dataclass(frozen=True, eq=False)
class FamilyCurve:
    """Families of states of a machine along a parameter. polygons: phases of members by the sides of the force polygon, as
    ``_polygon`` returns them."""

    averaged_equilibria: AveragedEquilibria
    polygons: dict[tuple[float, ...], tuple[np.ndarray, int] | None] = field(default_factory=dict)

    @cached_property
    def equilibria(self) -> EquilibriumContinuation:
        """Common speed over the parameter: (w, p) with sum tau_i(w, p) = 0."""
        states = self.averaged_equilibria
        machine, path, (low, high) = states.machine, states.path, states.bounds
        torques, prescribed_speed = (
            states.model_at(states.nominal_value).torques,
            states.averaged_equations.averaged_system.bodies.fixed_speed,
        )
        rate = (
            sp.Add(*torques.shaft_torques) / float(torques.inertia.sum())
            if prescribed_speed is None
            else prescribed_speed - SPEED
        )
        system, scale = System((SPEED,), (rate,), machine.structure.symbols), {SPEED.name: states.fastest, path: high - low}
        equations = EquilibriumEquations.from_system(system, [path], machine.values, scale)
        return EquilibriumContinuation(equations, states.bounds, states.equilibria.steps, {0: states.limits})

    def follow_branch(self, state: State, value: float) -> EquilibriumBranch:
        """Follow the branch of the family to which a state at a value belongs. Raises ``RunError`` where that is impossible."""
        branch = self.equilibria.follow_branch(self.equilibria.start([state.speed], value))
        points, ends = self._closing_part(branch, value, state.speed)
        rows = list[tuple[np.ndarray, np.ndarray, str, float]]()
        for i, p in enumerate(points):
            here = float(p.x[0]), p.parameter, self._members(p.parameter, float(p.x[0])), p.kind
            for speed, at, sample, kind in (*(self._changes(points[i - 1], p) if i else ()), here):
                # At a limit the member that gains or loses its stability there: the first that is stable, or the last.
                k = {SOME_STABLE: sample.first, ALL_STABLE: sample.last}.get(kind, 0)
                rows.append((self._point(speed, sample.phases[:, k], at), sample.exponents[k], kind, sample.share))
        unknowns, exponents, kinds, shares = zip(*rows, strict=True)
        table = np.full((len(self.averaged_equilibria.names), len(rows)), np.nan, complex)
        for i, column in enumerate(exponents):
            table[: len(column), i] = column
        return EquilibriumBranch(
            unknowns=np.array(unknowns).T, exponents=table, kinds=kinds, ends=ends,
            kind=Kind("compensating"), dimension=state.dimension, stable_share=shares,
        )  # fmt: skip

    def is_same_family(self, branch: EquilibriumBranch, state: State, value: float) -> bool:
        """True if a family at a value belongs to a branch: its speed is that of the branch there."""
        near = _NEAR * self.averaged_equilibria.fastest
        return branch.dimension == state.dimension and any(abs(w - state.speed) < near for w in self._speeds(branch, value))

    def _speeds(self, branch: EquilibriumBranch, value: float) -> list[float]:
        """Return the common speeds with which a branch passes a value."""
        speeds = list[float]()
        for guess in branch.crossings(value):
            try:
                speeds.append(float(self.equilibria.start([self.averaged_equilibria.state(guess).speed], value).unknowns[0]))
            except RunError:
                continue
        return speeds

    def states_at(self, branch: EquilibriumBranch, value: float) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Return unknowns (n+1,) and exponents (k,) of the member that represents a family, where its branch has a value, and
        the share of members that are stable.
        """
        states = list[tuple[np.ndarray, np.ndarray, float]]()
        for speed in self._speeds(branch, value):
            try:
                sample = self._members(value, speed)
            except RunError:
                continue
            states.append((self._point(speed, sample.phases[:, 0], value), sample.exponents[0], sample.share))
        return states

    def _point(self, speed: float, phases: np.ndarray, value: float) -> np.ndarray:
        return self.averaged_equilibria.point(State(speed, phases), value)

    def _closes(self, value: float) -> bool:
        return self._polygon(value) is not None

    def _polygon(self, value: float) -> tuple[np.ndarray, int] | None:
        """Return phases (n, k) of members and the dimension; None where there is no state, or only isolated ones."""
        torques = self.averaged_equilibria.model_at(value).torques
        c = torques.coefficients
        if c is None:
            return None
        sides = tuple(np.round(np.concatenate([c.real, c.imag]) / np.abs(c).max() / _EQUAL).tolist())
        if sides not in self.polygons:
            self.polygons[sides] = _members_of_polygon(torques)
        return self.polygons[sides]

    def _members(self, value: float, speed: float) -> _Members:
        polygon = self._polygon(value)
        if polygon is None:
            raise RunError("the unbalances do not compensate each other here")
        phases, dimension = polygon
        return _Members(
            phases, self.averaged_equilibria.model_at(value).exponents(State(speed, phases[:, 0], dimension), phases)
        )

    def _closing_part(self, branch: Branch, value: float, speed: float) -> tuple[list[Equilibrium], tuple[str, str]]:
        """Return the points of a branch of speeds around a state, as far as the unbalances compensate each other."""
        scale = self.equilibria.equations.scale
        points = list(branch.points)
        first = last = int(np.argmin([np.abs((p.unknowns - [speed, value]) / scale).max() for p in points]))
        while first > 0 and self._closes(points[first - 1].parameter):
            first -= 1
        while last + 1 < len(points) and self._closes(points[last + 1].parameter):
            last += 1
        states = self.averaged_equilibria

        def limit_reason(unknowns: np.ndarray) -> str:
            return states.speed_limit_reason(bool(unknowns[0] <= states.limits[0]))

        ends = list(describe_ends(self.equilibria, branch, states.path, limit_reason))
        kept_points = points[first : last + 1]
        if first > 0:
            kept_points.insert(0, self._last_closing_point(points[first], points[first - 1]))
            ends[0] = _OPEN
        if last + 1 < len(points):
            kept_points.append(self._last_closing_point(points[last], points[last + 1]))
            ends[1] = _OPEN
        return kept_points, (ends[0], ends[1])

    def _last_closing_point(self, good: Equilibrium, bad: Equilibrium) -> Equilibrium:
        inside, outside = good.unknowns, bad.unknowns
        for _ in range(_BISECTIONS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self._closes(float(middle[1])) else (inside, middle)
        return self.equilibria.evaluate(self.equilibria.start(inside[:1], float(inside[1])))

    def _changes(self, a: Equilibrium, b: Equilibrium) -> list[tuple[float, float, _Members, str]]:
        """Return speed, value, members and kind of the points between two where some, or all, members change stability."""
        if a.kind or b.kind:
            return []

        def point_at(way: float) -> tuple[float, float, _Members]:
            guess = a.unknowns + way * (b.unknowns - a.unknowns)
            speed, value = self.equilibria.start(guess[:1], float(guess[1])).unknowns.tolist()
            return speed, value, self._members(value, speed)

        def levels(way: float) -> dict[str, bool]:
            share = point_at(way)[2].share
            return {SOME_STABLE: share > 0, ALL_STABLE: share >= 1}

        changes = list[tuple[float, tuple[float, float, _Members, str]]]()
        before, after = levels(0.0), levels(1.0)
        for kind in before:
            if before[kind] != after[kind]:
                way = first_where(lambda s, kind=kind: levels(s)[kind] != before[kind], 0.0, 1.0)  # type: ignore[misc]
                changes.append((way, (*point_at(way), kind)))
        if len(changes) == len(before):  # between both limits a point where some members are stable
            way = sum(w for w, _ in changes) / len(changes)
            changes.append((way, (*point_at(way), "")))
        return [point for _, point in sorted(changes, key=lambda f: f[0])]


_OPEN = "beyond, the unbalances cannot compensate each other"


def _members_of_polygon(torques: SteadyTorques) -> tuple[np.ndarray, int] | None:
    solutions = compensating_phases(torques)
    if not solutions or not solutions[0][1]:
        return None
    phases, dimension, _ = solutions[0]
    return np.concatenate([phases[:, None], family_members(torques, SAMPLED_MEMBERS - 1)], axis=1), dimension
