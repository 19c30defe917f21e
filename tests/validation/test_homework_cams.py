"""Two cams of textbooks, each segment of the turn with a law of its own: by closed forms, and by the table of their motion.

A flat-faced cam with a cycloidal rise, a harmonic fall, a 3-4-5 rise and a parabolic fall (``four-laws.csv``: cam angle in deg,
lift in cm), and a double dwell cam whose roller leaves it. The laws: R. L. Norton, Design of Machinery, chapter 8.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import CamLaw, draw, export, load, run, run_file
from wucht.cams.drive import cam_drive_from

EXAMPLES = Path(__file__).parents[2] / "examples"
DEG, H, BETA = math.pi / 180, 0.040, math.pi / 3


def ran(name: str, **settings: Any) -> xr.Dataset:
    return run_file(EXAMPLES / f"{name}.toml", settings={f"study.{key}": value for key, value in settings.items()})


def test_the_motion_of_four_laws_is_that_of_its_table() -> None:
    """To the digits of the table, whose lift is in cm. A parabolic fall has no jerk, a harmonic one no jump of it."""
    result = ran("four_laws_cam", kind="cam-law", points=360)
    table = np.loadtxt(Path(__file__).with_name("four-laws.csv"), delimiter=",", skiprows=1)
    assert result.cam_angle.values[:-1] == pytest.approx(table[:, 0] * DEG)
    assert result.position.values[:-1] == pytest.approx(1e-2 * table[:, 1], abs=5.1e-12)
    peaks = result.wucht.summary["peaks"]
    assert peaks["velocity"] == pytest.approx(2 * H / BETA, rel=1e-12)  # cycloidal and parabolic alike
    assert peaks["acceleration"] == pytest.approx(2 * math.pi * H / BETA**2, rel=1e-12)
    assert peaks["jerk"] == pytest.approx(4 * math.pi**2 * H / BETA**3, rel=1e-12)


def test_its_acceleration_jumps_most_in_the_middle_of_the_parabolic_fall() -> None:
    """From -4 h/beta^2 to 4 h/beta^2."""
    result = ran("four_laws_cam", kind="cam-law", points=16)
    assert result.wucht.summary["acceleration_jumps"] == pytest.approx(8 * H / BETA**2, rel=1e-12)
    [warning] = result.wucht.warnings
    assert warning.startswith("the acceleration jumps at 0°, 90°, 150°, 300°, 330°, and the jerk has no bound there")
    parabolic = {"kind": "parabolic", "stroke": "10 mm", "rise": ["0 deg", "90 deg"]}
    [warning] = run(CamLaw(points=16), cam_drive_from({"law": parabolic}, "a cam", None)).wucht.warnings
    assert warning.startswith(
        "the acceleration jumps where the rise and the return begin or end, and within them, and the jerk"
    )


def test_the_flat_face_of_four_laws() -> None:
    """Radius d + s + s'': in the cycloidal rise it is least where cos 2 pi x = 1/(1 - (2 pi/beta)^2) = -1/35.

    The face reaches as far as ds/dphi: 2 h/beta to either side, 152.79 mm. The base circle may be smaller by that radius.
    """
    result = ran("four_laws_cam", permitted={"least_radius": "0 mm"})
    assert any(warning.startswith("the acceleration jumps at 0°, 90°") for warning in result.wucht.warnings)
    s = result.wucht.summary
    x = 1 - math.acos(-1 / 35) / (2 * math.pi)
    lift, bend = H * (x - math.sin(2 * math.pi * x) / (2 * math.pi)), 2 * math.pi * H / BETA**2 * math.sin(2 * math.pi * x)
    least = s["cams"]["cam"]["min_curvature"]
    assert least == {"radius": pytest.approx(0.2 + lift + bend, rel=1e-9), "at": pytest.approx(60 * DEG * x, rel=1e-6)}
    assert f"{1e3 * least['radius']:.3f} {least['at'] / DEG:.2f}" == "7.092 44.73"
    assert s["face_length"] == pytest.approx(4 * H / BETA, rel=1e-9)
    assert s["smallest"]["base_radius"] == pytest.approx(-(lift + bend), rel=1e-9)  # 192.908 mm


def test_files_for_the_workshop_of_a_contour_that_bends_anew_where_the_acceleration_jumps(tmp_path: Path) -> None:
    pytest.importorskip("ezdxf")
    """Its spline is fine where it has to be: even points do not keep a micrometre, not 65,536 of them."""
    lines = export(ran("four_laws_cam"), tmp_path)
    assert [line.split("  ")[0].rpartition("/")[2] for line in lines] == [
        "cam.txt", "cam.dxf", "law.csv", "law.TcGVL.txt", "law.codesys.txt",
    ]  # fmt: skip
    [count] = [int(line.split(", ")[1].split(":")[0]) for line in lines if "drawing of the cam" in line]
    assert count < 5000  # corners of the polyline and pieces of the spline
    assert "# law: segments, 40 mm from the least to the greatest position" in (tmp_path / "cam.txt").read_text()


def test_the_double_dwell_cam_is_left_by_its_roller() -> None:
    result = ran("double_dwell_cam")
    assert not any("the acceleration jumps" in warning for warning in result.wucht.warnings)
    s, contact = result.wucht.summary, result.wucht.summary["contact"]
    assert contact["lift_off"]["cam"] == [pytest.approx([56.6555 * DEG, 83.0205 * DEG], rel=1e-5)]
    assert contact["least_preload"] == pytest.approx(16.47099, rel=1e-6)
    assert contact["max_torque"]["value"] == pytest.approx(0.226958, rel=1e-5)
    assert contact["power"]["peak"] == pytest.approx(10 * 0.226958, rel=1e-5)
    assert s["peak_acceleration"] == pytest.approx(10 / math.sqrt(3) * 0.010 * (10 / (90 * DEG)) ** 2, rel=1e-6)


def test_what_the_camshaft_gives_over_a_turn_is_what_the_damper_takes() -> None:
    """With a preload that keeps contact: spring and mass give back what they take, and the integral of s'^2 is 10/7 on a rise.

    What flows into the shaft again is the difference of the mean and of the mean of the positive part.
    """
    result = ran("double_dwell_cam", **{"contact.preload": "20 N"})
    power, speed, h = result.wucht.summary["contact"]["power"], 10.0, 0.010
    damped = 2.74 * speed**2 * h**2 * 10 / 7 * (1 / (90 * DEG) + 1 / math.pi) / (2 * math.pi)
    assert power["mean"] == pytest.approx(damped, rel=1e-6)
    curve = result.camshaft_power.values[:-1]
    assert curve == pytest.approx(speed * result.camshaft_torque.values[:-1], rel=1e-12)
    assert (power["peak"], power["mean_positive"]) == pytest.approx((curve.max(), np.maximum(curve, 0).mean()), rel=1e-3)
    assert power["mean_positive"] > 3 * power["mean"]


def test_the_segments_are_drawn_from_the_stored_result(tmp_path: Path) -> None:
    result = run_file(EXAMPLES / "four_laws_cam.toml", folder=tmp_path)
    figure = draw(load(tmp_path / "result.nc"))
    assert len(figure.axes) == 3 and result.attrs["title"] == "Flat-faced cam with four laws"
