"""Closed curves of a phase plane: seen where a curve comes back to itself, then solved for as periodic motions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.phase_plane.plane import Plane

_BACK = 30_000  # samples of a curve among which its last lap is looked for
_NEIGHBOUR = 0.1  # of the window: how far beside a state the curve may pass, to have come back to it
_SHORTEST = 0.02  # of the window: of a lap
_CREEPS = 0.02  # of its length: a lap that ends farther from its start is on its way to a fixed point
_LOST = 1e-10  # of the product of two entries of a monodromy matrix: what may be lost in their difference
_NEUTRAL = 1e-6  # of a multiplier: nearer to 1 curves beside are closed too


@dataclass(frozen=True)
class Lap:
    """The last lap of a curve: it ends at ``state`` (2,), began ``period`` before, and each state gains ``advance`` (2,) in it.

    gap: how far it ends beside its beginning, in units of the window. shares: of the period (M,), from 0 to 1, at which motion
    that goes on from there passes states that are evenly spaced.
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
        By how much each state advances in a period: whole turns of angles.
    multiplier : float
        By which a small distance from it grows in a period.
    """

    states: np.ndarray
    period: float
    turns: np.ndarray
    multiplier: float

    @property
    def kind(self) -> str:
        """In words."""
        if self.neutral:
            return "one of a family"
        return "stable" if self.multiplier < 1 else "unstable"

    @property
    def neutral(self) -> bool:
        """Whether curves beside it are closed too."""
        return abs(self.multiplier - 1) <= _NEUTRAL

    def goes_there(self, forwards: bool) -> bool:
        """Whether curves beside it go there, forwards or backwards in time, or are closed themselves."""
        return self.neutral or (self.multiplier < 1) == forwards

    def distance(self, plane: Plane, state: np.ndarray) -> float:
        """Of a state (2,) from it, in units of the window."""
        a, b = self.states[:, :-1], self.states[:, 1:]
        way, off = (b - a) / plane.scale[:, None], plane.apart(state[:, None], a)
        share = np.clip((way * off).sum(axis=0) / np.maximum((way * way).sum(axis=0), 1e-300), 0.0, 1.0)
        return float(np.hypot(*(off - share * way)).min())


def last_lap(plane: Plane, states: np.ndarray, time: np.ndarray) -> Lap | None:
    """The last lap of a curve (2, N) with its times (N,): since it last passed beside its end the same way, if it did."""
    x, t = states[:, -_BACK:], time[-_BACK:]
    if x.shape[1] < 3:
        return None
    end = x[:, -1]
    way = (x[:, -1] - x[:, -2]) / plane.scale
    way = way / max(float(np.hypot(*way)), 1e-300)
    off = plane.apart(x, end[:, None])
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
        began = x[:, k] + share * (x[:, k + 1] - x[:, k])
        turns = plane.turns * np.round(np.divide(end - began, plane.turns, out=np.zeros(2), where=plane.turns > 0))
        since = t[k] + share * (t[k + 1] - t[k])
        period = float(t[-1] - since)
        shares = (t[k + 1 :] - since) / period if period > 0 else (1 - (t[k + 1 :] - since) / period)[::-1]
        return Lap(end, abs(period), turns * np.sign(period), gap, shares)
    return None


def closed_curve(plane: Plane, lap: Lap) -> ClosedCurve | None:
    """The closed curve beside a lap, None where there is none."""
    system = replace(plane.system, outputs=(), quadratures=())
    compiled = compile_system(system)
    rates = np.abs(plane.rates(lap.state[:, None])[:, 0] / plane.scale)
    held = int(np.argmax(rates))
    try:
        orbit = periodic_orbit(compiled, plane.numbers, lap.state, lap.period, lap.advance, phase_state=held)
    except WuchtError:
        return None
    times = np.unique(np.concatenate([[0.0, 1.0], np.clip(lap.shares, 0.0, 1.0)])) * orbit.period
    run = integrate(compiled, orbit.state, plane.numbers, times)
    if run.failure is not None or not 0.5 < orbit.period / lap.period < 2:
        return None
    if np.ptp(run.states / plane.scale[:, None], axis=1).max() < _SHORTEST / 4:
        return None
    return ClosedCurve(run.states, orbit.period, orbit.advance, _multiplier(plane, orbit.monodromy, times, run.states))


def _multiplier(plane: Plane, monodromy: np.ndarray, times: np.ndarray, states: np.ndarray) -> float:
    """The product of both multipliers, that of the phase being 1; where rounding would hide it, from Liouville's formula."""
    from scipy.interpolate import CubicSpline

    scaled = monodromy * plane.scale[None, :] / plane.scale[:, None]
    if _LOST * float(np.abs(scaled).max()) ** 2 < _NEUTRAL:
        return float(np.linalg.det(monodromy))
    divergence = np.einsum("iiN->N", plane.jacobian(states))
    return math.exp(float(CubicSpline(times, divergence).integrate(times[0], times[-1])))
