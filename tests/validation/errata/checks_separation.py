"""001, sections 2.1 to 2.3: a rotor on a shaken axis, and two exciters that synchronise each other."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine

from .check import Claim, check, equal, turned
from .derived import Derived, full_rows, path, real

SOURCE = "001"
SPEED, M, A_XX, X_0, THETA = real("Omega M A_xx x_0 theta")
F = real("f_1 f_2")
J = real("J_1 J_2")
DAMPING = real("k_1 k_2")
PARTIAL = real("Omega_1 Omega_2")
ALPHA = real("alpha_1 alpha_2")
RATE = real(r"\dot{\alpha}_{1} \dot{\alpha}_{2}")
SECOND = real(r"\ddot{\alpha}_{1} \ddot{\alpha}_{2}")


@cache
def shaken() -> Derived:
    """The machine of (12), (13)."""
    averaged_equations = averaged_equations_of(load_machine("sperling-vibration/figure-2a", {}))
    put = {path("carrier.motion.amplitude"): X_0, path("carrier.motion.frequency"): SPEED, path("carrier.gravity"): sp.S.Zero}
    put |= {path("rotor.inertia"): J[0], path("rotor.bearing_damping"): sp.S.Zero, path("drive.slope"): DAMPING[0]}
    put |= {path("rotor.eccentricity"): F[0] / (SPEED**2 * path("rotor.mass")), path("drive.no_load_speed"): PARTIAL[0]}
    put |= {path("rotor.phase"): ALPHA[0], path("rotor.speed"): SPEED + RATE[0]}
    return Derived(averaged_equations, (put,))


def fluctuation_left(d: Derived, body: str, inertia: sp.Expr, damping: sp.Expr) -> sp.Expr:
    """J psi'' + k psi' of the program's fluctuation at twice the speed, as a function of theta = Omega t."""
    psi = d.fluctuation(body, THETA)
    return inertia * SPEED**2 * sp.diff(psi, THETA, 2) + damping * SPEED * sp.diff(psi, THETA)


@check(
    SOURCE,
    "(8)",
    r"J_i \ddot\varphi_i",
    "The rotor's equation: in print with the speed of the carrier instead of its acceleration.",
)
def equation_8() -> Claim:
    phi, acceleration, speed, unbalance = real(r"\varphi_{i} \ddot{x} \dot{x} {m_i\varepsilon_i}")
    torque = real("L_i")[0]
    names = {"angle": phi, "inertia": J[0], "eccentricity": unbalance / path("e1.mass"), "bearing_damping": sp.S.Zero}
    put = {path(f"e1.{n}"): e for n, e in names.items()} | {path("carrier.x.acceleration"): acceleration}
    put |= {path("carrier.gravity"): sp.S.Zero, path("drives.e1.slope"): torque}
    put |= {path("drives.e1.no_load_speed"): 1 + path("e1.speed")}  # any torque
    row = full_rows(load_machine("sperling-vibration/self-synchronisation-soft", {}), put)["e1.angle"]
    derived = J[0] * path("e1.angle.acceleration") - row
    right = torque + unbalance * acceleration * sp.sin(phi)
    return equal(torque + unbalance * speed * sp.sin(phi), derived, right)


@check(
    SOURCE,
    "(15)",
    "0",
    "The slow equation of a rotor on a shaken axis: the residual is left less right, with the program's alpha_1''.",
)
def equation_15() -> Claim:
    left = J[0] * SECOND[0] + DAMPING[0] * RATE[0] - DAMPING[0] * (PARTIAL[0] - SPEED) + F[0] * X_0 * sp.sin(ALPHA[0]) / 2
    return Claim(left, lambda e: e.xreplace({SECOND[0]: shaken().rate("rotor.speed")}))


@check(SOURCE, "(20)", "V_1", "The vibration torque.")
def equation_20() -> Claim:
    return equal(-F[0] * X_0 * sp.sin(ALPHA[0]) / 2, shaken().output("vibration_torque[rotor]"))


def pull_out() -> sp.Expr:
    """k_1 (Omega_1 - Omega) + V_1, which is zero in the entrained motion."""
    return (J[0] * shaken().rate("rotor.speed")).xreplace({RATE[0]: sp.S.Zero})


@check(
    SOURCE,
    "(22)",
    r"\sin\alpha_1^0",
    "The phase of the entrained motion, (15) at rest; (21) is that this is less than 1 in size.",
)
def equation_22() -> Claim:
    sine = real("sine")[0]
    actual = sp.solve(turned(pull_out(), {ALPHA[0]: (sine, sp.S.One)}), sine)[0]
    return equal(2 * DAMPING[0] * (PARTIAL[0] - SPEED) / (F[0] * X_0), actual)


@check(SOURCE, "(24)", "c", "The stiffness in J_1 d''+ k_1 d' + c d = 0 of a small disturbance d.")
def equation_24() -> Claim:
    return equal(F[0] * X_0 * sp.cos(ALPHA[0]) / 2, -sp.diff(pull_out(), ALPHA[0]))


@check(
    SOURCE,
    "(25)",
    r"\frac{f_1 x_0}{2}",
    "The threshold of rotation without a drive: the largest moment at the limit k_1 Omega; the residual is (15) at rest.",
)
def equation_25() -> Claim:
    without_drive = pull_out().xreplace({PARTIAL[0]: sp.S.Zero, ALPHA[0]: -sp.pi / 2})
    return Claim(DAMPING[0] * SPEED, lambda e: without_drive.subs(X_0, 2 * e / F[0]))


@check(SOURCE, "(26)", r"J_1\ddot\psi_1 + k_1\dot\psi_1", "The fluctuation at twice the speed, theta = Omega t.")
def equation_26() -> Claim:
    derived = fluctuation_left(shaken(), "rotor", J[0], DAMPING[0])
    return equal(-F[0] * X_0 * sp.sin(2 * THETA + ALPHA[0]) / 2, derived)


@cache
def exciters() -> Derived:
    """The machine of (27), (28); the first exciter turns with Omega."""
    averaged_equations = averaged_equations_of(load_machine("sperling-vibration/self-synchronisation-soft", {}))
    put = {path("carrier.mass"): M - path("e1.mass") - path("e2.mass"), path("carrier.damping"): sp.S.Zero}
    put |= {path("carrier.stiffness"): M * SPEED**2 + 1 / A_XX, path("carrier.gravity"): sp.S.Zero}
    put |= {path("e1.speed"): SPEED, path("e2.speed"): SPEED + RATE[1], path("e2.phase"): ALPHA[1] - ALPHA[0]}
    for i, name in enumerate(("e1", "e2")):
        put |= {path(f"{name}.eccentricity"): F[i] / (SPEED**2 * path(f"{name}.mass")), path(f"{name}.inertia"): J[i]}
        put |= {path(f"{name}.bearing_damping"): sp.S.Zero, path(f"drives.{name}.slope"): DAMPING[i]}
        put[path(f"drives.{name}.no_load_speed")] = PARTIAL[i]
    return Derived(averaged_equations, (put,))


@check(SOURCE, "(32)", "x", "The forced motion of the undamped carrier, theta = Omega t.")
def equation_32() -> Claim:
    printed = A_XX * sp.Add(*(F[i] * sp.cos(THETA + ALPHA[i]) for i in range(2)))
    return equal(printed, exciters().carrier("x", THETA + ALPHA[0]))


@check(
    SOURCE,
    "(33)",
    "(0, 0)",
    "The averaged equations, left less right, with the program's accelerations; exciter 1 turns with Omega.",
)
def equation_33() -> Claim:
    moment = [exciters().output(f"vibration_torque[e{i}]") for i in (1, 2)]
    rates = (sp.S.Zero, RATE[1])
    left = [J[i] * SECOND[i] + DAMPING[i] * rates[i] - DAMPING[i] * (PARTIAL[i] - SPEED) - real("V_1 V_2")[i] for i in range(2)]
    put = {SECOND[i]: exciters().rate(f"e{i + 1}.speed") for i in range(2)} | dict(zip(real("V_1 V_2"), moment, strict=True))
    return Claim(sp.ImmutableMatrix(left), lambda e: e.xreplace(put))


SYNCHRONISING = A_XX * F[0] * F[1] * sp.sin(ALPHA[0] - ALPHA[1]) / 2


@check(SOURCE, "(34)", "(V_1, V_2)", "The vibration torques.")
def equation_34() -> Claim:
    derived = sp.Matrix([exciters().output(f"vibration_torque[e{i}]") for i in (1, 2)])
    return equal(sp.ImmutableMatrix([-SYNCHRONISING, SYNCHRONISING]), derived)


def at_common_speed() -> sp.Matrix:
    """J_i alpha_i'' of both exciters, turning with Omega."""
    rows = [J[i] * exciters().rate(f"e{i + 1}.speed").xreplace({RATE[1]: sp.S.Zero}) for i in range(2)]
    return sp.Matrix(rows)


@check(SOURCE, "(35)", r"\Omega", "The synchronous speed: the residual is the sum of both equations (33) at steady phases.")
def equation_35() -> Claim:
    summed = sp.simplify(at_common_speed()[0] + at_common_speed()[1])
    return Claim(
        (DAMPING[0] * PARTIAL[0] + DAMPING[1] * PARTIAL[1]) / (DAMPING[0] + DAMPING[1]), lambda e: summed.subs(SPEED, e)
    )


@check(
    SOURCE,
    "(36)",
    "(0, 0)",
    "Equal partial speeds, Omega_1 = Omega_2 = Omega: left-hand sides with the program's accelerations.",
)
def equation_36() -> Claim:
    left = [J[0] * SECOND[0] + SYNCHRONISING, J[1] * SECOND[1] + DAMPING[1] * RATE[1] - SYNCHRONISING]
    put = {SECOND[i]: exciters().rate(f"e{i + 1}.speed").xreplace(dict.fromkeys(PARTIAL, SPEED)) for i in range(2)}
    return Claim(sp.ImmutableMatrix(left), lambda e: e.xreplace(put))


@check(SOURCE, "(37)", r"\alpha_1^0 - \alpha_2^0", "The two synchronous states: the residual is (36) there.")
def equation_37() -> Claim:
    equal_speeds = at_common_speed()[0].xreplace(dict.fromkeys(PARTIAL, SPEED))
    return Claim(
        sp.ImmutableMatrix([0, sp.pi]),
        lambda e: sp.Matrix([equal_speeds.subs(ALPHA[0], ALPHA[1] + difference) for difference in e]),
    )


@check(SOURCE, "(39)", r"C", "The stiffness matrix of small disturbances; (40) is that its only entry C_11 is positive.")
def equation_39() -> Claim:
    entry = F[0] * F[1] * A_XX * sp.cos(ALPHA[0] - ALPHA[1]) / 2
    return equal(sp.ImmutableMatrix([[entry, -entry], [-entry, entry]]), -at_common_speed().jacobian(ALPHA))


@check(SOURCE, "(41)", r"J_i\ddot\psi_i + k_i\dot\psi_i", "The fluctuations at twice the speed, theta = Omega t.")
def equation_41() -> Claim:
    first = ALPHA[0]
    twice = [[F[j] * sp.sin(2 * THETA + ALPHA[i] + ALPHA[j]) for j in range(2)] for i in range(2)]
    printed = sp.ImmutableMatrix([-A_XX * F[i] / 2 * sp.Add(*twice[i]) for i in range(2)])
    derived = [fluctuation_left(exciters(), f"e{i + 1}", J[i], DAMPING[i]).subs(THETA, THETA + first) for i in range(2)]
    return equal(printed, sp.Matrix(derived))
