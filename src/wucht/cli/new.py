"""``wucht new``: a commented study file to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.errors import InputError, nearest

_TEMPLATES = Path(__file__).parent / "templates"


def new(
    name: Annotated[str, typer.Argument(help="A study (run-up) or a catalogue name to copy.")],
    file: Annotated[Path | None, typer.Argument(help="The file to write; default NAME.toml here.")] = None,
) -> None:
    """Write a commented study file to start from."""
    from wucht.machines.catalogue import FOLDER, names

    templates = {p.stem: p for p in _TEMPLATES.glob("*.toml")}
    known = {**templates, **{n: FOLDER / f"{n}.toml" for n in names()}}
    if name not in known:
        raise InputError("NAME", name, f"neither a study nor a catalogue name; {nearest(name, known)}")
    target = file or Path(f"{Path(name).name}.toml")
    if _exists(target):
        raise InputError("FILE", str(target), "this file exists already; choose another name")
    try:
        target.write_text(known[name].read_text(encoding="utf-8"), encoding="utf-8")
    except OSError as error:
        raise InputError("FILE", str(target), f"it cannot be written: {error.strerror}") from None
    typer.echo(f"{target}: edit it, then `wucht run {target}`")


def _exists(target: Path) -> bool:
    try:
        return target.exists()
    except (OSError, ValueError) as error:
        raise InputError("FILE", str(target), f"this cannot be the name of a file: {error}") from None
