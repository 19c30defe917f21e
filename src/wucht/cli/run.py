"""``wucht run``: a study file or catalogue name -> result, figure, summary, verdict."""

from __future__ import annotations

import json
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import wucht

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.files import StudyFile


def run(
    study: Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.")],
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; repeatable.")] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default results/NAME.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted run found in the output folder.")] = False,
) -> None:
    """Run a study and say what becomes of the machine."""
    from wucht.cli.interruption import Interruption
    from wucht.cli.progress import Progress
    from wucht.cli.settings import parse_settings
    from wucht.errors import InputError
    from wucht.plots import draw
    from wucht.results.store import load, prepare_folder, save, save_figure, save_summary, to_json
    from wucht.studies.files import read_study

    begun = time.perf_counter()
    asked = read_study(study, parse_settings(set_ or []))
    names = ("result.nc", f"{asked.question.kind}.png", "summary.json")
    folder = prepare_folder(out or Path("results") / Path(study).name.removesuffix(".toml"), names)
    target, figure, short = (folder / name for name in names)
    earlier = load(target) if resume and target.exists() else None
    if earlier is not None and earlier.attrs["study"] != asked.question.kind:
        given, wanted = earlier.attrs["study"], asked.question.kind
        raise InputError("--resume", None, f"the result in {folder} answers study.kind = {given!r}, not {wanted!r}")
    with Interruption() as interruption, Progress(asked.machine.title) as progress:

        def report(reached: float, goal: float) -> None:
            progress.update(reached, goal)
            interruption.check()

        keep = partial(_keep, save, asked, target)
        result = asked.kind.answer(asked.machine, asked.question, report, keep, earlier)
    result.attrs["document"] = json.dumps(asked.document, default=str)
    save(result, target)
    save_figure(draw(result), figure)
    document = _document(asked, result, [target, figure, short], time.perf_counter() - begun)
    save_summary(document, short)
    if as_json:
        sys.stdout.write(to_json(document) + "\n")
    else:
        _say(document, folder)
    if result.attrs["failure"]:
        sys.stderr.write(f"wucht: {result.attrs['failure']}. What was computed is kept in {folder}\n")
        raise typer.Exit(1)
    if not result.attrs["finished"]:
        raise typer.Exit(130)


def _keep(save: Any, asked: StudyFile, target: Path, so_far: xr.Dataset) -> None:
    so_far.attrs["document"] = json.dumps(asked.document, default=str)
    so_far.attrs["finished"] = 0
    save(so_far, target)


def _document(asked: StudyFile, result: xr.Dataset, files: list[Path], elapsed: float) -> dict[str, Any]:
    return {
        "study": result.attrs["study"],
        "machine": asked.machine.title,
        "summary": json.loads(result.attrs["summary"]),
        "warnings": json.loads(result.attrs["warnings"]),
        "files": [str(f) for f in files],
        "units": "dimensionless" if result.attrs["dimensionless"] else "SI",
        "version": wucht.__version__,
        "elapsed_s": round(elapsed, 3),
    }


def _say(document: dict[str, Any], folder: Path) -> None:
    from wucht.cli.verdicts import verdict_lines

    for line in verdict_lines(document):
        typer.echo(line)
    for warning in document["warnings"]:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(f"files: {folder}/" + ", ".join(Path(f).name for f in document["files"]))
