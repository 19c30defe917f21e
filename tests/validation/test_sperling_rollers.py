"""Two rollers that balance a rotor on an anisotropic support, at a prescribed speed.

L. Sperling, H. Duckstein, B. Ryzhik, "Selbsttaetiges Auswuchten mittels zweier beliebiger Rollen" (Self-balancing by means
of two arbitrary rollers), Institut fuer Mechanik, Otto-von-Guericke-Universitaet Magdeburg. Source 000; equations, tables
and figures ("Bild") are numbered as there. Errata: one of the two beta_0-bar of (17) is the drive's slope, the other the
bearing's damping.

The paper gives m = 1 kg, omega_x = 62.5 and omega_y = 125.1 rad/s, U_0 = 1e-4 kg m and three pairs of roller unbalances, but
no damping, no size of the rollers and no inertia. Ours are: rollers of 1 g in concentric tracks (U_i = 1 g * (R_i - r),
r = 10 mm, balls), which with the rotor make 1 kg; support damping 0.25 % of critical in each direction; roller damping
5e-5 N m s (2e-5 at 40 rad/s, where the synchronising torques are weakest), with which the phases settle within seconds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import fsolve

from wucht import RunUp, run
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.mechanics.lagrange import acceleration, equations_of_motion, reaction
from wucht.studies.study_file import read_study

OMEGA_X, OMEGA_Y = 62.5, 125.1  # rad/s, section 6
TOTAL_MASS = 1.0  # kg, section 6
U_0 = 1e-4  # kg m, section 6
SUPPORT_DAMPING = 0.0025  # of critical: ours
ROLLER_MASS, ROLLER_RADIUS = 1e-3, 0.01  # kg, m: ours


def machine(u_1: float, u_2: float, drive: dict[str, Any], damping: float = SUPPORT_DAMPING, beta: float = 5e-5) -> Machine:
    """The machine of section 6 with two rollers of unbalances u_1, u_2."""

    def roller(name: str, unbalance: float) -> dict[str, Any]:
        return {
            "kind": "roller", "name": name, "about": "drum", "mass": ROLLER_MASS, "radius": ROLLER_RADIUS, "damping": beta,
            "track_radius": unbalance / ROLLER_MASS + ROLLER_RADIUS,
        }  # fmt: skip

    return machine_from(
        {
            "carrier": {
                "directions": "xy",
                "stiffness": [TOTAL_MASS * OMEGA_X**2, TOTAL_MASS * OMEGA_Y**2],  # (28)
                "damping": [2 * damping * TOTAL_MASS * OMEGA_X, 2 * damping * TOTAL_MASS * OMEGA_Y],
            },
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": TOTAL_MASS - 2 * ROLLER_MASS, "unbalance": U_0, "inertia": 5e-3},
                roller("r1", u_1),
                roller("r2", u_2),
            ],
            "drive": drive,
        }
    )


# ----------------------------------------------------------------------------------------------------------------------
# Equations
# ----------------------------------------------------------------------------------------------------------------------


def symbol(path: str) -> sp.Symbol:
    """wucht's symbol of a state or parameter."""
    return sp.Symbol(path, real=True)


x, y, vx, vy = (symbol(f"carrier.{n}") for n in ("x", "y", "vx", "vy"))
phi, phi_1 = ([symbol(f"{body}.{n}") for body in ("drum", "r1", "r2")] for n in ("angle", "speed"))
x_2, y_2, *phi_2 = (symbol(f"{q}.acceleration") for q in ("x", "y", "phi0", "phi1", "phi2"))
m_1, m_2 = (symbol(f"r{i}.mass") for i in (1, 2))
R = {i: symbol(f"r{i}.track_radius") for i in (1, 2)}
eps = {i: R[i] - symbol(f"r{i}.radius") for i in (1, 2)}
beta = {i: symbol(f"r{i}.damping") for i in (1, 2)}
mu = {i: symbol(f"r{i}.shape_factor") for i in (1, 2)}
mass = {1: m_1, 2: m_2}

# The paper's primary rotor is a symmetric one, of m and J, and a point mass m_0 at eps_0: together the drum. wucht's carrier
# and drum share the mass m + m_0; the drum's inertia about the axis is J + m_0 eps_0^2, its unbalance m_0 eps_0.
M = symbol("carrier.mass") + symbol("drum.mass") + m_1 + m_2  # (6)
J_00 = symbol("drum.inertia") + sum(mu[i] * mass[i] * R[i] ** 2 for i in (1, 2))  # (6)
J_0 = {i: mu[i] * mass[i] * R[i] * eps[i] for i in (1, 2)}  # (7)
J = {i: (1 + mu[i]) * mass[i] * eps[i] ** 2 for i in (1, 2)}  # (7)
U = [symbol("drum.unbalance"), m_1 * eps[1], m_2 * eps[2]]  # m_i eps_i


