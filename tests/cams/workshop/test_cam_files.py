"""Files of a cam, read back: their deviations of curves known by pencil, and which curves are written at all."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed

from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.workshop import cam_files
from wucht.cams.workshop.cam_files import (
    WorkshopFile,
    _checked_file,
    _motion_deviation,
    _write_point_list,
    write_cam_files,
    write_law_files,
)
from wucht.cams.workshop.lists import Separator
from wucht.cams.workshop.plc import Form
from wucht.cams.workshop.points import PointList, chord_points
from wucht.numerics.fourier_series import FourierSeries

RADIUS = 0.04
LAW = FourierSeries.of(0.01, [-0.006], [0.001])
CAM = RollerCam(LAW, TranslatingRoller(distance=0.05, roller_radius=0.008))


def circle(phi: np.ndarray, order: int = 0) -> np.ndarray:
    return np.asarray(RADIUS * 1j**order * np.exp(1j * np.asarray(phi)))


def around(count: int) -> PointList:
    phi = np.arange(count) * 2 * math.pi / count
    return PointList(phi, circle(phi), circle(phi) / RADIUS)


def listed(path: Path, tolerance: float, decimals: int = 6) -> WorkshopFile:
    return _write_point_list(path / "a.txt", "circle", circle, around(8), tolerance, decimals, Separator.BLANK, None)


def test_a_list_deviates_by_the_height_of_its_arcs(tmp_path: Path) -> None:
    """Eight chords of a circle: r (1 - cos(pi/8)); half a unit of the last digit is allowed besides, in x and in y."""
    height = RADIUS * (1 - math.cos(math.pi / 8))
    file = listed(tmp_path, 1.01 * height, 3)
    assert file.deviation == pytest.approx(height, abs=1e-6) and (file.count, file.motion, file.unit) == (8, None, "m")
    assert file.allowed_deviation == pytest.approx(1.01 * height + 1e-3 * 1e-3 * math.sqrt(2) / 2, rel=1e-9)
    with failed("deviates"):
        listed(tmp_path, 0.99 * height)


def test_what_a_file_may_deviate_by(tmp_path: Path) -> None:
    """By a millionth of the limit more, which is arithmetic."""
    file = WorkshopFile(tmp_path / "a", "", 1, 1.0, 1.0)
    assert _checked_file(replace(file, deviation=1 + 0.9e-6)).count == 1
    with failed("deviates"):
        _checked_file(replace(file, deviation=1 + 1.1e-6))


def test_the_motion_that_milled_points_make_is_compared_with_the_law() -> None:
    """Points of a cam that lifts 3e-5 m more are off by that; without contact it is infinite."""
    phi = np.arange(720) * math.pi / 360
    higher = replace(CAM, law=FourierSeries.of(0.01 + 3e-5, [-0.006], [0.001]))
    assert _motion_deviation(CAM, higher.contour(phi)) == pytest.approx(3e-5, rel=1e-4)
    assert _motion_deviation(CAM, 0.2 + 0.001 * np.exp(-1j * phi)) == math.inf


def written(path: Path, cam: Any, **more: Any) -> dict[str, WorkshopFile]:
    points = chord_points(cam.contour, 2e-5)
    return {f.path.name: f for f in write_cam_files(path, "cam", cam, points, 2e-5, 6, **{"drawing": False} | more)}


def test_lists_of_a_cam_with_a_roller(tmp_path: Path) -> None:
    files = written(tmp_path, CAM)
    assert list(files) == ["cam.txt", "cam-pitch.txt"]
    assert "roller radius 8 mm" in files["cam-pitch.txt"].content and files["cam-pitch.txt"].motion is None
    motion = files["cam.txt"].motion
    assert motion is not None and 1e-10 < motion < 1e-5
    finer = written(tmp_path, CAM, spacing=5e-4)
    length = np.abs(np.diff(CAM.pitch(np.linspace(0, 2 * math.pi, 4001)))).sum()
    assert finer["cam-pitch.txt"].count >= length / 5e-4 > files["cam-pitch.txt"].count
    assert finer["cam.txt"].count == files["cam.txt"].count, "points of the contour are given"


def test_only_an_inner_flank_of_a_roller_has_a_pitch_curve(tmp_path: Path) -> None:
    edge = replace(CAM, follower=CAM.follower.model_copy(update={"roller_radius": 0.0}))
    assert list(written(tmp_path, edge)) == list(written(tmp_path, replace(CAM, outer=True))) == ["cam.txt"]


def test_a_drawing_is_compared_with_the_curves_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest deviation of all its lines counts, and the base circle is the contour's smallest radius."""
    drawn = list[tuple[Any, ...]]()
    monkeypatch.setattr(cam_files, "write_dxf", lambda *given: drawn.append(given))
    lines = {"CONTOUR": (3, 1e-6), "CONTOUR_SPLINE": (4, 5e-6)}
    monkeypatch.setattr(cam_files, "read_back", lambda *given: (drawn.append(given), lines)[1])
    files = written(tmp_path, CAM, drawing=True)
    assert (files["cam.dxf"].count, files["cam.dxf"].deviation, files["cam.dxf"].allowed_deviation) == (7, 5e-6, 2e-5)
    (path, contour, tolerance, pitch, base, roller, heading), (again, contour_read, pitch_read) = drawn
    at = np.array([0.3])
    assert path == again == tmp_path / "cam.dxf" and (tolerance, roller, heading) == (2e-5, 0.008, None)
    assert contour(at) == pytest.approx(CAM.contour(at)) == contour_read(at)
    assert pitch(at) == pytest.approx(CAM.pitch(at)) == pitch_read(at)
    assert base == pytest.approx(np.abs(CAM.contour(np.linspace(0, 2 * math.pi, 20_001))).min(), abs=1e-9)


@pytest.mark.parametrize("unit", ["m", "rad"])
def test_the_law_as_tables_of_controllers(tmp_path: Path, unit: str) -> None:
    law, tolerance = FourierSeries.of(0.3, [-0.25]), 1e-4
    scale = 1 if unit == "rad" else 0.1
    files = write_law_files(
        tmp_path,
        FourierSeries.of(scale * law.mean, scale * law.cosine),
        unit,
        scale * tolerance,
        forms=(Form.CSV, Form.CODESYS_ASCII),
    )
    assert [f.path.name for f in files] == ["law.csv", "law.ascii.txt"]
    for file in files:
        assert 0 < file.deviation <= file.allowed_deviation == pytest.approx(scale * tolerance) and file.unit == unit
    quintic, linear = files
    assert linear.count > 3 * quintic.count, "straight lines need more points"
    assert linear.count >= 2 * math.pi / math.sqrt(8 * tolerance / 0.25) * 0.7
