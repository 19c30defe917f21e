"""Printed equations: the second-order form of a mechanism in the symbols of the field, as text or LaTeX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.lagrange import Coordinate
from wucht.system import TIME, SecondOrder

_GREEK = {"epsilon": "\\varepsilon", "phi": "\\varphi", "phi_0": "\\varphi_0"}


@dataclass(frozen=True)
class Notation:
    """How coordinates and parameters are written: base symbols by internal name, such as ``drum.angle`` -> ``phi``."""

    names: Mapping[str, str]

    def symbols(self, coordinates: Sequence[Coordinate], latex: bool) -> dict[sp.Symbol, sp.Symbol]:
        """Printed symbols for positions, velocities and parameters."""
        shown = {sp.Symbol(k, real=True): sp.Symbol(latex_name(v) if latex else v) for k, v in self.names.items()}
        bases = {c.velocity: self.names[c.position.name] for c in coordinates}
        return shown | {v: sp.Symbol(_dotted(base, 1) if latex else f"{base}'") for v, base in bases.items()}

    def acceleration(self, c: Coordinate, latex: bool) -> sp.Symbol:
        """The printed symbol of an acceleration."""
        base = self.names[c.position.name]
        return sp.Symbol(_dotted(base, 2) if latex else f"{base}''")


def latex_name(name: str) -> str:
    """A name such as ``b_carrier`` as LaTeX."""
    head, _, index = name.partition("_")
    head = _GREEK.get(head, head)
    known = head if len(head) == 1 or head.startswith("\\") else f"\\{head}"
    return f"{known}_{{\\mathrm{{{index}}}}}" if index else known


def _dotted(name: str, dots: int) -> str:
    head, _, index = name.partition("_")
    return f"\\{'d' * dots}ot{{{latex_name(head)}}}" + (f"_{{\\mathrm{{{index}}}}}" if index else "")


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
            right = right + sp.Symbol(f"{name}_{{\\mathrm{{{index}}}}}" if latex else f"{name}_{index}")
        lines.append(equation(left, right, latex))
    return lines


def equation(left: sp.Expr, right: sp.Expr, latex: bool) -> str:
    """``left = right``."""
    return f"{sp.latex(left)} = {sp.latex(right)}" if latex else f"{sp.sstr(left)} = {sp.sstr(right)}"
