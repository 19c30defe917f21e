"""Single shooting: Newton's method on x(T) = x(0) + advance.

The Jacobian (the monodromy matrix) comes from the variational equations, which are built symbolically and integrated along, one
column at a time.
U. M. Ascher, R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential
Equations", SIAM 1995, section 4.1; A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics", Wiley 1995, sections 3.2, 5.2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
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
class Shooting:
    """The boundary value problem: what stays the same in all steps of Newton's method."""

    compiled: CompiledSystem
    linearisation: CompiledSystem
    rates: Evaluator
    pars: np.ndarray
    guess: np.ndarray
    period: float
    advance: np.ndarray
    time: float

    @classmethod
    def of(
        cls,
        compiled: CompiledSystem,
        parameters: Numbers | Mapping[str, float],
        guess: np.ndarray,
        period: float,
        advance: np.ndarray,
        phase_state: int | None,
        time: float,
        engine: str | None,
    ) -> Shooting:
        """The problem, compiled. Raises ``WuchtError`` for arguments that do not fit."""
        bare = replace(compiled.system, outputs=(), quadratures=())
        n, chosen = len(bare.states), engine or compiled.engine.name
        if guess.shape != (n,) or advance.shape != (n,) or not (np.isfinite(guess).all() and np.isfinite(advance).all()):
            raise WuchtError(f"a periodic motion of {n} states needs {n} finite numbers for its start and for its advance")
        if not (math.isfinite(period) and period > 0):
            raise WuchtError(f"the period of a periodic motion is positive, not {period}")
        if phase_state is not None and phase_state not in range(n):
            raise WuchtError(f"phase_state {phase_state} is no state: allowed is 0 to {n - 1}")
        pars = np.array(bare.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
        plain = compile_system(bare, compiled.tolerance, (), chosen)
        linearisation = compile_system(variational(bare), compiled.tolerance, (), chosen)
        rates = Evaluator.of_rates(bare)
        return cls(plain, linearisation, rates, pars, guess, period, advance, time)

    def first_advancing(self) -> int:
        """The first state that advances. Raises ``WuchtError`` where none does."""
        advancing = np.flatnonzero(self.advance)
        if not len(advancing):
            raise WuchtError(
                "a periodic motion whose period is free needs phase_state, a state held at its start: no state advances"
            )
        return int(advancing[0])

    def start(self) -> np.ndarray:
        """The guess with its angles within half a turn of zero: the smaller the numbers, the smaller their rounding."""
        angles = np.array([s in self.compiled.system.angles for s in self.compiled.system.states])
        state: np.ndarray = np.where(angles, self.guess - 2 * np.pi * np.round(self.guess / (2 * np.pi)), self.guess)
        return state

    def sampled(self, x: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Times (N,) and states (n, N) over one period. Raises ``WuchtError`` where the integration fails."""
        run = self._arrived(integrate(self.compiled, x, self.pars, self.time + np.linspace(0.0, duration, _SAMPLES + 1)))
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
        sizes: np.ndarray = np.where((size > _NEGLIGIBLE * size.max(initial=0.0)) & (self.advance == 0), size, 1.0)
        return sizes

    def end(self, x: np.ndarray, duration: float) -> np.ndarray:
        """x(T) (n,), not finite where the integration fails."""
        try:
            return self._arrived(integrate(self.compiled, x, self.pars, self.time + np.array([0.0, duration]))).states[:, -1]
        except WuchtError:
            return np.full(len(x), np.inf)

    def linearised(self, x: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x(T) (n,), the monodromy matrix (n, n) and dx/dt at the end (n,)."""
        n = len(x)
        grid, matrix, end = self.time + np.array([0.0, duration]), np.empty((n, n)), x
        # The engines' errors are relative to the largest state: a column begins with the size of the states.
        size = float(np.abs(x).max(initial=0.0)) or 1.0
        for j in range(n):
            run = self._arrived(integrate(self.linearisation, np.concatenate([x, size * np.eye(n)[j]]), self.pars, grid))
            end, matrix[:, j] = run.states[:n, -1], run.states[n:, -1] / size
        rate = self.rates(grid[-1:], end[:, None], self.pars)
        return end, matrix, np.array([rate[s.name][0] for s in self.compiled.system.states])

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
        """Raises ``WuchtError`` where a piecewise function jumps within the period."""
        system = self.compiled.system
        expressions = [*map(sp.sympify, system.derivatives), *(sp.sympify(e) for _, e in system.definitions)]
        jumping = sorted({p for e in expressions for p in e.atoms(PiecewiseCubic) if p.args[1].jumps()}, key=str)
        if not jumping:
            return
        times, states = self.sampled(x, duration)
        names = [str(k) for k in range(len(jumping))]
        arguments = Evaluator.of(system, [p.args[0] for p in jumping], names)(times, states, self.pars)
        for name, function in zip(names, jumping, strict=True):
            low, high = arguments[name].min(), arguments[name].max()
            if any(low <= jump <= high for jump in function.args[1].jumps()):
                raise WuchtError(
                    f"the periodic motion passes a jump of {function}: its multipliers are not defined by the equations"
                )


def newton_step(
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
    rank = int((values > _SINGULAR * values[0]).sum())
    rank = min(rank, len(values) - left_open)
    solution = right[:rank].T @ (left[:, :rank].T @ (-gap / sizes) / values[:rank])
    step = np.zeros(n)
    step[free] = solution[: len(free)] * sizes[free]
    longer = float(solution[-1] * duration) if rate is not None else 0.0
    return step, longer, left[:, :rank] @ left[:, :rank].T if left_open else None
