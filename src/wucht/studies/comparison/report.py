"""The comparison in words: a table with a line a variant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.formatting import label, printed_unit, wrapped

if TYPE_CHECKING:
    import xarray as xr

_COLUMNS, _MOST_LINES, _WIDEST = 6, 60, 60
_HEADED = 16  # letters of a line of a column's head, where words can be broken so


@dataclass(frozen=True)
class _Column:
    """Of the table. left: whether its cells stand at the left, as texts do."""

    head: str
    cells: list[str]
    left: bool = True


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht compare`` prints: the numbers looked at first, and of others those that differ."""
    s, names, outcomes = result.wucht.summary, names_of(result), list(map(str, result.outcome.values))
    columns = [_Column("", [_cut(name) for name in names])] if any(names) else []
    columns += [_column(result, path) for path in s["vary"]]
    columns += [_Column("outcome", outcomes)] if any(outcomes) else []
    numbers = [_column(result, name) for name in shown_numbers(result)[:_COLUMNS]]
    if not numbers:  # nothing to put into columns: each one's answer in words
        numbers = [_Column("", list(map(str, result.sentence.values)))]
    more = [f"and {result.sizes['variant'] - _MOST_LINES} more"] if result.sizes["variant"] > _MOST_LINES else []
    failures = [f"{v['label']}: {v['failure']}" for v in s["variants"] if v["failure"]]
    return [
        result.attrs["title"],
        f"verdict: {result.attrs['sentence']}",
        *(f"  {line}" for line in [*_table([*columns, *numbers]), *more, *failures]),
    ]


def names_of(result: xr.Dataset) -> list[str]:
    """What the variants are called, but for what is varied."""
    return [str(v) for v in result.get("name", result.variant).values]


def shown_numbers(result: xr.Dataset) -> list[str]:
    """Numbers of the summaries, those looked at first before the others; what is the same in all of them last."""
    s = result.wucht.summary
    numbers = [n for n in result.data_vars if result[n].dims == ("variant",) and result[n].dtype.kind == "f"]
    known = [n for n in s["headline"] if n in numbers and np.isfinite(result[n].values).any()]
    return sorted(known, key=lambda name: _same(result[name].values))


def _same(values: np.ndarray) -> bool:
    return len(values) > 1 and bool(np.all(values == values[0]))


def _column(result: xr.Dataset, name: str) -> _Column:
    """What it is, with its unit, and its values."""
    (factor, unit), values = printed_unit(result, name), result[name].values
    numeric = values.dtype.kind == "f"
    cells = [_number(factor * float(v)) if numeric else _cut(str(v)) for v in values]
    return _Column(label(result, name, unit), cells, not numeric)


def _table(columns: Sequence[_Column]) -> list[str]:
    """The lines of a table, with heads of as many lines as they need."""
    heads = [[line.replace("\N{NO-BREAK SPACE}", " ") for line in wrapped(column.head, _HEADED)] for column in columns]
    depth = max(map(len, heads))
    cells = [
        [""] * (depth - len(head)) + head + column.cells[:_MOST_LINES] for head, column in zip(heads, columns, strict=True)
    ]
    widths = [max(map(len, own)) for own in cells]
    sides = [str.ljust if column.left else str.rjust for column in columns]
    rows = zip(*cells, strict=True)
    return [
        "  ".join(side(*of) for side, of in zip(sides, zip(row, widths, strict=True), strict=True)).rstrip() for row in rows
    ]


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.5g}"


def _cut(text: str) -> str:
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 3]}..."
