"""The files of a contour for the workshop, from the command line and from Python, of the cam that was corrected too."""

import math
from dataclasses import replace
from importlib.metadata import version

import cam_files_to_study as given
import numpy as np
import pytest
from tests.refusals import refused

import wucht
from wucht import CamContour, CamPrediction, run, run_file
from wucht.cams.tables.speed import SpeedTable
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


def test_without_the_shaft_there_is_no_correction(file):
    with refused("speed", given=None, code="missing"):
        plain = file.parent / "plain.toml"
        plain.write_text(study_of("cam-contour").template)
        run_file(plain, {"study.corrected": True})


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


@pytest.mark.slow
@pytest.mark.parametrize(("corrected", "version"), [(None, "original"), (False, "original"), (True, "corrected")])
def test_a_contour_says_whether_it_is_the_original_or_the_corrected_cam(corrected, version):
    """Without the key it is the original one, and a warning names both choices."""
    speed = {"mean": 52.36, "cosine": [0.0, 2.4], "sine": [0.0, 1.0]}
    drive = given.drive(given.SMOOTH, given.FOLLOWER, speed=speed)
    result = run(CamContour(points=36) if corrected is None else CamContour(points=36, corrected=corrected), drive)
    assert sum("study.corrected = true" in w for w in result.wucht.warnings) == (corrected is None)
    s = result.wucht.summary
    assert (s["cam_version"], s["speed"], s["corrected"]) == (version, speed, speed if corrected else None)
    assert s["fluctuation"] == pytest.approx(2 * math.hypot(2.4, 1.0) / 52.36)
    assert f"{version} cam" in "\n".join(wucht.report(result)) and wucht.draw(result).axes


@pytest.mark.parametrize(("tables", "version"), [({}, None), ({"speed": {"mean": 52.36}}, "original")])
def test_without_a_fluctuating_speed_there_is_one_cam(tables, version):
    result = run(CamContour(points=36), given.drive(given.SMOOTH, given.FOLLOWER, **tables))
    assert not result.wucht.warnings and result.wucht.summary["cam_version"] == version


def test_files_are_read_back_and_carry_what_they_are_of(file, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    lines = wucht.export(run_file(file, {"study.chord_tolerance": "50 um", "study.corrected": False}), tmp_path)
    assert {"cam.txt", "cam-pitch.txt", "law.csv"} <= {p.name for p in tmp_path.iterdir()}
    assert len(lines) == len([*tmp_path.iterdir()]) and all("read back within" in line for line in lines)
    for path in tmp_path.iterdir():
        heads = [line.removeprefix("# ").strip() for line in path.read_text().splitlines()[:12]]
        assert {"title: A cam for dwell and return", "date: 1970-01-02", f"program: wucht {version('wucht')}"} <= set(heads)
        assert "speed: 500 rpm, fluctuating by 13.09 % in orders 2, 3" in heads
    with refused("cam-law", "cam-contour and cam-correction", given=None, code="not-exported"):
        wucht.export(run_file(file, {"study.kind": "cam-law"}), tmp_path)
