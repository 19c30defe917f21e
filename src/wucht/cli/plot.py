"""``wucht plot``: draw the figures again, from the file alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.options import DEFAULT_STYLE, FormatOption, Imports, StyleOption, write_figure
from wucht.errors import InputError


def plot(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`, or the folder that has it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    style: StyleOption = DEFAULT_STYLE,
    format_: FormatOption = None,
    import_: Imports = None,
) -> None:
    """Draw the figures of a result again."""
    from wucht.results.output_folder import load_result, note_figure, result_file
    from wucht.results.store import prepare_folder

    dataset, file = load_result(result), result_file(result)
    folder = prepare_folder(out or file.parent)
    try:
        figures = write_figure(dataset, folder, style, format_)
    except InputError as error:
        raise error.with_file(file) from None
    for figure in figures:
        note_figure(figure)
        typer.echo(str(figure))
