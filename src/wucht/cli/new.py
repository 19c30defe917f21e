"""``wucht new``: a commented study file to start from."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.completing import template_names
from wucht.cli.options import Imports
from wucht.errors import InputError


def new(
    name: Annotated[
        str | None, typer.Argument(help="A study (run-up) or a catalogue name to copy.", autocompletion=template_names)
    ] = None,
    file: Annotated[Path | None, typer.Argument(help="The file to write, - for stdout; default NAME.toml here.")] = None,
    ask: Annotated[bool, typer.Option("--ask", help="Ask five questions about your machine; NAME is then the file.")] = False,
    import_: Imports = None,
) -> None:
    """Write a commented study file to start from: of a study, a copy from the catalogue, or of a machine by five questions."""
    if ask:
        _write_answered(name, file)
        return
    if name is None:
        raise InputError("NAME", None, "give a study or a catalogue name (`wucht list` prints all), or --ask", code="missing")
    from wucht.files.catalogue import FOLDER, names, nearest_names
    from wucht.studies.registry import studies

    known_names = [*studies(), *names()]
    if name not in known_names:
        raise InputError("NAME", name, f"must be a study or a catalogue name; {nearest_names(name, known_names)}")
    template = studies()[name].template if name in studies() else (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    _write(template, file or Path(f"{Path(name).name}.toml"))


def _write_answered(name: str | None, second: Path | None) -> None:
    """Ask about a machine, and write its file, which is checked before. Raises ``InputError`` where nobody can answer."""
    import tomllib

    from wucht.files.building import machine_from

    if second is not None:
        raise InputError("FILE", str(second), "with --ask give one name, that of the file to write")
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise InputError("--ask", None, "questions need a terminal; `wucht new run-up` writes a file to be edited")
    if name is not None:
        _refuse_existing(Path(name))
    from wucht.cli.machine_dialog import machine_of_dialog

    purpose, text = machine_of_dialog()
    machine_from(tomllib.loads(text)["machine"])
    _write(text, Path(name or f"my-{purpose}.toml"))


def _write(text: str, target: Path) -> None:
    if target == Path("-"):
        typer.echo(text, nl=False)
        return
    _refuse_existing(target)
    try:
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        with suppress(OSError):  # of which only a part may have been written
            target.unlink(missing_ok=True)
        raise InputError("FILE", str(target), f"it cannot be written: {error.strerror}") from None
    typer.echo(f"{target}: edit it, then `wucht run {target}`")


def _refuse_existing(target: Path) -> None:
    if target != Path("-") and _exists(target):
        raise InputError("FILE", str(target), "this file exists already; choose another name")


def _exists(target: Path) -> bool:
    try:
        return target.exists()
    except (OSError, ValueError) as error:
        raise InputError("FILE", str(target), f"this cannot be the name of a file: {error}") from None
