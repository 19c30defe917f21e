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
from wucht.numerics.continuation.curve import CURVE_IS_CLOSED
from wucht.numerics.continuation.equations import CurvePoint
from wucht.numerics.continuation.equilibria import BRANCH_POINT, FOLD, HOPF, Branch, Equilibrium, EquilibriumContinuation
from wucht.numerics.continuation.special_curves import UNRESOLVED_POINT
from wucht.numerics.zeros_and_peaks import values_at_passages

_PITCHFORK = 1e-4  # in units of scale: between a branch point and the fold of the branch that begins there

_SAMPLES = 9  # points of a branch at which its state is named
_COMPARISON_SHARES = (
    0.12,
    0.3,
    0.7,
    0.88,
)  # of a branch: points of comparison, not in the middle, where a pitchfork has its vertex
_LENGTH = 1e-6  # in units of scale: a shorter branch is a point
BOUND_TOLERANCE = 1e-9  # in units of scale: a point so near to a bound lies on it
_CLOSE = 1e-3  # in units of scale: a point so near to a bound would reach it
_NO_FURTHER_POINT = "no further point of the branch can be computed"
RANGE_ENDS = "the range ends"
SOME_STABLE, ALL_STABLE = "some-stable", "all-stable"  # from here on some, or all, members of a family are stable


class StabilityLevel(IntEnum):
    """Stability of a point. PARTLY_STABLE: only some members of a family. NEUTRAL: a disturbance neither grows nor decays."""

    NEUTRAL = -1
    UNSTABLE = 0
    PARTLY_STABLE = 1
    STABLE = 2


def stability_levels(exponents: np.ndarray) -> np.ndarray:
    """Return ``StabilityLevel`` (N,) from exponents (n, N), which are nan where there are fewer."""
    growth, fastest = np.nanmax(exponents.real, axis=0), np.nanmax(np.abs(exponents), axis=0)
    decays = np.where(growth < -NEUTRAL * fastest, StabilityLevel.STABLE, StabilityLevel.NEUTRAL)
    return np.where(growth > NEUTRAL * fastest, StabilityLevel.UNSTABLE, decays)


def stability_from_fraction(share: float) -> StabilityLevel:
    """Return the stability of a family from the fraction of its members that are stable."""
    return StabilityLevel.STABLE if share >= 1 else StabilityLevel.PARTLY_STABLE if share > 0 else StabilityLevel.UNSTABLE


