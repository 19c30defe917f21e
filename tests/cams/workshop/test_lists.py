"""Lists of points come back as they were written, to half of the last decimal."""

import math

import numpy as np
import pytest
from curves_to_mill import CURVES, ellipse, lobes
from tests.refusals import failed, refused

from wucht.cams.workshop.lists import Separator, format_decimals, read_list, write_ascii, write_list
from wucht.cams.workshop.points import PointList, chord_points, even_points

ALL = ("phi", "x", "y", "nx", "ny")
HALF = 0.5 + 1e-6


@pytest.mark.parametrize("separator", Separator)
@pytest.mark.parametrize("decimals", [0, 3, 6])
def test_a_round_trip(tmp_path, separator, decimals):
    points = chord_points(lobes, 1e-6)
    path = write_list(tmp_path / "cam.txt", points, "contour", ALL, separator, decimals, tolerance=1e-6)
    there = read_list(path)
    mm, last = 1e-3 * 10.0**-decimals, 10.0 ** -(decimals + 3)
    off = there.position - points.position
    assert np.abs(off.real).max() <= HALF * mm
    assert np.abs(off.imag).max() <= HALF * mm
    assert np.abs(np.degrees(there.phi - points.phi)).max() <= HALF * last
    assert np.abs(there.normal - points.normal).max() <= math.sqrt(2) * HALF * last
    assert (there.content, there.decimals, there.tolerance) == ("contour", decimals, pytest.approx(1e-6, rel=1e-12))


def test_what_stands_in_the_file(tmp_path):
    path = write_list(tmp_path / "cam.txt", even_points(ellipse(), 4), "pitch curve", ("phi", "x", "y"), Separator.SEMICOLON, 2)
    assert path.read_text() == (
        "# wucht point list: pitch curve\n"
        "# unit: mm, angles in deg, normals of length 1\n"
        "# sense: counter-clockwise\n"
        "# points: 4, closed, the first one not repeated\n"
        "# chord tolerance: not stated\n"
        "# decimals: 2\n"
        "# columns: phi x y\n"
        "0.00000;50.00;0.00\n"
        "90.00000;0.00;50.00\n"
        "180.00000;-50.00;0.00\n"
        "270.00000;0.00;-50.00\n"
    )
    there = read_list(path)
    assert (there.content, there.tolerance, there.normal) == ("pitch curve", None, None)
    assert there.position == pytest.approx(0.05 * np.array([1, 1j, -1, -1j]), abs=1e-18)


@pytest.mark.parametrize("name", CURVES)
def test_the_sense_is_stated(tmp_path, name):
    there = read_list(write_list(tmp_path / "cam.txt", chord_points(CURVES[name], 1e-4), "contour"))
    assert there.clockwise == name.startswith("clockwise")
    assert there.phi is None


POINTS = even_points(ellipse(), 5)


@pytest.mark.parametrize(
    ("change", "refusal"),
    [
        ({"decimals": 13}, refused("decimals", "12", given=13, code="decimals")),
        ({"tolerance": 0.0}, refused("tolerance", given=0.0, code="not-positive")),
        ({"content": "a\nb"}, refused("content", given="a\nb")),
        ({"content": "Außenkontur"}, refused("cam.txt", "ASCII", given=None)),
        ({"columns": ("x", "y", "x")}, refused("columns", given=["x", "y", "x"])),
        ({"points": PointList(POINTS.phi[:4], POINTS.position, POINTS.normal)}, refused("points.phi", given=None)),
    ],
)
def test_what_cannot_be_written(tmp_path, change, refusal):
    with refusal:
        write_list(tmp_path / "cam.txt", **({"points": POINTS, "content": "contour"} | change))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "refusal"),
    [
        ("# sense: counter-clockwise\n", "", refused("cam.txt", code="header")),
        ("50.0000 0.0000 1.0000000 0.0000000\n", "", refused("cam.txt", code="count")),
        ("50.0000 0.0000 1.0000000 0.0000000\n", "50.0000 0.0000\n", refused("cam.txt", code="count")),
        ("50.0000 0.0000", "nan 0.0000", refused("cam.txt", code="count")),
        ("50.0000 0.0000", "5O.0000 0.0000", refused("cam.txt", code="no-number")),
    ],
)
def test_a_damaged_list(tmp_path, old, new, refusal):
    path = write_list(tmp_path / "cam.txt", POINTS, "contour")
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with refusal:
        read_list(path)


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file" / "a.txt", tmp_path / "missing" / "a.txt"):
        with failed("not-written"):
            write_ascii(path, "x")
    (tmp_path / "folder").mkdir()
    with failed("not-written"):
        write_ascii(tmp_path / "folder", "x")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


def test_decimals_without_a_negative_zero():
    assert format_decimals(np.array([-0.0004, 1.0005, -2.0]), 3) == ["0.000", "1.000", "-2.000"]
    assert format_decimals(np.array([2.6]), 0) == ["3"]
