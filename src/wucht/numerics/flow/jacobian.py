"""System -> its right-hand side together with the exact Jacobian, as one program in machine code.

Forward differentiation through the System's definitions: each definition is differentiated once by each symbol in it
(``p``), and the chain rule adds products of symbols (``d``), so that no expression grows: A. Griewank, A. Walther, "Evaluating
Derivatives", SIAM 2008, section 3.1.

The variational equations govern small changes of a motion: A. H. Nayfeh, B. Balachandran, "Applied Nonlinear
Dynamics", Wiley 1995, sections 3.2, 5.2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.point_function import PointFunction, point_function
from wucht.numerics.flow.program import Numbers, Program, lower
from wucht.piecewise import PiecewiseCubic
from wucht.system import System, needed_definitions


@dataclass(frozen=True)
class Jacobian:
    """Functions f, df/dx and df/dp of a System; made by ``Jacobian.of``, called with states and parameters.

    Attributes
    ----------
    system : System
        With n states; its quadratures and outputs are left out.
    parameter_names : tuple of str
        The names of the k parameters p.
    program : Program
        Independent of the parameter values.
    places : tuple of (int, int)
        Row and column of each entry of (df/dx, df/dp) that is not identically zero.
    """

    system: System
    parameter_names: tuple[str, ...]
    program: Program
    places: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, system: System, parameter_names: Sequence[str] = ()) -> Jacobian:
        """Build the Jacobian of a System.

        Parameters
        ----------
        system : System
        parameter_names : sequence of str
            The names of the parameters p by which to differentiate as well.

        Raises
        ------
        WuchtError
            Where a name is none of the System's parameters.
        """
        unknown = [name for name in parameter_names if name not in system.parameter_names]
        if unknown:
            raise WuchtError(
                f"{unknown[0]} is not a parameter of this System; known: {', '.join(system.parameter_names)}",
                code="no-parameter",
            )
        directions = [*system.states, *(system.parameters[system.parameter_names.index(name)] for name in parameter_names)]
        n = len(system.states)
        rates = tuple(sp.sympify(d) for d in system.derivatives)
        tangent = Tangent({s: {j: sp.S.One} for j, s in enumerate(directions)}, needed_definitions(system.definitions, rates))
        entries = {(i, j): e for i, r in enumerate(rates) for j, e in tangent.of(r, f"f{i}").items() if e != 0}
        tangent_system = System(system.states, (sp.S.Zero,) * n, system.parameters, tuple(tangent.lines))
        return cls(system, tuple(parameter_names), lower(tangent_system, (*rates, *entries.values())), tuple(entries))

    @cached_property
    def _machine_code(self) -> PointFunction | None:
        """The program in machine code; None where it has piecewise functions."""
        expressions = [*(e for _, e in self.program.lines), *self.program.results]
        return None if any(e.has(PiecewiseCubic) for e in expressions) else point_function(self.program)

    @cached_property
    def _python_function(self) -> Callable[..., Any]:
        return self.program.function()

    def __call__(
        self, states: np.ndarray, parameter_values: Numbers, time: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Evaluate at many states.

        Parameters
        ----------
        states : ndarray, (n, N)
        parameters : sequence of float
            In the System's order.
        time : float

        Returns
        -------
        f : ndarray, (n, N)
        f_x : ndarray, (n, n, N)
        f_p : ndarray, (n, k, N)
            Not a number where the equations cannot be evaluated (a division by zero).
        """
        x, constants = np.ascontiguousarray(states, float), self.program.constant_values(parameter_values)
        shape = x.shape[1:]  # empty for one state, as from ``values_at``
        if self._machine_code is not None:
            numbers = self._machine_code(x, constants, time)
        else:
            with np.errstate(all="ignore"):
                values = self._python_function(tuple(x), time, constants)
            numbers = np.array([np.broadcast_to(np.asarray(v, float), shape) for v in values])
        n = len(self.system.states)
        numbers[~np.isfinite(numbers)] = np.nan
        whole = np.zeros((n, n + len(self.parameter_names), *shape))
        for (i, j), value in zip(self.places, numbers[n:], strict=True):
            whole[i, j] = value
        return numbers[:n].reshape((n, *shape)), whole[:, :n], whole[:, n:]

    def with_parameters(self, parameter_values: Numbers) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Return the function at fixed parameters and time 0, with the least work per call: x (n,) or (n, N) -> f and df/dx.

        Raises ``RunError`` where the equations cannot be evaluated at these parameters.
        """
        n, function = len(self.system.states), self._machine_code
        if function is None:
            return lambda x: self(x, parameter_values)[:2]
        constants = self.program.constant_values(parameter_values)
        flat = np.array([i * n + j for i, j in self.places], int)

        def values(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            shape, numbers = x.shape[1:], function(x, constants)
            matrix = np.zeros((n * n, *shape))
            matrix[flat] = numbers[n:]
            return numbers[:n], matrix.reshape(n, n, *shape)

        return values

    def values_at(
        self, state: Sequence[float] | np.ndarray, parameter_values: Numbers, time: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Evaluate f (n,), df/dx (n, n) and df/dp (n, k) at one state (n,)."""
        return self(np.asarray(state, float), parameter_values, time)


