"""Printed equations, as text or LaTeX: a mechanism's second-order form in the symbols of the field, and averaged equations."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.energies import InternalState
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.rotating_bodies.averaged_system import AveragedSystem
from wucht.piecewise import PiecewiseCubic
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
LONGEST_LINE = 200  # characters of LaTeX: some 60 letters as they are typeset
_SHORT_SIDE = 60  # a left side of fewer stands before the first terms of the right one
_BREAK = 20  # of these for what marks the break of a line
_SHORT_FACTOR = 40  # a factor of fewer is repeated

Equation = tuple[sp.Expr, sp.Expr]
"""Both sides of an equation in printed symbols."""


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
) -> list[Equation]:
    """Return the equations of motion in printed symbols, one equation a coordinate, ``inertia = forces``.

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
    list of Equation
        For ``equation_text``.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    symbols = notation.symbols(coordinates, latex)
    equations: list[Equation] = []
    for i, c in enumerate(coordinates):
        scale = motion.mass[i, i].xreplace(nothing) if normalise else sp.S.One
        lhs = sp.S.Zero
        for j, column_coordinate in enumerate(coordinates):
            entry = motion.mass[i, j].xreplace(nothing)
            if entry != 0 and (
                column_coordinate.prescribed_velocity is None or sp.diff(column_coordinate.prescribed_velocity, TIME) != 0
            ):
                factor = sp.simplify(entry / scale) if normalise else _shorter(entry)
                lhs += factor.xreplace(symbols) * notation.acceleration(column_coordinate, latex)
        rhs = _without_empty_functions(motion.forces[i].xreplace(nothing))
        rhs = sp.expand(rhs / scale) if normalise else rhs
        rhs = _without_common_factors(sp.collect(rhs, [c.velocity for c in coordinates])).xreplace(symbols)
        if c.prescribed_velocity is not None:
            equations.append((symbols[c.velocity], c.prescribed_velocity.xreplace(nothing).xreplace(symbols)))
            name, index = ("T", "motor") if c.angle else ("F", "drive")
            rhs = rhs + sp.Symbol(latex_name(f"{name}_{index}") if latex else f"{name}_{index}")
        equations.append((lhs, rhs))
    return equations


def printed_state_rates(
    internal: Sequence[InternalState], coordinates: Sequence[Coordinate], notation: Notation, latex: bool
) -> list[Equation]:
    """Return the rates of the internal states of parts in printed symbols, one equation each."""
    symbols = notation.symbols(coordinates, latex)
    bases = [notation.names[state.state.name] for state in internal]
    rates = [sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for base in bases]
    return [(rate, state.rate.xreplace(symbols)) for rate, state in zip(rates, internal, strict=True)]


def _shorter(expression: sp.Expr) -> sp.Expr:
    """The expression as it is, or expanded, without common factors: whichever is shorter."""
    return min(map(sp.factor_terms, (sp.expand(expression), expression)), key=sp.count_ops)


def _without_empty_functions(expression: sp.Expr) -> sp.Expr:
    """Without piecewise functions that are zero everywhere, such as the derivative of a step."""
    functions = expression.atoms(PiecewiseCubic)
    return expression.xreplace({f: sp.S.Zero for f in functions if not any(map(any, f.args[1].coefficients))})


def _without_common_factors(expression: sp.Expr) -> sp.Expr:
    """Each term of a sum with its numbers in front: -b (v - w), not -b (2 v - 2 w)/2."""
    return sp.Add(*map(sp.factor_terms, sp.Add.make_args(expression)))


def short_terms(equations: Sequence[Equation]) -> tuple[list[Equation], list[Equation]]:
    """Return equations in LaTeX symbols whose terms fit a line, as far as that can be, and the definitions that they use.

    The factors that long terms share, and the sums within them, become h_1, h_2, ...
    """
    rows = _sums_apart(_factors_apart(equations))
    names = {left: sp.Symbol(latex_name(f"h_{k}")) for k, (left, _) in enumerate(rows[len(equations) :], 1)}
    rows = [(left.xreplace(names), right.xreplace(names)) for left, right in rows]
    return rows[: len(equations)], rows[len(equations) :]


def _factors_apart(equations: Sequence[Equation]) -> list[Equation]:
    """The equations with symbols for the factors that their long terms share, and the definitions of those."""
    long_terms = _long_terms(equations)
    factors, terms = sp.cse(long_terms, _new_symbols(), order="none")
    short = dict(zip(long_terms, terms, strict=True))
    inline, rows = dict[sp.Symbol, sp.Expr](), _with_terms(equations, short)
    for symbol, factor in factors:
        expression = factor.xreplace(inline)
        if expression.is_Add or len(sp.latex(expression)) > _SHORT_FACTOR:
            rows.append((symbol, expression))
        else:
            inline[symbol] = expression
    return [(left.xreplace(inline), right.xreplace(inline)) for left, right in rows]


def _sums_apart(equations: Sequence[Equation]) -> list[Equation]:
    """The equations with a symbol for the longest sum within each long term, and the definitions of those, likewise."""
    rows, apart, names = list(equations), dict[sp.Expr, sp.Symbol](), _new_symbols()
    for k, equation in enumerate(rows):  # which grows
        short = dict[sp.Expr, sp.Expr]()
        for term in _long_terms([equation]):
            sums = sorted((x for x in sp.preorder_traversal(term) if x.is_Add), key=lambda x: len(sp.latex(x)))
            if sums:
                if sums[-1] not in apart:
                    apart[sums[-1]] = next(names)
                    rows.append((apart[sums[-1]], sums[-1]))
                short[term] = term.xreplace({sums[-1]: apart[sums[-1]]})
        (rows[k],) = _with_terms([equation], short)
    return rows


