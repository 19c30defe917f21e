"""Printed equations, as text or LaTeX: a mechanism's second-order form in the symbols of the field, and averaged equations."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.averaged.averaged_system import AveragedSystem
from wucht.mechanics.energies import Internal
from wucht.mechanics.lagrange import Coordinate
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
    """Printed symbols of coordinates and parameters: base symbols by internal name, such as ``drum.angle`` -> ``phi``."""

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
    """A name such as ``b_carrier`` as LaTeX; a symbol with a second index, such as ``U1_drive``, has both below.

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

    zero: parameters that are zero and removed. normalise: divide each equation by its inertia. A coordinate whose motion is
    prescribed gets its velocity, and the equation of the force or torque that enforces it.
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
    """The rates of the internal states of parts, one equation each."""
    symbols = notation.symbols(coordinates, latex)
    bases = [notation.names[own.state.name] for own in internal]
    rates = [sp.Symbol(latex_name(base, 1) if latex else f"{base}'") for base in bases]
    return [equation(rate, own.rate.xreplace(symbols), latex) for rate, own in zip(rates, internal, strict=True)]


def equation(left: sp.Expr, right: sp.Expr, latex: bool) -> str:
    """``left = right``."""
    return f"{sp.latex(left)} = {sp.latex(right)}" if latex else f"{sp.sstr(left)} = {sp.sstr(right)}"


def written_averaged(
    equations: AveragedSystem, notation: Notation, zero: Sequence[sp.Symbol], latex: bool
) -> tuple[list[str], list[str]]:
    """The rows, and the definitions they use in order.

    zero: parameters that are zero and removed. Phases are alpha, speeds omega (the main rotor's without an index); a prime is
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
