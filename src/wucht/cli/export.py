"""``wucht export``: what a result has for others, in their files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.importing import Imports
from wucht.errors import InputError


def export(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    import_: Imports = None,
) -> None:
    """Write the files of a result for others: of a cam the points to mill, drawings and tables for controllers."""
    from wucht.results.store import load
    from wucht.studies.runner import export as written

    dataset = load(result)
    try:
        files = written(dataset, out or result.parent)
    except InputError as error:
        raise error.in_file(result) from None
    for line in files:
        typer.echo(line)
