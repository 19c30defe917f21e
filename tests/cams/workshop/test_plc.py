"""Cam tables stay within their tolerance of the law, as the controller interpolates them, with few rows."""

import math
import re

import numpy as np
import pytest
from curves_to_mill import LAW
from tests.refusals import failed, refused

from wucht.cams.workshop.plc import (
    CamTable,
    Form,
    Interpolation,
    SlaveUnit,
    cam_table,
    largest_deviation,
    read_cam_table,
    write_cam_table,
)

LINEAR, QUINTIC = Interpolation.LINEAR, Interpolation.QUINTIC
FINE = np.linspace(0, 2 * math.pi, 77777)


@pytest.mark.parametrize("interpolation", Interpolation)
@pytest.mark.parametrize("unit", SlaveUnit)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-6])
def test_the_tolerance_is_kept_and_made_use_of(interpolation, unit, tolerance):
    table = cam_table(LAW, unit, tolerance, interpolation, decimals=7)
    worst = np.abs(table(FINE) - LAW(FINE)).max()
    assert worst <= tolerance
    assert largest_deviation(table, LAW) == pytest.approx(worst, rel=0.01)
    # Twice as few rows do not keep it: the error falls with the second or the sixth power of their distance.
    assert worst * 2**interpolation.value > tolerance or len(table.phi) == 9
    assert table.interpolation is interpolation


def test_rows_of_linear_interpolation():
    """h^2 max|law''|/8 is the error; the rows are the next number that divides 360 deg into multiples of 0.0001 deg."""
    needed = 2 * math.pi * math.sqrt(np.abs(LAW(FINE, 2)).max() / (8 * 1e-5))
    rows = len(cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR).phi) - 1
    assert needed <= rows < 1.3 * needed
    assert 3_600_000 % rows == 0


def test_as_many_rows_as_the_controller_takes_and_no_more():
    """Both ends of the turn are rows: so many intervals have one row more."""
    rows = len(cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR).phi)
    assert len(cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR, most=rows).phi) == rows
    with refused("tolerance", f"{rows - 1} rows"):
        cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR, most=rows - 1)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_it_is_a_law_with_its_derivatives(order):
    """Differences of the table's own values, and the law's own derivatives."""
    table = cam_table(LAW, SlaveUnit.DEGREE, 1e-9, decimals=10)
    assert np.abs(table(FINE, order) - LAW(FINE, order)).max() <= (1e-9, 1e-7, 1e-5, 1e-2)[order]
    h, at = 1e-4, np.array([0.3, 1.0, 4.0, 6.0])
    if order:
        assert (table(at + h, order - 1) - table(at - h, order - 1)) / (2 * h) == pytest.approx(table(at, order), abs=1e-6)


def test_a_polynomial_of_fifth_degree_is_met_exactly():
    phi = np.array([0.0, 2.0, 2 * math.pi])
    p = np.polynomial.Polynomial([1, -2, 0.5, 0.1, -0.03, 0.004])
    table = CamTable(phi, p(phi), p.deriv()(phi), p.deriv(2)(phi), SlaveUnit.DEGREE, 6)
    at = np.linspace(0, 6.28, 50)
    for order in range(4):
        assert table(at, order) == pytest.approx(p.deriv(order)(at) if order else p(at), abs=1e-12)


def test_straight_lines_between_positions():
    table = CamTable(np.array([0.0, 2.0, 2 * math.pi]), np.array([1.0, 3.0, 1.0]), None, None, SlaveUnit.DEGREE, 6)
    assert table(np.array([0.5, 2.0, 2 * math.pi, -1.0])) == pytest.approx([1.5, 3.0, 1.0, 1 + 2 / (2 * math.pi - 2)])
    assert table(np.array([0.5, 3.0]), 1) == pytest.approx([1.0, -2 / (2 * math.pi - 2)])
    assert table(np.array([[0.5, 3.0]]), 2).tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("unit", SlaveUnit)
def test_the_values_are_those_of_the_file(unit):
    """Rounded in mm or deg; derivatives by the degree, with more decimals."""
    table = cam_table(LAW, unit, 1e-4, decimals=3)
    per, degree = unit.si_factor, math.pi / 180
    for column, order, decimals in ((table.position, 0, 3), (table.velocity, 1, 6), (table.acceleration, 2, 8)):
        shown = column * per * degree**order * 10**decimals
        assert np.abs(shown - np.round(shown)).max() < 1e-5
        assert np.abs(column - LAW(table.phi, order)).max() <= 0.5001 * 10.0**-decimals / (per * degree**order)
    assert table.phi[[0, -1]].tolist() == [0.0, 2 * math.pi]
    assert table.position[0] == table.position[-1]
    assert (SlaveUnit.MILLIMETRE.si_factor, SlaveUnit.DEGREE.si_factor) == (1000.0, pytest.approx(57.29577951308232, rel=1e-15))


