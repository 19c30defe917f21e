"""The dissertation: unbalanced rotors with a motor of limited power, without and with two balancing pendulums.

Olga Drozdetskaya, "Zur Dynamik eines unwuchtigen Rotors mit Selbstauswuchtsystem" (On the dynamics of an unbalanced
rotor with a self-balancing system), dissertation, Karlsruher Institut fuer Technologie (KIT), Karlsruhe 2020. Source 002;
equations, tables and figures are numbered as there, corrected where ``errata.md`` says so.

First the equations: what wucht derives from energies is, to a residual of exactly zero, what the dissertation prints. Then
the numbers: run-ups of the full equations against values computed independently (``cases.md``: SciPy/Numba at rtol 1e-11,
AUTO-07p, a multibody model).

Tolerances, unless a case says otherwise: relative 1e-6 where the reference has seven or more digits, else one unit of its
last digit. The integration itself is good to about 1e-10 (tolerance 1e-12 a step) and never decides.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht import RunUp, run
from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.analysis.vibration import Vibration
from wucht.files.building import machine_from
from wucht.files.catalogue import load_document, load_machine
from wucht.machines.machine import Machine
from wucht.mechanics.lagrange import acceleration, equations_of_motion

SEVEN_DIGITS = 1e-6  # relative

# ----------------------------------------------------------------------------------------------------------------------
# Equations
# ----------------------------------------------------------------------------------------------------------------------

SIN, COS = sp.sin, sp.cos


def symbol(path: str) -> sp.Symbol:
    """wucht's symbol of a state or parameter."""
    return sp.Symbol(path, real=True)


def left_minus_right(machine: Machine) -> dict[str, sp.Expr]:
    """The derived equations as ``mass * acceleration - forces``, by coordinate."""
    motion = equations_of_motion(machine.energies, machine.coordinates)
    a = sp.Matrix([acceleration(c) for c in machine.coordinates])
    rows = motion.mass * a - motion.forces
    return {c.position.name: row for c, row in zip(machine.coordinates, rows, strict=True)}


def is_zero(expression: sp.Expr, given: dict[sp.Symbol, sp.Expr] | None = None) -> bool:
    """Zero as a polynomial in all symbols and in the sines and cosines of the single angles.

    ``given``: relations between the symbols, put in last.
    """
    return sp.expand(sp.expand_trig(sp.expand(expression)).xreplace(given or {})) == 0


def si_rotor(directions: str, pendulums: int = 0) -> Machine:
    """An SI machine with a rotor "drum", a linear drive and pendulums "p1", "p2", ...; only its structure matters here."""
    pendulum = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "inertia": 1.69e-3, "damping": 0.169}
    return machine_from(
        {
            "carrier": {"directions": directions, "stiffness": 1e5, "damping": 200.0},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 9.75e-4},
                *({**pendulum, "name": f"p{i + 1}"} for i in range(pendulums)),
            ],
            "drive": {"kind": "linear", "slope": 0.0195, "no_load_speed": 200.0},
        }
    )


# What wucht's machines have and the dissertation's have not: a carrier with a mass of its own, gravity, a lossy bearing.
ABSENT = {symbol("carrier.mass"): 0, symbol("carrier.gravity"): 0, symbol("drum.bearing_damping"): 0}

# The dissertation's symbols for wucht's.
M, e, J_R = symbol("drum.mass"), symbol("drum.eccentricity"), symbol("drum.inertia")
b, c = symbol("carrier.damping"), symbol("carrier.stiffness")
x, y, vx, vy = (symbol(f"carrier.{n}") for n in ("x", "y", "vx", "vy"))
phi, phi_1 = symbol("drum.angle"), symbol("drum.speed")
theta, theta_1 = ([symbol(f"p{i}.{n}") for i in (1, 2)] for n in ("angle", "speed"))
U_M, omega_star = symbol("drive.slope"), symbol("drive.no_load_speed")
T_M = U_M * (omega_star - phi_1)  # (3.27), (4.5)


def second_derivatives(machine: Machine) -> list[sp.Symbol]:
    return [acceleration(q) for q in machine.coordinates]


def test_rotor_on_a_carrier_that_moves_in_x_equations_3_28_and_3_29():
    machine = si_rotor("x")
    x_2, phi_2 = second_derivatives(machine)
    derived = left_minus_right(machine)
    equation_3_28 = M * x_2 + b * vx + c * x - M * e * (phi_1**2 * COS(phi) + phi_2 * SIN(phi))
    equation_3_29 = J_R * phi_2 - T_M - M * e * x_2 * SIN(phi)
    assert is_zero(derived["carrier.x"].subs(ABSENT) - equation_3_28)
    assert is_zero(derived["drum.angle"].subs(ABSENT) - equation_3_29)


