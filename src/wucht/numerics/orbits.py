"""Periodic motions of a System with rotating angles, and the multipliers that decide on their stability.

In a synchronous motion every angle advances, in one period, by a given number of turns, and all else repeats:
x(T) = x(0) + advance. From nearby it is computed by Newton's method on integrated motions (``exact_orbits``); from farther
away, and where it is very unstable, by collocation first (``closing``). It may be one of a family (``families``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
import sympy as sp

from wucht.errors import RunError, WuchtError
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator, Numbers
from wucht.numerics.periodic.closing import ClosedOrbit, Closing, close_orbit
from wucht.numerics.periodic.exact_orbits import ExactOrbit, exact_orbit, finer_linearisation
from wucht.numerics.periodic.floquet import logarithms, transverse_maps
from wucht.piecewise import PiecewiseCubic
from wucht.system import System

_TOLERANCE = 1e-10  # the largest |x(T) - x(0) - advance| allowed, relative to the size of each state
_FEW_SAMPLES, _MANY_SAMPLES = 64, 2048  # of one period: for sizes and jumps, for collocation
_FEW_LEGS, _MANY_LEGS = 1, 32  # of a period, integrated separately: of a run, of samples
_NEARLY = 1e-4  # of the states' sizes: an orbit with a smaller gap is nearly converged
_REST_SHARE = 1e-3  # of its size in the guess: a state that is smaller on the orbit is at rest there
_NEGLIGIBLE = 1e-8  # share of the largest state below which a state counts as at rest
_AT_REST = 1e-9  # of the states' sizes: a motion of less in a period has no phase


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
        The gain of each state in a period.
    logarithms : ndarray of complex, (n,)
        ln mu of the Floquet multipliers, the largest first, the imaginary parts within pi: right where mu is tiny or huge.
    monodromy : ndarray, (n, n)
        d x(T) / d x(0).
    gap : ndarray, (n,)
        x(T) - x(0) - advance in the directions in which no change of x(0) or T closes the motion: rounding, or the creep along
        directions that were left open.
    residual : float
        The largest of the gap, and of the error elsewhere, each state relative to its size.
    """

    time: float
    state: np.ndarray
    period: float
    advance: np.ndarray
    logarithms: np.ndarray
    monodromy: np.ndarray
    gap: np.ndarray
    residual: float

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers (n,), the largest first. A free phase and each direction of a family have one that is 1."""
        return np.asarray(np.exp(self.logarithms))

    @property
    def exponents(self) -> np.ndarray:
        """Floquet exponents ln(mu)/T (n,), the imaginary parts within half the orbit's frequency; -inf where mu = 0."""
        return np.asarray(self.logarithms / self.period)

    def nontrivial(self, trivial: int) -> np.ndarray:
        """Return the multipliers without those ``trivial`` ones that lie nearest to 1, the largest first."""
        return np.asarray(np.exp(self.nontrivial_logarithms(trivial)))

    def nontrivial_logarithms(self, trivial: int) -> np.ndarray:
        """Return ln mu of the same multipliers."""
        nearest = np.argsort(np.abs(np.expm1(self.logarithms)), kind="stable")[:trivial]
        return np.delete(self.logarithms, nearest)

    def creep(self, trivial: int) -> np.ndarray:
        """Return the gain of each state (n,) per period along the directions of the ``trivial`` multipliers, in the long run.

        That is the gap's part in their invariant subspace: a spectral projector commutes with the monodromy matrix.
        """
        values, vectors = np.linalg.eig(self.monodromy)
        neutral = np.argsort(np.abs(values - 1), kind="stable")[:trivial]
        return np.asarray((vectors[:, neutral] @ np.linalg.solve(vectors, self.gap.astype(complex))[neutral]).real)


