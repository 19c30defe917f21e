"""001, sections 2.4 and 2.5: automatic balancing, and a rotor on a damped carrier."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine

from .check import Claim, check, equal, reduced, turned
from .checks_separation import A_XX, ALPHA, DAMPING, PARTIAL, RATE, SECOND, SOURCE, SPEED, THETA, J, M, fluctuation_left
from .derived import Derived, path, real
from .machines import with_balls

F_0, F_1, F_2, EQUAL = real("f_0 f_1 f_2 f")
F = (F_0, F_1, F_2)
PHASES = (sp.S.Zero, *ALPHA)
ALIKE = {F_1: EQUAL, F_2: EQUAL}
BALLS = ("b1", "b2")


@cache
def balls(directions: str = "xy") -> Derived:
    """The machine of (42), (43), undamped."""
    averaged_equations = averaged_equations_of(with_balls(directions))
    masses = [path(f"{n}.mass") for n in BALLS]
    put = {path("carrier.mass"): M - path("drum.mass") - sp.Add(*masses), path("carrier.damping"): sp.S.Zero}
    put |= {path("carrier.stiffness"): M * SPEED**2 + 1 / A_XX, path("carrier.gravity"): sp.S.Zero}
    put |= {path("drive.speed"): SPEED, path("drum.unbalance"): F_0 / SPEED**2}
    for i, n in enumerate(BALLS):
        put |= {
            path(f"{n}.length"): F[i + 1] / (masses[i] * SPEED**2),
            path(f"{n}.inertia"): J[i],
            path(f"{n}.damping"): DAMPING[i],
        }
        put |= {path(f"{n}.phase"): ALPHA[i], path(f"{n}.speed"): SPEED + RATE[i]}
    return Derived(averaged_equations, (put,))


@cache
def torques() -> sp.Matrix:
    """The vibration torques on the balls."""
    return sp.Matrix([reduced(balls().output(f"vibration_torque[{n}]")) for n in BALLS])


APART = sp.sin(ALPHA[0] - ALPHA[1])
PULLS = (F_1 * (F_0 * sp.sin(ALPHA[0]) + F_2 * APART), F_2 * (F_0 * sp.sin(ALPHA[1]) - F_1 * APART))


@check(
    SOURCE,
    "(47)",
    "(0, 0)",
    "The averaged equations of the balls, with the program's accelerations: two directions give A_xx, not A_xx/2.",
)
def equation_47() -> Claim:
    def left(influence: sp.Expr) -> sp.ImmutableMatrix:
        rows = [J[i] * SECOND[i] + DAMPING[i] * RATE[i] + influence * PULLS[i] for i in range(2)]
        return sp.ImmutableMatrix(rows)

    put = {SECOND[i]: balls().rate(f"{n}.speed") for i, n in enumerate(BALLS)}
    return Claim(left(A_XX / 2), lambda e: e.xreplace(put), left(A_XX))


@check(SOURCE, "(48)", "(0, 0)", "Steady phases of two equal balls: minus the vibration torque over f A_xx.")
def equation_48() -> Claim:
    printed = [F_0 * sp.sin(ALPHA[0]) + EQUAL * APART, F_0 * sp.sin(ALPHA[1]) - EQUAL * APART]
    return equal(sp.ImmutableMatrix(printed), -torques().xreplace(ALIKE) / (EQUAL * A_XX))


@check(
    SOURCE,
    "(49), Table 1",
    r"(\alpha_1, \alpha_2)",
    "The four solutions of (48), one a column, with cos(gamma) = f_0/(2 f): the residual is (48).",
)
def equation_49() -> Claim:
    gamma, sine = real("gamma sine")
    states = sp.ImmutableMatrix([[sp.pi - gamma, sp.pi, 0, 0], [sp.pi + gamma, sp.pi, 0, sp.pi]])

    def at(e: sp.Matrix) -> sp.Matrix:
        actual = [torques().xreplace(ALIKE).subs(dict(zip(ALPHA, e[:, k], strict=True))) for k in range(e.shape[1])]
        return sp.Matrix.hstack(*actual).applyfunc(lambda v: turned(v, {gamma: (sine, F_0 / (2 * EQUAL))}))

    return Claim(states, at)


def stiffness(influence: sp.Expr) -> sp.ImmutableMatrix:
    """The matrix in (50), (51) with this factor for A_xx/2."""
    pair = EQUAL * sp.cos(ALPHA[0] - ALPHA[1])
    diagonal = [F_0 * sp.cos(a) + pair for a in ALPHA]
    return influence * EQUAL * sp.ImmutableMatrix([[diagonal[0], -pair], [-pair, diagonal[1]]])


@check(SOURCE, "(50)", "C", "The stiffness matrix of small disturbances of two equal balls.")
def equation_50() -> Claim:
    return equal(stiffness(A_XX / 2), -torques().xreplace(ALIKE).jacobian(ALPHA), stiffness(A_XX))


@check(SOURCE, "(51)", "K", "The matrix of (50), whose minors (52) decide.")
def equation_51() -> Claim:
    return equal(stiffness(A_XX / 2), -torques().xreplace(ALIKE).jacobian(ALPHA), stiffness(A_XX))


@check(
    SOURCE,
    "(53)",
    "(V_1, V_2)",
    "With the V_i of (47): the residual is the right-hand side of (53), printed as zero, at any angle.",
)
def equation_53() -> Claim:
    x, y = (balls().carrier(d, THETA) for d in ("x", "y"))
    moments = [-F[i] * (x * sp.sin(THETA + PHASES[i]) - y * sp.cos(THETA + PHASES[i])) for i in (1, 2)]
    half, whole = (sp.ImmutableMatrix([-influence * p for p in PULLS]) for influence in (A_XX / 2, A_XX))
    return equal(half, sp.Matrix(moments), whole)


@check(SOURCE, "(54)", r"J_i\ddot\psi_i + k_i\dot\psi_i", "The fluctuations where y is blocked, theta = Omega t.")
def equation_54() -> Claim:
    twice = [[F[j] * sp.sin(2 * THETA + PHASES[i] + PHASES[j]) for j in range(3)] for i in (1, 2)]
    printed = [-A_XX * F[i + 1] / 2 * sp.Add(*twice[i]) for i in range(2)]
    derived = [fluctuation_left(balls("x"), n, J[i], DAMPING[i]) for i, n in enumerate(BALLS)]
    return equal(sp.ImmutableMatrix(printed), sp.Matrix(derived))


ETA, VARTHETA, K, C, M_1, E_1, F_ONE, PHI = real(r"eta vartheta k c m_1 varepsilon_1 f_1 \Phi")
SCALED = {C: M * K**2, SPEED: ETA * K}
RESONANCE = (1 - ETA**2) ** 2 + 4 * VARTHETA**2 * ETA**2


@cache
def damped() -> Derived:
    """The machine of (12), (55), with eta and vartheta of (58) and k = sqrt(c/M)."""
    averaged_equations = averaged_equations_of(load_machine("sperling-vibration/figure-5", {}))
    put = {
        path("carrier.mass"): M - path("rotor.mass"),
        path("carrier.stiffness"): M * K**2,
        path("carrier.gravity"): sp.S.Zero,
    }
    put |= {path("carrier.damping"): 2 * VARTHETA * M * K, path("rotor.speed"): ETA * K, path("rotor.inertia"): J[0]}
    put |= {path("rotor.eccentricity"): M_1 * E_1 / path("rotor.mass"), path("rotor.bearing_damping"): sp.S.Zero}
    put |= {path("drive.slope"): DAMPING[0], path("drive.no_load_speed"): PARTIAL[0]}
    return Derived(averaged_equations, (put,))


@check(SOURCE, "(58) amplitude", r"\Delta^2", "The amplitude in (57), squared: |z|^2.")
def amplitude_58() -> Claim:
    re, im = (damped().output(f"amplitude.{part}[x]") for part in ("re", "im"))
    return equal((M_1 / M) ** 2 * ETA**4 / RESONANCE * E_1**2, re**2 + im**2)


@check(SOURCE, "(58) phase", r"\tan\Phi", "The phase in (57): -Im z/Re z.")
def phase_58() -> Claim:
    re, im = (damped().output(f"amplitude.{part}[x]") for part in ("re", "im"))
    return equal(2 * VARTHETA * ETA / (1 - ETA**2), -im / re)


BRAKE = (M_1 / M) ** 2 * VARTHETA * ETA**5 / RESONANCE * C * E_1**2


@check(SOURCE, "(59)", "V_1", "The vibration torque.")
def equation_59() -> Claim:
    return equal(-BRAKE, damped().output("vibration_torque[rotor]"), put=SCALED)


@check(SOURCE, "(60)", r"k_1 \Omega", "The slow equation at a steady speed, solved for it.")
def equation_60() -> Claim:
    steady = J[0] * damped().rate("rotor.speed") + DAMPING[0] * ETA * K
    return equal(DAMPING[0] * PARTIAL[0] - BRAKE, steady, put=SCALED)


@check(
    SOURCE,
    "(61)",
    r"J_1\ddot\psi_1 + k_1\dot\psi_1",
    "The fluctuation at twice the speed, theta = Omega t + alpha_1; sin and cos of Phi from (58).",
)
def equation_61() -> Claim:
    printed = -(F_ONE**2) / (2 * sp.sqrt(RESONANCE) * C) * sp.sin(2 * THETA - PHI)
    phase = {PHI: tuple(v / sp.sqrt(RESONANCE) for v in (2 * VARTHETA * ETA, 1 - ETA**2))}
    derived = fluctuation_left(damped(), "rotor", J[0], DAMPING[0])
    force = {F_ONE: M_1 * E_1 * (ETA * K) ** 2}
    return Claim(printed, lambda e: derived - turned(e, phase).xreplace(force), put=SCALED)
