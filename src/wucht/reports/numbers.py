"""The numbers of a result in a report: main numbers, single numbers, and the tables of its summary."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from wucht.reports.markup import html_table, html_text, section
from wucht.reports.subject_section import MOST_ROWS, left_out, remarks, sentence_case
from wucht.results.formatting import engineering_text, number_text, rpm_first
from wucht.results.report import paths_in_report
from wucht.results.result_tables import leaves

if TYPE_CHECKING:
    import xarray as xr

    from wucht.results.accessor import ResultAccessor

_MOST_COLUMNS, _BESIDE = 7, 5  # of tables of the summary: beside each other where they are few
_FEW_ROWS, _IN_COLUMNS, _SHORT = (
    8,
    2,
    90,
)  # of a brief chapter: rows of a table, those of one in columns, letters of a cell there
_MOST_NUMBERS = 6  # of a list in a cell
_HEADLINES = 4  # of a result on the first page


def main_numbers(accessor: ResultAccessor) -> str:
    """The first main numbers of a result, a line each: those that it has."""
    lines = list[str]()
    for path in accessor.headlines:
        key, _, part = path.partition(".")
        value = accessor.summary.get(key)
        value = value.get(part) if part and isinstance(value, Mapping) else None if part else value
        if value in (None, {}, [], ""):
            continue
        facts = {"unit": accessor.unit_at(path)}
        lines.append(f"{html_text(accessor.description_at(path))}: {_printed_cell(value, facts, accessor)}")
    return "<br>".join(lines[:_HEADLINES])


def number_sections(result: xr.Dataset, without: Collection[str] = ()) -> list[str]:
    """Sections with all single numbers of a summary, and with each list of tables in it. without: keys left out."""
    accessor = result.wucht
    rows = [(html_text(name), _printed_cell(value, facts, accessor)) for name, value, facts in _single(accessor, without)]
    numbers = f'<div class="parts">{html_table(rows, row_heads=True, kind="long")}</div>' if rows else ""
    tables = [
        section(name, _rows_table(value, parts, accessor.dimensionless)) for name, value, parts in _lists(accessor, without)
    ]
    return [section("Numbers", numbers), *tables]


def brief_numbers(result: xr.Dataset, without: Collection[str] = ()) -> list[str]:
    """The same on less paper: without the numbers of the lines above, small tables in columns, of long ones the first rows."""
    accessor, paths = result.wucht, paths_in_report(result)
    dimensionless = accessor.dimensionless
    without = {*without, *(key for key, value in accessor.summary.items() if _is_shown(key, value, paths))}
    cells = [(html_text(name), _printed_cell(value, facts, accessor)) for name, value, facts in _single(accessor, without)]
    narrow = [html_table([row for row in cells if len(row[1]) <= _SHORT], row_heads=True, kind="long")]
    long = [(name, cell.replace("<br>", "; ")) for name, cell in cells if len(cell) > _SHORT]
    broad = [html_table(long, row_heads=True, kind="entries wide")]
    pairs = list[str]()
    for name, rows, parts in _lists(accessor, without):
        if len(rows) <= _IN_COLUMNS:
            small = html_table(_beside(rows, parts, dimensionless), caption=html_text(name), row_heads=True, kind="long")
            (narrow if len(rows) == 1 else pairs).append(small)
        else:
            broad.append(section(name, _rows_table(rows, parts, dimensionless, _FEW_ROWS), level=3))
    columns = [_columns_block(narrow, "parts"), _columns_block(pairs, "parts two")]
    return [section("Further numbers", *columns, *broad)]


def _is_shown(key: str, value: Any, paths: Collection[str]) -> bool:
    """True if the lines of the report show a value, or all numbers in it. A list of tables is a table of its own."""
    if _is_list_of_tables(value) and value:
        return False
    return key in paths or all(path in paths for path, leaf in leaves(value, key) if leaf is not None)


def _columns_block(tables: Sequence[str], kind: str) -> str:
    inner = "".join(filter(None, tables))
    return f'<div class="{kind}">{inner}</div>' if inner else ""


def _single(accessor: ResultAccessor, without: Collection[str]) -> Iterator[tuple[str, Any, Mapping[str, Any]]]:
    """Name in words, value and facts of each number of a summary that is no list of tables."""
    for name, value, facts in _summary_values(accessor, without):
        if not _is_list_of_tables(value):
            yield name, value, facts


def _lists(accessor: ResultAccessor, without: Collection[str]) -> Iterator[tuple[str, Any, Mapping[str, Any]]]:
    """Name in words, rows and parts of each list of tables of a summary."""
    for name, value, facts in _summary_values(accessor, without):
        if _is_list_of_tables(value):
            yield name, value, facts.get("parts", {})


def _summary_values(accessor: ResultAccessor, without: Collection[str]) -> Iterator[tuple[str, Any, Mapping[str, Any]]]:
    for key, value in accessor.summary.items():
        if key != "sentence" and key not in without and value not in (None, {}, []):
            facts = accessor.quantities.get(key, {})
            yield sentence_case(str(facts.get("what", key))), value, facts


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(row, Mapping) for row in value)


def _rows_table(
    rows: Sequence[Mapping[str, Any]], parts: Mapping[str, Any], dimensionless: bool, most_rows: int = MOST_ROWS
) -> str:
    """A list of tables as one: a few beside each other, many below each other with their first columns."""
    if len(rows) <= _BESIDE:
        heads = ("", *map(str, range(1, len(rows) + 1)))
        return html_table(_beside(rows, parts, dimensionless), heads, row_heads=True, kind="beside")
    keys, names = _columns(rows, parts)
    columns, further_columns = keys[:_MOST_COLUMNS], keys[_MOST_COLUMNS:]
    cells = [[_cell(row.get(key), parts.get(key, {}), dimensionless) for key in columns] for row in rows[:most_rows]]
    further = [f"Also in the result file: {', '.join(names[key] for key in further_columns)}."] if further_columns else []
    head = [html_text(sentence_case(names[key])) for key in columns]
    return html_table(cells, head) + remarks([*left_out(rows, most_rows), *further])


def _beside(rows: Sequence[Mapping[str, Any]], parts: Mapping[str, Any], dimensionless: bool) -> list[list[str]]:
    """A line for each column of a list of tables, with the values of its rows beside each other."""
    keys, names = _columns(rows, parts)
    return [
        [html_text(sentence_case(names[key])), *(_cell(row.get(key), parts.get(key, {}), dimensionless) for row in rows)]
        for key in keys
    ]


def _columns(rows: Sequence[Mapping[str, Any]], parts: Mapping[str, Any]) -> tuple[list[str], dict[str, str]]:
    """The columns of a list of tables that have values, single values first, and their names in words."""
    every_key = dict.fromkeys(key for row in rows for key in row)
    keys = [key for key in every_key if any(row.get(key) not in (None, {}, []) for row in rows)]
    keys.sort(key=lambda key: any(isinstance(row.get(key), list | Mapping) for row in rows))
    return keys, {key: str(parts.get(key, {}).get("what", key)) for key in keys}


def _printed_cell(value: Any, facts: Mapping[str, Any], accessor: ResultAccessor) -> str:
    """A value in HTML, speeds in rpm first where the study file has such."""
    cell = _cell(value, facts, accessor.dimensionless)
    return rpm_first(cell) if accessor.speaks_rpm else cell


def _cell(value: Any, facts: Mapping[str, Any], dimensionless: bool) -> str:
    """A value of the summary in HTML, with its unit; in words where it is no number. facts: its unit, and its parts."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        cells = [_cell(one, facts, dimensionless) for one in value[: _MOST_NUMBERS + 1]]
        return "; ".join(cells) if len(cells) <= _MOST_NUMBERS else f"{len(value):,} values, in the result file"
    if isinstance(value, Mapping):
        parts = facts.get("parts", {})
        inner = {
            name: _cell(one, parts.get(name, facts), dimensionless) for name, one in value.items() if one not in (None, {}, [])
        }
        is_inside = any(isinstance(one, Mapping) for one in value.values())
        lines = (f"{html_text(parts.get(name, {}).get('what', name))}: {cell}" for name, cell in inner.items())
        return "<br>".join(line.replace("<br>", ", ") if is_inside else line for line in lines)
    if isinstance(value, int | float):
        unit = str(facts.get("unit", ""))
        has_words = not unit or dimensionless or "/rad" in unit
        return html_text(number_text(value, unit, "", dimensionless) if has_words else engineering_text(value, unit))
    return html_text(value)