def periodic_orbit(
    compiled_system: CompiledSystem,
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
    """Solve for the periodic motion near a guess, to |x(T) - x(0) - advance| <= 1e-10 of the size of each state.

    Parameters
    ----------
    compiled_system : CompiledSystem
        n states; its quadratures, outputs and events are left out.
    parameters : sequence of float, or mapping by name
        The System's parameters.
    guess : array_like, (n,) or (n, K)
        The state at ``time``, or those of a whole period at K evenly spaced times from its beginning to its end: for a motion
        so unstable that a run departs from it within a period. Where periodic motions form a family the nearest is returned.
    period : float
        In the unit of time; a guess too where it is free (an autonomous System).
    advance : array_like, (n,)
        The gain of each state in a period: 2 pi per turn of an angle, zero for states that repeat.
    free_period : bool
        True if the period is unknown.
    phase_state : int, optional
        The state that keeps its value of the guess. Where the period is free one must, by default the first that advances;
        where it is given, name one if the equations do not depend on time, else the nearest phase is returned.
    left_open : int
        The number of directions of a family that a small term breaks: along them the motion may creep: x(T) - x(0) - advance
        is the sum of s_i l_i, the l_i those directions of its left side that no change of x(0) and T reaches. It is returned
        as ``PeriodicOrbit.gap``, and its long-run effect as ``PeriodicOrbit.creep``.
    time : float
        At which the period begins.
    most_steps : int
        Of Newton's method, at most.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    WuchtError
        Where the arguments do not fit, Newton's method does not converge (start nearer, as from the end of a long run), the
        period is free but the equations depend on time, or a piecewise function jumps within the period (there the variational
        equations do not hold).
    """
    gains, duration, guess_states = np.asarray(advance, float), float(period), np.asarray(guess, float)
    samples = guess_states if guess_states.ndim == 2 and guess_states.shape[1] > 1 else guess_states.reshape(-1, 1)
    phase_states = _phase_states(compiled_system.system, samples, duration, gains, free_period, phase_state)
    bare = replace(compiled_system.system, outputs=(), quadratures=())
    plain = compile_system(bare, compiled_system.tolerance, (), compiled_system.engine_name)
    values = np.array(bare.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
    # Angles are taken within half a turn of zero: the smaller the numbers, the smaller their rounding.
    angles = np.array([s in bare.angles for s in bare.states])
    samples = samples - np.where(angles, 2 * np.pi * np.round(samples[:, 0] / (2 * np.pi)), 0.0)[:, None]
    equations = _Equations(plain, values, time)
    motion = samples if samples.shape[1] > 1 else equations.run(samples[:, 0], duration, _FEW_SAMPLES)
    closing = Closing(gains, _sizes(motion, gains), motion[:, 0], duration, phase_states, free_period, left_open)
    try:
        orbit, closing = equations.close_orbit(samples, motion, closing, most_steps)
    except RunError as error:
        equations.refuse_jumps(motion, duration)
        raise RunError(f"no periodic motion could be computed: {error}", code="no-convergence") from None
    equations.refuse_jumps(equations.run(orbit.states[:, 0], orbit.period, _FEW_SAMPLES), orbit.period)
    residual = max(orbit.residual, closing.gap_size(orbit.gap))
    if not (orbit.residual <= _TOLERANCE and (left_open or residual <= _TOLERANCE)):
        raise WuchtError(
            f"no periodic motion could be computed: after {most_steps} steps of Newton's method the residual is "
            f"{residual:.2g}, more than {_TOLERANCE:g}",
            code="too-many-steps",
        )
    logs = equations.multipliers(orbit, closing, residual <= _TOLERANCE)
    monodromy = (
        reduce(lambda whole, leg_map: leg_map @ whole, orbit.linearisation.maps) * closing.sizes[:, None] / closing.sizes
    )
    return PeriodicOrbit(time, orbit.states[:, 0], orbit.period, gains, logs, monodromy, orbit.gap, residual)


def _phase_states(
    system: System, samples: np.ndarray, period: float, advance: np.ndarray, free_period: bool, phase_state: int | None
) -> tuple[int, ...]:
    """Return the states that keep their values of the guess. Raises ``WuchtError`` where the arguments do not fit."""
    n = len(system.states)
    if len(samples) != n or advance.shape != (n,) or not (np.isfinite(samples).all() and np.isfinite(advance).all()):
        raise WuchtError(
            f"a periodic motion of {n} states needs {n} finite numbers for its start, and as many for its advance over a "
            "period",
            code="shape",
        )
    if not (math.isfinite(period) and period > 0):
        raise WuchtError(f"the period of a periodic motion must be positive, not {period}", code="period")
    if phase_state is not None and phase_state not in range(n):
        raise WuchtError(f"phase_state {phase_state} is not a state: it must be 0 to {n - 1}", code="no-state")
    if free_period and system.depends_on_time:
        raise WuchtError(
            "the period of a periodic motion is free, but the equations depend on time: give the period", code="time-dependent"
        )
    if phase_state is not None or not free_period:
        return () if phase_state is None else (phase_state,)
    if not advance.any():
        raise WuchtError(
            "a periodic motion with a free period needs phase_state, a state with a fixed start value: no state advances",
            code="phase-state",
        )
    return (int(np.flatnonzero(advance)[0]),)


def _sizes(states: np.ndarray, advance: np.ndarray) -> np.ndarray:
    """Return the size of each state over a period (n,): 1 for an angle that advances and for a state at rest."""
    size = np.abs(states).max(axis=1)
    return np.where((size > _NEGLIGIBLE * size.max(initial=0.0)) & (advance == 0), size, 1.0)


@dataclass(frozen=True)
class _Equations:
    """A System without outputs and quadratures, its parameters, and the time at which the orbit begins."""

    plain: CompiledSystem
    parameter_values: np.ndarray
    time: float

    def run(self, x: np.ndarray, duration: float, count: int) -> np.ndarray:
        """Integrate states (n, count + 1) from x over a period. Raises ``RunError`` where the integration fails."""
        run = integrate(
            self.plain, x, self.parameter_values, self.time + np.linspace(0.0, duration, count + 1)
        ).reraise_interrupt()
        if run.failure is not None:
            raise RunError(f"no periodic motion could be computed: {run.failure}")
        return run.states

    def close_orbit(
        self, samples: np.ndarray, motion: np.ndarray, closing: Closing, most_steps: int
    ) -> tuple[ExactOrbit, Closing]:
        """Close the orbit near a motion, by integration alone where that suffices, else by collocation first; with its sizes.

        samples (n, K): as given, of a period or the start alone. motion (n, K'): of a period.
        """
        alone, last = samples.shape[1] == 1, motion.shape[1] - 1
        legs = np.linspace(0, last, min(_FEW_LEGS if alone else _MANY_LEGS, last) + 1).round().astype(int)
        with suppress(RunError):
            orbit, orbit_closing = self._exact(ClosedOrbit(closing.period, legs / last, motion[:, legs]), closing, most_steps)
            if orbit.residual <= _TOLERANCE:
                return orbit, orbit_closing
        if alone:
            motion = self.run(samples[:, 0], closing.period, _MANY_SAMPLES)
        try:
            near = close_orbit(self.plain.system, self.parameter_values, self.time, motion, closing, most_steps)
        except RunError:  # a motion that is deformed until it is closed may lie nearer
            closure_gap = motion[:, -1] - motion[:, 0] - closing.advance
            bent_motion = motion - closure_gap[:, None] * np.linspace(0.0, 1.0, motion.shape[1])
            near = close_orbit(self.plain.system, self.parameter_values, self.time, bent_motion, closing, most_steps)
        return self._exact(near, closing, most_steps)

    def _exact(self, near: ClosedOrbit, closing: Closing, most_steps: int) -> tuple[ExactOrbit, Closing]:
        """Close the orbit by integration. A state that is at rest on the orbit but not in the guess gets its size there."""
        orbit = exact_orbit(self.plain, self.parameter_values, self.time, near, closing, _TOLERANCE, most_steps)
        if _TOLERANCE < orbit.residual < _NEARLY:
            legs = len(orbit.times) - 1
            motion = self.run(orbit.states[:, 0], orbit.period, _FEW_SAMPLES) if legs == 1 else orbit.states
            is_at_rest = np.abs(motion).max(axis=1) < _REST_SHARE * closing.sizes
            orbit_closing = replace(closing, sizes=np.where(is_at_rest, 1.0, closing.sizes))
            again = ClosedOrbit(
                orbit.period, orbit.times, np.column_stack([orbit.states, orbit.states[:, 0] + closing.advance])
            )
            return exact_orbit(
                self.plain, self.parameter_values, self.time, again, orbit_closing, _TOLERANCE, most_steps
            ), orbit_closing
        return orbit, closing

    def multipliers(self, orbit: ExactOrbit, closing: Closing, repeats: bool) -> np.ndarray:
        """Return ln mu (n,), the largest first. repeats: true if the orbit is closed, so that a free phase has mu = 1."""
        maps, flow = finer_linearisation(self.plain, self.parameter_values, self.time, orbit, closing.sizes)
        moves = np.linalg.norm(flow, axis=1).min() * orbit.period > _AT_REST
        if repeats and moves and not self.plain.system.depends_on_time:
            logs = np.append(logarithms(transverse_maps(maps, flow)[0])[0], 0.0)
        else:
            logs = logarithms(maps)[0]
        return logs[np.lexsort((-logs.imag, -np.round(logs.real, 12)))]

    def refuse_jumps(self, motion: np.ndarray, duration: float) -> None:
        """Raise ``WuchtError`` where a piecewise function jumps within a period: states (n, K), evenly spaced."""
        system = self.plain.system
        expressions = [*system.derivatives, *(e for _, e in system.definitions)]
        functions = {p for e in expressions for p in sp.sympify(e).atoms(PiecewiseCubic) if p.args[1].jumps()}
        if not functions:
            return
        jumping = sorted(functions, key=str)
        evaluator = Evaluator.of(system, [p.args[0] for p in jumping], list(map(str, range(len(jumping)))))
        times = self.time + np.linspace(0.0, duration, motion.shape[1])
        for function, argument in zip(jumping, evaluator.array(times, motion, self.parameter_values), strict=True):
            if any(argument.min() <= jump <= argument.max() for jump in function.args[1].jumps()):
                raise WuchtError(
                    f"the periodic motion passes a jump of {function}: its multipliers are not defined by the equations",
                    code="jump",
                )
