"""Branches of steady states: each state is followed both ways, and from branch points the crossing branches too."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property

import numpy as np

from wucht.analysis.configurations.averaged_stability import NEUTRAL
from wucht.dynamics.branches.steady_states import Kind, SteadyStates
from wucht.errors import RunError
from wucht.numerics.continuation.equations import CurvePoint
from wucht.numerics.continuation.equilibria import BRANCH_POINT, FOLD, Branch, Equilibria, Equilibrium
from wucht.numerics.continuation.special_curves import UNRESOLVED
from wucht.numerics.zeros_and_peaks import at_passages

_PITCHFORK = 1e-4  # in units of scale: between a branch point and the fold of the branch that begins there

_SAMPLES = 9  # points of a branch at which its state is named
_COMPARED = (0.12, 0.3, 0.7, 0.88)  # of a branch: points of comparison, not in the middle, where a pitchfork has its vertex
_LENGTH = 1e-6  # in units of scale: a shorter branch is a point
ON = 1e-9  # in units of scale: a point so near to a bound lies on it
_CLOSE = 1e-3  # in units of scale: a point so near to a bound would reach it
_STUCK = "no further point of the branch can be computed"
RANGE_ENDS = "the range ends"
SOME_STABLE, ALL_STABLE = "some-stable", "all-stable"  # from here on some, or all, members of a family are stable


class Stability(IntEnum):
    """Stability of a point. PARTLY_STABLE: only some members of a family. NEUTRAL: a disturbance neither grows nor decays."""

    NEUTRAL = -1
    NONE = 0
    SOME = 1
    ALL = 2


def stability(exponents: np.ndarray) -> np.ndarray:
    """Return ``StabilityLevel`` (N,) from exponents (n, N), which are nan where there are fewer."""
    growth, fastest = np.nanmax(exponents.real, axis=0), np.nanmax(np.abs(exponents), axis=0)
    decays = np.where(growth < -NEUTRAL * fastest, Stability.ALL, Stability.NEUTRAL)
    return np.where(growth > NEUTRAL * fastest, Stability.NONE, decays)


def stability_from_share(share: float) -> Stability:
    """Return the stability of a family from the fraction of its members that are stable."""
    return Stability.ALL if share >= 1 else Stability.SOME if share > 0 else Stability.NONE


@dataclass(frozen=True)
class EquilibriumBranch:
    """Equilibria in their order along a branch, as stored between runs.

    u (n+1, N): states, angles not wrapped, and parameter. exponents (n, N): per unit of time, nan where a
    family has fewer. kinds (N): "" or the kind of a special point. ends: why it ends, at first and last. dimension: of
    the family that it represents, 0 for isolated states. stable_share (N): of the family's members, empty where
    there is no family. kind: name and type of the states. offshoots: point and direction (n+1,) of the
    branches that cross it. second: value of the second parameter.
    """

    u: np.ndarray
    exponents: np.ndarray
    kinds: tuple[str, ...]
    ends: tuple[str, str]
    kind: Kind = field(default_factory=Kind)
    dimension: int = 0
    stable_share: tuple[float, ...] = ()
    offshoots: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    second: float | None = None

    @property
    def values(self) -> np.ndarray:
        """Values of the parameter (N,)."""
        return np.asarray(self.u[-1])

    @cached_property
    def stability(self) -> np.ndarray:
        """``StabilityLevel`` of each point (N,); at a special point the higher one of its neighbours."""
        shares, special = self.stable_share, self._special
        each = np.array([stability_from_share(s) for s in shares]) if shares else stability(self.exponents)
        known = np.where(special, Stability.NEUTRAL, each)
        beside = np.maximum(np.append(Stability.NEUTRAL, known[:-1]), np.append(known[1:], Stability.NEUTRAL))
        return np.asarray(np.where(special, beside, each))

    @property
    def stable(self) -> np.ndarray:
        """True where all disturbances of all members decay (N,)."""
        return np.asarray(self.stability == Stability.ALL)

    @property
    def _special(self) -> np.ndarray:
        return np.array([bool(kind) for kind in self.kinds])

    def intervals(self, of: Stability) -> list[tuple[int, int]]:
        """Return first and last point of each stretch of a level, up to the special or neutral points where it ends."""
        special = self._special
        open_ = special | (self.stability == Stability.NEUTRAL)  # does not determine the stretch that it lies in, or ends
        sure = np.flatnonzero(~open_).tolist()
        groups: list[tuple[int, int]] = []
        for k, i in enumerate(sure):
            if self.stability[i] != of:
                continue
            before, after = (sure[k - 1] if k else -1), (sure[k + 1] if k + 1 < len(sure) else len(open_))
            if groups and k and self.stability[before] == of:
                groups[-1] = (groups[-1][0], self._up_to(i, after, 1))
            else:
                groups.append((self._up_to(i, before, -1), self._up_to(i, after, 1)))
        return groups

    def _up_to(self, i: int, other: int, way: int) -> int:
        """Return the end of a stretch that contains point i on the way to the limit: the special point, if there is one."""
        between = range(i + way, other, way)
        return next((j for j in between if self.kinds[j]), between[0] if between else i)

    @property
    def unlocated(self) -> list[tuple[int, int]]:
        """Neighbouring points between which stability changes without a located special point."""
        special = np.array([bool(kind) and kind != UNRESOLVED for kind in self.kinds])
        sure = np.flatnonzero(~self._special & (self.stability != Stability.NEUTRAL))
        pairs = zip(sure[:-1].tolist(), sure[1:].tolist(), strict=True)
        return [(i, j) for i, j in pairs if self.stability[i] != self.stability[j] and not special[i:j].any()]

    def length(self, scale: np.ndarray) -> float:
        """Return the arc length through all points, in units of scale (n+1,)."""
        return float((np.abs(np.diff(self.u / scale[:, None], axis=1)) ** 2).sum(axis=0) ** 0.5 @ np.ones(self.u.shape[1] - 1))

    def crossings(self, value: float) -> Iterator[np.ndarray]:
        """Return points (n+1,) where the branch passes a value, interpolated to first order."""
        return (np.append(x, value) for x in at_passages(self.values, value, self.u[:-1])[1].T)


def branch_through(states: SteadyStates, start: CurvePoint) -> EquilibriumBranch:
    """Follow the branch of isolated states through a point both ways, with its name, and the starts of those that cross it."""
    equilibria = states.equilibria
    branch = equilibria.branch(start)
    points = [p for p in branch.points if not _turns_at_a_branch_point(branch, p)]
    offshoots = [other for p in points if p.kind == BRANCH_POINT for other in _offshoots(equilibria, p)]
    made = EquilibriumBranch(
        u=np.array([p.u for p in points]).T, exponents=np.array([p.eigenvalues for p in points]).T,
        kinds=tuple(p.kind for p in points), offshoots=tuple(offshoots),
        ends=ends_in_words(states.equilibria, branch, states.path, states.end),
    )  # fmt: skip
    return replace(made, kind=_kind(states, made))


def _turns_at_a_branch_point(branch: Branch, point: Equilibrium) -> bool:
    """True if a fold is one only because the branch begins there on another one, symmetrically: a pitchfork."""
    scale = branch.equations.scale
    return point.kind == FOLD and any(
        p.kind == BRANCH_POINT and np.abs((p.u - point.u) / scale).max() < _PITCHFORK for p in branch.special
    )


def _offshoots(equilibria: Equilibria, at: Equilibrium) -> list[tuple[np.ndarray, np.ndarray]]:
    try:
        return [(p.u, p.tangent) for p in equilibria.switched(at)]
    except RunError:
        return []


def _kind(states: SteadyStates, made: EquilibriumBranch) -> Kind:
    """Return name, type and split as far as they are the same along the branch, from some points that are not special."""
    regular = np.flatnonzero([not kind for kind in made.kinds])
    chosen = regular[np.linspace(0, len(regular) - 1, min(_SAMPLES, len(regular))).astype(int)]
    seen = {states.kind(made.u[:, i]) for i in chosen}
    if len(seen) == 1:
        return seen.pop()
    names, splits = {(k.name, k.type) for k in seen}, {k.split for k in seen}
    name, type_ = names.pop() if len(names) == 1 else (None, None)
    return Kind(name, type_, splits.pop() if len(splits) == 1 else None, max((k.multiplicity for k in seen), default=1))


def ends_in_words(equilibria: Equilibria, branch: Branch, path: str, leaves: Callable[[np.ndarray], str]) -> tuple[str, str]:
    """Return why a branch ends, at first and last. path: of the parameter. limit_reason: of a state (n+1,) at its limits."""
    if branch.closed:
        return branch.ends
    # A branch with fewer points than the maximum ends where not even the shortest step leads to another one.
    fewer = len(branch.points) < equilibria.steps.points
    first, last = (
        end_in_words(equilibria, f"{path} = {p.parameter:.5g}", leaves, p.u, _STUCK if fewer else said)
        for p, said in zip((branch.points[0], branch.points[-1]), branch.ends, strict=True)
    )
    return first, last


def end_in_words(equilibria: Equilibria, at: str, leaves: Callable[[np.ndarray], str], u: np.ndarray, said: str) -> str:
    """Return why a branch that is not closed ends at a point u (n+1,).

    at: the place as text. limit_reason: of a state at its limits. reason: of the continuation, for all other cases.
    """
    scale = equilibria.equations.scale
    off = min(abs(float(u[-1]) - bound) for bound in equilibria.bounds) / scale[-1]
    if any(min(abs(u[i] - bound) for bound in pair) <= ON * scale[i] for i, pair in equilibria.limits.items()):
        return leaves(u)
    if off <= ON:
        return RANGE_ENDS
    if off <= _CLOSE:
        return f"it is followed to {at}: nearer to the end of the range the equations are singular"
    return f"at {at}: {said}"


def points_at(states: SteadyStates, branch: EquilibriumBranch, value: float) -> list[CurvePoint]:
    """Return the points of a branch of isolated states at a value."""
    points: list[CurvePoint] = []
    for guess in branch.crossings(value):
        try:
            found = states.equilibria.start(guess[:-1], value)
        except RunError:
            continue
        if not any(states.same(found.u, p.u) for p in points):
            points.append(found)
    return points


def lies_on(states: SteadyStates, branches: Sequence[EquilibriumBranch], u: np.ndarray) -> bool:
    """True if a point lies on one of the branches, up to an exchange of equal bodies."""
    value = float(u[-1])
    return any(states.same(u, p.u) for b in branches if not b.dimension for p in points_at(states, b, value))


def repeats(states: SteadyStates, branches: Sequence[EquilibriumBranch], other: EquilibriumBranch) -> bool:
    """True if a branch is only a point, or coincides with a known one at points far from its special ones."""
    regular = np.flatnonzero([not kind for kind in other.kinds])
    if not len(regular) or other.length(states.equilibria.equations.scale) < _LENGTH:
        return True
    chosen = regular[(np.array(_COMPARED) * (len(regular) - 1)).astype(int)]
    return all(lies_on(states, branches, other.u[:, i]) for i in chosen)
