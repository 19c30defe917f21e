"""Every output of a machine and both powers of its energy balance at one moment, from the formulas of mechanics alone.

Two rotors on a carrier that is unlike in x and y, with gravity: one behind a gear with losses and with a ball about it, the
other at a prescribed speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.machines.machine import Machine

GRAVITY, MASS, STIFFNESS, DAMPING = 9.81, 6.0, (2e3, 5e3), (7.0, 11.0)
M1, U1, J1, B1 = 3.0, 0.06, 0.08, 0.013  # of the driven rotor
M2, U2, J2, B2 = 2.0, 0.05, 0.04, 0.017  # of the one whose speed is prescribed
MB, LB, DB = 0.5, 0.12, 0.021  # of the ball about the first
SLOPE, FREE, RATIO, MOTOR, ETA = 0.02, 300.0, 3.0, 0.0015, 0.8
SPEED, LOAD, FAN = -9.0, 0.004, 0.0007
STATES = {
    "carrier.x": 0.003, "carrier.y": -0.011, "carrier.vx": 0.4, "carrier.vy": -0.3, "e1.angle": 0.7, "e2.angle": -1.9,
    "p.angle": 2.4,
}  # fmt: skip


def machine(sense: float) -> Machine:
    gear = {"ratio": RATIO, "inertia": MOTOR, "efficiency": ETA}
    return machine_from(
        {
            "carrier": {"mass": MASS, "stiffness": list(STIFFNESS), "damping": list(DAMPING), "gravity": GRAVITY},
            "bodies": [
                {"kind": "rotor", "name": "e1", "mass": M1, "unbalance": U1, "inertia": J1, "bearing_damping": B1},
                {"kind": "rotor", "name": "e2", "mass": M2, "unbalance": U2, "inertia": J2, "bearing_damping": B2},
                {"kind": "pendulum", "name": "p", "about": "e1", "mass": MB, "length": LB, "damping": DB},
            ],
            "drives": [
                {"kind": "linear", "on": "e1", "slope": SLOPE, "no_load_speed": sense * FREE, "transmission": gear},
                {"kind": "constant-speed", "on": "e2", "speed": SPEED},
            ],
            "loads": [
                {"kind": "viscous", "on": "e2", "coefficient": LOAD},
                {"kind": "quadratic", "on": "e1", "coefficient": FAN},
            ],
        }
    )


def evaluated(made: Machine, states: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """The definitions of the equations, their outputs, and the rates of their quadratures, one after the other."""
    values: dict[sp.Symbol, Any] = {sp.Symbol(n, real=True): sp.Float(v) for n, v in {**made.values, **states}.items()}
    system = made.system

    def number(expression: sp.Expr) -> sp.Float:
        return sp.Float(sp.sympify(expression).xreplace(values))

    for symbol, expression in system.definitions:
        values[symbol] = number(expression)
    definitions = {symbol.name: float(values[symbol]) for symbol, _ in system.definitions}
    outputs = {o.name: float(number(o.expression)) for o in system.outputs}
    return definitions, outputs, {q.name: float(number(q.expression)) for q in system.quadratures}


@pytest.fixture(scope="module", params=[(1.0, 20.0), (1.0, 130.0), (-1.0, -20.0), (-1.0, -130.0), (1.0, -20.0)], ids=str)
def moment(request: pytest.FixtureRequest) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """Of the motor's sense and the rotor's speed: below and above the no-load speed of 100 rad/s, and braked by reversal."""
    sense, speed = request.param
    states = STATES | {"e1.speed": speed, "p.speed": speed - 1.5}
    definitions, outputs, powers = evaluated(machine(sense), states)
    return {**states, **definitions, "sense": sense}, outputs, powers


def motor_torque(at: Mapping[str, float]) -> float:
    """On the side of the body."""
    return RATIO * SLOPE * (at["sense"] * FREE - RATIO * at["e1.speed"])


def gear_loss(at: Mapping[str, float]) -> float:
    """A motor that drives brings eta T, one that is driven takes T/eta."""
    torque, speed = motor_torque(at), at["e1.speed"]
    share = 1 - ETA if torque * speed > 0 else 1 / ETA - 1
    return math.copysign(share * abs(torque), speed)


def reaction(at: Mapping[str, float]) -> float:
    """The torque that keeps the second rotor at its speed: against bearing, load, weight and the carrier's acceleration."""
    angle = at["e2.angle"]
    ax, ay = at["carrier.x.acceleration"], at["carrier.y.acceleration"]
    moving = U2 * (-ax * math.sin(angle) + (ay + GRAVITY) * math.cos(angle))
    return moving + (B2 + LOAD) * SPEED


Moment = tuple[dict[str, float], dict[str, float], dict[str, float]]


def test_torques_and_power_of_the_motors(moment: Moment) -> None:
    at, outputs, powers = moment
    motor = motor_torque(at) + reaction(at)
    assert outputs["motor_torque"] == pytest.approx(motor, rel=1e-9)
    assert outputs["drive_torque"] == pytest.approx(motor - gear_loss(at), rel=1e-9)
    power = motor_torque(at) * at["e1.speed"] + reaction(at) * SPEED
    assert outputs["motor_power"] == pytest.approx(power, rel=1e-9)
    assert powers["supplied_work"] == pytest.approx(power, rel=1e-9)
    assert outputs["motor_power[e1]"] == pytest.approx(motor_torque(at) * at["e1.speed"], rel=1e-9)
    assert outputs["motor_power[e2]"] == pytest.approx(reaction(at) * SPEED, rel=1e-9)
    assert outputs["e2.speed"] == SPEED


