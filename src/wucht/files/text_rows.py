"""Rows of text files with columns, as spreadsheets and loggers write them."""

from __future__ import annotations

import re

_BLANK_OUTSIDE_BRACKETS = re.compile(r"\s+(?![^\[(]*[\])])(?![\[(])")


def cells_of(line: str, separator: str | None, least: int = 1) -> list[str]:
    """Texts in the columns of a row, without quotation marks.

    separator: between columns; None: blanks. least: number of columns kept where a row ends with empty ones.
    """
    cells = line.split(separator) if separator else _BLANK_OUTSIDE_BRACKETS.split(line)
    texts = [c.strip().strip('"').strip() for c in cells]
    while len(texts) > least and not texts[-1]:  # spreadsheets and loggers end their lines with a separator
        texts.pop()
    return texts