@dataclass(frozen=True)
class EquilibriumBranch:
    """Equilibria in their order along a branch, as stored between runs.

    unknowns (n+1, N): states, angles not wrapped, and parameter. exponents (n, N): per unit of time, nan where a
    family has fewer. kinds (N): "" or the kind of a special point. ends: why it ends, at first and last. dimension: of
    the family that it represents, 0 for isolated states. stable_share (N): of the family's members, empty where
    there is no family. kind: name and type of the states. offshoots: point and direction (n+1,) of the
    branches that cross it. second: value of the second parameter.
    """

    unknowns: np.ndarray
    exponents: np.ndarray
    kinds: tuple[str, ...]
    ends: tuple[str, str]
    kind: Kind = field(default_factory=Kind)
    dimension: int = 0
    stable_share: tuple[float, ...] = ()
    offshoots: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    second: float | None = None

    @property
    def parameter_values(self) -> np.ndarray:
        """Values of the parameter (N,)."""
        return np.asarray(self.unknowns[-1])

    @property
    def is_closed(self) -> bool:
        """True if it returns to its first point, which is then its last, too."""
        return self.ends[0] == self.ends[1] == CURVE_IS_CLOSED

    @cached_property
    def stability(self) -> np.ndarray:
        """``StabilityLevel`` of each point (N,); at a special point the higher one of its neighbours."""
        shares, special = self.stable_share, self._special
        levels = np.array([stability_from_fraction(s) for s in shares]) if shares else stability_levels(self.exponents)
        known_levels = np.where(special, StabilityLevel.NEUTRAL, levels)
        beside = np.maximum(
            np.append(StabilityLevel.NEUTRAL, known_levels[:-1]), np.append(known_levels[1:], StabilityLevel.NEUTRAL)
        )
        return np.asarray(np.where(special, beside, levels))

    @property
    def stable(self) -> np.ndarray:
        """True where all disturbances of all members decay (N,)."""
        return np.asarray(self.stability == StabilityLevel.STABLE)

    @property
    def unstable(self) -> np.ndarray:
        """Number of growing disturbances of each point (N,)."""
        # Against the fastest of the branch: at a fold, equations of one state have no other exponent than the one that is zero.
        fastest = np.nanmax(np.abs(self.exponents), initial=0.0)
        return np.asarray((self.exponents.real > NEUTRAL * fastest).sum(axis=0))

    @property
    def _special(self) -> np.ndarray:
        return np.array([bool(kind) for kind in self.kinds])

    def frequency(self, i: int) -> float | None:
        """Return the frequency of the oscillation that begins at a special point, None where none does.

        It is that of the pair nearest to the imaginary axis, of those that oscillate.
        """
        exponents, kind = self.exponents[np.isfinite(self.exponents[:, i]), i], self.kinds[i]
        if kind != HOPF and (kind not in (SOME_STABLE, ALL_STABLE) or not exponents[exponents.real.argmax()].imag):
            return None
        pairs = exponents[exponents.imag > 0]
        return float(pairs[np.abs(pairs.real).argmin()].imag)

    def intervals(self, level: StabilityLevel) -> list[tuple[int, int]]:
        """Return first and last point of each stretch of a level, up to the special or neutral points where it ends."""
        special = self._special
        open_ = special | (self.stability == StabilityLevel.NEUTRAL)  # does not determine the stretch that it lies in, or ends
        sure = np.flatnonzero(~open_).tolist()
        groups: list[tuple[int, int]] = []
        for k, i in enumerate(sure):
            if self.stability[i] != level:
                continue
            before, after = (sure[k - 1] if k else -1), (sure[k + 1] if k + 1 < len(sure) else len(open_))
            if groups and k and self.stability[before] == level:
                groups[-1] = (groups[-1][0], self._stretch_end(i, after, 1))
            else:
                groups.append((self._stretch_end(i, before, -1), self._stretch_end(i, after, 1)))
        return groups

    def _stretch_end(self, i: int, limit: int, way: int) -> int:
        """Return the end of a stretch that contains point i on the way to the limit: the special point, if there is one."""
        between = range(i + way, limit, way)
        return next((j for j in between if self.kinds[j]), between[0] if between else i)

    @property
    def unlocated_changes(self) -> list[tuple[int, int]]:
        """Neighbouring points between which stability changes without a located special point."""
        special = np.array([bool(kind) and kind != UNRESOLVED_POINT for kind in self.kinds])
        sure = np.flatnonzero(~self._special & (self.stability != StabilityLevel.NEUTRAL))
        pairs = zip(sure[:-1].tolist(), sure[1:].tolist(), strict=True)
        return [(i, j) for i, j in pairs if self.stability[i] != self.stability[j] and not special[i:j].any()]

    def length(self, scale: np.ndarray) -> float:
        """Return the arc length through all points, in units of scale (n+1,)."""
        return float(
            (np.abs(np.diff(self.unknowns / scale[:, None], axis=1)) ** 2).sum(axis=0) ** 0.5
            @ np.ones(self.unknowns.shape[1] - 1)
        )

    def crossings(self, value: float) -> Iterator[np.ndarray]:
        """Return points (n+1,) where the branch passes a value, interpolated to first order."""
        return (np.append(x, value) for x in values_at_passages(self.parameter_values, value, self.unknowns[:-1])[1].T)


def branch_through(steady_states: SteadyStates, start: CurvePoint) -> EquilibriumBranch:
    """Follow the branch of isolated states through a point both ways, with its name, and the starts of those that cross it."""
    equilibria = steady_states.equilibria
    branch = equilibria.follow_branch(start)
    points = [p for p in branch.points if not _turns_at_a_branch_point(branch, p)]
    offshoots = [offshoot for p in points if p.kind == BRANCH_POINT for offshoot in _offshoots(equilibria, p)]
    whole_branch = EquilibriumBranch(
        unknowns=np.array([p.unknowns for p in points]).T, exponents=np.array([p.eigenvalues for p in points]).T,
        kinds=tuple(p.kind for p in points), offshoots=tuple(offshoots),
        ends=describe_ends(steady_states.equilibria, branch, steady_states.path, steady_states.end_reason),
    )  # fmt: skip
    return replace(whole_branch, kind=_kind(steady_states, whole_branch))


def _turns_at_a_branch_point(branch: Branch, point: Equilibrium) -> bool:
    """True if a fold is one only because the branch begins there on another one, symmetrically: a pitchfork."""
    scale = branch.equations.scale
    return point.kind == FOLD and any(
        p.kind == BRANCH_POINT and np.abs((p.unknowns - point.unknowns) / scale).max() < _PITCHFORK for p in branch.special
    )


