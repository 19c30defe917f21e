"""Equilibria at which motions rest: recognised by the residual of the equations, and by the eigenvalues there.

Where a motion seems to rest, the step of Newton's method from there is the distance of the equilibrium, and the real parts of
its eigenvalues are the rates at which disturbances grow or decay. A motion that comes near to a saddle rests for a while
too. It ends there only if it rests for longer than a disturbance as small as rounding takes to grow to the size of the motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind, StateMetric
from wucht.machines.subject import Subject
from wucht.numerics.flow.jacobian import Jacobian

_AT_REST = 1e-6  # of the extent of the whole run: a smaller change is none
# Times the tolerance: as small a change is the noise of an integration, whose steps grow at an equilibrium until they are
# barely stable. Measured with Lorenz' equations: 26 (compiled, SciPy).
_NOISE = 100.0
_NEWTON, _LAST_STEP = 30, 1e-10  # steps; relative to the states' sizes
_NEUTRAL = 1e-6  # of the fastest rate: a slower disturbance neither grows nor decays
_NEARBY, _NOISES = 1e-3, 10.0  # of the states' sizes, and times the noise: no motion rests farther away from its equilibrium
_GROWTH_OF_ROUNDING = math.log(1e16)  # e-folds until a disturbance of the size of rounding is as large as the motion


def state_extents(ranges: np.ndarray, states: np.ndarray, turning: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the extents of states of motions: their ranges; of states that change by noise alone, their magnitudes.

    Parameters
    ----------
    ranges, states : ndarray, (n,) or (n, L)
        Over the whole run, and at its end.
    turning : ndarray of bool, (n,)
        True for angles.
    tolerance : float
        Of the integration.
    """
    return np.where(ranges > _noise(states, turning, tolerance), ranges, np.abs(states))


def _noise(states: np.ndarray, turning: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the noise of states (n, ...) after an integration, whose tolerance is relative to the largest one."""
    magnitudes = np.abs(states)
    largest = np.where(turning.reshape(-1, *[1] * (states.ndim - 1)), 0.0, magnitudes).max(axis=0)
    return np.asarray(tolerance * np.maximum(_NOISE * magnitudes, largest))


def rests(changes: np.ndarray, ranges: np.ndarray, states: np.ndarray, turning: np.ndarray, tolerance: float) -> np.ndarray:
    """True (...) for motions whose states (n, ...) have changed of late no more than an integration at rest changes them.

    changes: of late; the other parameters are those of ``state_extents``.
    """
    limits = max(_AT_REST, _NOISE * tolerance) * state_extents(ranges, states, turning, tolerance)
    noise = _noise(states, turning, tolerance)
    return np.asarray((changes <= np.where(ranges > noise, limits, np.maximum(limits, noise))).all(axis=0))


@dataclass(frozen=True)
class RestPoints:
    """Newton's method from many states of equations that do not depend on time. values: of the parameters."""

    jacobian: Jacobian
    values: Sequence[float]
    tolerance: float

    @classmethod
    def of(cls, subject: Subject, tolerance: float) -> Self:
        """Build it of equations that are integrated with a tolerance."""
        return cls(Jacobian.of(subject.system), subject.system.values(subject.values), tolerance)

    def newton_points(self, states: np.ndarray) -> np.ndarray:
        """Return where one step of Newton's method leads from states (n, L); not a number where there is no such step."""
        f, matrices, _ = self.jacobian(states, self.values)
        return np.asarray(states + _newton_steps(f, matrices))

    def times_of_rest(self, states: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """Return how long each of resting motions (L,) must rest before it is known to end there.

        That is 0 where disturbances do not grow, and infinite where no equilibrium is nearby. states, sizes: (n, L).
        """
        f, matrices, _ = self.jacobian(states, self.values)
        is_near = (np.abs(_newton_steps(f, matrices)) <= _nearby(self.tolerance) * sizes).all(axis=0)
        times = np.full(states.shape[1], np.inf)
        times[is_near] = [time_of_rest(e) for e in np.linalg.eigvals(np.moveaxis(matrices[:, :, is_near], -1, 0))]
        return times


def _newton_steps(f: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Return the steps (n, L) of Newton's method, of rates f (n, L) and their derivatives (n, n, L)."""
    steps = np.full(f.shape, np.nan)
    is_finite = np.isfinite(f).all(axis=0) & np.isfinite(matrices).all(axis=(0, 1))
    matrix_stack, rates = np.moveaxis(matrices[:, :, is_finite], -1, 0), f[:, is_finite].T[..., None]
    try:
        steps[:, is_finite] = -np.linalg.solve(matrix_stack, rates)[..., 0].T
    except np.linalg.LinAlgError:  # one of them is singular
        steps[:, is_finite] = -(np.linalg.pinv(matrix_stack) @ rates)[..., 0].T
    return steps


def _nearby(tolerance: float) -> float:
    return max(_NEARBY, _NOISES * _NOISE * tolerance)


def time_of_rest(eigenvalues: np.ndarray) -> float:
    """Return how long a motion must rest at an equilibrium before it is known to end there."""
    return 0.0 if decays(eigenvalues) is not False else _GROWTH_OF_ROUNDING / float(eigenvalues.real.max())


def equilibrium_near(
    subject: Subject, state: np.ndarray, metric: StateMetric, tolerance: float, time: float = 0.0
) -> LimitSet | None:
    """Return the equilibrium to which Newton's method leads from a state (n,), where it lies as near as a motion at rest is.

    Its eigenvalues: the one that grows fastest first. time: of its sample. The equations must not depend on time.
    """
    x, sizes = state.copy(), metric.sizes
    evaluate = Jacobian.of(subject.system).with_parameters(subject.system.values(subject.values))
    for _ in range(_NEWTON):
        f, matrix = evaluate(x)
        if not (np.isfinite(f).all() and np.isfinite(matrix).all()):
            return None
        step = _newton_step(f, matrix, sizes)
        x = x + step
        if (np.abs(step) <= _LAST_STEP * np.maximum(sizes, np.abs(x))).all():
            break
    if (np.abs(x - state) > _nearby(tolerance) * sizes).any():
        return None
    eigenvalues = np.linalg.eigvals(evaluate(x)[1])
    eigenvalues = eigenvalues[np.lexsort((-eigenvalues.imag, -eigenvalues.real))]
    kind, times = MotionKind.EQUILIBRIUM, np.array([time])
    return LimitSet(kind, times, x[:, None], metric, decays(eigenvalues), eigenvalues=eigenvalues)


def _newton_step(f: np.ndarray, matrix: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return np.asarray(-np.linalg.lstsq(matrix * sizes, f, rcond=None)[0] * sizes)


def decays(eigenvalues: np.ndarray) -> bool | None:
    """Return whether all disturbances of an equilibrium with these eigenvalues decay; None if the slowest neither grows nor
    decays."""
    return sign_of_growth(eigenvalues.real, _NEUTRAL * float(np.abs(eigenvalues).max(initial=0.0)))


def sign_of_growth(growth: np.ndarray, neutral: float) -> bool | None:
    """True if all disturbances decay, False if one grows, None if the slowest does neither."""
    largest = float(growth.max(initial=-np.inf))
    return True if largest < -neutral else False if largest > neutral else None
