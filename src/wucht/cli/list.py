"""``wucht list``: all groups of names on a screen, a line for each name of one, and of one name what it is."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from wucht.cli.completing import listed_names
from wucht.cli.options import Imports
from wucht.errors import InputError


def list_all(
    name: Annotated[
        str | None,
        typer.Argument(
            help="A group (carriers, studies, practice), a study, a kind of part, or a catalogue name: what it is.",
            autocompletion=listed_names,
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what it is as one JSON object, with all keys.")] = False,
    every_key: Annotated[bool, typer.Option("--all", help="List all keys of NAME at length, on more than a screen.")] = False,
    search: Annotated[
        str | None, typer.Option("--search", metavar="WORD", help="What has this word in its name, text, keys or results.")
    ] = None,
    import_: Imports = None,
) -> None:
    """List parts, laws and followers of cams, studies and the catalogue; with a NAME, what it is."""
    from wucht.cli.list_groups import column_lines, group_names, lines_of, overview
    from wucht.cli.list_name import describe_name
    from wucht.cli.list_search import search_lines

    for option, is_given in (("--json", as_json), ("--all", every_key)):
        if is_given and name is None:
            raise InputError(option, None, "allowed only with the name of a study, a part or a file of the catalogue")
    if search is not None:
        if name is not None:
            raise InputError("--search", search, f"give either a word or the name {name!r}")
        lines = search_lines(search)
    elif name is None:
        lines = list(overview())
    elif name in group_names():
        entries = lines_of(name)
        lines = (
            [json.dumps({"name": name, "names": entries}, indent=2, ensure_ascii=False)]
            if as_json
            else [*column_lines(entries)]
        )
    else:
        lines = [describe_name(name, as_json=as_json, every_key=every_key, groups=group_names())]
    for line in lines:
        typer.echo(line)
