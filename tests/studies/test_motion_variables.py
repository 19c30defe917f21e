"""The variables of a motion: each follows from others by its definition, in the units that it states."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import CoastDown, Machine, RunUp, TorqueBalance, load_machine, run
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "inertia": 0.03, "unbalance": 2e-3}
BALL = {"kind": "pendulum", "about": "drum", "mass": 0.01, "length": 0.1, "damping": 1e-5}
GUIDED = {
    "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.3, "damping": 0.02, "moving_mass": 0.2,
    "inner_stop": 0.05, "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0, "permanent_unbalance": 0.0,
}  # fmt: skip
CARRIER = {"mass": 0.98, "stiffness": [3e4, 12e4], "damping": [20.0, 30.0]}
DRIVE = {"kind": "linear", "slope": 0.04}
TABLE = {"parameter": "drive.no_load_speed", "points": [(0.0, -300.0), (0.5, -50.0)], "interpolation": "linear"}
PARTS: dict[str, dict[str, Any]] = {
    "balls": {"bodies": [ROTOR, BALL | {"name": "b1"}, BALL | {"name": "b2"}], "drive": DRIVE | {"no_load_speed": 300.0}},
    "clockwise": {"bodies": [ROTOR], "drive": DRIVE | {"no_load_speed": -300.0}, "schedules": [TABLE]},
    "two rotors": {
        "bodies": [ROTOR, ROTOR | {"name": "e2"}],
        "drives": [DRIVE | {"on": "drum", "no_load_speed": 300.0}, DRIVE | {"on": "e2", "no_load_speed": -280.0}],
    },
    "guided": {"bodies": [ROTOR, GUIDED], "drive": DRIVE | {"no_load_speed": 300.0}},
}


def made(name: str) -> Machine:
    return machine_from({"carrier": CARRIER} | PARTS[name])


@cache
def motion(name: str) -> xr.Dataset:
    """A run-up of a second."""
    return run(RunUp(until=1.0), made(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["balls", "clockwise", "two rotors"])
def test_rates_are_those_of_what_moves(name: str) -> None:
    """Differences of angles and displacements over a sample are means of speeds and velocities, but for the curvature."""
    result, step = motion(name), np.diff(motion(name).time.values)
    for place, rate in (("angle", "speed"), ("displacement", "velocity")):
        for x, v in zip(result[place].values, result[rate].values, strict=True):
            assert np.diff(x) / step == pytest.approx((v[1:] + v[:-1]) / 2, abs=0.05 * np.abs(v).max())
    units = {
        "angle": "rad",
        "speed": "rad/s",
        "motor_torque": "N m",
        "motor_power": "W",
        "displacement": "m",
        "velocity": "m/s",
    }
    units |= {"bearing_force": "N", "radius": "m", "amplitude": "m", "stored_energy": "J"}
    assert {variable: result[variable].attrs["units"] for variable in units} == units


@pytest.mark.parametrize("name", ["balls", "clockwise"])
def test_torque_power_and_amplitude(name: str) -> None:
    """The motor at the speed of the rotor; the radius in the plane, whose greatest value is the peak."""
    result = motion(name)
    speed, no_load = result.speed.values[0], 300.0
    if name == "clockwise":
        no_load = np.interp(result.time.values, *np.transpose(TABLE["points"]))
    assert result.motor_torque.values == pytest.approx(0.04 * (no_load - speed), abs=1e-9)
    assert result.motor_power.values == pytest.approx(result.motor_torque.values * speed, abs=1e-9)
    assert result.radius.values == pytest.approx(np.hypot(*result.displacement.values), abs=1e-12)
    assert float(result.peak_amplitude) == pytest.approx(result.radius.values.max(), rel=1e-2)
    assert result.free_speed.values == pytest.approx(300.0 if name == "balls" else -50.0), "as at the end of the run"
    assert ("phase" in result) == (name == "balls")


def test_the_amplitude_joins_the_peaks_of_an_orbit_that_is_no_circle() -> None:
    """It begins at zero with the motion, and is about as large as the greatest radius of each turn."""
    result = motion("balls")
    amplitude, radius, time = result.amplitude.values, result.radius.values, result.time.values
    assert amplitude[0] < 1e-3 * amplitude.max()
    half = math.pi / np.abs(result.speed.values[0]).max()
    for k in np.flatnonzero((time > 0.8) & (time < 0.95)):
        turn = radius[np.abs(time - time[k]) <= half]
        assert turn.min() < 0.7 * turn.max(), "of an ellipse"
        assert amplitude[k] == pytest.approx(turn.max(), rel=0.2)


def test_phases_and_the_residual_unbalance_are_those_of_the_angles() -> None:
    """Two pendulums of 1 g m each about a rotor of 2 g m."""
    result = motion("balls")
    drum, *balls = result.angle.values
    assert result.body.values.tolist() == ["drum", "b1", "b2"] and np.isnan(result.phase.values[0]).all()
    assert np.exp(1j * result.phase.values[1:]) == pytest.approx(np.exp(1j * (np.array(balls) - drum)), abs=1e-9)
    left = np.abs(2e-3 * np.exp(1j * drum) + sum(1e-3 * np.exp(1j * ball) for ball in balls)) / 2e-3
    assert result.residual_unbalance.values == pytest.approx(left, abs=1e-9)


def test_a_mass_in_its_guide_adds_to_the_unbalance_of_its_body() -> None:
    """0.2 kg that have moved outward beside a pendulum that has no unbalance while they are at their stop."""
    result = motion("guided")
    (out,), (drum, pendulum) = result.slider_displacement.values, result.angle.values
    assert out.max() > 1e-3 and result.slider.values.tolist() == ["p"]
    left = np.abs(2e-3 * np.exp(1j * drum) + 0.2 * out * np.exp(1j * pendulum)) / 2e-3
    assert result.residual_unbalance.values == pytest.approx(left, abs=1e-9)
    assert (result.slider_displacement.attrs["units"], result.slider_velocity.attrs["units"]) == ("m", "m/s")


@pytest.mark.parametrize("name", PARTS)
def test_the_balance_of_energy_is_that_of_the_works(name: str) -> None:
    result = motion(name)
    stored, supplied, dissipated = (result[n].values for n in ("stored_energy", "supplied_work", "dissipated_work"))
    missing = supplied - dissipated - (stored - stored[0])
    scale = max(np.abs(one).max() for one in (stored, supplied, dissipated))
    assert result.energy_residual.values == pytest.approx(missing / scale, abs=1e-6)
    assert np.abs(missing).max() < 1e-4 * scale


def test_rotors_have_their_phase_to_the_first_and_a_power_and_a_force_each() -> None:
    """In the sense in which each turns, in [0, 2 pi); forces by rotor and direction, which add to that of the bearings."""
    result = motion("two rotors")
    (first, second), phase = result.angle.values, result.rotor_phase.values
    assert np.isnan(phase[0]).all() and (phase[1] >= 0).all() and (phase[1] < 2 * math.pi).all()
    assert np.exp(1j * phase[1]) == pytest.approx(np.exp(1j * (-second - first)), abs=1e-9)
    speeds = result.speed.values
    no_load = np.array([[300.0], [-280.0]])
    assert result.rotor_power.values == pytest.approx(0.04 * (no_load - speeds) * speeds, abs=1e-9)
    assert result.rotor_bearing_force.dims == ("rotor", "plane", "time") and result.plane.values.tolist() == ["x", "y"]
    assert not {"rotor_power", "rotor_bearing_force"} & set(motion("balls"))


def test_a_shaken_machine_has_the_phase_of_its_rotor_to_the_vibration() -> None:
    result = run(RunUp(until=2.0), machine := load_machine("sperling-vibration/figure-2a"))
    frequency, place = machine.shaking_frequency, result.body.values.tolist().index(machine.rotor.name)
    assert frequency is not None and result.vibration_frequency.values == pytest.approx(frequency)
    behind = result.angle.values[place] - frequency * result.time.values
    assert np.exp(1j * result.rotor_phase.values[place]) == pytest.approx(np.exp(1j * behind), abs=1e-9)


def test_natural_frequencies_and_parameters_by_their_names() -> None:
    """Of 2.98 kg."""
    result = run(TorqueBalance(), made("two rotors"))
    natural = result.wucht.summary["natural_frequencies"]
    assert natural == pytest.approx({"x": math.sqrt(3e4 / 4.98), "y": math.sqrt(12e4 / 4.98)})
    assert dict(zip(result["mode"].values, result.natural_frequency.values, strict=True)) == natural
    assert result.natural_frequency.attrs["units"] == result.wucht.unit_at("natural_frequencies.x") == "rad/s"
    down = run(CoastDown(until=0.1), made("balls"))
    assert dict(zip(down.parameter.values, down.parameters.values, strict=True)) == dict(made("balls").values)


def test_the_places_of_mounts_are_those_of_the_file() -> None:
    result = run(RunUp(until=0.01), load_machine("practice/screen"))
    assert (result.mount_x.values.tolist(), result.mount_y.values.tolist()) == ([-0.9, 0.9], [-0.2, -0.2])