def test_elastic_rotor_equations_3_53_to_3_55():
    machine = si_rotor("xy")
    x_2, y_2, phi_2 = second_derivatives(machine)
    derived = left_minus_right(machine)
    equation_3_53 = M * x_2 + b * vx + c * x - M * e * (phi_1**2 * COS(phi) + phi_2 * SIN(phi))
    equation_3_54 = M * y_2 + b * vy + c * y - M * e * (phi_1**2 * SIN(phi) - phi_2 * COS(phi))
    equation_3_55 = J_R * phi_2 - T_M - M * e * (x_2 * SIN(phi) - y_2 * COS(phi))
    assert is_zero(derived["carrier.x"].subs(ABSENT) - equation_3_53)
    assert is_zero(derived["carrier.y"].subs(ABSENT) - equation_3_54)
    assert is_zero(derived["drum.angle"].subs(ABSENT) - equation_3_55)


# The dissertation's two pendulums are equal: one m, r, J_P and b_r for both.
m, r, J_P, b_r = (symbol(f"p1.{n}") for n in ("mass", "length", "inertia", "damping"))
EQUAL_PENDULUMS = {symbol(f"p2.{n}"): symbol(f"p1.{n}") for n in ("mass", "length", "inertia", "damping")}


def test_rotor_with_two_pendulums_equations_4_1_to_4_5():
    machine = si_rotor("xy", pendulums=2)
    x_2, y_2, phi_2, *theta_2 = second_derivatives(machine)
    derived = {name: row.subs(ABSENT | EQUAL_PENDULUMS) for name, row in left_minus_right(machine).items()}
    pendulums = list(zip(theta, theta_1, theta_2, strict=True))
    equation_4_1 = (M + 2 * m) * x_2 + b * vx + c * x - M * e * (phi_1**2 * COS(phi) + phi_2 * SIN(phi))
    equation_4_1 -= sum(m * r * (t_1**2 * COS(t) + t_2 * SIN(t)) for t, t_1, t_2 in pendulums)
    equation_4_2 = (M + 2 * m) * y_2 + b * vy + c * y - M * e * (phi_1**2 * SIN(phi) - phi_2 * COS(phi))
    equation_4_2 -= sum(m * r * (t_1**2 * SIN(t) - t_2 * COS(t)) for t, t_1, t_2 in pendulums)
    equation_4_3 = J_R * phi_2 + b_r * (2 * phi_1 - theta_1[0] - theta_1[1]) - T_M - M * e * (x_2 * SIN(phi) - y_2 * COS(phi))
    assert is_zero(derived["carrier.x"] - equation_4_1)
    assert is_zero(derived["carrier.y"] - equation_4_2)
    assert is_zero(derived["drum.angle"] - equation_4_3)
    for name, (t, t_1, t_2) in zip(("p1.angle", "p2.angle"), pendulums, strict=True):
        equation_4_4 = J_P * t_2 + b_r * (t_1 - phi_1) - m * r * (x_2 * SIN(t) - y_2 * COS(t))
        assert is_zero(derived[name] - equation_4_4)


# The dissertation's dimensionless symbols; a prime is a derivative by tau = k t.
epsilon, sigma, lambda_, u = (symbol(n) for n in ("epsilon", "sigma", "lambda", "u"))
mu, s, w, beta_p, beta_r = (symbol(n) for n in ("mu", "s", "w", "beta_p", "beta_r"))
xi, eta, xi_1, eta_1 = x, y, vx, vy
PHI, PHI_1 = symbol("rotor.angle"), symbol("rotor.speed")


def test_dimensionless_rotor_on_a_carrier_equations_3_33_and_3_34():
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier")
    xi_2, phi_2 = second_derivatives(machine)
    derived = left_minus_right(machine)
    equation_3_33 = xi_2 + 2 * sigma * xi_1 + xi - PHI_1**2 * COS(PHI) - phi_2 * SIN(PHI)
    equation_3_34 = phi_2 - epsilon * (u * (lambda_ - PHI_1) + xi_2 * SIN(PHI))
    assert is_zero(derived["carrier.x"] - equation_3_33)
    # Derived from an energy, the equation of phi carries its inertia, 1/epsilon, on the left.
    assert is_zero(epsilon * derived["rotor.angle"] - equation_3_34)


def test_dimensionless_elastic_rotor_equations_3_59_to_3_61():
    machine = load_machine("drozdetskaya-2020/table-3.1-laval")
    xi_2, eta_2, phi_2 = second_derivatives(machine)
    derived = left_minus_right(machine)
    equation_3_59 = xi_2 + 2 * sigma * xi_1 + xi - PHI_1**2 * COS(PHI) - phi_2 * SIN(PHI)
    equation_3_60 = eta_2 + 2 * sigma * eta_1 + eta - PHI_1**2 * SIN(PHI) + phi_2 * COS(PHI)
    equation_3_61 = phi_2 - epsilon * (u * (lambda_ - PHI_1) + xi_2 * SIN(PHI) - eta_2 * COS(PHI))
    assert is_zero(derived["carrier.x"] - equation_3_59)
    assert is_zero(derived["carrier.y"] - equation_3_60)
    assert is_zero(epsilon * derived["rotor.angle"] - equation_3_61)


