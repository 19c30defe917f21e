"""``wucht list``: what there is, a line each."""

from __future__ import annotations

from collections.abc import Mapping

import typer


def list_all() -> None:
    """List parts, drives, models, studies and the catalogue."""
    from wucht.documents import read_toml
    from wucht.machines.catalogue import FOLDER, names
    from wucht.machines.models import MODELS
    from wucht.machines.parts import bodies, drives, loads
    from wucht.machines.reading import CARRIERS
    from wucht.studies.kinds import STUDIES

    for title, found in (
        ("carriers", _first(CARRIERS)),
        ("bodies", _first(bodies())),
        ("drives", _first(drives())),
        ("loads", _first(loads())),
        ("dimensionless machines", _first(MODELS)),
        ("studies", _first({name: kind.question for name, kind in STUDIES.items()})),
        ("catalogue", {n: str(read_toml(FOLDER / f"{n}.toml").get("title", "")) for n in names()}),
    ):
        typer.echo(f"{title}:")
        width = max(map(len, found))
        for name, line in found.items():
            typer.echo(f"  {name:{width}}  {line}")


def _first(kinds: Mapping[str, type]) -> dict[str, str]:
    return {name: (cls.__doc__ or "").strip().splitlines()[0] for name, cls in kinds.items()}
