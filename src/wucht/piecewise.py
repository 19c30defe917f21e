"""Piecewise cubic functions of one argument as SymPy functions: schedules, measured characteristics, contacts.

They can be differentiated, printed and evaluated like any function. An integrator never steps over a breakpoint: ``numerics``
compiles the cubic of one piece and changes its coefficients at the breakpoint, which is located as an event.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import WuchtError


class Pieces(sp.Atom):  # type: ignore[misc]
    """Breakpoints x_1 < ... < x_k and k + 1 cubics; a name for printing.

    coefficients: (k + 1, 4). Piece i holds from x_i on (piece 0 before x_1) and is a polynomial in the distance from its
    first breakpoint, for piece 0 from x_1 (``origins``). At a breakpoint the function has its value from the right.
    Raises ``WuchtError`` where the breakpoints do not increase, a number is not finite, or the shapes do not fit.
    """

    __slots__ = ("__dict__", "breakpoints", "coefficients", "name")
    breakpoints: tuple[float, ...]
    coefficients: tuple[tuple[float, ...], ...]
    name: str

    def __new__(cls, name: str, breakpoints: Sequence[float], coefficients: Sequence[Sequence[float]]) -> Pieces:  # noqa: D102
        x, c = np.asarray(breakpoints, float), np.asarray(coefficients, float)
        if len(x) < 1 or c.shape != (len(x) + 1, 4):
            raise WuchtError(
                f"{name}: {len(x)} breakpoints need {len(x) + 1} pieces of 4 coefficients, not {c.shape}", code="count"
            )
        if not (np.isfinite(x).all() and np.isfinite(c).all() and (np.diff(x) > 0).all()):
            raise WuchtError(f"{name}: the breakpoints must increase, and all numbers be finite", code="not-increasing")
        instance: Pieces = super().__new__(cls)
        instance.name, instance.breakpoints = name, tuple(x.tolist())
        instance.coefficients = tuple(tuple(row) for row in c.tolist())
        return instance

    def _hashable_content(self) -> tuple[Any, ...]:
        return (self.name, self.breakpoints, self.coefficients)

    def __getnewargs__(self) -> tuple[Any, ...]:
        return (self.name, self.breakpoints, self.coefficients)

    @cached_property
    def origins(self) -> tuple[float, ...]:
        """Points (k + 1,) at which the polynomials' arguments are zero."""
        return (self.breakpoints[0], *self.breakpoints)

    @cached_property
    def degree(self) -> int:
        """The highest power that occurs."""
        return max((k for row in self.coefficients for k, c in enumerate(row) if c), default=0)

    @cached_property
    def derivative(self) -> Pieces:
        """The derivative within the pieces; jumps have none."""
        return Pieces(f"{self.name}'", self.breakpoints, [(b, 2 * c, 3 * d, 0.0) for _, b, c, d in self.coefficients])

    @cached_property
    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return np.array(self.breakpoints), np.array(self.origins), np.array(self.coefficients)

    def __call__(self, x: Any) -> Any:
        """The value at a number or an array."""
        breakpoints, origins, coefficients = self._arrays
        at = np.asarray(x, float)
        i = np.searchsorted(breakpoints, at, side="right")
        s, c = at - origins[i], coefficients[i]
        value = c[..., 0] + s * (c[..., 1] + s * (c[..., 2] + s * c[..., 3]))
        return float(value) if value.ndim == 0 else value

    def jumps(self) -> tuple[float, ...]:
        """The breakpoints at which the value itself jumps."""
        x = np.array(self.breakpoints)
        i = np.arange(len(x))
        _, origins, c = self._arrays
        s = x - origins[i]
        before = c[i, 0] + s * (c[i, 1] + s * (c[i, 2] + s * c[i, 3]))
        scale = float(np.abs(c[:, 0]).max()) or 1.0
        return tuple(x[np.abs(c[i + 1, 0] - before) > 1e-12 * scale].tolist())


