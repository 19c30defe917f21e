"""Periodic motions of a System with rotating angles, and the multipliers that decide on their stability.

In a synchronous motion every angle advances, in one period, by a given number of turns, and all else repeats:
x(T) = x(0) + advance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.program import Numbers
from wucht.numerics.shooting import Shooting, newton_step


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
            exponents: np.ndarray = np.log(self.multipliers.astype(complex)) / self.period
        return exponents

    def nontrivial(self, trivial: int) -> np.ndarray:
        """The multipliers without those ``trivial`` ones that lie nearest to 1, the largest first."""
        nearest = np.argsort(np.abs(self.multipliers - 1), kind="stable")[:trivial]
        others: np.ndarray = np.delete(self.multipliers, nearest)
        return others

    def creep(self, trivial: int) -> np.ndarray:
        """What each state (n,) gains a period along the directions of the ``trivial`` multipliers, all else having decayed.

        That is the gap's part in their invariant subspace: a spectral projector commutes with the monodromy matrix.
        """
        values, vectors = np.linalg.eig(self.monodromy)
        neutral = np.argsort(np.abs(values - 1), kind="stable")[:trivial]
        creep: np.ndarray = (vectors[:, neutral] @ np.linalg.solve(vectors, self.gap.astype(complex))[neutral]).real
        return creep


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
    tolerance: float = 1e-10,
    most_steps: int = 25,
    engine: str | None = None,
) -> PeriodicOrbit:
    """The periodic motion near a guess, by single shooting.

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
    tolerance : float
        The largest |x(T) - x(0) - advance| allowed, relative to the size of each state.
    most_steps : int
        Of Newton's method.
    engine : str, optional
        As for ``compile_system``; by default that of ``compiled``.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    WuchtError
        Where the arguments do not fit, Newton's method does not converge (start nearer, as from the end of a long run), or a
        piecewise function jumps within the period (there the variational equations do not hold).
    """
    problem = Shooting.of(
        compiled, parameters, np.asarray(guess, float), float(period), np.asarray(advance, float), phase_state, time, engine
    )
    if free_period and phase_state is None:
        phase_state = problem.first_advancing()
    x, duration = problem.start(), float(period)
    end, monodromy, rate = problem.linearised(x, duration)
    sizes = problem.sizes(x, duration)
    for _ in range(most_steps):
        step, longer, seen = newton_step(
            end - x - problem.advance, monodromy, rate if free_period else None, phase_state, sizes, duration, left_open
        )
        if problem.missed(end, x, sizes, seen) <= tolerance:
            break
        x, duration = problem.damped(x, duration, step, longer, sizes, seen)
        end, monodromy, rate = problem.linearised(x, duration)
    residual = problem.missed(end, x, sizes, seen)
    if not residual <= tolerance:
        raise WuchtError(
            f"no periodic motion was found: after {most_steps} steps of Newton's method {residual:.2g} is left open, "
            f"allowed is {tolerance:g}"
        )
    problem.refuse_jumps(x, duration)
    multipliers = np.linalg.eigvals(monodromy).astype(complex)
    order = np.lexsort((-multipliers.imag, -np.round(np.abs(multipliers), 14)))
    gap = end - x - problem.advance
    return PeriodicOrbit(
        time, x, duration, problem.advance, multipliers[order], monodromy, gap, float(np.abs(gap / sizes).max())
    )