class Tangent:
    """Definitions together with those of their derivatives: forward differentiation along some directions.

    known_derivatives: d symbol / d direction where it is not zero, by the directions' numbers; at first of the independent
    symbols. lines: the definitions and their derivatives, in order.
    """

    def __init__(
        self, known_derivatives: dict[sp.Symbol, dict[int, sp.Expr]], definitions: Iterable[tuple[sp.Symbol, sp.Expr]]
    ) -> None:
        self.lines: list[tuple[sp.Symbol, sp.Expr]] = []
        self.known_derivatives = known_derivatives
        pairs = tuple(definitions)
        self._partial, self._total = _free_prefix("p", pairs), _free_prefix("d", pairs)
        for symbol, expression in pairs:
            self.lines.append((symbol, expression))
            derivatives = self.of(expression, symbol.name)
            if derivatives:
                known_derivatives[symbol] = {
                    j: self._name_expression(e, f"{self._total}[{symbol.name}][{j}]") for j, e in derivatives.items()
                }

    def of(self, expression: sp.Expr, label: str) -> dict[int, sp.Expr]:
        """Return the derivatives of an expression by the directions on which it depends."""
        terms: dict[int, list[sp.Expr]] = {}
        for symbol in sorted(expression.free_symbols & self.known_derivatives.keys(), key=lambda s: s.name):
            partial = self._name_expression(sp.diff(expression, symbol), f"{self._partial}[{label}][{symbol.name}]")
            for j, change in self.known_derivatives[symbol].items():
                terms.setdefault(j, []).append(partial * change)
        return {j: sp.Add(*products) for j, products in terms.items()}

    def _name_expression(self, expression: sp.Expr, name: str) -> sp.Expr:
        if expression.is_Atom:
            return expression
        symbol = sp.Symbol(name, real=True)
        self.lines.append((symbol, expression))
        return symbol


def _free_prefix(letter: str, definitions: Iterable[tuple[sp.Symbol, sp.Expr]]) -> str:
    """Return a prefix of names for derivatives: a letter, repeated until no definition begins with it."""
    names, prefix = [symbol.name for symbol, _ in definitions], letter
    while any(name.startswith(f"{prefix}[") for name in names):
        prefix += letter
    return prefix


@lru_cache(maxsize=16)
def variational_system(system: System, columns: int = 1) -> System:
    """Build the System together with its linearisation: states (x, dx_1, dx_2, ...), d(dx_j)/dt = (df/dx) dx_j.

    columns: the number of changes dx_j. It has no outputs and no quadratures.
    """
    moves = [[sp.Symbol(f"d[{s.name}][{j}]", real=True) for s in system.states] for j in range(columns)]
    rates = tuple(sp.sympify(d) for d in system.derivatives)
    definitions = [(symbol, sp.sympify(expression)) for symbol, expression in system.definitions]
    tangent = Tangent({s: {j: moves[j][i] for j in range(columns)} for i, s in enumerate(system.states)}, definitions)
    changes = [tangent.of(rate, f"f{i}") for i, rate in enumerate(rates)]
    further = tuple(change.get(j, sp.S.Zero) for j in range(columns) for change in changes)
    states = (*system.states, *(move for column in moves for move in column))
    return System(states, (*rates, *further), system.parameters, tuple(tangent.lines), angles=system.angles)
