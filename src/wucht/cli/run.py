"""``wucht run``: a study file or catalogue name -> result, figure, summary, verdict."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import wucht
from wucht.cli.importing import Imports

if TYPE_CHECKING:
    import xarray as xr


def run(
    study: Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.")],
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; repeatable.")] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default results/NAME.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted run found in the output folder.")] = False,
    import_: Imports = None,
) -> None:
    """Run a study and say what becomes of the machine."""
    from wucht.cli.interruption import Interruption
    from wucht.cli.progress import Progress
    from wucht.cli.set_option import parse_settings
    from wucht.results.store import save_figure, save_summary, to_json
    from wucht.studies.runner import RESULT, draw
    from wucht.studies.study_file import answer, read_study

    begun = time.perf_counter()
    asked = read_study(study, parse_settings(set_ or []))
    names = (RESULT, f"{asked.spec.kind}.png", "summary.json")
    folder = out or Path("results") / Path(study).name.removesuffix(".toml")
    target, figure, short = (folder / name for name in names)
    with Interruption() as interruption, Progress(study) as progress:

        def report(share: float, what: str) -> None:
            progress.update(share, what)
            interruption.check()

        result = answer(asked, folder=folder, files=names, resume=resume, progress=report)
    save_figure(draw(result), figure)
    document = _document(result, [target, figure, short], time.perf_counter() - begun)
    save_summary(document, short)
    if as_json:
        sys.stdout.write(to_json(document) + "\n")
    else:
        _print(result, document)
    if result.attrs["failure"]:
        sys.stderr.write(f"wucht: {result.attrs['failure']}. What was computed is kept in {folder}\n")
        raise typer.Exit(1)
    if not result.attrs["finished"]:
        raise typer.Exit(130)


def _document(result: xr.Dataset, files: list[Path], elapsed: float) -> dict[str, Any]:
    return {
        "study": result.attrs["study"],
        "machine": result.attrs["title"],
        "summary": json.loads(result.attrs["summary"]),
        "warnings": json.loads(result.attrs["warnings"]),
        "files": [str(f) for f in files],
        "units": "dimensionless" if result.attrs["dimensionless"] else "SI",
        "version": wucht.__version__,
        "elapsed_s": round(elapsed, 3),
    }


def _print(result: xr.Dataset, document: dict[str, Any]) -> None:
    from wucht.studies.runner import report

    for line in report(result):
        typer.echo(line)
    for warning in document["warnings"]:
        typer.echo(f"warning: {warning}", err=True)
    files = [Path(f) for f in document["files"]]
    typer.echo(f"files: {files[0].parent}/" + ", ".join(f.name for f in files))
