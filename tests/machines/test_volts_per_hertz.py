"""V/f control: the voltage that goes with a frequency, from 0 Hz on, in one schedule."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht.files.building import machine_from
from wucht.machines.volts_per_hertz import proportional_voltage
from wucht.piecewise import interpolated
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

PLATE = {
    "power": "4 kW", "speed": "1435 rpm", "voltage": "400 V", "frequency": "50 Hz", "efficiency": 0.866, "power_factor": 0.81,
    "breakdown_torque_ratio": 3.0,
}  # fmt: skip
RAMP = {"parameter": "drive.frequency", "points": [["0 s", "0 Hz"], ["2 s", "50 Hz"]], "voltage": "proportional"}
PHASE = 400 / math.sqrt(3)


def machine_with(*schedules, drive=None, **parts):
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.1}
    machine = {
        "carrier": {"mass": 1.0, "stiffness": 4e4, "damping": 100.0}, "bodies": [rotor],
        "drive": drive or {"kind": "induction", "nameplate": PLATE}, "schedules": list(schedules),
    }  # fmt: skip
    return machine_from(machine | parts)


@pytest.mark.parametrize("kind", ["linear", "smooth", "steps"])
@pytest.mark.parametrize("boost", [0.0, 12.0])
def test_the_voltage_is_proportional_up_to_the_rated_frequency(kind, boost):
    """And the rated one above it: over points that rise beyond, fall and end below it, with a corner in between."""
    times, values = [0.0, 1.0, 3.0, 4.0, 6.0], [0.0, 20.0, 80.0, 80.0, 10.0]
    frequency = interpolated("f", times, values, kind)
    voltage = proportional_voltage("U", frequency, (50.0, 230.0), boost)
    t = np.linspace(-1.0, 7.0, 1601)
    exact = np.where(frequency(t) < 50, boost + (230 - boost) * frequency(t) / 50, 230.0)
    assert voltage(t) == pytest.approx(exact, abs=1e-9)
    corners = sorted(set(voltage.breakpoints) - set(times))
    assert len(corners) == (0 if kind == "steps" else 2)
    assert frequency(np.array(corners)) == pytest.approx([50.0] * len(corners))


def test_one_schedule_moves_both():
    machine = machine_with(RAMP | {"boost": "10 V"})
    assert [s.parameter for s in machine.schedules] == ["drive.frequency", "drive.voltage"]
    assert [(machine.at(t).values["drive.frequency"], machine.at(t).values["drive.voltage"]) for t in (0.0, 1.0, 2.0, 9.0)] == [
        (0.0, pytest.approx(10.0)),
        (25.0, pytest.approx((10 + PHASE) / 2)),
        (50.0, pytest.approx(PHASE)),
        (50.0, pytest.approx(PHASE)),
    ]


@pytest.mark.parametrize("boost", ["0 V", pytest.param("12 V", marks=pytest.mark.slow)])
def test_a_motor_follows_its_inverter_from_standstill(boost):
    """A light rotor runs with the field but for a small slip, through its resonance, and the works balance."""
    result = run(RunUp(until="2.5 s"), machine_with(RAMP | {"boost": boost}))
    s = result.wucht.summary
    field = 50 * math.pi * np.clip(result.time.values / 2, 0, 1)
    late = result.time.values > 0.5
    assert np.abs(result.speed.values[0] - field)[late].max() < 6.0
    assert s["final_speed"] == pytest.approx(50 * math.pi, rel=1e-3)
    assert s["energy_residual"] < 1e-10


@pytest.mark.parametrize(
    ("changes", "drive", "refusal"),
    [
        ({"boost": "400 V"}, None, refused("machine.schedules[0].boost", "230.94 V", given="400 V")),
        ({"boost": "-1 V"}, None, refused("machine.schedules[0].boost", "230.94 V", given="-1 V")),
        ({"boost": "1 A"}, None, refused("machine.schedules[0].boost", given="1 A")),
        ({"voltage": "V/f"}, None, refused("machine.schedules[0].voltage", given="V/f")),
        ({"voltage": None, "boost": "3 V"}, None, refused("machine.schedules[0].boost", given="3 V")),
        ({}, {"kind": "synchronous", "frequency": 50, "pole_pairs": 2},
         refused("machine.schedules[0].voltage", given="proportional")),
        ({"parameter": "drive.rotor_resistance", "points": [[0, 1], [1, 2]]}, None,
         refused("machine.schedules[0].voltage", given="proportional")),
        ({}, {"kind": "induction", "nameplate": {k: v for k, v in PLATE.items() if k != "power_factor"}},
         refused("machine.schedules[0].points (t = 0)", "drive.frequency", "0 Hz", given=0.0)),
    ],
)  # fmt: skip
def test_bad_ramps_are_refused(changes, drive, refusal):
    ramp = {k: v for k, v in (RAMP | changes).items() if v is not None}
    with refusal:
        machine_with(ramp, drive=drive)


def test_the_voltage_has_one_schedule():
    own = {"parameter": "drive.voltage", "points": [[0, 1], [1, 2]]}
    with refused("machine.schedules[1].parameter", given="drive.voltage"):
        machine_with(RAMP, own)
    with refused("machine.schedules[1].parameter", given="drive.voltage"):
        machine_with(own, RAMP)
