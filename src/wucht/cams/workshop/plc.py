"""Cam tables of controllers: a motion law as slave positions over the master positions of a turn; and their files.

The terms are those of PLCopen (Motion Control): the table is handed to MC_CamTableSelect, with Periodic := TRUE, and MC_CamIn
couples the slave axis to the master axis by it. Between the rows the controller interpolates; a table is judged by the outcome.

Documented, and not documented:

TwinCAT 3 (TF5050, library Tc2_MC2_Camming): MC_CamTableSelect takes an MC_CAM_REF that points to an array in the PLC, either a
position table of two columns of LREAL, master and slave, ascending, or a motion function, an array of MC_MotionFunctionPoint.
Both are written as declarations, to be pasted into a global variable list, and linear interpolation is the default of position
tables. Sources: infosys.beckhoff.com/content/1033/tf5050_tc3_nc_camming, pages 1003586955 (MC_CAM_REF), 1003721995
(MC_MotionFunctionPoint), 1003744011 (MC_MotionFunctionType: 15 is the polynomial of order 5, motion to motion), 1003709323
(MC_InterpolationType); in /content/1031/ 1003758987 (MC_MotionPointType), 1003794571 (MC_TableType). Left open there: the units
of SlaveVelo and SlaveAcc. The page calls them Y' and Y'' over X, and so they are written: derivatives by the master position.
Left open too is RelIndexNextPoint of the last point: 1 here, as "usually" (others write 0). What the Cam Design Tool (TE1510)
imports is not publicly documented and is not claimed.

CODESYS SoftMotion: the type XYVA of MC_CAM_REF, an array of SMC_CAMXYVA with polynomials of fifth degree between, is written
in the layout that the cam editor's "Display Generated Code" shows. Sources: content.helpme-codesys.com/en/CODESYS SoftMotion,
_sm_cmd_cam_display_generated_code; libs/SM3_Basic/Current, MC_CAM_REF and SMC_CAM_TYPE; derivatives by the master position:
SMC_CamTableEvaluate and the default cam, V = 1 from (120, 120) to (240, 240). The ASCII table (TXT) is read by "Read Cam Data
from ASCII Table" as X/Y values at equal distances of X; the page (_sm_cmd_cam_read_data_from_ascii_table) does not say what
separates them: a blank here. The editor lays polynomials of fifth degree through them; a deviation computed for straight
lines holds only where the table is used without them. The layout of .CAM files is not published; none is written.

CSV is ours: master;slave, and velocity;acceleration by the degree of the master, under a line of names.

Each begins with what its cam is, as a comment; but the ASCII table, of which no comment is documented.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from wucht.cams.demands import require_decimals, require_finite, require_positive
from wucht.cams.laws import Law
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.lists import format_decimals, write_ascii
from wucht.errors import InputError
from wucht.files.documents import read_text

MOST_ROWS = 32767  # nElements of CODESYS' MC_CAM_REF is an INT
MASTER_DECIMALS = 4  # of degrees: steps are whole multiples of 0.0001 deg, so that even spacing survives rounding
VELOCITY_FINER, ACCELERATION_FINER = 3, 5  # decimals more than the slave position has
_FEWEST = 8
_BETWEEN = 16  # parts of each interval at which the table is compared with the law; the middle is one
_SAMPLES = 2048
_SHARE = 0.99  # of the tolerance is used: between the samples lies at most 0.4 % more
_CLOSURE = 1e-9  # of the law's range: by how much it may differ after a turn
_DEGREE = math.pi / 180
_TURN = 2 * math.pi
_WHOLE = 1e-9  # deg
_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")  # IEC 61131-3
_NUMBER = r"([-+]?[0-9][0-9.eE+-]*)"
_MOTION = rf"MasterPos := {_NUMBER}, SlavePos := {_NUMBER}, SlaveVelo := {_NUMBER}, SlaveAcc := {_NUMBER}"
_XYVA = rf"dX := {_NUMBER}, dY := {_NUMBER}, dV := {_NUMBER}, dA := {_NUMBER}"


_COMMENT = re.compile(r"\(\*[\s\S]*?\*\)|^#.*$", re.MULTILINE)


class SlaveUnit(Enum):
    """The unit of the slave in the file: mm for a law in m, deg for a law in rad."""

    MILLIMETRE = "mm"
    DEGREE = "deg"

    @property
    def si_factor(self) -> float:
        """Number of these units in one m, or one rad."""
        return 1e3 if self is SlaveUnit.MILLIMETRE else 1 / _DEGREE


class Interpolation(Enum):
    """Interpolation of the controller between the rows, and the power of their distance with which its error falls."""

    LINEAR = 2
    QUINTIC = 6  # polynomials of fifth degree from position, velocity and acceleration at both ends


@dataclass(frozen=True, eq=False)
class CamTable:
    """The rows of a cam table, in SI, rounded as in the file. It is a law itself: the motion that the controller makes of it.

    phi (N,): master positions in rad, from 0 to 2 pi, both included. position (N,): of the slave in m or rad. velocity,
    acceleration (N,): its derivatives by phi; None for linear interpolation. decimals: of the slave position in its unit.
    """

    phi: np.ndarray
    position: np.ndarray
    velocity: np.ndarray | None
    acceleration: np.ndarray | None
    unit: SlaveUnit
    decimals: int

    @property
    def interpolation(self) -> Interpolation:
        """Linear where there are positions alone."""
        return Interpolation.LINEAR if self.velocity is None else Interpolation.QUINTIC

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The motion, or its derivative by phi of order 1 to 3, at master positions in rad of any shape."""
        angle = np.mod(np.asarray(phi, float), _TURN)
        i = np.clip(np.searchsorted(self.phi, angle, side="right") - 1, 0, len(self.phi) - 2)
        h = np.diff(self.phi)[i]
        share = (angle - self.phi[i]) / h
        coefficients = self._polynomials()
        value = np.zeros(angle.shape)
        for power in range(len(coefficients) - 1, order - 1, -1):
            value = value * share + math.perm(power, order) * coefficients[power][i]
        return np.asarray(value / h**order)

    def _polynomials(self) -> list[np.ndarray]:
        """Return the coefficients (N - 1,) of the powers of the share of each interval, from the constant one on."""
        y, h = self.position, np.diff(self.phi)
        if self.velocity is None or self.acceleration is None:
            return [y[:-1], np.diff(y)]
        v, a = self.velocity, self.acceleration
        first, second = h * v[:-1], h**2 * a[:-1] / 2
        d, e, f = np.diff(y) - first - second, h * v[1:] - first - 2 * second, h**2 * a[1:] - 2 * second
        return [y[:-1], first, second, 10 * d - 4 * e + f / 2, -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2]


