"""Closed curves of a phase plane: detected where a curve returns to itself, then solved for as periodic motions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.phase_plane.plane import Plane

_BACK = 30_000  # samples of a curve in which its last lap is searched
_NEIGHBOUR = 0.1  # of the window: largest distance from a state at which the curve counts as having returned to it
_SHORTEST = 0.02  # of the window: shortest lap
_CREEPS = 0.02  # of its length: a lap that ends farther from its start is on its way to a fixed point
_CANCELLATION = 1e-10  # of the product of two entries of a monodromy matrix: possible cancellation in their difference
_NEUTRAL = 1e-6  # of a multiplier: nearer to 1 neighbouring curves are closed too


@dataclass(frozen=True)
class Lap:
    """The last lap of a curve: it ends at ``state`` (2,), began ``period`` before, and each state gains ``advance`` (2,) in it.

    gap: distance of its end from its beginning, in units of the window. shares: of the period (M,), from 0 to 1, at which the
    motion that continues from there passes evenly spaced states.
    """

    state: np.ndarray
    period: float
    advance: np.ndarray
    gap: float
    shares: np.ndarray


@dataclass(frozen=True, eq=False)
class ClosedCurve:
    """A periodic motion.

    Attributes
    ----------
    states : ndarray, (2, M)
        Evenly spaced, over a period: the last equals the first but for whole turns.
    period : float
    turns : ndarray, (2,)
        The advance of each state in a period: whole turns of angles.
    multiplier : float
        The factor by which a small distance from it grows in a period.
    """

    states: np.ndarray
    period: float
    turns: np.ndarray
    multiplier: float

    @property
    def kind(self) -> str:
        """Kind of the closed curve, for reports."""
        if self.neutral:
            return "one of a family"
        return "stable" if self.multiplier < 1 else "unstable"

    @property
    def neutral(self) -> bool:
        """True if neighbouring curves are closed too."""
        return abs(self.multiplier - 1) <= _NEUTRAL

    def attracts(self, forwards: bool) -> bool:
        """True if neighbouring curves approach it, forwards or backwards in time, or are closed too."""
        return self.neutral or (self.multiplier < 1) == forwards

    def distance(self, plane: Plane, state: np.ndarray) -> float:
        """Return the distance of a state (2,) from the curve, in units of the window."""
        a, b = self.states[:, :-1], self.states[:, 1:]
        way, off = (b - a) / plane.scale[:, None], plane.difference(state[:, None], a)
        share = np.clip((way * off).sum(axis=0) / np.maximum((way * way).sum(axis=0), 1e-300), 0.0, 1.0)
        return float(np.hypot(*(off - share * way)).min())


def last_lap(plane: Plane, states: np.ndarray, time: np.ndarray) -> Lap | None:
    """Return the last lap of a curve (2, N) with times (N,), since it last passed near its end the same way, or None."""
    x, t = states[:, -_BACK:], time[-_BACK:]
    if x.shape[1] < 3:
        return None
    end = x[:, -1]
    way = (x[:, -1] - x[:, -2]) / plane.scale
    way = way / max(float(np.hypot(*way)), 1e-300)
    off = plane.difference(x, end[:, None])
    ahead, beside = way @ off, np.array([-way[1], way[0]]) @ off
    near = (np.abs(ahead) < _NEIGHBOUR) & (np.abs(beside) < _NEIGHBOUR)
    crosses = near[:-1] & near[1:] & (ahead[:-1] <= 0) & (ahead[1:] > 0)
    for k in np.flatnonzero(crosses)[::-1]:
        length = plane.length(x[:, k:])
        share = float(ahead[k] / (ahead[k] - ahead[k + 1]))
        gap = abs(float(beside[k] + share * (beside[k + 1] - beside[k])))
        if length < _SHORTEST:
            continue
        if gap > _CREEPS * length:
            return None
        lap_start = x[:, k] + share * (x[:, k + 1] - x[:, k])
        turns = plane.turns * np.round(np.divide(end - lap_start, plane.turns, out=np.zeros(2), where=plane.turns > 0))
        start_time = t[k] + share * (t[k + 1] - t[k])
        period = float(t[-1] - start_time)
        shares = (t[k + 1 :] - start_time) / period if period > 0 else (1 - (t[k + 1 :] - start_time) / period)[::-1]
        return Lap(end, abs(period), turns * np.sign(period), gap, shares)
    return None


def closed_curve(plane: Plane, lap: Lap) -> ClosedCurve | None:
    """Solve for the closed curve near a lap; None where there is none."""
    system = replace(plane.system, outputs=(), quadratures=())
    compiled_system = compile_system(system)
    rates = np.abs(plane.rates(lap.state[:, None])[:, 0] / plane.scale)
    phase_state = int(np.argmax(rates))
    try:
        orbit = periodic_orbit(compiled_system, plane.numbers, lap.state, lap.period, lap.advance, phase_state=phase_state)
    except WuchtError:
        return None
    times = np.unique(np.concatenate([[0.0, 1.0], np.clip(lap.shares, 0.0, 1.0)])) * orbit.period
    run = integrate(compiled_system, orbit.state, plane.numbers, times).reraise_interrupt()
    if run.failure is not None or not 0.5 < orbit.period / lap.period < 2:
        return None
    if np.ptp(run.states / plane.scale[:, None], axis=1).max() < _SHORTEST / 4:
        return None
    return ClosedCurve(run.states, orbit.period, orbit.advance, _multiplier(plane, orbit.monodromy, times, run.states))


def _multiplier(plane: Plane, monodromy: np.ndarray, times: np.ndarray, states: np.ndarray) -> float:
    """Return the product of both multipliers, that of the phase being 1; from Liouville's formula where rounding hides it."""
    from scipy.interpolate import CubicSpline

    scaled_monodromy = monodromy * plane.scale[None, :] / plane.scale[:, None]
    if _CANCELLATION * float(np.abs(scaled_monodromy).max()) ** 2 < _NEUTRAL:
        return float(np.linalg.det(monodromy))
    divergence = np.einsum("iiN->N", plane.jacobian(states))
    return math.exp(float(CubicSpline(times, divergence).integrate(times[0], times[-1])))
