"""From a result to the files of the workshop and back; the command line, and templates."""

from __future__ import annotations

import math
from importlib.util import find_spec
from pathlib import Path

import cam_files_to_study as given
import numpy as np
import pytest
from tests import refusals

from wucht import CamContour, load, run, run_file
from wucht.cams.laws import Law
from wucht.cams.workshop.lists import read_list
from wucht.cams.workshop.plc import Form, SlaveUnit, read_cam_table
from wucht.studies.cam_contour.export import drive_of, points_to_mill, write_workshop
from wucht.studies.registry import studies

needs_ezdxf = pytest.mark.skipif(find_spec("ezdxf") is None, reason="the extra [cad] is not installed")


@pytest.mark.slow
def test_lists_and_tables_of_a_pair(tmp_path: Path) -> None:
    follower = given.FOLLOWER | {"counter": given.COUNTER}
    run(CamContour(chord_tolerance="5 um"), given.drive(given.FIVE, follower), folder=tmp_path / "run")
    result = load(tmp_path / "run" / "result.nc")
    files = {f.path.name: f for f in write_workshop(result, tmp_path / "mill")}
    assert {name for name in files if not name.endswith(".dxf")} == {
        "cam.txt", "cam-pitch.txt", "counter.txt", "counter-pitch.txt", "law.csv", "law.TcGVL.txt", "law.codesys.txt",
    }  # fmt: skip
    assert {p.name for p in (tmp_path / "mill").iterdir()} == set(files)
    for name in ("cam", "counter"):
        read, points = read_list(tmp_path / "mill" / f"{name}.txt"), points_to_mill(result, name)
        assert np.abs(read.position - points.position).max() <= 0.5e-8 * math.sqrt(2) * 1.001
        assert read.normal is not None
        assert np.abs(read.normal - points.normal).max() < 1e-7
        assert read.tolerance == pytest.approx(5e-6)
        written = files[f"{name}.txt"]
        assert 2.5e-6 < written.deviation <= written.allowed_deviation < 5.01e-6
        assert written.motion is not None
        assert written.motion < 1e-6, "rad, of the lever on a spline through the points that were read"
        assert written.count == len(points.phi)
    law: Law = drive_of(result).motion_law.function
    table = read_cam_table(tmp_path / "mill" / "law.TcGVL.txt", Form.TWINCAT, SlaveUnit.DEGREE)
    phi = np.linspace(0, 2 * math.pi, 5001)
    assert np.abs(table(phi) - law(phi)).max() <= files["law.csv"].allowed_deviation < 1e-5 * math.radians(24.5)


@pytest.mark.slow
@needs_ezdxf
def test_drawings_of_a_rod_and_a_groove(tmp_path: Path) -> None:
    groove = given.FOLLOWER | {"groove": True}
    for law, follower, drawn in (
        (given.MODIFIED_SINE, given.ROD, ["cam.dxf"]),
        (given.SMOOTH, groove, ["cam.dxf", "outer.dxf"]),
    ):
        folder = tmp_path / str(follower["kind"])
        result = run(CamContour(chord_tolerance="20 um"), given.drive(law, follower))
        files = write_workshop(result, folder)
        assert sorted(f.path.name for f in files if f.path.suffix == ".dxf") == drawn
        assert all(f.deviation <= f.allowed_deviation * (1 + 1e-6) for f in files)
        motions = [f.motion for f in files if f.motion is not None]
        assert len(motions) == len(drawn)
        assert max(motions) < 5e-6
        assert files[-1].path.name == "law.codesys.txt"
        assert files[-1].unit == ("m" if follower is not groove else "rad")


def test_what_cannot_be_milled_is_refused(tmp_path: Path) -> None:
    cut = run(CamContour(allow_undercut=True), given.drive(given.MODIFIED_SINE, given.FLAT | {"distance": "2 mm"}))
    with refusals.refused("result", code="no-points"):
        write_workshop(cut, tmp_path)
    result = run(CamContour(), given.drive(given.MODIFIED_SINE, given.FLAT))
    result["mill_x"] = result.mill_x + 1e-6
    with refusals.refused("result", code="deviates"):
        write_workshop(result, tmp_path)
    with refusals.refused("cam", given="counter"):
        points_to_mill(result, "counter")
    assert list(tmp_path.iterdir()) == []


def template() -> str:
    text = studies()["cam-contour"].template
    assert text is not None
    return text


def test_pressure_needs_a_width(here: Path) -> None:
    text = template().replace(', width = "12 mm"', "").replace("least_radius =", "contact_pressure = 1e9, least_radius =", 1)
    Path("cam.toml").write_text(text, encoding="utf-8")
    with refusals.refused("study.permitted.contact_pressure", given=None, file="cam.toml"):
        run_file("cam.toml")


def test_no_follower_no_contour(here: Path) -> None:
    text = template()
    Path("cam.toml").write_text(text[: text.index("[follower]")], encoding="utf-8")
    with refusals.refused("follower", given=None, code="missing"):
        run_file("cam.toml")
