"""Equations to be followed: F(X) = 0, n of n + 1 unknowns; and those of a System's equilibria, f(x, p) = 0, compiled once.

The vector of unknowns, X in formulas and ``unknowns`` in code, has the parameters p after the states x: X = (x, p).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import Any, Protocol

import numpy as np

from wucht.disk_cache import derived_once
from wucht.earlier_names import provide_earlier_names, with_earlier_names
from wucht.errors import RunError, WuchtError
from wucht.numerics.flow.jacobian import Jacobian
from wucht.system import System as System  # noqa: PLC0414 - re-exported

Residual = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""X (n+1,) -> F (n,), dF/dX (n, n+1)."""
Values = tuple[np.ndarray, np.ndarray]


@with_earlier_names
@dataclass(frozen=True, eq=False)
class CurvePoint:
    """A solution on a curve.

    Attributes
    ----------
    unknowns : ndarray, (n+1,)
        The unknowns, parameters last.
    tangent : ndarray, (n+1,)
        du/ds, s being the arclength.
    jacobian : ndarray, (n, n+1)
        dF/dX, or another object in which the problem stores it.
    length : float
        The arclength s.
    orientation : int
        Sign of the determinant of dF/dX with the tangent as its last row; 0 where it is not computed.
    bend : ndarray, (n+1,), or None
        About d^2X/ds^2, where the previous point is known.
    """

    unknowns: np.ndarray
    tangent: np.ndarray
    jacobian: Any
    length: float
    orientation: int
    bend: np.ndarray | None = None


