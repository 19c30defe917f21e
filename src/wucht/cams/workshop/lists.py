"""Lists of points for the workshop: text, a line a point, in millimetres, with a descriptive header."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np

from wucht.cams.demands import require_decimals, require_positive
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.points import FEWEST, PointList
from wucht.errors import InputError, nearest
from wucht.files.documents import read_text
from wucht.results.store import replace_file

_FINER = 3  # decimals that angles and normals have more than coordinates: 1 um on a radius of 1 m is 6e-5 deg
_TITLE = "wucht point list"
_LENGTHS = {"x", "y"}
UNITS = {"phi": "deg", "x": "mm", "y": "mm", "nx": "1", "ny": "1"}


class Separator(Enum):
    """Text between the numbers of a line."""

    BLANK = " "
    SEMICOLON = ";"
    COMMA = ","


@dataclass(frozen=True, eq=False)
class ReadList:
    """A list read from a file. position (N,): complex, in m. phi (N,): rad, normal (N,): complex; None where the list has none.

    tolerance: the chord tolerance in m that the header states, or None. decimals: of the coordinates in mm.
    """

    content: str
    position: np.ndarray
    phi: np.ndarray | None
    normal: np.ndarray | None
    clockwise: bool
    tolerance: float | None
    decimals: int


def write_list(
    path: Path,
    points: PointList,
    content: str,
    columns: Sequence[str] = ("x", "y", "nx", "ny"),
    separator: Separator = Separator.BLANK,
    decimals: int = 4,
    tolerance: float | None = None,
    heading: Heading | None = None,
) -> Path:
    """Write points, each once: the list is closed, and the first is not repeated.

    content: "contour", "pitch curve" ... in a line of ASCII. columns: of phi (deg), x, y (mm), nx, ny (outward unit normal),
    x and y among them. decimals: of x and y in mm; phi and the normals have three more. tolerance: the chord tolerance in m of
    the points, heading: of the cam, both for the header. Raises ``InputError``, and ``RunError`` where nothing can be written.
    """
    require_decimals("decimals", decimals)
    _check(points, content, columns)
    tolerance_text = "not stated" if tolerance is None else f"{1e3 * require_positive('tolerance', tolerance):.12g} mm"
    values = {
        "phi": np.degrees(points.phi),
        "x": 1e3 * points.position.real,
        "y": 1e3 * points.position.imag,
        "nx": points.normal.real,
        "ny": points.normal.imag,
    }
    texts = [format_decimals(values[c], decimals if c in _LENGTHS else decimals + _FINER) for c in columns]
    header = {
        _TITLE: content,
        **({} if heading is None else heading.entries),
        "unit": "mm, angles in deg, normals of length 1",
        "sense": "clockwise" if _is_clockwise(points.position) else "counter-clockwise",
        "points": f"{len(points.position)}, closed, the first one not repeated",
        "chord tolerance": tolerance_text,
        "decimals": str(decimals),
        "columns": " ".join(columns),
    }
    lines = [f"# {key}: {value}" for key, value in header.items()]
    lines += [separator.value.join(row) for row in zip(*texts, strict=True)]
    return write_ascii(path, "\n".join(lines) + "\n")


def _check(points: PointList, content: str, columns: Sequence[str]) -> None:
    if not content.strip() or "\n" in content:
        raise InputError("content", content, "it must be a name of one line")
    for column in columns:
        if column not in UNITS:
            raise InputError("columns", column, f"there is no such column; {nearest(column, UNITS)}")
    if len(set(columns)) < len(columns) or not set(columns) >= _LENGTHS:
        raise InputError("columns", list(columns), "x and y must be among them, and each once only")
    if len(points.position) < FEWEST:
        raise InputError("points", len(points.position), f"a closed curve needs {FEWEST} points or more")
    for name, values in (("phi", points.phi), ("position", points.position), ("normal", points.normal)):
        if len(values) != len(points.position) or not np.isfinite(values).all():
            raise InputError(f"points.{name}", None, "each point must have one, and none may be missing (NaN)")


def _is_clockwise(position: np.ndarray) -> bool:
    return bool(np.sum((position.conj() * np.roll(position, -1)).imag) < 0)


def read_list(path: Path) -> ReadList:
    """Read a list that ``write_list`` wrote, with any separator. Raises ``InputError``."""
    lines = read_text(path).splitlines()
    header = dict(re.findall(r"^# ([^:]+): (.*)$", "\n".join(lines), re.MULTILINE))
    if missing := [k for k in (_TITLE, "sense", "points", "chord tolerance", "decimals", "columns") if k not in header]:
        raise InputError(str(path), None, f"its header does not state: {', '.join(missing)}", code="header")
    columns = header["columns"].split()
    rows = [re.split(r"[;,\s]+", line.strip()) for line in lines if line.strip() and not line.startswith("#")]
    try:
        table = np.array([[float(v) for v in row] for row in rows if len(row) == len(columns)])
        count, decimals = int(header["points"].split(",")[0]), int(header["decimals"])
        tolerance = None if header["chord tolerance"] == "not stated" else float(header["chord tolerance"].split()[0]) / 1e3
    except ValueError as error:
        raise InputError(str(path), None, f"it holds a value that is not a number: {error}", code="no-number") from None
    if len(table) != len(rows) or len(rows) != count or not np.isfinite(table).all():
        raise InputError(
            str(path),
            None,
            f"its header announces {count} points with {len(columns)} numbers each, but some are missing",
            code="count",
        )
    return _list_from_columns(header, dict(zip(columns, table.T, strict=True)), tolerance, decimals)


def _list_from_columns(
    header: Mapping[str, str], columns: Mapping[str, np.ndarray], tolerance: float | None, decimals: int
) -> ReadList:
    return ReadList(
        content=header[_TITLE],
        position=(columns["x"] + 1j * columns["y"]) / 1e3,
        phi=np.radians(columns["phi"]) if "phi" in columns else None,
        normal=columns["nx"] + 1j * columns["ny"] if {"nx", "ny"} <= set(columns) else None,
        clockwise=header["sense"] == "clockwise",
        tolerance=tolerance,
        decimals=decimals,
    )


def write_ascii(path: Path, text: str) -> Path:
    """Write a text: ASCII, as controllers and old CAM programs read it. Raises ``InputError`` for other
    letters, ``RunError`` where it cannot be written."""
    if not text.isascii():
        raise InputError(str(path), None, "names in files for the workshop must be of plain ASCII characters")
    return replace_file(path, lambda beside: beside.write_text(text, encoding="ascii", newline="\n"))


def format_decimals(values: np.ndarray, decimals: int) -> list[str]:
    """Return numbers (N,) with so many decimals; never a minus before a zero."""
    return [f"{v:.{decimals}f}" for v in np.round(values, decimals) + 0.0]