# psi, delta of (4.6), (4.7) and their first and second derivatives, for the equations (4.11)-(4.20).
psi, psi_1, psi_2 = sp.symbols("psi psi' psi''", real=True)
delta, delta_1, delta_2 = sp.symbols("delta delta' delta''", real=True)


def equations_4_11_to_4_15(xi_2: sp.Expr, eta_2: sp.Expr, phi_2: sp.Expr) -> dict[str, sp.Expr]:
    """(4.11)-(4.15) with (4.16)-(4.20), left minus right; errata: the last term of (4.16) and of (4.17) stands once."""
    ahead, behind = PHI + psi + delta / 2, PHI + psi - delta / 2  # theta_1, theta_2
    ahead_1, behind_1 = PHI_1 + psi_1 + delta_1 / 2, PHI_1 + psi_1 - delta_1 / 2
    ahead_2, behind_2 = phi_2 + psi_2 + delta_2 / 2, phi_2 + psi_2 - delta_2 / 2
    f_xi = s * (PHI_1**2 * COS(PHI) + phi_2 * SIN(PHI))  # (4.16)
    f_xi += ahead_1**2 * COS(ahead) + ahead_2 * SIN(ahead) + behind_1**2 * COS(behind) + behind_2 * SIN(behind)
    f_eta = s * (PHI_1**2 * SIN(PHI) - phi_2 * COS(PHI))  # (4.17)
    f_eta += ahead_1**2 * SIN(ahead) - ahead_2 * COS(ahead) + behind_1**2 * SIN(behind) - behind_2 * COS(behind)
    epsilon_f_phi = epsilon * (u * (lambda_ - PHI_1) + w * (xi_2 * SIN(PHI) - eta_2 * COS(PHI)))  # (4.18)
    epsilon_f_psi = mu * (xi_2 * SIN(PHI + psi) - eta_2 * COS(PHI + psi)) * COS(delta / 2) - epsilon_f_phi  # (4.19)
    epsilon_f_delta = 2 * mu * (xi_2 * COS(PHI + psi) + eta_2 * SIN(PHI + psi)) * SIN(delta / 2)  # (4.20)
    return {
        "4.11": xi_2 + 2 * sigma * xi_1 + xi - f_xi,
        "4.12": eta_2 + 2 * sigma * eta_1 + eta - f_eta,
        "4.13": phi_2 - beta_r * psi_1 - epsilon_f_phi,
        "4.14": psi_2 + (beta_r + beta_p) * psi_1 - epsilon_f_psi,
        "4.15": delta_2 + beta_p * delta_1 - epsilon_f_delta,
    }


def in_psi_and_delta(machine: Machine, phi_2: sp.Symbol) -> dict[sp.Symbol, sp.Expr]:
    """theta_1 = phi + psi + delta/2, theta_2 = phi + psi - delta/2, and their derivatives: (4.6), (4.7) solved."""
    put: dict[sp.Symbol, sp.Expr] = {}
    for body, sign in zip(machine.bodies[1:], (1, -1), strict=True):
        q = body.coordinate
        put[q.position] = PHI + psi + sign * delta / 2
        put[q.velocity] = PHI_1 + psi_1 + sign * delta_1 / 2
        put[acceleration(q)] = phi_2 + psi_2 + sign * delta_2 / 2
    return put


def assert_equal_4_11_to_4_15(
    xi_row: sp.Expr,
    eta_row: sp.Expr,
    phi_row: sp.Expr,
    theta_rows: list[sp.Expr],
    printed: dict[str, sp.Expr],
    given: dict[sp.Symbol, sp.Expr] | None = None,
) -> None:
    """Rows with unit inertia: (4.14) is the mean of the pendulums' equations less the rotor's, (4.15) their difference."""
    first, second = theta_rows
    assert is_zero(xi_row - printed["4.11"], given)
    assert is_zero(eta_row - printed["4.12"], given)
    assert is_zero(phi_row - printed["4.13"], given)
    assert is_zero((first + second) / 2 - phi_row - printed["4.14"], given)
    assert is_zero(first - second - printed["4.15"], given)