class PiecewiseCubic(sp.Function):  # type: ignore[misc]
    """``PiecewiseCubic(argument, pieces)``: the function of ``pieces`` at an argument. A number gives a number at once."""

    nargs = 2

    @classmethod
    def eval(cls, argument: sp.Expr, pieces: Pieces) -> sp.Expr | None:
        """A number for a number."""
        return sp.Float(pieces(float(argument))) if argument.is_number else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """The derivative by the argument."""
        argument, pieces = self.args
        return PiecewiseCubic(argument, pieces.derivative)

    def _eval_is_real(self) -> bool:
        return True

    def _eval_derivative(self, symbol: sp.Symbol) -> sp.Expr:
        inner = sp.diff(self.args[0], symbol)
        return inner * self.fdiff() if inner != 0 else sp.S.Zero

    def _sympystr(self, printer: Any) -> str:
        return f"{self.args[1].name}({printer._print(self.args[0])})"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        name = self.args[1].name.replace("_", "\\_")
        latex = f"\\mathrm{{{name}}}\\left({printer._print(self.args[0])}\\right)"
        return latex if exp is None else f"{{{latex}}}^{{{exp}}}"


def step(name: str, at: float, before: float, after: float) -> Pieces:
    """``before`` up to a breakpoint, ``after`` from there on."""
    return Pieces(name, (at,), ((before, 0, 0, 0), (after, 0, 0, 0)))


ABSOLUTE = Pieces("abs", (0.0,), ((0, -1, 0, 0), (0, 1, 0, 0)))
_SIGN = step("sign", 0.0, -1.0, 1.0)


def with_located_kinks(expression: sp.Expr, constant: Set[sp.Symbol] = frozenset()) -> sp.Expr:
    """The expression with |x| and sign(x) as piecewise functions, at whose breakpoints integration stops.

    constant: symbols that do not change during a motion; functions of these alone have no kinks in it. SymPy also writes
    sqrt(x^2) as abs(x).
    """

    def moves(e: sp.Expr) -> bool:
        return bool(e.free_symbols - constant)

    expression = expression.replace(lambda e: isinstance(e, sp.Abs) and moves(e), lambda e: PiecewiseCubic(e.args[0], ABSOLUTE))
    return expression.replace(lambda e: isinstance(e, sp.sign) and moves(e), lambda e: PiecewiseCubic(e.args[0], _SIGN))


def larger_value(a: sp.Expr, b: sp.Expr) -> sp.Expr:
    """The larger of two values."""
    return (a + b + sp.Abs(a - b)) / 2


def smaller_value(a: sp.Expr, b: sp.Expr) -> sp.Expr:
    """The smaller of two values."""
    return (a + b - sp.Abs(a - b)) / 2


def interpolated_pieces(name: str, abscissae: Sequence[float], ordinates: Sequence[float], kind: str) -> Pieces:
    """A function through points, constant before the first and after the last.

    abscissae, ordinates: (n,), the first increasing. kind: ``"steps"`` (each value holds until the next point), ``"linear"``,
    ``"smooth"`` (a + (b - a)(3 s^2 - 2 s^3): zero slope at each point, as a machine's control does), ``"monotone"``
    (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238-246: no overshoot between measured points), ``"spline"``
    (continuous curvature).
    """
    x, y = np.asarray(abscissae, float), np.asarray(ordinates, float)
    if len(x) == 1 or kind == "steps":
        return Pieces(name, x.tolist(), [(y[0], 0, 0, 0), *((v, 0, 0, 0) for v in y)])
    h, rise = np.diff(x), np.diff(y)
    if kind == "linear":
        inside = [(a, b, 0, 0) for a, b in zip(y, rise / h, strict=False)]
    elif kind == "smooth":
        inside = [(a, 0, 3 * r / d**2, -2 * r / d**3) for a, r, d in zip(y, rise, h, strict=False)]
    else:
        from scipy.interpolate import CubicSpline, PchipInterpolator

        # SciPy's rule for the ends of two points is a straight line for both.
        spline = PchipInterpolator(x, y) if kind == "monotone" else CubicSpline(x, y, bc_type="clamped")
        inside = [tuple(row[::-1]) for row in spline.c.T]
    return Pieces(name, x.tolist(), [(y[0], 0, 0, 0), *inside, (y[-1], 0, 0, 0)])


# The argument, clamped to -1 and 1.
CLAMP_TO_ONE = Pieces("within", (-1.0, 1.0), ((-1, 0, 0, 0), (-1, 1, 0, 0), (1, 0, 0, 0)))