def test_the_power_that_is_lost(moment: Moment) -> None:
    at, _, powers = moment
    w = at["e1.speed"]
    carrier = DAMPING[0] * at["carrier.vx"] ** 2 + DAMPING[1] * at["carrier.vy"] ** 2
    bearings = B1 * w**2 + (B2 + LOAD) * SPEED**2 + DB * (at["p.speed"] - w) ** 2
    assert powers["dissipated_work"] == pytest.approx(carrier + bearings + FAN * abs(w) ** 3 + gear_loss(at) * w, rel=1e-9)
    assert gear_loss(at) * w > 0


def velocity(at: Mapping[str, float], arm: float, body: str, speed: float) -> tuple[float, float]:
    angle = at[f"{body}.angle"]
    return (at["carrier.vx"] - arm * speed * math.sin(angle), at["carrier.vy"] + arm * speed * math.cos(angle))


def test_the_energy_that_is_stored(moment: Moment) -> None:
    """Of centres of mass and turning about these; a motor behind a gear counts with the square of its ratio."""
    at, outputs, _ = moment
    energy = MASS * (at["carrier.vx"] ** 2 + at["carrier.vy"] ** 2) / 2 + MASS * GRAVITY * at["carrier.y"]
    energy += STIFFNESS[0] * at["carrier.x"] ** 2 / 2 + STIFFNESS[1] * at["carrier.y"] ** 2 / 2
    energy += MOTOR * (RATIO * at["e1.speed"]) ** 2 / 2
    bodies = (("e1", M1, U1 / M1, J1, at["e1.speed"]), ("e2", M2, U2 / M2, J2, SPEED), ("p", MB, LB, MB * LB**2, at["p.speed"]))
    for name, mass, arm, inertia, speed in bodies:
        vx, vy = velocity(at, arm, name, speed)
        height = at["carrier.y"] + arm * math.sin(at[f"{name}.angle"])
        energy += mass * (vx**2 + vy**2) / 2 + (inertia - mass * arm**2) * speed**2 / 2 + mass * GRAVITY * height
    assert outputs["stored_energy"] == pytest.approx(energy, rel=1e-9)


def push(at: Mapping[str, float], mass: float, arm: float, body: str, speed: float, turned: float) -> tuple[float, float]:
    """The force with which a body loads what bears it: against the acceleration of its centre of mass, and along its weight."""
    angle = at[f"{body}.angle"]
    ax = at["carrier.x.acceleration"] - arm * (turned * math.sin(angle) + speed**2 * math.cos(angle))
    ay = at["carrier.y.acceleration"] + arm * (turned * math.cos(angle) - speed**2 * math.sin(angle))
    return -mass * ax, -mass * (ay + GRAVITY)


def test_forces_on_the_carrier(moment: Moment) -> None:
    at, outputs, _ = moment
    first = push(at, M1, U1 / M1, "e1", at["e1.speed"], at["e1.angle.acceleration"])
    ball = push(at, MB, LB, "p", at["p.speed"], at["p.angle.acceleration"])
    second = push(at, M2, U2 / M2, "e2", SPEED, 0.0)
    for k, d in enumerate("xy"):
        assert outputs[f"bearing_force[e1]_{d}"] == pytest.approx(first[k] + ball[k], rel=1e-9)
        assert outputs[f"bearing_force[e2]_{d}"] == pytest.approx(second[k], rel=1e-9)
        assert outputs[f"bearing_force_{d}"] == pytest.approx(first[k] + ball[k] + second[k], rel=1e-9)
        weight = MASS * GRAVITY if d == "y" else 0.0
        springs = STIFFNESS[k] * at[f"carrier.{d}"] + DAMPING[k] * at[f"carrier.v{d}"]
        acceleration = (outputs[f"bearing_force_{d}"] - springs - weight) / MASS
        assert at[f"carrier.{d}.acceleration"] == pytest.approx(acceleration, rel=1e-9)


def test_the_orbit_is_the_axis_of_the_first_rotor(moment: Moment) -> None:
    at, outputs, _ = moment
    assert [outputs[f"orbit.{d}"] for d in ("x", "y", "vx", "vy")] == [at[f"carrier.{d}"] for d in ("x", "y", "vx", "vy")]


def test_bodies_turn_by_their_torques(moment: Moment) -> None:
    """Of the rotor and its ball; the motor's inertia turns along."""
    at, _, _ = moment
    ax, ay, w = at["carrier.x.acceleration"], at["carrier.y.acceleration"] + GRAVITY, at["e1.speed"]
    slip = DB * (at["p.speed"] - w)

    def lever(moment_of: float, body: str) -> float:
        angle = at[f"{body}.angle"]
        return moment_of * (ax * math.sin(angle) - ay * math.cos(angle))

    ball = lever(MB * LB, "p") - slip
    assert at["p.angle.acceleration"] == pytest.approx(ball / (MB * LB**2), rel=1e-9)
    rotor = lever(U1, "e1") + slip + motor_torque(at) - gear_loss(at) - B1 * w - FAN * w * abs(w)
    assert at["e1.angle.acceleration"] == pytest.approx(rotor / (J1 + RATIO**2 * MOTOR), rel=1e-9)
