"""Measured tables: files of two columns, read at the edge, so that a machine's description holds numbers only."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from wucht.errors import FieldError, InputError, code_of
from wucht.files.documents import Document, read_text
from wucht.files.text_rows import cells_of, plain_number, remedy_of_number, separator_of, without_comment
from wucht.machines.parts.characteristic import SPEED_TORQUE
from wucht.schema import Unit, article

TIME_DISPLACEMENT = (Unit("s", "time"), Unit("m", "displacement"))
TIME_ANGLE = (Unit("s", "time"), Unit("rad", "angle"))

_HEADING = re.compile(r"([^\[(]+?)\s*(?:\[(.*)\]|\((.*)\))?")  # name, name [unit] or name (unit)
_UNIT_IN_WORDS = re.compile(r"\S.*\sin (\S.*)")  # Drehzahl in 1/min


def read_table(path: Path, units: tuple[Unit, Unit]) -> list[list[float]]:
    """The rows of a text file of two columns, in SI.

    units: what each column holds and its SI unit. Columns are separated by semicolons, tabs, commas or blanks; with
    semicolons and tabs a decimal comma is accepted. ``#`` begins a comment. The first line may be a heading whose columns
    carry units, as in ``speed (rpm), torque [N m]``, ``Drehzahl in U/min; Moment in Nm`` or ``rpm, N m``; without units numbers
    are SI. Raises ``InputError``, with the line, for a file that cannot be read, a line that is not a row of two numbers, a
    first column that does not increase, and fewer than two rows.
    """
    scale, has_heading = [1.0, 1.0], False
    rows: list[list[float]] = []
    for number, line in _lines(path):
        try:
            if not rows and not has_heading and _is_heading(line):
                scale, has_heading = _scales(line, units), True
                continue
            if has_heading and not rows and _is_heading(line):
                example = "; ".join(f"{u.long_name} [{u.si}]" for u in units)
                first_cell = repr(_cells(line)[0])
                raise FieldError(
                    f"{first_cell} is not a finite number; write units beside the names: {example}", code="heading-twice"
                )
            row = [u.parse_quantity(n * f) for n, f, u in zip(_row(line, units), scale, units, strict=True)]
            if rows and row[0] <= rows[-1][0]:
                raise FieldError(f"the {units[0].long_name} does not increase", code="not-increasing")
        except ValueError as error:
            raise InputError.file_error(path, f"line {number}: {error}", code=code_of(error)) from None
        rows.append(row)
    if len(rows) < 2:
        raise InputError.file_error(
            path, f"there must be at least two rows of {_column_names(units)}; there are {len(rows)}", code="too-few"
        )
    return rows


def with_tables(description: Document, folder: Path) -> Document:
    """A copy of a table ``[machine]`` in which each file of measured points is replaced by its ``points``, numbers in SI.

    Drives and loads of kind "table" name a ``file`` of speed and torque, a carrier's motion a ``table`` of time and
    displacement (an angle, where it turns). Paths are relative to the folder. Raises ``InputError``, located from ``machine``
    on, for a file that cannot be used, and where there are points beside it. Other faults are reported by the machine.
    """
    document = dict(description)
    for key in [k for k in ("drive", "load", "drives", "loads") if k in document]:
        shafts, location = document[key], f"machine.{key}"
        if isinstance(shafts, list):
            document[key] = [_characteristic(d, folder, f"{location}[{i}]") for i, d in enumerate(shafts)]
        else:
            document[key] = _characteristic(shafts, folder, location)
    carrier = document.get("carrier")
    if isinstance(carrier, dict) and isinstance(carrier.get("motion"), dict):
        motion = carrier["motion"]
        units = TIME_ANGLE if "r" in (carrier.get("directions"), motion.get("direction")) else TIME_DISPLACEMENT
        document["carrier"] = {**carrier, "motion": _with_points(motion, "table", units, folder, "machine.carrier.motion")}
    return document


def _characteristic(description: Any, folder: Path, location: str) -> Any:
    is_measured = isinstance(description, dict) and description.get("kind") == "table"
    return _with_points(description, "file", SPEED_TORQUE, folder, location) if is_measured else description


def _with_points(description: Document, key: str, units: tuple[Unit, Unit], folder: Path, location: str) -> Document:
    if key not in description:
        return description
    name = description[key]
    if not isinstance(name, str) or not name.strip() or "\0" in name:
        raise InputError(f"{location}.{key}", name, "must be the name of a file")
    if "points" in description:
        raise InputError(f"{location}.{key}", name, f"give either {key} or points", code="either-or")
    try:
        points = read_table(folder / name, units)
    except InputError as error:
        raise InputError(f"{location}.{key}", name, error.explanation, code=error.code) from None
    return {**{k: v for k, v in description.items() if k != key}, "points": points}


def _lines(path: Path) -> list[tuple[int, str]]:
    """The lines that contain more than comments, with their numbers."""
    text = read_text(path, f"there is no such file: {path}")
    numbered_lines = ((i, without_comment(line)) for i, line in enumerate(text.splitlines(), 1))
    return [(i, line) for i, line in numbered_lines if line]


def _cells(line: str) -> list[str]:
    return cells_of(line, separator_of(line), least=2)


def _column_names(units: tuple[Unit, Unit]) -> str:
    return " and ".join(u.long_name for u in units)


def _row(line: str, units: tuple[Unit, Unit]) -> list[float]:
    cells, commas = _cells(line), separator_of(line) in (";", "\t")
    if len(cells) != 2:
        remedy = "; where commas are decimal, put a semicolon between the columns" if "," in line and not commas else ""
        sentence = f"there must be two numbers, {_column_names(units)}; there are {len(cells)} columns{remedy}"
        raise FieldError(sentence, code="count")
    return [_number(c.replace(",", ".") if commas else c, u) for c, u in zip(cells, units, strict=True)]


def _number(cell: str, unit: Unit) -> float:
    try:
        value = plain_number(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        remedy = remedy_of_number(cell)
        raise FieldError(f"{cell[:40]!r} is not a finite number; must be {article(unit.long_name)}{remedy}", code="no-number")
    return value


def _is_heading(line: str) -> bool:
    """True if all columns begin with a letter, and are not the numbers ``nan`` or ``inf``."""
    names = [c.lower().lstrip("+-") for c in _cells(line)]
    return all(n[:1].isalpha() and n not in ("nan", "inf", "infinity") for n in names)


def _scales(line: str, units: tuple[Unit, Unit]) -> list[float]:
    """Factor from the unit of each column to SI."""
    cells = _cells(line)
    if len(cells) != 2:
        raise FieldError(f"there must be two columns, {_column_names(units)}; the heading has {len(cells)}", code="count")
    factors = []
    for cell, unit, other_unit in zip(cells, units, units[::-1], strict=True):
        parts = _HEADING.fullmatch(cell)
        if parts is None:
            sentence = f"{cell[:40]!r} is not a heading; must be {unit.long_name} or {unit.long_name} [{unit.si}]"
            raise FieldError(sentence, code="no-heading")
        if other_unit.long_name in parts[1].lower() and unit.long_name not in parts[1].lower():
            sentence = f"the columns are exchanged; must be {units[0].long_name} first, then {units[1].long_name}"
            raise FieldError(sentence, code="exchanged")
        in_words = _UNIT_IN_WORDS.fullmatch(parts[1])
        if parts[2] is not None or parts[3] is not None:
            factors.append(unit.parse_quantity(f"1 {parts[2] or parts[3] or '?'}"))
        else:
            factors.append(unit.parse_quantity(f"1 {in_words[1]}") if in_words else _unit_at_the_end(parts[1], unit))
    return factors


def _unit_at_the_end(heading: str, unit: Unit) -> float:
    """Factor to SI of a unit in a heading's last words, as ``rpm``, ``n rpm``, ``n / rpm``; 1 where there is none."""
    words = heading.split()
    for first in range(len(words)):
        try:
            return unit.parse_quantity(f"1 {' '.join(words[first:]).removeprefix('/').strip()}")
        except ValueError:
            continue
    return 1.0
