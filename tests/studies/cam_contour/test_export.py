"""The files of a contour for the workshop, from the command line and from Python, of the cam that was corrected too."""

import math
from dataclasses import replace
from importlib.metadata import version

import cam_files_to_study as given
import numpy as np
import pytest
from tests.refusals import refused
from typer.testing import CliRunner

import wucht
from wucht import CamContour, CamPrediction, run, run_file
from wucht.cams.correction import CorrectedLaw
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.speed import SpeedTable
from wucht.cams.workshop.cam_files import WorkshopFile
from wucht.cams.workshop.lists import read_list
from wucht.cli import app as command_line
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.cam_workshop import file_lines
from wucht.studies.registry import study_of
from wucht.studies.study_file import read_study

UNEVEN = """
[speed]
mean = "500 rpm"
cosine = ["0 rad/s", "2.4 rad/s", "1 rad/s"]
sine = ["0 rad/s", "1 rad/s"]
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("contour") / "cam.toml"
    path.write_text(study_of("cam-contour").template + UNEVEN)
    return path


@pytest.mark.slow
def test_the_corrected_cam_is_another_one_and_its_list_says_so(file, tmp_path):
    """Its points lie on the contour of the law of the corrected cam, to the half of the last decimal."""
    result = run_file(file, {"study.corrected": True})
    lines = wucht.export(result, tmp_path)
    assert any(line.startswith(str(tmp_path / "cam.txt")) for line in lines)
    drive = read_study(str(file)).subject
    shaft = ShaftMotion(FourierSeries.of(500 * math.pi / 30, [0, 2.4, 1], [0, 1]))
    corrected = drive.make_cams(CorrectedLaw(drive.motion_law.function, shaft))["cam"]
    listed = read_list(tmp_path / "cam.txt")
    assert np.abs(listed.position - corrected.contour(listed.phi)).max() < 1e-8
    assert np.abs(listed.position - drive.make_cams(drive.motion_law.function)["cam"].contour(listed.phi)).max() > 1e-4
    assert result.wucht.summary["corrected"]["cosine"] == [0, 2.4, 1]


def test_without_the_shaft_there_is_no_correction(file):
    with refused("speed", given=None, code="missing"):
        plain = file.parent / "plain.toml"
        plain.write_text(study_of("cam-contour").template)
        run_file(plain, {"study.corrected": True})


@pytest.mark.slow
def test_from_the_command_line(file, tmp_path, monkeypatch):
    command_line.register()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    result = tmp_path / "out"
    run_file(file, folder=result)
    done = CliRunner().invoke(command_line.app, ["export", str(result / "result.nc"), "-o", str(tmp_path / "mill")])
    assert done.exit_code == 0, done.output
    assert {"cam.txt", "cam-pitch.txt", "cam.dxf", "law.csv"} <= {p.name for p in (tmp_path / "mill").iterdir()}
    assert "read back within" in done.output
    for path in (tmp_path / "mill").iterdir():
        lines = [line.removeprefix("# ").strip() for line in path.read_text().splitlines()[:12]]
        assert {"title: A cam for dwell and return", "date: 1970-01-02", f"program: wucht {version('wucht')}"} <= set(lines)
        assert "cam: original, for a shaft that turns evenly: it makes the law over the cam angle" in lines
        assert "speed: 500 rpm, fluctuating by 13.09 % in orders 2, 3" in lines
        assert "law: harmonic, 5 harmonics, 24.1975 deg from the least to the greatest position" in lines


@pytest.mark.parametrize(("corrected", "warns"), [(None, True), (False, False), (True, False)])
def test_a_contour_says_whether_it_is_the_original_or_the_corrected_cam(corrected, warns):
    """Without the key it is the original one, and a warning names both choices; in report, figure and summary."""
    speed = {"mean": 52.36, "cosine": [0.0, 2.4], "sine": [0.0, 1.0]}
    drive = given.drive(given.SMOOTH, given.FOLLOWER, speed=speed)
    result = run(CamContour(points=36) if corrected is None else CamContour(points=36, corrected=corrected), drive)
    said, other = ("corrected", "original") if corrected else ("original", "corrected")
    warnings = [w for w in result.wucht.warnings if "original" in w]
    assert len(warnings) == warns
    assert all(choice in warnings[0] for choice in ("study.corrected = true", "study.corrected = false", "9.931 %") if warns)
    s = result.wucht.summary
    assert (s["cam_version"], s["speed"], s["corrected"]) == (said, speed, speed if corrected else None)
    assert s["fluctuation"] == pytest.approx(2 * math.hypot(2.4, 1.0) / 52.36)
    text = "\n".join(wucht.report(result))
    assert f"{said} cam" in text and f"{other} cam" not in text
    assert "speed of 500 rpm fluctuates by 9.931 %" in text
    for page in (wucht.PRINT, wucht.JOURNAL):
        labels = {t.get_text() for legend in wucht.draw(result, page).legends for t in legend.get_texts()}
        assert f"contour, {said}" in {" ".join(label.split()) for label in labels}


def test_a_resumed_contour_without_the_key_is_another_question(tmp_path):
    """Else the warning would stay that study.corrected = false removes."""
    drive = given.drive(given.SMOOTH, given.FOLLOWER, speed={"mean": 52.36, "cosine": [2.4]})
    run(CamContour(points=36), drive, folder=tmp_path)
    assert run(CamContour(points=36), drive, folder=tmp_path, resume=True).wucht.warnings
    with refused("--resume", "study.corrected", code="other-question"):
        run(CamContour(points=36, corrected=False), drive, folder=tmp_path, resume=True)


def test_without_a_fluctuating_speed_there_is_one_cam():
    for tables in ({}, {"speed": {"mean": 52.36}}):
        result = run(CamContour(points=36), given.drive(given.SMOOTH, given.FOLLOWER, **tables))
        assert not result.wucht.warnings
        assert result.wucht.summary["cam_version"] == ("original" if tables else None)
        assert ("original" in "\n".join(wucht.report(result))) == bool(tables)


def test_a_study_without_files_for_others_says_so(tmp_path):
    path = tmp_path / "law.toml"
    path.write_text(study_of("cam-law").template)
    with refused("cam-law", "cam-contour and cam-correction", given=None, code="not-exported"):
        wucht.export(run_file(path), tmp_path)


@pytest.mark.slow
def test_without_a_table_speed_the_cam_is_corrected_for_the_predicted_shaft():
    """As if its predicted orders had been given; the carton pusher of the catalogue."""
    pusher = read_study("practice/carton-pusher").subject
    shaft = run(CamPrediction(cuts=0, simulate=0), pusher).wucht.summary["corrected"]["speed"]
    stated = replace(pusher, speed=SpeedTable(**shaft))
    found, given, even = (
        run(CamContour(points=50, corrected=corrected), drive).follower.values
        for drive, corrected in ((pusher, True), (stated, True), (pusher, False))
    )
    assert found == pytest.approx(given, abs=1e-11)
    assert np.abs(found - even).max() > 1e-3


def test_each_file_for_the_workshop_is_a_line(tmp_path):
    """With what was read back: of points in m, of a table in rad, of a law in words."""
    files = [
        WorkshopFile(tmp_path / "cam.txt", "points", 100, 2.5e-6, 5e-6, motion=1.25e-7),
        WorkshopFile(tmp_path / "law.csv", "rows", 3600, math.radians(1e-5), 1e-6, unit="rad"),
    ]
    assert file_lines(files) == [
        f"{tmp_path / 'cam.txt'}  points, 100: read back within 2.5 µm; a follower on it deviates from its law by 1.2e-07",
        f"{tmp_path / 'law.csv'}  rows, 3600: read back within 1.0e-05°",
    ]
