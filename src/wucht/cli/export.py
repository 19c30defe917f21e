"""``wucht export``: files of a result for other programs and machines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.options import Imports
from wucht.errors import InputError


def export(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`, or the folder that has it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    csv: Annotated[bool, typer.Option("--csv", help="The variables of any result as CSV, with units.")] = False,
    import_: Imports = None,
) -> None:
    """Export a result: of a cam the points to mill, drawings and tables for controllers; of any study its variables as CSV."""
    from wucht.results.output_folder import load_result, result_file
    from wucht.results.store import prepare_folder, save_csv
    from wucht.studies.runner import export as export_files

    dataset, file = load_result(result), result_file(result)
    folder = out or file.parent
    try:
        lines = list(map(str, save_csv(dataset, prepare_folder(folder)))) if csv else export_files(dataset, folder)
    except InputError as error:
        raise error if error.location == "-o" else error.with_file(file) from None
    for line in lines:
        typer.echo(line)
