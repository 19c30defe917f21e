"""What the commands that draw figures have in common: on which page, in which format, and how they are written."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wucht.file_names import safe_name
from wucht.plots.page import JOURNAL, PAGES, PRINT

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
    typer.Option(
        "--style",
        help="On what the figure is printed: a page, or a column of a journal "
        "(88 mm, 8 pt, no title; what would be taller than 230 mm goes across both columns).",
    ),
]
Formatted = Annotated[list[Format] | None, typer.Option("--format", help="File format of the figure, default png; repeatable.")]
PRINTED = Style.PRINT


def formats_of(given: Iterable[Format] | None) -> list[Format]:
    """Those that are asked for, each once."""
    return list(dict.fromkeys(given or [Format.PNG]))


def write_figure(
    result: xr.Dataset, folder: Path, style: Style = PRINTED, formats: Iterable[Format] | None = None
) -> list[Path]:
    """Draw the figure of a result and write it into a folder, named as its study. Raises as ``draw`` and ``save_figure`` do."""
    from wucht.plots.saving import save_figure
    from wucht.studies.runner import draw

    figure, name = draw(result, PAGES[style.value]), safe_name(str(result.attrs["study"]))
    return [save_figure(figure, folder / f"{name}.{ending.value}") for ending in formats_of(formats)]
