"""A Program as text for LLVM: a function of time, states and constants that stores its results, without a loop or a branch.

On numbers, or on vectors of them: then each lane has its time, states and constants.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

import sympy as sp
from llvmlite import binding, ir

from wucht.errors import RunError
from wucht.function_call import CalledRate
from wucht.numerics.flow.program import TIME, Program

# The names under which a module calls functions of the C library, so that no platform has to export them by another name.
LIBRARY_PREFIX = "wucht_"
FUNCTIONS = {
    sp.tan: "tan", sp.exp: "exp", sp.log: "log", sp.sinh: "sinh", sp.cosh: "cosh", sp.tanh: "tanh",
    sp.atan: "atan", sp.asin: "asin", sp.acos: "acos", sp.atan2: "atan2",
}  # fmt: skip
POWER = "pow"
# A quarter of a turn in three parts, of 159 bits; the polynomials for an eighth of a turn are those of Sun's fdlibm (k_sin.c,
# k_cos.c).
_QUARTER_TURN = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33)
_SINE = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04, 2.75573137070700676789e-06,
    -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_COSINE = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05, -2.75573143513906633035e-07,
    2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
LIBRARY = {**dict.fromkeys(FUNCTIONS.values(), 1), "atan2": 2, POWER: 2}  # names and numbers of arguments
_DOUBLE, _INTEGER, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
CONTRACT = ("contract",)  # a product and a sum may be one instruction
_LAST_BITS = 1.5 * 2.0**52  # added to a number, it leaves the integer nearest to it in the last bits


def module_text(programs: Sequence[tuple[str, Program]], width: int = 1) -> str:
    """Return the text of a module with a function for each program, by these names.

    width: numbers in each vector; for 1 the functions have numbers, and their first argument, the time, is one; else all
    arguments are addresses. Raises ``RunError`` for a function that the C library does not have.
    """
    module = ir.Module(name="wucht")
    pointer = lanes_of(_DOUBLE, width).as_pointer()
    for name, program in programs:
        time_kind = _DOUBLE if width == 1 else pointer
        function = ir.Function(module, ir.FunctionType(ir.VoidType(), [time_kind, pointer, pointer, pointer]), name)
        time, states, constants, results = function.args
        for argument in function.args:
            if argument.type.is_pointer:
                argument.add_attribute("noalias")
        builder = ir.IRBuilder(function.append_basic_block())
        printer = _Printer(module, builder, width)
        printer.memo[TIME] = time if width == 1 else printer.load(time, 0)
        printer.memo |= {s: printer.load(states, i) for i, s in enumerate(program.states)}
        printer.memo |= {s: printer.load(constants, i) for i, (s, _) in enumerate(program.constants)}
        for symbol, expression in program.lines:
            printer.memo[symbol] = printer(expression)
        for i, result in enumerate(program.results):
            builder.store(printer(result), printer.place(results, i))
        builder.ret_void()
    return str(module)


def lanes_of(kind: Any, width: int) -> Any:
    """Return the type of a vector of so many, of a single one where the width is 1."""
    return kind if width == 1 else ir.VectorType(kind, width)


def constant_lanes(kind: Any, value: float, width: int) -> ir.Constant:
    """Return a constant of this type, in a vector the same on all lanes."""
    number = ir.Constant(kind, value)
    return number if width == 1 else ir.Constant(ir.VectorType(kind, width), [number] * width)


def intrinsic(module: ir.Module, name: str, values: Sequence[Any]) -> Any:
    """Return one of LLVM's functions of numbers, or of vectors lane by lane, for values of this type."""
    kind = values[0].type
    suffix = "f64" if kind == _DOUBLE else f"v{kind.count}f64"
    return module.declare_intrinsic(f"{name}.{suffix}", (), ir.FunctionType(kind, [kind] * len(values)))


