"""002, chapters 3.2 and 3.3: strongly damped systems, and rotors without balancers on a carrier."""

from __future__ import annotations

from functools import cache

import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.catalogue import load_machine
from wucht.mechanics.lagrange import acceleration

from .check import Claim, check, equal
from .derived import Derived, full_rows, path, real
from .machines import si_rotor

SOURCE = "002"
EPSILON, SIGMA, LAMBDA, U = real("epsilon sigma lambda u")
OMEGA, PHI, A, B = real("omega phi A B")
TABLES = {"x": "table-3.1-carrier", "xy": "table-3.1-laval"}
DEFINED = {A: 1 - OMEGA**2, B: 2 * SIGMA * OMEGA}  # (3.38), (3.65)
RESONANCE = (1 - OMEGA**2) ** 2 + 4 * SIGMA**2 * OMEGA**2


@cache
def rotor(directions: str, short: bool = False) -> Derived:
    """The machine of Table 3.1 on a carrier that moves in these directions, with symbols for its parameters."""
    averaged_equations = averaged_equations_of(load_machine(f"drozdetskaya-2020/{TABLES[directions]}", {}))
    names = {f"D[{d}].{part}": symbol for d in directions for part, symbol in (("re", A), ("im", B))}
    return Derived(averaged_equations, ({path("rotor.speed"): OMEGA},), names if short else {})


def acceleration_of_rotor(directions: str) -> sp.Expr:
    """omega' from the full equation of the rotor, the carrier in its forced motion."""
    machine = load_machine(f"drozdetskaya-2020/{TABLES[directions]}", {})
    d = rotor(directions, short=True)
    put = {path("rotor.angle"): PHI, path("rotor.speed"): OMEGA}
    put |= {path(f"carrier.{n}.acceleration"): -(OMEGA**2) * d.carrier(n, PHI) for n in directions}
    row = full_rows(machine, put)["rotor.angle"]
    actual: sp.Expr = sp.solve(row, path("rotor.angle.acceleration"))[0]
    return actual


@check(
    SOURCE,
    "before (3.19)",
    r"t(\tau)",
    "The slow time: x' = epsilon X must become dx/dtau = X; the residual is X less dx/dtau.",
)
def slow_time_before_3_19() -> Claim:
    tau, x = sp.symbols("tau X")
    return Claim(EPSILON * tau, lambda e: x - EPSILON * x * sp.diff(e, tau), tau / EPSILON)


@check(SOURCE, "(3.23)", r"\dot x", "Back from the slow time, dx/dt = (dx/dtau) (dtau/dt) with tau = epsilon t.")
def equation_3_23() -> Claim:
    x, t = sp.symbols("X t")
    return equal(x, x * sp.diff(EPSILON * t, t), EPSILON * x)


@check(
    SOURCE,
    "(3.26)",
    "t_1",
    "From when on the error is O(epsilon): the residual is exp(-t_1), what is left of a damped variable, less epsilon.",
)
def equation_3_26() -> Claim:
    small = sp.Symbol("epsilon", positive=True)
    return Claim(1 / sp.log(small), lambda e: sp.exp(-e) - small, sp.log(1 / small))


@check(
    SOURCE,
    "(3.30)",
    "u",
    "The motor parameter: the drive's torque of the machine in SI units, scaled with (3.30)-(3.32); K is k.",
)
def equation_3_30() -> Claim:
    return _motor_parameter("x")


@check(SOURCE, "(3.56)", "u", "(3.30) for a carrier that moves in two directions.")
def equation_3_56() -> Claim:
    return _motor_parameter("xy")


def _motor_parameter(directions: str) -> Claim:
    """Epsilon u (lambda - phi') is the torque over J k^2, and epsilon = M e^2/J."""
    M, e, J, k, K, U_M, no_load = real("M e J_R k K U_M lambda")
    machine = si_rotor(directions)
    put = {path("drum.inertia"): J, path("drive.slope"): U_M, path("drive.no_load_speed"): k * no_load}
    put |= {path("drum.speed"): k * OMEGA, path("drum.bearing_damping"): sp.S.Zero, path("carrier.gravity"): sp.S.Zero}
    still = dict.fromkeys((acceleration(c) for c in machine.coordinates if c.position.name != "drum.angle"), sp.S.Zero)
    row = full_rows(machine, put)["drum.angle"].xreplace(still)
    torque = J * path("drum.angle.acceleration") - row
    derived = torque / (J * k**2) / (M * e**2 / J) / (no_load - OMEGA)
    return equal(U_M / (K * M * e**2), derived, U_M / (k * M * e**2))


