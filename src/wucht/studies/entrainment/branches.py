"""Branches of steady phases over a parameter, around their folds, and where their stability ends.

001 (21) and, for the lock limits of exciters, what follows from (33)-(34). They are followed by their arc length.
H. B. Keller, "Numerical Solution of Bifurcation and Nonlinear Eigenvalue Problems", in: Applications of Bifurcation Theory,
Academic Press 1977, 359-384.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.studies.entrainment.averaged_equations import AveragedEquations
from wucht.studies.entrainment.swept_parameter import stretches
from wucht.studies.work import Work

STEP = 0.05  # of the arc length: phases in rad, speeds and the parameter by their sizes
_LONGEST, _SHORTEST, _MOST = 0.1, 1e-7, 4000
_BISECTIONS = 60
_ANYWHERE = 64  # starts from which it is looked where an equilibrium may be


@dataclass(frozen=True)
class Branch:
    """Equilibria along their arc length. values: (N,) of the parameter. states: (n, N). stable: (N,). closed: it returns."""

    values: np.ndarray
    states: np.ndarray
    stable: np.ndarray
    closed: bool


@dataclass(frozen=True)
class Edge:
    """Where stability ends: the value of the parameter, and how: ``fold``, ``hopf``, ``range`` where the range ends."""

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
    """Equilibria of averaged equations, followed with the parameter. Points (n + 1,) are state and value by their sizes."""

    def __init__(self, equations: AveragedEquations) -> None:
        self.equations, self.sizes = equations, np.append(equations.sizes, equations.unit)
        self._axes = np.eye(equations.n + 1)  # the parameter's is the last one

    def _dimensional(self, at: np.ndarray) -> tuple[np.ndarray, float]:
        return at[:-1] * self.sizes[:-1], float(at[-1] * self.sizes[-1])

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
        start = np.append(state, value) / self.sizes
        away = self._tangent(start, self._axes[-1])
        points, closed = self._followed(start, away)
        if not closed:
            points = [*reversed(self._followed(start, -away)[0][1:]), *points]
        states, values = zip(*map(self._dimensional, points), strict=True)
        stable = [self.equations.stable(*at) for at in zip(states, values, strict=True)]
        return Branch(np.array(values), np.array(states).T, np.array(stable), closed)

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
            n = len(b.values)
            order = np.arange(n)
            if b.closed and not b.stable.all():  # begin where it is not stable, so that no stretch is cut
                first = int(np.flatnonzero(~b.stable)[0])
                order = np.concatenate([np.arange(first, n - 1), np.arange(first + 1)])
            for begin, end in stretches(b.stable[order]):
                before, after = order[begin - 1] if begin else None, order[end + 1] if end + 1 < n else None
                ends = self._edge(b, order[begin], before), self._edge(b, order[end], after)
                low, high = sorted(ends, key=lambda e: e.value)
                ranges.append(StableRange(index, low, high, order[begin : end + 1]))
        return tuple(ranges)

    def _linearised(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rates (n,) and their derivatives (n, n + 1) by the states and the value, all by their sizes."""
        (state, value), unit = self._dimensional(at), self.equations.unit
        h = 1e-6 * unit
        (rate, jacobian), (up, _), (down, _) = (self.equations.rates(state[:, None], v) for v in (value, value + h, value - h))
        return rate[:, 0], np.hstack([jacobian[0], (up - down) / (2 * h) * unit])

    @np.errstate(all="ignore")  # where Newton's method goes astray there is no point
    def _corrected(self, guess: np.ndarray, direction: np.ndarray, far: bool = False) -> np.ndarray | None:
        """The equilibrium in the plane through a guess normal to a direction.

        far: it may be far away; else None is returned where Newton's method goes there.
        """
        at, size = guess, math.inf
        for _ in range(60 if far else 12):
            rate, jacobian = self._linearised(at)
            try:
                step = np.linalg.solve(np.vstack([jacobian, direction]), -np.append(rate, direction @ (at - guess)))
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if not size <= (sys.float_info.max if far else 1.0):
                return None
            at = at + step * min(1.0, 0.5 / size if far and size > 0 else 1.0)
            if size < 1e-11:
                break
        return at if size < 1e-8 else None

    def _tangent(self, at: np.ndarray, before: np.ndarray) -> np.ndarray:
        """The unit tangent (n + 1,) that continues in the direction ``before``."""
        matrix = np.vstack([self._linearised(at)[1], before])
        along = np.linalg.lstsq(matrix, self._axes[-1], rcond=None)[0]
        return np.asarray(along / np.linalg.norm(along))

    def _followed(self, start: np.ndarray, tangent: np.ndarray) -> tuple[list[np.ndarray], bool]:
        """The points from a start on, and whether they return to it."""
        points, step, at = [start], STEP, start
        low, high = self.equations.limits
        while len(points) < _MOST:
            guess = at + step * tangent
            point = self._corrected(guess, tangent)
            along = tangent if point is None else self._tangent(point, tangent)
            if point is None or along @ tangent < 0.9 or np.abs(point - guess).max() > step:
                step /= 2
                if step < _SHORTEST:
                    break
                continue
            if not low <= point[-1] * self.equations.unit <= high:
                return [*points, self._at_limit(at, point)], False
            if not self.equations.turning(point[:-1]):
                break
            if len(points) > 3 and self._returned(start, at, point):
                return [*points, start + self._turns(point, start)], True
            points.append(point)
            at, tangent, step = point, along, min(1.3 * step, _LONGEST)
        return points, False

    def _turns(self, point: np.ndarray, start: np.ndarray) -> np.ndarray:
        """The whole turns of phases (n + 1,) from a start to a point."""
        return 2 * math.pi * np.where(np.append(self.equations.phases, False), np.round((point - start) / (2 * math.pi)), 0.0)

    def _returned(self, start: np.ndarray, before: np.ndarray, after: np.ndarray) -> bool:
        """Whether the start lies on the way from one point to the next."""
        target, way = start + self._turns(after, start), after - before
        share = float((target - before) @ way) / float(way @ way)
        return 0 <= share <= 1 and float(np.linalg.norm(before + share * way - target)) < 0.1 * float(np.linalg.norm(way))

    def _at_limit(self, inside: np.ndarray, beyond: np.ndarray) -> np.ndarray:
        """The point on the limit that was passed."""
        low, high = self.equations.limits
        limit = (low if beyond[-1] * self.equations.unit < low else high) / self.equations.unit
        guess = inside + (limit - inside[-1]) / (beyond[-1] - inside[-1]) * (beyond - inside)
        return guess if (exact := self._corrected(guess, self._axes[-1])) is None else exact

    def _anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Equilibria at other values than those asked for: one phase is held, and the value that it needs is found."""
        held, (low, high) = self._axes[int(self.equations.phases.argmax())], self.equations.limits
        starts = (np.append(start, value) / self.sizes for start in self.equations.starts().T[:_ANYWHERE])
        found = (self._corrected(start, held, far=True) for start in starts)
        equilibria = [self._dimensional(at) for at in found if at is not None]
        return [(self.equations.wrapped(x), v) for x, v in equilibria if low <= v <= high and self.equations.turning(x)]

    def _edge(self, b: Branch, inside: int, outside: int | None) -> Edge:
        """Where stability is lost between two neighbouring points, by bisection of the arc."""
        if outside is None:
            return Edge(float(b.values[inside]), "range")
        good, bad = (np.append(b.states[:, k], b.values[k]) / self.sizes for k in (inside, outside))
        bad = bad + self._turns(good, bad)
        way = (bad - good) / np.linalg.norm(bad - good)
        for _ in range(_BISECTIONS):
            if np.abs(bad - good).max() < 1e-13:
                break
            middle = self._corrected((good + bad) / 2, way)
            if middle is None:
                break
            good, bad = (middle, bad) if self.equations.stable(*self._dimensional(middle)) else (good, middle)
        state, value = self._dimensional(good)
        values = self.equations.eigenvalues(state, value)
        leaving = values[values.real.argmax()]
        return Edge(value, "hopf" if abs(leaving.imag) > 1e-3 * np.abs(values).max() else "fold")
