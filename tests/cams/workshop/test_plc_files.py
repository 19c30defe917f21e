"""Files of cam tables come back as the same table, and look as the manuals show them."""

import re

import numpy as np
import pytest
from curves_to_mill import LAW
from tests.refusals import failed, refused

from wucht.cams.workshop.plc import Interpolation, Unit, cam_table, largest_deviation
from wucht.cams.workshop.plc_files import Form, read_cam_table, write_cam_table

LINEAR, QUINTIC = Interpolation.LINEAR, Interpolation.QUINTIC
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
    return cam_table(LAW, Unit.MILLIMETRE, 0.1, interpolation, decimals=2)


@pytest.mark.parametrize(("form", "interpolation"), PAIRS)
@pytest.mark.parametrize("unit", Unit)
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
    path = write_cam_table(tmp_path / "cam.txt", cam_table(LAW, Unit.MILLIMETRE, 1e-5, LINEAR), Form.CODESYS_ASCII)
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
        read_cam_table(path, form, Unit.MILLIMETRE)


def test_a_position_table_that_lost_a_number(tmp_path):
    path = write_cam_table(tmp_path / "cam.txt", small(LINEAR), Form.TWINCAT)
    path.write_text(path.read_text().replace("360.0000, 170.00]", "360.0000]"))
    with refused("cam.txt", "8 rows", code="count"):
        read_cam_table(path, Form.TWINCAT, Unit.MILLIMETRE)


@pytest.mark.parametrize("form", Form)
def test_no_table_at_all(tmp_path, form):
    with refused("", code="no-file", file="cam.txt"):
        read_cam_table(tmp_path / "cam.txt", form, Unit.DEGREE)
    (tmp_path / "cam.txt").write_text("\n")
    with refused("cam.txt", form.value, code="no-table"):
        read_cam_table(tmp_path / "cam.txt", form, Unit.DEGREE)
