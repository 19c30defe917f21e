"""The page docs/errata.md: printed equation, what the derivation gives, the residual."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy.simplify.fu import TR10i

from .check import Check, is_zero

TITLES = {
    "002": "002: O. Drozdetskaya, Zur Dynamik eines unwuchtigen Rotors mit Selbstauswuchtsystem, KIT Karlsruhe 2020",
    "000": "000: L. Sperling, H. Duckstein, B. Ryzhik, Selbsttätiges Auswuchten mittels zweier beliebiger Rollen",
    "001": "001: L. Sperling, F. Merten, H. Duckstein, Rotation und Vibration in Beispielen",
    "004": "004: K. Kaltofen, Saubere HS-Bewegungen bei periodisch schwankender Antriebswinkelgeschwindigkeit",
}

HEAD = """\
# Errata: the papers' equations against their derivation

Written by `python -m tests.validation.errata` from the checks in `tests/validation/errata`, which the tests run; do not edit.

Each printed equation is set against what the program derives from the energies of a machine (its full equations, its slow
equations with symbols for all parameters), or, for the few that no machine has, against SymPy's own derivation from the
equations before it. Unless an entry says otherwise, the residual is the derived right-hand side less the printed one. Zero is
exact. Where the print is wrong the residual of the print is shown, and below it the form whose residual is zero. Columns in
brackets are several equations at once. A bar over a slow variable is left out.
"""

ELSEWHERE = """\
## What is not on this page

- The equations of motion, 002 (3.28)-(3.61), (4.1)-(4.20), 000 (18), 001 (9)-(11), (42), (43), (55), (64), (65): in
  `tests/validation/test_drozdetskaya_2020.py`, `test_sperling_rollers.py`, `test_sperling_vibration.py`.
- 001 (10): that L depends on the angular velocity is a matter of its list of arguments, which a residual does not see.
- 002, 5.1: "Abb. 5.3" where Abb. 5.2 is meant; no equation.
- 001 (21): the band in which the entrained motion exists is not the one reached from rest: `test_sperling_entrainment.py`.
- 002, type I "always stable": that holds for the averaged equations; the full ones can lose it where the damping is light.
- 002, 6.2: with one pendulum and s = 1 as printed nothing modulates; with two the printed sets do, but not stably "over the
  whole range": their pendulums part before its end: `test_exciter.py`.
"""


def page(checks: Sequence[Check]) -> str:
    """The page in Markdown with LaTeX formulas."""
    parts = [HEAD, _overview(checks)]
    for source, title in TITLES.items():
        own = [c for c in checks if c.source == source]
        parts.append(f"## {title}\n")
        for heading, wanted in (("Misprints", True), ("Right as printed", False)):
            chosen = [c for c in own if c.misprinted is wanted]
            if chosen:
                parts.append(f"### {heading}\n")
                parts += [_entry(c) for c in chosen]
    return "\n".join([*parts, ELSEWHERE])


def _overview(checks: Sequence[Check]) -> str:
    rows = ["| source | checks | misprints |", "|---|---|---|"]
    for source in TITLES:
        own = [c for c in checks if c.source == source]
        wrong = dict.fromkeys(c.equation for c in own if c.misprinted)
        rows.append(f"| {source} | {len(own)} | {'; '.join(wrong)} |")
    return "\n".join([*rows, ""])


def _entry(check: Check) -> str:
    claim = check.claim()
    if claim.corrected is None and is_zero(check.of_print):
        return f"**{check.equation}** {check.says} Residual: 0\n\n{_formula(check, claim.printed)}"
    lines = [f"#### {check.equation}\n", f"{check.says}\n", f"printed:\n\n{_formula(check, claim.printed)}"]
    lines.append(_residual(check.of_print))
    if claim.corrected is not None:
        lines += [f"derived:\n\n{_formula(check, claim.corrected)}", _residual(check.of_correction)]
    return "\n".join(lines)


def _formula(check: Check, right: sp.Basic) -> str:
    return f"$${check.left} = {sp.latex(right)}$$\n"


def _residual(residual: sp.Basic) -> str:
    if is_zero(residual):
        return "residual: 0\n"
    return f"residual:\n\n$${sp.latex(_shorter(residual))}$$\n"


def _shorter(residual: sp.Basic) -> sp.Basic:
    """Products of sines and cosines as those of sums."""
    if isinstance(residual, sp.MatrixBase):
        return sp.ImmutableMatrix(residual).applyfunc(_shorter)
    return TR10i(residual)
