"""What a cam leaves is judged by the output against its law over time: of a standard law, as a formula and as a table.

The law rises by 30 mm in 120 degrees along an inclined sine, whose acceleration is 2 pi h/b^2 sin(2 pi x/b), and returns alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from wucht import draw, run_file
from wucht.cams.confirmation import confirmation
from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

Command = Callable[..., Any]
Array = NDArray[np.float64]
STROKE, ARC, RETURN = 0.03, 2 * math.pi / 3, math.pi
FORMULA = 'kind = "inclined-sine"\nstroke = "30 mm"\nrise = ["0 deg", "120 deg"]\nreturn = ["180 deg", "300 deg"]'
TABLE = 'kind = "table"\nfile = "law.csv"'
FILE = """
title = "Slide cam"
[study]
kind = "cam-prediction"
[law]
{law}
[follower]
kind = "translating-roller"
distance = "70 mm"
roller_radius = "12 mm"
[shaft]
inertia = "0.4 kg m^2"
output_mass = "12 kg"
[shaft.drive]
kind = "induction"
transmission = {{ ratio = 2.9, inertia = "0.004 kg m^2", efficiency = "95 %" }}
[shaft.drive.nameplate]
power = "1.1 kW"
speed = "1450 rpm"
voltage = "400 V"
frequency = "50 Hz"
breakdown_torque_ratio = 2.8
"""
RECORD = '[speed]\nfile = "speed.csv"\ncolumn = "speed"\norders = [1, 2, 3, 4, 5, 6]\n'


def lift(phi: Array) -> Array:
    """The law in closed form, in m."""

    def rise(x: Array) -> Array:
        share = np.clip(x / ARC, 0.0, 1.0)
        return STROKE * (share - np.sin(2 * math.pi * share) / (2 * math.pi))

    phi = np.mod(phi, 2 * math.pi)
    return np.asarray(rise(phi) - rise(phi - RETURN))


def orders_of(values: Array) -> NDArray[np.complex128]:
    """Orders 1 to 60 of the second derivative by tau of a motion over a turn."""
    k = np.arange(1, 61)
    return np.asarray(-(k**2) * 2 * np.fft.rfft(values)[1:61] / len(values))


def write(law: str, more: str = "") -> None:
    degrees = np.arange(0, 361)
    rows = (f"{d};{1e3 * x:.5f}" for d, x in zip(degrees, lift(np.radians(degrees)), strict=True))
    Path("law.csv").write_text("\n".join(("cam angle [deg];lift [mm]", *rows)) + "\n", encoding="utf-8")
    Path("cam.toml").write_text(FILE.format(law=law) + more, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("law", [pytest.param(FORMULA, id="formula"), pytest.param(TABLE, id="table")])
def test_a_standard_law_is_judged_by_what_is_off_the_law(here: Path, law: str) -> None:
    write(law)
    result = run_file("cam.toml", {"study.simulate": 2, "study.cuts": 2})
    s = result.wucht.summary
    assert s["sentence"].startswith(
        "CLEAN on a shaft that fluctuates by 1.19 %: the corrected cam leaves no order off the law's"
    )
    assert s["sentence"].endswith("the original one leaves orders off by up to 2.74 % of order 1")

    tau = 2 * math.pi * np.arange(4096) / 4096
    target, fine = orders_of(lift(tau)), np.linspace(0, 2 * math.pi, 100_001)
    speed = CubicSpline(result.tau.values, result.speed.values[0], bc_type="periodic")
    turned = CubicSpline(fine, speed(fine), bc_type="periodic").antiderivative()
    phi = turned(tau) / turned(2 * math.pi) * 2 * math.pi
    original = orders_of(lift(phi))
    assert s["above"]["original"] == pytest.approx(np.abs(original - target).max() / abs(original[0]), rel=2e-3)
    assert s["position_error"]["original"] == pytest.approx(np.abs(lift(phi) - lift(tau)).max(), rel=2e-3)
    assert s["above"]["corrected"] < 1e-12 and s["position_error"]["corrected"] < 1e-12 * STROKE
    amplitudes, omega = result.output_acceleration.values[:, :20], s["corrected"]["mean_speed"]
    expected = omega**2 * np.abs(target[:20])
    assert amplitudes[1] == pytest.approx(expected, abs=1e-3), "but for 2048 samples of a turn, and a table's rounding"
    assert expected[8] < 1e-6 and amplitudes[0, 8] == pytest.approx(0.168, rel=0.02), "order 9, which the law has not"
    assert s["simulation"]["corrected"]["above"] < 1e-6
    cuts = s["cut_residuals"]
    assert cuts[0] == pytest.approx(s["above"]["original"]) and cuts[1] < 0.05 * cuts[0]


def test_a_record_of_the_speed_is_compared_with_the_prediction(here: Path) -> None:
    """Made of the prediction itself with the original cam, beginning anywhere in a turn, and with a fluctuation ten times as
    large."""
    write(FORMULA)
    result = run_file("cam.toml", {"study.simulate": 0, "study.cuts": 0})
    assert result.wucht.summary["record"] is None and "measured_speed" not in result
    write(FORMULA, RECORD)
    speed = CubicSpline(result.tau.values, result.speed.values[0], bc_type="periodic")
    clock, mean = np.arange(0.0, 2.0, 1e-3), result.wucht.summary["mean_speed"]
    warned = []
    for times in (1.0, 10.0):
        values = mean + times * (speed(np.mod(mean * clock + 1.0, 2 * math.pi)) - mean)
        rows = "\n".join(f"{t:.4f},{30 / math.pi * v:.4f}" for t, v in zip(clock, values, strict=True))
        Path("speed.csv").write_text(f"time [s],speed [rpm]\n{rows}\n", encoding="utf-8")
        measured = run_file("cam.toml", {"study.simulate": 0, "study.cuts": 0})
        record = measured.wucht.summary["record"]
        assert record["mean_speed"] == pytest.approx(mean, rel=1e-4)
        assert record["fluctuation"] == pytest.approx(times * result.wucht.summary["fluctuation"], rel=0.05)
        assert record["explained"]["original"] == pytest.approx(1 - (1 - 1 / times) ** 2, abs=0.01)
        warned.append([w for w in measured.wucht.warnings if "the record of the speed" in w])
    assert not warned[0] and "cam-correction" in warned[1][0]
    assert draw(measured).axes


@pytest.mark.slow
def test_a_torque_is_not_computed_again_and_again() -> None:
    """It is tabulated for the simulation, also where it has kinks: beside SciPy's solution with the torque itself."""
    from scipy.integrate import solve_ivp

    calls = []

    def torque(speeds: Array) -> tuple[Array, Array]:
        calls.append(speeds.size)
        over = np.asarray(speeds) > 50.3
        return np.where(over, -400.0, -30.0) * (speeds - 50.3), np.where(over, -400.0, -30.0)

    law: Law = FourierSeries.of(0.5, [-0.4, 0.1])
    shaft = CamShaft(2.0, 1.0, 50.0, torque)
    motion = shaft.motion_with_cam(law)
    calls.clear()
    simulated = confirmation(shaft, law, motion, 2, lambda _: None)
    assert len(calls) < 100, "a turn takes some thousand steps"

    def slope(_: float, y: Array) -> list[float]:
        p, q = float(law(y[0], 1)), float(law(y[0], 2))
        return [y[1], (float(torque(y[1])[0]) - p * q * y[1] ** 2) / (2.0 + p**2)]

    period = 2 * math.pi / motion.mean
    at = period * (1 + np.arange(64) / 64)
    begin = [0.0, float(motion.speed(0.0))]
    expected = solve_ivp(slope, (0, 2 * period), begin, "DOP853", at, rtol=1e-11, atol=1e-11, max_step=period / 500).y[1]
    assert simulated.speed(2 * math.pi * np.arange(64) / 64) == pytest.approx(expected, rel=1e-8)
    assert isinstance(motion, ShaftMotion)
