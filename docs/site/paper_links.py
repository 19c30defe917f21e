"""Numbers of equations, tables and figures of the papers as links to the line of their paper in the page of sources."""

from __future__ import annotations

import re
from pathlib import PurePosixPath

SOURCES = "sources.md"
# A paper with a number: 002 (4.60)-(4.62), 001 (20), 000 Table 1.
_ONE = r"\([A-Z]?\.?\d[\w.]*\)"
_NUMBER = re.compile(
    rf"(?<![\w\[.,-])(00[0124]) ({_ONE}(?:(?:-|, | and ){_ONE})*|(?:Table|Bild|Abb\.|Tab\.) [A-Z]?\.?\d+(?:\.\d+)?)"
)
_KEPT = re.compile(
    r"^```.*?^```$|^#[^\n]*$|`[^`\n]*`|\[[^\]\n]*\]\([^)\n]*\)|\$\$.*?\$\$|\$[^$\n]*\$", re.MULTILINE | re.DOTALL
)


def with_paper_links(name: str, page: str) -> str:
    """A page with links; code, formulas, headings and links stay as they are. name: of the page, with its folders."""
    if name == SOURCES:
        return page
    target = "../" * (len(PurePosixPath(name).parts) - 1) + SOURCES
    pieces, end = list[str](), 0
    for kept in _KEPT.finditer(page):
        pieces += [_linked(page[end : kept.start()], target), kept[0]]
        end = kept.end()
    return "".join([*pieces, _linked(page[end:], target)])


def _linked(text: str, target: str) -> str:
    return _NUMBER.sub(lambda found: f"[{found[1]} {found[2]}]({target}#paper-{found[1]})", text)
