"""002, chapter 2: a bifurcation, the Laval rotor and the motors."""

from __future__ import annotations

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate, equations_of_motion

from .check import Claim, check, equal
from .derived import Derived, path, real
from .machines import si_rotor

SOURCE = "002"
M, e, c, T = real("M e c T")
OMEGA, SIGMA, K = real("omega sigma k")


@check(
    SOURCE,
    "2.1.3",
    r"\lambda_2",
    "The second eigenvalue at the outer equilibria of the pitchfork (2.33), x^2 = mu: d/dx (mu x - x^3) there.",
)
def pitchfork() -> Claim:
    mu, x = sp.symbols("mu x", positive=True)
    return equal(-3 * mu, sp.diff(mu * x - x**3, x).subs(x, sp.sqrt(mu)), -2 * mu)


@check(SOURCE, "(2.65)", r"\dot y_S", "The time derivative of (2.63).")
def equation_2_65() -> Claim:
    t = sp.Symbol("t")
    y, phi = (sp.Function(n)(t) for n in ("y", "phi"))
    right = sp.diff(y, t) + e * sp.diff(phi, t) * sp.cos(phi)
    return equal(sp.diff(y, t) + e * phi * sp.cos(phi), sp.diff(y + e * sp.sin(phi), t), right, put=_as_symbols(t, y, phi))


def _as_symbols(t: sp.Symbol, y: sp.Expr, phi: sp.Expr) -> dict[sp.Expr, sp.Symbol]:
    return {sp.diff(y, t): path(r"\dot{y}"), sp.diff(phi, t): path(r"\dot{\phi}"), phi: path("phi")}


@check(
    SOURCE, "(2.70)", "J_r", "The inertia that meets phi'' where (2.60) holds with the inertia J_S about the centre of mass."
)
def equation_2_70() -> Claim:
    central, phi, w, vx, vy = real("J_S phi omega v_x v_y")
    speed = (vx - e * w * sp.sin(phi)) ** 2 + (vy + e * w * sp.cos(phi)) ** 2  # (2.61), (2.64), (2.65)
    coordinates = [Coordinate(*pair) for pair in ((path("x"), vx), (path("y"), vy), (phi, w))]
    mass = equations_of_motion([Energies(kinetic=M * speed / 2 + central * w**2 / 2)], coordinates).mass
    return equal(central, mass[2, 2], central + M * e**2)


@check(
    SOURCE,
    "(2.79)",
    "T",
    "The torque that holds the speed: minus the vibration torque on a rotor whose carrier moves in two directions.",
)
def equation_2_79() -> Claim:
    put = {
        path("drum.mass"): M - path("carrier.mass"),
        path("carrier.stiffness"): M * K**2,
        path("carrier.damping"): 2 * M * SIGMA,
    }
    unbalance = {path("drum.eccentricity"): M * e / (M - path("carrier.mass")), path("speed"): OMEGA}
    derived = -Derived(averaged_equations_of(si_rotor("xy"), has_fixed_speed=True), (unbalance | put, put)).output(
        "vibration_torque[drum]"
    )
    lost = 2 * e**2 * SIGMA * OMEGA**5 / ((K**2 - OMEGA**2) ** 2 + 4 * SIGMA**2 * OMEGA**2)
    return equal(lost, derived, M * lost)


U, R_A, R_E, L_E, FLUX, SPEED = real(r"U R_A R_E L_E \Phi_{E} \dot{\phi}")
K_MOTOR, K_CAPITAL, K_FIELD = real("k_M K_M k_E")


def motor(flux: sp.Expr, resistance: sp.Expr, current: sp.Symbol) -> sp.Expr:
    """T_M = k_M I_A Phi_E (2.85) with the current that solves U - k_M Phi_E phi' = R I_A (2.88), (2.90)."""
    actual = sp.solve(U - K_MOTOR * flux * SPEED - resistance * current, current)[0]
    return (K_MOTOR * current * flux).subs(current, actual)


@check(SOURCE, "(2.92)", "T_M", "The separately excited motor, from (2.85), (2.88), (2.90). There is no K_M.")
def equation_2_92() -> Claim:
    slope = K_MOTOR**2 * FLUX**2 / R_A
    printed, right = (slope * (U / (k * FLUX) - SPEED) for k in (K_CAPITAL, K_MOTOR))
    return equal(printed, motor(FLUX, R_A, path("I_A")), right)


