"""000, sections 2 and 3: the moments of vibration on two rollers and the averaged equations of their phases."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of

from .check import Claim, check, equal
from .derived import Derived, full_rows, path, real
from .machines import DRIVE, HELD, with_rollers

SOURCE = "000"
M, SPEED, A_XX, A_YY = real("M Omega A_xx A_yy")
F = real("f_0 f_1 f_2")
ALPHA = (sp.S.Zero, *real("alpha_1 alpha_2"))
RATE = (sp.S.Zero, *real(r"\dot{\alpha}_{1} \dot{\alpha}_{2}"))
SECOND = (sp.S.Zero, *real(r"\ddot{\alpha}_{1} \ddot{\alpha}_{2}"))
BETA = (None, *real("beta_1 beta_2"))
J = (None, *real("J_11 J_22"))
OMEGA_X, OMEGA_Y = real("omega_x omega_y")
FAST = real("theta")[0]
"""Omega t."""


@cache
def rollers(short: bool = True) -> Derived:
    """The machine of (18) with (19), (20); short: with A_xx, A_yy of (27)."""
    averaged_equations = averaged_equations_of(with_rollers(HELD))
    rigidity = {"x": (A_XX, OMEGA_X), "y": (A_YY, OMEGA_Y)}
    total = path("carrier.mass"), M - path("drum.mass") - path("r1.mass") - path("r2.mass")
    put = {total[0]: total[1], path("drive.speed"): SPEED, path("drum.unbalance"): F[0] / SPEED**2}
    for d, (influence, frequency) in rigidity.items():
        put[path(f"carrier.damping.{d}")] = sp.S.Zero
        put[path(f"carrier.stiffness.{d}")] = M * SPEED**2 + 1 / influence if short else M * frequency**2
    forces: dict[sp.Symbol, sp.Expr] = {}
    for i in (1, 2):
        arm, r = real(f"epsilon_{i}")[0], f"r{i}"
        put |= {
            path(f"{r}.track_radius"): arm + path(f"{r}.radius"),
            path(f"{r}.damping"): BETA[i],
            path(f"{r}.phase"): ALPHA[i],
        }
        put[path(f"{r}.speed")] = SPEED + RATE[i]
        forces |= {path(f"{r}.mass"): F[i] / (arm * SPEED**2), path(f"{r}.shape_factor"): J[i] * SPEED**2 / (F[i] * arm) - 1}
    return Derived(averaged_equations, (put, forces))


def turning_back(i: int) -> sp.Expr:
    """The mean of what stands on the left of (18) against roller i: minus the vibration torque."""
    return -rollers().output(f"vibration_torque[r{i}]")


def summed(i: int, f: sp.Expr) -> sp.Expr:
    """Half f_i sum f_k (A_xx + A_yy) sin(alpha_i - alpha_k), times a factor."""
    return f * F[i] / 2 * sp.Add(*(F[k] * (A_XX + A_YY) * sp.sin(ALPHA[i] - ALPHA[k]) for k in range(3)))


@check(
    SOURCE,
    "(17)",
    r"\beta_0",
    "The factor of the rotor's speed in (18), with a drive of slope and a bearing of its own damping: they are not one.",
)
def equation_17() -> Claim:
    slope, bearing = real(r"\bar{\beta}_{L} \bar{\beta}_{0}")
    put = {path("drive.slope"): slope, path("drum.bearing_damping"): bearing}
    put |= {path("r1.damping"): BETA[1], path("r2.damping"): BETA[2]}
    derived = sp.diff(full_rows(with_rollers(DRIVE), put)["drum.angle"], path("drum.speed"))
    return equal(2 * bearing + BETA[1] + BETA[2], derived, slope + bearing + BETA[1] + BETA[2])


@check(SOURCE, "(26)", "(x^0, y^0)", "The forced motion of the undamped support.")
def equation_26() -> Claim:
    printed = [a * sp.Add(*(F[i] * f(FAST + ALPHA[i]) for i in range(3))) for a, f in ((A_XX, sp.cos), (A_YY, sp.sin))]
    return equal(sp.ImmutableMatrix(printed), sp.Matrix([rollers().carrier(d, FAST) for d in ("x", "y")]))


@check(SOURCE, "(27)", "(A_{xx}, A_{yy})", "The harmonic influence coefficients: H(w) without damping.")
def equation_27() -> Claim:
    printed = sp.ImmutableMatrix([1 / (M * (o**2 - SPEED**2)) for o in (OMEGA_X, OMEGA_Y)])
    return equal(printed, sp.Matrix([rollers(short=False).definition(f"H[{d}].re") for d in ("x", "y")]))


def moment(i: int) -> sp.Expr:
    """(29): -m_i eps_i (x'' sin(Omega t + alpha_i) - y'' cos(Omega t + alpha_i))."""
    x, y = (rollers().carrier(d, FAST) for d in ("x", "y"))
    angle = FAST + ALPHA[i]
    return F[i] * (x * sp.sin(angle) - y * sp.cos(angle))  # x'' = -Omega^2 x, f_i = m_i eps_i Omega^2


@check(SOURCE, "(30)", "(B_1^0, B_2^0)", "The moments (29) of the forced motion.")
def equation_30() -> Claim:
    def printed(i: int) -> sp.Expr:
        twice = (F[k] * (A_XX - A_YY) * sp.sin(2 * FAST + ALPHA[i] + ALPHA[k]) for k in range(3))
        return F[i] / 2 * sp.Add(*twice) + summed(i, sp.S.One)

    return equal(sp.ImmutableMatrix([printed(i) for i in (1, 2)]), sp.Matrix([moment(i) for i in (1, 2)]))


@check(
    SOURCE,
    "(31) integral",
    "(V_1, V_2)",
    "The integral over a turn, in print without 1/(2 pi): minus the vibration torque less the integral.",
)
def equation_31_integral() -> Claim:
    moments = dict(zip(real("{B_1^0} {B_2^0}"), [sp.expand(sp.expand_trig(moment(i))) for i in (1, 2)], strict=True))
    printed = sp.ImmutableMatrix([sp.Integral(b, (FAST, 0, 2 * sp.pi)) for b in moments])
    derived = sp.Matrix([turning_back(i) for i in (1, 2)])
    return Claim(printed, lambda e: derived - e.xreplace(moments).doit(), printed / (2 * sp.pi))


@check(SOURCE, "(31) result", "(V_1, V_2)", "What (31) gives: minus the vibration torque of the averaged equations.")
def equation_31_result() -> Claim:
    return equal(sp.ImmutableMatrix([summed(i, sp.S.One) for i in (1, 2)]), sp.Matrix([turning_back(i) for i in (1, 2)]))


def slow_row(i: int, other: int, sign: int) -> Claim:
    """(32), (33): the left-hand side with alpha'' from the averaged equations is zero."""
    pair = sign * F[other] * sp.sin(ALPHA[1] - ALPHA[2])
    left = J[i] * SECOND[i] + BETA[i] * RATE[i] + (A_XX + A_YY) / 2 * F[i] * (F[0] * sp.sin(ALPHA[i]) + pair)
    return Claim(left, lambda e: e.xreplace({SECOND[i]: rollers().rate(f"r{i}.speed")}))


@check(SOURCE, "(32)", "0", "The slow equation of roller 1: the residual is its left-hand side with the program's alpha_1''.")
def equation_32() -> Claim:
    return slow_row(1, 2, 1)


@check(SOURCE, "(33)", "0", "The slow equation of roller 2.")
def equation_33() -> Claim:
    return slow_row(2, 1, -1)
