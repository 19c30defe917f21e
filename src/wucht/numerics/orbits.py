"""Periodic motions of a System with rotating angles, and the multipliers that decide on their stability.

In a synchronous motion every angle advances, in one period, by a given number of turns, and all else repeats:
x(T) = x(0) + advance. Newton's method on this condition; the Jacobian (the monodromy matrix) comes from the variational
equations, which are built symbolically and integrated along, one column at a time.
U. M. Ascher, R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential
Equations", SIAM 1995, section 4.1; A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics", Wiley 1995, sections 3.2, 5.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator, Numbers
from wucht.numerics.flow.trajectory import Trajectory
from wucht.piecewise import PiecewiseCubic
from wucht.system import System

_SAMPLES = 64  # of one period: for the sizes of the states, and to see whether a jump is passed
_SINGULAR = 1e-9  # share of the largest singular value below which a direction leads along a family of periodic motions
_NEGLIGIBLE = 1e-8  # share of the largest state below which a state counts as at rest
_HALVINGS = 8


@dataclass(frozen=True)
class Orbit:
    """A periodic motion.

    state: (n,) at ``time``, angles within half a turn of zero. multipliers: (n,), complex, the largest first; a phase that
    nothing fixes and each direction of a family has one that is 1. monodromy: (n, n), d x(T) / d x(0). gap: (n,), what is left
    of x(T) - x(0) - advance: rounding, or the drift along directions that were left open. residual: the largest of it, each
    state by its own size.
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
            found: np.ndarray = np.log(self.multipliers.astype(complex)) / self.period
        return found

    def rest(self, trivial: int) -> np.ndarray:
        """The multipliers without those ``trivial`` ones that lie nearest to 1, the largest first."""
        nearest = np.argsort(np.abs(self.multipliers - 1), kind="stable")[:trivial]
        found: np.ndarray = np.delete(self.multipliers, nearest)
        return found

    def drift(self, trivial: int) -> np.ndarray:
        """What each state (n,) gains a period along the directions of the ``trivial`` multipliers, all else having decayed.

        That is the gap's part in their invariant subspace: a spectral projector commutes with the monodromy matrix.
        """
        values, vectors = np.linalg.eig(self.monodromy)
        slow = np.argsort(np.abs(values - 1), kind="stable")[:trivial]
        found: np.ndarray = (vectors[:, slow] @ np.linalg.solve(vectors, self.gap.astype(complex))[slow]).real
        return found


