"""Files of a cam, read back: their deviations of curves known by pencil, and which curves are written at all."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.workshop.cam_files import WorkshopFile, write_cam_files, write_law_files
from wucht.cams.workshop.plc import Form
from wucht.cams.workshop.points import chord_points
from wucht.numerics.fourier_series import FourierSeries

LAW = FourierSeries.of(0.01, [-0.006], [0.001])
CAM = RollerCam(LAW, TranslatingRoller(distance=0.05, roller_radius=0.008))


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