def equations_18(drive_and_bearing: sp.Expr, constant_torque: sp.Expr) -> list[sp.Expr]:
    """(18), left minus right, with beta_0 = ``drive_and_bearing`` + sum beta_i of (17) and L_0 = ``constant_torque``."""
    kx, ky, cx, cy = (symbol(f"carrier.{n}") for n in ("stiffness.x", "stiffness.y", "damping.x", "damping.y"))
    sin, cos = [sp.sin(p) for p in phi], [sp.cos(p) for p in phi]
    forces_x = sum(U[i] * (phi_1[i] ** 2 * cos[i] + phi_2[i] * sin[i]) for i in range(3))
    forces_y = sum(U[i] * (phi_1[i] ** 2 * sin[i] - phi_2[i] * cos[i]) for i in range(3))
    beta_0 = drive_and_bearing + beta[1] + beta[2]  # (17)
    return [
        M * x_2 + cx * vx + kx * x - forces_x,
        M * y_2 + cy * vy + ky * y - forces_y,
        J_00 * phi_2[0]
        - sum(J_0[i] * phi_2[i] for i in (1, 2))
        + beta_0 * phi_1[0]
        - sum(beta[i] * phi_1[i] for i in (1, 2))
        - U[0] * (x_2 * sin[0] - y_2 * cos[0])
        - constant_torque,
        *(
            -J_0[i] * phi_2[0]
            + J[i] * phi_2[i]
            - beta[i] * phi_1[0]
            + beta[i] * phi_1[i]
            - U[i] * (x_2 * sin[i] - y_2 * cos[i])
            for i in (1, 2)
        ),
    ]


def test_equations_of_motion_18():
    """Mass matrix and forces derived from the energies (1)-(5), (9), (12) and (16) are those of (18), to zero residual."""
    linear = machine(1.2e-4, 0.8e-4, {"kind": "linear", "slope": 1.0, "no_load_speed": 100.0})
    motion = equations_of_motion(linear.energies, linear.coordinates)
    derived = motion.mass * sp.Matrix([x_2, y_2, *phi_2]) - motion.forces
    # (16): L = L_0 - beta_0-bar phi_0', here slope (no_load_speed - phi_0'), so L_0 = slope no_load_speed; (17), errata.
    slope, no_load = symbol("drive.slope"), symbol("drive.no_load_speed")
    printed = equations_18(slope + symbol("drum.bearing_damping"), slope * no_load)
    without_gravity = {symbol("carrier.gravity"): sp.S.Zero}  # (9): "horizontal arrangement, or gravity negligible"
    for row, expected in zip(derived, printed, strict=True):
        assert sp.expand(row.xreplace(without_gravity) - expected) == 0


def test_prescribed_speed_19_in_equations_18():
    """With phi_0 = Omega t (19) the System's accelerations solve (18), and the third equation gives the drive's torque."""
    driven = machine(1.2e-4, 0.8e-4, {"kind": "constant-speed", "speed": 80.0})
    system, drum = driven.system, driven.bodies[0].coordinate
    torque = symbol("torque")  # L_0 - beta_0-bar phi_0' of (16), whatever it takes
    unknown = [x_2, y_2, *phi_2, torque]
    solution = [*(acceleration(q) for q in driven.coordinates), reaction(drum)]
    solve = sp.lambdify(system.states, [system.explicit(s).xreplace(driven.numbers) for s in solution], cse=True)
    values = driven.numbers | {phi_1[0]: driven.values["drive.speed"]}
    printed = [e.xreplace(values) for e in equations_18(symbol("drum.bearing_damping"), torque)]
    residuals = sp.lambdify([*system.states, *unknown], printed)
    terms = [sp.Add(*(abs(term) for term in sp.Add.make_args(sp.expand(e)))) for e in printed]
    sizes = sp.lambdify([*system.states, *unknown], terms)

    reach = {"carrier.x": 1e-3, "carrier.y": 1e-3, "carrier.vx": 0.1, "carrier.vy": 0.1, "r1.speed": 100.0, "r2.speed": 100.0}
    random = np.random.default_rng(2001)
    for _ in range(10):
        state = [random.uniform(-1, 1) * reach.get(name, math.pi) for name in system.state_names]
        solved = solve(*state)
        assert solved[2] == 0  # phi_0'' = 0
        # Rounding alone, against the sum of the moduli of each equation's terms.
        assert (np.abs(residuals(*state, *solved)) < 1e-12 * np.array(sizes(*state, *solved))).all()


