"""The torque balance as a function on the torus of the phases, with bounds on how much its Jacobian changes over a box.

The bounds follow from those of the harmonic influence coefficients over an interval of speeds, by a Neumann series.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import WuchtError
from wucht.machines.operation import SPEED
from wucht.numerics.intervals import enclosure
from wucht.piecewise import PiecewiseCubic


@dataclass(frozen=True)
class OnTheTorus:
    """The torque balance as f(x) = 0, x = (alpha_1, ..., alpha_n-1), and the speed if it is not given: k unknowns.

    Where the speed is searched the first equation is that of all torques together: near a resonance the torques between the
    bodies are large, and in it they are gone.
    """

    torques: SteadyTorques

    def parted(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Speeds (N,) and phases (n, N)."""
        n = self.torques.size
        phases = np.concatenate([np.zeros((1, x.shape[1])), x[: n - 1]])
        given = self.torques.given
        return (x[-1] if given is None else np.full(x.shape[1], given)), phases

    def function(self, x: np.ndarray) -> np.ndarray:
        """f (k, N)."""
        t, at = self.torques, self.parted(x)
        found: np.ndarray = t.residual(*at)[list(t.free)]
        if t.given is None:
            found[0] = t.total(*at)
        return found

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """df/dx (k, k, N)."""
        t, free = self.torques, list(self.torques.free)
        speeds, phases = self.parted(x)
        change, rate = t.slopes(speeds, phases)
        found: np.ndarray = change[free][:, 1:]
        if t.given is None:
            found = np.concatenate([found, (rate + t.alone(speeds)[1])[free][:, None]], axis=1)
            found[0] = self._of_all(speeds, phases)
        return found

    def _of_all(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """The first row (k, N): d/dx of sum tau_i - s^H B s."""
        t, s = self.torques, np.exp(1j * phases)
        brake, rate = (np.einsum("iN,Nik,kN->iN", s.conj(), b, s) for b in t.brake(speeds))
        by_speed = t.share @ t.alone(speeds)[1] - rate.real.sum(axis=0)
        return np.concatenate([-2 * brake.imag[1:], by_speed[None]])

    def spread(self, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """How much df/dx differs from that at the centre of a box, at most (k, k, N)."""
        t, free, n = self.torques, list(self.torques.free), self.torques.size
        speeds, phases = self.parted(centre)
        reach = np.concatenate([np.zeros((1, radius.shape[1])), radius[: n - 1]])
        apart, turn = phases[:, None] - phases[None], reach[:, None] + reach[None]
        wide = radius[-1] if t.given is None else np.zeros(centre.shape[1])
        influence, rate = (np.moveaxis(v, 0, -1) for v in t.influence(speeds))
        here, now = speeds**4 / 2 * influence, 2 * speeds**3 * influence + speeds**4 / 2 * rate
        bounds = self._bounds(speeds, wide)
        slope, curve, own = (np.moveaxis(v, 0, -1) for v in bounds[:3])
        cosine = np.minimum(2.0, np.abs(np.sin(apart - np.angle(here))) * turn + turn**2 / 2)
        by_phase = np.abs(here) * cosine + slope * wide
        index = np.arange(n)
        by_phase[index, index] = 0.0
        by_phase[index, index] = by_phase.sum(axis=1)
        found: np.ndarray = by_phase[free][:, 1:]
        if t.given is None:
            by_speed = (np.abs(now) * np.minimum(2.0, turn) + curve * wide).sum(axis=1) + own
            found = np.concatenate([found, by_speed[free][:, None]], axis=1)
            found[0] = self._spread_of_all(speeds, apart, turn, wide, own, *(np.moveaxis(v, 0, -1) for v in bounds[3:]))
        return found

    def _spread_of_all(
        self,
        speeds: np.ndarray,
        apart: np.ndarray,
        turn: np.ndarray,
        wide: np.ndarray,
        own: np.ndarray,
        slope: np.ndarray,
        curve: np.ndarray,
    ) -> np.ndarray:
        """The same (k, N) for the first row. slope, curve: bounds on |B'| and |B''|."""
        t, index = self.torques, np.arange(self.torques.size)
        here, now = (np.moveaxis(b, 0, -1) for b in t.brake(speeds))
        by_phase = np.abs(here) * np.minimum(2.0, np.abs(np.cos(apart - np.angle(here))) * turn + turn**2 / 2) + slope * wide
        by_phase[index, index] = 0.0  # a body's own part does not depend on its phase
        other = turn.copy()
        other[index, index] = 0.0
        by_speed = (np.abs(now) * np.minimum(2.0, other) + curve * wide).sum(axis=(0, 1)) + np.abs(t.share) @ own
        found: np.ndarray = np.concatenate([2 * by_phase.sum(axis=1)[1:], by_speed[None]])
        return found

    def _bounds(self, speeds: np.ndarray, wide: np.ndarray) -> tuple[np.ndarray, ...]:
        """Bounds over intervals of speeds: on |b'| and |b''| (N, n, n) of b = w^4 a/2, on what tau' differs by (N, n), on |B'|
        and |B''|.
        """
        if not wide.any():
            none = np.zeros((len(speeds), self.torques.size, self.torques.size))
            return none, none, none[:, 0], none, none
        pairs, where = np.unique(np.array([speeds, wide]), axis=1, return_inverse=True)
        found = _bounds_over(self.torques, pairs[0], pairs[1])
        return tuple(v[where.ravel()] for v in found)


def _bounds_over(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    v, high = t.vibration, (w + r)[:, None, None]
    left, right = np.abs(t.felt), np.abs(v.excitation).T
    mass, damping = np.abs(v.mass), np.abs(v.damping)
    centre = np.linalg.inv(v.dynamic(w[:, None, None]))
    response = np.abs(centre)
    moved = (2 * w * r + r**2)[:, None, None] * mass + r[:, None, None] * damping
    ratio = moved @ response
    converges = np.abs(np.linalg.eigvals(ratio)).max(axis=-1, initial=0.0) < 0.95
    safe = np.where(converges[:, None, None], ratio, 0.0)
    bound = response @ np.linalg.inv(np.eye(len(v.mass)) - safe)
    first = bound @ (2 * high * mass + damping) @ bound
    second = 2 * first @ (2 * high * mass + damping) @ bound + bound @ (2 * mass) @ bound
    a, da, dda = (left @ x @ right for x in (bound, first, second))
    exact, slope = (np.abs(x) for x in t.influence(w))  # at the centre, where bodies' excitations may cancel
    da = np.minimum(da, slope + dda * r[:, None, None])
    a = np.minimum(a, exact + da * r[:, None, None])
    found = [2 * high**3 * a + high**4 / 2 * da, 6 * high**2 * a + 4 * high**3 * da + high**4 / 2 * dda]
    power = bound @ damping @ bound
    rate = first @ damping @ bound + bound @ damping @ first
    bend = second @ damping @ bound + 2 * first @ damping @ first + bound @ damping @ second
    p, dp, ddp = (right.T @ x @ right for x in (power, rate, bend))
    braking = [5 * high**4 / 2 * p + high**5 / 2 * dp, 10 * high**3 * p + 5 * high**4 * dp + high**5 / 2 * ddp]
    braking[0] = np.minimum(braking[0], np.abs(t.brake(w)[1]) + braking[1] * r[:, None, None])
    for x in (*found, *(braking if damping.any() else ())):  # without damping nothing brakes, whatever the response
        x[~converges] = np.inf
    return (*found, _apart(t, w, r), *braking)


def bounded(torques: SteadyTorques) -> bool:
    """Whether bounds are known of the torques' slopes, where the speed is searched: not where a characteristic jumps."""
    at, nothing = np.ones(1), np.zeros(1)
    return torques.given is not None or bool(np.isfinite(_apart(torques, at, nothing)).all())


def _apart(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """How much the slopes of the torques tau on [w - r, w + r] differ from those at w, at most (N, n).

    At a kink both slopes count: a zero is unique if every matrix of slopes between them is regular (F. H. Clarke, Optimization
    and Nonsmooth Analysis, 1983, sections 2.6, 7.1).
    """
    found, slopes = np.zeros((len(w), t.size)), t.alone(w)[1]
    for i, torque in enumerate(e.xreplace(t.machine.numbers) for e in t.own):
        slope, curvature = _derivatives(torque)
        if slope is None:
            found[:, i] = np.inf
        elif curvature is None:
            below, above = _enclosure(slope, w - r, w + r)
            found[:, i] = np.maximum(above - slopes[i], slopes[i] - below)
        else:
            below, above = _enclosure(curvature, w - r, w + r)
            found[:, i] = np.where(r > 0, np.maximum(np.abs(below), np.abs(above)) * r, 0.0)
    return found


@lru_cache(maxsize=64)
def _derivatives(torque: sp.Expr) -> tuple[sp.Expr | None, sp.Expr | None]:
    """The first and second derivative of a torque by ``SPEED``; None where it jumps, or has a kink."""
    pieces = [f.args[1] for f in torque.atoms(PiecewiseCubic)]
    if any(p.jumps() for p in pieces):
        return None, None
    slope = sp.diff(torque, SPEED)
    kinked = any(p.derivative.jumps() for p in pieces)
    return sp.together(slope), None if kinked else sp.together(sp.diff(slope, SPEED))


def _enclosure(expression: sp.Expr, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    try:
        return enclosure(expression, SPEED, low, high)
    except WuchtError:
        return np.full_like(low, -np.inf), np.full_like(low, np.inf)