@pytest.mark.parametrize("name", ["table-5.1", "table-a.1"])
def test_dimensionless_rotor_with_two_pendulums_equations_4_11_to_4_20(name: str):
    machine = load_machine(f"drozdetskaya-2020/{name}")
    xi_2, eta_2, phi_2 = second_derivatives(machine)[:3]
    put = in_psi_and_delta(machine, phi_2)
    derived = {q: row.xreplace(put) for q, row in left_minus_right(machine).items()}
    # Derived from energies, each equation is the printed one times a weight: 1 for xi and eta, s/(epsilon w) for phi,
    # 1/mu for theta.
    assert_equal_4_11_to_4_15(
        derived["carrier.x"],
        derived["carrier.y"],
        derived["rotor.angle"] * epsilon * w / s,
        [mu * derived["p1.angle"], mu * derived["p2.angle"]],
        equations_4_11_to_4_15(xi_2, eta_2, phi_2),
    )


def test_scaling_4_8_to_4_10_leads_from_4_1_to_4_20():
    """The equations derived for the SI machine, scaled with the definitions (4.8)-(4.10), are (4.11)-(4.20)."""
    machine = si_rotor("xy", pendulums=2)
    k, M_star = sp.symbols("k M_star", positive=True)
    xi_2, eta_2, phi_2 = sp.symbols("xi'' eta'' phi''", real=True)
    definitions = definitions_4_8(k, M_star)

    length = m * r / M_star  # (4.10); each dot is a factor k (4.9)
    a_x, a_y, a_phi, *a_theta = second_derivatives(machine)
    scaled = {x: length * xi, vx: length * k * xi_1, a_x: length * k**2 * xi_2}
    scaled |= {y: length * eta, vy: length * k * eta_1, a_y: length * k**2 * eta_2}
    scaled |= {phi: PHI, phi_1: k * PHI_1, a_phi: k**2 * phi_2}
    for t, t_1, t_2, sign in zip(theta, theta_1, a_theta, (1, -1), strict=True):
        scaled[t] = PHI + psi + sign * delta / 2
        scaled[t_1] = k * (PHI_1 + psi_1 + sign * delta_1 / 2)
        scaled[t_2] = k**2 * (phi_2 + psi_2 + sign * delta_2 / 2)
    stiffness = {c: k**2 * M_star}

    rows = {q: row.subs(ABSENT | EQUAL_PENDULUMS).xreplace(scaled | stiffness) for q, row in left_minus_right(machine).items()}
    printed = equations_4_11_to_4_15(xi_2, eta_2, phi_2)
    assert_equal_4_11_to_4_15(
        rows["carrier.x"] / (k**2 * m * r),
        rows["carrier.y"] / (k**2 * m * r),
        rows["drum.angle"] / (k**2 * J_R),
        [rows[f"p{i}.angle"] / (k**2 * J_P) for i in (1, 2)],
        {number: row.xreplace(definitions) for number, row in printed.items()},
        given={M: M_star - 2 * m},
    )


