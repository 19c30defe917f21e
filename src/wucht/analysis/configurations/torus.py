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
from wucht.machines.structure import SPEED
from wucht.numerics.intervals import enclosure
from wucht.piecewise import PiecewiseCubic


@dataclass(frozen=True)
class TorusProblem:
    """The torque balance as f(x) = 0, x = (alpha_1, ..., alpha_n-1), and the speed if it is not fixed: k unknowns.

    Where the speed is searched the first equation is the sum of all torques: near a resonance the torques between the
    bodies are large, and in the sum they cancel.
    """

    torques: SteadyTorques

    def speeds_and_phases(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Speeds (N,) and phases (n, N)."""
        phases = np.concatenate([np.zeros((1, x.shape[1])), x[: self.torques.size - 1]])
        return (x[-1] if self.torques.fixed_speed is None else np.full(x.shape[1], self.torques.fixed_speed)), phases

    def function(self, x: np.ndarray) -> np.ndarray:
        """f (k, N)."""
        t, at = self.torques, self.speeds_and_phases(x)
        balance: np.ndarray = t.residual(*at)[list(t.free)]
        if t.fixed_speed is None:
            balance[0] = t.total(*at)
        return balance

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """df/dx (k, k, N)."""
        t, free = self.torques, list(self.torques.free)
        speeds, phases = self.speeds_and_phases(x)
        change, rate = t.slopes(speeds, phases)
        if t.fixed_speed is not None:
            return np.asarray(change[free][:, 1:])
        torque_slopes = t.shaft_torque(speeds)[1]
        jacobian = np.concatenate([change[:, 1:], (rate + torque_slopes)[:, None]], axis=1)
        s = np.exp(1j * phases)  # the first row: d/dx of sum tau_i - s^H B s
        brake, slope = (np.einsum("iN,Nik,kN->iN", s.conj(), b, s) for b in t.brake(speeds))
        jacobian[0] = np.concatenate([-2 * brake.imag[1:], (t.share @ torque_slopes - slope.real.sum(axis=0))[None]])
        return jacobian

    def spread(self, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Upper bound (k, k, N) on the change of df/dx from the centre of a box."""
        t, free, n = self.torques, list(self.torques.free), self.torques.size
        speeds, phases = self.speeds_and_phases(centre)
        reach = np.concatenate([np.zeros((1, radius.shape[1])), radius[: n - 1]])
        apart, turn = phases[:, None] - phases[None], reach[:, None] + reach[None]
        wide = radius[-1] if t.fixed_speed is None else np.zeros(centre.shape[1])
        influence, rate = (np.moveaxis(v, 0, -1) for v in t.influence_with_slope(speeds))
        slope, curve, slope_spread, *braking = (np.moveaxis(v, 0, -1) for v in self._bounds(speeds, wide))
        pull, now = speeds**4 / 2 * influence, 2 * speeds**3 * influence + speeds**4 / 2 * rate
        by_phase = _phase_variation(pull, np.sin(apart - np.angle(pull)), turn, slope * wide)
        by_phase[np.arange(n), np.arange(n)] = by_phase.sum(axis=1)
        if t.fixed_speed is not None:
            return np.asarray(by_phase[free][:, 1:])
        by_speed = (np.abs(now) * np.minimum(2.0, turn) + curve * wide).sum(axis=1) + slope_spread
        spread = np.concatenate([by_phase[:, 1:], by_speed[:, None]], axis=1)
        brake, rate = (np.moveaxis(b, 0, -1) for b in t.brake(speeds))
        by_phase = _phase_variation(brake, np.cos(apart - np.angle(brake)), turn, braking[0] * wide)
        turn[np.arange(n), np.arange(n)] = 0.0  # the diagonal part does not depend on the body's phase
        by_speed = (np.abs(rate) * np.minimum(2.0, turn) + braking[1] * wide).sum(axis=(0, 1)) + np.abs(t.share) @ slope_spread
        spread[0] = np.concatenate([2 * by_phase.sum(axis=1)[1:], by_speed[None]])
        return spread

    def _bounds(self, speeds: np.ndarray, wide: np.ndarray) -> tuple[np.ndarray, ...]:
        """Bounds over intervals of speeds: on |b'| and |b''| (N, n, n) of b = w^4 a/2, on the change of tau' (N, n), on |B'|
        and |B''|.
        """
        if not wide.any():
            zeros = np.zeros((len(speeds), self.torques.size, self.torques.size))
            return zeros, zeros, zeros[:, 0], zeros, zeros
        pairs, inverse = np.unique(np.array([speeds, wide]), axis=1, return_inverse=True)
        return tuple(v[inverse.ravel()] for v in _interval_bounds(self.torques, *pairs))


def _phase_variation(pull: np.ndarray, slope: np.ndarray, turn: np.ndarray, by_speed: np.ndarray) -> np.ndarray:
    """Bound on the change of a harmonic torque (n, n, N), of this relative slope, over turns; zero on the diagonal."""
    change: np.ndarray = np.abs(pull) * np.minimum(2.0, np.abs(slope) * turn + turn**2 / 2) + by_speed
    change[np.arange(len(pull)), np.arange(len(pull))] = 0.0
    return change


def _interval_bounds(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    v, high = t.vibration, (w + r)[:, None, None]
    reaction, excitation = np.abs(t.reaction_shapes), np.abs(v.excitation).T
    mass, damping = np.abs(v.mass), np.abs(v.damping)
    centre = np.linalg.inv(v.dynamic_stiffness(w[:, None, None]))
    response = np.abs(centre)
    perturbation = (2 * w * r + r**2)[:, None, None] * mass + r[:, None, None] * damping
    ratio = perturbation @ response
    converges = np.abs(np.linalg.eigvals(ratio)).max(axis=-1, initial=0.0) < 0.95
    safe = np.where(converges[:, None, None], ratio, 0.0)
    inverse_bound = response @ np.linalg.inv(np.eye(len(v.mass)) - safe)
    first = inverse_bound @ (2 * high * mass + damping) @ inverse_bound
    second = 2 * first @ (2 * high * mass + damping) @ inverse_bound + inverse_bound @ (2 * mass) @ inverse_bound
    a, da, dda = (reaction @ x @ excitation for x in (inverse_bound, first, second))
    exact, slope = (np.abs(x) for x in t.influence_with_slope(w))  # at the centre, where bodies' excitations may cancel
    da = np.minimum(da, slope + dda * r[:, None, None])
    a = np.minimum(a, exact + da * r[:, None, None])
    pulling = [2 * high**3 * a + high**4 / 2 * da, 6 * high**2 * a + 4 * high**3 * da + high**4 / 2 * dda]
    power = inverse_bound @ damping @ inverse_bound
    rate = first @ damping @ inverse_bound + inverse_bound @ damping @ first
    bend = second @ damping @ inverse_bound + 2 * first @ damping @ first + inverse_bound @ damping @ second
    p, dp, ddp = (excitation.T @ x @ excitation for x in (power, rate, bend))
    braking = [5 * high**4 / 2 * p + high**5 / 2 * dp, 10 * high**3 * p + 5 * high**4 * dp + high**5 / 2 * ddp]
    braking[0] = np.minimum(braking[0], np.abs(t.brake(w)[1]) + braking[1] * r[:, None, None])
    for x in (*pulling, *(braking if damping.any() else ())):  # without damping nothing brakes, whatever the response
        x[~converges] = np.inf
    return (*pulling, _slope_deviation(t, w, r), *braking)


def has_slope_bounds(torques: SteadyTorques) -> bool:
    """True if the torques' slopes have bounds, as far as the speed is searched: not where a characteristic jumps."""
    at, nothing = np.ones(1), np.zeros(1)
    return torques.fixed_speed is not None or bool(np.isfinite(_slope_deviation(torques, at, nothing)).all())


def _slope_deviation(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Upper bound (N, n) on the change of the slopes of the torques tau on [w - r, w + r] from those at w.

    At a kink both slopes count: a zero is unique if every matrix of slopes between them is regular (F. H. Clarke, Optimization
    and Nonsmooth Analysis, 1983, sections 2.6, 7.1).
    """
    deviation, slopes = np.full((len(w), t.size), np.inf), t.shaft_torque(w)[1]
    for i, torque in enumerate(e.xreplace(t.machine.numbers) for e in t.shaft_torques):
        slope, curvature = _derivatives(torque)
        if curvature is not None:
            below, above = _enclosure(curvature, w - r, w + r)
            deviation[:, i] = np.where(r > 0, np.maximum(np.abs(below), np.abs(above)) * r, 0.0)
        elif slope is not None:
            below, above = _enclosure(slope, w - r, w + r)
            deviation[:, i] = np.maximum(above - slopes[i], slopes[i] - below)
    return deviation


@lru_cache(maxsize=64)
def _derivatives(torque: sp.Expr) -> tuple[sp.Expr | None, sp.Expr | None]:
    """The first and second derivative of a torque by ``SPEED``; None where it jumps, or has a kink."""
    pieces = [f.args[1] for f in torque.atoms(PiecewiseCubic)]
    if any(p.jumps() for p in pieces):
        return None, None
    slope = sp.diff(torque, SPEED)
    has_kinks = any(p.derivative.jumps() for p in pieces)
    return sp.together(slope), None if has_kinks else sp.together(sp.diff(slope, SPEED))


def _enclosure(expression: sp.Expr, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    try:
        return enclosure(expression, SPEED, low, high)
    except WuchtError:
        return np.full_like(low, -np.inf), np.full_like(low, np.inf)
