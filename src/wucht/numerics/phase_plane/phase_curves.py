"""Curves of a phase plane, followed along their length until their limit is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.integration import integrate
from wucht.numerics.phase_plane.closed_curves import ClosedCurve, Lap, closed_curve, last_lap
from wucht.numerics.phase_plane.fixed_points import SADDLE, FixedPoint
from wucht.numerics.phase_plane.plane import PASSED_TIME, Plane

FIXED_POINT, CLOSED_CURVE, OUTSIDE_WINDOW, LENGTH, REST_STATE, FAILURE, KINKS = (
    "fixed point", "closed curve", "left the window", "length", "at rest", "failed", "too many kinks",
)  # fmt: skip

_LEG, _SPACING = 0.25, 1e-3  # of the window: length of a leg, and distance of samples
_REST = 1e-4  # of the usual speed: below, time counts instead of length
_STALL_SHARE = 1e-3  # of the length of a leg: a curve that advances by less is at rest
_ROUNDING = 1e-14  # of a Jacobian in units of the window: a decay below it is none
_TRAP, _HALVINGS = 5e-3, 12  # of the window: the largest trap around a fixed point, and the most halvings of it
_RINGS, _ANGLES = 6, 32  # states of a trap at which it is checked that curves go inwards
_PASSING, _AWAY = 3e-3, 1.2e-2  # of the window: distance at which a saddle is examined, and distance of a curve before
_ON_IT = 1e-5  # of the window: distance below which a state is on the manifold
_NEAR_LAP = 2e-3  # of the window: distance of successive laps below which a closed curve is searched
_ON_CLOSED = 0.02  # of the window: largest distance from an attracting closed curve


@dataclass(frozen=True, eq=False)
class PhaseCurve:
    """A curve that was followed to its end.

    Attributes
    ----------
    states : ndarray, (2, N)
        Angles continued along it, not wrapped.
    time : ndarray, (N,)
        Elapsed time, negative where it was followed backwards.
    forwards : bool
    end : str
        One of ``FIXED_POINT``, ``CLOSED_CURVE``, ``OUTSIDE_WINDOW``, ``LENGTH``, ``REST_STATE``, ``FAILURE``,
        ``KINKS``.
    index : int
        Index of the fixed point or closed curve at which it ends, -1 for another end.
    gap : float
        Distance from there at the end, in units of the window; for a saddle, from its manifold.
    length : float
        In units of the window.
    """

    states: np.ndarray
    time: np.ndarray
    forwards: bool
    end: str
    index: int = -1
    gap: float = 0.0
    length: float = 0.0


@dataclass(eq=False)
class Portrait:
    """Fixed points and closed curves of a phase plane, collected while curves are followed in it.

    points: its fixed points. closed_curves: those at which curves have ended; grows. most_length: of a curve, in units of the
    window. check: called now and then; an exception that it raises ends the search.
    """

    plane: Plane
    points: Sequence[FixedPoint]
    most_length: float = 60.0
    closed_curves: list[ClosedCurve] = field(default_factory=list)
    check: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        self._traps = {k: _trap(self.plane, p) for k, p in enumerate(self.points) if p.attracts}
        self._compiled_system = self.plane.compiled_length_system

    def follow(self, start: np.ndarray, forwards: bool) -> PhaseCurve:
        """Follow the curve from a state (2,). Raises ``KeyboardInterrupt`` where the user stops it."""
        plane, way = self.plane, 1.0 if forwards else -1.0
        numbers, grid = plane.length_numbers(forwards, _REST), np.linspace(0.0, _LEG, round(_LEG / _SPACING) + 1)
        states, time, length, near = np.asarray(start, float)[:, None], np.zeros(1), 0.0, _NEAR_LAP
        while True:
            run = integrate(self._compiled_system, states[:, -1], numbers, grid, self._progress).reraise_interrupt()
            first = states.shape[1]
            states = np.concatenate([states, run.states[:, 1:]], axis=1)
            time = np.concatenate([time, time[-1] + way * run.quadratures[PASSED_TIME][1:]])
            if (curve := self._ended_curve(states, time, first, forwards)) is not None:
                return replace(curve, length=length + plane.length(curve.states[:, first - 1 :]))
            leg_length = plane.length(states[:, first - 1 :])
            length += leg_length
            lap, end, index, gap = last_lap(plane, states, time), "", -1, 0.0
            if run.failure is not None:
                end = KINKS if run.is_sliding else FAILURE
            elif leg_length < _STALL_SHARE * _LEG:
                end, index, gap = self._rest(states[:, -1])
            elif lap is not None and lap.gap < near and (closed_end := self._match_closed_curve(lap, forwards)) is not None:
                end, (index, gap) = CLOSED_CURVE, closed_end
            elif length >= self.most_length:
                end = LENGTH
            if end:
                return PhaseCurve(states, time, forwards, end, index, gap, length)
            near = min(near, lap.gap) / 2 if lap is not None and lap.gap < near else near

    def _progress(self, _time: float) -> None:
        if self.check is not None:
            self.check()

    def _rest(self, state: np.ndarray) -> tuple[str, int, float]:
        """Return the end of a curve at rest: a fixed point of any kind, or elsewhere."""
        away = [float(np.hypot(*self.plane.difference(state, p.state))) for p in self.points]
        if away and min(away) < _ON_CLOSED:
            return FIXED_POINT, int(np.argmin(away)), min(away)
        return REST_STATE, -1, 0.0

    def _ended_curve(self, states: np.ndarray, time: np.ndarray, first: int, forwards: bool) -> PhaseCurve | None:
        """Return the curve to its end among the samples from ``first`` on; None where it does not end there."""
        plane, new, ended_curves = self.plane, states[:, first:], list[PhaseCurve]()

        def add(count: int, state: np.ndarray, at: float, end: str, index: int, gap: float) -> None:
            """Add the curve of so many samples and a last state (2, 1)."""
            of_curve = np.concatenate([states[:, :count], state], axis=1), np.append(time[:count], at)
            ended_curves.append(PhaseCurve(*of_curve, forwards, end, index, gap))

        outside = (((new < plane.low[:, None]) | (new > plane.high[:, None])) & (plane.turns == 0)[:, None]).any(axis=0)
        if outside.any():
            k = first + int(outside.argmax())
            share = _share_inside(plane, states[:, k - 1], states[:, k])
            border = states[:, k - 1] + share * (states[:, k] - states[:, k - 1])
            add(k, border[:, None], float(time[k - 1] + share * (time[k] - time[k - 1])), OUTSIDE_WINDOW, -1, 0.0)
        for k, p in enumerate(self.points):
            away = plane.difference(new, p.state[:, None])
            i, gap = self._arrival(states, first, k, away, forwards)
            if i >= 0:
                end_state = new[:, i : i + 1] - (away[:, i] * plane.scale)[:, None]
                add(first + i + 1, end_state, float(time[first + i]), FIXED_POINT, k, gap)
        return min(ended_curves, key=lambda curve: len(curve.time), default=None)

    def _arrival(self, states: np.ndarray, first: int, k: int, away: np.ndarray, forwards: bool) -> tuple[int, float]:
        """Return the first new sample from which a curve goes to a fixed point, else -1. away: (2, N), from that point."""
        p, distance = self.points[k], np.hypot(*away)
        if not distance.size:
            return -1, 0.0
        if p.attracts == (1 if forwards else -1):
            caught = np.einsum("iN,ij,jN->N", away, self._traps[k], away) <= 1
            i = int(caught.argmax())
            return (i, float(distance[i])) if caught[i] else (-1, 0.0)
        i = int(distance.argmin())
        limit = _PASSING if 0 < i < len(distance) - 1 else _PASSING / 2
        if p.kind == SADDLE and distance[i] < limit and self._has_been_away(states[:, : first + i], p):
            arrival = int((distance < limit).argmax())  # later it departs from the manifold
            gap, at = min((_manifold_distance(self.plane, p, away[:, k], forwards), k) for k in (arrival, i))
            return (at, gap) if gap < _ON_IT else (-1, 0.0)
        return -1, 0.0

    def _has_been_away(self, states: np.ndarray, point: FixedPoint) -> bool:
        """True if a curve has been away from a saddle before it comes (back) to it."""
        return bool((np.hypot(*self.plane.difference(states, point.state[:, None])) > _AWAY).any())

    def _match_closed_curve(self, lap: Lap, forwards: bool) -> tuple[int, float] | None:
        """Return the closed curve at which a curve with this last lap ends, and its distance; None if there is none."""
        for k, known_curve in enumerate(self.closed_curves):
            gap = known_curve.distance(self.plane, lap.state)
            if gap < (_ON_IT if known_curve.neutral else _ON_CLOSED) and known_curve.attracts(forwards):
                return k, gap
        new_curve = closed_curve(self.plane, lap)
        if new_curve is None or not new_curve.attracts(forwards):
            return None
        gap = new_curve.distance(self.plane, lap.state)
        if gap > (_ON_IT if new_curve.neutral else _ON_CLOSED):  # near a homoclinic loop there may be a family
            return None
        self.closed_curves.append(new_curve)
        return len(self.closed_curves) - 1, gap


def _trap(plane: Plane, point: FixedPoint) -> np.ndarray:
    """Return the metric of an ellipse z^T metric z <= 1 around a fixed point that curves enter and do not leave.

    It is that of Lyapunov's equation, in units of the window, so small that z^T metric z falls along all curves inside it.
    Raises ``RunError`` in a window so large that the attraction vanishes in its units.
    """
    from scipy.linalg import solve_continuous_lyapunov

    scale, way = plane.scale, point.attracts
    matrix = way * plane.jacobian(point.state[:, None])[..., 0] * scale[None, :] / scale[:, None]
    metric = np.zeros((2, 2))
    if np.linalg.eigvals(matrix).real.max() < -_ROUNDING * np.abs(matrix).max():
        metric = solve_continuous_lyapunov(matrix.T, -np.eye(2))
    if not np.linalg.eigvalsh(metric)[0] > _ROUNDING * np.abs(metric).max():
        at = ", ".join(f"{x:.4g}" for x in point.state)
        raise RunError(
            f"the fixed point at ({at}) attracts too weakly to be resolved in this window: choose smaller ranges",
            code="too-narrow",
        )
    size = _TRAP * np.sqrt(np.linalg.eigvalsh(metric)[0])  # the longest half axis is _TRAP
    around = np.linspace(0, 2 * np.pi, _ANGLES, endpoint=False)
    circle = np.linalg.solve(np.linalg.cholesky(metric).T, np.array([np.cos(around), np.sin(around)]))
    for _ in range(_HALVINGS):
        z = np.concatenate([circle * size * r / _RINGS for r in range(1, _RINGS + 1)], axis=1)
        falls = way * np.einsum(
            "iN,ij,jN->N", z, metric, plane.rates(point.state[:, None] + z * scale[:, None]) / scale[:, None]
        )
        if (falls < 0).all():
            break
        size /= 2
    return np.asarray(metric / size**2)


def _manifold_distance(plane: Plane, saddle: FixedPoint, away: np.ndarray, forwards: bool) -> float:
    """Return the distance of a state near a saddle from the manifold along which curves go to it, in units of the window."""
    j, scale = plane.jacobian(saddle.state[:, None])[..., 0], plane.scale
    values, vectors = np.linalg.eig(j * scale[None, :] / scale[:, None])
    values, vectors = values.real, vectors.real
    into, out = (
        (int(np.argmin(values)), int(np.argmax(values))) if forwards else (int(np.argmax(values)), int(np.argmin(values)))
    )
    a = np.linalg.solve(vectors, away)
    v = vectors[:, into]
    bend = np.linalg.solve(j - 2 * values[into] * np.eye(2), -plane.curvature(saddle.state, v * scale) / 2) / scale
    return float(abs(a[out] - np.linalg.solve(vectors, bend)[out] * a[into] ** 2))


def _share_inside(plane: Plane, inside: np.ndarray, outside: np.ndarray) -> float:
    """Return the share of the way from one state to another that is in the window."""
    shares = [1.0]
    for i in np.flatnonzero(plane.turns == 0):
        border = plane.low[i] if outside[i] < plane.low[i] else plane.high[i] if outside[i] > plane.high[i] else None
        if border is not None and outside[i] != inside[i]:
            shares.append(float((border - inside[i]) / (outside[i] - inside[i])))
    return min(max(min(shares), 0.0), 1.0)
