"""Parameters over time: against closed solutions and energy balances, with exact corners."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.schedules import SCHEDULE_WORK, Schedule, proportional_voltage
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import interpolated_pieces

PLATE = {
    "power": "4 kW", "speed": "1435 rpm", "voltage": "400 V", "frequency": "50 Hz", "efficiency": 0.866, "power_factor": 0.81,
    "breakdown_torque_ratio": 3.0,
}  # fmt: skip
RAMP = {"parameter": "drive.frequency", "points": [["0 s", "0 Hz"], ["2 s", "50 Hz"]], "voltage": "proportional"}
PHASE = 400 / math.sqrt(3)


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


def test_one_schedule_moves_both():
    machine = inverter_machine(RAMP | {"boost": "10 V"})
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
        ({"boost": "1 A"}, None, refused("machine.schedules[0].boost", given="1 A", code="dimension")),
        ({"voltage": "V/f"}, None, refused("machine.schedules[0].voltage", given="V/f", code="unknown-name")),
        ({"voltage": None, "boost": "3 V"}, None, refused("machine.schedules[0].boost", given="3 V", code="not-allowed")),
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
        inverter_machine(ramp, drive=drive)


def test_the_voltage_has_one_schedule():
    own = {"parameter": "drive.voltage", "points": [[0, 1], [1, 2]]}
    with refused("machine.schedules[1].parameter", given="drive.voltage"):
        inverter_machine(RAMP, own)
    with refused("machine.schedules[1].parameter", given="drive.voltage"):
        inverter_machine(own, RAMP)


DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
BALANCED = DRUM | {"eccentricity": 0.0}
CARRIER = {"mass": 1.0, "stiffness": 1.2e4, "damping": 20.0}
DC = {"kind": "dc-separate", "voltage": 0.0, "armature_resistance": 2.0, "motor_constant": 1.0, "flux": 0.5}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 90.0}
PENDULUM = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.01}


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


def test_a_smooth_voltage():
    """The work of a smooth ramp, by quadrature of the closed impulse response (Duhamel)."""
    points = ([0.0, 0.0], [1.0, 26.0])
    machine = machine_with(schedule("drive.voltage", *points, interpolation="smooth"), bodies=[BALANCED], drive=DC)
    rows = moved(machine, 2.0, 21)
    tau = 0.03 * 2.0 / 0.25
    s, weights = np.polynomial.legendre.leggauss(60)
    for t, w in zip(rows["time"][1:], rows["drum.speed"][1:], strict=True):
        total = 0.0
        for low, high in ((0.0, min(t, 1.0)), (1.0, max(t, 1.0))):
            at = low + (high - low) * (s + 1) / 2
            voltage = np.where(at < 1, 26 * (3 * at**2 - 2 * at**3), 26.0)
            total += (weights * 0.5 / 2.0 * voltage * np.exp(-(t - at) / tau)).sum() * (high - low) / 2 / 0.03
        assert w == pytest.approx(total, abs=1e-9)


def test_a_step_of_a_torque():
    """Constant torque on a rotor on a fixed axis: straight lines, with corners at the steps, one of them at a sample."""
    drive = {"kind": "constant-torque", "torque": 0.0}
    steps = schedule("drive.torque", [0.5, 0.3], [1.0, -0.6], [1.25, 0.0], interpolation="steps")
    rows = moved(machine_with(steps, bodies=[BALANCED], drive=drive, carrier={"directions": "fixed"}), 2.0)
    t = rows["time"]  # the first value holds before the first point
    exact = 10 * np.minimum(t, 1.0) - 20 * np.clip(t - 1.0, 0, 0.25)
    assert rows["drum.speed"] == pytest.approx(exact, abs=1e-11)


SOFTER = {
    "linear": schedule("carrier.stiffness", [0.3, 1.2e4], [0.9, 2e3]),
    "smooth": schedule("carrier.stiffness", [0.3, 1.2e4], [0.9, 2e3], interpolation="smooth"),
    "steps": schedule("carrier.stiffness", [0.0, 1.2e4], [0.3, 5e3], [0.95, 2e4], interpolation="steps"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", SOFTER)
def test_the_energy_of_a_support_that_softens(kind):
    """What the schedule takes out is booked: with steps c x^2/2 at the moment of the step."""
    machine = machine_with(SOFTER[kind], bodies=[DRUM, PENDULUM])
    rows = moved(machine, 1.5, 401, {"p": 1.0, "carrier": {"x": "3 mm"}})
    assert energy_gap(rows).max() < 1e-9  # at the samples at the very corners as well
    assert np.ptp(rows[SCHEDULE_WORK]) > 1e-3


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


def test_a_laundry_that_loses_water_loses_its_energy():
    """Mass and unbalance change together, at the same corners; the balance closes."""
    masses = schedule("drum.mass", [0.2, 2.0], [0.5, 1.2], [0.7, 1.2], [1.0, 0.8])
    arms = schedule("drum.eccentricity", [0.2, 0.01], [0.5, 0.003], [0.7, 0.003], [1.0, 0.008])
    rows = moved(machine_with(masses, arms, bodies=[DRUM, PENDULUM]), 1.4, 281, {"p": -0.5})
    assert energy_gap(rows).max() < 1e-9
    assert rows[SCHEDULE_WORK][-1] < -0.01


def test_two_schedules_with_the_same_corners():
    """Voltage and flux change at the same times: against the same motor in two runs, one after the other."""
    both = [
        schedule("drive.voltage", [0.0, 10.0], [0.7, 24.0], interpolation="steps"),
        schedule("drive.flux", [0.0, 0.5], [0.7, 0.3], interpolation="steps"),
    ]
    rows = moved(machine_with(*both, bodies=[BALANCED], drive=DC), 2.0, 41)
    t = rows["time"]

    def run(start, voltage, flux, s):
        free, tau = voltage / flux, 0.03 * 2.0 / flux**2
        return free + (start - free) * np.exp(-s / tau)

    middle = run(0.0, 10.0, 0.5, 0.7)
    exact = np.where(t < 0.7, run(0.0, 10.0, 0.5, t), run(middle, 24.0, 0.3, t - 0.7))
    assert rows["drum.speed"] == pytest.approx(exact, abs=1e-9)


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


@pytest.mark.parametrize(
    ("table", "refusal"),
    [
        (
            schedule("drive.slop", [0, 1]),
            refused("machine.schedules[0].parameter", "drive.slope", given="drive.slop", code="unknown-parameter"),
        ),
        ({"points": [[0, 1]]}, refused("machine.schedules[0].parameter", "drive.slope", given=None, code="unknown-parameter")),
        (schedule("drive.slope"), refused("machine.schedules[0].points", given=[], code="pairs")),
        (
            {"parameter": "drive.slope", "points": [[0, 1, 2]]},
            refused("machine.schedules[0].points", given=[[0, 1, 2]], code="pairs"),
        ),
        (
            schedule("drive.slope", [0, 1], [0, 2]),
            refused("machine.schedules[0].points", given=[[0, 1], [0, 2]], code="not-increasing"),
        ),
        (
            schedule("drive.slope", [1, 1], [0, 2]),
            refused("machine.schedules[0].points", given=[[1, 1], [0, 2]], code="not-increasing"),
        ),
        (schedule("drive.slope", ["0 m", 1]), refused("machine.schedules[0].points[0][0]", given="0 m", code="dimension")),
        (schedule("drive.slope", [0, "3 kg"]), refused("machine.schedules[0].points[0][1]", given="3 kg", code="dimension")),
        (
            schedule("drive.slope", [0, 1], interpolation="cubic"),
            refused("machine.schedules[0].interpolation", given="cubic", code="unknown-name"),
        ),
        (
            schedule("drive.slope", [0, 1], colour="red"),
            refused("machine.schedules[0].colour", given="red", code="unknown-key"),
        ),
        (
            schedule("drive.slope", [0, float("nan")]),
            refused("machine.schedules[0].points[0][1]", given=float("nan"), code="not-finite"),
        ),
    ],
)
def test_schedules_that_cannot_be_are_refused(table, refusal):
    with refusal:
        machine_with(table)


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


def test_the_point_that_is_not_allowed_is_named_even_if_another_schedule_begins_before():
    voltage = schedule("drive.voltage", ["0 s", "0 V"], ["5 s", "230 V"])
    frequency = schedule("drive.frequency", ["1 s", "0 Hz"], ["5 s", "50 Hz"])
    with refused("machine.schedules[1].points (t = 1)", given=0.0):
        machine_with(voltage, frequency, drive=INDUCTION)


def test_a_value_that_is_not_allowed_beside_another_is_the_fault_of_the_one_that_changes():
    """Without leakage of the rotor that of the stator may not be 0: the rotor's is at fault by name, but has no schedule."""
    voltage = schedule("drive.voltage", ["0 s", "0 V"], ["5 s", "230 V"])
    reactance = schedule("drive.stator_reactance", ["0 s", "1 ohm"], ["5 s", "0 ohm"])
    with refused("machine.schedules[1].points (t = 5)", "drive.rotor_reactance", "0 ohm", given=0.0):
        machine_with(voltage, reactance, drive=INDUCTION | {"rotor_reactance": 0.0})


