"""A camshaft with its drive: torques and power in closed form, how a disturbance decays, a shaft that comes to stand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed

from wucht.cams.correction import Purity
from wucht.cams.driven_camshaft import DrivenCamshaft
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import ShaftTable
from wucht.numerics.fourier_series import FourierSeries

LAW = FourierSeries.of(0.5, [-0.4, 0.1])
J0, J1, OMEGA = 20.0, 6.0, 50.0
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
LOADS = [{"kind": "viscous", "coefficient": 2.0}, {"kind": "coulomb", "torque": "7 N m"}]
TAU = np.linspace(0.0, 2 * math.pi, 9)


def slopes(phi: Any) -> tuple[Any, Any]:
    """By hand: psi' and psi''."""
    return 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)


def camshaft(**shaft: Any) -> DrivenCamshaft:
    mean = {} if "drive" in shaft else {"mean_speed": OMEGA}
    table = ShaftTable(**{"inertia": J0, "output_inertia": J1} | mean | shaft)
    driving = table.camshaft_drive(Path())
    return DrivenCamshaft(LAW, table.camshaft(driving, "rad"), driving, Purity.from_law(LAW))


def test_the_power_at_constant_speed_is_that_of_output_and_loads() -> None:
    """J1 omega^3 psi' psi'' and omega times the loads; over the angle, the last as the first."""
    slope, bend = slopes(2 * math.pi * np.arange(16) / 16)
    expected = J1 * 30.0**3 * slope * bend + 30.0 * (60.0 + 7.0)
    power = camshaft(drive=LINEAR, loads=LOADS).constant_speed_power(30.0, 16)
    assert power == pytest.approx(np.append(expected, expected[0]), rel=1e-6)
    bare = camshaft().constant_speed_power(30.0, 16)
    assert bare[:-1] == pytest.approx(expected - 30.0 * 67.0, abs=1e-6 * expected.max())


def test_the_torque_of_the_drive_is_its_own() -> None:
    """200 (53.4 - v), whatever the loads; none without a drive; where it enforces the speed, loads and output."""
    shaft, viscous = ShaftMotion(FourierSeries.of(50.0, [3.0])), LOADS[:1]
    drive = camshaft(drive=LINEAR, loads=viscous).drive_torque(LAW, shaft, TAU)
    assert drive == pytest.approx(200 * (51 * math.pi / 3 - 50 - 3 * np.cos(TAU)))
    assert camshaft().drive_torque(LAW, shaft, TAU).tolist() == [0.0] * 9
    held = camshaft(drive={"kind": "constant-speed", "speed": 50.0}, loads=viscous)
    slope, bend = slopes(TAU)
    torque = held.drive_torque(LAW, ShaftMotion(FourierSeries.of(50.0)), TAU)
    assert torque == pytest.approx(100.0 + J1 * 2500 * slope * bend)


def test_a_disturbance_decays_by_the_slope_of_the_torque() -> None:
    """Of an output without inertia: exp(-(200 + 2) T/J0)."""
    shaft = ShaftMotion(FourierSeries.of(50.0))
    still = replace(camshaft(), shaft=CamShaft(J0, 0.0, OMEGA, lambda v: (0 * v, np.full(np.shape(v), -202.0))))
    assert still.energy_multiplier(LAW, shaft) == pytest.approx(math.exp(-202 * 2 * math.pi / 50 / J0))
    assert camshaft().energy_multiplier(LAW, shaft) == 1.0
    assert math.isnan(camshaft(drive={"kind": "constant-speed", "speed": 50.0}).energy_multiplier(LAW, shaft))


def test_a_motion_that_ends_at_standstill_is_a_sentence() -> None:
    """The shaft creeps where 150 N m of friction, smooth about standstill, hold 10 N m of the drive."""
    driven = camshaft(drive=LINEAR, loads=[{"kind": "coulomb", "torque": "150 N m"}])
    assert driven.driving is not None

    def torques(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([10.0 + 0 * v, 150 * np.tanh(v / 0.1)]), np.zeros((2, len(v)))

    def torque(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 10 - 150 * np.tanh(v / 0.1), -1500 / np.cosh(v / 0.1) ** 2

    creeping = replace(driven, driving=replace(driven.driving, torques=torques), shaft=CamShaft(J0, J1, 0.007, torque))
    with failed("stands", "0.00668 rad/s", "10 N", "m"):
        creeping.motion(False)


def test_a_cut_cam_without_a_motion_has_a_reason() -> None:
    """A torque that brakes the shaft at every speed; without one there is a motion."""
    braked = replace(camshaft(), shaft=CamShaft(J0, J1, OMEGA, lambda v: (-10 - 2 * v, np.full(np.shape(v), -2.0))))
    with failed("no-convergence", "no periodic motion of the shaft was found"):
        braked.shaft.residual_with_cam(LAW, braked.purity)
    residual, _ = camshaft().shaft.residual_with_cam(LAW, braked.purity)
    assert 0.01 < residual < 1
