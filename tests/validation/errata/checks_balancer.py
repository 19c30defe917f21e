"""002, chapter 4: the averaged equations of a rotor with two balancing pendulums."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine

from .check import Claim, check, equal
from .derived import Derived, full_rows, path, real

SOURCE = "002"
EPSILON, MU, S, W, BETA_P, BETA_R, LAMBDA, SIGMA, U = real("epsilon mu s w beta_p beta_r lambda sigma u")
OMEGA, PSI, DELTA, A, B = real("omega psi delta A B")
PHI = path("phi")
DIRECTIONS = ("x", "y")


@cache
def balancer(short: bool = True) -> Derived:
    """The machine of Table 5.1 with symbols for its parameters; short: with A and B of (4.42), (4.43)."""
    averaged_equations = averaged_equations_of(load_machine("drozdetskaya-2020/table-5.1", {}), inertia=False)
    put = {path("rotor.speed"): OMEGA, path("p1.phase"): PSI + DELTA / 2, path("p2.phase"): PSI - DELTA / 2}
    names = {f"D[{d}].{part}": symbol for d in DIRECTIONS for part, symbol in (("re", A), ("im", B))}
    return Derived(averaged_equations, (put,), names if short else {})


@cache
def rates() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Speed, mean phase and opening angle of the pendulums, derived by the rotor's angle."""
    d = balancer()
    first, second = d.rate("p1.phase"), d.rate("p2.phase")
    return d.rate("rotor.speed") / OMEGA, (first + second) / (2 * OMEGA), (first - second) / OMEGA


D = A**2 + B**2
MOTOR = EPSILON * U * (LAMBDA - OMEGA) / (OMEGA * (BETA_P + BETA_R))
FIELD = OMEGA**3 / (D * (BETA_P + BETA_R))


def moments(f: type[sp.cos] | type[sp.sin]) -> sp.Expr:
    """The sum in (4.38) to (4.56)."""
    return S * f(PHI) + f(PHI + PSI + DELTA / 2) + f(PHI + PSI - DELTA / 2)


@check(SOURCE, "(4.16)", r"f_\xi", "The force on the carrier in its equation of motion; the last term stands twice in print.")
def equation_4_16() -> Claim:
    return _force(sp.cos, sp.sin, "x", 1)


@check(SOURCE, "(4.17)", r"f_\eta", "(4.16) in the other direction.")
def equation_4_17() -> Claim:
    return _force(sp.sin, sp.cos, "y", -1)


def _force(f: type[sp.Function], g: type[sp.Function], direction: str, sign: int) -> Claim:
    machine = load_machine("drozdetskaya-2020/table-5.1", {})
    phi1, phi2, psi1, psi2, delta1, delta2 = real(r"{\phi}' {\phi}'' {\psi}' {\psi}'' {\delta}' {\delta}''")
    put = {path("rotor.angle"): PHI, path("rotor.speed"): phi1, path("rotor.angle.acceleration"): phi2}
    for body, s in (("p1", 1), ("p2", -1)):
        put |= {path(f"{body}.angle"): PHI + PSI + s * DELTA / 2, path(f"{body}.speed"): phi1 + psi1 + s * delta1 / 2}
        put |= {path(f"{body}.angle.acceleration"): phi2 + psi2 + s * delta2 / 2}
    row = full_rows(machine, put)[f"carrier.{direction}"]
    x, v, a = (path(f"carrier.{n}") for n in (direction, f"v{direction}", f"{direction}.acceleration"))
    force = a + 2 * SIGMA * v + x - row
    right = S * (phi1**2 * f(PHI) + sign * phi2 * g(PHI))
    for s in (1, -1):
        angle, speed = PHI + PSI + s * DELTA / 2, phi1 + psi1 + s * delta1 / 2
        last = sign * (phi2 + psi2 + s * delta2 / 2) * g(angle)
        right += speed**2 * f(angle) + last
    return equal(right + last, force, right)


@check(SOURCE, "(4.40)", r"\xi_{p0}", "The forced motion of the carrier, from the carrier's response H(w).")
def equation_4_40() -> Claim:
    return equal(OMEGA**2 / D * (A * moments(sp.cos) + B * moments(sp.sin)), balancer().carrier("x", PHI))


@check(SOURCE, "(4.41)", r"\eta_{p0}", "(4.40) in the other direction.")
def equation_4_41() -> Claim:
    return equal(OMEGA**2 / D * (A * moments(sp.sin) - B * moments(sp.cos)), balancer().carrier("y", PHI))


@check(SOURCE, "(4.42), (4.43)", r"(A, B)", "Re and Im of 1/H, the abbreviations of all that follows.")
def equations_4_42_and_4_43() -> Claim:
    d = balancer(short=False)
    return equal(
        sp.ImmutableMatrix([1 - OMEGA**2, 2 * SIGMA * OMEGA]), sp.Matrix([d.definition(f"D[x].{p}") for p in ("re", "im")])
    )


def right_4_60(sign: int) -> sp.Expr:
    """(4.60), with this sign of mu beta_r s beside cos(psi)."""
    across = A * (2 * EPSILON * BETA_P * W - MU * BETA_R * S) * sp.sin(PSI)
    along = B * (2 * EPSILON * BETA_P * W + sign * MU * BETA_R * S) * sp.cos(PSI)
    still = B * (MU * BETA_R * (sp.cos(DELTA) + 1) + EPSILON * BETA_P * S * W)
    return BETA_P * MOTOR + FIELD * ((across - along) * sp.cos(DELTA / 2) - still)


def right_4_61(last: int) -> sp.Expr:
    """(4.61) with mu (cos(delta) + last)."""
    swing = B * (2 * EPSILON * W - MU * S) * sp.cos(PSI) - A * (2 * EPSILON * W + MU * S) * sp.sin(PSI)
    return -MOTOR + FIELD * (swing * sp.cos(DELTA / 2) - B * (MU * (sp.cos(DELTA) + last) - EPSILON * S * W))


RIGHT_4_62 = (
    -2
    * MU
    * OMEGA**3
    / (BETA_P * D)
    * (A * S * sp.cos(PSI) - B * S * sp.sin(PSI) + 2 * A * sp.cos(DELTA / 2))
    * sp.sin(DELTA / 2)
)


@check(
    SOURCE, "(4.60)", r"\frac{d\omega}{d\phi}", "The rotor's speed; omega' / omega of the strongly damped averaged equations."
)
def equation_4_60() -> Claim:
    return equal(right_4_60(1), rates()[0])


@check(SOURCE, "(4.61)", r"\frac{d\psi}{d\phi}", "The pendulums' mean phase, psi = (alpha_1 + alpha_2)/2.")
def equation_4_61() -> Claim:
    return equal(right_4_61(-1), rates()[1], right_4_61(1))


@check(SOURCE, "(4.62)", r"\frac{d\delta}{d\phi}", "The pendulums' opening angle, delta = alpha_1 - alpha_2.")
def equation_4_62() -> Claim:
    return equal(RIGHT_4_62, rates()[2])


@check(SOURCE, "end of 4.2", "(n, 2n)", "Degrees of freedom and order of the full system, counted in the program's System.")
def end_of_4_2() -> Claim:
    machine = load_machine("drozdetskaya-2020/table-5.1", {})
    counted = sp.Matrix([len(machine.coordinates), len(machine.system.states)])
    return equal(sp.ImmutableMatrix([4, 8]), counted, sp.ImmutableMatrix([5, 10]))
