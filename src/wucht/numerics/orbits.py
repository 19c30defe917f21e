"""Periodic motions of a System with rotating angles, and the multipliers that decide on their stability.

In a synchronous motion every angle advances, in one period, by a given number of turns, and all else repeats:
x(T) = x(0) + advance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.program import Numbers
from wucht.numerics.shooting import Shooting, newton_step

_TOLERANCE = 1e-10  # the largest |x(T) - x(0) - advance| allowed, relative to the size of each state


@dataclass(frozen=True)
class PeriodicOrbit:
    """A periodic motion.

    Attributes
    ----------
    time : float
        At which ``state`` holds, in the unit of the System's time.
    state : ndarray, (n,)
        Angles within half a turn of zero.
    period : float
        T, in the unit of time.
    advance : ndarray, (n,)
        What each state gains in a period.
    multipliers : ndarray of complex, (n,)
        Floquet multipliers, the largest first. A phase that nothing fixes and each direction of a family have one that is 1.
    monodromy : ndarray, (n, n)
        d x(T) / d x(0).
    gap : ndarray, (n,)
        What is left of x(T) - x(0) - advance: rounding, or the creep along directions that were left open.
    residual : float
        The largest of the gap, each state by its own size.
    """

    time: float
    state: np.ndarray
    period: float
    advance: np.ndarray
    multipliers: np.ndarray
    monodromy: np.ndarray
    gap: np.ndarray
    residual: float

    @property
    def exponents(self) -> np.ndarray:
        """The Floquet exponents ln(mu)/T (n,), the imaginary parts within half the orbit's frequency; -inf where mu = 0."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.multipliers.astype(complex)) / self.period)

    def nontrivial(self, trivial: int) -> np.ndarray:
        """The multipliers without those ``trivial`` ones that lie nearest to 1, the largest first."""
        nearest = np.argsort(np.abs(self.multipliers - 1), kind="stable")[:trivial]
        return np.delete(self.multipliers, nearest)

    def creep(self, trivial: int) -> np.ndarray:
        """What each state (n,) gains a period along the directions of the ``trivial`` multipliers, all else having decayed.

        That is the gap's part in their invariant subspace: a spectral projector commutes with the monodromy matrix.
        """
        values, vectors = np.linalg.eig(self.monodromy)
        neutral = np.argsort(np.abs(values - 1), kind="stable")[:trivial]
        return np.asarray((vectors[:, neutral] @ np.linalg.solve(vectors, self.gap.astype(complex))[neutral]).real)


def periodic_orbit(
    compiled: CompiledSystem,
    parameters: Numbers | Mapping[str, float],
    guess: Sequence[float] | np.ndarray,
    period: float,
    advance: Sequence[float] | np.ndarray,
    *,
    free_period: bool = True,
    phase_state: int | None = None,
    left_open: int = 0,
    time: float = 0.0,
    most_steps: int = 25,
) -> PeriodicOrbit:
    """The periodic motion near a guess, by single shooting: |x(T) - x(0) - advance| <= 1e-10 of the size of each state.

    Parameters
    ----------
    compiled : CompiledSystem
        n states; its quadratures, outputs and events are left out.
    parameters : sequence of float, or mapping by name
        The System's parameters.
    guess : array_like, (n,)
        The state at ``time``. Where periodic motions form a family the nearest to it is returned.
    period : float
        In the unit of time; a guess too where it is free (an autonomous System).
    advance : array_like, (n,)
        What each state gains in a period: 2 pi a turn for an angle, zero for what repeats.
    free_period : bool
        Whether the period is unknown.
    phase_state : int, optional
        The state that keeps its value of the guess. Where the period is free one must, by default the first that advances;
        where it is given, name one if the equations do not depend on time, else the nearest phase is returned.
    left_open : int
        How many directions of a family that a small term breaks: along them the motion may creep (``PeriodicOrbit.gap``).
    time : float
        At which the period begins.
    most_steps : int
        Of Newton's method.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    WuchtError
        Where the arguments do not fit, Newton's method does not converge (start nearer, as from the end of a long run), or a
        piecewise function jumps within the period (there the variational equations do not hold).
    """
    system, given, gains = compiled.system, np.asarray(guess, float), np.asarray(advance, float)
    n, duration = len(system.states), float(period)
    if given.shape != (n,) or gains.shape != (n,) or not np.isfinite([given, gains]).all():
        raise WuchtError(f"a periodic motion of {n} states needs {n} finite numbers for its start and for its advance")
    if not (math.isfinite(duration) and duration > 0):
        raise WuchtError(f"the period of a periodic motion is positive, not {duration}")
    if phase_state is not None and phase_state not in range(n):
        raise WuchtError(f"phase_state {phase_state} is no state: must be 0 to {n - 1}")
    if free_period and phase_state is None:
        if not gains.any():
            raise WuchtError(
                "a periodic motion whose period is free needs phase_state, a state held at its start: no state advances"
            )
        phase_state = int(np.flatnonzero(gains)[0])
    problem = Shooting.of(compiled, parameters, gains, time)
    # Angles are taken within half a turn of zero: the smaller the numbers, the smaller their rounding.
    angles = np.array([s in system.angles for s in system.states])
    x = np.where(angles, given - 2 * np.pi * np.round(given / (2 * np.pi)), given)
    end, monodromy, rate = problem.linearised(x, duration)
    sizes = problem.sizes(x, duration)
    for _ in range(most_steps):
        step, longer, seen = newton_step(
            end - x - gains, monodromy, rate if free_period else None, phase_state, sizes, duration, left_open
        )
        residual = problem.missed(end, x, sizes, seen)
        if residual <= _TOLERANCE:
            break
        x, duration = problem.damped(x, duration, step, longer, sizes, seen, residual)
        end, monodromy, rate = problem.linearised(x, duration)
    residual = problem.missed(end, x, sizes, seen)
    if not residual <= _TOLERANCE:
        raise WuchtError(
            f"no periodic motion was found: after {most_steps} steps of Newton's method {residual:.2g} is left open, "
            f"more than {_TOLERANCE:g}"
        )
    problem.refuse_jumps(x, duration)
    multipliers = np.linalg.eigvals(monodromy).astype(complex)
    order = np.lexsort((-multipliers.imag, -np.round(np.abs(multipliers), 14)))
    gap = end - x - gains
    return PeriodicOrbit(time, x, duration, gains, multipliers[order], monodromy, gap, float(np.abs(gap / sizes).max()))