def definitions_4_8(k: sp.Expr, M_star: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """The dimensionless numbers (4.8) in SI symbols; k and M* are kept as symbols."""
    p = m * r**2 / J_P
    return {
        s: M * e / (m * r),
        epsilon: M * e**2 / J_R,
        mu: p * m / M_star,
        w: m * r / (M_star * e),
        sigma: b / (2 * k * M_star),
        beta_r: 2 * b_r / (k * J_R),
        beta_p: b_r / (k * J_P),
        lambda_: omega_star / k,
        u: U_M / (k * M * e**2),
    }


def test_definitions_4_8_imply_what_table_5_1_breaks():
    """Errata: mu s beta_r = 2 epsilon w beta_p and s w = 1 - 2 mu/p hold for every machine in SI units."""
    k, M_star = sp.symbols("k M_star", positive=True)
    put, p = definitions_4_8(k, M_star), m * r**2 / J_P
    assert is_zero((mu * s * beta_r - 2 * epsilon * w * beta_p).xreplace(put))
    assert is_zero((s * w - 1 + 2 * mu / p).xreplace(put), given={M: M_star - 2 * m})


# The first-order System, in which M a = F has been solved ------------------------------------------------------------


def test_elimination_solves_the_simplest_machine_symbolically():
    """The System of (3.28)-(3.29): its accelerations, put into M a - F, leave zero."""
    machine = si_rotor("x")
    system = machine.system
    motion = system.second_order
    assert motion is not None
    a = sp.Matrix([system.explicit(acceleration(q)) for q in machine.coordinates])
    assert sp.simplify(motion.mass * a - motion.forces) == sp.zeros(2, 1)


@pytest.mark.parametrize(
    "machine",
    [
        pytest.param(si_rotor("xy"), id="3.53-3.55"),
        pytest.param(si_rotor("xy", pendulums=2), id="4.1-4.4"),
        pytest.param(load_machine("drozdetskaya-2020/table-3.1-carrier"), id="3.33-3.34"),
        pytest.param(load_machine("drozdetskaya-2020/table-3.1-laval"), id="3.59-3.61"),
        pytest.param(load_machine("drozdetskaya-2020/table-5.1"), id="4.11-4.20"),
    ],
)
def test_elimination_solves_mass_times_acceleration_equals_forces(machine: Machine):
    """At random states the System's derivatives equal the solution of M a = F by LAPACK."""
    system = machine.system
    motion = system.second_order
    assert motion is not None
    state_symbols = [*motion.coordinates, *motion.velocities]
    evaluate = sp.lambdify(
        state_symbols,
        [
            motion.mass.xreplace(machine.numbers),
            motion.forces.xreplace(machine.numbers),
            [system.explicit(acceleration(q)).xreplace(machine.numbers) for q in machine.coordinates],
        ],
        cse=True,
    )
    random = np.random.default_rng(20200101)
    for _ in range(20):
        mass, forces, eliminated = evaluate(*random.uniform(-3, 3, len(state_symbols)))
        solved = np.linalg.solve(mass, np.ravel(forces))
        # Two ways to solve one system: rounding alone, 1e-16 times the condition of the mass matrix.
        np.testing.assert_allclose(eliminated, solved, rtol=1e-10, atol=1e-10 * np.abs(solved).max())


# ----------------------------------------------------------------------------------------------------------------------
# Chapter 3: the rotor without balancers, Table 3.1
# ----------------------------------------------------------------------------------------------------------------------


@cache
def result_of(name: str, *settings: tuple[str, Any], **start: Any) -> tuple[dict[str, Any], Any]:
    """Run the study of a catalogue entry, with parameters set, and return its summary and its Dataset."""
    machine = load_machine(f"drozdetskaya-2020/{name}", dict(settings))
    study = dict(load_document(f"drozdetskaya-2020/{name}")[0]["study"])
    if start:
        study["start"] = {body: dict(value) if isinstance(value, tuple) else value for body, value in start.items()}
    result = run(RunUp.from_table(study), machine)
    return result.wucht.summary, result


def motor_less_vibration(machine: Machine, speed: float) -> float:
    """The averaged equation (3.50), (3.67): motor torque less vibration torque at a speed."""
    values = machine.values
    return values["u"] * (values["lambda"] - speed) - float(Vibration.of(machine).torque(np.array([speed]), np.zeros(1))[0][0])


@pytest.mark.parametrize("name, factor", [("table-3.1-carrier", 1), ("table-3.1-laval", 2)])
def test_folds_of_the_averaged_equation_figure_3_2(name: str, factor: int):
    """u over omega, (3.52) corrected, has its extrema at the folds; in two directions the values of u double (3.67)."""
    from scipy.optimize import minimize_scalar

    machine = load_machine(f"drozdetskaya-2020/{name}")
    vibration, no_load = Vibration.of(machine), machine.values["lambda"]

    def slope_needed(speed: float) -> float:
        return float(vibration.torque(np.array([speed]), np.zeros(1))[0][0]) / (no_load - speed)

    for (speed, u_fold), sign in zip([(1.0213376, 2.6053860), (1.4239669, 0.8937191)], (-1, 1), strict=True):
        actual = minimize_scalar(
            lambda w, sign=sign: sign * slope_needed(w), bounds=(speed - 0.1, speed + 0.1), options={"xatol": 1e-9}
        )
        assert sign * actual.fun == pytest.approx(factor * u_fold, rel=SEVEN_DIGITS)
        # At an extremum the abscissa is known only to the root of the rounding, 1e-8: still enough for seven digits.
        assert actual.x == pytest.approx(speed, rel=SEVEN_DIGITS)


@pytest.mark.parametrize("name, u_", [("table-3.1-carrier", 2.0), ("table-3.1-laval", 4.0)])
def test_stationary_speeds_of_the_averaged_equation_figure_3_2(name: str, u_: float):
    from scipy.optimize import brentq

    machine = load_machine(f"drozdetskaya-2020/{name}", {"u": u_})
    for speed in (0.9686444, 1.0937039, 1.8176384):
        actual = brentq(lambda w: motor_less_vibration(machine, w), speed - 0.02, speed + 0.02, xtol=1e-12)
        assert actual == pytest.approx(speed, rel=SEVEN_DIGITS)


def test_capture_on_a_carrier_in_one_direction_figure_3_3():
    """Full equations (3.33)-(3.34) at u = 2, from rest: captured near the stable 0.9686444 of the averaged equation."""
    actual, _ = result_of("table-3.1-carrier")
    assert actual["outcome"] == "captured"
    # The torque at twice the speed is averaged away, which is right only to O(epsilon), epsilon = 1e-3.
    # Measured: 0.017 epsilon.
    assert actual["final_speed"] == pytest.approx(0.9686444, abs=0.03 * 1e-3)
    # The speed ripples at twice its mean, +-1.1e-3 = +-1.1 epsilon: so all of it lies within 2 epsilon of the mean.
    assert actual["max_speed"] - actual["min_speed"] < 4 * 1e-3


@pytest.mark.parametrize("epsilon_", [1e-3, 2e-3, 4e-3, 8e-3])
def test_deviation_from_the_averaged_equation_is_of_first_order_in_epsilon(epsilon_: float):
    """The tolerance of the test above, explained: measured 0.017, 0.016, 0.020, 0.018 epsilon."""
    actual, _ = result_of("table-3.1-carrier", ("epsilon", epsilon_))
    assert 0.01 * epsilon_ < actual["final_speed"] - 0.9686444 < 0.03 * epsilon_


def test_state_near_no_load_speed_on_a_carrier_in_one_direction_figure_3_2():
    """Full equations at u = 2, started above it: the other stable speed, 1.8176384."""
    actual, _ = result_of("table-3.1-carrier", rotor=(("speed", 1.9),))
    assert actual["outcome"] == "passed"
    assert actual["final_speed"] == pytest.approx(1.8176384, abs=0.05 * 1e-3)  # O(epsilon): measured -0.033 epsilon


def test_capture_of_the_elastic_rotor_section_3_3_2():
    """Full equations (3.59)-(3.61) at u = 4: on an isotropic support their steady speed is exactly that of (3.67)."""
    actual, _ = result_of("table-3.1-laval")
    assert actual["outcome"] == "captured"
    assert actual["final_speed"] == pytest.approx(0.9686444, rel=SEVEN_DIGITS)
    # (3.63)-(3.65): the axis runs on a circle of radius omega^2/sqrt(A^2 + B^2), exactly; the approach has ended by then.
    speed = actual["final_speed"]
    assert actual["final_amplitude"] == pytest.approx(speed**2 / math.hypot(1 - speed**2, 0.2 * speed), rel=1e-8)


# ----------------------------------------------------------------------------------------------------------------------
# Chapter 5: the self-balancing rotor, Table 5.1, and Table A.1
# ----------------------------------------------------------------------------------------------------------------------


def test_table_5_1_is_no_machine():
    """The set as printed runs, with a warning that says what beta_r would be: 2 epsilon w beta_p/(mu s) = 3.46667."""
    warnings = load_machine("drozdetskaya-2020/table-5.1").warnings
    assert len(warnings) == 1
    assert "dampers' torque" in warnings[0]
    assert "3.46667" in warnings[0]
    assert load_machine("drozdetskaya-2020/table-5.1", {"beta_r": 2 * 0.01 * 1.3 / (0.01 * 0.75)}).warnings == ()


def test_table_a_1_is_no_machine():
    """Table A.1 needs p = 2, beyond the 1 of a point mass; and its beta_r should be 0.98."""
    warnings = load_machine("drozdetskaya-2020/table-a.1").warnings
    assert len(warnings) == 2
    assert any("p = 2" in completed for completed in warnings)
    assert any("beta_r = 0.98" in completed for completed in warnings)


@pytest.mark.parametrize("name", ["r1", "r2"])
def test_the_real_machines_need_no_warning(name: str):
    machine = load_machine(f"drozdetskaya-2020/{name}")
    assert machine.warnings == ()
    actual = dimensionless_numbers(machine)
    # They share Table 5.1's mu, s, w, beta_p, lambda and sigma to rounding; epsilon and beta_r are the errata's.
    assert [actual[n] for n in ("mu", "s", "w", "beta_p", "lambda", "sigma")] == pytest.approx([0.01, 0.75, 1.3, 1, 2, 0.1])
    own = {"r1": (0.01, 3.46667), "r2": (2.88462e-4, 0.1)}[name]
    assert actual["epsilon"] == pytest.approx(own[0], rel=5e-6)  # six digits are given
    assert actual["beta_r"] == pytest.approx(own[1], rel=5e-6)


def psi_and_delta(actual: dict[str, Any]) -> tuple[float, float]:
    """psi and delta of (4.6), (4.7) from the final phases."""
    first, second = (actual["final_phases"][p] for p in ("p1", "p2"))
    return (first + second) / 2, abs(first - second)


@pytest.mark.parametrize("u_", [1.0, 1.5])
def test_weak_motor_is_captured_figure_5_4(u_: float):
    """Run-up from rest, psi = 0, delta = 0.5: the pendulums come together (type II) and the rotor stays in its resonance."""
    actual, _ = result_of("table-5.1", ("u", u_))
    assert actual["outcome"] == "captured"
    _, delta_ = psi_and_delta(actual)
    assert math.sin(delta_ / 2) == pytest.approx(0, abs=1e-3)  # decays as exp(-0.016 phi): gone after 6000


def motor_of_type_II(speed: float, s_: float, w_: float, sigma_: float, no_load: float) -> float:
    """u at which type II (pendulums together, unbalance amplified) turns at ``speed``: (5.11) corrected, upper sign."""
    A, B = 1 - speed**2, 2 * sigma_ * speed  # (5.4)
    root = 4 * A * math.sqrt(A**2 * s_**2 + B**2 * (s_**2 - 4))
    bracket = A**2 * (s_**2 + 4) + B**2 * (s_**2 - 4) + root
    return 2 * sigma_ * w_ * speed**5 * bracket / (s_ * (no_load - speed) * (A**2 + B**2) ** 2)


@pytest.mark.parametrize("u_", [1.0, 1.5])
def test_captured_speed_is_that_of_type_II_equation_5_11(u_: float):
    """On isotropic supports a steady state of the averaged equations is one of the full equations, exactly."""
    actual, _ = result_of("table-5.1", ("u", u_))
    assert motor_of_type_II(actual["final_speed"], 0.75, 1.3, 0.1, 2.0) == pytest.approx(u_, rel=SEVEN_DIGITS)
    if u_ == 1.0:
        assert actual["final_speed"] == pytest.approx(0.7028953, rel=SEVEN_DIGITS)  # cases.md


@pytest.mark.parametrize("u_", [2.5, 2.75])
def test_medium_motor_is_captured_and_beats_figure_5_4(u_: float):
    """Between the folds u1* = 1.833 and u2* = 5.871: held in the resonance, above and below it, pendulums together."""
    actual, _ = result_of("table-5.1", ("u", u_))
    assert actual["outcome"] == "captured-modulated"
    assert actual["min_speed"] < 1 < actual["max_speed"]
    _, delta_ = psi_and_delta(actual)
    assert math.sin(delta_ / 2) == pytest.approx(0, abs=1e-3)


def test_period_of_the_modulation_at_u_2_5():
    """In phi, of the full equations: 745.8 (averaged: 766.5); one unit of the last digit."""
    actual, _ = result_of("table-5.1", ("u", 2.5))
    assert actual["modulation_period_phi"] == pytest.approx(745.8, abs=0.1)


@pytest.mark.parametrize("u_", [3.5, 5.0, 7.0])
def test_strong_motor_is_compensated_figure_5_4(u_: float):
    """Type I: no-load speed, psi = pi (5.5), delta = 2 arccos(s/2) = 2.3728 (5.6), no vibration left."""
    actual, _ = result_of("table-5.1", ("u", u_))
    assert actual["outcome"] == "compensated"
    assert actual["final_speed"] == pytest.approx(2.0, rel=SEVEN_DIGITS)  # (5.7)
    psi_, delta_ = psi_and_delta(actual)
    assert delta_ == pytest.approx(2.3728, abs=1e-4)  # the last digit
    assert delta_ == pytest.approx(2 * math.acos(0.75 / 2), abs=1e-6)  # exact; the approach decays as exp(-0.0018 phi)
    assert psi_ == pytest.approx(math.pi, abs=1e-6)
    assert actual["final_amplitude"] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("u_", [1.0, 2.5, 5.0])
def test_energy_of_the_printed_set_is_balanced(u_: float):
    """Booked apart, the printed dampers leave no residual; what they create from nothing is reported beside it."""
    actual, _ = result_of("table-5.1", ("u", u_))
    assert actual["energy_residual"] < 1e-9  # the quadratures are integrated with the states, to 1e-12 a step
    assert abs(actual["damper_mismatch"]) > 1


# ----------------------------------------------------------------------------------------------------------------------
# The nearest real machines R1 and R2 (errata), in SI units. Start theta = (0.3, -0.5) rad, all else at rest.
# ----------------------------------------------------------------------------------------------------------------------

SLOPE = 9.75e-4  # U_M = 9.75e-4 u N m s


def real_machine(name: str, u_: float) -> tuple[dict[str, Any], Any]:
    return result_of(name, ("drive.slope", SLOPE * u_))


def test_r1_with_u_1_is_captured():
    actual, _ = real_machine("r1", 1.0)
    assert actual["outcome"] == "captured"
    assert actual["final_speed"] == pytest.approx(70.2895, abs=1e-4)  # rad/s, the last digit
    assert actual["final_amplitude"] == pytest.approx(3.00e-3, abs=1e-5)  # m, the last digit


def test_r1_with_u_20_is_captured_and_beats():
    """Above and below the natural frequency of 100 rad/s in each period, the pendulums together and slipping behind."""
    actual, result = real_machine("r1", 20.0)
    assert actual["outcome"] == "captured-modulated"
    assert actual["min_speed"] == pytest.approx(88.340, abs=1e-3)
    assert actual["max_speed"] == pytest.approx(116.146, abs=1e-3)
    assert actual["max_amplitude"] == pytest.approx(10.97e-3, abs=1e-5)
    late = result.time > 50
    rotor, *pendulums = result.speed[:, late].values
    # Mean over many periods of the modulation (1.29 s): each pendulum loses one turn a period on the rotor, 2 pi/1.29 s.
    slip = 2 * math.pi / actual["modulation_period"]
    for pendulum in pendulums:
        assert rotor.mean() - pendulum.mean() == pytest.approx(slip, rel=0.03)  # 10 s are not a whole number of periods
    together = result.phase.dropna("body", how="all")[:, late].values
    np.testing.assert_allclose(np.sin((together[0] - together[1]) / 2), 0, atol=1e-6)


def test_r1_with_u_20_radius_of_the_orbit():
    """8.81 to 10.97 mm: on an isotropic support the distance of the axis from its rest is the amplitude at every instant."""
    _, result = real_machine("r1", 20.0)
    radius = result.radius[result.time > 50]
    assert float(radius.min()) == pytest.approx(8.81e-3, abs=1e-5)
    assert float(radius.max()) == pytest.approx(10.97e-3, abs=1e-5)


def test_r1_with_u_20_smallest_amplitude_in_the_summary():
    """The envelope that the summary takes its numbers from does not fill the bottom of the modulation."""
    actual, _ = real_machine("r1", 20.0)
    assert actual["min_amplitude"] == pytest.approx(8.81e-3, abs=1e-5)


@pytest.mark.parametrize("u_", [40.0, 80.0])
def test_r1_with_a_strong_motor_is_compensated(u_: float):
    actual, _ = real_machine("r1", u_)
    assert actual["outcome"] == "compensated"
    assert actual["final_speed"] == pytest.approx(200.0, rel=SEVEN_DIGITS)
    # Which pendulum goes to which side depends on the start; both sides must be taken.
    phases = sorted(math.degrees(actual["final_phases"][p]) for p in ("p1", "p2"))
    assert phases == pytest.approx([112.024, 247.976], abs=1e-3)  # pi -+ arccos(s/2)


@pytest.mark.parametrize("u_, outcome", [(20.0, "captured-modulated"), (80.0, "compensated")])
def test_r2(u_: float, outcome: str):
    """The heavy rotor: beta_r = 0.1 as in Table 5.1, epsilon = 2.88462e-4."""
    actual, _ = real_machine("r2", u_)
    assert actual["outcome"] == outcome


@pytest.mark.parametrize("name, u_", [("r1", 1.0), ("r1", 20.0), ("r1", 40.0), ("r2", 20.0)])
def test_energy_of_the_real_machines_is_balanced(name: str, u_: float):
    actual, _ = real_machine(name, u_)
    assert actual["energy_residual"] < 1e-9  # as above
    assert actual["damper_mismatch"] is None


# ----------------------------------------------------------------------------------------------------------------------
# SI and dimensionless: the same motion
# ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("u_", [1.0, 20.0, 40.0])
def test_si_machine_and_its_dimensionless_numbers_run_alike(u_: float):
    """R1 for 2 s, and (4.11)-(4.20) with its numbers for tau = 200: one motion, in units of 1/k and m r/M* (4.9), (4.10)."""
    si = load_machine("drozdetskaya-2020/r1", {"drive.slope": SLOPE * u_})
    scaled = dimensionless_numbers(si)
    assert scaled["u"] == pytest.approx(u_, rel=1e-14)
    model = machine_from({"model": "self-balancing-rotor", "parameters": {n: v for n, v in scaled.items() if n != "p"}})
    assert model.warnings == ()

    k = 100.0  # rad/s
    length = 0.125 * 0.104 / 10.0  # m r/M*
    start = {"p1": 0.3, "p2": -0.5}
    in_si = run(RunUp.from_table({"until": 2.0, "start": start}), si)
    in_tau = run(RunUp.from_table({"until": 2.0 * k, "start": start}), model)
    in_tau = in_tau.assign_coords(time=in_tau.time / k)

    # Both are sampled alike. 1e-9 of the largest value: 1e-12 a step, over some 60 turns, in a motion that is not chaotic.
    np.testing.assert_allclose(in_si.time, in_tau.time, rtol=1e-12)
    for name, unit in (("speed", k), ("displacement", length), ("velocity", length * k), ("angle", 1.0)):
        expected = in_tau[name].values * unit
        np.testing.assert_allclose(in_si[name].values, expected, rtol=0, atol=1e-9 * np.abs(expected).max(), err_msg=name)
    # Phases are compared on the circle.
    phases = (each.phase.dropna("body", how="all").values for each in (in_si, in_tau))
    turned = np.subtract(*(np.exp(1j * phase) for phase in phases))
    assert np.abs(turned).max() < 1e-9
