"""Small pieces of Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence


def cell(text: str) -> str:
    """Text for a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """A table, line by line."""
    lines = [heads, ["---"] * len(heads), *rows]
    return ["| " + " | ".join(map(cell, line)) + " |" for line in lines]


def toml_block(text: str) -> list[str]:
    """A block of TOML, line by line."""
    return ["```toml", *text.strip().splitlines(), "```"]


def naturally(name: str) -> list[tuple[int, str]]:
    """A key to sort by, with which figure-2.10 comes after figure-2.9."""
    return [(int(piece), "") if piece.isdecimal() else (-1, piece) for piece in re.split(r"(\d+)", name)]
