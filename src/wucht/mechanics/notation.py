"""Printed equations, as text or LaTeX: a mechanism's second-order form in the symbols of the field, and averaged equations."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.energies import InternalState
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.rotating_bodies.averaged_system import AveragedSystem
from wucht.system import TIME, SecondOrder, needed_definitions

_GREEK = (  # those with a TeX command: the others are Latin letters
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi", "pi",
    "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
    "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega",
)  # fmt: skip
_VARIANTS = {"epsilon": "varepsilon", "phi": "varphi"}
_SYMBOL = re.compile(f"({'|'.join(sorted(_GREEK, key=len, reverse=True))}|[A-Za-z])(.{{0,2}})")  # a letter, and its index
_PART = re.compile(r"^(?P<head>[^\[]+)\[(?P<index>[^\]]+)\](\.(?P<part>re|im))?$")
_LATEX_HEADS = {"|D|^2": "\\left|D\\right|^2", "nu": "\\nu"}


@dataclass(frozen=True)
class Notation:
    """Printed symbols of coordinates and parameters.

    Parameters
    ----------
    names : mapping of str to str
        Base symbols by internal name, such as ``drum.angle`` -> ``phi``.
    """

    names: Mapping[str, str]

    def symbols(self, coordinates: Sequence[Coordinate], latex: bool) -> dict[sp.Symbol, sp.Symbol]:
        """Printed symbols for positions, velocities and parameters."""
        printed_symbols = {sp.Symbol(k, real=True): sp.Symbol(latex_name(v) if latex else v) for k, v in self.names.items()}
        bases = {c.velocity: self.names[c.position.name] for c in coordinates}
        return printed_symbols | {v: sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for v, base in bases.items()}

    def acceleration(self, c: Coordinate, latex: bool) -> sp.Symbol:
        """The printed symbol of an acceleration."""
        base = self.names[c.position.name]
        return sp.Symbol(latex_name(base, 2) if latex else f"{base}''")


def latex_name(name: str, dots: int = 0) -> str:
    """A name such as ``b_carrier`` as LaTeX; a symbol with a second index, such as ``U1_drive``, has both below.

    dots: over the letter, for derivatives by time.
    """
    head, _, owner = name.partition("_")
    parts = _SYMBOL.fullmatch(head)
    letter, letter_index = (parts[1], parts[2]) if parts else (f"\\mathrm{{{head}}}", "")
    latex_letter = f"\\{_VARIANTS.get(letter, letter)}" if letter in _GREEK else letter
    if dots:
        latex_letter = f"\\{'d' * dots}ot{{{latex_letter}}}"
    below = ",".join(filter(None, (letter_index, owner)))
    return latex_letter + latex_subscript(below) if below else latex_letter


def latex_subscript(index: str) -> str:
    """An index in upright letters."""
    escaped_index = index.replace("_", "\\_")
    return f"_{{\\mathrm{{{escaped_index}}}}}"


def printed_equations(
    motion: SecondOrder,
    coordinates: Sequence[Coordinate],
    notation: Notation,
    zero: Sequence[sp.Symbol],
    latex: bool,
    normalise: bool,
) -> list[str]:
    """Write the equations of motion as text or LaTeX, one equation a coordinate, ``inertia = forces``.

    A coordinate whose motion is prescribed gets its velocity, and the equation of the force or torque that enforces it.

    Parameters
    ----------
    motion : SecondOrder
    coordinates : sequence of Coordinate
    notation : Notation
    zero : sequence of sympy.Symbol
        Parameters that are zero and removed.
    latex : bool
    normalise : bool
        Divide each equation by its inertia.

    Returns
    -------
    list of str
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    symbols = notation.symbols(coordinates, latex)
    lines = []
    for i, c in enumerate(coordinates):
        scale = motion.mass[i, i].xreplace(nothing) if normalise else sp.S.One
        lhs = sp.S.Zero
        for j, column_coordinate in enumerate(coordinates):
            entry = motion.mass[i, j].xreplace(nothing)
            if entry != 0 and (
                column_coordinate.prescribed_velocity is None or sp.diff(column_coordinate.prescribed_velocity, TIME) != 0
            ):
                factor = sp.simplify(entry / scale) if normalise else sp.factor_terms(sp.expand(entry))
                lhs += factor.xreplace(symbols) * notation.acceleration(column_coordinate, latex)
        rhs = motion.forces[i].xreplace(nothing)
        rhs = sp.expand(rhs / scale) if normalise else rhs
        rhs = sp.collect(rhs, [c.velocity for c in coordinates]).xreplace(symbols)
        if c.prescribed_velocity is not None:
            lines.append(
                printed_equation(symbols[c.velocity], c.prescribed_velocity.xreplace(nothing).xreplace(symbols), latex)
            )
            name, index = ("T", "motor") if c.angle else ("F", "drive")
            rhs = rhs + sp.Symbol(latex_name(f"{name}_{index}") if latex else f"{name}_{index}")
        lines.append(printed_equation(lhs, rhs, latex))
    return lines


