"""``wucht plot``: draw the figures again, from the file alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.options import DEFAULT_STYLE, FormatOption, Imports, StyleOption, draw_on, figure_names
from wucht.errors import InputError, RunError


def plot(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`, or the folder that has it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    style: StyleOption = DEFAULT_STYLE,
    format_: FormatOption = None,
    import_: Imports = None,
) -> None:
    """Draw the figures of a result again."""
    from wucht.plots.sheet import save_figure
    from wucht.results.attempts import reason_of
    from wucht.results.output_folder import load_result, note_figure, result_file
    from wucht.results.store import file_name, prepare_folder

    dataset, file = load_result(result), result_file(result)
    folder = prepare_folder(out or file.parent)
    try:
        figure = draw_on(dataset, style)
    except InputError as error:
        raise error.with_file(file) from None
    except Exception as error:  # of a study of another package, or a fault of ours
        raise RunError(f"{file}: its figure cannot be drawn: {reason_of(error)}") from error
    for name in figure_names(str(dataset.attrs["study"]), format_):
        path = save_figure(figure, folder / file_name(name, dataset))
        note_figure(path, dataset)
        typer.echo(str(path))
