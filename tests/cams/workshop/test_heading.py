"""What files for the workshop say of their cam, in every format, whatever the title has in it."""

import re
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from curves_to_mill import lobes

from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.dxf import read_dxf, write_dxf
from wucht.cams.workshop.heading import Heading
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
    even = ShaftMotion(FourierSeries.of(52.36, [0.0]))
    assert replace(CORRECTED, shaft=even).entries["speed"] == "500.001 rpm, constant"
    assert replace(CORRECTED, title="∞").entries["title"] == "?"


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
