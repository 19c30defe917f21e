"""Branches of steady states: each that is found is followed both ways, and from branch points the other branches too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.analysis.configurations.averaged_stability import NEUTRAL
from wucht.errors import RunError
from wucht.numerics.continuation.equilibria import BRANCH_POINT, FOLD, Branch, Equilibria, Equilibrium
from wucht.numerics.continuation.problem import CurvePoint
from wucht.studies.speed_curve.steady_states import Kind, SteadyStates

_PITCHFORK = 1e-4  # in units of scale: between a branch point and the fold of the branch that begins there

_SAMPLES = 9  # points of a branch that are named
_COMPARED = (0.12, 0.3, 0.7, 0.88)  # of a branch: where it is compared, not in the middle, where a pitchfork has its vertex
RANGE_ENDS = "the range ends"


@dataclass(frozen=True)
class FollowedBranch:
    """Equilibria in their order along a branch, as they are kept between runs.

    u (n+1, N): states, angles as they have turned, and parameter. exponents (n, N): per unit of time, not a number where a
    family has less of them. kinds (N): "" or the kind of a special point. ends: why it ends, at first and last. dimension: of
    the family for one of whose members it stands, 0 for isolated states. stable_share (N): of the family's members, empty where
    there is no family. kind: what the states are called. offshoots: point and direction (n+1,) of other
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
        """Of the parameter (N,)."""
        return np.asarray(self.u[-1])

    @property
    def stable(self) -> np.ndarray:
        """Whether all disturbances decay (N,); at a special point, where one does not, as beside it on the stable side."""
        growth = np.nanmax(self.exponents.real, axis=0)
        decays = growth < -NEUTRAL * np.nanmax(np.abs(self.exponents), axis=0)
        beside = np.concatenate([[False], decays[:-1]]) | np.concatenate([decays[1:], [False]])
        special = np.array([bool(kind) for kind in self.kinds])
        return np.asarray(np.where(special, beside, decays))

    @property
    def stable_intervals(self) -> list[tuple[int, int]]:
        """First and last point of each stretch that is stable, up to the special points where it ends."""
        special, last = [bool(kind) for kind in self.kinds], len(self.kinds) - 1
        regular, stable = [i for i, s in enumerate(special) if not s], self.stable
        groups: list[tuple[int, int]] = []
        for k, i in enumerate(regular):
            if not stable[i]:
                continue
            end = i + 1 if i < last and special[i + 1] else i
            if groups and k and stable[regular[k - 1]]:
                groups[-1] = (groups[-1][0], end)
            else:
                groups.append((i - 1 if i and special[i - 1] else i, end))
        return groups

    def crossings(self, value: float) -> Iterator[np.ndarray]:
        """Points (n+1,) between those of the branch where it passes a value, to first order."""
        v = self.values
        for i in np.flatnonzero((v[:-1] - value) * (v[1:] - value) <= 0).tolist():
            width = v[i + 1] - v[i]
            share = (value - v[i]) / width if width else 0.0
            yield np.append((self.u[:, i] + share * (self.u[:, i + 1] - self.u[:, i]))[:-1], value)


def followed(states: SteadyStates, start: CurvePoint) -> FollowedBranch:
    """The whole branch of isolated states through a point, with its name, and the beginnings of those that cross it."""
    equilibria = states.equilibria
    branch = equilibria.branch(start)
    points = [p for p in branch.points if not _turns_at_a_branch_point(branch, p)]
    offshoots = [other for p in points if p.kind == BRANCH_POINT for other in _offshoots(equilibria, p)]
    made = FollowedBranch(
        u=np.array([p.u for p in points]).T, exponents=np.array([p.eigenvalues for p in points]).T,
        kinds=tuple(p.kind for p in points), offshoots=tuple(offshoots),
        ends=_ends(states, branch),
    )  # fmt: skip
    return replace(made, kind=_kind(states, made))


def _turns_at_a_branch_point(branch: Branch, point: Equilibrium) -> bool:
    """Whether it is a fold only because the branch begins there on another one, symmetrically: a pitchfork."""
    scale = branch.equations.scale
    return point.kind == FOLD and any(
        p.kind == BRANCH_POINT and np.abs((p.u - point.u) / scale).max() < _PITCHFORK for p in branch.special
    )


def _offshoots(equilibria: Equilibria, at: Equilibrium) -> list[tuple[np.ndarray, np.ndarray]]:
    try:
        return [(p.u, p.tangent) for p in equilibria.switched(at)]
    except RunError:
        return []


def _kind(states: SteadyStates, made: FollowedBranch) -> Kind:
    """Name, type and split as far as they are the same all along, from some points that are not special."""
    regular = np.flatnonzero([not kind for kind in made.kinds])
    chosen = regular[np.linspace(0, len(regular) - 1, min(_SAMPLES, len(regular))).astype(int)]
    seen = {states.kind(made.u[:, i]) for i in chosen}
    if len(seen) == 1:
        return seen.pop()
    names, splits = {(k.name, k.type) for k in seen}, {k.split for k in seen}
    name, type_ = names.pop() if len(names) == 1 else (None, None)
    return Kind(name, type_, splits.pop() if len(splits) == 1 else None, max((k.multiplicity for k in seen), default=1))


def _ends(states: SteadyStates, branch: Branch) -> tuple[str, str]:
    if branch.closed:
        return branch.ends
    return _end(states, branch.ends[0], branch.u[:, 0]), _end(states, branch.ends[1], branch.u[:, -1])


def _end(states: SteadyStates, sentence: str, u: np.ndarray) -> str:
    """Why a branch ends, in the study's words."""
    if not sentence.startswith("it leaves the range"):
        return sentence
    if sentence.endswith("singular"):
        return f"{sentence.split(', where ')[1]} at the end of the range"
    return RANGE_ENDS if u[-1] in states.bounds else states.end(u)


def exact(states: SteadyStates, branch: FollowedBranch, value: float) -> list[CurvePoint]:
    """The points of a branch of isolated states at a value."""
    points: list[CurvePoint] = []
    for guess in branch.crossings(value):
        try:
            found = states.equilibria.start(guess[:-1], value)
        except RunError:
            continue
        if not any(states.same(found.u, p.u) for p in points):
            points.append(found)
    return points


def known(states: SteadyStates, branches: Sequence[FollowedBranch], u: np.ndarray) -> bool:
    """Whether a point lies on one of the branches, equal bodies being exchanged."""
    value = float(u[-1])
    return any(states.same(u, p.u) for b in branches if not b.dimension for p in exact(states, b, value))


def repeats(states: SteadyStates, branches: Sequence[FollowedBranch], other: FollowedBranch) -> bool:
    """Whether a branch is one of the known ones: points far from its special ones lie on them."""
    regular = np.flatnonzero([not kind for kind in other.kinds])
    chosen = regular[(np.array(_COMPARED) * (len(regular) - 1)).astype(int)]
    return all(known(states, branches, other.u[:, i]) for i in chosen)
