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
from wucht.numerics.jacobian import Tangent
from wucht.piecewise import PiecewiseCubic
from wucht.system import System

_SAMPLES = 64  # of one period: for the sizes of the states, and to see whether a jump is passed
_SINGULAR = 1e-9  # share of the largest singular value below which a direction leads along a family of periodic motions
_NEGLIGIBLE = 1e-8  # share of the largest state below which a state counts as at rest
_HALVINGS = 8


@lru_cache(maxsize=16)
def variational(system: System, columns: int = 1) -> System:
    """The System together with its linearisation: states (x, dx_1, dx_2, ...), d(dx_j)/dt = (df/dx) dx_j.

    columns: how many changes dx_j are carried along. No outputs, no quadratures.
    """
    moves = [[sp.Symbol(f"d[{s.name}][{j}]", real=True) for s in system.states] for j in range(columns)]
    rates = tuple(sp.sympify(d) for d in system.derivatives)
    definitions = [(symbol, sp.sympify(expression)) for symbol, expression in system.definitions]
    tangent = Tangent({s: {j: moves[j][i] for j in range(columns)} for i, s in enumerate(system.states)}, definitions)
    changes = [tangent.of(rate, f"f{i}") for i, rate in enumerate(rates)]
    further = tuple(change.get(j, sp.S.Zero) for j in range(columns) for change in changes)
    states = (*system.states, *(move for column in moves for move in column))
    return System(states, (*rates, *further), system.parameters, tuple(tangent.lines), angles=system.angles)


@dataclass(frozen=True)
class Shooting:
    """The boundary value problem: what stays the same in all steps of Newton's method.

    plain, linearisation: the System, and its variational equations, compiled.
    """

    system: System
    plain: CompiledSystem
    linearisation: CompiledSystem
    parameters: np.ndarray
    advance: np.ndarray
    time: float

    @classmethod
    def of(
        cls, compiled: CompiledSystem, parameters: Numbers | Mapping[str, float], advance: np.ndarray, time: float
    ) -> Shooting:
        """The problem of a System without its outputs, quadratures and events."""
        bare = replace(compiled.system, outputs=(), quadratures=())
        both = (bare, variational(bare))
        plain, linearisation = (compile_system(s, compiled.tolerance, (), compiled.engine_name) for s in both)
        values = np.array(bare.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
        return cls(bare, plain, linearisation, values, advance, time)

    def _run(self, equations: CompiledSystem, x: np.ndarray, duration: float, count: int = 1) -> Trajectory:
        """From x over a period. Raises ``WuchtError`` where the integration fails."""
        grid = self.time + np.linspace(0.0, duration, count + 1)
        run = integrate(equations, x, self.parameters, grid).uninterrupted()
        if run.failure is not None:
            raise WuchtError(f"no periodic motion was found: {run.failure}")
        return run

    def sizes(self, x: np.ndarray, duration: float) -> np.ndarray:
        """The size of each state over a period (n,): that of an angle that advances is 1, of a state at rest too."""
        size = np.abs(self._run(self.plain, x, duration, _SAMPLES).states).max(axis=1)
        return np.where((size > _NEGLIGIBLE * size.max(initial=0.0)) & (self.advance == 0), size, 1.0)

    def linearised(self, x: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x(T) (n,), the monodromy matrix (n, n) and dx/dt at the end (n,)."""
        n, matrix, end = len(x), np.empty((len(x), len(x))), x
        # The engines' errors are relative to the largest state: a column begins with the size of the states.
        size = float(np.abs(x).max(initial=0.0)) or 1.0
        for j in range(n):
            last = self._run(self.linearisation, np.concatenate([x, size * np.eye(n)[j]]), duration).states[:, -1]
            end, matrix[:, j] = last[:n], last[n:] / size
        rate = Evaluator.of_rates(self.system).array(np.array([self.time + duration]), end[:, None], self.parameters)
        return end, matrix, rate[:, 0]

    def missed(self, end: np.ndarray, x: np.ndarray, sizes: np.ndarray, seen: np.ndarray | None) -> float:
        """The largest |x(T) - x(0) - advance|, each state by its own size, as far as it is ``seen``: a projector (n, n)."""
        gap = (end - x - self.advance) / sizes
        return float(np.abs(gap if seen is None else seen @ gap).max())

    def damped(
        self,
        x: np.ndarray,
        duration: float,
        step: np.ndarray,
        longer: float,
        sizes: np.ndarray,
        seen: np.ndarray | None,
        before: float,
    ) -> tuple[np.ndarray, float]:
        """The step, halved until less is missed than before; the shortest step tried where that never happens."""

        def missed(share: float) -> float:
            at, period = x + share * step, duration + share * longer
            try:
                return self.missed(self._run(self.plain, at, period).states[:, -1], at, sizes, seen) if period > 0 else math.inf
            except WuchtError:
                return math.inf

        share = 1.0
        for _ in range(_HALVINGS):
            if missed(share) < before:
                break
            share /= 2
        return x + share * step, duration + share * longer

    def refuse_jumps(self, x: np.ndarray, duration: float) -> None:
        """Raises ``WuchtError`` where a piecewise function jumps within the period."""
        expressions = [*self.system.derivatives, *(e for _, e in self.system.definitions)]
        functions = {p for e in expressions for p in sp.sympify(e).atoms(PiecewiseCubic) if p.args[1].jumps()}
        if not functions:
            return
        jumping = sorted(functions, key=str)
        run = self._run(self.plain, x, duration, _SAMPLES)
        evaluator = Evaluator.of(self.system, [p.args[0] for p in jumping], list(map(str, range(len(jumping)))))
        for function, argument in zip(jumping, evaluator.array(run.time, run.states, self.parameters), strict=True):
            if any(argument.min() <= jump <= argument.max() for jump in function.args[1].jumps()):
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
