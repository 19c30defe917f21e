"""What files for the workshop say of their cam, in every format, whatever the title has in it."""

import re
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from curves_to_mill import LAW, lobes

from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.dxf import read_dxf, write_dxf
from wucht.cams.workshop.heading import Heading, speed_in_words
from wucht.cams.workshop.lists import read_list, write_list
from wucht.cams.workshop.plc import Form, Interpolation, SlaveUnit, cam_table, read_cam_table, write_cam_table
from wucht.cams.workshop.points import chord_points
from wucht.numerics.fourier_series import FourierSeries

SHAFT = ShaftMotion(FourierSeries.of(52.36, [0, 2.4, 0], [0, 1, 0.5]))
HOSTILE = "Stößel*) (* 5 µm\n# points: 3\n999; ARRAY[0..1] slave in mm (dX := 1, dY := 2, dV := 3, dA := 4)"
CORRECTED = Heading(HOSTILE, "3-4-5, 10 mm", SHAFT, True, datetime(2001, 2, 3, 4, tzinfo=UTC), "1.2")
NAMES = ("title", "cam", "law", "speed", "date", "program")


def test_the_lines_are_plain_and_say_which_cam_it_is():
    entries = CORRECTED.entries
    assert tuple(entries) == NAMES
    assert entries["title"].startswith("Stoessel) ( 5 um # points: 3 999; ARRAY")
    assert entries["cam"].startswith("corrected, ")
    assert entries["speed"] == "500.001 rpm, fluctuating by 11.42 % in orders 2, 3"
    assert (entries["date"], entries["program"]) == ("2001-02-03", "wucht 1.2")
    assert replace(CORRECTED, is_corrected=False).entries["cam"].startswith("original, ")
    alone = replace(CORRECTED, is_corrected=False, shaft=None)
    assert (alone.cam_version, alone.entries["speed"]) == ("", "not stated")
    assert alone.entries["cam"] == "for a shaft that turns evenly"
    assert replace(CORRECTED, title="∞").entries["title"] == "?"


def test_a_constant_speed_in_words():
    assert speed_in_words(ShaftMotion(FourierSeries.of(52.36, [0.0]))) == "500.001 rpm, constant"
    fluctuation = np.ptp(SHAFT.speed(np.linspace(0, 2 * np.pi, 100_001))) / 52.36
    assert f"by {100 * fluctuation:.4g} %" in speed_in_words(SHAFT)


def test_a_list_says_it_and_is_read_as_without(tmp_path):
    points = chord_points(lobes, 1e-5)
    bare = read_list(write_list(tmp_path / "bare.txt", points, "contour"))
    path = write_list(tmp_path / "cam.txt", points, "contour", heading=CORRECTED)
    said = read_list(path)
    assert path.read_text().splitlines()[1:7] == [f"# {name}: {text}" for name, text in CORRECTED.entries.items()]
    assert (said.position == bare.position).all() and said.content == bare.content


@pytest.mark.parametrize("form", [Form.CSV, Form.TWINCAT, Form.CODESYS])
def test_a_cam_table_says_it_in_a_comment_and_is_read_as_without(tmp_path, form):
    table = cam_table(LAW, SlaveUnit.DEGREE, 1e-5)
    bare = read_cam_table(write_cam_table(tmp_path / "bare", table, form), form, SlaveUnit.DEGREE)
    path = write_cam_table(tmp_path / "table", table, form, heading=CORRECTED)
    said = read_cam_table(path, form, SlaveUnit.DEGREE)
    assert (said.position == bare.position).all() and len(said.phi) == len(table.phi)
    comment = path.read_text().split("*)" if form is not Form.CSV else "\nmaster")[0]
    assert comment.startswith("#" if form is Form.CSV else "(*")
    assert all(f"{name}: {text}" in comment for name, text in CORRECTED.entries.items())


def test_the_ascii_table_is_numbers_alone(tmp_path):
    table = cam_table(LAW, SlaveUnit.DEGREE, 1e-3, Interpolation.LINEAR)
    path = write_cam_table(tmp_path / "table", table, Form.CODESYS_ASCII, heading=CORRECTED)
    assert np.loadtxt(path).shape == (len(table.phi), 2)


def test_a_drawing_says_it_before_its_header_and_equal_ones_are_equal(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    from ezdxf.tools.juliandate import calendardate

    for name in ("a.dxf", "b.dxf"):
        write_dxf(tmp_path / name, lobes, 1e-5, heading=CORRECTED)
    write_dxf(tmp_path / "later.dxf", lobes, 1e-5, heading=replace(CORRECTED, date=datetime(2002, 2, 3, tzinfo=UTC)))
    text = (tmp_path / "a.dxf").read_text()
    assert text.startswith("".join(f"999\n{name}: {said}\n" for name, said in CORRECTED.entries.items()) + "  0\nSECTION\n")
    assert text == (tmp_path / "b.dxf").read_text() != (tmp_path / "later.dxf").read_text()
    document = ezdxf.readfile(tmp_path / "a.dxf")
    assert document.audit().errors == []
    dates = re.findall(r"\$TDU?(?:CREATE|UPDATE)\n *40\n(.*)\n", text)  # ezdxf replaces one of them when it reads
    assert [calendardate(float(date)) for date in dates] == [datetime(2001, 2, 3, 4)] * 4
    assert set(read_dxf(tmp_path / "a.dxf")[0]) == {"CONTOUR"}
