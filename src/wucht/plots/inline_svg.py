"""Figures as SVG inside a page of HTML: text as text, no address outside, and identifiers that no other figure has."""

from __future__ import annotations

import io
import re
import warnings
from typing import TYPE_CHECKING

from wucht.plots.page import page_context
from wucht.plots.sheet import page_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTHING = dict.fromkeys(("Date", "Creator", "Format", "Type"))  # of metadata: they have a date and addresses
_OPENING = re.compile(r"<svg\b[^>]*>")
_NAMESPACE = re.compile(r'\s+xmlns(?::\w+)?="[^"]*"')
_SIZE = re.compile(r'\s(?:width|height)="[\d.]+pt"')
_ID = re.compile(r'\sid="([^"]+)"')
_REFERENCE = re.compile(r'(url\(#|href="#)([^")]+)')
_RIM = 0.03  # around everything that is drawn, in inches
_DECIMALS = re.compile(r"(\d\.\d\d)\d+")
_PATH = re.compile(r'(?<= d=")[^"]*')


def inline_svg(figure: Figure, prefix: str, label: str) -> str:
    """Draw a figure as an SVG element for a page of HTML.

    Parameters
    ----------
    figure : Figure
        One that has been arranged.
    prefix : str
        Beginning of its identifiers, unique among the figures of the page: letters, digits and hyphens.
    label : str
        The figure in words, for readers who do not see it, already escaped for HTML.

    Returns
    -------
    str
        The same for the same figure and prefix.
    """
    from matplotlib import rc_context

    file = io.StringIO()
    with warnings.catch_warnings(), page_context(page_of(figure)):
        warnings.filterwarnings("ignore", "Glyph", UserWarning)  # a name in a script that the font lacks
        with rc_context({"svg.hashsalt": "wucht", "svg.fonttype": "none"}):
            # A legend may be taller than the first panel of a figure without a heading.
            figure.savefig(file, format="svg", metadata=_NOTHING, bbox_inches="tight", pad_inches=_RIM)
    text = file.getvalue()
    # Its style sheet would hold for the whole page, which has the same rules for figures.
    text = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", text[text.index("<svg") :], flags=re.DOTALL)
    # Coordinates are in points: hundredths are finer than any print.
    text = _PATH.sub(lambda path: _short_path(path[0]), text.replace("xlink:href", "href"))
    references = {match[2] for match in _REFERENCE.finditer(text)}
    text = _ID.sub(lambda match: f' id="{prefix}-{match[1]}"' if match[1] in references else "", text)
    text = _REFERENCE.sub(lambda match: f"{match[1]}{prefix}-{match[2]}", text)
    opening = _SIZE.sub("", _NAMESPACE.sub("", _OPENING.match(text)[0]))  # type: ignore[index]
    opening = opening.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
    return _OPENING.sub(lambda _: opening, text, count=1).strip()


def _short_path(path: str) -> str:
    """The same path in fewer characters."""
    return re.sub(r"\s+(?=[A-Za-z]|$)|(?<=[A-Za-z])\s+", "", _DECIMALS.sub(r"\1", path))