def cam_table(
    law: Law,
    unit: SlaveUnit,
    tolerance: float,
    interpolation: Interpolation = Interpolation.QUINTIC,
    decimals: int = 6,
    most: int = MOST_ROWS,
) -> CamTable:
    """Return the table of about as few rows as keep the interpolated, rounded motion within the tolerance of the law.

    tolerance: in m or rad, as the law. decimals: of the slave position in its unit, mm or deg; the velocity has three more, the
    acceleration five. most: the number of rows that the controller takes. Raises ``InputError``.
    """
    require_positive("tolerance", tolerance)
    half = 0.5 * 10.0 ** -require_decimals("decimals", decimals) / unit.si_factor
    if tolerance <= half:
        need = math.floor(-math.log10(2 * tolerance * unit.si_factor)) + 1
        raise InputError("decimals", decimals, f"rounding alone exceeds the tolerance: {need} decimals or more are needed")
    _check_closed(law)
    steps = _even_steps(most)
    count = _FEWEST
    for n in steps:
        if n < count:
            continue
        table = _rounded_table(law, unit, n, interpolation, decimals)
        excess = largest_deviation(table, law) / (_SHARE * tolerance)
        if excess <= 1:
            return table
        count = math.ceil(n * min(excess ** (1 / interpolation.value), 1.5))
    raise InputError(
        "tolerance", tolerance, f"{most} rows do not keep it (in m or rad): choose a wider one, more decimals or more rows"
    )


def largest_deviation(table: CamTable, law: Law, order: int = 0) -> float:
    """Return the largest deviation of the interpolated table from the law, or of their derivatives, in SI."""
    parts = max(_BETWEEN, math.ceil(_SAMPLES / (len(table.phi) - 1)))
    shares = np.arange(parts) / parts
    phi = (table.phi[:-1, None] + np.diff(table.phi)[:, None] * shares).ravel()
    return float(np.abs(table(phi, order) - require_finite("law", law(phi, order))).max())


def _check_closed(law: Law) -> None:
    values = require_finite("law", law(np.linspace(0, _TURN, _SAMPLES + 1)))
    if abs(values[-1] - values[0]) > _CLOSURE * max(float(np.abs(values).max()), float(np.ptp(values))):
        raise InputError(
            "law",
            None,
            "it must close after a turn: a motion that advances with each turn has no periodic cam table",
            code="not-periodic",
        )


def _even_steps(most: int) -> list[int]:
    """Return the numbers of intervals whose length is a whole multiple of the last decimal of the master."""
    whole = 360 * 10**MASTER_DECIMALS
    return [n for n in range(_FEWEST, min(most, MOST_ROWS)) if whole % n == 0]


