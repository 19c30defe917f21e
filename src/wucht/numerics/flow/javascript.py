"""A Program as JavaScript: functions of arrays that store their results, without a branch, a loop or an object.

States, parameters, constants and results are places in arrays: no name of a file is part of the code.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import RunError
from wucht.numerics.flow.program import TIME, Assignments, Program
from wucht.piecewise import PiecewiseCubic

_FUNCTIONS = {
    sp.sin: "sin", sp.cos: "cos", sp.tan: "tan", sp.exp: "exp", sp.log: "log", sp.sinh: "sinh", sp.cosh: "cosh",
    sp.tanh: "tanh", sp.atan: "atan", sp.asin: "asin", sp.acos: "acos", sp.atan2: "atan2", sp.Abs: "abs",
    sp.Max: "max", sp.Min: "min",
}  # fmt: skip
_MOST_FACTORS = 8  # higher powers are computed by the library
_TIME, _STATES, _PARAMETERS, _CONSTANTS, _RESULTS = "txpcr"


def missing_functions(expressions: Iterable[sp.Expr]) -> list[str]:
    """Return the names of the functions in expressions that JavaScript does not have, piecewise ones excepted."""
    functions = {f.func for e in expressions for f in e.atoms(sp.Function)}
    return sorted(f.__name__ for f in functions - {*_FUNCTIONS, PiecewiseCubic})


@derived_once
def javascript_code(program: Program) -> str:
    """Print a program as an object of two functions.

    Parameters
    ----------
    program : Program
        Without piecewise functions: the polynomials of the segments in use stand in their place.

    Returns
    -------
    str
        ``{ constantCount, constants(p, c), values(t, x, c, r) }``: the first function computes the constants c from the
        parameters p, the second the results r from the time t, the states x and the constants. Arrays do not overlap.

    Raises
    ------
    RunError
        For a function that JavaScript does not have.

    Examples
    --------
    >>> import sympy as sp
    >>> from wucht.numerics.flow.program import lower
    >>> from wucht.system import System
    >>> x, v, k = sp.symbols("x v k", real=True)
    >>> print(javascript_code(lower(System((x, v), (v, -k * sp.sin(x)), (k,)), [v, -k * sp.sin(x)])))
    {
    constantCount: 1,
    constants(p, c) {
    c[0] = -p[0];
    },
    values(t, x, c, r) {
    r[0] = x[1];
    r[1] = c[0] * Math.sin(x[0]);
    },
    }
    """
    of_parameters = {s: f"{_PARAMETERS}[{i}]" for i, s in enumerate(program.parameter_symbols)}
    arguments = {TIME: _TIME} | {s: f"{_STATES}[{i}]" for i, s in enumerate(program.states)}
    arguments |= {s: f"{_CONSTANTS}[{i}]" for i, (s, _) in enumerate(program.constants)}
    constants = _statements(of_parameters, (), [e for _, e in program.constants], _CONSTANTS)
    values = _statements(arguments, program.lines, program.results, _RESULTS)
    return "\n".join(
        [
            "{",
            f"constantCount: {len(program.constants)},",
            f"constants({_PARAMETERS}, {_CONSTANTS}) {{",
            *constants,
            "},",
            f"values({_TIME}, {_STATES}, {_CONSTANTS}, {_RESULTS}) {{",
            *values,
            "},",
            "}",
        ]
    )


def _statements(
    arguments: Mapping[sp.Symbol, str], lines: Assignments, results: Sequence[sp.Expr], results_name: str
) -> list[str]:
    """Return the statements of a function's body.

    An expression that is needed more than once, such as a sine, is computed once: they are counted first, then printed.
    """
    counts, statements = Counter[sp.Basic](), list[str]()
    for _ in ("count", "print"):
        printer = _Printer(arguments, {e for e, count in counts.items() if count > 1})
        for symbol, expression in lines:
            printer.define(symbol, expression)
        stores = [f"{results_name}[{i}] = {printer.text(sp.sympify(e))};" for i, e in enumerate(results)]
        counts, statements = printer.counts, [*printer.statements, *stores]
    return statements


class _Printer:
    """SymPy expressions to text. ``repetitions`` become constants in the code, in ``statements`` that come before.

    counts: how often the text of each expression was needed.
    """

    def __init__(self, arguments: Mapping[sp.Symbol, str], repetitions: set[sp.Basic]) -> None:
        self._repetitions = repetitions
        self._arguments, self._texts = arguments, dict[sp.Basic, str]()
        self.counts, self.statements = Counter[sp.Basic](), list[str]()

    def define(self, symbol: sp.Symbol, e: sp.Expr) -> None:
        """Compute a line of the program."""
        self._texts[symbol] = self._constant(self.text(e))

    def text(self, e: sp.Expr) -> str:
        """Return the text of an expression: a name, a number, a call, a product, or a sum in brackets."""
        if e.is_number:
            return _number(float(e))
        self.counts[e] += 1
        if e not in self._texts:
            text = self._print(e)
            self._texts[e] = self._constant(text) if e in self._repetitions and e != TIME else text
        return self._texts[e]

    def _constant(self, text: str) -> str:
        name = f"v{len(self.statements)}"
        self.statements.append(f"const {name} = {text};")
        return name

    def _print(self, e: sp.Expr) -> str:
        if e in self._arguments:
            return self._arguments[e]
        if isinstance(e, sp.Add):
            return self._sum(e)
        if isinstance(e, sp.Mul):
            return self._product(e)
        if isinstance(e, sp.Pow):
            return self._power(e.base, e.exp)
        if e.func in _FUNCTIONS:
            return f"Math.{_FUNCTIONS[e.func]}({', '.join(map(self.text, e.args))})"
        raise RunError(f"JavaScript has no function {e.func.__name__!r}", code="no-function")

    def _sum(self, e: sp.Add) -> str:
        """Print the terms; those with a minus sign are subtracted."""
        terms = sorted(((a.could_extract_minus_sign(), a) for a in e.args), key=lambda term: term[0])
        (is_negative, first), *rest = terms
        parts = [f"-{self._factor(-first)}" if is_negative else self.text(first)]
        parts += [f"- {self._factor(-a)}" if negative else f"+ {self.text(a)}" for negative, a in rest]
        return f"({' '.join(parts)})"

    def _factor(self, e: sp.Expr) -> str:
        """Return a text that a minus sign may precede."""
        text = self.text(e)
        return f"({text})" if text.startswith("-") else text

    def _product(self, e: sp.Mul) -> str:
        above = [a for a in e.args if a is not sp.S.NegativeOne and not _is_below(a)]
        below = [a for a in e.args if _is_below(a)]
        text = " * ".join(map(self._factor, above)) or "1"
        if below:
            text = f"({text}) / {self._denominator(below)}"
        return f"-{text}" if sp.S.NegativeOne in e.args else text

    def _denominator(self, below: Iterable[sp.Pow]) -> str:
        return f"({' * '.join(self._power(a.base, -a.exp) for a in below)})"

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> str:
        if exponent == sp.S.One:
            return self.text(base)
        if exponent.could_extract_minus_sign():
            return f"1 / ({self._power(base, -exponent)})"
        if exponent == sp.S.Half:
            return f"Math.sqrt({self.text(base)})"
        if exponent.is_Integer and exponent <= _MOST_FACTORS:
            return f"({' * '.join(self.text(base) for _ in range(int(exponent)))})"
        return f"Math.pow({self.text(base)}, {self.text(exponent)})"


def _is_below(e: sp.Expr) -> bool:
    return bool(e.is_Pow and e.exp.could_extract_minus_sign())


def _number(value: float) -> str:
    """Return a number's shortest text with all its digits. Raises ``RunError`` for one that is not finite."""
    if not math.isfinite(value):
        raise RunError("an equation has a number that is not finite", code="not-evaluated")
    return repr(value) if value >= 0 else f"({value!r})"