class Problem(Protocol):
    """F(X) = 0 in the form that ``Curve`` needs: functions of the unknowns alone.

    scale (n+1,): a typical large change of each unknown: the unit of arclength.
    """

    @property
    def scale(self) -> np.ndarray: ...  # noqa: D102

    def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, Any]:
        """Evaluate F (n,) and its Jacobian."""

    def solution(self, jacobian: Any, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
        """Solve [jacobian; row] x = sides (n+1, k); return also the determinant's sign. Raises ``RunError`` if singular."""

    def reformulate(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """Return the equations in the form best suited near a point, and the point in that form."""

    def outline(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return numbers that identify a solution, in units of their scale, and the period of those on a circle."""


def bordered_solution(jacobian: np.ndarray, row: np.ndarray, sides: np.ndarray) -> tuple[np.ndarray, int]:
    """Solve the bordered equations of ``Problem.solution`` for a Jacobian that is a full matrix."""
    from scipy.linalg.lapack import dgesv

    matrix = np.empty((len(row), len(row)), order="F")
    matrix[:-1], matrix[-1] = jacobian, row
    factors, pivots, solution, info = dgesv(matrix, sides, overwrite_a=1)
    if info:
        raise RunError("the equations are singular here")
    changes = 0  # counted by hand: for a few unknowns three times as fast as arrays
    for i, (pivot, swap) in enumerate(zip(factors.diagonal().tolist(), pivots.tolist(), strict=True)):
        changes += (pivot < 0) != (swap != i)
    return solution, -1 if changes % 2 else 1


@dataclass(frozen=True, eq=False)
class FunctionProblem:
    """Equations F(X) = 0 of n + 1 unknowns, given as a function, for ``Curve``.

    Parameters
    ----------
    function : callable
        X (n+1,) -> F (n,), dF/dX (n, n+1).
    scale : ndarray, (n+1,)
        A typical large change of each unknown.
    turns : ndarray, (n+1,), optional
        The period of unknowns that are angles, 0 of others.
    solution : callable, optional
        Solves the bordered linear equations [dF/dX; row] x = sides, as ``bordered_solution``, where dF/dX is no full matrix.
    """

    function: Residual
    scale: np.ndarray
    turns: np.ndarray | None = None
    solution: Callable[[Any, np.ndarray, np.ndarray], tuple[np.ndarray, int]] = field(default=bordered_solution, repr=False)

    def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Evaluate F and its Jacobian: see ``Problem``."""
        return self.function(unknowns)

    def reformulate(self, point: CurvePoint) -> tuple[Problem, CurvePoint]:
        """Return the problem and the point unchanged: see ``Problem``."""
        return self, point

    def outline(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns as outline: see ``Problem``."""
        return unknowns / self.scale, np.zeros(len(unknowns)) if self.turns is None else self.turns / self.scale


@with_earlier_names
@dataclass(frozen=True, eq=False)
class EquilibriumEquations:
    """Equations f = 0 of n states and of the m parameters that are varied.

    They are built from a System by ``from_system``, or from a function by ``from_function``.

    Attributes
    ----------
    values : callable
        X = (x, p) (n+m,) or (n+m, N) -> f (n,) or (n, N), df/dX (n, n+m) or (n, n+m, N).
    state_names, parameter_names : tuple of str
        Of the states, and of the varied parameters, in order.
    turns : ndarray, (n+m,)
        2 pi of states that are angles, 0 of others.
    scale : ndarray, (n+m,)
        A typical large change of each.
    """

    values: Callable[[np.ndarray], Values]
    state_names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    turns: np.ndarray
    scale: np.ndarray

    @classmethod
    def from_system(
        cls,
        system: System,
        parameter_names: Sequence[str],
        fixed_values: Mapping[str, float],
        scale: Mapping[str, float] | None = None,
    ) -> EquilibriumEquations:
        """Build the equations of a System's equilibria.

        Parameters
        ----------
        system : System
            Its outputs and quadratures are left out.
        parameter_names : sequence of str
            Of the parameters that change along a branch.
        fixed_values : mapping
            Values of all other parameters.
        scale : mapping, optional
            A typical large change of states and varied parameters, by name; 1 where none is given.

        Returns
        -------
        EquilibriumEquations

        Raises
        ------
        WuchtError
            For a name that is no parameter, a parameter without a value or varied twice, a size that is not positive,
            equations that depend on time, a System without states.
        """
        names, n, m = system.parameter_names, len(system.states), len(parameter_names)
        if not n:
            raise WuchtError("a System without states has no equilibria", code="no-states")
        if twice := [name for name in parameter_names if parameter_names.count(name) > 1]:
            raise WuchtError(f"the parameter {twice[0]} is varied twice: give each name once", code="given-twice")
        for name in (*parameter_names, *(scale or {})):
            if name not in names and not (name in system.state_names and name not in parameter_names):
                raise WuchtError(f"{name} is none of the parameters: {', '.join(names)}", code="no-parameter")
        missing = [name for name in names if name not in parameter_names and name not in fixed_values]
        if missing:
            raise WuchtError(f"the parameter {missing[0]} has no value: give one to each that is not varied", code="no-value")
        if system.depends_on_time:
            raise WuchtError(
                "these equations depend on time: they have no equilibria, only periodic orbits", code="time-dependent"
            )
        symbols = tuple(system.parameters[names.index(name)] for name in parameter_names)
        fixed_symbols = tuple(p for p in system.parameters if p not in symbols)
        # A varied parameter is a constant state: one compiled function then gives f and all its derivatives.
        extended_system = System(
            (*system.states, *symbols), (*system.derivatives, *(0,) * m), fixed_symbols, system.definitions
        )
        values = _SystemValues(extended_system, tuple(fixed_values[p.name] for p in fixed_symbols), n)
        turns = np.array([2 * math.pi if s in system.angles else 0.0 for s in system.states] + [0.0] * m)
        return cls(
            values, system.state_names, tuple(parameter_names), turns, _sizes((*system.state_names, *parameter_names), scale)
        )

    @classmethod
    def from_function(
        cls,
        values: Callable[[np.ndarray], Values],
        state_names: Sequence[str],
        parameter_names: Sequence[str],
        scale: Mapping[str, float] | None = None,
        angles: Sequence[str] = (),
    ) -> EquilibriumEquations:
        """Build equations from a function.

        Parameters
        ----------
        values : callable
            Function of the unknowns X = (x, p) (n+m,) that returns f (n,) and df/dX (n, n+m).
        state_names, parameter_names : sequence of str
            Names of the states and of the varied parameters, in the order of X.
        scale : mapping, optional
            A typical large change of each, by name; 1 where none is given.
        angles : sequence of str
            Names of the states that are angles.

        Returns
        -------
        EquilibriumEquations

        Raises
        ------
        WuchtError
            For a name that is none of the states and parameters, or a size that is not positive.
        """
        names = (*state_names, *parameter_names)
        for name in (*(scale or {}), *angles):
            if name not in names:
                raise WuchtError(f"{name} is none of the states and parameters: {', '.join(names)}", code="unknown-name")
        turns = np.array([2 * math.pi if name in angles else 0.0 for name in names])
        return cls(partial(_values_of_points, values), tuple(state_names), tuple(parameter_names), turns, _sizes(names, scale))

    def with_scale(self, scale: np.ndarray) -> EquilibriumEquations:
        """Return the equations with another scale of states and parameters (n+m,). Raises ``WuchtError`` if not positive."""
        sizes = dict(zip(self.names, np.asarray(scale, float).tolist(), strict=True))
        return replace(self, scale=_sizes(self.names, sizes))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of states and parameters (n+m,)."""
        return (*self.state_names, *self.parameter_names)

    @property
    def n(self) -> int:
        """Number of states."""
        return len(self.state_names)


def _sizes(names: Sequence[str], scale: Mapping[str, float] | None) -> np.ndarray:
    for name, size in (scale or {}).items():
        if not 0 < size < math.inf:
            raise WuchtError(
                f"the scale of {name} is {size:g}: it must be a positive number, the size of a typical large change",
                code="scale",
            )
    return np.array([(scale or {}).get(name, 1.0) for name in names])


@dataclass(frozen=True, eq=False)
class _SystemValues:
    """Values f (n,) of a System and derivatives, compiled when first called.

    extended_system: with the varied parameters as last states, which are constant.
    """

    extended_system: System
    fixed_values: tuple[float, ...]
    n: int

    @cached_property
    def _function(self) -> Callable[[np.ndarray], Values]:
        return _jacobian(self.extended_system).with_parameters(self.fixed_values)

    def __call__(self, unknowns: np.ndarray) -> Values:
        f, derivatives = self._function(unknowns)
        return f[: self.n], derivatives[: self.n]

    def __reduce__(self) -> tuple[type[_SystemValues], tuple[System, tuple[float, ...], int]]:
        return type(self), (self.extended_system, self.fixed_values, self.n)  # compiled code is not pickled


def _values_of_points(values: Callable[[np.ndarray], Values], unknowns: np.ndarray) -> Values:
    """Call a function of one vector of unknowns with one or with several."""
    if unknowns.ndim == 1:
        return values(unknowns)
    f, derivatives = zip(*map(values, unknowns.T), strict=True)
    return np.stack(f, axis=-1), np.stack(derivatives, axis=-1)


@lru_cache(maxsize=64)
@derived_once
def _jacobian(system: System) -> Jacobian:
    return Jacobian.of(system)


provide_earlier_names(__name__)