def printed_state_rates(
    internal: Sequence[InternalState], coordinates: Sequence[Coordinate], notation: Notation, latex: bool
) -> list[str]:
    """The rates of the internal states of parts, one equation each."""
    symbols = notation.symbols(coordinates, latex)
    bases = [notation.names[state.state.name] for state in internal]
    rates = [sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for base in bases]
    return [printed_equation(rate, state.rate.xreplace(symbols), latex) for rate, state in zip(rates, internal, strict=True)]


def printed_equation(lhs: sp.Expr, rhs: sp.Expr, latex: bool) -> str:
    """``left = right``."""
    return f"{sp.latex(lhs)} = {sp.latex(rhs)}" if latex else f"{sp.sstr(lhs)} = {sp.sstr(rhs)}"


def printed_averaged_equations(
    equations: AveragedSystem, notation: Notation, zero: Sequence[sp.Symbol], latex: bool
) -> tuple[list[str], list[str]]:
    """The rows, and the definitions they use in order.

    zero: parameters that are zero and removed. Phases are alpha, speeds omega (the main rotor's without an index); a prime is
    d/dt; Re and Im are the parts of a complex amplitude.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    inline, definitions = dict[sp.Symbol, sp.Expr](), list[tuple[sp.Symbol, sp.Expr]]()
    for symbol, expression in equations.row_definitions:
        short_expression = expression.xreplace(nothing).xreplace(inline)
        if short_expression.is_Atom or short_expression.func in (sp.cos, sp.sin):
            inline[symbol] = short_expression
        else:
            definitions.append((symbol, short_expression))
    rows = [
        (lhs.xreplace(nothing), rhs.xreplace(nothing).xreplace(inline))
        for lhs, rhs in equations.rows
        if not str(rhs).endswith(".slip")
    ]
    row_definitions = needed_definitions(definitions, [e for row in rows for e in row])
    printed_symbols = _printed_symbols(
        equations, notation, set().union(*(e.free_symbols for pair in (*rows, *row_definitions) for e in pair)), latex
    )
    return (
        [
            printed_equation(
                _collect_rates(lhs).xreplace(printed_symbols),
                (sp.factor_terms(rhs) if rhs.is_Mul else rhs).xreplace(printed_symbols),
                latex,
            )
            for lhs, rhs in rows
        ],
        [
            printed_equation(symbol.xreplace(printed_symbols), expression.xreplace(printed_symbols), latex)
            for symbol, expression in row_definitions
        ],
    )


def _collect_rates(expression: sp.Expr) -> sp.Expr:
    """A sum of rates with simple coefficients."""
    rates = sorted((s for s in expression.free_symbols if s.name.endswith((".rate", ".slip"))), key=str)
    terms = sp.collect(sp.expand(expression), rates, evaluate=False)
    return sp.Add(*(rate * sp.factor(coefficient) for rate, coefficient in terms.items()))


def _printed_symbols(
    equations: AveragedSystem, notation: Notation, symbols: set[sp.Symbol], latex: bool
) -> Mapping[sp.Symbol, sp.Symbol]:
    parameters = set(notation.names.values())
    speed = next(n for n in ("omega", "Omega", "w", "n") if n not in parameters)
    phase = next(n for n in ("alpha", "psi") if n not in parameters)
    main = equations.bodies.names[0]
    names = {}
    for symbol in symbols:
        if symbol.name in notation.names:  # before states: the parameter drive.speed is no body's speed
            name = latex_name(notation.names[symbol.name]) if latex else notation.names[symbol.name]
        else:
            name = _state_notation(symbol.name, main, speed, phase, latex) or _definition_notation(symbol.name, latex)
        names[symbol] = sp.Symbol(name)
    return names


def _state_notation(name: str, main: str, speed: str, phase: str, latex: bool) -> str | None:
    body, _, quantity = name.partition(".")
    letters = {"phase": (phase, 0), "speed": (speed, 0), "speed.rate": (speed, 1), "phase.rate": (phase, 1), "slip": (phase, 1)}
    if quantity not in letters:
        return None
    letter, dots = letters[quantity]
    index = "" if body == main and letter == speed else f"_{body}"
    if not latex:
        return letter + index + "'" * dots
    return latex_name(letter + index, dots)


def _definition_notation(name: str, latex: bool) -> str:
    match = _PART.match(name)
    if match is None:
        return name
    head, index, part = match["head"], match["index"], match["part"]
    text = _LATEX_HEADS.get(head, head) + latex_subscript(index) if latex else f"{head}_{index}"
    if not part:
        return text
    return f"\\operatorname{{{part.capitalize()}}}({text})" if latex else f"{part.capitalize()}({text})"
