"""What the commands that draw figures have in common: on which page, in which format, and how they are written."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wucht.results.page import JOURNAL, PAGES, PRINT

if TYPE_CHECKING:
    import xarray as xr


class Style(StrEnum):
    """On what figures are printed."""

    PRINT = PRINT.name
    JOURNAL = JOURNAL.name


class Format(StrEnum):
    """File formats of figures."""

    PNG = "png"
    PDF = "pdf"
    SVG = "svg"


Styled = Annotated[
    Style,
    typer.Option("--style", help="On what the figure is printed: a page, or a column of a journal (88 mm, 8 pt, no title)."),
]
Formatted = Annotated[Format, typer.Option("--format", help="File format of the figure.")]
PRINTED, PNG = Style.PRINT, Format.PNG


def write_figure(result: xr.Dataset, folder: Path, style: Style = PRINTED, format_: Format = PNG) -> Path:
    """Draw the figure of a result and write it into a folder, named as its study. Raises as ``draw`` and ``save_figure`` do."""
    from wucht.results.store import save_figure
    from wucht.studies.runner import draw

    return save_figure(draw(result, PAGES[style.value]), folder / f"{result.attrs['study']}.{format_.value}")
