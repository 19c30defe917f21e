"""The load of a motor in operation and over a start, against its nameplate and a start integrated by SciPy.

The heat of a start is the integral of the square of the current; relays of class N wait at 7.2 times their current at least
0.5, 4, 6, 9 s for N = 5, 10, 20, 30 (IEC 60947-4-1:2009, table 3).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wucht import RunUp, TorqueBalance, run
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.machines.parts.induction import Induction
from wucht.machines.schedules import schedules_of

PLATE = {
    "power": 3000.0, "speed": 1450 * math.pi / 30, "voltage": 400.0, "frequency": 50.0, "breakdown_torque_ratio": 2.8,
    "efficiency": 0.85, "power_factor": 0.82,
}  # fmt: skip
RATED = PLATE["power"] / PLATE["speed"]


def fan(inertia: float, load: float, **of_drive: Any) -> Machine:
    """A rotor without unbalance whose load grows with the square of the speed. load: at the rated speed."""
    rotor = {"kind": "rotor", "name": "fan", "mass": 10.0, "eccentricity": 0.0, "inertia": inertia}
    return machine_from(
        {
            "carrier": {"directions": "fixed"},
            "bodies": [rotor],
            "drives": [{"kind": "induction", "nameplate": PLATE} | of_drive],
            "loads": [{"kind": "quadratic", "coefficient": load / PLATE["speed"] ** 2}],
        }
    )


def start_of(machine: Machine, inertia: float, load: float, end: float) -> tuple[float, float]:
    """Root mean square of the torque, and the heat of the start in rated currents squared."""
    motor = next(d for d in machine.drives if isinstance(d, Induction))
    circuit = motor.circuit_at(PLATE["voltage"] / math.sqrt(3), 50.0)
    rated = PLATE["power"] / (0.85 * 0.82 * math.sqrt(3) * 400.0)  # A

    def rates(_: float, w: np.ndarray) -> list[float]:
        slip = 1 - w[0] / circuit.synchronous
        torque = circuit.torque(slip)
        brake = load / PLATE["speed"] ** 2 * w[0] ** 2
        return [(torque - brake) / inertia, torque**2, (circuit.current(slip) / rated) ** 2]

    end_state = solve_ivp(rates, (0.0, end), [0.0, 0.0, 0.0], rtol=1e-9, atol=1e-9, method="LSODA").y[:, -1]
    return math.sqrt(end_state[1] / end), float(end_state[2])


def test_load_in_operation_and_over_the_start() -> None:
    """At the rated load the motor turns with its rated speed, and gives its rated torque and power."""
    inertia = 0.5
    machine = fan(inertia, RATED)
    summary = run(RunUp(until=6.0), machine).wucht.summary
    assert summary["final_speed"] == pytest.approx(PLATE["speed"], rel=1e-6)
    assert summary["motor_load"]["fan"] == pytest.approx(1.0, rel=1e-5)
    assert summary["motor_power_share"]["fan"] == pytest.approx(1.0, rel=1e-5)
    torque, heat = start_of(machine, inertia, RATED, summary["settling_time"])
    assert summary["starting_rms_torque"]["fan"] == pytest.approx(torque, rel=2e-3)
    assert summary["starting_rms_share"]["fan"] == pytest.approx(torque / RATED, rel=2e-3)
    assert summary["starting_heat"]["fan"] == pytest.approx(heat, rel=2e-3)
    balance = run(TorqueBalance(), machine).wucht.summary
    assert balance["motor_load"]["fan"] == pytest.approx(1.0, rel=1e-5)


def test_behind_a_belt_the_motor_has_its_own_torque() -> None:
    """The fan turns at half the speed, and takes twice the torque."""
    belt = fan(0.5, 2 * RATED * 4, transmission={"ratio": 2.0})
    summary = run(RunUp(until=8.0), belt).wucht.summary
    assert summary["final_speed"] == pytest.approx(PLATE["speed"] / 2, rel=1e-6)
    assert summary["motor_load"]["fan"] == pytest.approx(1.0, rel=1e-5)
    assert summary["motor_power_share"]["fan"] == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize(
    ("least", "below", "above"), [(0.5, "5", "10"), (4.0, "10", "20"), (6.0, "20", "30"), (9.0, "30", None)]
)
def test_trip_classes_on_both_sides_of_their_heat(least: float, below: str, above: str | None) -> None:
    """The heat of a start without load grows with the inertia."""
    limit, known = 7.2**2 * least, 1.0
    heat = run(RunUp(until=12.0 * known), fan(known, 0.0)).wucht.summary["starting_heat"]["fan"]
    for share, name in ((0.95, below), (1.05, above)):
        inertia = known * share * limit / heat
        summary = run(RunUp(until=12.0 * inertia), fan(inertia, 0.0)).wucht.summary
        assert (summary["starting_heat"]["fan"] < limit) is (share < 1)
        assert summary["trip_class"]["fan"] == name


def test_motors_without_a_nameplate_state_nothing() -> None:
    rotor = {"kind": "rotor", "name": "fan", "mass": 10.0, "eccentricity": 0.0, "inertia": 0.1}
    drive = {"kind": "linear", "slope": 0.5, "no_load_speed": 100.0}
    summary = run(
        RunUp(), machine_from({"carrier": {"directions": "fixed"}, "bodies": [rotor], "drives": [drive]})
    ).wucht.summary
    assert not [key for key in summary if key.startswith(("motor", "starting", "trip"))]


def test_a_schedule_of_the_supply_leaves_the_current_out() -> None:
    ramp = {"parameter": "drive.voltage", "points": [[0, 100], [2, 230]]}
    machine = fan(0.5, RATED)
    scheduled = machine.with_fields(schedules=schedules_of([ramp], machine.parameters, machine.parts, "s"))
    summary = run(RunUp(until=6.0), scheduled).wucht.summary
    assert summary["motor_load"]["fan"] == pytest.approx(1.0, rel=0.01)
    assert "starting_heat" not in summary


def test_a_motor_that_does_not_start_has_no_start() -> None:
    """It stands under its starting torque: a class of relay that lets that pass would be no advice."""
    held = machine_from(
        {
            "carrier": {"directions": "fixed"},
            "bodies": [{"kind": "rotor", "name": "fan", "mass": 10.0, "eccentricity": 0.0, "inertia": 0.5}],
            "drives": [{"kind": "induction", "nameplate": PLATE}],
            "loads": [{"kind": "coulomb", "torque": 10 * RATED}],
        }
    )
    summary = run(RunUp(until=5.0), held).wucht.summary
    assert summary["outcome"] == "not-started"
    assert summary["motor_load"]["fan"] > 1
    assert not [key for key in summary if key.startswith(("starting_rms", "starting_heat", "trip"))]