def test_it_closes_whichever_way_its_ends_are_rounded():
    """A law that is 170.0000005 mm at 0, by the rounding of floats a little less there and a little more after a turn."""

    def law(phi, order=0):
        return LAW(phi, order) + (np.where(np.asarray(phi) > 6.28, 1e-12, -1e-12) + 5e-10 if order == 0 else 0.0)

    table = cam_table(law, SlaveUnit.MILLIMETRE, 1e-6)
    assert table.position[0] == table.position[-1] == pytest.approx(0.17, abs=1e-10)


def test_derivatives_of_the_table():
    table = cam_table(LAW, SlaveUnit.DEGREE, 1e-6, decimals=8)
    assert largest_deviation(table, LAW, 1) < 1e-4
    assert largest_deviation(table, LAW, 2) < 1e-2


def lifting(phi, order=0):
    return np.asarray(phi, float) if order == 0 else np.full(np.shape(phi), float(order == 1))


def missing(phi, order=0):
    return np.where(np.asarray(phi) > 6, np.nan, LAW(phi, order))


@pytest.mark.parametrize(
    ("change", "refusal"),
    [
        ({"tolerance": 0.0}, refused("tolerance", given=0.0, code="not-positive")),
        ({"tolerance": math.nan}, refused("tolerance", given=float("nan"), code="not-positive")),
        ({"decimals": 13}, refused("decimals", given=13, code="decimals")),
        ({"decimals": 2, "tolerance": 4.9e-6}, refused("decimals", given=2)),
        ({"law": lifting}, refused("law", code="not-periodic")),
        ({"law": missing}, refused("law", code="not-finite")),
        ({"tolerance": 1e-6, "interpolation": LINEAR, "most": 500}, refused("tolerance", "500", given=1e-06)),
    ],
)
def test_what_will_not_do(change, refusal):
    with refusal:
        cam_table(**({"law": LAW, "unit": SlaveUnit.MILLIMETRE, "tolerance": 1e-5} | change))


def test_the_decimals_that_are_advised_will_do():
    with refused("decimals", given=1):
        cam_table(LAW, SlaveUnit.MILLIMETRE, 1e-6, decimals=1)
    assert largest_deviation(cam_table(LAW, SlaveUnit.MILLIMETRE, 1e-6, decimals=3), LAW) <= 1e-6


PAIRS = [
    (Form.CSV, LINEAR),
    (Form.CSV, QUINTIC),
    (Form.TWINCAT, LINEAR),
    (Form.TWINCAT, QUINTIC),
    (Form.CODESYS, QUINTIC),
    (Form.CODESYS_ASCII, LINEAR),
]


def small(interpolation):
    """A table of eight steps of 45 deg, in mm."""
    return cam_table(LAW, SlaveUnit.MILLIMETRE, 0.1, interpolation, decimals=2)


@pytest.mark.parametrize(("form", "interpolation"), PAIRS)
@pytest.mark.parametrize("unit", SlaveUnit)
def test_a_round_trip(tmp_path, form, interpolation, unit):
    table = cam_table(LAW, unit, 1e-6, interpolation)
    there = read_cam_table(write_cam_table(tmp_path / "cam.txt", table, form), form, unit)
    assert there.interpolation is interpolation
    assert there.decimals == 6
    assert there.phi == pytest.approx(table.phi, abs=1e-14)
    assert there.position == pytest.approx(table.position, abs=1e-15)
    if interpolation is QUINTIC:
        assert there.velocity == pytest.approx(table.velocity, abs=1e-14)
        assert there.acceleration == pytest.approx(table.acceleration, abs=1e-13)
    assert largest_deviation(there, LAW) <= 1e-6


def test_codesys_as_its_cam_editor_shows_it(tmp_path):
    text = write_cam_table(tmp_path / "cam.txt", small(QUINTIC), Form.CODESYS, "Cam").read_text()
    assert "{attribute 'linkalways'}\nVAR_GLOBAL\nCam_A: ARRAY[0..8] OF SMC_CAMXYVA := [\n" in text
    row = "(dX := 0.0000, dY := 170.00, dV := 1.04720, dA := -0.0396003)"  # 170 mm, 60 mm/rad, -130 mm/rad^2
    assert f"        {row},\n" in text
    assert text.count("dX :=") == 9
    assert (
        "Cam: MC_CAM_REF := (nElements := 9, byType := 3, xStart := 0, xEnd := 360, nTappets := 0, strCAMName := 'Cam', "
        "pce := ADR(Cam_A), xPartofLM := TRUE);\nEND_VAR\n"
    ) in text


def test_twincat_motion_function(tmp_path):
    text = write_cam_table(tmp_path / "cam.txt", small(QUINTIC), Form.TWINCAT, "Press").read_text()
    assert "Press_A : ARRAY[1..9] OF MC_MotionFunctionPoint := [" in text
    assert "TableType := MC_TABLETYPE_MOTIONFUNCTION" in text
    assert re.findall(r"PointIndex := (\d+)", text) == [str(i) for i in range(1, 10)]
    assert text.count("FunctionType := MC_MotionFunctionType.MOTIONFUNCTYPE_POLYNOM5_MM,") == 9
    assert text.count("PointType := MC_MotionPointType.MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1,") == 9
    assert "MasterPos := 0.0000, SlavePos := 170.00, SlaveVelo := 1.04720, SlaveAcc := -0.0396003, SlaveJerk := 0.0)" in text


