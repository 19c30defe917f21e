"""Rows of text files with columns, as spreadsheets and loggers write them."""

from __future__ import annotations

import csv
import re

_BLANK_OUTSIDE_BRACKETS = re.compile(r"\s+(?![^\[(]*[\])])(?![\[(])")
_TEXT_IN_QUOTES = re.compile(r'"[^"]*"')
_BEFORE_COMMENT = re.compile(r'(?:[^"#]|"[^"]*")*')


def without_comment(line: str) -> str:
    """A line up to the ``#`` of a comment; one between quotation marks belongs to the text of a cell."""
    if "#" not in line:
        return line.strip()
    before = _BEFORE_COMMENT.match(line) if has_closed_quotes(line) else None
    return (line.split("#", 1)[0] if before is None else before[0]).strip()


def has_closed_quotes(line: str) -> bool:
    """True if each quotation mark of a line has its counterpart in it."""
    return line.count('"') % 2 == 0


def separator_of(line: str) -> str | None:
    """The character between the columns of a row, a semicolon, a tab or a comma outside quotation marks; None: blanks."""
    bare = _TEXT_IN_QUOTES.sub("", line) if '"' in line else line
    return next((s for s in ";\t," if s in bare), None)


def cells_of(line: str, separator: str | None, least: int = 1) -> list[str]:
    """Texts in the columns of a row, without quotation marks; a separator between these does not separate.

    separator: between columns; None: blanks. least: number of columns kept where a row ends with empty ones.
    """
    cells = _quoted_cells(line, separator) if '"' in line and has_closed_quotes(line) else None
    if cells is None:
        cells = [c.strip().strip('"') for c in (line.split(separator) if separator else _BLANK_OUTSIDE_BRACKETS.split(line))]
    texts = [c.strip() for c in cells]
    while len(texts) > least and not texts[-1]:  # spreadsheets and loggers end their lines with a separator
        texts.pop()
    return texts


def _quoted_cells(line: str, separator: str | None) -> list[str] | None:
    try:
        return next(csv.reader([line], delimiter=separator or " ", skipinitialspace=True), [])
    except csv.Error:  # a cell of more than 131,072 letters
        return None


def plain_number(text: str) -> float:
    """The number that a text of the digits 0 to 9 states. Raises ``ValueError``: other digits and underscores, which Python
    takes too, may be a fault of the file."""
    if not text.isascii() or "_" in text:
        raise ValueError(text)
    return float(text)


def remedy_of_number(text: str) -> str:
    """How to write a text that is no number so that it is one, for the end of a sentence; empty where that is not known."""
    if any(c.isdigit() and not c.isascii() for c in text):
        return "; write it with the digits 0 to 9"
    if "_" in text:
        return "; write it without underscores"
    if "'" in text:
        return "; write it without apostrophes"
    if "," in text and any(c.isdigit() for c in text):
        return "; write a decimal point, and nothing between thousands"
    return ""
