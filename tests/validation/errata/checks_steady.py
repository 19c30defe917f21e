"""002, chapter 5: steady states, pendulums together, and the stability of their orbit."""

from __future__ import annotations

import sympy as sp

from .check import Claim, check, equal, reduced, turned
from .checks_balancer import (
    BETA_P,
    BETA_R,
    DELTA,
    EPSILON,
    FIELD,
    LAMBDA,
    MOTOR,
    MU,
    OMEGA,
    PSI,
    RIGHT_4_62,
    SIGMA,
    SOURCE,
    A,
    B,
    D,
    S,
    U,
    W,
    balancer,
    rates,
    right_4_60,
    right_4_61,
)
from .derived import real

ROOT = real("R")[0]
"""R = sqrt(s^2 D - 4 B^2), D = A^2 + B^2. Both signs are covered: only its square is used."""
OF_ROOT = ((ROOT, ROOT**2 - S**2 * D + 4 * B**2),)
TYPE_II = ((-2 * A * B - B * ROOT) / (S * D), (A * ROOT - 2 * B**2) / (S * D))
"""Sine and cosine of psi: (5.8) corrected, upper sign."""
TOGETHER, OPPOSITE = {DELTA: sp.S.Zero}, {DELTA: sp.pi}
OF_B = {SIGMA: B / (2 * OMEGA)}
DEFINED = {A: 1 - OMEGA**2, B: 2 * SIGMA * OMEGA}  # (5.4)


def pulled_together() -> sp.Expr:
    """What is proportional to the vibration torque on pendulums that are together; zero in a steady state of type II."""
    torque = balancer().output("vibration_torque[p1]").xreplace(TOGETHER)
    return -2 * D / OMEGA**4 * torque


def at(sine: sp.Expr, cosine: sp.Expr, expression: sp.Expr) -> sp.Expr:
    """The expression at a phase psi with this sine and cosine, the pendulums together."""
    return turned(reduced(expression.xreplace(TOGETHER)), {PSI: (sine, cosine)})


@check(SOURCE, "(5.1)", "0", "(4.60) is zero: the residual is the derived right-hand side less the printed.")
def equation_5_1() -> Claim:
    return equal(right_4_60(-1), rates()[0], right_4_60(1))


@check(SOURCE, "(5.2)", "0", "(4.61) is zero, with the other sign.")
def equation_5_2() -> Claim:
    return equal(-right_4_61(-1), -rates()[1], -right_4_61(1))


@check(SOURCE, "(5.3)", "0", "(4.62) is zero, with the other sign.")
def equation_5_3() -> Claim:
    return equal(-RIGHT_4_62, -rates()[2])


@check(SOURCE, "(5.5) to (5.7)", r"(\psi, \delta, \omega)", "Type I: the residual is the three rates there.")
def equations_5_5_to_5_7() -> Claim:
    sine, half = real("S"), sp.Symbol("h", real=True)

    def rates_at(state: sp.Matrix) -> sp.Matrix:
        cosine = sp.expand_trig(sp.cos(state[1] / 2))
        angles = {half: (sine[0], cosine)}
        put = {PSI: state[0], OMEGA: state[2]}
        return sp.Matrix([turned(r.xreplace({DELTA: 2 * half}), angles).xreplace(put) for r in rates()])

    return Claim(
        sp.ImmutableMatrix([sp.pi, 2 * sp.acos(S / 2), LAMBDA]), rates_at, relations=((sine[0], sine[0] ** 2 - 1 + S**2 / 4),)
    )


@check(
    SOURCE,
    "(5.8)",
    r"(\sin\psi, \cos\psi)",
    "Type II, upper sign; R -> -R gives the lower. R^2 = s^2 (A^2 + B^2) - 4 B^2. An arctangent lies in (-pi/2, pi/2), so the "
    "print has the positive cosine: q = 1 or -1 is the sign of A R - 2 B^2. The residual: what turns the pendulums, and "
    "sin^2 + cos^2 - 1.",
)
def equation_5_8() -> Claim:
    q = real("q")[0]
    right = sp.ImmutableMatrix(TYPE_II)
    relations = (*OF_ROOT, (q, q**2 - 1))
    return Claim(
        q * right, lambda e: sp.Matrix([at(e[0], e[1], pulled_together()), e[0] ** 2 + e[1] ** 2 - 1]), right, relations
    )


