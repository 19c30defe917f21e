"""``wucht list``: what there is, a line each."""

from __future__ import annotations

from collections.abc import Mapping

import typer

from wucht.cli.importing import Imports


def list_all(import_: Imports = None) -> None:
    """List parts, drives, models, laws and followers of cams, studies and the catalogue."""
    from wucht.cams.tables.follower import FOLLOWERS
    from wucht.cams.tables.kinds_of_law import LAWS
    from wucht.cams.tables.linkage import LINKAGES
    from wucht.files.catalogue import FOLDER, names
    from wucht.files.documents import read_toml
    from wucht.machines.models import models
    from wucht.machines.parts import attachments, bodies, carriers, drives, loads
    from wucht.studies.registry import studies

    kinds: dict[str, Mapping[str, type]] = {"carriers": carriers(), "bodies": bodies(), "drives": drives(), "loads": loads()}
    kinds["attachments"] = attachments()
    kinds |= {"dimensionless machines": models(), "laws of cams": LAWS, "followers": FOLLOWERS, "linkages": LINKAGES}
    listed = {title: _first(of_kind) for title, of_kind in kinds.items()}
    listed["studies"] = {kind: study.line for kind, study in studies().items()}
    listed["catalogue"] = {n: str(read_toml(FOLDER / f"{n}.toml").get("title", "")) for n in names()}
    for title, entries in listed.items():
        typer.echo(f"{title}:")
        width = max(map(len, entries))
        for name, line in entries.items():
            typer.echo(f"  {name:{width}}  {line}")


def _first(kinds: Mapping[str, type]) -> dict[str, str]:
    return {name: (cls.__doc__ or "").strip().splitlines()[0] for name, cls in kinds.items()}
