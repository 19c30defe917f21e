"""``System``, which all layers exchange: a first-order ordinary differential equation with names, units and meaning.

A System is symbolic and complete: states, right-hand side, parameters, the named intermediate results that keep the right-hand
side small, outputs, quadratures, and which states are angles. It holds no number.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy as sp

from wucht.errors import WuchtError
from wucht.function_call import CalledRate, PythonCall, called_rates
from wucht.function_trace import traced_rates
from wucht.piecewise import with_located_kinks

TIME = sp.Symbol("t", real=True)


@dataclass(frozen=True)
class Output:
    """A quantity that can be computed from the states.

    Parameters
    ----------
    name : str
    expression : sympy.Expr
        Expression in the System's states, parameters, definitions and time.
    unit : str
    long_name : str
        The label on an axis.
    jump : sympy.Expr
        Of a quadrature: its integral increases by the difference of this expression where a piecewise function jumps.
    """

    name: str
    expression: sp.Expr
    unit: str = ""
    long_name: str = ""
    jump: sp.Expr = sp.S.Zero


@dataclass(frozen=True)
class SecondOrder:
    """The mechanical form ``mass * d2(coordinates)/dt2 = forces`` from which a System was made.

    Parameters
    ----------
    coordinates, velocities : tuple of sympy.Symbol, n
    mass : sympy.ImmutableMatrix, n x n
        Symmetric.
    forces : sympy.ImmutableMatrix, n x 1
    driven : tuple of sympy.Symbol
        Coordinates whose motion is prescribed: their rows hold, and give the torque that enforces the motion.
    """

    coordinates: tuple[sp.Symbol, ...]
    velocities: tuple[sp.Symbol, ...]
    mass: sp.ImmutableMatrix
    forces: sp.ImmutableMatrix
    driven: tuple[sp.Symbol, ...] = ()


@dataclass(frozen=True)
class System:
    """``d states / dt = derivatives(states, parameters, t)``.

    Parameters
    ----------
    states : tuple of sympy.Symbol, n
    derivatives : tuple of sympy.Expr, n
    parameters : tuple of sympy.Symbol
        Symbols of the numbers that a run is given; another value never recompiles.
    definitions : tuple of (sympy.Symbol, sympy.Expr)
        Evaluated in order; each may use those before it.
    outputs : tuple of Output
    quadratures : tuple of Output
        Quantities whose integral over time a run also computes (the work of the motor, the dissipated energy).
    angles : frozenset of sympy.Symbol
        The states that are angles.
    second_order : SecondOrder, optional
        The mechanical form, which two equal Systems need not share.

    Raises
    ------
    WuchtError
        Where an expression uses another symbol, one is defined twice, or a name has two meanings: states and parameters,
        outputs and quadratures are identified by their names.
    """

    states: tuple[sp.Symbol, ...]
    derivatives: tuple[sp.Expr, ...]
    parameters: tuple[sp.Symbol, ...] = ()
    definitions: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()
    outputs: tuple[Output, ...] = ()
    quadratures: tuple[Output, ...] = ()
    angles: frozenset[sp.Symbol] = frozenset()
    second_order: SecondOrder | None = field(default=None, compare=False)

    @classmethod
    def from_function(
        cls, function: Callable[..., Any], states: Sequence[str], parameters: Iterable[str] = (), *, angles: Iterable[str] = ()
    ) -> System:
        """Write a Python function f(t, x, p) as formulas: it is called once, with symbols in the place of numbers.

        One that asks for a number, by a branch, ``math.sin`` or a function of SciPy, has no formulas: it is kept, and called at
        each stage of each step of an integration.

        Parameters
        ----------
        function : callable
            Of the time, the states and the parameters, both arrays in the order of their names; it returns the derivatives of
            the states. Arithmetic, matrix products, functions of NumPy and SymPy, ``np.where(x[0] > 0, a, b)``. Kinks and jumps
            of ``abs``, ``sign``, ``maximum``, ``minimum`` and ``where`` are located exactly in each run.
        states : sequence of str
        parameters : iterable of str
            Names, or a mapping by name: a System holds no values. What else the function uses keeps the value of the call.
        angles : iterable of str
            The states that are angles.

        Returns
        -------
        System
            As if its formulas had been written: with Jacobian, averaging and machine code. Of a function that is called there
            are only integrations and run-ups ``until`` a time, at about 100 times the time (a pendulum with a branch takes
            3 us a call, half of it in the function itself, and its formulas 0.03 us); what needs more raises ``WuchtError``
            with its line. It stays in its process, and no machine code of it is kept.

        Warns
        -----
        RuntimeWarning
            Where the function is called: with the line that has no formula, what to write instead, and what is lost.

        Raises
        ------
        WuchtError
            Where it can neither be traced nor called with numbers, or returns another number of values than there are states.

        Examples
        --------
        >>> import numpy as np
        >>> pendulum = System.from_function(lambda t, x, p: [x[1], -np.sin(x[0]) - p[0] * x[1]], ["q", "v"], ["d"])
        >>> pendulum.derivatives
        (v, -d*v - sin(q))
        """
        if isinstance(states, str) or isinstance(parameters, str):
            raise WuchtError('states and parameters are lists of names: from_function(f, ["x", "v"], ["mu"])', code="no-list")
        state_symbols, constants = (tuple(sp.Symbol(name, real=True) for name in names) for names in (states, parameters))
        try:
            rates = traced_rates(function, TIME, state_symbols, constants)
        except WuchtError as error:
            if error.code != "not-traced":
                raise
            rates = called_rates(function, TIME, state_symbols, constants, error)
        turning = frozenset(sp.Symbol(name, real=True) for name in angles)
        smooth_between_kinks = tuple(with_located_kinks(rate, frozenset(constants)) for rate in rates)
        return cls(state_symbols, smooth_between_kinks, constants, angles=turning)

    def __post_init__(self) -> None:
        if len(self.states) != len(self.derivatives):
            raise WuchtError(f"{len(self.states)} states but {len(self.derivatives)} derivatives", code="count")
        _refuse_repeated("state or parameter", [*self.state_names, *self.parameter_names])
        _refuse_repeated("output or quadrature", [o.name for o in (*self.outputs, *self.quadratures)])
        if TIME.name in (*self.state_names, *self.parameter_names):
            raise WuchtError(f"{TIME} is the time: no state and no parameter may have that name", code="time-taken")
        known_symbols = {*self.states, *self.parameters, TIME}
        for symbol, expression in self.definitions:
            self._refuse_unknown(expression, known_symbols, f"the definition of {symbol}")
            if symbol in known_symbols:
                raise WuchtError(f"{symbol} is defined twice, or is a state or a parameter as well", code="defined-twice")
            known_symbols.add(symbol)
        for state, expression in zip(self.states, self.derivatives, strict=True):
            self._refuse_unknown(expression, known_symbols, f"the derivative of {state}")
        for output in (*self.outputs, *self.quadratures):
            self._refuse_unknown(output.expression, known_symbols, f"the output {output.name}")
            self._refuse_unknown(output.jump, known_symbols, f"the jump of {output.name}")
        if not self.angles <= set(self.states):
            raise WuchtError(f"angles {sorted(map(str, self.angles - set(self.states)))} are not states", code="no-angle")

    @staticmethod
    def _refuse_unknown(expression: sp.Expr, known_symbols: set[sp.Symbol], subject: str) -> None:
        unknown = sp.sympify(expression).free_symbols - known_symbols
        if unknown:
            raise WuchtError(
                f"{subject} uses {', '.join(sorted(map(str, unknown)))}: neither a state nor a parameter, nor "
                "defined before it",
                code="unknown-symbol",
            )

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """The names of the states, in order."""
        return tuple(s.name for s in self.states)

    @cached_property
    def is_angle(self) -> tuple[bool, ...]:
        """Whether each of the states, in order, is an angle."""
        return tuple(s in self.angles for s in self.states)

    @cached_property
    def has_formulas(self) -> bool:
        """False if the equations call a Python function that has none: see ``from_function``."""
        return self._call is None

    def require_formulas(self) -> None:
        """Raise ``WuchtError`` if the equations call a Python function that has none: with its line."""
        if self._call is not None:
            raise self._call.refusal()

    @cached_property
    def depends_on_time(self) -> bool:
        """True if time itself occurs in the equations. Raises ``WuchtError`` where that is not known: they have no formulas."""
        self.require_formulas()
        return any(TIME in sp.sympify(expression).free_symbols for expression in self._equations)

    @property
    def _equations(self) -> tuple[sp.Expr, ...]:
        return (*self.derivatives, *(expression for _, expression in self.definitions))

    @cached_property
    def _call(self) -> PythonCall | None:
        rates = (rate for e in self._equations for rate in sp.sympify(e).atoms(CalledRate))
        return next((rate.call for rate in rates), None)

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        """The names (paths) of the parameters, in order."""
        return tuple(p.name for p in self.parameters)

    def output(self, name: str) -> Output:
        """The output or quadrature of that name. Raises ``KeyError``."""
        for candidate in (*self.outputs, *self.quadratures):
            if candidate.name == name:
                return candidate
        raise KeyError(name)

    def explicit(self, expression: sp.Expr) -> sp.Expr:
        """The expression with all definitions substituted: in states, parameters and time alone."""
        return substitute_definitions(expression, self.definitions)

    def values(self, values_by_name: Mapping[str, float]) -> tuple[float, ...]:
        """Parameter values in order, from a mapping by name. Raises ``WuchtError`` on a missing one."""
        missing = [name for name in self.parameter_names if name not in values_by_name]
        if missing:
            raise WuchtError(f"no value for the parameter {', '.join(missing)}", code="no-value")
        return tuple(float(values_by_name[name]) for name in self.parameter_names)


def _refuse_repeated(category: str, names: Iterable[str]) -> None:
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise WuchtError(
            f"more than one {category} has the name {', '.join(twice)}: each needs a different name", code="name-twice"
        )


def substitute_definitions(expression: sp.Expr, definitions: Iterable[tuple[sp.Symbol, sp.Expr]]) -> sp.Expr:
    """Put definitions into an expression, the last first, touching only those that occur."""
    for symbol, meaning in reversed(tuple(definitions)):
        if symbol in expression.free_symbols:
            expression = expression.xreplace({symbol: meaning})
    return expression


def needed_definitions(
    definitions: Iterable[tuple[sp.Symbol, sp.Expr]], expressions: Iterable[sp.Expr]
) -> list[tuple[sp.Symbol, sp.Expr]]:
    """The definitions that the expressions use, directly or through one another, in order."""
    used_symbols, needed_pairs = (
        set[sp.Basic]().union(*(e.free_symbols for e in expressions)),
        list[tuple[sp.Symbol, sp.Expr]](),
    )
    for symbol, meaning in reversed(tuple(definitions)):
        if symbol in used_symbols:
            needed_pairs.append((symbol, sp.sympify(meaning)))
            used_symbols |= needed_pairs[-1][1].free_symbols
    return needed_pairs[::-1]
