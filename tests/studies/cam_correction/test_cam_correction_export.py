"""The exported files of a correction are those of the corrected cam: the same as those of a contour that is corrected."""

import math

import numpy as np
import pytest
from known_cam import LAW, SHAFT
from tests.refusals import refused

import wucht
from wucht import CamContour, CamCorrection, load, run
from wucht.cams.correction import CorrectedLaw
from wucht.cams.drive import cam_drive_from
from wucht.cams.workshop.lists import read_list
from wucht.cams.workshop.plc import Form, SlaveUnit, read_cam_table

pytestmark = pytest.mark.usefixtures("coarse_angles")

TABLES = {
    "law": {"kind": "harmonic", "coefficients": {"mean": LAW.mean, "cosine": [*LAW.cosine], "sine": [*LAW.sine]}},
    "speed": {"mean": SHAFT.mean, "cosine": [*SHAFT.speed.cosine], "sine": [*SHAFT.speed.sine]},
}
FOLLOWER = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": math.radians(-135)}


@pytest.fixture(scope="module")
def drive():
    return cam_drive_from(TABLES | {"follower": FOLLOWER}, "A drive", None)


@pytest.mark.slow
def test_it_is_the_corrected_cam_of_the_contour(drive, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    keys = {"points": 36, "chord_tolerance": "100 um", "decimals": 4}
    run(CamCorrection(**keys), drive, folder=tmp_path / "correction")
    lines = wucht.export(load(tmp_path / "correction"), tmp_path / "mill")
    wucht.export(run(CamContour(**keys, corrected=True), drive), tmp_path / "same")
    files = sorted(path.name for path in (tmp_path / "mill").iterdir())
    assert {"cam.txt", "cam-pitch.txt", "law.csv", "law.TcGVL.txt", "law.codesys.txt"} <= set(files)
    assert len(lines) == len(files) == len(list((tmp_path / "same").iterdir()))
    assert all("of the corrected cam" in line for line in lines)
    for name in files:
        assert (tmp_path / "mill" / name).read_text() == (tmp_path / "same" / name).read_text(), name
    listed = read_list(tmp_path / "mill" / "cam.txt")
    cam = drive.make_cams(CorrectedLaw(LAW, SHAFT))["cam"]
    assert np.abs(listed.position - cam.contour(listed.phi)).max() < 1e-7 * math.sqrt(2) / 2 * 1.001
    assert np.abs(listed.position - drive.make_cams(LAW)["cam"].contour(listed.phi)).max() > 1e-4
    assert listed.tolerance == pytest.approx(100e-6)


def test_without_a_follower_there_are_tables_alone(tmp_path):
    result = run(CamCorrection(points=36), cam_drive_from(TABLES, "A law", None))
    wucht.export(result, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["law.TcGVL.txt", "law.codesys.txt", "law.csv"]
    table = read_cam_table(tmp_path / "law.csv", Form.CSV, SlaveUnit.DEGREE)
    phi = np.linspace(0, 2 * math.pi, 1001)
    stroke = float(np.ptp(LAW(phi)))
    assert np.abs(table(phi) - CorrectedLaw(LAW, SHAFT)(phi)).max() < 1.1e-5 * stroke
    assert np.abs(table(phi) - LAW(phi)).max() > 1e-2 * stroke


def test_a_changed_contour_is_refused(drive, tmp_path):
    result = run(CamCorrection(points=36), drive)
    result["contour_x"] = result.contour_x + 1e-6
    with refused("result", given=None, code="deviates"):
        wucht.export(result, tmp_path)
