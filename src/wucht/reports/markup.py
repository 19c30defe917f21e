"""Elements of a page of HTML: escaped text, tables, lists, figures, and the page around them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from wucht.file_names import replace_non_utf8

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"  # a browser loads nothing from elsewhere
_LONGEST = 600  # characters of a text, except of a study file
_HEADING = 160  # of a title
_SHORT = 24  # rows of a table that is not broken over two pages
_FEW = 6  # columns of a table with letters of the usual size


def html_text(words: object, longest: int = _LONGEST) -> str:
    """Text in HTML: escaped, without control characters, shortened to ``longest``."""
    clean = "".join(_printable(letter) for letter in brief_text(replace_non_utf8(str(words)), longest))
    return escape(clean)


def brief_text(words: str, longest: int = _HEADING) -> str:
    """A text of at most this many characters, with an ellipsis where some are left out."""
    return words if len(words) <= longest else f"{words[: longest - 1].rstrip()}…"


def _printable(letter: str) -> str:
    """A character that HTML allows and that changes no other: no control character, no change of the direction of writing."""
    if letter in "\n\t":
        return letter
    return "\N{REPLACEMENT CHARACTER}" if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Co", "Cn") else letter


def html_table(
    rows: Iterable[Sequence[str]], head: Sequence[str] = (), *, caption: str = "", kind: str = "", row_heads: bool = False
) -> str:
    """A table of cells that are HTML already. Empty where there are no rows. row_heads: the first cell of a row is its name."""
    lines = list(rows)
    if not lines:
        return ""
    wide = "wide" if len(lines[0]) > _FEW else ""
    classes = " ".join(filter(None, (kind, wide, "short" if len(lines) <= _SHORT else "")))
    first = "th" if row_heads else "td"
    body = "\n".join(
        f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for tag, cell in zip([first, *['td'] * len(row)], row, strict=False))}</tr>"
        for row in lines
    )
    top = f"<thead><tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr></thead>" if head else ""
    top_line = f"<caption>{caption}</caption>" if caption else ""
    return f'<table class="{classes}">{top_line}{top}<tbody>\n{body}\n</tbody></table>'


def bullets(lines: Iterable[str]) -> str:
    """A list of texts; empty where there are none."""
    items = "".join(f"<li>{html_text(line)}</li>" for line in lines)
    return f"<ul>{items}</ul>" if items else ""


def section(heading: str, *contents: str, level: int = 2) -> str:
    """A heading with its contents; empty where all of them are."""
    inner = "\n".join(filter(None, contents))
    return f"<h{level}>{html_text(heading, _HEADING)}</h{level}>\n{inner}" if inner else ""


def page(title: str, body: str) -> str:
    """The whole page. title: as plain text, at the foot of each printed page as well."""
    style = files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    note = '; font: 8pt "Helvetica Neue", Arial, sans-serif; color: #59636d; }'
    foot = (
        f'@page {{ @bottom-left {{ content: "{_style_string(brief_text(title, 90))}"{note} '
        f'@bottom-right {{ content: counter(page) " / " counter(pages){note} }}'
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html_text(title, _HEADING)}</title>\n<style>\n{style}{foot}\n</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def _style_string(words: str) -> str:
    """A text within quotation marks of a style sheet: no character of it can end the text or the sheet."""
    clean = "".join(map(_printable, replace_non_utf8(words))).replace("\n", " ")
    return re.sub(r"[^\w .,:;()+-]", lambda match: f"\\{ord(match[0]):06x}", clean)