def test_twincat_position_table(tmp_path):
    text = write_cam_table(tmp_path / "cam.txt", small(LINEAR), Form.TWINCAT).read_text()
    assert "Cam_A : ARRAY[0..8, 0..1] OF LREAL := [\n    0.0000, 170.00,\n    45.0000, " in text
    assert "    360.0000, 170.00];\nEND_VAR\n" in text
    assert "NoOfRows := 9, NoOfColumns := 2" in text
    assert "TableType := MC_TABLETYPE_EQUIDISTANT" in text


def test_plain_columns(tmp_path):
    lines = write_cam_table(tmp_path / "cam.csv", small(QUINTIC), Form.CSV).read_text().splitlines()
    assert lines[0] == "# cam table Cam: master in deg, slave in mm, quintic interpolation"
    assert lines[1:3] == ["master;slave;velocity;acceleration", "0.0000;170.00;1.04720;-0.0396003"]
    lines = write_cam_table(tmp_path / "cam.txt", small(LINEAR), Form.CODESYS_ASCII).read_text().splitlines()
    assert (lines[0], lines[-1], len(lines)) == ("0.0000 170.00", "360.0000 170.00", 9)


def test_even_spacing_survives_rounding(tmp_path):
    path = write_cam_table(tmp_path / "cam.txt", cam_table(LAW, SlaveUnit.MILLIMETRE, 1e-5, LINEAR), Form.CODESYS_ASCII)
    master = [round(1e4 * float(line.split()[0])) for line in path.read_text().splitlines()]
    assert len(set(np.diff(master))) == 1


@pytest.mark.parametrize(
    ("form", "table", "name", "refusal"),
    [
        (Form.CODESYS, LINEAR, "Cam", refused("form", given="codesys")),
        (Form.CODESYS_ASCII, QUINTIC, "Cam", refused("form", given="codesys-ascii")),
        (Form.CSV, LINEAR, "1st", refused("name", "IEC", "61131", given="1st")),
        (Form.TWINCAT, LINEAR, "Cam; END_VAR", refused("name", given="Cam; END_VAR")),
    ],
)
def test_what_cannot_be_written(tmp_path, form, table, name, refusal):
    with refusal:
        write_cam_table(tmp_path / "cam.txt", small(table), form, name)
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    with failed("not-written", "cam.txt"):
        write_cam_table(tmp_path / "file" / "cam.txt", small(LINEAR), Form.CSV)


@pytest.mark.parametrize(
    ("form", "old", "new", "refusal"),
    [
        (Form.CSV, "170.00;", "17O.00;", refused("cam.txt", "17O.00", code="no-number")),
        (Form.CSV, "170.00;", "nan;", refused("cam.txt", code="not-finite")),
        (Form.CSV, "45.0000;", "95.0000;", refused("cam.txt", "360 deg", code="not-increasing")),
        (Form.CSV, "360.0000;", "359.0000;", refused("cam.txt", "360 deg", code="not-increasing")),
        (Form.CSV, "360.0000;170", "360.0000;171", refused("cam.txt", code="not-closed")),
        (Form.CSV, ";1.04720;", ";", refused("cam.txt", "csv", code="no-table")),
        (Form.CSV, "slave in mm", "slave in deg", refused("cam.txt", "deg", "mm", code="unit")),
        (Form.CODESYS, "dY := 170.00", "dY := none", refused("cam.txt", "7 rows", code="count")),
        (Form.TWINCAT, "SlavePos := 170.00", "SlavePos := none", refused("cam.txt", "7 rows", code="count")),
    ],
)
def test_a_damaged_table(tmp_path, form, old, new, refusal):
    path = write_cam_table(tmp_path / "cam.txt", small(QUINTIC), form)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with refusal:
        read_cam_table(path, form, SlaveUnit.MILLIMETRE)


def test_a_position_table_that_lost_a_number(tmp_path):
    path = write_cam_table(tmp_path / "cam.txt", small(LINEAR), Form.TWINCAT)
    path.write_text(path.read_text().replace("360.0000, 170.00]", "360.0000]"))
    with refused("cam.txt", "8 rows", code="count"):
        read_cam_table(path, Form.TWINCAT, SlaveUnit.MILLIMETRE)


@pytest.mark.parametrize("form", Form)
def test_no_table_at_all(tmp_path, form):
    with refused("", code="no-file", file="cam.txt"):
        read_cam_table(tmp_path / "cam.txt", form, SlaveUnit.DEGREE)
    (tmp_path / "cam.txt").write_text("\n")
    with refused("cam.txt", form.value, code="no-table"):
        read_cam_table(tmp_path / "cam.txt", form, SlaveUnit.DEGREE)


def test_the_columns_of_positions_alone_are_named(tmp_path):
    lines = write_cam_table(tmp_path / "cam.csv", small(LINEAR), Form.CSV).read_text().splitlines()
    assert lines[1:3] == ["master;slave", "0.0000;170.00"]