@check(SOURCE, "(2.93)", r"\omega^*", "Its no-load speed, at which (2.85) with (2.88), (2.90) gives no torque.")
def equation_2_93() -> Claim:
    derived = sp.solve(motor(FLUX, R_A, path("I_A")), SPEED)[0]
    return equal(U / (K_CAPITAL * FLUX), derived, U / (K_MOTOR * FLUX))


@check(SOURCE, "(2.99)", "T_M", "The shunt motor, Phi_E = L_E U/R_E (2.87), (2.96).")
def equation_2_99() -> Claim:
    printed = K_MOTOR**2 * U**2 * L_E**2 / (R_A * R_E**2) * (R_E / (K_MOTOR * L_E) - SPEED)
    return equal(printed, motor(L_E * U / R_E, R_A, path("I_A")))


@check(SOURCE, "(2.104)", "T_M", "The series motor, Phi_E = L_E I_A (2.100). There is no k_E.")
def equation_2_104() -> Claim:
    current, total = path("I_A"), path(r"R_{\Sigma}")
    actual = sp.solve(U - K_MOTOR * L_E * current * SPEED - total * current, current)[0]
    printed, right = (K_MOTOR * L_E * U**2 / (total + k * L_E * SPEED) ** 2 for k in (K_FIELD, K_MOTOR))
    return equal(printed, K_MOTOR * L_E * actual**2, right)


U_1, R_1, R_2, X_1, X_2, SLIP, SYNCHRONOUS = real(r"U_1 R_1 {R_2'} X_{1\sigma} {X_{2\sigma}'} s_A \dot{\phi}_{s}")
X = X_1 + X_2
TORQUE = 3 * R_2 * U_1**2 / (SLIP * SYNCHRONOUS * ((R_1 + R_2 / SLIP) ** 2 + X**2))  # (2.119)
BREAKDOWN = R_2 / sp.sqrt(R_1**2 + X**2)  # (2.121)


def current_squared(sign: int) -> sp.Expr:
    """|I_2|^2 from (2.110)-(2.112) with I_0 = 0: I_1 + sign I_2 = 0."""
    first, second, induced = sp.symbols("I_1 I_2 U_h")
    equations = [
        first + sign * second,
        U_1 - induced - (sp.I * X_1 + R_1) * first,
        induced - (sp.I * X_2 + R_2 / SLIP) * second,
    ]
    actual = sp.together(sp.solve(equations, [first, second, induced], dict=True)[0][second])
    top, bottom = sp.fraction(actual)
    return sp.expand(top * sp.conjugate(top)) / sp.expand(bottom * sp.conjugate(bottom))


@check(
    SOURCE,
    "(2.107)",
    r"\text{sign of } I_2",
    "With (2.111), (2.112) and I_0 = 0: the residual is U_1^2/|I_2|^2 less that of (2.118).",
)
def equation_2_107() -> Claim:
    square = (R_1 + R_2 / SLIP) ** 2 + X**2  # U_1^2/I_2^2 of (2.118)
    return Claim(sp.Integer(1), lambda sign: U_1**2 / current_squared(int(sign)) - square, sp.Integer(-1))


@check(SOURCE, "(2.119)", "T_M", "The torque (2.117) with (2.118) and phi' = (1 - s_A) phi'_s.")
def equation_2_119() -> Claim:
    turning = (1 - SLIP) * SYNCHRONOUS
    return equal(TORQUE, 3 * R_2 * current_squared(-1) * (1 - SLIP) / (SLIP * turning))


@check(
    SOURCE,
    "(2.120)",
    "T_{M_k}",
    "The breakdown torque: (2.119) at the slip (2.121), where its derivative is zero. Z^2 = R_1^2 + X^2.",
)
def equation_2_120() -> Claim:
    root = path("Z")
    derived = TORQUE.subs(SLIP, R_2 / root).subs(X_1, sp.sqrt(root**2 - R_1**2) - X_2)
    printed = 3 * R_2 * U_1**2 / (2 * SYNCHRONOUS * (R_1 + root))
    return equal(printed, derived, printed / R_2)


@check(SOURCE, "(2.121)", "s_{A_k}", "The slip of the largest torque: the residual is the derivative of (2.119) there.")
def equation_2_121() -> Claim:
    return Claim(BREAKDOWN, lambda s: sp.diff(TORQUE, SLIP).subs(SLIP, s))
