"""CAD files come back within the tolerance, in millimetres, closed."""

import sys

import numpy as np
import pytest
from curves_to_mill import CURVES, broken, ellipse, lobes
from tests.refusals import failed, refused

from wucht.cams.workshop.closed_curve import curve_distances, fitted_spline, spline_deviation
from wucht.cams.workshop.dxf import CONTOUR, CONTOUR_SPLINE, PITCH, PITCH_SPLINE, read_back, read_dxf, write_dxf
from wucht.cams.workshop.points import chord_deviation, chord_points

PITCH_CURVE = ellipse(0.06, 0.06)
TOLERANCE = 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("name", CURVES)
def test_a_round_trip_within_the_tolerance(tmp_path, name):
    write_dxf(tmp_path / "cam.dxf", CURVES[name], TOLERANCE, PITCH_CURVE)
    there = read_back(tmp_path / "cam.dxf", CURVES[name], PITCH_CURVE)
    assert list(there) == [CONTOUR, CONTOUR_SPLINE, PITCH, PITCH_SPLINE]
    drawn = list[tuple[int, float]]()
    for curve in (CURVES[name], PITCH_CURVE):
        points, spline = chord_points(curve, TOLERANCE), fitted_spline(curve, TOLERANCE)
        drawn.append((len(points.phi), chord_deviation(curve, points.phi)))
        drawn.append((spline.pieces, spline_deviation(curve, spline)))
    for (count, deviation), (count_read, deviation_read) in zip(drawn, there.values(), strict=True):
        assert count_read == count and deviation <= TOLERANCE
        assert 0.3 * deviation < deviation_read <= 1.001 * deviation
    assert read_back(tmp_path / "cam.dxf", CURVES[name])[CONTOUR][0] == drawn[0][0]


def test_the_header_has_the_extents_of_all_lines(tmp_path):
    """Of the contour alone those of many of its points; with a roller on the pitch curve beside it the roller's, too."""
    import ezdxf

    write_dxf(tmp_path / "cam.dxf", lobes, TOLERANCE)
    header, points = ezdxf.readfile(tmp_path / "cam.dxf").header, 1e3 * lobes(np.linspace(0, 2 * np.pi, 200_001))
    assert tuple(header["$EXTMIN"]) == pytest.approx((points.real.min(), points.imag.min(), 0), abs=1.1e-3)
    assert tuple(header["$EXTMAX"]) == pytest.approx((points.real.max(), points.imag.max(), 0), abs=1.1e-3)
    write_dxf(tmp_path / "cam.dxf", lobes, TOLERANCE, PITCH_CURVE, base_radius=0.045, roller_radius=0.01)
    document = ezdxf.readfile(tmp_path / "cam.dxf")
    assert tuple(document.header["$EXTMAX"]) == pytest.approx((70, 60, 0), abs=1.1e-3)
    assert tuple(document.header["$EXTMIN"]) == pytest.approx((-60, -60, 0), abs=1.1e-3)
    assert tuple(document.modelspace().dxf.extmax) == tuple(document.header["$EXTMAX"])


def test_as_a_cad_program_sees_it(tmp_path):
    """ezdxf evaluates the spline itself; the file has no faults; its unit is the millimetre."""
    import ezdxf

    write_dxf(tmp_path / "cam.dxf", lobes, TOLERANCE, PITCH_CURVE, base_radius=0.045, roller_radius=0.01)
    document = ezdxf.readfile(tmp_path / "cam.dxf")
    assert document.header["$INSUNITS"] == 4
    assert document.header["$MEASUREMENT"] == 1
    assert document.audit().errors == []
    spline = next(s for s in document.modelspace().query("SPLINE") if s.dxf.layer == CONTOUR_SPLINE)
    assert spline.closed
    assert spline.dxf.degree == 3
    seen = np.array([complex(v.x, v.y) for v in spline.construction_tool().approximate(5000)]) / 1e3
    assert curve_distances(lobes, seen).max() <= TOLERANCE
    assert np.abs(seen).max() == pytest.approx(0.055, rel=1e-6)


def test_without_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    for ask in (lambda: write_dxf(tmp_path / "cam.dxf", lobes, TOLERANCE), lambda: read_dxf(tmp_path / "cam.dxf")):
        with refused("dxf", "DXF", "wucht[cad]", given=None):
            ask()


@pytest.mark.parametrize(
    ("change", "refusal"),
    [
        ({"tolerance": 0.0}, refused("tolerance", given=0.0, code="not-positive")),
        ({"contour": broken}, refused("curve", code="not-finite")),
        ({"roller_radius": 0.01}, refused("roller_radius", given=0.01)),
    ],
)
def test_what_cannot_be_drawn(tmp_path, change, refusal):
    with refusal:
        write_dxf(tmp_path / "cam.dxf", **({"contour": lobes, "tolerance": TOLERANCE} | change))
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    with failed("not-written", "cam.dxf"):
        write_dxf(tmp_path / "file" / "cam.dxf", lobes, 1e-4)


def test_what_cannot_be_read(tmp_path):
    import ezdxf

    path = tmp_path / "cam.dxf"
    with refused("cam.dxf", code="no-file"):
        read_dxf(path)
    for content in (b"no drawing", b"\x00\xff\xfe" * 100, b""):
        path.write_bytes(content)
        with refused("cam.dxf", "DXF", given=None, code="unreadable"):
            read_dxf(path)
    ezdxf.new(units=6).saveas(path)
    with refused("cam.dxf", code="unit"):
        read_dxf(path)
    ezdxf.new(units=4).saveas(path)
    with refused("cam.dxf", "CONTOUR", given=None, code="no-layers"):
        read_back(path, lobes)
