"""The comparison in words: a table with a line a variant."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.results.conventions import summary_of
from wucht.results.style import with_unit

if TYPE_CHECKING:
    import xarray as xr

_COLUMNS, _MOST_LINES, _WIDEST = 6, 60, 60


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht compare`` prints: the numbers looked at first, and of others those that differ."""
    s = summary_of(result)
    names = shown_numbers(result)[:_COLUMNS]
    header = ["", "outcome", *(with_unit(name, str(result[name].attrs["units"])) for name in names)]
    rows = [
        [_cut(str(v)), str(result.outcome.values[k]), *(_number(float(result[name].values[k])) for name in names)]
        for k, v in enumerate(result.variant.values[:_MOST_LINES])
    ]
    if not names:  # nothing to put into columns: each one's answer in words
        header, rows = [*header, ""], [[*row, str(result.sentence.values[k])] for k, row in enumerate(rows)]
    if not any(row[1] for row in rows):
        header, rows = header[:1] + header[2:], [row[:1] + row[2:] for row in rows]
    widths = [max(len(line[k]) for line in (header, *rows)) for k in range(len(header))]
    left = len(header) - len(names)
    lines = [
        "  ".join(cell.ljust(w) if k < left else cell.rjust(w) for k, (cell, w) in enumerate(zip(line, widths, strict=True)))
        for line in (header, *rows)
    ]
    more = [f"and {result.sizes['variant'] - _MOST_LINES} more"] if result.sizes["variant"] > _MOST_LINES else []
    failures = [f"{v['label']}: {v['failure']}" for v in s["variants"] if v["failure"]]
    return [
        result.attrs["title"],
        f"verdict: {result.attrs['sentence']}",
        *(f"  {line.rstrip()}" for line in lines + more + failures),
    ]


def shown_numbers(result: xr.Dataset) -> list[str]:
    """Numbers of the summaries, those looked at first before the others; what is the same in all of them last."""
    s = summary_of(result)
    numbers = [n for n in result.data_vars if result[n].dims == ("variant",) and result[n].dtype.kind == "f"]
    known = [n for n in s["headline"] if n in numbers and np.isfinite(result[n].values).any()]
    return sorted(known, key=lambda name: _same(result[name].values))


def _same(values: np.ndarray) -> bool:
    return len(values) > 1 and bool(np.all(values == values[0]))


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.5g}"


def _cut(text: str) -> str:
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 3]}..."
