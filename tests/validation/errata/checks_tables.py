"""002: numbers that the dissertation prints, against its own definitions."""

from __future__ import annotations

import sympy as sp

from .check import Claim, check, equal
from .checks_balancer import SOURCE, A, B, D, S

NUMBERS = {  # of Tables 5.1 and A.1
    "5.1": {"epsilon": "0.01", "mu": "0.01", "s": "0.75", "w": "1.30", "beta_p": "1.0", "beta_r": "0.1"},
    "A.1": {"epsilon": "0.01", "mu": "0.02", "s": "1", "w": "0.98", "beta_p": "1", "beta_r": "1"},
}


def exact(table: str) -> dict[str, sp.Rational]:
    """The printed numbers of a table."""
    return {name: sp.Rational(text) for name, text in NUMBERS[table].items()}


def reciprocal(table: str) -> Claim:
    """beta_r against 2 epsilon w beta_p/(mu s)."""
    n = exact(table)
    right = 2 * n["epsilon"] * n["w"] * n["beta_p"] / (n["mu"] * n["s"])
    return equal(n["beta_r"], _from_definitions(n), right)


def _from_definitions(n: dict[str, sp.Rational]) -> sp.Expr:
    """beta_r = 2 b_r/(k J_R) of (4.8) of a machine with the other numbers of the table, for M* = r = k = 1."""
    b_r, J_R, J_P, m, e, M = sp.symbols("b_r J_R J_P m e M", positive=True)
    equations = [
        M * e / m - n["s"],
        M * e**2 / J_R - n["epsilon"],
        m / J_P * m - n["mu"],
        m / e - n["w"],
        b_r / J_P - n["beta_p"],
    ]
    actual = sp.solve(equations, [b_r, J_R, J_P, e, M], dict=True)[0]
    return sp.simplify((2 * b_r / J_R).subs(actual))


@check(
    SOURCE,
    "Table 5.1",
    r"\beta_r",
    "A damper turns the rotor as much as the pendulums back: what (4.8) gives for the other numbers of the table.",
)
def table_5_1() -> Claim:
    return reciprocal("5.1")


@check(SOURCE, "Table A.1", r"\beta_r", "What (4.8) gives for the other numbers of the table.")
def table_a_1() -> Claim:
    return reciprocal("A.1")


@check(
    SOURCE,
    "Table A.1, p",
    "p",
    "m r^2/J_P, at most 1 for any body; (4.8) implies p = 2 mu/(1 - s w), and no machine has these numbers.",
)
def pendulums_of_table_a_1() -> Claim:
    n = exact("A.1")
    M, m, e, r, J_P, mu, s, w = sp.symbols("M m e r J_P mu s w", positive=True)
    total = M + 2 * m
    equations = [m**2 * r**2 / (J_P * total) - mu, M * e / (m * r) - s, m * r / (total * e) - w]  # mu, s, w of (4.8)
    actual = sp.solve(equations, [J_P, M, e], dict=True)[0]
    derived = sp.simplify((m * r**2 / J_P).subs(actual)).subs({mu: n["mu"], s: n["s"], w: n["w"]})
    return equal(sp.S.One, derived, sp.Integer(2))


@check(SOURCE, "5.5", r"\delta", "The opening angle of type I for Table 5.1: the residual is cos(delta/2) less s/2.")
def opening_angle_in_5_5() -> Claim:
    s = exact("5.1")["s"]
    return Claim(sp.Rational(38, 100) * sp.pi, lambda e: sp.cos(e / 2) - s / 2, 2 * sp.acos(s / 2))


@check(
    SOURCE,
    "Appendix A",
    r"\operatorname{sign}(u_2^* - u_1^*)",
    "By (5.11) corrected: u_1^* is at least u at omega = 0.83, u_2^* at most u at omega = 1.47.",
)
def folds_of_table_a_1() -> Claim:
    below, above = (motor_parameter(sp.Rational(text)) for text in ("0.83", "1.47"))
    return equal(sp.S.One, sp.sign(above - below), -sp.S.One)


def motor_parameter(omega: sp.Rational) -> sp.Expr:
    """(5.11) corrected, upper sign, for Table A.1, where sigma = 0.1 and lambda = 2."""
    n, sigma = exact("A.1"), sp.Rational(1, 10)
    root = sp.sqrt(S**2 * D - 4 * B**2)
    actual = 2 * sigma * n["w"] * omega**5 * (A**2 * (S**2 + 4) + B**2 * (S**2 - 4) + 4 * A * root) / (S * (2 - omega) * D**2)
    return actual.subs({S: n["s"], A: 1 - omega**2, B: 2 * sigma * omega})
