"""System -> straight-line program: constant expressions are taken out and computed once per run from the parameters.

An expression such as ``m*l*cos(theta)`` becomes ``c0*cos(theta)`` with ``c0 = m*l``. It is computed once a
run instead of at each stage of each step. Machine code and all outputs use it.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from linecache import getlines
from typing import Any

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import RunError
from wucht.function_call import CALL_PREFIX, CalledRate
from wucht.piecewise import Pieces, PiecewiseCubic
from wucht.system import TIME as TIME  # noqa: PLC0414 - re-exported
from wucht.system import System, needed_definitions

Numbers = Sequence[float] | np.ndarray
# Given only a library's name, SymPy would load all of it: "from numpy import *" takes as long as ten functions.
_AUXILIARY_PREFIX = "_"  # begins the names of parameters that no user gave
_LIBRARIES = {"numpy": np, "math": math, "cmath": cmath}
PointValues = Callable[[np.ndarray, float, np.ndarray], Sequence[float]]  # of a state, a time and constants
_MOST_RECENT = 128
Assignments = tuple[tuple[sp.Symbol, sp.Expr], ...]


@dataclass(frozen=True)
class Program:
    """Assignments to be evaluated in order, then results; ``constants`` are functions of the parameters alone."""

    states: tuple[sp.Symbol, ...]
    parameter_symbols: tuple[sp.Symbol, ...]
    constants: Assignments
    lines: Assignments
    results: tuple[sp.Expr, ...]

    @cached_property
    def _constant_function(self) -> Callable[..., Sequence[float]]:
        return python_function((self.parameter_symbols,), (), tuple(e for _, e in self.constants), "math")

    def function(self, modules: str = "numpy") -> Callable[..., Any]:
        """Return the function (states, time, constants) -> list of results; see ``python_function``."""
        return python_function((self.states, TIME, tuple(s for s, _ in self.constants)), self.lines, self.results, modules)

    @cached_property
    def _parameter_places(self) -> np.ndarray:
        """The places of the parameters that the constants depend on."""
        needed = set[sp.Basic]().union(*(sp.sympify(e).free_symbols for _, e in self.constants))
        return np.array([i for i, s in enumerate(self.parameter_symbols) if s in needed], int)

    @cached_property
    def _recent_constants(self) -> dict[bytes, np.ndarray]:
        return {}

    def constant_values(self, parameter_values: Numbers) -> np.ndarray:
        """Evaluate the constants (k,) at given parameter values. Raises ``RunError`` where they are not finite.

        They cannot be written to: those of recent values are kept, as contacts close and open again with the same ones.
        """
        key = np.asarray(parameter_values, float)[self._parameter_places].tobytes()
        values = self._recent_constants.get(key)
        if values is None:
            values = self._evaluate_constants(parameter_values)
            values.flags.writeable = False
            if len(self._recent_constants) >= _MOST_RECENT:
                self._recent_constants.clear()
            self._recent_constants[key] = values
        return values

    def _evaluate_constants(self, parameter_values: Numbers) -> np.ndarray:
        try:
            values = np.array(self._constant_function(list(map(float, parameter_values))), dtype=float)
        except (ZeroDivisionError, OverflowError, ValueError):
            values = np.array([math.nan])
        if not np.isfinite(values).all():
            pairs = [
                (p.name, v)
                for p, v in zip(self.parameter_symbols, parameter_values, strict=True)
                if not p.name.startswith(_AUXILIARY_PREFIX)
            ]
            listing = ", ".join(f"{name} = {v:g}" for name, v in pairs) or "none"
            reason = "a division by zero, or a number that is too large"
            raise RunError(f"the equations cannot be evaluated at these parameters ({reason}): {listing}", code="not-evaluated")
        return values


@dataclass
class _Folder:
    """Folder of constants: it replaces every part of an expression that depends on parameters alone by a symbol."""

    varying: set[sp.Symbol]
    constants: dict[sp.Expr, sp.Symbol] = field(default_factory=dict)
    memo: dict[sp.Expr, sp.Expr] = field(default_factory=dict)

    def fold(self, e: sp.Expr) -> sp.Expr:
        if e not in self.memo:
            self.memo[e] = self._fold(e)
        return self.memo[e]

    def _fold(self, e: sp.Expr) -> sp.Expr:
        if not e.free_symbols & self.varying:
            if e.is_Number or -e in self.constants:
                return e if e.is_Number else -self.constants[-e]
            return self.constants.setdefault(e, sp.Symbol(f"_c{len(self.constants)}", real=True))
        if e.is_Atom:
            return e
        if isinstance(e, PiecewiseCubic):
            return e.func(self.fold(e.args[0]), e.args[1])
        if isinstance(e, sp.Add | sp.Mul):
            constant_parts = [a for a in e.args if not a.free_symbols & self.varying]
            moving = [self.fold(a) for a in e.args if a.free_symbols & self.varying]
            return e.func(*((self.fold(e.func(*constant_parts)),) if constant_parts else ()), *moving)
        return e.func(*(self.fold(a) for a in e.args))


def lower(system: System, results: Sequence[sp.Expr], changing: tuple[sp.Symbol, ...] = ()) -> Program:
    """Build the program that computes ``results`` from a System's states and parameters, with the definitions they need.

    changing: parameters whose values change during a run. They are the last constants, and no other constant depends on them.
    """
    expressions = tuple(map(sp.sympify, results))
    definitions = tuple(needed_definitions(system.definitions, expressions))
    return _lower(system.states, system.parameters, definitions, expressions, changing)


@derived_once
def _lower(
    states: tuple[sp.Symbol, ...],
    parameters: tuple[sp.Symbol, ...],
    definitions: Assignments,
    results: tuple[sp.Expr, ...],
    changing: tuple[sp.Symbol, ...],
) -> Program:
    folder, lines = _Folder({*states, TIME, *changing}), []
    # Definitions that are substituted: constants, multiples of one symbol or wave, and repetitions of a previous definition.
    substitutions: dict[sp.Symbol, sp.Expr] = {}
    first: dict[sp.Expr, sp.Symbol] = {}
    for symbol, expression in definitions:
        full_expression = expression.xreplace(substitutions)
        if not expression.free_symbols & folder.varying:
            substitutions[symbol] = full_expression
            continue
        folder.varying.add(symbol)
        folded_expression = folder.fold(full_expression)
        if folded_expression in first or -folded_expression in first:
            substitutions[symbol] = first[folded_expression] if folded_expression in first else -first[-folded_expression]
        elif _is_multiple(folded_expression, folder.varying):
            substitutions[symbol] = full_expression
        else:
            first[folded_expression] = symbol
            lines.append((symbol, folded_expression))
    folded_results = tuple(folder.fold(r.xreplace(substitutions)) for r in results)
    constants = (*((symbol, expression) for expression, symbol in folder.constants.items()), *((s, s) for s in changing))
    return Program(states, parameters, constants, tuple(lines), folded_results)


def _is_multiple(e: sp.Expr, varying: set[sp.Symbol]) -> bool:
    """True if it is a constant times a symbol, a sine or a cosine: a product of two of these may become a square."""
    moving = [a for a in sp.Mul.make_args(e) if a.free_symbols & varying]
    return len(moving) == 1 and (moving[0].is_Symbol or (moving[0].func in (sp.sin, sp.cos) and moving[0].args[0].is_Symbol))


def python_function(
    arguments: Sequence[Any], lines: Assignments, results: Sequence[sp.Expr], modules: str = "numpy"
) -> Callable[..., Any]:
    """Compile a Python function of ``arguments`` (symbols or groups of them) that runs the lines and returns the results.

    modules: ``"math"`` for numbers, ``"cmath"`` for complex ones, ``"numpy"`` for arrays.
    """
    source, tables = _source(tuple(arguments), tuple(lines), tuple(map(sp.sympify, results)), modules)
    library = _LIBRARIES[modules]  # SymPy calls some functions with its name, most without
    names = vars(library) | {modules: library, "reduce": reduce} | {f"table_{k}": table for k, table in enumerate(tables)}
    if CALL_PREFIX in source:
        names |= {str(c.func): c.column for e in (*(e for _, e in lines), *results) for c in sp.sympify(e).atoms(CalledRate)}
    exec(source, names)
    function: Callable[..., Any] = names["_lambdifygenerated"]
    return function


@derived_once
def _source(
    arguments: tuple[Any, ...], lines: Assignments, results: tuple[sp.Expr, ...], modules: str
) -> tuple[str, tuple[Pieces, ...]]:
    """Print the text of the function; return also the piecewise functions that it calls ``table_0``, ``table_1``, ..."""
    expressions = [sp.sympify(e) for e in (*(e for _, e in lines), *results)]
    tables = tuple({p.args[1]: None for e in expressions for p in sp.preorder_traversal(e) if isinstance(p, PiecewiseCubic)})
    table_functions = {table: sp.Function(f"table_{k}") for k, table in enumerate(tables)}
    if tables:
        expressions = [e.replace(PiecewiseCubic, lambda argument, table: table_functions[table](argument)) for e in expressions]
    symbols = {s for a in arguments for s in (a if isinstance(a, tuple) else (a,))} | {s for s, _ in lines}
    short = {s: sp.Symbol(f"v{k}", real=True) for k, s in enumerate(sorted(symbols, key=lambda s: s.name))}
    short_arguments = [tuple(short[s] for s in a) if isinstance(a, tuple) else short[a] for a in arguments]
    short_expressions = [e.xreplace(short) for e in expressions]
    # Sines and cosines of arguments are the most expensive part of a mechanism's formulas: each is computed once.
    argument_symbols = {s for a in short_arguments for s in (a if isinstance(a, tuple) else (a,))}
    waves = {a for e in short_expressions for a in e.atoms(sp.sin, sp.cos) if a.free_symbols <= argument_symbols}
    once = {a: sp.Symbol(f"w{k}", real=True) for k, a in enumerate(sorted(waves, key=sp.default_sort_key))}
    short_expressions = [e.xreplace(once) for e in short_expressions]
    body = [*((w, a) for a, w in once.items()), *((short[s], e) for (s, _), e in zip(lines, short_expressions, strict=False))]
    result_expressions, table_names = short_expressions[len(lines) :], {str(f): len for f in table_functions.values()}
    function = sp.lambdify(
        short_arguments,
        result_expressions,
        modules=[table_names, _LIBRARIES[modules]],
        printer=_printer(modules, table_names),
        cse=lambda e: (body, e),
        docstring_limit=0,
    )
    return "".join(getlines(function.__code__.co_filename)), tables


def _printer(modules: str, functions: Iterable[str]) -> Any:
    """SymPy's printer for a library, which leaves sums in their order: to sort them takes half of the time."""
    from sympy.printing.numpy import NumPyPrinter
    from sympy.printing.pycode import CmathPrinter, PythonCodePrinter

    printers = {"numpy": NumPyPrinter, "cmath": CmathPrinter, "math": PythonCodePrinter}
    names = {name: name for name in functions}
    return printers[modules](
        {"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True, "order": "none"}
        | {"user_functions": names}
    )


@lru_cache(maxsize=1024)
def number_function(expressions: tuple[sp.Expr, ...], symbols: tuple[sp.Symbol, ...]) -> Callable[[Iterable[float]], list[Any]]:
    """Compile expressions, once, as a function of the values of their symbols that returns a list of numbers.

    They are complex where an expression has the imaginary unit.
    """
    complex_ = any(sp.sympify(e).has(sp.I) for e in expressions)
    function = python_function((symbols,), (), expressions, "cmath" if complex_ else "math")
    return lambda values: list(function(tuple(values)))


@lru_cache(maxsize=256)
def variable_function(
    expressions: tuple[sp.Expr, ...], symbols: tuple[sp.Symbol, ...], variable: sp.Symbol, modules: str
) -> Callable[[Sequence[float], Any], list[Any]]:
    """Compile expressions, once, as a function of the values of their symbols and of one variable, a number or an array."""
    return python_function((symbols, variable), (), expressions, modules)


@dataclass(frozen=True)
class Evaluator:
    """Expressions of a System as a function of arrays. The same expressions give the same evaluator back.

    Attributes
    ----------
    names : tuple of str
        Names of the expressions.
    program : Program
        The assignments that compute them.

    Examples
    --------
    >>> import numpy as np
    >>> import sympy as sp
    >>> from wucht.numerics.flow import Evaluator, System
    >>> x, v, k = sp.symbols("x v k", real=True)
    >>> energy = Evaluator.of(System((x, v), (v, -k * x), (k,)), [(v**2 + k * x**2) / 2], ["energy"])
    >>> energy(np.zeros(2), np.array([[1.0, 0.0], [0.0, 3.0]]), [4.0])
    {'energy': array([2. , 4.5])}
    """

    names: tuple[str, ...]
    program: Program

    @classmethod
    def of(cls, system: System, expressions: Sequence[sp.Expr], names: Sequence[str]) -> Evaluator:
        """Return the evaluator of expressions in a System's symbols."""
        return _evaluator(system, tuple(expressions), tuple(names))

    @classmethod
    def of_outputs(cls, system: System) -> Evaluator:
        """Return the evaluator of a System's outputs."""
        return cls.of(system, [o.expression for o in system.outputs], [o.name for o in system.outputs])

    @classmethod
    def of_rates(cls, system: System) -> Evaluator:
        """Return the evaluator of a System's derivatives, by the names of the states."""
        return cls.of(system, system.derivatives, system.state_names)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        return self.program.function()

    def __call__(self, time: np.ndarray, states: np.ndarray, parameter_values: Numbers) -> dict[str, np.ndarray]:
        """Evaluate. time: (N,), states: (n, N), parameters in the System's order. Returns an array (N,) for each name."""
        values = self._function(tuple(states), time, self.program.constant_values(parameter_values))
        return {n: np.broadcast_to(np.asarray(v, float), time.shape) for n, v in zip(self.names, values, strict=True)}

    def array(self, time: np.ndarray, states: np.ndarray, parameter_values: Numbers) -> np.ndarray:
        """Evaluate to an array (k, N), in the order of the names."""
        return np.array(list(self(time, states, parameter_values).values())).reshape(len(self.names), len(time))


@lru_cache(maxsize=256)
def _evaluator(system: System, expressions: tuple[sp.Expr, ...], names: tuple[str, ...]) -> Evaluator:
    return Evaluator(names, lower(system, expressions))