# ----------------------------------------------------------------------------------------------------------------------
# Tables 1 to 3
# ----------------------------------------------------------------------------------------------------------------------

# One speed in each of the four ranges: below omega_x, up to omega_0 = 98.884, up to omega_y, above. The paper's Bild 7 to 10
# use 40, 80 and 300 rad/s. Run times are ours: enough for the slowest departure from beside an unstable state.
RUN_TIME = {40.0: 200.0, 80.0: 120.0, 110.0: 40.0, 300.0: 40.0}  # rad/s: s
SPEEDS = tuple(RUN_TIME)
UNBALANCES = {1: (1.2e-4, 0.8e-4), 2: (0.2e-4, 0.4e-4), 3: (2e-4, 0.5e-4)}  # kg m

COMPENSATED_43, COMPENSATED_44 = (138.59, 262.82), (221.41, 97.18)  # degrees; cases.md, printed as 139/263 and 221/97
AMPLIFIED_45, OPPOSED_46 = (0.0, 0.0), (180.0, 180.0)
APART_47, APART_48 = (0.0, 180.0), (180.0, 0.0)

# Table: synchronous states, and which of them are stable at 80 and 300 rad/s. At 40 and 110 rad/s it is (45) in all three.
TABLES = {
    1: ((COMPENSATED_43, COMPENSATED_44, AMPLIFIED_45, OPPOSED_46, APART_48, APART_47), (COMPENSATED_43, COMPENSATED_44)),
    2: ((AMPLIFIED_45, OPPOSED_46, APART_48, APART_47), (OPPOSED_46,)),
    3: ((AMPLIFIED_45, OPPOSED_46, APART_48, APART_47), (APART_48,)),
}


def stable_states(table: int, speed: float) -> tuple[tuple[float, float], ...]:
    return TABLES[table][1] if speed in (80.0, 300.0) else (AMPLIFIED_45,)


def final_phases(table: int, speed: float, start: tuple[float, float], **options: float) -> tuple[np.ndarray, dict[str, Any]]:
    """Run from phases (degrees), disturbed by 3 and -4 degrees. Returns the phases in the end (degrees) and the summary."""
    options.setdefault("beta", 2e-5 if speed == 40.0 else 5e-5)
    driven = machine(*UNBALANCES[table], {"kind": "constant-speed", "speed": speed}, **options)
    begin = {"r1": math.radians(start[0] + 3), "r2": math.radians(start[1] - 4)}
    actual = run(RunUp.from_table({"until": RUN_TIME[speed], "start": begin}), driven).wucht.summary
    return np.degrees([actual["final_phases"]["r1"], actual["final_phases"]["r2"]]), actual


def apart(first: np.ndarray | tuple[float, float], second: np.ndarray | tuple[float, float]) -> float:
    """The largest difference of two pairs of angles in degrees, on the circle."""
    difference = np.asarray(first) - np.asarray(second)
    return float(np.abs((difference + 180) % 360 - 180).max())


def damped_phases(table: int, speed: float, near: tuple[float, float], damping: float = SUPPORT_DAMPING) -> np.ndarray:
    """The phases, in degrees, at which the mean torques on both rollers vanish on the damped support.

    (29)-(35) with the complex influence coefficients H = 1/(k - M Omega^2 + i c Omega) instead of (27):
    sum_k f_k [Re(H_x + H_y) sin(alpha_i - alpha_k) - Im(H_x + H_y) cos(alpha_i - alpha_k)] = 0, i = 1, 2.
    """
    h = sum(1 / (w**2 - speed**2 + 2j * damping * w * speed) for w in (OMEGA_X, OMEGA_Y)) / TOTAL_MASS
    forces = np.array([U_0, *UNBALANCES[table]])

    def torques(phases: np.ndarray) -> np.ndarray:
        alpha = np.array([0.0, *phases])
        lag = alpha[1:, None] - alpha[None, :]
        return (forces * (h.real * np.sin(lag) - h.imag * np.cos(lag))).sum(axis=1) / (abs(h) * U_0)

    return np.degrees(fsolve(torques, np.radians(near), xtol=1e-12))


