"""A Python function of states as SymPy expressions: it is called once, with symbols in the place of numbers.

Arithmetic, matrix products, functions of NumPy and SymPy, and ``np.where`` are traced. What asks for a number is not: ``if``,
``math.sin``, functions of SciPy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from numbers import Integral, Real
from pathlib import Path
from traceback import extract_tb
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.piecewise import PiecewiseCubic, larger_value, smaller_value, step

_EXACT = 18  # characters of a decimal number that is kept as a fraction, as in formulas
_STEP = step("step", 0.0, 0.0, 1.0)
_FUNCTIONS: Mapping[str, Callable[..., sp.Expr]] = {  # by the names of NumPy
    **{f.__name__: f for f in (sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log, sp.sqrt, sp.sign)},
    **{f"arc{name}": getattr(sp, f"a{name}") for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh")},
    "arctan2": sp.atan2, "absolute": sp.Abs, "fabs": sp.Abs, "maximum": larger_value, "fmax": larger_value,
    "minimum": smaller_value, "fmin": smaller_value, "log10": lambda x: sp.log(x, 10), "log2": lambda x: sp.log(x, 2),
    "log1p": lambda x: sp.log(1 + x), "expm1": lambda x: sp.exp(x) - 1, "exp2": lambda x: 2**x,
    "cbrt": lambda x: sp.sign(x) * sp.Abs(x) ** sp.Rational(1, 3),
    "square": lambda x: x**2, "reciprocal": lambda x: 1 / x, "hypot": lambda x, y: sp.sqrt(x**2 + y**2),
    "deg2rad": sp.rad, "radians": sp.rad, "rad2deg": sp.deg, "degrees": sp.deg, "positive": lambda x: x,
    "negative": lambda x: -x, "add": lambda x, y: x + y, "subtract": lambda x, y: x - y, "multiply": lambda x, y: x * y,
    "divide": lambda x, y: x / y, "power": lambda x, y: x**y,
    "heaviside": lambda x, _: PiecewiseCubic(x, _STEP),
}  # fmt: skip
_REMEDY = (
    "write functions of NumPy (np.sin for math.sin), np.where(x[0] > 0, a, b) for a branch, np.maximum for max, "
    "np.zeros_like(x) for np.zeros, sympy.Matrix(M).LUsolve(sympy.Matrix(f)) for np.linalg.solve, or return a list"
)


class _NoNumberError(Exception):
    """A number was needed where there is a symbol."""


class TraceSymbol:
    """A number in a function that is traced. NumPy's functions call its methods of their names, also within arrays."""

    def __init__(self, value: Any) -> None:
        self._expression = _exact(value)

    def _sympy_(self) -> sp.Expr:
        return self._expression

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options or ufunc.__name__ not in _FUNCTIONS:
            raise _NoNumberError(f"{ufunc.__name__} has no formula")
        apply = partial(_symbol_of, ufunc.__name__)
        if not any(isinstance(one, np.ndarray) for one in inputs):
            return apply(*inputs)
        return np.frompyfunc(apply, len(inputs), 1)(*map(_objects, inputs))

    def __getattr__(self, name: str) -> Callable[..., TraceSymbol]:
        if name not in _FUNCTIONS:
            raise AttributeError(f"a state, parameter or time has no {name!r} while the function is traced")
        return partial(_symbol_of, name, self)

    def __neg__(self) -> TraceSymbol:
        return _symbol_of("negative", self)

    def __pos__(self) -> TraceSymbol:
        return self

    def __abs__(self) -> TraceSymbol:
        return _symbol_of("absolute", self)

    def __add__(self, operand: Any) -> Any:
        return _operation("add", self, operand)

    def __radd__(self, operand: Any) -> Any:
        return _operation("add", operand, self)

    def __sub__(self, operand: Any) -> Any:
        return _operation("subtract", self, operand)

    def __rsub__(self, operand: Any) -> Any:
        return _operation("subtract", operand, self)

    def __mul__(self, operand: Any) -> Any:
        return _operation("multiply", self, operand)

    def __rmul__(self, operand: Any) -> Any:
        return _operation("multiply", operand, self)

    def __truediv__(self, operand: Any) -> Any:
        return _operation("divide", self, operand)

    def __rtruediv__(self, operand: Any) -> Any:
        return _operation("divide", operand, self)

    def __pow__(self, operand: Any) -> Any:
        return _operation("power", self, operand)

    def __rpow__(self, operand: Any) -> Any:
        return _operation("power", operand, self)

    def __gt__(self, operand: Any) -> _Condition:
        return _Condition(self - operand)

    __ge__ = __gt__

    def __lt__(self, operand: Any) -> _Condition:
        return _Condition(operand - self)

    __le__ = __lt__

    def __eq__(self, operand: object) -> bool:
        raise _NoNumberError("it asks whether values are equal")

    def __ne__(self, operand: object) -> bool:
        raise _NoNumberError("it asks whether values are equal")

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> bool:
        raise _NoNumberError("it branches on a value")

    def __float__(self) -> float:
        raise _NoNumberError("it needs a value as a number")

    __int__ = __index__ = __complex__ = __float__


