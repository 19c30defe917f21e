"""What the correction gains in numbers: acceleration, position error and power of the camshaft, with both cams, by hand.

A slide of 12 kg on a cycloidal law of 30 mm over 120 degrees at 500 rpm, and a shaft whose speed fluctuates in its order 2.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

import wucht
from wucht import CamContour, CamCorrection, CamPrediction
from wucht.cams.drive import cam_drive_from

pytestmark = pytest.mark.usefixtures("coarse_angles")

H, BETA, OMEGA, MASS, SWING = 0.030, 2 * math.pi / 3, 500 * math.pi / 30, 12.0, 3.0  # SWING: rad/s of order 2
RISE = {"kind": "inclined-sine", "stroke": "30 mm", "rise": ["0 deg", "120 deg"], "return": ["180 deg", "300 deg"]}
SEGMENTS = {
    "segments": [
        {"kind": "inclined-sine", "to": "120 deg", "stroke": "30 mm"},
        {"kind": "inclined-sine", "from": "180 deg", "to": "300 deg", "stroke": "-30 mm"},
    ]
}
SPEED = {"mean": OMEGA, "cosine": [0.0, SWING]}
SHAFT = {"inertia": "0.4 kg m^2", "output_mass": f"{MASS} kg", "mean_speed": OMEGA}
LOADED = SHAFT | {"drive": {"kind": "constant-speed", "speed": OMEGA}, "loads": [{"kind": "coulomb", "torque": "5 N m"}]}
del LOADED["mean_speed"]


def answered(spec: Any = None, **tables: Any) -> xr.Dataset:
    given = {"law": RISE, "speed": SPEED, "shaft": SHAFT, **tables}
    return wucht.run(spec or CamCorrection(points=180), cam_drive_from(given, "slide", Path()))


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return answered()


def lift(angle: Any) -> Any:
    """The law by hand."""
    phi = np.mod(angle, 2 * math.pi)
    x = np.clip(phi / BETA, 0, 1) - np.clip((phi - math.pi) / BETA, 0, 1)
    return H * (x - np.sin(2 * math.pi * x) / (2 * math.pi))


def off(tau: Any) -> Any:
    """How far the cam cut at constant speed is off over time: at the angle tau + a/(2 omega) sin 2 tau instead of tau."""
    return lift(tau + SWING / (2 * OMEGA) * np.sin(2 * tau)) - lift(tau)


def test_the_largest_acceleration_is_that_of_the_law(result: xr.Dataset) -> None:
    """2 pi h omega^2/beta^2 = 117.8 m/s^2 with the corrected cam; by differences with the original one."""
    s = result.wucht.summary
    assert s["peak_after"] == pytest.approx(2 * math.pi * H * (OMEGA / BETA) ** 2, rel=1e-9)
    assert f"{s['peak_after']:.1f}" == "117.8"
    tau = np.linspace(0, 2 * math.pi, 200_001)
    over_time = lift(tau) + off(tau)
    assert s["peak_before"] == pytest.approx(OMEGA**2 * np.abs(np.gradient(np.gradient(over_time, tau), tau)).max(), rel=1e-4)
    [line] = [line for line in wucht.report(result) if line.startswith("  acceleration ")]
    assert line.endswith(f"at most 117.8 m/s²; of the original cam {s['peak_before']:.4g} m/s²")


@pytest.mark.parametrize("law", [RISE, SEGMENTS], ids=["rise and return", "segments"])
def test_the_position_error_is_that_by_hand(law: dict[str, Any]) -> None:
    result = answered(law=law)
    s, tau = result.wucht.summary, result.tau.values[:-1]
    by_hand = off(tau)
    before, after = (result.position_error.sel(version=version).values[:-1] for version in ("original", "corrected"))
    assert before == pytest.approx(by_hand, abs=1e-14) and np.abs(after).max() < 1e-15
    edges = [0, BETA, math.pi, math.pi + BETA, 2 * math.pi]
    square = sum(quad(lambda t: off(t) ** 2, a, b, limit=200)[0] for a, b in pairwise(edges))
    assert s["position_error_rms_before"] == pytest.approx(math.sqrt(square / (2 * math.pi)), rel=1e-6)
    assert s["position_error_before"] == pytest.approx(np.abs(by_hand).max(), rel=1e-4)
    assert max(s["position_error_after"], s["position_error_rms_after"]) < 1e-15
    [line] = [line for line in wucht.report(result) if line.startswith("  position ")]
    size, rms = (f"{1e3 * s[f'position_error{which}_before']:.4g} mm" for which in ("", "_rms"))
    assert line.endswith(f"at most 0 mm (rms 0 mm); with the original cam by {size} (rms {rms})")


def test_the_power_of_the_camshaft_is_that_of_a_slide_that_follows_the_law(result: xr.Dataset) -> None:
    """m a v = 2 pi m h^2 (omega/beta)^3 sin (1 - cos), where sin (1 - cos) is 3 sqrt(3)/4 at most. Twice a turn it is moved."""
    power = result.wucht.summary["camshaft_power_after"]
    assert power["peak"] == pytest.approx(2 * math.pi * MASS * H**2 * (OMEGA / BETA) ** 3 * 0.75 * math.sqrt(3), rel=1e-6)
    kinetic = MASS * (2 * H * OMEGA / BETA) ** 2 / 2
    assert power["mean_positive"] == pytest.approx(2 * kinetic * OMEGA / (2 * math.pi), rel=1e-4)
    assert power["mean"] == pytest.approx(0, abs=1e-9)
    assert result.camshaft_power.attrs["units"] == "W" and result.wucht.unit_at("camshaft_power_after.peak") == "W"


def test_power_is_the_rate_of_the_kinetic_energy_with_either_cam(result: xr.Dataset) -> None:
    t = result.time.values
    for version, name in (("original", "before"), ("corrected", "after")):
        speed = np.gradient(result.output_over_time.sel(version=version).values, t, edge_order=2)
        rate = np.gradient(MASS * speed**2 / 2, t, edge_order=2)
        power = result.camshaft_power.sel(version=version).values
        assert rate == pytest.approx(power, abs=5e-3 * np.abs(power).max()), version
        assert result.wucht.summary[f"camshaft_power_{name}"]["peak"] == power.max()


def test_a_load_adds_its_work(result: xr.Dataset) -> None:
    """5 N m of dry friction at the shaft: T omega on average, with either cam."""
    s = answered(shaft=LOADED).wucht.summary
    without = result.wucht.summary
    for name in ("before", "after"):
        assert s[f"camshaft_power_{name}"]["mean"] == pytest.approx(5 * OMEGA, rel=1e-6)
        assert s[f"camshaft_power_{name}"]["peak"] > without[f"camshaft_power_{name}"]["peak"] + 5 * (OMEGA - SWING) * 0.99


def test_without_a_shaft_there_is_no_power_and_one_that_does_not_fit_is_told() -> None:
    given = {"law": RISE, "speed": SPEED}
    bare = wucht.run(CamCorrection(points=180), cam_drive_from(given, "slide", Path()))
    assert bare.wucht.summary["camshaft_power_after"] is None and "camshaft_power" not in bare and not bare.wucht.warnings
    turning = answered(shaft={"inertia": 0.4, "output_inertia": 1.0, "mean_speed": OMEGA})
    assert turning.wucht.summary["camshaft_power_before"] is None
    [warning] = turning.wucht.warnings
    assert warning.startswith("no power of the camshaft: shaft.output_inertia: ") and "output_mass" in warning


def test_a_flat_face_is_as_long_as_the_range_of_the_velocity_by_the_angle() -> None:
    """2 h/beta to either side; of the corrected cam times what the shaft is slower there."""
    result = answered(follower={"kind": "flat-faced", "distance": "150 mm"})
    cam = result.wucht.summary["contours"]["cam"]
    assert cam["original"]["face_length"] == pytest.approx(4 * H / BETA, rel=1e-9)
    phi = np.linspace(0, 2 * math.pi, 20_001)
    tau = phi.copy()
    for _ in range(60):
        tau = phi - SWING / (2 * OMEGA) * np.sin(2 * tau)
    velocity = np.gradient(lift(tau), phi)
    assert cam["corrected"]["face_length"] == pytest.approx(np.ptp(velocity), rel=1e-5)
    assert cam["corrected"]["face_length"] != pytest.approx(4 * H / BETA, rel=1e-3)


def test_a_prediction_has_the_same_numbers() -> None:
    """At an enforced speed both cams make the law: what it takes then is the power of the camshaft above."""
    result = answered(CamPrediction(points=720, simulate=0, cuts=0), speed={"mean": OMEGA}, shaft=LOADED)
    s = result.wucht.summary
    assert s["peak_acceleration"] == pytest.approx(dict.fromkeys(("original", "corrected"), 117.8097), rel=1e-6)
    assert max(s["position_error_rms"].values()) < 1e-15 and float(np.abs(result.position_error).max()) < 1e-15
    assert np.abs(result.acceleration_over_time.values).max() == pytest.approx(117.8097, rel=1e-6)
    expected = answered(speed={"mean": OMEGA}, shaft=LOADED).wucht.summary["camshaft_power_after"]
    assert s["power"]["corrected"] == pytest.approx(expected, rel=1e-4)


def test_a_prediction_is_off_the_law_with_the_original_cam_alone() -> None:
    """Of the eigenmotion: the distance over time from the law, by the angle of the predicted shaft."""
    result = answered(CamPrediction(points=720, simulate=0, cuts=0))
    s, tau = result.wucht.summary, result.tau.values
    speed = result.speed.sel(cam="original").values / s["mean_speed"]
    angle = np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(tau))])
    by_hand = lift(angle) - lift(tau)
    error = result.position_error.sel(cam="original").values
    assert error == pytest.approx(by_hand, abs=1e-3 * np.abs(by_hand).max())
    assert s["position_error_rms"]["original"] == pytest.approx(math.sqrt((error[:-1] ** 2).mean()), rel=1e-3)
    over_time = lift(tau) + error
    by_differences = s["mean_speed"] ** 2 * np.abs(np.gradient(np.gradient(over_time, tau), tau)).max()
    assert s["peak_acceleration"]["original"] == pytest.approx(by_differences, rel=1e-3)
    assert s["peak_acceleration"]["corrected"] == pytest.approx(117.8097, rel=1e-6)


def test_a_contour_states_the_acceleration_of_its_own_cam(result: xr.Dataset) -> None:
    """With the table [speed] that of the correction, with either cam; at a constant speed that of the law; none without one."""
    given = {"law": RISE, "follower": {"kind": "flat-faced", "distance": "150 mm"}}
    coarse = {"points": 16, "chord_tolerance": "50 um"}

    def peak(table: Any = None, **asked: Any) -> float | None:
        tables = given | ({"speed": table} if table else {})
        contour = wucht.run(CamContour(**coarse, **asked), cam_drive_from(tables, "slide", Path()))
        value: float | None = contour.wucht.summary["peak_acceleration"]
        return value

    s = result.wucht.summary
    assert peak(SPEED, corrected=False) == pytest.approx(s["peak_before"], rel=1e-4)
    assert peak(SPEED, corrected=True) == pytest.approx(s["peak_after"], rel=1e-6)
    assert peak(SPEED, speed="250 rpm") == pytest.approx(s["peak_after"] / 4, rel=1e-6)
    assert peak() is None
