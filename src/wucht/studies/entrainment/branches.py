"""Branches of constant phases over a parameter, around their folds, and where their stability ends.

001 (21) and, for the lock limits of exciters, what follows from (33)-(34). They are followed by their arc length.
H. B. Keller, "Numerical Solution of Bifurcation and Nonlinear Eigenvalue Problems", in: Applications of Bifurcation Theory,
Academic Press 1977, 359-384.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.studies.entrainment.averaged_equations import AveragedEquations
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
    """Where stability ends: the parameter, how (fold, hopf), and the state (n,) there; kind ``range`` where the range ends."""

    value: float
    kind: str
    state: np.ndarray


@dataclass(frozen=True)
class StableRange:
    """A stretch of a branch that is stable, from ``low`` to ``high``; points: indices into the branch."""

    branch: int
    low: Edge
    high: Edge
    points: np.ndarray


@dataclass(frozen=True)
class Continuation:
    """Equilibria of averaged equations, followed with the parameter. Points (n + 1,) are state and value by their sizes."""

    equations: AveragedEquations

    def branches(self, values: Sequence[float], more: np.ndarray | None, work: Work) -> tuple[Branch, ...]:
        """All that pass one of the values, found from many starts there and from states ``more`` (n, N) at the first."""
        branches: list[Branch] = []

        def follow(state: np.ndarray, value: float, share: float) -> None:
            work.report(share, "averaged equations")
            if not any(self.passes(b, state, value) for b in branches):
                branches.append(work.unit(f"branch {len(branches)}", partial(self.branch, state, value)))

        for i, value in enumerate(values):
            search = partial(self.equations.equilibria, value, None if i else more)
            for state in work.unit(f"equilibria at {value!r}", search):
                follow(state, value, i / len(values))
        if not branches:
            for state, other in work.unit("equilibria anywhere", partial(self._anywhere, values[0])):
                follow(state, other, 1.0)
        work.report(1.0, "averaged equations")
        return tuple(branches)

    def branch(self, state: np.ndarray, value: float) -> Branch:
        """The branch through an equilibrium, both ways, up to the limits or until it returns."""
        start = np.append(state / self.equations.sizes, value / self.equations.unit)
        away = self._tangent(start, self._parameter_axis)
        points, closed = self._followed(start, away)
        if not closed:
            backward, _ = self._followed(start, -away)
            points = [*reversed(backward[1:]), *points]
        all_ = np.array(points).T
        states, values = all_[:-1] * self.equations.sizes[:, None], all_[-1] * self.equations.unit
        stable = np.array([self.equations.stable(states[:, k], float(values[k])) for k in range(len(values))])
        return Branch(values, states, stable, closed)

    def passes(self, branch: Branch, state: np.ndarray, value: float) -> bool:
        """Whether an equilibrium lies on a branch."""
        v = branch.values
        for k in np.flatnonzero((np.minimum(v[1:], v[:-1]) <= value) & (value <= np.maximum(v[1:], v[:-1]))):
            share = (value - v[k]) / (v[k + 1] - v[k]) if v[k + 1] != v[k] else 0.0
            between = branch.states[:, k] + share * (branch.states[:, k + 1] - branch.states[:, k])
            if self.equations.distance(between, state) < STEP:
                return True
        return False

    def stable_ranges(self, branches: Sequence[Branch]) -> tuple[StableRange, ...]:
        """All stable stretches."""
        return tuple(r for k, b in enumerate(branches) for r in self._stable_ranges_of(k, b))

    @property
    def _parameter_axis(self) -> np.ndarray:
        return np.append(np.zeros(self.equations.n), 1.0)

    def _dimensional(self, at: np.ndarray) -> tuple[np.ndarray, float]:
        return at[:-1] * self.equations.sizes, float(at[-1] * self.equations.unit)

    def _bordered(self, at: np.ndarray, last: np.ndarray) -> np.ndarray:
        """The Jacobian (n + 1, n + 1) by the states and the value in their sizes, below it a direction."""
        e, (state, value) = self.equations, self._dimensional(at)
        h = 1e-6 * e.unit
        up, down = (e.rates(state[:, None], value + s * h)[0][:, 0] for s in (1, -1))
        by_value = (up - down) / (2 * h) * e.unit
        return np.vstack([np.column_stack([e.rates(state[:, None], value)[1][0], by_value]), last])

    @np.errstate(all="ignore")  # where Newton's method goes astray there is no point
    def _corrected(self, guess: np.ndarray, direction: np.ndarray, far: bool = False) -> np.ndarray | None:
        """The equilibrium in the plane through a guess normal to a direction.

        far: it may be far away; else None is returned where Newton's method goes there.
        """
        at = guess.copy()
        for _ in range(60 if far else 12):
            state, value = self._dimensional(at)
            rate = self.equations.rates(state[:, None], value)[0][:, 0]
            left = np.append(rate, direction @ (at - guess))
            matrix = self._bordered(at, direction)
            if not (np.isfinite(left).all() and np.isfinite(matrix).all()):
                return None
            try:
                step = np.linalg.solve(matrix, -left)
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if size > 1.0 and not far:
                return None
            at = at + step * min(1.0, 0.5 / size if far and size > 0 else 1.0)
            if size < 1e-11:
                return at
        return at if size < 1e-8 else None

    def _tangent(self, at: np.ndarray, before: np.ndarray) -> np.ndarray:
        """The unit tangent (n + 1,) that goes on in the direction ``before``."""
        matrix = self._bordered(at, before)
        along = np.linalg.lstsq(matrix, self._parameter_axis, rcond=None)[0]
        return np.asarray(along / np.linalg.norm(along))

    def _followed(self, start: np.ndarray, tangent: np.ndarray) -> tuple[list[np.ndarray], bool]:
        """The points from a start on, and whether they return to it."""
        points, step, at = [start], STEP, start
        low, high = self.equations.limits
        while len(points) < _MOST:
            guess = at + step * tangent
            point = self._corrected(guess, tangent)
            along = None if point is None else self._tangent(point, tangent)
            if point is None or along is None or along @ tangent < 0.9 or np.abs(point - guess).max() > step:
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
        phases = np.append(self.equations.phases, False)
        return np.where(phases, 2 * math.pi * np.round((point - start) / (2 * math.pi)), 0.0)

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
        exact = self._corrected(guess, self._parameter_axis)
        return guess if exact is None else exact

    def _anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Equilibria at other values than those asked for: some phases are held, and the value that they need is found."""
        held = np.zeros(self.equations.n + 1)
        held[int(np.flatnonzero(self.equations.phases)[0])] = 1.0
        low, high = self.equations.limits
        equilibria = []
        for start in self.equations.starts().T[:_ANYWHERE]:
            at = self._corrected(np.append(start / self.equations.sizes, value / self.equations.unit), held, far=True)
            if at is None:
                continue
            state, needed = self._dimensional(at)
            if low <= needed <= high and self.equations.turning(state):
                equilibria.append((self.equations.wrapped(state), needed))
        return equilibria

    def _stable_ranges_of(self, index: int, b: Branch) -> list[StableRange]:
        n, ranges = len(b.values), []
        order = np.arange(n)
        if b.closed and not b.stable.all():  # begin where it is not stable, so that no stretch is cut
            first = int(np.flatnonzero(~b.stable)[0])
            order = np.concatenate([np.arange(first, n - 1), np.arange(first + 1)])
        stable = b.stable[order]
        begins = np.flatnonzero(stable & ~np.concatenate([[False], stable[:-1]]))
        for begin in begins:
            rest = np.flatnonzero(~stable[begin:])
            end = int(begin + rest[0] - 1) if len(rest) else n - 1
            one = self._edge(b, int(order[begin]), int(order[begin - 1]) if begin else None)
            other = self._edge(b, int(order[end]), int(order[end + 1]) if end + 1 < n else None)
            low, high = (one, other) if one.value <= other.value else (other, one)
            ranges.append(StableRange(index, low, high, order[begin : end + 1]))
        return ranges

    def _edge(self, b: Branch, inside: int, outside: int | None) -> Edge:
        """Where stability is lost between two neighbouring points, by bisection of the arc."""
        if outside is None:
            return Edge(float(b.values[inside]), "range", b.states[:, inside])
        sizes, unit = self.equations.sizes, self.equations.unit
        good, bad = (np.append(b.states[:, k] / sizes, b.values[k] / unit) for k in (inside, outside))
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
        return Edge(value, "hopf" if abs(leaving.imag) > 1e-3 * np.abs(values).max() else "fold", state)