def _rounded_table(law: Law, unit: SlaveUnit, n: int, interpolation: Interpolation, decimals: int) -> CamTable:
    phi = np.arange(n + 1) * (_TURN / n)

    def rounded_values(order: int, finer: int) -> np.ndarray:
        si_factor = unit.si_factor * _DEGREE**order  # derivatives stand in the file by the degree
        values = np.round(require_finite("law", law(phi, order)) * si_factor, decimals + finer) / si_factor
        values[-1] = values[0]
        return values

    if interpolation is Interpolation.LINEAR:
        return CamTable(phi, rounded_values(0, 0), None, None, unit, decimals)
    return CamTable(
        phi, rounded_values(0, 0), rounded_values(1, VELOCITY_FINER), rounded_values(2, ACCELERATION_FINER), unit, decimals
    )


class Form(Enum):
    """Program that reads the file."""

    CSV = "csv"
    TWINCAT = "twincat"
    CODESYS = "codesys"
    CODESYS_ASCII = "codesys-ascii"


def write_cam_table(path: Path, table: CamTable, form: Form, name: str = "Cam", heading: Heading | None = None) -> Path:
    """Write a table, the master in deg, the slave in its unit.

    name: of the variables in TwinCAT and CODESYS. heading: of the cam whose law it is. CODESYS takes only tables for quintic,
    its ASCII table only for linear interpolation; TwinCAT and CSV take both. Raises ``InputError``, and ``RunError`` where
    nothing can be written.
    """
    if not _IDENTIFIER.fullmatch(name):
        raise InputError(
            "name", name, "it must be a name in IEC 61131-3: a letter, then letters, digits and single underscores"
        )
    interpolation = {Form.CODESYS: Interpolation.QUINTIC, Form.CODESYS_ASCII: Interpolation.LINEAR}.get(
        form, table.interpolation
    )
    if table.interpolation is not interpolation:
        raise InputError("form", form.value, f"it needs a table made for {interpolation.name.lower()} interpolation")
    about = (
        [_title(table, name), *(f"{key}: {text}" for key, text in heading.entries.items())]
        if heading
        else [_title(table, name)]
    )
    return write_ascii(path, _WRITERS[form](_columns(table), table, name, about) + "\n")


def _columns(table: CamTable) -> list[tuple[str, ...]]:
    """Return the rows as texts: master, slave, and velocity and acceleration where there are any, by the degree."""
    si_factor = table.unit.si_factor
    columns = [
        format_decimals(table.phi / _DEGREE, MASTER_DECIMALS),
        format_decimals(table.position * si_factor, table.decimals),
    ]
    if table.velocity is not None and table.acceleration is not None:
        columns.append(format_decimals(table.velocity * si_factor * _DEGREE, table.decimals + VELOCITY_FINER))
        columns.append(format_decimals(table.acceleration * si_factor * _DEGREE**2, table.decimals + ACCELERATION_FINER))
    return list(zip(*columns, strict=True))


def _title(table: CamTable, name: str) -> str:
    return f"cam table {name}: master in deg, slave in {table.unit.value}, {table.interpolation.name.lower()} interpolation"


def _csv(rows: list[tuple[str, ...]], table: CamTable, name: str, comment: list[str]) -> str:
    head = [*(f"# {line}" for line in comment), ";".join(("master", "slave", "velocity", "acceleration")[: len(rows[0])])]
    return "\n".join(head + [";".join(row) for row in rows])


def _twincat(rows: list[tuple[str, ...]], table: CamTable, name: str, comment: list[str]) -> str:
    n = len(rows)
    if table.interpolation is Interpolation.LINEAR:
        kind, columns, array = "EQUIDISTANT", 2, f"ARRAY[0..{n - 1}, 0..1] OF LREAL"
        points = [", ".join(row) for row in rows]
    else:
        kind, columns, array = "MOTIONFUNCTION", 1, f"ARRAY[1..{n}] OF MC_MotionFunctionPoint"
        points = [
            f"(PointIndex := {i}, FunctionType := MC_MotionFunctionType.MOTIONFUNCTYPE_POLYNOM5_MM, "
            f"PointType := MC_MotionPointType.MOTIONPOINTTYPE_MOTION, RelIndexNextPoint := 1, "
            f"MasterPos := {x}, SlavePos := {y}, SlaveVelo := {v}, SlaveAcc := {a}, SlaveJerk := 0.0)"
            for i, (x, y, v, a) in enumerate(rows, 1)
        ]
    return "\n".join([
        f"(* {comment[0]}. MC_CamTableSelect with Periodic := TRUE, then MC_CamIn.",
        *(f"   {line}" for line in comment[1:]),
        f"   MC_CAM_REF: pArray := ADR({name}_A), ArraySize := SIZEOF({name}_A), NoOfRows := {n}, NoOfColumns := {columns},",
        f"   TableType := MC_TABLETYPE_{kind} *)",
        "VAR_GLOBAL",
        f"{name}_A : {array} := [",
        ",\n".join(f"    {point}" for point in points) + "];",
        "END_VAR",
    ])  # fmt: skip


