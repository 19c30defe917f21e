"""``wucht list``: all parts, studies and catalogue names, a line each; of a study or part all its keys."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wucht.cli.options import Imports
from wucht.errors import InputError, nearest

if TYPE_CHECKING:
    from wucht.schema import Key

_WIDEST = 44  # of a column
_HELP = " " * 6  # before the help of a key, below it


def list_all(
    name: Annotated[str | None, typer.Argument(help="A study, or a kind of part: list its keys.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the keys as one JSON object.")] = False,
    import_: Imports = None,
) -> None:
    """List parts, drives, models, laws and followers of cams, studies and the catalogue; with a NAME, its keys."""
    if as_json and name is None:
        raise InputError("--json", None, "allowed only with the name of a study or part")
    if name is not None:
        _list_one(name, as_json)
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


def kinds() -> dict[str, Mapping[str, type]]:
    """All kinds that a file can name, except studies, by category."""
    from wucht.cams.drive import followers, laws, linkages
    from wucht.machines.models import models
    from wucht.machines.parts import attachments, bodies, carriers, drives, loads

    parts: dict[str, Mapping[str, type]] = {"carriers": carriers(), "bodies": bodies(), "drives": drives(), "loads": loads()}
    parts["attachments"] = attachments()
    of_cams: dict[str, Mapping[str, type]] = {"laws of cams": laws(), "followers": followers(), "linkages": linkages()}
    return {**parts, "dimensionless machines": models(), **of_cams}


def _first_lines(kinds: Mapping[str, type]) -> dict[str, str]:
    from wucht.schema import prose_of

    return {name: prose_of(cls).partition("\n")[0] for name, cls in kinds.items()}


_TABLES = {
    "carriers": '[machine.carrier] directions = "{}"', "bodies": '[[machine.bodies]] kind = "{}"',
    "drives": '[machine.drive] kind = "{}"', "loads": '[[machine.loads]] kind = "{}"',
    "attachments": '[[machine.attachments]] kind = "{}"',
    "dimensionless machines": '[machine] model = "{}", keys of [machine.parameters]', "laws of cams": '[law] kind = "{}"',
    "followers": '[follower] kind = "{}"', "linkages": '[linkage] kind = "{}"', "studies": '[study] kind = "{}"',
}  # fmt: skip


def _list_one(name: str, as_json: bool) -> None:
    """Print all keys of each study or part with this name: a drive and a load may share one, as both kinds ``table`` do."""
    from wucht.files.equal_bodies import keys_in_files
    from wucht.schema import prose_of
    from wucht.studies.registry import studies

    kinds_by_title: dict[str, Mapping[str, Any]] = {**kinds(), "studies": studies()}
    matches = {title: of_kind[name] for title, of_kind in kinds_by_title.items() if name in of_kind}
    if not matches:
        from wucht.files.catalogue import names

        if entries := [n for n in names() if name in n]:
            hint = f"`wucht new {entries[0]}` copies {'it' if len(entries) == 1 else 'the first'}"
            raise InputError("NAME", name, f"neither a study nor a part; in the catalogue: {', '.join(entries)}; {hint}")
        raise InputError(
            "NAME", name, f"neither a study nor a part; {nearest(name, {n for k in kinds_by_title.values() for n in k})}"
        )
    descriptions = []
    for title, one in matches.items():
        cls = one.spec if title == "studies" else one
        descriptions.append(
            (_TABLES[title].format(name), prose_of(cls), keys_in_files(cls), getattr(cls, "internal_states", ()))
        )
    if as_json:
        tables = [
            {"table": table, "description": text, "keys": [asdict(k) for k in keys]}
            | ({"states": [asdict(x) for x in states]} if states else {})
            for table, text, keys, states in descriptions
        ]
        typer.echo(json.dumps({"name": name, "tables": tables}, indent=2, ensure_ascii=False))
        return
    for k, (table, text, keys, states) in enumerate(descriptions):
        typer.echo("\n" * bool(k) + f"{table}\n\n{text.replace('``', '')}\n")
        head, *rows = _rows([("key", "value", "unit", "default", "allowed"), *map(_cells, keys)])
        typer.echo(head)
        for key, row in zip(keys, rows, strict=True):
            typer.echo(f"{row}\n{fill(key.what.replace('`', ''), 100, initial_indent=_HELP, subsequent_indent=_HELP)}")
        if states:
            typer.echo("\nInternal states, in results and in start:\n")
            typer.echo("\n".join(_rows([("state", "unit", ""), *((x.name, x.unit, x.what) for x in states)])))


def _cells(key: Key) -> tuple[str, ...]:
    default = "needed" if key.needed else _default(key.default)
    return key.name, key.type, key.unit or "", default, key.allowed


def _rows(cells: Sequence[tuple[str, ...]]) -> list[str]:
    """The lines of a table with aligned columns."""
    widths = [min(max(map(len, column)), _WIDEST) for column in zip(*cells, strict=True)]
    return ["  " + "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in cells]


def _default(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)
