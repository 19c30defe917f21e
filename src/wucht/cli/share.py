"""``wucht share``: a machine as one page of HTML, in which it moves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.completing import study_names
from wucht.cli.options import Imports, Settings


def share(
    study: Annotated[
        str,
        typer.Argument(
            metavar="FILE", autocompletion=study_names, help="A study or machine file, or a name from `wucht list`."
        ),
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="The page of HTML to write.")] = Path("machine.html"),
    set_: Settings = None,
    verdict: Annotated[
        bool | None,
        typer.Option(
            "--verdict/--no-verdict", help="Run the machine up for a verdict, or not; by default where the file asks for it."
        ),
    ] = None,
    import_: Imports = None,
) -> None:
    """Write a machine as one page of HTML to send: it moves in any browser, without a network."""
    from wucht.cli.options import parse_settings
    from wucht.web.shared_study import write_page

    typer.echo(str(write_page(study, out, parse_settings(set_ or []), verdict)))