@check(SOURCE, "(3.37)", r"\xi_{p0}", "The forced motion of the carrier.")
def equation_3_37() -> Claim:
    return equal(OMEGA**2 * (A * sp.cos(PHI) + B * sp.sin(PHI)) / (A**2 + B**2), rotor("x", short=True).carrier("x", PHI))


@check(SOURCE, "(3.48)", r"\omega'", "(3.34) with (3.46): the rotor's equation, the carrier in its forced motion.")
def equation_3_48() -> Claim:
    pulse = OMEGA**4 * (A * sp.cos(PHI) + B * sp.sin(PHI)) * sp.sin(PHI) / (A**2 + B**2)
    motor = U * (LAMBDA - OMEGA)
    return equal(EPSILON * (motor + pulse), acceleration_of_rotor("x"), EPSILON * (motor - pulse))


@check(SOURCE, "(3.49)", r"\frac{d\omega}{d\phi}", "(3.34) with (3.46) by the rotor's angle.")
def equation_3_49() -> Claim:
    pulse = OMEGA**4 * (A * sp.cos(PHI) + B * sp.sin(PHI)) * sp.sin(PHI) / (A**2 + B**2)
    return equal(EPSILON / OMEGA * (U * (LAMBDA - OMEGA) - pulse), acceleration_of_rotor("x") / OMEGA)


@check(SOURCE, "(3.50)", r"\frac{d\bar\omega}{d\phi}", "The slow equation of a rotor on a carrier with one direction.")
def equation_3_50() -> Claim:
    printed = EPSILON / OMEGA * (U * (LAMBDA - OMEGA) - OMEGA**5 * SIGMA / RESONANCE)
    return equal(printed, rotor("x").rate("rotor.speed") / OMEGA)


@check(
    SOURCE,
    "(3.52)",
    "u",
    "(3.51) solved for the motor parameter: the averaged equation (3.50) at a steady speed; a bracket is lost.",
)
def equation_3_52() -> Claim:
    lost = OMEGA**5 * SIGMA / ((1 - OMEGA**2) ** 2 + 4 * SIGMA**2 * OMEGA**2 * (LAMBDA - OMEGA))
    derived = sp.solve(rotor("x").rate("rotor.speed"), U)[0]
    return equal(lost, derived, OMEGA**5 * SIGMA / (RESONANCE * (LAMBDA - OMEGA)))


@check(SOURCE, "(3.63)", r"\xi_{p0}", "The forced motion of a carrier with two directions.")
def equation_3_63() -> Claim:
    return equal(OMEGA**2 * (A * sp.cos(PHI) + B * sp.sin(PHI)) / (A**2 + B**2), rotor("xy", short=True).carrier("x", PHI))


@check(SOURCE, "(3.64)", r"\eta_{p0}", "(3.63) in the other direction.")
def equation_3_64() -> Claim:
    return equal(OMEGA**2 * (A * sp.sin(PHI) - B * sp.cos(PHI)) / (A**2 + B**2), rotor("xy", short=True).carrier("y", PHI))


@check(SOURCE, "(3.67)", r"\omega'", "The slow equation of an elastic rotor.")
def equation_3_67() -> Claim:
    printed = EPSILON * (U * (LAMBDA - OMEGA) - 2 * SIGMA * OMEGA**5 / RESONANCE)
    return equal(printed, rotor("xy").rate("rotor.speed"))


@check(SOURCE, "before (3.67)", r"\omega'", "The full equation (3.61) with (3.63), (3.64): it holds before averaging.")
def equation_3_67_before_averaging() -> Claim:
    printed = EPSILON * (U * (LAMBDA - OMEGA) - 2 * SIGMA * OMEGA**5 / RESONANCE)
    return equal(printed, acceleration_of_rotor("xy"), put=DEFINED)


@check(SOURCE, "(3.68)", r"\frac{d\omega}{d\phi}", "(3.67) by the rotor's angle.")
def equation_3_68() -> Claim:
    printed = EPSILON / OMEGA * (U * (LAMBDA - OMEGA) - 2 * SIGMA * OMEGA**5 / RESONANCE)
    return equal(printed, rotor("xy").rate("rotor.speed") / OMEGA)
