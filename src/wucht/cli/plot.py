"""``wucht plot``: the figures again, from the file alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.figure_options import PNG, PRINTED, Formatted, Styled, write_figure
from wucht.cli.importing import Imports
from wucht.errors import InputError


def plot(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    style: Styled = PRINTED,
    format_: Formatted = PNG,
    import_: Imports = None,
) -> None:
    """Draw the figures of a result again."""
    from wucht.results.store import load, prepare_folder

    dataset = load(result)
    folder = prepare_folder(out or result.parent)
    try:
        target = write_figure(dataset, folder, style, format_)
    except InputError as error:
        raise error.within(str(result), ": ") from None
    typer.echo(str(target))
