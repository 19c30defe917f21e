"""Branches of constant phases over a parameter, around their folds, and where their stability ends.

001 (21) and, for the lock limits of exciters, what follows from (33)-(34). They are followed by their arc length.
H. B. Keller, "Numerical Solution of Bifurcation and Nonlinear Eigenvalue Problems", in: Applications of Bifurcation Theory,
Academic Press 1977, 359-384.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.studies.entrainment.slow import Slow

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
class Interval:
    """A stretch of a branch that is stable, from ``low`` to ``high``; points: indices into the branch."""

    branch: int
    low: Edge
    high: Edge
    points: np.ndarray


@dataclass(frozen=True)
class Path:
    """Equilibria of slow equations, followed with the parameter."""

    slow: Slow

    def _slope(self, state: np.ndarray, value: float) -> np.ndarray:
        """d rates / d value (n,), the value in its size."""
        h = 1e-6 * self.slow.unit
        up, down = (self.slow.rates(state[:, None], value + s * h)[0][:, 0] for s in (1, -1))
        found: np.ndarray = (up - down) / (2 * h) * self.slow.unit
        return found

    def _bordered(self, at: np.ndarray, last: np.ndarray) -> np.ndarray:
        state, value = at[:-1] * self.slow.sizes, float(at[-1] * self.slow.unit)
        _, jacobian = self.slow.rates(state[:, None], value)
        return np.vstack([np.column_stack([jacobian[0], self._slope(state, value)]), last])

    def corrected(self, guess: np.ndarray, direction: np.ndarray, far: bool = False) -> np.ndarray | None:
        """The equilibrium (n + 1,: state and value by their sizes) in the plane through a guess normal to a direction.

        far: it may be far away; else None is returned where Newton's method goes there.
        """
        at = guess.copy()
        with np.errstate(all="ignore"):
            for _ in range(60 if far else 12):
                rate = self.slow.rates((at[:-1] * self.slow.sizes)[:, None], float(at[-1] * self.slow.unit))[0][:, 0]
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
        return at if np.abs(step).max() < 1e-8 else None

    def tangent(self, at: np.ndarray, before: np.ndarray) -> np.ndarray:
        """The unit tangent (n + 1,) that goes on in the direction ``before``."""
        matrix = self._bordered(at, before)
        found = np.linalg.lstsq(matrix, np.append(np.zeros(self.slow.n), 1.0), rcond=None)[0]
        turned: np.ndarray = found / np.linalg.norm(found)
        return turned

    def branch(self, state: np.ndarray, value: float) -> Branch:
        """The branch through an equilibrium, both ways, up to the limits or until it returns."""
        start = np.append(state / self.slow.sizes, value / self.slow.unit)
        first = np.append(np.zeros(self.slow.n), 1.0)
        away = self.tangent(start, first)
        forward, closed = self._followed(start, away)
        points = forward
        if not closed:
            backward, _ = self._followed(start, -away)
            points = [*reversed(backward[1:]), *forward]
        all_ = np.array(points).T
        states, values = all_[:-1] * self.slow.sizes[:, None], all_[-1] * self.slow.unit
        stable = np.array([self.slow.stable(states[:, k], float(values[k])) for k in range(len(values))])
        return Branch(values, states, stable, closed)

    def _followed(self, start: np.ndarray, tangent: np.ndarray) -> tuple[list[np.ndarray], bool]:
        points, step, at = [start], STEP, start
        while len(points) < _MOST:
            guess = at + step * tangent
            found = self.corrected(guess, tangent)
            along = None if found is None else self.tangent(found, tangent)
            if found is None or along is None or along @ tangent < 0.9 or np.abs(found - guess).max() > step:
                step /= 2
                if step < _SHORTEST:
                    break
                continue
            value = found[-1] * self.slow.unit
            if not self.slow.limits[0] <= value <= self.slow.limits[1]:
                points.append(self._clipped(at, found, tangent))
                return points, False
            if (found[:-1][~self.slow.phases] <= 0).any():
                break
            if len(points) > 3 and self._passed(start, at, found):
                points.append(start + self._turns(found, start))
                return points, True
            points.append(found)
            at, tangent, step = found, along, min(1.3 * step, _LONGEST)
        return points, False

    def _turns(self, found: np.ndarray, start: np.ndarray) -> np.ndarray:
        phases = np.append(self.slow.phases, False)
        return np.where(phases, 2 * math.pi * np.round((found - start) / (2 * math.pi)), 0.0)

    def _passed(self, start: np.ndarray, before: np.ndarray, after: np.ndarray) -> bool:
        """Whether the start lies on the way from one point to the next."""
        target, way = start + self._turns(after, start), after - before
        share = float((target - before) @ way) / float(way @ way)
        return 0 <= share <= 1 and float(np.linalg.norm(before + share * way - target)) < 0.1 * float(np.linalg.norm(way))

    def _clipped(self, at: np.ndarray, found: np.ndarray, tangent: np.ndarray) -> np.ndarray:
        """The point on the limit that was passed."""
        limit = self.slow.limits[0 if found[-1] * self.slow.unit < self.slow.limits[0] else 1] / self.slow.unit
        share = (limit - at[-1]) / (found[-1] - at[-1])
        guess = at + share * (found - at)
        normal = np.append(np.zeros(self.slow.n), 1.0)
        exact = self.corrected(guess, normal)
        return guess if exact is None else exact

    def on(self, branch: Branch, state: np.ndarray, value: float) -> bool:
        """Whether an equilibrium lies on a branch."""
        v = branch.values
        for k in np.flatnonzero((np.minimum(v[1:], v[:-1]) <= value) & (value <= np.maximum(v[1:], v[:-1]))):
            share = (value - v[k]) / (v[k + 1] - v[k]) if v[k + 1] != v[k] else 0.0
            between = branch.states[:, k] + share * (branch.states[:, k + 1] - branch.states[:, k])
            if self.slow.distance(between, state) < STEP:
                return True
        return False

    def branches(self, values: np.ndarray, more: np.ndarray | None) -> list[Branch]:
        """All that pass one of the values, found from many starts there and from states ``more`` (n, N) at the first."""
        found: list[Branch] = []
        for i, value in enumerate(values):
            for state in self.slow.equilibria(float(value), more if i == 0 else None):
                if not any(self.on(b, state, float(value)) for b in found):
                    found.append(self.branch(state, float(value)))
        for state, other in [] if found else self._anywhere(float(values[0])):
            if not any(self.on(b, state, other) for b in found):
                found.append(self.branch(state, other))
        return found

    def _anywhere(self, value: float) -> list[tuple[np.ndarray, float]]:
        """Equilibria at other values than those asked for: some phases are held, and the value that they need is found."""
        held = np.append(np.zeros(self.slow.n), 0.0)
        held[int(np.flatnonzero(self.slow.phases)[0])] = 1.0
        found = []
        for start in self.slow.starts().T[:_ANYWHERE]:
            at = self.corrected(np.append(start / self.slow.sizes, value / self.slow.unit), held, far=True)
            if at is None or not self.slow.limits[0] <= at[-1] * self.slow.unit <= self.slow.limits[1]:
                continue
            if (at[:-1][~self.slow.phases] > 0).all():
                found.append((self.slow.wrapped(at[:-1] * self.slow.sizes), float(at[-1] * self.slow.unit)))
        return found

    def intervals(self, branches: list[Branch]) -> list[Interval]:
        """All stable stretches."""
        return [i for k, b in enumerate(branches) for i in self._stretches(k, b)]

    def _stretches(self, index: int, b: Branch) -> list[Interval]:
        n, found = len(b.values), []
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
            found.append(Interval(index, low, high, order[begin : end + 1]))
        return found

    def _edge(self, b: Branch, inside: int, outside: int | None) -> Edge:
        """Where stability is lost between two neighbouring points, by bisection of the arc."""
        if outside is None:
            return Edge(float(b.values[inside]), "range", b.states[:, inside])
        good, bad = (np.append(b.states[:, k] / self.slow.sizes, b.values[k] / self.slow.unit) for k in (inside, outside))
        bad = bad + np.where(np.append(self.slow.phases, False), 2 * math.pi * np.round((good - bad) / (2 * math.pi)), 0.0)
        way = (bad - good) / np.linalg.norm(bad - good)
        for _ in range(_BISECTIONS):
            if np.abs(bad - good).max() < 1e-13:
                break
            middle = self.corrected((good + bad) / 2, way)
            if middle is None:
                break
            if self.slow.stable(middle[:-1] * self.slow.sizes, float(middle[-1] * self.slow.unit)):
                good = middle
            else:
                bad = middle
        state, value = good[:-1] * self.slow.sizes, float(good[-1] * self.slow.unit)
        values = self.slow.eigenvalues(state, value)
        leaving = values[values.real.argmax()]
        return Edge(value, "hopf" if abs(leaving.imag) > 1e-3 * np.abs(values).max() else "fold", state)