def _codesys(rows: list[tuple[str, ...]], table: CamTable, name: str, comment: list[str]) -> str:
    points = [f"        (dX := {x}, dY := {y}, dV := {v}, dA := {a})" for x, y, v, a in rows]
    return "\n".join([
        f"(* {comment[0]}. MC_CamTableSelect with Periodic := TRUE, then MC_CamIn",
        *(f"   {line}" for line in comment[1:]),
        "*)",
        "{attribute 'linkalways'}",
        "VAR_GLOBAL",
        f"{name}_A: ARRAY[0..{len(rows) - 1}] OF SMC_CAMXYVA := [",
        ",\n".join(points) + "];",
        f"{name}: MC_CAM_REF := (nElements := {len(rows)}, byType := 3, xStart := 0, xEnd := 360, nTappets := 0, "
        f"strCAMName := '{name}', pce := ADR({name}_A), xPartofLM := TRUE);",
        "END_VAR",
    ])  # fmt: skip


def _codesys_ascii(rows: list[tuple[str, ...]], table: CamTable, name: str, comment: list[str]) -> str:
    return "\n".join(" ".join(row) for row in rows)


_WRITERS: dict[Form, Callable[[list[tuple[str, ...]], CamTable, str, list[str]], str]] = {
    Form.CSV: _csv,
    Form.TWINCAT: _twincat,
    Form.CODESYS: _codesys,
    Form.CODESYS_ASCII: _codesys_ascii,
}


def read_cam_table(path: Path, form: Form, unit: SlaveUnit) -> CamTable:
    """Read a table that ``write_cam_table`` wrote. unit: of the slave in the file. Raises ``InputError``."""
    text = read_text(path)
    unit_match = re.search(r"slave in (\w+)", text)
    if unit_match and unit_match.group(1) != unit.value:
        raise InputError(str(path), None, f"its slave is in {unit_match.group(1)}, not in {unit.value}", code="unit")
    content = _COMMENT.sub("", text)  # a title may have anything in it
    rows, size_match = _rows(content, form), re.search(r"ARRAY\[([0-9]+)\.\.([0-9]+)", content)
    if size_match and len(rows) != int(size_match.group(2)) - int(size_match.group(1)) + 1:
        sentence = f"it declares an array of another length than the {len(rows)} rows that can be read"
        raise InputError(str(path), None, sentence, code="count")
    if len(rows) < 3 or len({len(row) for row in rows}) != 1 or len(rows[0]) not in (2, 4):
        raise InputError(str(path), None, f"there is no cam table of the form {form.value} in it", code="no-table")
    try:
        values = np.array([[float(v) for v in row] for row in rows]).T
    except ValueError as error:
        raise InputError(str(path), None, f"it holds a value that is not a number: {error}", code="no-number") from None
    _check_rows(path, values)
    derivatives = [column / (unit.si_factor * _DEGREE**order) for order, column in enumerate(values[2:], 1)] or [None, None]
    decimals = max(len(row[1].partition(".")[2]) for row in rows)
    return CamTable(values[0] * _DEGREE, values[1] / unit.si_factor, derivatives[0], derivatives[1], unit, decimals)


def _rows(text: str, form: Form) -> list[tuple[str, ...]]:
    if form is Form.CODESYS:
        return re.findall(_XYVA, text)
    if form is Form.TWINCAT:
        pairs = re.search(r"OF LREAL := \[(.*?)\]", text, re.DOTALL)
        numbers = re.split(r"[,\s]+", pairs.group(1).strip()) if pairs else []
        return list(zip(numbers[::2], numbers[1::2], strict=False)) or re.findall(_MOTION, text)
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith(("#", "master"))]
    return [tuple(re.split(r"[;\s]+", line)) for line in lines]


def _check_rows(path: Path, values: np.ndarray) -> None:
    master, slave = values[:2]
    if not np.isfinite(values).all():
        raise InputError(str(path), None, "none of its values may be missing (NaN)", code="not-finite")
    if not (np.diff(master) > 0).all() or abs(master[0]) > _WHOLE or abs(master[-1] - 360) > _WHOLE:
        raise InputError(str(path), None, "its master positions must rise from 0 to 360 deg", code="not-increasing")
    if slave[0] != slave[-1]:
        raise InputError(str(path), None, "its slave must return to its position after a turn", code="not-closed")
