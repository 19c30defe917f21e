"""``wucht report``: results as one page of HTML to send."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.options import Imports


def report(
    results: Annotated[
        list[Path], typer.Argument(metavar="RESULT...", help="Results written by `wucht run`, or their folders.")
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="The page of HTML to write.")] = Path("report.html"),
    title: Annotated[str, typer.Option("--title", help="Title of the report; default that of its only result.")] = "",
    everything: Annotated[
        bool, typer.Option("--all", help="Also the candidates that a search has tried and not chosen.")
    ] = False,
    import_: Imports = None,
) -> None:
    """Write results as one file to send: a page of HTML that prints on A4 and opens without a network."""
    from wucht.reports.html_report import write_report

    typer.echo(str(write_report(results, out, title, everything=everything)))
