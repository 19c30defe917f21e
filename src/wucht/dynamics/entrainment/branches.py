"""Branches of steady phases over a parameter, around their folds, and where their stability ends.

001 (21) and, for the lock limits of exciters, what follows from (33)-(34). The edges are the folds and Hopf points of the
branches, see ``numerics.continuation.equilibria``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.dynamics.entrainment.averaged_equations import STABLE, AveragedEquations
from wucht.dynamics.entrainment.entrainment_case import stretches
from wucht.dynamics.work import Work
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import FOLD, HOPF, Equilibria
from wucht.numerics.continuation.fold_curves import direction

STEP = 0.05  # of the arc length: phases in rad, speeds and the parameter by their sizes
_STEPS = Steps(first=STEP, most=2 * STEP, points=4000)
_ANYWHERE = 64  # starts from which it is looked where an equilibrium may be
RANGE = "range"


@dataclass(frozen=True)
class Branch:
    """Equilibria along their arc length.

    values: (N,) of the parameter. states: (n, N). stable: (N,), at a special point as beside it on the stable side. kinds (N):
    "" or the kind of a special point. leaving (N): the complex exponent that grows fastest. closed: it returns.
    """

    values: np.ndarray
    states: np.ndarray
    stable: np.ndarray
    kinds: tuple[str, ...]
    leaving: np.ndarray
    closed: bool


@dataclass(frozen=True)
class Edge:
    """Where stability ends: the value of the parameter, and how: ``fold``, ``hopf``, ``branch-point``, or ``range`` where the
    range ends.
    """

    value: float
    kind: str


@dataclass(frozen=True)
class StableRange:
    """A stretch of a branch that is stable, from ``low`` to ``high``; points: indices into the branch."""

    branch: int
    low: Edge
    high: Edge
    points: np.ndarray


class Continuation:
    """Equilibria of averaged equations, followed with the parameter."""

    def __init__(self, equations: AveragedEquations) -> None:
        self.equations = equations
        turning = dict.fromkeys(np.flatnonzero(~equations.phases).tolist(), (0.0, math.inf))
        self.problem = Equilibria(equations.equations, equations.limits, _STEPS, turning)

    def branches(self, values: Sequence[float], more: np.ndarray | None, work: Work) -> tuple[Branch, ...]:
        """All that pass one of the values, found from many starts there and from states ``more`` (n, N) at the first."""
        branches: list[Branch] = []

        def follow(state: np.ndarray, value: float, share: float) -> None:
            work.report(share, "averaged equations")
            if not any(self.passes(b, state, value) for b in branches):
                branches.append(work.unit(f"branch {len(branches)}", partial(self.branch, state, value)))

        for i, value in enumerate(values):
            for state in work.unit(f"equilibria at {value!r}", partial(self.equations.equilibria, value, None if i else more)):
                follow(state, value, i / len(values))
        for state, value in () if branches else work.unit("equilibria anywhere", partial(self._anywhere, values[0])):
            follow(state, value, 1.0)
        work.report(1.0, "averaged equations")
        return tuple(branches)

    def branch(self, state: np.ndarray, value: float) -> Branch:
        """The branch through an equilibrium, both ways, up to the limits or until it returns."""
        at, e = np.append(state, value), self.problem.equations
        whole = self.problem.branch(self.problem.curve.start(at, direction(e.values(at)[1], e.scale)))
        exponents = np.array([p.eigenvalues for p in whole.points])
        decays = exponents.real.max(axis=1) < -STABLE * np.abs(exponents).max(axis=1)
        special = np.array([bool(p.kind) for p in whole.points])
        beside = np.append(False, decays[:-1] & ~special[:-1]) | np.append(decays[1:] & ~special[1:], False)
        leaving = np.take_along_axis(exponents, exponents.real.argmax(axis=1)[:, None], axis=1)[:, 0]
        kinds, stable = tuple(p.kind for p in whole.points), np.where(special, beside, decays)
        return Branch(whole.u[-1], whole.u[:-1], stable, kinds, leaving, whole.closed)

    def passes(self, branch: Branch, state: np.ndarray, value: float) -> bool:
        """Whether an equilibrium lies on a branch."""
        v, states = branch.values, branch.states.T
        k = np.flatnonzero((np.minimum(v[1:], v[:-1]) <= value) & (value <= np.maximum(v[1:], v[:-1])))
        width = v[k + 1] - v[k]
        share = np.divide(value - v[k], width, out=np.zeros(len(k)), where=width != 0)
        between = states[k] + share[:, None] * (states[k + 1] - states[k])
        return bool((self.equations.distance(between, state) < STEP).any())

    def stable_ranges(self, branches: Sequence[Branch]) -> tuple[StableRange, ...]:
        """All stable stretches."""
        ranges = []
        for index, b in enumerate(branches):
            regular = np.flatnonzero([not kind for kind in b.kinds])
            stable = b.stable[regular]
            if b.closed and not stable.all():  # begin where it is not stable, so that no stretch is cut
                first = int(np.flatnonzero(~stable)[0])
                regular = np.concatenate([regular[first:-1], regular[: first + 1]])  # its last point is its first
                stable = b.stable[regular]
            for begin, end in stretches(stable):
                before = regular[begin - 1] if begin else None
                after = regular[end + 1] if end + 1 < len(regular) else None
                ends = _edge(b, regular[begin], before), _edge(b, regular[end], after)
                low, high = sorted(ends, key=lambda e: e.value)
                ranges.append(StableRange(index, low, high, regular[begin : end + 1]))
        return tuple(ranges)

    def _anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Equilibria at other values than those asked for: one phase is held, and the value that it needs is found."""
        e, (low, high) = self.equations, self.equations.limits
        states, values = e.with_a_phase_held(e.starts()[:, :_ANYWHERE], value)
        return [(e.wrapped(x), float(v)) for x, v in zip(states.T, values, strict=True) if low <= v <= high and e.turning(x)]


def _edge(b: Branch, inside: int, outside: int | None) -> Edge:
    """Where stability is lost on the way from a stable point to its neighbour: at the special point between them."""
    if outside is None:
        return Edge(float(b.values[inside]), RANGE)
    step = 1 if (outside - inside) % len(b.values) <= len(b.values) // 2 else -1
    beside = (inside + step) % len(b.values)
    if kind := b.kinds[beside]:
        return Edge(float(b.values[beside]), kind)
    # No special point was located between them.
    return Edge(float(b.values[inside]), HOPF if b.leaving[outside].imag else FOLD)