# Quick are the largest shift, and each table and each speed once.
@pytest.mark.parametrize(
    ("table", "speed"),
    [
        pytest.param(t, w, marks=() if (t, w) == (2, 110.0) or (i + k) % 3 == 0 else pytest.mark.slow)
        for i, t in enumerate(TABLES)
        for k, w in enumerate(SPEEDS)
    ],
)
def test_tables_1_to_3_every_entry(table: int, speed: float):
    """Started beside each synchronous state: back to it if the table says stable, else away to one that is.

    Among these are the runs of Bild 7 to 10. Two tolerances, in degrees. To the paper: 8, because damping of the support
    shifts the states (45) to (48), as the paper says; at 110 rad/s, between the resonances, by up to 7.54. To the phases
    with that damping taken into account: 0.2, what averaging leaves out, the square of the rollers' ripple at twice the
    speed. Measured: at most 0.135 (Table 2, 110 rad/s, where J_ii is least), and 0.0099 there with rollers of four times that
    inertia; elsewhere at most 0.033.
    """
    stable = stable_states(table, speed)
    for state in TABLES[table][0]:
        reached, _ = final_phases(table, speed, state)
        distance = {target: apart(reached, target) for target in stable}
        nearest = min(distance, key=distance.__getitem__)
        assert distance[nearest] < 8
        assert apart(reached, damped_phases(table, speed, nearest)) < 0.2
        if state in stable:
            assert nearest == state


@pytest.mark.parametrize("speed", [80.0, 300.0])
def test_compensating_phases_of_table_1_do_not_depend_on_damping(speed: float):
    """(43), (44): with all centrifugal forces in balance nothing vibrates, so a damped support shifts nothing."""
    for damping in (0.01, 0.005):
        for state in (COMPENSATED_43, COMPENSATED_44):
            reached, actual = final_phases(1, speed, state, damping=damping)
            assert actual["outcome"] == "compensated"
            # The last digit of cases.md. What is left of the approach after the run time is less.
            assert apart(reached, state) < 0.01
            # (42): exactly.
            exact = np.degrees([math.acos((1 + 1.44 - 0.64) / 2.4), math.acos((1 - 1.44 + 0.64) / 1.6)])
            expected = (180 - exact[0], 180 + exact[1]) if state == COMPENSATED_43 else (180 + exact[0], 180 - exact[1])
            assert apart(reached, expected) < 1e-3
            assert actual["final_residual_unbalance"] < 1e-5


@pytest.mark.parametrize(
    "table, speed, state, shift",
    [
        (1, 40.0, AMPLIFIED_45, 1.70),
        (1, 110.0, AMPLIFIED_45, 12.9),
        (2, 300.0, OPPOSED_46, 0.085),
        (3, 300.0, APART_48, 0.107),
    ],
)
def test_shift_by_damping_vanishes_with_damping(table: int, speed: float, state: tuple[float, float], shift: float):
    """The tolerance of the tables, explained: with half the damping, the states (45) to (48) are shifted by half as much."""
    shifts = {}
    for damping in (0.005, 0.0025, 0.00125):
        reached, _ = final_phases(table, speed, state, damping=damping)
        shifts[damping] = apart(reached, state)
    assert shifts[0.005] == pytest.approx(shift, rel=0.02)  # degrees; given to three digits at most
    # Proportional as long as the shift is small: 13 degrees are not quite (second order: 0.7 % of it).
    assert shifts[0.0025] == pytest.approx(shifts[0.005] / 2, rel=0.02)
    assert shifts[0.00125] == pytest.approx(shifts[0.0025] / 2, rel=0.02)


# ----------------------------------------------------------------------------------------------------------------------
# Bild 7 to 10: from an unstable position to a stable one, as the files of the catalogue run them
# ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("figure", "phases", "tolerance"),
    [
        # At 40 rad/s the synchronising torques are weak and the support's damping shifts the phases by 0.84 degrees.
        (7, (0.0, 0.0), 1.0),
        (8, (138.59, 262.82), 5e-3),  # compensation does not depend on damping: cases.md, last digit
        (9, (221.41, 97.18), 5e-3),
        (10, (180.0, 0.0), 0.1),
    ],
)
def test_motion_to_the_stable_position_bild_7_to_10(figure: int, phases: tuple[float, float], tolerance: float) -> None:
    study = read_study(f"sperling-rollers/figure-{figure}")
    actual = run(study.spec, study.subject).wucht.summary
    for name, phase in zip(("r1", "r2"), phases, strict=True):
        assert math.remainder(math.degrees(actual["final_phases"][name]) - phase, 360.0) == pytest.approx(0.0, abs=tolerance)
    assert actual["energy_residual"] < 1e-9