class _Printer:
    """SymPy expressions to LLVM's instructions; equal expressions are computed once."""

    def __init__(self, module: ir.Module, builder: ir.IRBuilder, width: int) -> None:
        self.module, self.builder, self.width = module, builder, width
        self.memo: dict[sp.Basic, Any] = {}

    def real(self, value: float) -> ir.Constant:
        return constant_lanes(_DOUBLE, value, self.width)

    def place(self, array: Any, index: int) -> Any:
        return self.builder.gep(array, [ir.Constant(ir.IntType(64), index)])

    def load(self, array: Any, index: int) -> Any:
        return self.builder.load(self.place(array, index))

    def __call__(self, e: sp.Expr) -> Any:
        if e not in self.memo:
            self.memo[e] = self._print(e)
        return self.memo[e]

    def _print(self, e: sp.Expr) -> Any:
        if e.is_number:
            return self.real(float(e))
        printer = next((printer for kind, printer in _PRINTERS.items() if isinstance(e, kind)), None)
        if printer is not None:
            return printer(self, e)
        if e.func in FUNCTIONS:
            return self._call(FUNCTIONS[e.func], [self(a) for a in e.args])
        raise RunError(f"there is no machine code for the function {e.func.__name__!r}", code="no-function")

    def _sum(self, e: sp.Add) -> Any:
        """Sum the terms; those with a minus sign are subtracted."""
        negative = [a.could_extract_minus_sign() for a in e.args]
        terms = sorted(zip(negative, e.args, strict=True), key=lambda pair: pair[0])
        (first_negative, first), *rest = terms
        total = self.builder.fneg(self(-first)) if first_negative else self(first)
        for is_negative, term in rest:
            combine = self.builder.fsub if is_negative else self.builder.fadd
            total = combine(total, self(-term if is_negative else term), flags=CONTRACT)
        return total

    def _product(self, e: sp.Mul) -> Any:
        numerator, denominator = e.as_numer_denom() if any(a.is_Pow and a.exp.is_negative for a in e.args) else (e, sp.S.One)
        if denominator is not sp.S.One:
            return self.builder.fdiv(self(numerator), self(denominator))
        factors = [a for a in e.args if a is not sp.S.NegativeOne]
        product = reduce(self._multiply, map(self, factors))
        return product if len(factors) == len(e.args) else self.builder.fneg(product)

    def _multiply(self, a: Any, b: Any) -> Any:
        return self.builder.fmul(a, b, flags=CONTRACT)

    def _power(self, e: sp.Pow) -> Any:
        base, exponent = self(e.base), e.exp
        if exponent.is_Integer:
            product, square, n = None, base, int(abs(exponent))
            while n:
                if n & 1:
                    product = square if product is None else self._multiply(product, square)
                n >>= 1
                square = self._multiply(square, square) if n else square
            return product if exponent.is_positive else self.builder.fdiv(self.real(1.0), product)
        if abs(exponent) == sp.Rational(1, 2):
            root = self._intrinsic("llvm.sqrt", base)
            return root if exponent.is_positive else self.builder.fdiv(self.real(1.0), root)
        return self._call(POWER, [base, self(exponent)])

    def _magnitude(self, e: sp.Abs) -> Any:
        return self._intrinsic("llvm.fabs", self(e.args[0]))

    def _sign(self, e: sp.sign) -> Any:
        return self._intrinsic("llvm.copysign", self.real(1.0), self(e.args[0]))

    def _wave(self, e: sp.Expr) -> Any:
        """Return a sine or cosine; both are computed together."""
        sine, cosine = self._waves(self(e.args[0]))
        self.memo[sp.sin(e.args[0])], self.memo[sp.cos(e.args[0])] = sine, cosine
        return self.memo[e]

    def _python_rate(self, e: CalledRate) -> Any:
        """Return a rate of a Python function; all of them are computed together."""
        if self.width > 1:
            raise e.call.refusal()
        sizes = (ir.Constant(_INTEGER, len(values)) for values in (e.args, e.call.rates))
        arguments, results = (self.builder.alloca(_DOUBLE, size) for size in sizes)
        for i, argument in enumerate(e.args):
            self.builder.store(self(argument), self.place(arguments, i))
        function = self.module.globals.get(e.call.name)
        if function is None:
            binding.add_symbol(e.call.name, e.call.address)
            kinds = [_DOUBLE.as_pointer()] * 2
            function = ir.Function(self.module, ir.FunctionType(ir.VoidType(), kinds), e.call.name)
        self.builder.call(function, [arguments, results])
        self.memo |= {rate(*e.args): self.load(results, i) for i, rate in enumerate(e.call.rates)}
        return self.memo[e]

    def _waves(self, x: Any) -> tuple[Any, Any]:
        """Return sine and cosine of a value, to a unit in the last place, without a branch."""
        builder = self.builder
        sum_of_bits = self._add(self._multiply(x, self.real(2 / math.pi)), self.real(_LAST_BITS))
        quarters, rest = builder.fsub(sum_of_bits, self.real(_LAST_BITS)), x
        for part in _QUARTER_TURN:
            rest = self._intrinsic("llvm.fma", quarters, self.real(-part), rest)
        square = self._multiply(rest, rest)
        sine = self._polynomial(square, _SINE)
        sine = self._add(rest, self._multiply(self._multiply(rest, square), sine))
        cosine = self._polynomial(square, _COSINE)
        cosine = self._add(self.real(1.0), self._multiply(square, self._add(self.real(-0.5), self._multiply(square, cosine))))
        flag, one = lanes_of(_BIT, self.width), constant_lanes(_INTEGER, 1, self.width)
        count = builder.bitcast(sum_of_bits, lanes_of(_INTEGER, self.width))
        is_odd = builder.trunc(count, flag)
        results = []
        for first, second, quarter in ((sine, cosine, 0), (cosine, sine, 1)):
            value = builder.select(is_odd, second, first)
            quadrant = builder.add(count, constant_lanes(_INTEGER, quarter, self.width))
            is_negative = builder.trunc(builder.lshr(quadrant, one), flag)
            results.append(builder.select(is_negative, builder.fneg(value), value))
        return results[0], results[1]

    def _polynomial(self, x: Any, coefficients: Sequence[float]) -> Any:
        highest, *lower = map(self.real, coefficients[::-1])
        return reduce(lambda value, c: self._add(c, self._multiply(x, value)), lower, highest)

    def _add(self, a: Any, b: Any) -> Any:
        return self.builder.fadd(a, b, flags=CONTRACT)

    def _intrinsic(self, name: str, *values: Any) -> Any:
        return self.builder.call(intrinsic(self.module, name, values), values)

    def _call(self, name: str, values: Sequence[Any]) -> Any:
        full_name = LIBRARY_PREFIX + name
        function = self.module.globals.get(full_name)
        if function is None:
            function = ir.Function(self.module, ir.FunctionType(_DOUBLE, [_DOUBLE] * LIBRARY[name]), full_name)
        if self.width == 1:
            return self.builder.call(function, values)
        result, places = self.real(0.0), [ir.Constant(ir.IntType(32), lane) for lane in range(self.width)]
        for place in places:  # the C library has no function of vectors
            number = self.builder.call(function, [self.builder.extract_element(v, place) for v in values])
            result = self.builder.insert_element(result, number, place)
        return result


_PRINTERS: dict[type[sp.Expr], Callable[[_Printer, Any], Any]] = {
    sp.Add: _Printer._sum, sp.Mul: _Printer._product, sp.Pow: _Printer._power, sp.sin: _Printer._wave, sp.cos: _Printer._wave,
    sp.Abs: _Printer._magnitude, sp.sign: _Printer._sign,
    CalledRate: _Printer._python_rate,
}  # fmt: skip