class _Condition:
    """Whether an expression is positive, for ``np.where`` alone."""

    def __init__(self, difference: TraceSymbol) -> None:
        self._difference = difference

    def __bool__(self) -> bool:
        raise _NoNumberError("it branches on a value")

    def __array_function__(self, function: Any, types: Any, arguments: Any, options: Any) -> Any:
        if function is not np.where or len(arguments) != 3 or options:
            raise _NoNumberError(f"np.{function.__name__} needs a value as a number")
        _, there, elsewhere = arguments
        return elsewhere + (there - elsewhere) * _symbol_of("heaviside", self._difference, 1.0)


def traced_rates(
    function: Callable[..., Any], time: sp.Symbol, states: Sequence[sp.Symbol], parameters: Sequence[sp.Symbol]
) -> tuple[sp.Expr, ...]:
    """Call a function f(t, x, p) once with symbols, and return the derivatives of the states.

    Raises ``WuchtError`` where it asks for a number, with its line, fails, or returns another number of values.
    """
    name = getattr(function, "__name__", "the function")
    x, p = (_objects(np.array([*map(TraceSymbol, symbols), None], object)[:-1]) for symbols in (states, parameters))
    try:
        output = function(TraceSymbol(time), x, p)
        rates = [] if output is None else [_exact(value) for value in np.ravel(np.array(output, object))]
    except Exception as error:  # whatever a function of the user's raises
        reason = str(error) if isinstance(error, _NoNumberError) else f"{type(error).__name__}: {error}"
        remedy = f"; {_REMEDY}" if isinstance(error, _NoNumberError | TypeError) else ""
        sentence = f"{name} cannot be written as formulas: {reason}{line_of(function, error)}{remedy}"
        raise WuchtError(sentence, code="not-traced") from error
    if len(rates) != len(states):
        values_text = "nothing" if output is None else f"{len(rates)} value{'s' if len(rates) > 1 else ''}"
        raise WuchtError(
            f"{name} must return a derivative for each of {len(states)} states; it returns {values_text}", code="count"
        )
    return tuple(rates)


def line_of(function: Callable[..., Any], error: BaseException) -> str:
    """The line of the function at which an error arose, in words; empty where that is not known."""
    file = getattr(getattr(function, "__code__", None), "co_filename", None)
    lines = [frame for frame in extract_tb(error.__traceback__) if frame.filename == file]
    if not lines:
        return ""
    text = f" ({lines[-1].line})" if lines[-1].line else ""  # which is not known of what was typed at a prompt
    return f", at line {lines[-1].lineno} of {Path(lines[-1].filename).name}{text}"


def _symbol_of(name: str, *values: Any) -> TraceSymbol:
    return TraceSymbol(_FUNCTIONS[name](*map(_exact, values)))


def _operation(name: str, *values: Any) -> Any:
    """A sum, product, ...; of an array, NumPy does it element by element."""
    return NotImplemented if any(isinstance(one, np.ndarray) for one in values) else _symbol_of(name, *values)


def _objects(value: Any) -> np.ndarray:
    """A value, or the values of an array, as an array of objects."""
    if isinstance(value, np.ndarray):
        return value.astype(object)
    array = np.empty((), object)
    array[()] = value
    return array


def _exact(value: Any) -> sp.Expr:
    """A number or an expression as SymPy has it; a number of few decimals as a fraction, as formulas of a file."""
    if isinstance(value, Integral):
        return sp.Integer(int(value))
    if isinstance(value, Real) and not isinstance(value, sp.Basic):
        text = repr(float(value))
        return sp.Rational(text) if "e" not in text and "n" not in text and len(text) <= _EXACT else sp.Float(float(value))
    expression = sp.sympify(value, strict=True)
    if not isinstance(expression, sp.Expr) or (expression.is_number and not expression.is_extended_real):
        raise TypeError(f"{value!r} is no real number")
    return expression
