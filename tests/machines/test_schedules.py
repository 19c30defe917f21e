"""Parameters over time: against closed solutions and energy balances, with exact corners."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.schedules import SCHEDULE_WORK, proportional_voltage
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import interpolated_pieces

PLATE = {
    "power": "4 kW", "speed": "1435 rpm", "voltage": "400 V", "frequency": "50 Hz", "efficiency": 0.866, "power_factor": 0.81,
    "breakdown_torque_ratio": 3.0,
}  # fmt: skip
RAMP = {"parameter": "drive.frequency", "points": [["0 s", "0 Hz"], ["2 s", "50 Hz"]], "voltage": "proportional"}


def inverter_machine(*schedules, drive=None, **parts):
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
    frequency = interpolated_pieces("f", times, values, kind)
    voltage = proportional_voltage("U", frequency, (50.0, 230.0), boost)
    t = np.linspace(-1.0, 7.0, 1601)
    exact = np.where(frequency(t) < 50, boost + (230 - boost) * frequency(t) / 50, 230.0)
    assert voltage(t) == pytest.approx(exact, abs=1e-9)
    corners = sorted(set(voltage.breakpoints) - set(times))
    assert len(corners) == (0 if kind == "steps" else 2)
    assert frequency(np.array(corners)) == pytest.approx([50.0] * len(corners))


@pytest.mark.parametrize("boost", ["0 V"])
def test_a_motor_follows_its_inverter_from_standstill(boost):
    """A light rotor runs with the field but for a small slip, through its resonance, and the works balance."""
    result = run(RunUp(until="2.5 s"), inverter_machine(RAMP | {"boost": boost}))
    s = result.wucht.summary
    field = 50 * math.pi * np.clip(result.time.values / 2, 0, 1)
    late = result.time.values > 0.5
    assert np.abs(result.speed.values[0] - field)[late].max() < 6.0
    assert s["final_speed"] == pytest.approx(50 * math.pi, rel=1e-3)
    assert s["energy_residual"] < 1e-10


@pytest.mark.parametrize(
    ("changes", "drive", "refusal"),
    [
        ({"boost": "400 V"}, None, refused("machine.schedules[0].boost", "230.94 V", given="400 V", code="limits")),
        ({"boost": "-1 V"}, None, refused("machine.schedules[0].boost", "230.94 V", given="-1 V", code="limits")),
        ({"voltage": None, "boost": "3 V"}, None, refused("machine.schedules[0].boost", given="3 V", code="not-allowed")),
        (
            {},
            {"kind": "synchronous", "frequency": 50, "pole_pairs": 2},
            refused("machine.schedules[0].voltage", given="proportional"),
        ),
        (
            {},
            {"kind": "induction", "nameplate": {k: v for k, v in PLATE.items() if k != "power_factor"}},
            refused("machine.schedules[0].points (t = 0)", "drive.frequency", "0 Hz", given=0.0),
        ),
    ],
)
def test_bad_ramps_are_refused(changes, drive, refusal):
    ramp = {k: v for k, v in (RAMP | changes).items() if v is not None}
    with refusal:
        inverter_machine(ramp, drive=drive)


DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
BALANCED = DRUM | {"eccentricity": 0.0}
CARRIER = {"mass": 1.0, "stiffness": 1.2e4, "damping": 20.0}
DC = {"kind": "dc-separate", "voltage": 0.0, "armature_resistance": 2.0, "motor_constant": 1.0, "flux": 0.5}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 90.0}


def schedule(parameter, *points, **more):
    return {"parameter": parameter, "points": [list(p) for p in points]} | more


def machine_with(*schedules, **parts):
    return machine_from({"carrier": CARRIER, "bodies": [DRUM], "drive": LINEAR} | parts | {"schedules": list(schedules)})


def moved(machine, end, samples=201, start=None):
    flow = compile_system(machine.system)
    time = np.linspace(0, end, samples)
    run = integrate(flow, initial_state(machine, start or {}), machine.values, time)
    assert run.failure is None
    rows = dict(zip(machine.system.state_names, run.states, strict=True)) | dict(run.quadratures) | {"time": time}
    return rows | flow.outputs(run.time, run.states, run.final_parameter_values)


def energy_gap(rows):
    """Work of motors and schedules less what is lost and stored. (N,), relative to the largest of them"""
    gap = (
        rows["supplied_work"] + rows[SCHEDULE_WORK] - rows["dissipated_work"] - rows["stored_energy"] + rows["stored_energy"][0]
    )
    return np.abs(gap) / max(np.abs(rows["supplied_work"]).max(), np.abs(rows["stored_energy"]).max())


def voltage_ramp(time, inertia=0.03, R=2.0, k=0.5, rate=20.0, end=1.5, before=0.2):
    """J w' = k (U - k w)/R with U = rate (t - before) until t = end, then constant."""
    tau = inertia * R / k**2
    s = np.clip(time - before, 0, None)
    until = np.minimum(s, end - before)
    w = rate / k * (until - tau * (1 - np.exp(-until / tau)))
    final = rate / k * (end - before)
    return np.where(time <= end, w, final - (final - w) * np.exp(-(time - end) / tau))


