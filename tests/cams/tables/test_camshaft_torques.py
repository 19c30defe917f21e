"""The torques on a camshaft and its speed, by hand; and where its drive is too weak."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed, refused

import wucht
from wucht.cams.correction import Purity
from wucht.cams.driven_camshaft import DrivenCamshaft
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import ElasticTable, ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.numerics.fourier_series import FourierSeries, even_angles

HERE = Path()
MOTOR = {"kind": "linear", "slope": 2.0, "no_load_speed": 100.0}


def test_the_speed_of_a_shaft_with_a_load() -> None:
    """2 (100 - w) = 0.5 w at 80 rad/s; an expected speed takes its place."""
    loads = ({"kind": "viscous", "coefficient": 0.5},)
    common: dict[str, Any] = {"inertia": 3.0, "output_inertia": 0.2, "drive": MOTOR, "loads": loads}
    driving = ShaftTable(**common).camshaft_drive(HERE)
    assert driving is not None and not driving.is_enforced
    assert (driving.speed, driving.inertia, driving.friction) == (pytest.approx(80.0), 0.0, 0.0)
    torque, slope = driving.net(np.array([0.0, 80.0]))
    assert torque == pytest.approx([200.0, 0.0], abs=1e-9) and slope == pytest.approx([-2.5, -2.5])
    expected = ShaftTable(**common, mean_speed=70.0).camshaft_drive(HERE)
    assert expected is not None and expected.speed == 70.0
    shaft = ShaftTable(**common).camshaft(driving, "rad")
    assert (shaft.inertia, shaft.output_inertia, shaft.mean_speed) == (3.0, 0.2, pytest.approx(80.0))
    assert shaft.torque is not None and shaft.torque(np.array([0.0]))[0] == pytest.approx([200.0])


def test_a_drive_that_enforces_its_speed_has_no_torque() -> None:
    table = ShaftTable(inertia=3.0, output_mass=0.2, drive={"kind": "constant-speed", "speed": 40.0})
    driving = table.camshaft_drive(HERE)
    assert driving is not None and driving.is_enforced and driving.speed == 40.0
    shaft = table.camshaft(driving, "m")
    assert shaft.torque is None and shaft.mean_speed == 40.0
    with refused("shaft.output_mass"):
        table.camshaft(driving, "rad")
    with refused("shaft.mean_speed", given=30.0):
        ShaftTable(inertia=3.0, output_mass=0.2, mean_speed=30.0, drive=table.drive).camshaft_drive(HERE)


def test_a_weak_drive_does_not_start_its_shaft() -> None:
    """150 N m of dry friction against 100 N m; an expected speed makes no difference where no speed is possible."""
    loads = ({"kind": "coulomb", "torque": 150.0, "transition_speed": 0.01},)
    weak: dict[str, Any] = {"inertia": 3.0, "output_inertia": 0.2, "drive": MOTOR | {"slope": 1.0}, "loads": loads}
    for more in ({}, {"mean_speed": 60.0}):
        with refused("shaft.drive", given="linear", code="stands"):
            ShaftTable(**weak, **more).camshaft_drive(HERE)
    strong = ShaftTable(**weak | {"drive": MOTOR}).camshaft_drive(HERE)
    assert strong is not None and strong.speed == pytest.approx(25.0, rel=1e-6)
    assert (strong.friction, strong.transition) == (150.0, 0.01)


HELD = {"kind": "constant-speed", "speed": 100.0}


LAW = HarmonicLawTable(harmonics=2, coefficients={"mean": 0.1, "cosine": [-0.1]})


def test_the_motion_for_which_a_cam_is_corrected() -> None:
    held = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, drive=HELD | {"speed": 50.0}))
    motion = held.corrected_shaft_motion
    assert motion.mean == pytest.approx(50.0) and motion.fluctuation == pytest.approx(0.0, abs=1e-12)
    free = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=6.0, mean_speed=50.0)).corrected_shaft_motion
    assert free.mean == pytest.approx(50.0) and free.fluctuation > 1e-4
    linear = {"kind": "linear", "slope": 50.0, "no_load_speed": 55.0}
    load = {"kind": "viscous", "coefficient": 2.0}
    driven = wucht.CamDrive(LAW, shaft=ShaftTable(inertia=20.0, output_inertia=600.0, drive=linear, loads=[load]))
    speed = driven.corrected_shaft_motion.speed(even_angles(512))
    assert np.mean((50 * (55 - speed) - 2 * speed) * speed) == pytest.approx(0.0, abs=1e-6 * 50 * 55**2), "work in, work out"
    assert np.ptp(speed) > 1e-3 * speed.mean()
    with refused("speed", given=None, code="missing"):
        _ = wucht.CamDrive(LAW).corrected_shaft_motion


def test_the_damping_of_an_output_on_a_spring() -> None:
    """Given itself, or by its ratio to the critical one, 2 sqrt(c m)."""
    common = {"output_stiffness": 400.0}
    assert ElasticTable(**common, output_damping=3.0).output(4.0, "rad").damping == 3.0
    assert ElasticTable(**common, output_damping_ratio=0.25).output(4.0, "rad").damping == pytest.approx(0.25 * 2 * 40.0)
    with refused("shaft.elastic.output_damping", "negative", given=-3.0):
        ElasticTable(**common, output_damping=-3.0).output(4.0, "rad")
    with refused("shaft.elastic.output_stiffness", "above zero", given=0.0):
        ElasticTable(output_stiffness=0.0).output(4.0, "rad")


SERIES = FourierSeries.of(0.5, [-0.4, 0.1])
J0, J1, OMEGA = 20.0, 6.0, 50.0
FALLING = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
LOADS = [{"kind": "viscous", "coefficient": 2.0}, {"kind": "coulomb", "torque": "7 N m"}]
TAU = np.linspace(0.0, 2 * math.pi, 9)


def slopes(phi: Any) -> tuple[Any, Any]:
    """By hand: psi' and psi''."""
    return 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)


