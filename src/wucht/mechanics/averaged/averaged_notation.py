"""The averaged equations printed: rows, then the definitions they use, as text or LaTeX."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import sympy as sp

from wucht.mechanics.averaged.averaged_system import AveragedSystem
from wucht.mechanics.notation import Notation, equation, latex_name

_PART = re.compile(r"^(?P<head>[^\[]+)\[(?P<index>[^\]]+)\](\.(?P<part>re|im))?$")
_LATEX_HEADS = {"|D|^2": "\\left|D\\right|^2", "nu": "\\nu"}


def written_averaged(
    equations: AveragedSystem, notation: Notation, zero: Sequence[sp.Symbol], latex: bool
) -> tuple[list[str], list[str]]:
    """The rows, and the definitions they use in order.

    zero: parameters that are zero and left out. Phases are alpha, speeds omega (the main rotor's without an index); a dash is
    d/dt; Re and Im are the parts of a complex amplitude.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    inline, definitions = dict[sp.Symbol, sp.Expr](), list[tuple[sp.Symbol, sp.Expr]]()
    for symbol, expression in equations.shown:
        reduced = expression.xreplace(nothing).xreplace(inline)
        if reduced.is_Atom or reduced.func in (sp.cos, sp.sin):
            inline[symbol] = reduced
        else:
            definitions.append((symbol, reduced))
    own = [(left, right) for left, right in equations.rows if not str(right).endswith(".slip")]
    rows = [(left.xreplace(nothing), right.xreplace(nothing).xreplace(inline)) for left, right in own]
    used = set().union(*(e.free_symbols for row in rows for e in row))
    needed = []
    for symbol, expression in reversed(definitions):
        if symbol in used:
            needed.append((symbol, expression))
            used |= expression.free_symbols
    shown = _names(equations, notation, used | {s for s, _ in needed}, latex)
    return (
        [equation(_collected(left).xreplace(shown), _tidy(right).xreplace(shown), latex) for left, right in rows],
        [equation(symbol.xreplace(shown), expression.xreplace(shown), latex) for symbol, expression in reversed(needed)],
    )


def _collected(left: sp.Expr) -> sp.Expr:
    """A sum of rates with simple coefficients."""
    rates = sorted((s for s in left.free_symbols if s.name.endswith((".rate", ".slip"))), key=str)
    terms = sp.collect(sp.expand(left), rates, evaluate=False)
    return sp.Add(*(rate * sp.factor(coefficient) for rate, coefficient in terms.items()))


def _tidy(expression: sp.Expr) -> sp.Expr:
    return sp.factor_terms(expression) if expression.is_Mul else expression


def _names(equations: AveragedSystem, notation: Notation, used: set[sp.Symbol], latex: bool) -> Mapping[sp.Symbol, sp.Symbol]:
    parameters = set(notation.names.values())
    speed = next(n for n in ("omega", "Omega", "w", "n") if n not in parameters)
    phase = next(n for n in ("alpha", "psi") if n not in parameters)
    main = equations.bodies.names[0]
    names = {}
    for symbol in used:
        if symbol.name in notation.names:  # before states: the parameter drive.speed is no body's speed
            given = notation.names[symbol.name]
            name: str | None = latex_name(given) if latex else given
        else:
            name = _of_state(symbol.name, main, speed, phase, latex) or _of_definition(symbol.name, latex)
        names[symbol] = sp.Symbol(name or symbol.name)
    return names


def _of_state(name: str, main: str, speed: str, phase: str, latex: bool) -> str | None:
    body, _, what = name.partition(".")
    letters = {"phase": (phase, 0), "speed": (speed, 0), "speed.rate": (speed, 1), "phase.rate": (phase, 1), "slip": (phase, 1)}
    if what not in letters:
        return None
    letter, dots = letters[what]
    index = "" if body == main and letter == speed else f"_{body}"
    if not latex:
        return letter + index + "'" * dots
    head, _, below = latex_name(letter + index).partition("_")
    head = f"\\dot{{{head}}}" if dots else head
    return f"{head}_{below}" if below else head


def _of_definition(name: str, latex: bool) -> str | None:
    match = _PART.match(name)
    if match is None:
        return None
    head, index, part = match["head"], match["index"], match["part"]
    if not latex:
        plain = f"{head}_{index}"
        return f"{part.capitalize()}({plain})" if part else plain
    shown = f"{_LATEX_HEADS.get(head, head)}_{{\\mathrm{{{index}}}}}"
    return f"\\operatorname{{{part.capitalize()}}}({shown})" if part else shown