@check(
    SOURCE,
    "(5.8) in numbers",
    r"\psi",
    "The arctangent as it is printed at A = -3, B = 4, s = 2, R = 6: the residual is what turns the pendulums.",
)
def equation_5_8_in_numbers() -> Claim:
    place = {A: sp.Integer(-3), B: sp.Integer(4), S: sp.Integer(2), ROOT: sp.Integer(6)}
    printed = sp.atan((B * (2 * A**2 + A * ROOT) / (A * (2 * B**2 - A * ROOT))).subs(place))
    right = sp.atan2(*(e.subs(place) for e in TYPE_II))
    return Claim(printed, lambda e: at(sp.sin(e), sp.cos(e), pulled_together()).xreplace(place), right)


@check(
    SOURCE,
    "(5.8) condition",
    r"s_{\min}",
    "From which s on type II exists: where its two phases meet; the residual is the discriminant of its condition there.",
)
def equation_5_8_condition() -> Claim:
    size = sp.Symbol("B", positive=True)
    limit = size / sp.sqrt(A**2 + size**2)
    return Claim(limit, lambda e: discriminant().subs(B, size).subs(S, e), 2 * limit)


def discriminant() -> sp.Expr:
    """Of the quadratic in sin(psi) that the condition of type II is, over 4 s^2 B^2: R^2."""
    sine, cosine = real("sine cosine")
    actual = sp.solve(at(sine, cosine, pulled_together()), cosine)[0]
    top = sp.fraction(sp.together(sine**2 + actual**2 - 1))[0]
    return sp.cancel(sp.discriminant(top, sine) / (4 * S**2 * B**2))


@check(SOURCE, "(5.10)", "1", "Type II: the steady equations solved for the sine and the cosine of psi, squared and added.")
def equation_5_10() -> Claim:
    sine, cosine = real("sine cosine")
    conditions = [at(sine, cosine, r) for r in rates()[:2]]
    actual = sp.solve(conditions, [sine, cosine], dict=True)[0]
    motor, swing = U * S * D * (LAMBDA - OMEGA), B * OMEGA**4 * W
    printed = (swing * (S**2 + 4) - motor) ** 2 / (16 * B**2 * OMEGA**8 * W**2 * S**2)
    printed += (swing * (S**2 - 4) - motor) ** 2 / (16 * A**2 * OMEGA**8 * W**2 * S**2)
    return equal(printed, actual[sine] ** 2 + actual[cosine] ** 2)


@check(
    SOURCE,
    "(5.11)",
    "u",
    "The motor parameter of type II, upper sign: the residual is domega/dphi and dpsi/dphi at the phase (5.8).",
)
def equation_5_11() -> Claim:
    root = sp.sqrt(A**2 * (A**2 * S**2 + B**2 * (S**2 - 1)))
    printed = -(OMEGA**5) * W * SIGMA * (A**2 * (S**2 + 1) + B**2 * (S**2 - 1) + root) / (S * (OMEGA - LAMBDA) * D**2)
    right = 2 * SIGMA * W * OMEGA**5 / (S * (LAMBDA - OMEGA) * D**2)
    right *= A**2 * (S**2 + 4) + B**2 * (S**2 - 4) + 4 * A * ROOT

    def steady(u: sp.Expr) -> sp.Matrix:
        return sp.Matrix([at(TYPE_II[0], TYPE_II[1], r).xreplace({U: u.xreplace(OF_B)}) for r in rates()[:2]])

    return Claim(printed, steady, right, OF_ROOT)