def test_a_voltage_ramp():
    """A balanced rotor on a separately excited motor: the closed solution of a linear equation, exact at both corners."""
    machine = machine_with(schedule("drive.voltage", ["0.2 s", "0 V"], [1.5, 26.0]), bodies=[BALANCED], drive=DC)
    rows = moved(machine, 4.0)
    assert rows["drum.speed"] == pytest.approx(voltage_ramp(rows["time"]), abs=1e-9)
    assert rows[SCHEDULE_WORK] == pytest.approx(0.0, abs=1e-12)  # a voltage stores nothing


def test_the_work_of_a_step_by_hand():
    """No rotation, no damping: x = x_0 cos(w t), the stiffness is doubled at the time t_1: work c x_1^2/2; then w sqrt(2)."""
    carrier = {"directions": "x", "mass": 1.0, "stiffness": 300.0}
    steps = schedule("carrier.stiffness", [0.0, 300.0], [0.4, 600.0], interpolation="steps")
    idle = DRUM | {"eccentricity": 0.0}
    machine = machine_from({"carrier": carrier, "bodies": [idle], "schedules": [steps]})
    rows = moved(machine, 1.0, 11, {"carrier": {"x": 0.01}})
    w = math.sqrt(300 / 3)
    x1, v1 = 0.01 * math.cos(0.4 * w), -0.01 * w * math.sin(0.4 * w)
    late = rows["time"] > 0.41
    s, w2 = rows["time"][late] - 0.4, w * math.sqrt(2)
    assert rows["carrier.x"][late] == pytest.approx(x1 * np.cos(w2 * s) + v1 / w2 * np.sin(w2 * s), abs=1e-13)
    assert rows[SCHEDULE_WORK][late] == pytest.approx(300 * x1**2 / 2, abs=1e-13)


@pytest.mark.parametrize("kind", ["linear", "steps", "smooth"])
def test_an_unbalance_that_appears(kind):
    """A drum balanced until 0.4 s stands still on its springs until then; the energy balance closes, steps included."""
    appears = schedule("drum.eccentricity", [0.4, 0.0], [0.6, 0.01], interpolation=kind)
    machine = machine_with(appears)
    rows = moved(machine, 1.2, 601)
    before = rows["time"] <= (0.6 if kind == "steps" else 0.4)
    assert np.abs(rows["carrier.x"][before]).max() == 0.0
    assert np.abs(rows["carrier.x"]).max() > 1e-3
    assert energy_gap(rows).max() < 1e-9


def test_a_prescribed_speed_that_rises():
    """Omega from 0 to 40 rad/s within 2 s: the angle is a parabola, the torque J alpha plus that of gravity."""
    ramp = schedule("drive.speed", [0.0, 0.0], [2.0, 40.0])
    drive = {"kind": "constant-speed", "speed": 0.0, "angle": 0.2}
    rows = moved(machine_with(ramp, drive=drive, carrier={"directions": "fixed", "gravity": 9.81}), 3.0, 61)
    t = rows["time"]
    angle = 0.2 + np.where(t < 2, 10 * t**2, 40 * t - 40)
    assert rows["drum.angle"] == pytest.approx(angle, abs=1e-11)
    away = t != 2.0
    torque = np.where(t < 2, 20 * 0.03, 0.0) + 0.02 * 9.81 * np.cos(angle)
    assert rows["motor_torque"][away] == pytest.approx(torque[away], abs=1e-9)
    assert energy_gap(rows).max() < 1e-10


@pytest.mark.parametrize("key", ["amplitude", "frequency"])
def test_a_prescribed_motion_has_no_schedule(key):
    """Its phase would be frequency(t) t instead of the integral, its velocity not the derivative of amplitude(t) cos."""
    carrier = {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 30.0}}
    with refused("machine.schedules[0].parameter", "table of displacements", code="prescribed"):
        machine_with(schedule(f"carrier.motion.{key}", [0.0, 1e-3], [1.0, 2e-3], interpolation="smooth"), carrier=carrier)


@pytest.mark.parametrize(
    ("parameter", "parts"),
    [
        ("drive.speed", {"drive": {"kind": "constant-speed", "speed": 3.0}}),
        ("drive.frequency", {"drive": {"kind": "synchronous", "frequency": 50.0, "pole_pairs": 2}}),
    ],
)  # fmt: skip
def test_what_is_prescribed_cannot_jump(parameter, parts):
    with refused("machine.schedules[0].interpolation", parameter, given="steps"):
        machine_with(schedule(parameter, [0.0, 1.0], [1.0, 2.0], interpolation="steps"), **parts)
    machine_with(schedule(parameter, [0.0, 1.0], [1.0, 1.0], interpolation="steps"), **parts)  # this one does not


INDUCTION = {
    "kind": "induction", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 0.5,
    "rotor_resistance": 0.5, "stator_reactance": 1.0, "rotor_reactance": 1.0,
}  # fmt: skip


@pytest.mark.parametrize("first", ["voltage", "frequency"])
def test_a_value_that_is_not_allowed_is_the_fault_of_its_own_schedule(first):
    """Both have a point at t = 0, where only a voltage may be 0."""
    ramps = {
        "voltage": schedule("drive.voltage", ["0 s", "0 V"], ["5 s", "230 V"]),
        "frequency": schedule("drive.frequency", ["0 s", "0 Hz"], ["5 s", "50 Hz"]),
    }
    order = sorted(ramps, key=lambda name: name != first)
    place = f"machine.schedules[{order.index('frequency')}].points (t = 0)"
    with refused(place, "drive.frequency", "0 Hz", "magnetising_reactance", given=0.0):
        machine_with(*(ramps[name] for name in order), drive=INDUCTION)