def periodic_orbit(
    flow: CompiledSystem,
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
) -> Orbit:
    """The periodic motion near a guess.

    guess: the state (n,) at ``time``. period: a guess too where it is free (an autonomous System), else the period itself.
    phase_state: the state that keeps its value of the guess; where the period is free one must, by default the first that
    advances; where it is given, say which if the equations do not know the time, else the nearest phase is found.
    advance: (n,), what each state gains in a period, 2 pi a turn for an angle, zero for what repeats. tolerance: the largest
    |x(T) - x(0) - advance| allowed, of the size of each state. engine: as for ``compile_system``, by default that of the flow.
    Where periodic motions form a family the nearest to the guess is found. left_open: how many directions of a family that
    something small breaks: there the motion may drift, and does not repeat exactly (``Orbit.gap``). Quadratures, outputs and
    events are left out.

    Raises ``WuchtError`` for a call that does not fit, where Newton's method does not converge (start nearer, as from the end
    of a long run), and where a piecewise function jumps on the way (there the variational equations do not hold).
    """
    problem = _Problem.of(
        flow, parameters, np.asarray(guess, float), float(period), np.asarray(advance, float), phase_state, time, engine
    )
    if free_period and phase_state is None:
        phase_state = problem.first_advancing()
    x, duration = problem.start(), float(period)
    end, monodromy, rate = problem.linearised(x, duration)
    sizes = problem.sizes(x, duration)
    for _ in range(most_steps):
        step, longer, seen = _newton_step(
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
    return Orbit(time, x, duration, problem.advance, multipliers[order], monodromy, gap, float(np.abs(gap / sizes).max()))


@lru_cache(maxsize=16)
def variational(system: System) -> System:
    """The System together with its linearisation: states (x, dx), d(dx)/dt = (df/dx) dx; no outputs, no quadratures."""
    along = {s: sp.Symbol(f"d[{s.name}]", real=True) for s in system.states}
    differentials: dict[sp.Symbol, sp.Expr] = dict(along)
    definitions: list[tuple[sp.Symbol, sp.Expr]] = []

    def tangent(expression: sp.Expr) -> sp.Expr:
        used = sorted(expression.free_symbols & differentials.keys(), key=lambda s: s.name)
        return sp.Add(*(sp.diff(expression, s) * differentials[s] for s in used))

    for symbol, expression in system.definitions:
        definitions.append((symbol, expression))
        change = tangent(sp.sympify(expression))
        if change != 0:
            differentials[symbol] = sp.Symbol(f"d[{symbol.name}]", real=True)
            definitions.append((differentials[symbol], change))
    rates = tuple(sp.sympify(d) for d in system.derivatives)
    changes = tuple(tangent(r) for r in rates)
    states = (*system.states, *along.values())
    return System(states, (*rates, *changes), system.parameters, tuple(definitions), angles=system.angles)


@dataclass(frozen=True)
class _Problem:
    """What stays the same in all steps."""

    flow: CompiledSystem
    both: CompiledSystem
    rates: Evaluator
    pars: np.ndarray
    guess: np.ndarray
    period: float
    advance: np.ndarray
    time: float

    @classmethod
    def of(
        cls,
        flow: CompiledSystem,
        parameters: Numbers | Mapping[str, float],
        guess: np.ndarray,
        period: float,
        advance: np.ndarray,
        phase_state: int | None,
        time: float,
        engine: str | None,
    ) -> _Problem:
        bare = replace(flow.system, outputs=(), quadratures=())
        n, chosen = len(bare.states), engine or flow.engine.name
        if guess.shape != (n,) or advance.shape != (n,) or not (np.isfinite(guess).all() and np.isfinite(advance).all()):
            raise WuchtError(f"a periodic motion of {n} states needs {n} finite numbers for its start and for its advance")
        if not (math.isfinite(period) and period > 0):
            raise WuchtError(f"the period of a periodic motion is positive, not {period}")
        if phase_state is not None and phase_state not in range(n):
            raise WuchtError(f"phase_state {phase_state} is no state: allowed is 0 to {n - 1}")
        pars = np.array(bare.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
        plain = compile_system(bare, flow.tolerance, (), chosen)
        both = compile_system(variational(bare), flow.tolerance, (), chosen)
        rates = Evaluator.of_rates(bare)
        return cls(plain, both, rates, pars, guess, period, advance, time)

    def first_advancing(self) -> int:
        advancing = np.flatnonzero(self.advance)
        if not len(advancing):
            raise WuchtError(
                "a periodic motion whose period is free needs phase_state, a state held at its start: no state advances"
            )
        return int(advancing[0])

    def start(self) -> np.ndarray:
        """The guess with its angles within half a turn of zero: the smaller the numbers, the smaller their rounding."""
        angles = np.array([s in self.flow.system.angles for s in self.flow.system.states])
        found: np.ndarray = np.where(angles, self.guess - 2 * np.pi * np.round(self.guess / (2 * np.pi)), self.guess)
        return found

    def sampled(self, x: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Times (N,) and states (n, N) over one period. Raises ``WuchtError`` where the integration fails."""
        run = self._arrived(integrate(self.flow, x, self.pars, self.time + np.linspace(0.0, duration, _SAMPLES + 1)))
        return run.time, run.states

    @staticmethod
    def _arrived(run: Trajectory) -> Trajectory:
        if run.interrupted:
            raise KeyboardInterrupt
        if run.failure is not None:
            raise WuchtError(f"no periodic motion was found: {run.failure}")
        return run

    def sizes(self, x: np.ndarray, duration: float) -> np.ndarray:
        """The size of each state over a period (n,): that of an angle that advances is 1, of a state at rest too."""
        size = np.abs(self.sampled(x, duration)[1]).max(axis=1)
        found: np.ndarray = np.where((size > _NEGLIGIBLE * size.max(initial=0.0)) & (self.advance == 0), size, 1.0)
        return found

    def end(self, x: np.ndarray, duration: float) -> np.ndarray:
        """x(T) (n,), not finite where the integration fails."""
        try:
            return self._arrived(integrate(self.flow, x, self.pars, self.time + np.array([0.0, duration]))).states[:, -1]
        except WuchtError:
            return np.full(len(x), np.inf)

    def linearised(self, x: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x(T) (n,), the monodromy matrix (n, n) and dx/dt at the end (n,)."""
        n = len(x)
        grid, matrix, end = self.time + np.array([0.0, duration]), np.empty((n, n)), x
        # The engines' errors are relative to the largest state: a column begins with the size of the states.
        size = float(np.abs(x).max(initial=0.0)) or 1.0
        for j in range(n):
            run = self._arrived(integrate(self.both, np.concatenate([x, size * np.eye(n)[j]]), self.pars, grid))
            end, matrix[:, j] = run.states[:n, -1], run.states[n:, -1] / size
        rate = self.rates(grid[-1:], end[:, None], self.pars)
        return end, matrix, np.array([rate[s.name][0] for s in self.flow.system.states])

    def missed(self, end: np.ndarray, x: np.ndarray, sizes: np.ndarray, seen: np.ndarray | None) -> float:
        """The largest |x(T) - x(0) - advance|, each state by its own size, as far as it is ``seen``: a projector (n, n)."""
        gap = (end - x - self.advance) / sizes
        return float(np.abs(gap if seen is None else seen @ gap).max())

    def damped(
        self, x: np.ndarray, duration: float, step: np.ndarray, longer: float, sizes: np.ndarray, seen: np.ndarray | None
    ) -> tuple[np.ndarray, float]:
        """The step, halved until it brings the motion nearer to a periodic one; the shortest one tried where none does."""

        def missed(at: np.ndarray, period: float) -> float:
            return self.missed(self.end(at, period), at, sizes, seen) if period > 0 else math.inf

        before, share = missed(x, duration), 1.0
        for _ in range(_HALVINGS):
            if missed(x + share * step, duration + share * longer) < before:
                break
            share /= 2
        return x + share * step, duration + share * longer

    def refuse_jumps(self, x: np.ndarray, duration: float) -> None:
        system = self.flow.system
        expressions = [*map(sp.sympify, system.derivatives), *(sp.sympify(e) for _, e in system.definitions)]
        jumping = sorted({p for e in expressions for p in e.atoms(PiecewiseCubic) if p.args[1].jumps()}, key=str)
        if not jumping:
            return
        times, states = self.sampled(x, duration)
        names = [str(k) for k in range(len(jumping))]
        arguments = Evaluator.of(system, [p.args[0] for p in jumping], names)(times, states, self.pars)
        for name, function in zip(names, jumping, strict=True):
            low, high = arguments[name].min(), arguments[name].max()
            if any(low <= corner <= high for corner in function.args[1].jumps()):
                raise WuchtError(
                    f"the periodic motion passes a jump of {function}: its multipliers are not defined by the equations"
                )


def _newton_step(
    gap: np.ndarray,
    monodromy: np.ndarray,
    rate: np.ndarray | None,
    held: int | None,
    sizes: np.ndarray,
    duration: float,
    left_open: int,
) -> tuple[np.ndarray, float, np.ndarray | None]:
    """What Newton's method adds to x (n,) and to T: of all that do, the step that is shortest in the states' sizes.

    Third what of the gap can be closed without the directions that are left open: a projector (n, n), None for all of it.
    """
    n = len(gap)
    free = [i for i in range(n) if i != held]
    columns = ((monodromy - np.eye(n)) * sizes[None, :] / sizes[:, None])[:, free]
    if rate is not None:
        columns = np.column_stack([columns, rate * duration / sizes])
    left, values, right = np.linalg.svd(columns, full_matrices=False)
    kept = int((values > _SINGULAR * values[0]).sum())
    kept = min(kept, len(values) - left_open)
    found = right[:kept].T @ (left[:, :kept].T @ (-gap / sizes) / values[:kept])
    step = np.zeros(n)
    step[free] = found[: len(free)] * sizes[free]
    longer = float(found[-1] * duration) if rate is not None else 0.0
    return step, longer, left[:, :kept] @ left[:, :kept].T if left_open else None