@check(
    SOURCE,
    "(5.12)",
    r"\tan\psi",
    "Type III, q being arbitrary in print: the residual is ddelta/dphi (4.62) at delta = pi over cos(psi).",
)
def equation_5_12() -> Claim:
    tangent = real("q")[0]
    rate = turned(rates()[2].xreplace(OPPOSITE), {PSI: (tangent, sp.S.One)})
    return Claim(tangent, lambda e: rate.xreplace({tangent: e}), A / B)


@check(SOURCE, "(5.14)", "0", "Type III: domega/dphi at delta = pi.")
def equation_5_14() -> Claim:
    printed = BETA_P * EPSILON * (U * D * (LAMBDA - OMEGA) - B * S * W * OMEGA**4) / (OMEGA * D * (BETA_P + BETA_R))
    return equal(printed, rates()[0].xreplace(OPPOSITE))


@check(SOURCE, "(5.15)", "u", "The motor parameter of type III: (5.14) solved.")
def equation_5_15() -> Claim:
    derived = sp.solve(rates()[0].xreplace(OPPOSITE), U)[0]
    return equal(2 * OMEGA**5 * S * SIGMA * W / ((LAMBDA - OMEGA) * D), derived, put=OF_B)


@check(SOURCE, "(5.17)", r"\frac{d\omega}{d\phi}", "The pendulums together: (4.60) at delta = 0.")
def equation_5_17() -> Claim:
    swing = A * (2 * EPSILON * BETA_P * W - MU * BETA_R * S) * sp.sin(PSI)
    swing -= B * (2 * EPSILON * BETA_P * W + MU * BETA_R * S) * sp.cos(PSI)
    return equal(
        BETA_P * MOTOR + FIELD * (swing - B * (2 * MU * BETA_R + EPSILON * BETA_P * S * W)), rates()[0].xreplace(TOGETHER)
    )


@check(SOURCE, "(5.18)", r"\frac{d\psi}{d\phi}", "The pendulums together: (4.61) at delta = 0.")
def equation_5_18() -> Claim:
    swing = B * (2 * EPSILON * W - MU * S) * sp.cos(PSI) - A * (2 * EPSILON * W + MU * S) * sp.sin(PSI)
    printed, right = (-MOTOR + FIELD * (swing + B * last) for last in (EPSILON * S * W, EPSILON * S * W - 2 * MU))
    return equal(printed, rates()[1].xreplace(TOGETHER), right)


@check(
    SOURCE,
    "(5.20)",
    r"\Delta\psi'",
    "(4.61) linearised, at omega = 1, psi = pi/2. The factor of Delta omega is printed as d/dpsi.",
)
def equation_5_20() -> Claim:
    step_omega, step_psi, h = real(r"\Delta{\omega} \Delta{\psi} h")
    rate = rates()[1].xreplace(DEFINED | TOGETHER)
    moved = rate.xreplace({OMEGA: OMEGA + h * step_omega, PSI: PSI + h * step_psi})

    def here(e: sp.Expr) -> sp.Expr:
        return reduced(e.subs({h: 0, OMEGA: 1, PSI: sp.pi / 2}))

    by_omega, by_psi = (here(sp.diff(rate, x)) for x in (OMEGA, PSI))
    derived = here(sp.diff(moved, h))
    return equal(by_psi * step_omega + by_psi * step_psi, derived, by_omega * step_omega + by_psi * step_psi)


@check(SOURCE, "(5.22)", r"\Delta\delta'", "(4.62) linearised at delta = 0.")
def equation_5_22() -> Claim:
    step = real(r"\Delta{\delta}")[0]
    printed = MU * OMEGA**3 * step / (BETA_P * ((1 - OMEGA**2) ** 2 + 4 * OMEGA**2 * SIGMA**2))
    printed *= 2 * S * OMEGA * SIGMA * sp.sin(PSI) - (S * sp.cos(PSI) + 2) * (1 - OMEGA**2)
    return equal(printed, sp.diff(rates()[2], DELTA).xreplace(TOGETHER).xreplace(DEFINED) * step)
