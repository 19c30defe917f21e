"""Text files of columns: CSV and similar formats."""

from __future__ import annotations

import codecs
import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wucht.errors import InputError
from wucht.files.documents import read_text
from wucht.files.text_rows import (
    cells_of,
    has_closed_quotes,
    plain_number,
    remedy_of_number,
    separator_of,
    without_comment,
)
from wucht.measurements.recording import ANGLE_UNIT, SPEED_UNIT, TIME_UNIT, Channel, Recording
from wucht.schema import Unit

_TIMES = ("time", "t", "zeit", "times", "timestamp")
_KNOWN_UNITS = (TIME_UNIT, SPEED_UNIT, ANGLE_UNIT, Unit("m/s^2", "acceleration"), Unit("rad/s^2", "angular acceleration"))
_HEADING = re.compile(r"([^\[(]*?)\s*(?:\[(.*)\]|\((.*)\))?")  # name, name [unit] or name (unit)
_UNIT_IN_WORDS = re.compile(r"\S.*\sin (\S+)")  # Drehzahl in 1/min; the name is then all of it
_MARKS = (  # the longer ones first: that of UTF-32 begins with that of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_LONGEST_MARK = 4
_LONGEST_ROW = 10_000  # letters of a row with line breaks between quotation marks
_BLANK_BEFORE_QUOTE = re.compile(r' +"')
_NUMBER_IN_ANY_WRITING = re.compile(  # digits of any script, also with what separates decimals and thousands
    r"'?[-+]?[\d.,_\u066b\u066c]{0,40}\d[\d.,_\u066b\u066c]{0,40}(e[-+]?\d{1,5})?'?|[-+]?(nan|inf|infinity)", re.IGNORECASE
)
_UNITS_ALONE = ("s", "ms", "rpm", "rad/s", "deg/s", "Hz", "rad", "deg", "°", "V", "mV", "m/s^2")


@dataclass(frozen=True)
class _Layout:
    """Layout of a file. first: the number of its first row, from 0."""

    separator: str | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    first: int


def read_text_file(path: Path) -> Recording:
    """Read the columns of a text file over its time: the column called time (or t), else the first, in s if it has no unit.

    Columns are separated by semicolons, tabs, commas or blanks; beside semicolons and tabs a decimal comma is understood. Cells
    may be between quotation marks. ``#`` begins a comment. A heading names the columns and may give units, as in ``time [ms],
    speed (rpm)``, or in a second line; without one they are called "1", "2", ... A lone column is also its time: instants of
    events. The text is UTF-8, UTF-16 or UTF-32 with its mark, or Latin-1.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        With the line, for a file that cannot be read and a row that is not of as many finite numbers.
    """
    lines = _text(path).splitlines()
    layout = _layout(str(path), lines)
    table = _table(str(path), lines, layout)
    clock = next((i for i, n in enumerate(layout.names) if n.lower().split(" in ")[0] in _TIMES), 0)
    rows = np.arange(len(table))
    time = Channel(str(path), layout.names[clock], layout.units[clock], rows, table[:, clock]).to_si(TIME_UNIT).values
    if len(layout.names) == 1:
        return Recording.of(str(path), time, {layout.names[0]: time}, {layout.names[0]: "s"})
    columns = {n: table[:, i] for i, n in enumerate(layout.names) if i != clock}
    return Recording.of(str(path), time, columns, dict(zip(layout.names, layout.units, strict=True)))


def _text(path: Path) -> str:
    """Read a file in UTF-8, in UTF-16 or UTF-32 with its mark, or in Latin-1 as loggers write it, where only ° and µ differ."""
    encoding = _marked_encoding(path)
    if encoding is not None:
        return _decoded_text(path, encoding)
    try:
        text = read_text(path)
    except InputError:
        text = read_text(path, encoding="latin-1")
    if "\0" in text:
        number = text.count("\n", 0, text.index("\0")) + 1
        explanation = f"line {number}: there are zero bytes, as in UTF-16 without its mark; save it as UTF-8"
        raise InputError(str(path), None, explanation, code="unreadable")
    return text


def _marked_encoding(path: Path) -> str | None:
    """Return the encoding that the first bytes of a file state, where it is UTF-16 or UTF-32."""
    if not path.is_file() or not path.stat().st_size:  # reading a pipe, or a file of the system without a size, may never end
        return None
    try:
        with path.open("rb") as file:
            begin = file.read(_LONGEST_MARK)
    except OSError:
        return None
    return next((encoding for mark, encoding in _MARKS if begin.startswith(mark)), None)


def _decoded_text(path: Path, encoding: str) -> str:
    try:
        return read_text(path, encoding=encoding)
    except InputError as error:
        if error.code != "unreadable":
            raise
        explanation = f"its first bytes state {encoding.upper()}, but the file is cut short or damaged; save it as UTF-8"
        raise InputError(str(path), None, explanation, code="unreadable") from None


def _layout(source: str, lines: list[str]) -> _Layout:
    heading: list[list[str]] = []
    for number, text in _whole_rows(source, lines):
        separator = separator_of(text)
        cells = cells_of(text, separator)
        if len(heading) < 2 and not any(_is_number(c, separator) for c in cells):
            heading.append(cells)
            continue
        names, units = _heading(heading, len(cells))
        if len(names) != len(cells):
            explanation = f"line {number + 1}: there are {len(cells)} columns; the heading has {len(names)}"
            raise InputError(source, None, explanation, code="no-heading")
        duplicate = next((n for n, count in Counter(names).items() if count > 1), None)
        if duplicate is not None:
            raise InputError(source, None, f"two columns are called {duplicate!r}; names must be different", code="name-twice")
        return _Layout(separator, tuple(names), tuple(units), number)
    raise InputError(source, None, "there is no row of numbers in this file", code="no-rows")


def _whole_rows(source: str, lines: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the number, from 0, of the last line of each row and its text; a cell between quotation marks may have several."""
    text = ""
    for number, line in enumerate(lines):
        text = f"{text} {line}".strip() if text else without_comment(line)
        if text and has_closed_quotes(text):
            yield number, text
            text = ""
        elif text and len(text) > _LONGEST_ROW:
            break
    if text:
        raise _open_quote(source, next(number for number, line in enumerate(lines, 1) if not has_closed_quotes(line)))


def _open_quote(source: str, number: int) -> InputError:
    explanation = f"line {number}: a quotation mark is not closed; close it, or take it out"
    return InputError(source, None, explanation, code="open-quotes")


def _heading(heading: list[list[str]], count: int) -> tuple[list[str], list[str]]:
    """Return names and units of the columns."""
    if not heading:
        return [str(i + 1) for i in range(count)], [""] * count
    names, units = [], []
    for i, cell in enumerate(heading[0]):
        parts = _HEADING.fullmatch(cell)
        name, unit = (parts[1], (parts[2] or parts[3] or "").strip()) if parts else (cell, "")
        names.append(name or unit or str(i + 1))
        name_match = _UNIT_IN_WORDS.fullmatch(name)
        unit_in_name = name_match[1] if name_match and _is_unit(name_match[1]) else ""
        units.append(unit or unit_in_name or (name if name in _UNITS_ALONE else ""))
    if len(heading) == 2 and len(heading[1]) == len(names):
        units = [u or c.strip("[]()- ") for u, c in zip(units, heading[1], strict=True)]
    return names, units


def _is_unit(text: str) -> bool:
    """True if a text is a unit in which motions are recorded."""
    for unit in _KNOWN_UNITS:
        try:
            unit.parse_quantity(f"1 {text}")
        except ValueError:
            continue
        return True
    return text == "g"


def _table(source: str, lines: list[str], layout: _Layout) -> np.ndarray:
    """Return the rows (n, columns) of finite numbers."""
    rows, separator = lines[layout.first :], layout.separator
    if separator and rows[0].rstrip(" ").endswith(separator):
        rows = [r.rstrip(" ").removesuffix(separator) for r in rows]
    if separator and any('"' in r for r in rows):
        rows = [_BLANK_BEFORE_QUOTE.sub('"', r) for r in rows]
    if separator in (";", "\t"):
        rows = [r.replace(",", ".") for r in rows]
    try:
        table = np.loadtxt(rows, delimiter=separator, ndmin=2, comments="#", quotechar='"')
    except ValueError:
        raise _line_error(source, lines, layout) from None
    if not np.isfinite(table).all():
        raise _line_error(source, lines, layout)
    return np.asarray(table)


def _line_error(source: str, lines: list[str], layout: _Layout) -> InputError:
    """Return the error with the line that is not a row."""
    for number, line in enumerate(lines[layout.first :], layout.first + 1):
        text = without_comment(line)
        cells = cells_of(text, layout.separator)
        if not text:
            continue
        if not has_closed_quotes(text):
            return _open_quote(source, number)
        empty = _first_empty(text, layout)
        if empty is not None:
            return _without_value(source, lines, layout, number, empty)
        if len(cells) != len(layout.names):
            explanation = f"line {number}: there must be {len(layout.names)} columns; there are {len(cells)}"
            return InputError(source, None, explanation, code="count")
        for name, cell in zip(layout.names, cells, strict=True):
            if not math.isfinite(_plain_float(cell, layout.separator)):
                sentence = f"line {number}: {cell[:40]!r} is not a finite number{remedy_of_number(cell)}"
                return InputError(f"{source}: {name}", None, sentence, code="no-number")
    return InputError(source, None, f"the rows must be of {len(layout.names)} numbers each", code="count")


def _first_empty(text: str, layout: _Layout) -> int | None:
    """Return the number, from 0, of the first column that has nothing between its separators in a line."""
    if layout.separator is None:
        return None
    cells = cells_of(text, layout.separator, len(layout.names))
    return next((i for i, c in enumerate(cells[: len(layout.names)]) if not c), None)


def _without_value(source: str, lines: list[str], layout: _Layout, number: int, column: int) -> InputError:
    """Return the error of a column without a value in a line, or also in all lines after it: its record ends earlier."""
    texts = [without_comment(line) for line in lines[layout.first :]]
    before = sum(1 for line in texts[: number - 1 - layout.first] if line)
    after = [line for line in texts[number - 1 - layout.first :] if line]
    ends = len(after) > 1 and all(_first_empty(line, layout) == column for line in after)
    explanation = f"line {number}: there is no value; fill it in, or take the row out"
    if ends:
        explanation = (
            f"this channel ends early: it has {before} values, and none from line {number} on, while other columns have "
            f"{before + len(after)}; cut all columns at line {number}, or write this one into a separate file"
        )
    return InputError(f"{source}: {layout.names[column]}", None, explanation, code="ends-early" if ends else "no-value")


def _is_number(cell: str, separator: str | None) -> bool:
    """True if a cell is meant as a number, however it is written: its row is none of the heading."""
    return math.isfinite(_plain_float(cell, separator)) or _NUMBER_IN_ANY_WRITING.fullmatch(cell) is not None


def _plain_float(cell: str, separator: str | None) -> float:
    """Return the number of a cell; NaN where it is none, or not of the digits 0 to 9."""
    try:
        return plain_number(_with_decimal_point(cell, separator))
    except ValueError:
        return math.nan


def _with_decimal_point(cell: str, separator: str | None) -> str:
    return cell.replace(",", ".") if separator in (";", "\t") else cell
