"""Cam tables stay within their tolerance of the law, as the controller interpolates them, with few rows."""

import math
import re

import numpy as np
import pytest
from curves_to_mill import LAW
from tests.refusals import refused

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


def test_as_many_rows_as_the_controller_takes_and_no_more():
    """Both ends of the turn are rows: so many intervals have one row more."""
    rows = len(cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR).phi)
    assert len(cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR, most=rows).phi) == rows
    with refused("tolerance", f"{rows - 1} rows"):
        cam_table(LAW, SlaveUnit.DEGREE, 1e-5, LINEAR, most=rows - 1)


def test_a_polynomial_of_fifth_degree_is_met_exactly():
    phi = np.array([0.0, 2.0, 2 * math.pi])
    p = np.polynomial.Polynomial([1, -2, 0.5, 0.1, -0.03, 0.004])
    table = CamTable(phi, p(phi), p.deriv()(phi), p.deriv(2)(phi), SlaveUnit.DEGREE, 6)
    at = np.linspace(0, 6.28, 50)
    for order in range(4):
        assert table(at, order) == pytest.approx(p.deriv(order)(at) if order else p(at), abs=1e-12)


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


def lifting(phi, order=0):
    return np.asarray(phi, float) if order == 0 else np.full(np.shape(phi), float(order == 1))


def missing(phi, order=0):
    return np.where(np.asarray(phi) > 6, np.nan, LAW(phi, order))


@pytest.mark.parametrize(
    ("change", "refusal"),
    [
        ({"tolerance": 0.0}, refused("tolerance", given=0.0, code="not-positive")),
        ({"decimals": 2, "tolerance": 4.9e-6}, refused("decimals", given=2)),
        ({"law": lifting}, refused("law", code="not-periodic")),
        ({"law": missing}, refused("law", code="not-finite")),
        ({"tolerance": 1e-6, "interpolation": LINEAR, "most": 500}, refused("tolerance", "500", given=1e-06)),
    ],
)
def test_what_will_not_do(change, refusal):
    with refusal:
        cam_table(**({"law": LAW, "unit": SlaveUnit.MILLIMETRE, "tolerance": 1e-5} | change))


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


@pytest.mark.parametrize(
    ("form", "old", "new", "refusal"),
    [
        (Form.CSV, "170.00;", "17O.00;", refused("cam.txt", "17O.00", code="no-number")),
        (Form.CSV, "45.0000;", "95.0000;", refused("cam.txt", "360 deg", code="not-increasing")),
        (Form.CSV, "360.0000;170", "360.0000;171", refused("cam.txt", code="not-closed")),
        (Form.CSV, ";1.04720;", ";", refused("cam.txt", "csv", code="no-table")),
        (Form.CSV, "slave in mm", "slave in deg", refused("cam.txt", "deg", "mm", code="unit")),
    ],
)
def test_a_damaged_table(tmp_path, form, old, new, refusal):
    path = write_cam_table(tmp_path / "cam.txt", small(QUINTIC), form)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with refusal:
        read_cam_table(path, form, SlaveUnit.MILLIMETRE)