def camshaft(**shaft: Any) -> DrivenCamshaft:
    mean = {} if "drive" in shaft else {"mean_speed": OMEGA}
    table = ShaftTable(**{"inertia": J0, "output_inertia": J1} | mean | shaft)
    driving = table.camshaft_drive(Path())
    return DrivenCamshaft(SERIES, table.camshaft(driving, "rad"), driving, Purity.from_law(SERIES))


def test_the_power_at_constant_speed_is_that_of_output_and_loads() -> None:
    """J1 omega^3 psi' psi'' and omega times the loads; over the angle, the last as the first."""
    slope, bend = slopes(2 * math.pi * np.arange(16) / 16)
    expected = J1 * 30.0**3 * slope * bend + 30.0 * (60.0 + 7.0)
    power = camshaft(drive=FALLING, loads=LOADS).constant_speed_power(30.0, 16)
    assert power == pytest.approx(np.append(expected, expected[0]), rel=1e-6)
    bare = camshaft().constant_speed_power(30.0, 16)
    assert bare[:-1] == pytest.approx(expected - 30.0 * 67.0, abs=1e-6 * expected.max())


def test_the_torque_of_the_drive_is_its_own() -> None:
    """200 (53.4 - v), whatever the loads; none without a drive; where it enforces the speed, loads and output."""
    shaft, viscous = ShaftMotion(FourierSeries.of(50.0, [3.0])), LOADS[:1]
    drive = camshaft(drive=FALLING, loads=viscous).drive_torque(SERIES, shaft, TAU)
    assert drive == pytest.approx(200 * (51 * math.pi / 3 - 50 - 3 * np.cos(TAU)))
    assert camshaft().drive_torque(SERIES, shaft, TAU).tolist() == [0.0] * 9
    held = camshaft(drive={"kind": "constant-speed", "speed": 50.0}, loads=viscous)
    slope, bend = slopes(TAU)
    torque = held.drive_torque(SERIES, ShaftMotion(FourierSeries.of(50.0)), TAU)
    assert torque == pytest.approx(100.0 + J1 * 2500 * slope * bend)


def test_a_disturbance_decays_by_the_slope_of_the_torque() -> None:
    """Of an output without inertia: exp(-(200 + 2) T/J0)."""
    shaft = ShaftMotion(FourierSeries.of(50.0))
    still = replace(camshaft(), shaft=CamShaft(J0, 0.0, OMEGA, lambda v: (0 * v, np.full(np.shape(v), -202.0))))
    assert still.energy_multiplier(SERIES, shaft) == pytest.approx(math.exp(-202 * 2 * math.pi / 50 / J0))
    assert camshaft().energy_multiplier(SERIES, shaft) == 1.0
    assert math.isnan(camshaft(drive={"kind": "constant-speed", "speed": 50.0}).energy_multiplier(SERIES, shaft))


def test_a_motion_that_ends_at_standstill_is_a_sentence() -> None:
    """The shaft creeps where 150 N m of friction, smooth about standstill, hold 10 N m of the drive."""
    driven = camshaft(drive=FALLING, loads=[{"kind": "coulomb", "torque": "150 N m"}])
    assert driven.driving is not None

    def torques(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([10.0 + 0 * v, 150 * np.tanh(v / 0.1)]), np.zeros((2, len(v)))

    def torque(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 10 - 150 * np.tanh(v / 0.1), -1500 / np.cosh(v / 0.1) ** 2

    creeping = replace(driven, driving=replace(driven.driving, torques=torques), shaft=CamShaft(J0, J1, 0.007, torque))
    with failed("stands", "0.00668 rad/s", "10 N", "m"):
        creeping.motion(False)
