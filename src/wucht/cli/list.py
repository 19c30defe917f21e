"""``wucht list``: all parts, studies and catalogue names, a line each; of one name what it is, on a screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import typer

from wucht.cli.completing import listed_names
from wucht.cli.options import Imports
from wucht.errors import InputError


def list_all(
    name: Annotated[
        str | None,
        typer.Argument(help="A study, a kind of part, or a catalogue name: what it is.", autocompletion=listed_names),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what it is as one JSON object, with all keys.")] = False,
    every_key: Annotated[bool, typer.Option("--all", help="List all keys of NAME at length, on more than a screen.")] = False,
    import_: Imports = None,
) -> None:
    """List parts, drives, models, laws and followers of cams, studies and the catalogue; with a NAME, what it is."""
    from wucht.cli.list_name import describe_name, kinds

    for option, is_given in (("--json", as_json), ("--all", every_key)):
        if is_given and name is None:
            raise InputError(option, None, "allowed only with the name of a study, a part or a file of the catalogue")
    if name is not None:
        typer.echo(describe_name(name, as_json=as_json, every_key=every_key))
        return
    from wucht.files.catalogue import FOLDER, names
    from wucht.files.documents import read_toml
    from wucht.studies.registry import studies

    sections = {title: _first_lines(of_kind) for title, of_kind in kinds().items()}
    sections["studies"] = {kind: study.line for kind, study in studies().items()}
    sections["catalogue"] = {n: str(read_toml(FOLDER / f"{n}.toml").get("title", "")) for n in names()}
    for title, entries in sections.items():
        typer.echo(f"{title}:")
        width = max(map(len, entries))
        for entry, line in entries.items():
            typer.echo(f"  {entry:{width}}  {line}")


def _first_lines(kinds: Mapping[str, type]) -> dict[str, str]:
    from wucht.schema import prose_of

    return {name: prose_of(cls).partition("\n")[0] for name, cls in kinds.items()}