def _offshoots(equilibria: EquilibriumContinuation, at: Equilibrium) -> list[tuple[np.ndarray, np.ndarray]]:
    try:
        return [(p.unknowns, p.tangent) for p in equilibria.switch_branch(at)]
    except RunError:
        return []


def _kind(steady_states: SteadyStates, branch: EquilibriumBranch) -> Kind:
    """Return name, type and split as far as they are the same along the branch, from some points that are not special."""
    regular = np.flatnonzero([not kind for kind in branch.kinds])
    chosen = regular[np.linspace(0, len(regular) - 1, min(_SAMPLES, len(regular))).astype(int)]
    kinds_at_points = {steady_states.kind(branch.unknowns[:, i]) for i in chosen}
    if len(kinds_at_points) == 1:
        return kinds_at_points.pop()
    names, splits = {(k.name, k.type) for k in kinds_at_points}, {k.split for k in kinds_at_points}
    name, type_ = names.pop() if len(names) == 1 else (None, None)
    return Kind(
        name, type_, splits.pop() if len(splits) == 1 else None, max((k.multiplicity for k in kinds_at_points), default=1)
    )


def describe_ends(
    equilibria: EquilibriumContinuation, branch: Branch, path: str, limit_reason: Callable[[np.ndarray], str]
) -> tuple[str, str]:
    """Return why a branch ends, at first and last. path: of the parameter. limit_reason: of a state (n+1,) at its limits."""
    if branch.is_closed:
        return branch.ends
    # A branch with fewer points than the maximum ends where not even the shortest step leads to another one.
    fewer = len(branch.points) < equilibria.steps.points
    first, last = (
        describe_end(
            equilibria, f"{path} = {p.parameter:.5g}", limit_reason, p.unknowns, _NO_FURTHER_POINT if fewer else reason
        )
        for p, reason in zip((branch.points[0], branch.points[-1]), branch.ends, strict=True)
    )
    return first, last


def describe_end(
    equilibria: EquilibriumContinuation, at: str, limit_reason: Callable[[np.ndarray], str], unknowns: np.ndarray, reason: str
) -> str:
    """Return why a branch that is not closed ends at the point of these unknowns (n+1,).

    at: the place as text. limit_reason: of a state at its limits. reason: of the continuation, for all other cases.
    """
    scale = equilibria.equations.scale
    off = min(abs(float(unknowns[-1]) - limit) for limit in equilibria.bounds) / scale[-1]
    if any(
        min(abs(unknowns[i] - limit) for limit in pair) <= BOUND_TOLERANCE * scale[i] for i, pair in equilibria.limits.items()
    ):
        return limit_reason(unknowns)
    if off <= BOUND_TOLERANCE:
        return RANGE_ENDS
    if off <= _CLOSE:
        return f"it is followed to {at}: nearer to the end of the range the equations are singular"
    return f"at {at}: {reason}"


def points_with_value(steady_states: SteadyStates, branch: EquilibriumBranch, value: float) -> list[CurvePoint]:
    """Return the points of a branch of isolated states at a value."""
    points: list[CurvePoint] = []
    for guess in branch.crossings(value):
        try:
            point = steady_states.equilibria.start(guess[:-1], value)
        except RunError:
            continue
        if not any(steady_states.is_same(point.unknowns, p.unknowns) for p in points):
            points.append(point)
    return points


def lies_on(steady_states: SteadyStates, branches: Sequence[EquilibriumBranch], unknowns: np.ndarray) -> bool:
    """True if a point lies on one of the branches, up to an exchange of equal bodies."""
    value = float(unknowns[-1])
    return any(
        steady_states.is_same(unknowns, p.unknowns)
        for b in branches
        if not b.dimension
        for p in points_with_value(steady_states, b, value)
    )


def is_duplicate(steady_states: SteadyStates, branches: Sequence[EquilibriumBranch], candidate: EquilibriumBranch) -> bool:
    """True if a branch is only a point, or coincides with a known one at points far from its special ones."""
    regular = np.flatnonzero([not kind for kind in candidate.kinds])
    if not len(regular) or candidate.length(steady_states.equilibria.equations.scale) < _LENGTH:
        return True
    chosen = regular[(np.array(_COMPARISON_SHARES) * (len(regular) - 1)).astype(int)]
    return all(lies_on(steady_states, branches, candidate.unknowns[:, i]) for i in chosen)
