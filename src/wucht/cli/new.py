"""``wucht new``: a commented study file to start from."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.completing import template_names
from wucht.cli.options import Imports
from wucht.errors import InputError


def new(
    name: Annotated[str, typer.Argument(help="A study (run-up) or a catalogue name to copy.", autocompletion=template_names)],
    file: Annotated[Path | None, typer.Argument(help="The file to write, - for stdout; default NAME.toml here.")] = None,
    import_: Imports = None,
) -> None:
    """Write a commented study file to start from."""
    from wucht.files.catalogue import FOLDER, names, nearest_names
    from wucht.studies.registry import studies

    known_names = [*studies(), *names()]
    if name not in known_names:
        raise InputError("NAME", name, f"must be a study or a catalogue name; {nearest_names(name, known_names)}")
    template = studies()[name].template if name in studies() else (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    if file == Path("-"):
        typer.echo(template, nl=False)
        return
    target = file or Path(f"{Path(name).name}.toml")
    if _exists(target):
        raise InputError("FILE", str(target), "this file exists already; choose another name")
    try:
        target.write_text(template, encoding="utf-8")
    except OSError as error:
        with suppress(OSError):  # of which only a part may have been written
            target.unlink(missing_ok=True)
        raise InputError("FILE", str(target), f"it cannot be written: {error.strerror}") from None
    typer.echo(f"{target}: edit it, then `wucht run {target}`")


def _exists(target: Path) -> bool:
    try:
        return target.exists()
    except (OSError, ValueError) as error:
        raise InputError("FILE", str(target), f"this cannot be the name of a file: {error}") from None
