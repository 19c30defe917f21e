"""Printed equations: the second-order form of a mechanism in the symbols of the field, as text or LaTeX."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.energies import Internal
from wucht.mechanics.lagrange import Coordinate
from wucht.system import TIME, SecondOrder

_GREEK = (  # as far as TeX has them: the others are Latin letters
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi", "pi",
    "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
    "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega",
)  # fmt: skip
_VARIANTS = {"epsilon": "varepsilon", "phi": "varphi"}
_SYMBOL = re.compile(f"({'|'.join(sorted(_GREEK, key=len, reverse=True))}|[A-Za-z])(.{{0,2}})")  # a letter, and its index


@dataclass(frozen=True)
class Notation:
    """How coordinates and parameters are written: base symbols by internal name, such as ``drum.angle`` -> ``phi``."""

    names: Mapping[str, str]

    def symbols(self, coordinates: Sequence[Coordinate], latex: bool) -> dict[sp.Symbol, sp.Symbol]:
        """Printed symbols for positions, velocities and parameters."""
        shown = {sp.Symbol(k, real=True): sp.Symbol(latex_name(v) if latex else v) for k, v in self.names.items()}
        bases = {c.velocity: self.names[c.position.name] for c in coordinates}
        return shown | {v: sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for v, base in bases.items()}

    def acceleration(self, c: Coordinate, latex: bool) -> sp.Symbol:
        """The printed symbol of an acceleration."""
        base = self.names[c.position.name]
        return sp.Symbol(latex_name(base, 2) if latex else f"{base}''")


def latex_name(name: str, dots: int = 0) -> str:
    """A name such as ``b_carrier`` as LaTeX; a symbol with an index of its own, such as ``U1_drive``, has both below.

    dots: over the letter, for derivatives by time.
    """
    head, _, owner = name.partition("_")
    parts = _SYMBOL.fullmatch(head)
    letter, own = (parts[1], parts[2]) if parts else (f"\\mathrm{{{head}}}", "")
    shown = f"\\{_VARIANTS.get(letter, letter)}" if letter in _GREEK else letter
    if dots:
        shown = f"\\{'d' * dots}ot{{{shown}}}"
    below = ",".join(filter(None, (own, owner)))
    return shown + below_it(below) if below else shown


def below_it(index: str) -> str:
    """An index in upright letters."""
    escaped = index.replace("_", "\\_")
    return f"_{{\\mathrm{{{escaped}}}}}"


def written(
    motion: SecondOrder,
    coordinates: Sequence[Coordinate],
    notation: Notation,
    zero: Sequence[sp.Symbol],
    latex: bool,
    normalise: bool,
) -> list[str]:
    """One equation a coordinate, ``inertia = forces``.

    zero: parameters that are zero and left out. normalise: divide each equation by its own inertia. A coordinate whose motion
    is prescribed gets its velocity, and the equation of the force or torque that this takes.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    symbols = notation.symbols(coordinates, latex)
    lines = []
    for i, c in enumerate(coordinates):
        scale = motion.mass[i, i].xreplace(nothing) if normalise else sp.S.One
        left = sp.S.Zero
        for j, other in enumerate(coordinates):
            entry = motion.mass[i, j].xreplace(nothing)
            if entry != 0 and (other.prescribed is None or sp.diff(other.prescribed, TIME) != 0):
                factor = sp.simplify(entry / scale) if normalise else sp.factor_terms(sp.expand(entry))
                left += factor.xreplace(symbols) * notation.acceleration(other, latex)
        right = motion.forces[i].xreplace(nothing)
        right = sp.expand(right / scale) if normalise else right
        right = sp.collect(right, [c.velocity for c in coordinates]).xreplace(symbols)
        if c.prescribed is not None:
            lines.append(equation(symbols[c.velocity], c.prescribed.xreplace(nothing).xreplace(symbols), latex))
            name, index = ("T", "motor") if c.angle else ("F", "drive")
            right = right + sp.Symbol(latex_name(f"{name}_{index}") if latex else f"{name}_{index}")
        lines.append(equation(left, right, latex))
    return lines


def written_own(internal: Sequence[Internal], coordinates: Sequence[Coordinate], notation: Notation, latex: bool) -> list[str]:
    """The rates of the parts' own states, one equation each."""
    symbols = notation.symbols(coordinates, latex)
    bases = [notation.names[own.state.name] for own in internal]
    rates = [sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for base in bases]
    return [equation(rate, own.rate.xreplace(symbols), latex) for rate, own in zip(rates, internal, strict=True)]


def equation(left: sp.Expr, right: sp.Expr, latex: bool) -> str:
    """``left = right``."""
    return f"{sp.latex(left)} = {sp.latex(right)}" if latex else f"{sp.sstr(left)} = {sp.sstr(right)}"