def _new_symbols() -> Iterator[sp.Dummy]:
    """Symbols as wide as they are in the end, when they are numbered in order."""
    while True:
        yield sp.Dummy(latex_name("h_10"))


def _long_terms(equations: Sequence[Equation]) -> list[sp.Expr]:
    """The terms of both sides that are longer than a line."""
    terms = (term for equation in equations for side in equation for term in sp.Add.make_args(side))
    return [term for term in terms if len(sp.latex(term)) > LONGEST_LINE]


def _with_terms(equations: Sequence[Equation], new_terms: Mapping[sp.Expr, sp.Expr]) -> list[Equation]:
    """The equations with other terms in their sums."""

    def with_terms(side: sp.Expr) -> sp.Expr:
        return sp.Add(*(new_terms.get(term, term) for term in sp.Add.make_args(side)))

    return [(with_terms(left), with_terms(right)) for left, right in equations]


def equation_text(equation: Equation, latex: bool) -> str:
    """Return ``left = right``; in LaTeX ``left &= right``, broken between the terms of its sums where it is long."""
    left, right = equation
    if not latex:
        return f"{sp.sstr(left)} = {sp.sstr(right)}"
    left_lines, right_lines = _lines_of(left), _lines_of(right)
    first = f"&= {right_lines[0]}"
    if len(left_lines) == 1 and (len(left_lines[0]) < _SHORT_SIDE or len(left_lines[0]) + len(first) < LONGEST_LINE):
        left_lines, first = [], f"{left_lines[0]} {first}"
    return " \\notag \\\\\n  ".join([*left_lines, first, *(f"&\\quad {line}" for line in right_lines[1:])])


def _lines_of(side: sp.Expr) -> list[str]:
    """One side of an equation as lines of LaTeX."""
    lines: list[str] = []
    for term in side.as_ordered_terms():
        text = sp.latex(term)
        sign = "- " if text.startswith("-") else "+ " if lines else ""
        text = sign + text.removeprefix("-").lstrip()
        if lines and len(lines[-1]) + 1 + len(text) <= LONGEST_LINE - _BREAK:
            lines[-1] += f" {text}"
        else:
            lines.append(text)
    return lines


def printed_averaged_equations(
    averaged_system: AveragedSystem, notation: Notation, zero: Sequence[sp.Symbol], latex: bool
) -> tuple[list[Equation], list[Equation]]:
    """Return the rows in printed symbols, and the definitions they use in order.

    zero: parameters that are zero and removed. Phases are alpha, speeds omega (the main rotor's without an index); a prime is
    d/dt; Re and Im are the parts of a complex amplitude.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    inline, definitions = dict[sp.Symbol, sp.Expr](), list[tuple[sp.Symbol, sp.Expr]]()
    for symbol, expression in averaged_system.row_definitions:
        short_expression = expression.xreplace(nothing).xreplace(inline)
        if short_expression.is_Atom or short_expression.func in (sp.cos, sp.sin):
            inline[symbol] = short_expression
        else:
            definitions.append((symbol, short_expression))
    rows = [
        (lhs.xreplace(nothing), rhs.xreplace(nothing).xreplace(inline))
        for lhs, rhs in averaged_system.rows
        if not str(rhs).endswith(".slip")
    ]
    row_definitions = needed_definitions(definitions, [e for row in rows for e in row])
    printed_symbols = _printed_symbols(
        averaged_system, notation, set().union(*(e.free_symbols for pair in (*rows, *row_definitions) for e in pair)), latex
    )
    row_equations = [(_collect_rates(lhs), sp.factor_terms(rhs) if rhs.is_Mul else rhs) for lhs, rhs in rows]
    printed_rows, printed_definitions = (
        [(left.xreplace(printed_symbols), right.xreplace(printed_symbols)) for left, right in equations]
        for equations in (row_equations, row_definitions)
    )
    return printed_rows, printed_definitions


def _collect_rates(expression: sp.Expr) -> sp.Expr:
    """A sum of rates with simple coefficients."""
    rates = sorted((s for s in expression.free_symbols if s.name.endswith((".rate", ".slip"))), key=str)
    terms = sp.collect(sp.expand(expression), rates, evaluate=False)
    return sp.Add(*(rate * sp.factor(coefficient) for rate, coefficient in terms.items()))


def _printed_symbols(
    averaged_system: AveragedSystem, notation: Notation, symbols: set[sp.Symbol], latex: bool
) -> Mapping[sp.Symbol, sp.Symbol]:
    parameters = set(notation.names.values())
    speed = next(n for n in ("omega", "Omega", "w", "n") if n not in parameters)
    phase = next(n for n in ("alpha", "psi") if n not in parameters)
    main = averaged_system.bodies.names[0]
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
    text = _latex_definition(head, index) if latex else f"{head}_{index}"
    if not part:
        return text
    return f"\\operatorname{{{part.capitalize()}}}({text})" if latex else f"{part.capitalize()}({text})"


def _latex_definition(head: str, index: str) -> str:
    """A head such as ``D1`` or ``z,x`` has its index before that of the definition."""
    if head in _LATEX_HEADS:
        return _LATEX_HEADS[head] + latex_subscript(index)
    letter, head_index = head[0], head[1:].strip(",")
    return letter + latex_subscript(",".join(filter(None, (head_index, index))))
