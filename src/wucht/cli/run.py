"""``wucht run``: a study file or catalogue name -> result, figure, summary, verdict."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer

import wucht
from wucht.cli.figure_options import PNG, PRINTED, Formatted, Styled, write_figure
from wucht.cli.importing import Imports


def run(
    study: Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.")],
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; repeatable.")] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default results/NAME.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted run found in the output folder.")] = False,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Compute on the workers of a scheduler of dask.distributed."),
    ] = None,
    style: Styled = PRINTED,
    format_: Formatted = PNG,
    import_: Imports = None,
) -> None:
    """Run a study and say what becomes of the machine."""
    from wucht.cli.interruption import interruptible
    from wucht.cli.progress import Progress
    from wucht.cli.set_option import parse_settings
    from wucht.results.store import save_summary, to_json
    from wucht.studies.runner import RESULT
    from wucht.studies.runner import report as report_of
    from wucht.studies.study_file import answer, read_study

    begun = time.perf_counter()
    folder = out or Path("results") / Path(study).name.removesuffix(".toml")
    with Progress(study) as progress, interruptible() as check:

        def report(share: float, what: str) -> None:
            progress.update(share, what)
            check()

        asked = read_study(study, parse_settings(set_ or []))
        names = _, _, summary = RESULT, f"{asked.spec.kind}.{format_.value}", "summary.json"
        result = answer(asked, folder=folder, files=names, resume=resume, progress=report, scheduler=scheduler)
    write_figure(result, folder, style, format_)
    answered = result.wucht
    document = {
        "study": answered.study,
        "machine": result.attrs["title"],
        "summary": answered.summary,
        "warnings": answered.warnings,
        "files": [str(folder / name) for name in names],
        "units": "dimensionless" if result.attrs["dimensionless"] else "SI",
        "version": wucht.__version__,
        "elapsed_s": round(time.perf_counter() - begun, 3),
    }
    save_summary(document, folder / summary)
    if as_json:
        sys.stdout.write(to_json(document) + "\n")
    else:
        for line in report_of(result):
            typer.echo(line)
        for warning in answered.warnings:
            typer.echo(f"warning: {warning}", err=True)
        typer.echo(f"files: {folder}/{', '.join(names)}")
    if result.attrs["failure"]:
        sys.stderr.write(f"wucht: {result.attrs['failure']}. What was computed is kept in {folder}\n")
        raise typer.Exit(1)
    if not result.attrs["finished"]:
        raise typer.Exit(130)
