"""The averaged equations printed: rows, then the definitions they use, as text or LaTeX."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import sympy as sp

from wucht.mechanics.averaged.averaged_system import AveragedSystem
from wucht.mechanics.notation import Notation, below_it, equation, latex_name
from wucht.system import needed_definitions

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
    rows = [
        (left.xreplace(nothing), right.xreplace(nothing).xreplace(inline))
        for left, right in equations.rows
        if not str(right).endswith(".slip")
    ]
    needed = needed_definitions(definitions, [e for row in rows for e in row])
    shown = _names(equations, notation, set().union(*(e.free_symbols for pair in (*rows, *needed) for e in pair)), latex)
    return (
        [
            equation(
                _collected(left).xreplace(shown), (sp.factor_terms(right) if right.is_Mul else right).xreplace(shown), latex
            )
            for left, right in rows
        ],
        [equation(symbol.xreplace(shown), expression.xreplace(shown), latex) for symbol, expression in needed],
    )


def _collected(left: sp.Expr) -> sp.Expr:
    """A sum of rates with simple coefficients."""
    rates = sorted((s for s in left.free_symbols if s.name.endswith((".rate", ".slip"))), key=str)
    terms = sp.collect(sp.expand(left), rates, evaluate=False)
    return sp.Add(*(rate * sp.factor(coefficient) for rate, coefficient in terms.items()))


def _names(equations: AveragedSystem, notation: Notation, used: set[sp.Symbol], latex: bool) -> Mapping[sp.Symbol, sp.Symbol]:
    parameters = set(notation.names.values())
    speed = next(n for n in ("omega", "Omega", "w", "n") if n not in parameters)
    phase = next(n for n in ("alpha", "psi") if n not in parameters)
    main = equations.bodies.names[0]
    names = {}
    for symbol in used:
        if symbol.name in notation.names:  # before states: the parameter drive.speed is no body's speed
            name = latex_name(notation.names[symbol.name]) if latex else notation.names[symbol.name]
        else:
            name = _of_state(symbol.name, main, speed, phase, latex) or _of_definition(symbol.name, latex)
        names[symbol] = sp.Symbol(name)
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
    return latex_name(letter + index, dots)


def _of_definition(name: str, latex: bool) -> str:
    match = _PART.match(name)
    if match is None:
        return name
    head, index, part = match["head"], match["index"], match["part"]
    shown = _LATEX_HEADS.get(head, head) + below_it(index) if latex else f"{head}_{index}"
    if not part:
        return shown
    return f"\\operatorname{{{part.capitalize()}}}({shown})" if latex else f"{part.capitalize()}({shown})"
