"""Branches of states that form families: followed modulo the family.

The states in which the bodies' unbalances compensate each other, S = 0, form a continuum where there are more bodies than the
force polygon needs. The vibration is gone there, so that the drives' own torques alone decide the speed, whatever the member:
sum tau_i(w, p) = 0 is followed, and one member stands for all. Its exponents are those transverse to the family.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.force_balance import compensating, members
from wucht.errors import RunError
from wucht.machines.structure import SPEED
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.equilibria import BRANCH_POINT, HOPF, Branch, Equilibria, Equilibrium
from wucht.numerics.zeros import first_where
from wucht.studies.speed_curve.following import RANGE_ENDS, FollowedBranch
from wucht.studies.speed_curve.slow_states import SlowStates
from wucht.studies.speed_curve.steady_states import Kind
from wucht.system import System

_MEMBERS = 16  # of a family whose stability is looked at, besides the one that stands for it
_BISECTIONS = 50
_EQUAL = 1e-12  # relative: unbalances that have not changed
_NEAR = 1e-6  # of the fastest speed: two branches of speeds that are one


@dataclass(frozen=True)
class _Member:
    """phases (n,) of the member. others (n, k). dimension, exponents (k,) transverse, share: of members that are stable."""

    phases: np.ndarray
    dimension: int
    exponents: np.ndarray
    share: float


@dataclass(frozen=True, eq=False)
class FamilyCurve:
    """The families of a machine along a parameter."""

    slow: SlowStates

    @cached_property
    def equilibria(self) -> Equilibria:
        """The common speed over the parameter: (w, p) with sum tau_i(w, p) = 0."""
        slow = self.slow
        torques, given = slow.at(slow.machine.values[slow.path]).torques, slow.averaged.equations.bodies.given
        rate = sp.Add(*torques.own) / float(torques.inertia.sum()) if given is None else given - SPEED
        system = System((SPEED,), (rate,), slow.machine.structure.symbols)
        scale = {SPEED.name: slow.fastest, slow.path: slow.bounds[1] - slow.bounds[0]}
        equations = Equations.of(system, [slow.path], slow.machine.values, scale)
        return Equilibria(equations, slow.bounds, slow.equilibria.steps, {0: slow.limits})

    def branch(self, state: State, value: float) -> FollowedBranch:
        """The branch of the family to which a state at a value belongs. Raises ``RunError`` where it cannot be followed."""
        branch = self.equilibria.branch(self.equilibria.start([state.speed], value))
        points, ends = self._closing(branch, value, state.speed)
        seen = [self._member(p.x[0], p.parameter) for p in points]
        whole, all_members, kinds = list[np.ndarray](), list[_Member](), list[str]()
        for i, (p, m) in enumerate(zip(points, seen, strict=True)):
            if i and (found := self._stability_change(points[i - 1], p)) is not None:
                speed, at, member = found
                whole.append(self._point(speed, at, member))
                all_members.append(member)
                kinds.append(HOPF if abs(member.exponents[0].imag) > 0 else BRANCH_POINT)
            whole.append(self._point(float(p.x[0]), p.parameter, m))
            all_members.append(m)
            kinds.append(p.kind)
        return FollowedBranch(
            u=np.array(whole).T, exponents=self._exponents(all_members), kinds=tuple(kinds), ends=ends,
            kind=Kind("compensating"), dimension=state.dimension, stable_share=tuple(m.share for m in all_members),
        )  # fmt: skip

    def same(self, branch: FollowedBranch, state: State, value: float) -> bool:
        """Whether a family at a value belongs to a branch: its speed is that of the branch there."""
        near = _NEAR * self.slow.fastest
        return branch.dimension == state.dimension and any(abs(w - state.speed) < near for w in self._speeds(branch, value))

    def _speeds(self, branch: FollowedBranch, value: float) -> list[float]:
        """The common speeds with which a branch passes a value."""
        speeds = list[float]()
        for guess in branch.crossings(value):
            try:
                speeds.append(float(self.equilibria.start([self.slow.state(guess).speed], value).u[0]))
            except RunError:
                continue
        return speeds

    def at(self, branch: FollowedBranch, value: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """u (n+1,) and exponents (k,) of the member that stands for a family, where its branch passes a value."""
        found = list[tuple[np.ndarray, np.ndarray]]()
        for speed in self._speeds(branch, value):
            try:
                member = self._member(speed, value)
            except RunError:
                continue
            found.append((self._point(speed, value, member), member.exponents))
        return found

    def _point(self, speed: float, value: float, member: _Member) -> np.ndarray:
        return self.slow.point(State(speed, member.phases), value)

    def _exponents(self, all_members: list[_Member]) -> np.ndarray:
        n = len(self.slow.names)
        exponents = np.full((n, len(all_members)), np.nan, complex)
        for i, m in enumerate(all_members):
            exponents[: len(m.exponents), i] = m.exponents
        return exponents

    @cached_property
    def _known(self) -> dict[tuple[float, ...], tuple[np.ndarray, int, np.ndarray]]:
        return {}

    def _closes(self, value: float) -> bool:
        return self._polygon(value) is not None

    def _polygon(self, value: float) -> tuple[np.ndarray, int, np.ndarray] | None:
        """A member's phases (n,), the dimension, and others (n, k); None where the unbalances cannot compensate."""
        torques = self.slow.at(value).torques
        c = torques.coefficients
        if c is None:
            return None
        key = tuple(np.round(np.concatenate([c.real, c.imag]) / np.abs(c).max() / _EQUAL).tolist())
        if key not in self._known:
            found = compensating(torques)
            if not found or not found[0][1]:
                return None
            phases, dimension, _ = found[0]
            self._known[key] = phases, dimension, members(torques, _MEMBERS)
        return self._known[key]

    def _member(self, speed: float, value: float) -> _Member:
        polygon = self._polygon(value)
        if polygon is None:
            raise RunError("the unbalances do not compensate each other here")
        phases, dimension, others = polygon
        stability = self.slow.at(value)
        every = stability.exponents(State(speed, phases, dimension), np.concatenate([phases[:, None], others], axis=1))
        return _Member(phases, dimension, every[0], float((every[:, 0].real < 0).mean()))

    def _closing(self, branch: Branch, value: float, speed: float) -> tuple[list[Equilibrium], tuple[str, str]]:
        """The points of a branch of speeds around a state, as far as the unbalances compensate each other."""
        scale = self.equilibria.equations.scale
        points = list(branch.points)
        here = int(np.argmin([np.abs((p.u - [speed, value]) / scale).max() for p in points]))
        first = here
        while first > 0 and self._closes(points[first - 1].parameter):
            first -= 1
        last = here
        while last + 1 < len(points) and self._closes(points[last + 1].parameter):
            last += 1
        ends = list(branch.ends)
        kept = points[first : last + 1]
        if first > 0:
            kept.insert(0, self._last_closing(points[first], points[first - 1]))
            ends[0] = _OPEN
        if last + 1 < len(points):
            kept.append(self._last_closing(points[last], points[last + 1]))
            ends[1] = _OPEN
        return kept, (_in_words(ends[0]), _in_words(ends[1]))

    def _last_closing(self, good: Equilibrium, bad: Equilibrium) -> Equilibrium:
        inside, outside = good.u, bad.u
        for _ in range(_BISECTIONS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self._closes(float(middle[1])) else (inside, middle)
        return self.equilibria.seen(self.equilibria.start(inside[:1], float(inside[1])))

    def _stability_change(self, a: Equilibrium, b: Equilibrium) -> tuple[float, float, _Member] | None:
        """Speed, value and member where the member's stability changes between two points, None where it does not."""

        if a.kind or b.kind:
            return None

        def of(share: float) -> tuple[float, float, _Member]:
            guess = a.u + share * (b.u - a.u)
            speed, value = self.equilibria.start(guess[:1], float(guess[1])).u.tolist()
            return speed, value, self._member(speed, value)

        def decays(share: float) -> bool:
            return bool(of(share)[2].exponents[0].real < 0)

        before = decays(0.0)
        if decays(1.0) == before:
            return None
        return of(first_where(lambda share: decays(share) != before, 0.0, 1.0))


_OPEN = "beyond, the unbalances cannot compensate each other"


def _in_words(end: str) -> str:
    return RANGE_ENDS if end.startswith("it leaves the range") else end
