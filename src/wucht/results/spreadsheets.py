"""Tables of a result as files that spreadsheets open: CSV with decimal points or commas, and XLSX.

The first line of a table has names and units, as in ``time [s],speed drum [rad/s]``. Missing values are empty cells, true and
false are 1 and 0 in every language, and text that a spreadsheet would take for a formula is preceded by a quotation mark.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError
from wucht.file_names import replace_non_utf8, safe_name
from wucht.results.printed_tables import TIME, answers_table, time_table
from wucht.results.result_tables import TableColumn, result_table, table_names
from wucht.results.store import file_name, replace_file

if TYPE_CHECKING:
    import xarray as xr

# How a formula begins in a spreadsheet: also after what it takes for white space, and in the wide letters of East Asia.
_BLANK = r"[\s\x00-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2060-\u2064\ufeff]"
_CARRIAGE_RETURN = re.compile(r"\r\n?")
_FORMULA = re.compile(rf"[\t\r\n]|{_BLANK}*[=+@\-\uff1d\uff0b\uff20\uff0d]")
_MOST_ROWS, _MOST_COLUMNS, _LONGEST_TEXT, _LONGEST_TITLE = 1_048_576, 16_384, 32_767, 31  # of a sheet in XLSX
_NOT_IN_TITLES = re.compile(r"[\[\]:*?/\\']")
_NOT_IN_CELLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")  # letters that XML has not


def save_csv(result: xr.Dataset, folder: Path, decimal_comma: bool = False) -> list[Path]:
    """Write the tables of a result as CSV files ``STUDY-TABLE.csv``, the single numbers last.

    Parameters
    ----------
    result : xarray.Dataset
        A result of a study.
    folder : path
    decimal_comma : bool
        True for semicolons between cells and commas in numbers, as in ``0,5;104,72``.

    Returns
    -------
    list of path

    Raises
    ------
    RunError
        If a file cannot be written.
    """
    return [save_csv_table(result, name, folder, decimal_comma) for name in table_names(result)]


def save_csv_table(result: xr.Dataset, name: str, folder: Path, decimal_comma: bool = False) -> Path:
    """Write one of the tables of a result as a CSV file. Raises ``RunError`` if it cannot be written."""
    path, table = folder / file_name(f"{safe_name(f'{_kind(result)}-{name}')}.csv", result), result_table(result, name)
    return replace_file(path, lambda beside: _write_csv(beside, table, decimal_comma))


def save_xlsx(result: xr.Dataset, folder: Path, everything: bool = False) -> Path:
    """Write a result as the workbook ``STUDY.xlsx``: its answers and its course over time as engineers write them, and tables.

    Parameters
    ----------
    result : xarray.Dataset
        A result of a study.
    folder : path
    everything : bool
        True for all samples over time as well, in a sheet of their own.

    Returns
    -------
    path

    Raises
    ------
    InputError
        Without the extra ``xlsx``, and for a table that is too large for a sheet.
    RunError
        If the file cannot be written.
    """
    workbook, titles = _openpyxl().Workbook(write_only=True), set[str]()
    sheets = list(_sheets(result, everything))
    for name, table in sheets:
        rows, columns = len(table[0].values) + 1, len(table)
        if rows > _MOST_ROWS or columns > _MOST_COLUMNS:
            limits = (
                f"a sheet has at most {_MOST_ROWS} rows and {_MOST_COLUMNS} columns, this table {rows} and {columns}; use --csv"
            )
            raise InputError("--xlsx", name, limits, code="too-large")
    for name, table in sheets:
        sheet = workbook.create_sheet(_sheet_title(name, titles))
        sheet.freeze_panes = "A2"
        for line in _lines(table, _xlsx_cell):
            sheet.append(line)
    return replace_file(folder / file_name(f"{safe_name(_kind(result))}.xlsx", result), workbook.save)


def _sheets(result: xr.Dataset, everything: bool) -> Iterator[tuple[str, Sequence[TableColumn]]]:
    """Name and table of each sheet, those for people first, those in SI units after them."""
    yield "answers", answers_table(result)
    course = time_table(result)
    if course is not None:
        yield "over time", course
    for name in table_names(result):
        if name != TIME:
            yield name, result_table(result, name)
    if everything and course is not None:
        yield "all samples", result_table(result, TIME)


def _openpyxl() -> Any:
    try:
        return import_module("openpyxl")
    except ImportError:
        raise InputError("--xlsx", None, "XLSX files need the extra: pip install wucht[xlsx]", code="extra") from None


def _kind(result: xr.Dataset) -> str:
    return str(result.attrs["study"])


def _lines(table: Sequence[TableColumn], format_cell: Callable[[Any], Any]) -> Iterator[Sequence[Any]]:
    """Yield the headings and the rows of a table."""
    yield [format_cell(column.heading) for column in table]
    yield from zip(*(map(format_cell, column.values.tolist()) for column in table), strict=True)


def _write_csv(path: Path, table: Sequence[TableColumn], decimal_comma: bool) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter=";" if decimal_comma else ",", lineterminator="\n")
        writer.writerows(_lines(table, _csv_cell_with_comma if decimal_comma else _csv_cell))


def _csv_cell(cell: Any) -> Any:
    """A cell of a CSV file: numbers with all their digits. A carriage return, which would end the row, is a line feed."""
    if isinstance(cell, float):
        return "" if math.isnan(cell) else repr(cell)
    if isinstance(cell, str):
        return _escape_formula(_CARRIAGE_RETURN.sub("\n", replace_non_utf8(cell)))
    return int(cell) if isinstance(cell, bool) else cell


def _csv_cell_with_comma(cell: Any) -> Any:
    text = _csv_cell(cell)
    return text.replace(".", ",") if isinstance(cell, float) else text


def _xlsx_cell(cell: Any) -> Any:
    """A cell of a sheet: an infinite number, which it cannot hold, as text; a text without letters that XML has not."""
    if isinstance(cell, float):
        return cell if math.isfinite(cell) else None if math.isnan(cell) else str(cell)
    if not isinstance(cell, str):
        return int(cell) if isinstance(cell, bool) else cell
    text, note = _escape_formula(_NOT_IN_CELLS.sub("?", replace_non_utf8(cell))), " ... (shortened)"
    return text if len(text) <= _LONGEST_TEXT else f"{text[: _LONGEST_TEXT - len(note)]}{note}"


def _sheet_title(name: str, titles: set[str]) -> str:
    """A title for the sheet of a table, and add it to the earlier ones, whose case does not count."""
    base = _NOT_IN_TITLES.sub("-", name)
    candidates = (base[: _LONGEST_TITLE - len(end)] + end for end in ("", *(f" ({k})" for k in range(2, len(titles) + 3))))
    title = next(title for title in candidates if title.casefold() not in titles)
    titles.add(title.casefold())
    return title


def _escape_formula(text: str) -> str:
    """Protect a text from being read as a formula: one that begins like that gets a quotation mark before it, a number not."""
    if not _FORMULA.match(text):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text
