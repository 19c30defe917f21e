"""The report of a comparison, a table of its variants, and which numbers it shows, from the Dataset alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.formatting import label, printed_unit, wrap_text

if TYPE_CHECKING:
    import xarray as xr

_EQUAL = 1e-5  # of the largest value: what differs by less is printed with the same digits
_COLUMNS, _MOST_LINES, _CELL_WIDTH = 6, 60, 60
_HEAD_WIDTH = 16  # letters of a line of a column's head, where words allow it


_Column = tuple[str, list[str], Callable[[str, int], str]]  # head, cells, and how they are aligned


def comparison_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht compare`` prints: headline numbers first, and those that differ."""
    s, names, outcomes = result.wucht.summary, variant_names(result), list(map(str, result.outcome.values))
    columns: list[_Column] = [("", [_shorten(name) for name in names], str.ljust)] if any(names) else []
    columns += [_column(result, path) for path in s["vary"]]
    columns += [("outcome", outcomes, str.ljust)] if any(outcomes) else []
    numbers = [_column(result, name) for name in shown_numbers(result)[:_COLUMNS]]
    if not numbers:  # no numbers for columns: the verdict of each variant
        numbers = [("", list(map(str, result.sentence.values)), str.ljust)]
    more = [f"and {result.sizes['variant'] - _MOST_LINES} more"] if result.sizes["variant"] > _MOST_LINES else []
    failures = [f"{v['label']}: {v['failure']}" for v in s["variants"] if v["failure"]]
    return [
        result.attrs["title"],
        f"verdict: {result.attrs['sentence']}",
        *(f"  {line}" for line in [*_table_lines([*columns, *numbers]), *more, *failures]),
    ]


def variant_names(result: xr.Dataset) -> list[str]:
    """Return the names of the variants without varied values."""
    return [str(v) for v in result.get("name", result.variant).values]


def shown_numbers(result: xr.Dataset) -> list[str]:
    """Return the headline numbers of the summaries, those equal in all variants last."""
    s = result.wucht.summary
    numbers = [n for n in result.data_vars if result[n].dims == ("variant",) and result[n].dtype.kind == "f"]
    headlines = [n for n in s["headline"] if n in numbers and np.isfinite(result[n].values).any()]
    return sorted(headlines, key=lambda name: _is_constant(result[name].values))


def _is_constant(values: np.ndarray) -> bool:
    """True if all values, two or more, are equal as they are printed."""
    return len(values) > 1 and bool(np.ptp(values) <= _EQUAL * np.abs(values).max())


def _column(result: xr.Dataset, name: str) -> _Column:
    """Return a column with label, unit and values."""
    (factor, unit), values = printed_unit(result, name), result[name].values
    numeric = values.dtype.kind == "f"
    cells = [_number_text(factor * float(v)) if numeric else _shorten(str(v)) for v in values]
    return label(result, name, unit), cells, str.rjust if numeric else str.ljust


def _table_lines(columns: Sequence[_Column]) -> list[str]:
    """Return the lines of a table, with heads of as many lines as they need."""
    heads = [[line.replace("\N{NO-BREAK SPACE}", " ") for line in wrap_text(head, _HEAD_WIDTH)] for head, _, _ in columns]
    depth = max(map(len, heads)) if any(map(any, heads)) else 0
    cells = [
        ([""] * (depth - len(head)) + head)[:depth] + column_cells[:_MOST_LINES]
        for head, (_, column_cells, _) in zip(heads, columns, strict=True)
    ]
    widths = [max(map(len, column_cells)) for column_cells in cells]
    rows = zip(*cells, strict=True)
    return [
        "  ".join(align(*of) for of, (_, _, align) in zip(zip(row, widths, strict=True), columns, strict=True)).rstrip()
        for row in rows
    ]


def _number_text(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.5g}"


def _shorten(text: str) -> str:
    return text if len(text) <= _CELL_WIDTH else f"{text[: _CELL_WIDTH - 3]}..."
