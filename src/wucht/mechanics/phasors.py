"""Symbolic complex amplitudes as pairs of real expressions, and the harmonic response of a linear carrier as a program.

x = Re[z exp(i theta)] is written with z = re + i im. Intermediate results are named, so that they stay small and the carrier
may have any number of coordinates.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from wucht.system import needed_definitions


@dataclass(frozen=True)
class Phasor:
    """A complex amplitude ``re + i im`` of two real expressions."""

    re: sp.Expr = sp.S.Zero
    im: sp.Expr = sp.S.Zero

    @classmethod
    def of(cls, expression: sp.Expr) -> Phasor:
        """A complex expression in real symbols, which is expanded."""
        terms = sp.Add.make_args(sp.expand(expression))
        imaginary = [-sp.I * t for t in terms if t.has(sp.I)]
        return cls(sp.Add(*(t for t in terms if not t.has(sp.I))), sp.Add(*imaginary))

    def __add__(self, addend: Phasor) -> Phasor:
        return Phasor(self.re + addend.re, self.im + addend.im)

    def __sub__(self, subtrahend: Phasor) -> Phasor:
        return Phasor(self.re - subtrahend.re, self.im - subtrahend.im)

    def __mul__(self, factor: Phasor | sp.Expr) -> Phasor:
        """The product with a complex amplitude or a real factor."""
        if not isinstance(factor, Phasor):
            return self.scale(factor)
        return Phasor(self.re * factor.re - self.im * factor.im, self.re * factor.im + self.im * factor.re)

    __rmul__ = __mul__

    def scale(self, factor: sp.Expr) -> Phasor:
        """The product with a real factor."""
        return Phasor(factor * self.re, factor * self.im)

    @property
    def conj(self) -> Phasor:
        """The complex conjugate."""
        return Phasor(self.re, -self.im)

    @property
    def times_i(self) -> Phasor:
        """The product with i."""
        return Phasor(-self.im, self.re)

    @property
    def is_zero(self) -> bool:
        """True if both parts are literally zero."""
        return bool(self.re == 0 and self.im == 0)


ZERO, IMAGINARY_UNIT = Phasor(), Phasor(sp.S.Zero, sp.S.One)
Phasors = Sequence[Phasor] | np.ndarray


def total(phasors: Sequence[Phasor]) -> Phasor:
    """The sum."""
    return Phasor(sp.Add(*(p.re for p in phasors)), sp.Add(*(p.im for p in phasors)))


def product(first: Phasors, second: Phasors) -> Phasor:
    """The sum of first_k second_k, without conjugation."""
    return total([a * b for a, b in zip(first, second, strict=True) if not (a.is_zero or b.is_zero)])


@dataclass
class Lines:
    """Collects definitions: ``(symbol, expression)`` pairs in order of evaluation."""

    pairs: list[tuple[sp.Symbol, sp.Expr]] = field(default_factory=list)

    def name(self, expression: sp.Expr, label: str) -> sp.Expr:
        """A symbol for the expression, unless it is as short as a symbol already."""
        if expression.is_Atom or (expression.is_Mul and len(expression.args) == 2 and expression.args[0] == -1):
            return expression
        symbol = sp.Symbol(label, real=True)
        self.pairs.append((symbol, expression))
        return symbol

    def phasor(self, value: Phasor, label: str) -> Phasor:
        """Symbols for both parts of a complex amplitude."""
        return Phasor(self.name(value.re, f"{label}.re"), self.name(value.im, f"{label}.im"))

    def phasors(self, values: Phasors, label: str, names: Sequence[str]) -> list[Phasor]:
        """Symbols for several complex amplitudes."""
        return [self.phasor(v, f"{label}[{n}]") for v, n in zip(values, names, strict=True)]

    def rates(
        self,
        variable_rates: Mapping[sp.Symbol, sp.Expr],
        expressions: Sequence[sp.Expr],
        suffix: str,
        pairs: Sequence[tuple[sp.Symbol, sp.Expr]],
    ) -> list[sp.Expr]:
        """The rates of change of expressions in these definitions, whose variables change at the given rates."""
        rates_by_symbol = dict(variable_rates)

        def rate(e: sp.Expr) -> sp.Expr:
            return sp.Add(
                *(sp.diff(e, s) * rates_by_symbol[s] for s in sorted(e.free_symbols & rates_by_symbol.keys(), key=str))
            )

        for symbol, expression in needed_definitions(pairs, expressions):
            change = rate(expression)
            if change != 0:
                rates_by_symbol[symbol] = self.name(change, f"{symbol.name}{suffix}")
        return [rate(e) for e in expressions]


class HarmonicResponse:
    """``z = H(w) F`` with H = (K - w^2 M + i w C)^-1, factorised once (L D L^T of a complex symmetric matrix).

    Without pivoting: the damping matrix is positive definite where the carrier is damped, and then no pivot is zero.
    """

    def __init__(
        self, mass: sp.Matrix, damping: sp.Matrix, stiffness: sp.Matrix, frequency: sp.Expr, names: Sequence[str], lines: Lines,
        label: str = "D",
    ) -> None:  # fmt: skip
        self.names, self.lines, self.label = names, lines, label
        self.rows: list[dict[int, Phasor]] = [{} for _ in names]
        self.inverse: list[Phasor] = []
        for i, j in itertools.combinations_with_replacement(range(len(names)), 2):
            entry = dynamic_stiffness(mass[i, j], damping[i, j], stiffness[i, j], frequency)
            if not entry.is_zero:
                self.rows[i][j] = lines.phasor(entry, f"{label}[{names[i]}{names[j] if j > i else ''}]")
        for k, row in enumerate(self.rows):
            self.inverse.append(self._reciprocal(row[k], names[k]))
            coupled_indices = [j for j in row if j > k]
            for i in coupled_indices:
                factor = row[i] * self.inverse[k]
                for j in (j for j in coupled_indices if j >= i):
                    new_entry = self.rows[i].get(j, ZERO) - factor * row[j]
                    self.rows[i][j] = lines.phasor(new_entry, f"{label}{k + 1}[{names[i]}{names[j]}]")

    def _reciprocal(self, pivot: Phasor, name: str) -> Phasor:
        if pivot.im == 0:
            return self.lines.phasor(Phasor(1 / pivot.re), f"H[{name}]")
        square = self.lines.name(pivot.re**2 + pivot.im**2, f"|{self.label}|^2[{name}]")
        return self.lines.phasor(pivot.conj * (1 / square), f"H[{name}]" if self.label == "D" else f"1/{self.label}[{name}]")

    def __call__(self, force: Phasors, label: str) -> np.ndarray:
        """z for the force amplitudes (m), named ``label[name].re`` and ``.im``."""
        right = list(force)
        for k, row in enumerate(self.rows):
            for i in (i for i in row if i > k):
                new_force = right[i] - row[i] * self.inverse[k] * right[k]
                right[i] = self.lines.phasor(new_force, f"{label},{self.names[k]}[{self.names[i]}]")
        solution = np.full(len(right), ZERO)
        for k, row in reversed(list(enumerate(self.rows))):
            rest = total([row[i] * solution[i] for i in row if i > k])
            solution[k] = self.lines.phasor((right[k] - rest) * self.inverse[k], f"{label}[{self.names[k]}]")
        return solution


def dynamic_stiffness(mass: sp.Expr, damping: sp.Expr, stiffness: sp.Expr, w: sp.Expr) -> Phasor:
    """K - w^2 M + i w C of one pair of coordinates."""
    return Phasor(stiffness - w**2 * mass, w * damping)
