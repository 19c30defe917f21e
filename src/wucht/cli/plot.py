"""``wucht plot``: the figures again, from the file alone."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.importing import Imports
from wucht.errors import InputError


class Format(StrEnum):
    """File formats of figures."""

    PNG = "png"
    PDF = "pdf"
    SVG = "svg"


def plot(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`, or the folder that has it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    format_: Annotated[list[Format] | None, typer.Option("--format", help="File format, default png; repeatable.")] = None,
    import_: Imports = None,
) -> None:
    """Draw the figures of a result again."""
    from wucht.results.output_folder import note_figure
    from wucht.results.store import load, prepare_folder, result_file, save_figure
    from wucht.studies.runner import draw

    dataset, file = load(result), result_file(result)
    folder = prepare_folder(out or file.parent)
    try:
        figure = draw(dataset)
    except InputError as error:
        raise error.in_file(file) from None
    for ending in dict.fromkeys(format_ or [Format.PNG]):
        drawn = save_figure(figure, folder / f"{dataset.attrs['study']}.{ending.value}")
        note_figure(drawn)
        typer.echo(str(drawn))