def test_smooth_is_the_cubic_that_the_docs_say():
    points = [["0 s", "10 rad/s"], ["4 s", "50 rad/s"]]
    machine = machine_with({"parameter": "drive.no_load_speed", "points": points, "interpolation": "smooth"})
    s = np.array([0.0, 0.1, 0.5, 0.8, 1.0])
    at = [machine.at(4 * x).values["drive.no_load_speed"] for x in s]
    assert at == pytest.approx(10 + 40 * (3 * s**2 - 2 * s**3))


def test_one_schedule_a_parameter():
    with refused("machine.schedules[1].parameter", given="drive.slope"):
        machine_with(schedule("drive.slope", [0, 1]), schedule("drive.slope", [0, 2]))


def test_a_schedule_overrides_what_is_set():
    document = {
        "carrier": CARRIER, "bodies": [DRUM], "drive": LINEAR, "set": {"drive.slope": 0.9, "drum.mass": 3.0},
        "schedules": [schedule("drive.slope", [0.0, 0.05], [1.0, 0.1])],
    }  # fmt: skip
    machine = machine_from(document)
    assert machine.values["drive.slope"] == 0.05
    assert machine.values["drum.mass"] == 3.0
    assert machine.at(0.5).values["drive.slope"] == pytest.approx(0.075)
    assert "drive.slope" not in machine.system.parameter_names


def test_a_run_up_with_a_schedule_reports_its_energy():
    result = run(RunUp(until=1.5), machine_with(SOFTER["steps"]))
    assert result.wucht.summary["energy_residual"] < 1e-9
    assert result[SCHEDULE_WORK].attrs["units"] == "J"


def test_a_run_up_whose_legs_end_at_a_corner():
    """Of 1.5 s in twenty legs, one ends at 0.3 s: the step there is booked once."""
    steps = schedule("carrier.stiffness", [0.0, 1.2e4], [0.3, 5e3], [0.75, 2e4], interpolation="steps")
    result = run(RunUp(until=1.5, start={"carrier": {"x": "3 mm"}}), machine_with(steps))
    assert result.wucht.summary["energy_residual"] < 1e-9


@pytest.mark.parametrize("times", [(1.0, 3.0), (1.0, 2.0, 3.0)])
def test_a_value_holds_since_the_first_or_the_last_point_outside_of_the_points(times):
    of = Schedule("carrier.stiffness", interpolated_pieces("k", times, tuple(range(len(times))), "linear"))
    assert [of.holds_since(time) for time in (0.0, 1.0, 1.75, 3.0, 9.0)] == [1.0, 1.0, 1.75, 3.0, 3.0]
