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
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    format_: Annotated[Format, typer.Option("--format", help="File format.")] = Format.PNG,
    import_: Imports = None,
) -> None:
    """Draw the figures of a result again."""
    from wucht.results.store import load, prepare_folder, save_figure
    from wucht.studies.runner import draw

    dataset = load(result)
    folder = prepare_folder(out or result.parent)
    target = folder / f"{dataset.attrs['study']}.{format_.value}"
    try:
        figure = draw(dataset)
    except InputError as error:
        raise error.in_file(result) from None
    save_figure(figure, target)
    typer.echo(str(target))
