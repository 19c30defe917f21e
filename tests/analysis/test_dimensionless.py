"""The dimensionless numbers of 002 (4.8) and (3.30): for R1 and R2 those that the errata promise."""

import math

import pytest

from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

R1 = {
    "epsilon": 0.01, "s": 0.75, "w": 1.3, "p": 0.8, "mu": 0.01, "beta_p": 1.0, "beta_r": 3.46667, "lambda": 2.0, "sigma": 0.1,
    "u": 20.0,
}  # fmt: skip


def test_r1_has_the_numbers_of_the_errata():
    """Table 5.1 but for beta_r, which the reciprocity of the dampers asks for."""
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1")) == pytest.approx(R1, rel=1e-6)


def test_r2_has_the_beta_r_of_table_5_1_and_another_epsilon():
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r2")) == pytest.approx(
        R1 | {"epsilon": 2.88462e-4, "beta_r": 0.1}, rel=2e-6
    )


# --- by hand, from 002 (4.8) and (3.30) ---

ROTOR = {"kind": "rotor", "name": "d", "mass": 4.0, "eccentricity": 0.02, "inertia": 0.05}
BALL = {"kind": "pendulum", "about": "d", "mass": 0.25, "length": 0.1, "inertia": 0.004, "damping": 0.003}
LINEAR = {"kind": "linear", "slope": 0.03, "no_load_speed": 120.0}


def numbers_of(*more, drive=LINEAR, rotor=None, **carrier):
    held = {"mass": 6.0, "stiffness": 2e3, "damping": 8.0} | carrier
    described = {"carrier": held, "bodies": [ROTOR | (rotor or {}), *more]}
    return dimensionless_numbers(machine_from(described | ({"drive": drive} if drive else {})))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("directions", ["x", "y", "xy"])
def test_a_rotor_alone(directions, sense):
    """M = 10 kg, k = sqrt(c/M); lambda carries the sense of the motor, u does not."""
    k = math.sqrt(2e3 / 10)
    numbers = numbers_of(drive=LINEAR | {"no_load_speed": sense * 120.0}, directions=directions)
    exact = {"epsilon": 4 * 0.02**2 / 0.05, "sigma": 8 / (2 * 10 * k), "lambda": sense * 120 / k, "u": 0.03 / (k * 4 * 0.02**2)}
    assert numbers == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_equal_balls_whatever_their_number(count):
    mass = 10 + count * 0.25
    k = math.sqrt(2e3 / mass)
    numbers = numbers_of(*(BALL | {"name": f"b{i}"} for i in range(count)), drive=None)
    p = 0.25 * 0.1**2 / 0.004
    exact = {
        "epsilon": 4 * 0.02**2 / 0.05, "sigma": 8 / (2 * mass * k), "s": 4 * 0.02 / (0.25 * 0.1),
        "w": 0.25 * 0.1 / (mass * 0.02), "p": p, "mu": p * 0.25 / mass, "beta_p": 0.003 / (k * 0.004),
        "beta_r": count * 0.003 / (k * 0.05),
    }  # fmt: skip
    assert numbers == pytest.approx(exact, rel=1e-12)


def test_the_inertia_of_a_geared_motor_counts_with_the_square_of_its_ratio():
    geared = LINEAR | {"transmission": {"ratio": 3.0, "inertia": 0.002}}
    numbers, k = numbers_of(drive=geared), math.sqrt(2e3 / 10)
    assert numbers["epsilon"] == pytest.approx(4 * 0.02**2 / (0.05 + 9 * 0.002))
    assert numbers["lambda"] == pytest.approx(120 / 3 / k)
    assert numbers["u"] == pytest.approx(9 * 0.03 / (k * 4 * 0.02**2))


@pytest.mark.parametrize(
    ("drive", "carrier", "more"),
    [
        (LINEAR, {"directions": "fixed", "mass": None, "stiffness": None, "damping": None}, ()),
        (LINEAR, {"directions": "xyr", "inertia": 1.0, "rotation_stiffness": 50.0}, ()),
        (LINEAR, {"stiffness": [2e3, 2.1e3]}, ()),
        (LINEAR, {"stiffness": 0.0}, ()),
        (LINEAR, {}, (ROTOR | {"name": "e"},)),
        (LINEAR, {}, ({"kind": "slider", "name": "s", "about": "d", "mass": 0.1, "radius": 0.1, "stiffness": 1e3},)),
        (LINEAR, {"motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}, ()),
    ],
    ids=["fixed", "rocking", "unlike", "free", "two rotors", "slider", "shaken"],
)
def test_machines_that_have_none(drive, carrier, more):
    held = {
        key: value for key, value in ({"mass": 6.0, "stiffness": 2e3, "damping": 8.0} | carrier).items() if value is not None
    }
    drive = drive | {"on": "d"}
    made = machine_from({"carrier": held, "bodies": [ROTOR, *more], "drives": [drive]})
    assert dimensionless_numbers(made) == {}
