"""``wucht run``: a study file or catalogue name -> result, figure, summary, verdict."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import wucht
from wucht.cli.options import (
    DEFAULT_STYLE,
    DecimalOption,
    Format,
    FormatOption,
    Imports,
    Style,
    StyleOption,
    is_decimal_comma,
    unique_formats,
    write_figure,
)

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.study_file import StudyFile


def run(
    study: Annotated[str, typer.Argument(help="A study file, or a name from `wucht list`.")],
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; repeatable.")] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Output folder; default results/NAME, or results/NAME/KIND.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Write the result's tables and numbers as CSV too, with units.")] = False,
    decimal: DecimalOption = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the interrupted run in the output folder.")] = False,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Compute on the workers of a scheduler of dask.distributed."),
    ] = None,
    style: StyleOption = DEFAULT_STYLE,
    format_: FormatOption = None,
    import_: Imports = None,
) -> None:
    """Run a study and report its outcome."""
    from wucht.cli.next_command import next_command
    from wucht.cli.options import parse_settings
    from wucht.studies.study_file import read_study

    def follow_up(study_file: StudyFile, result: xr.Dataset, folder: Path) -> str:
        return next_command(study_file, result, folder, study, set_ or [], import_ or [])

    run_and_print(
        study, lambda: read_study(study, parse_settings(set_ or [])), follow_up, out, as_json, csv, resume, scheduler, style,
        format_, is_decimal_comma(csv, decimal),
    )  # fmt: skip


def run_and_print(
    study: str,
    read_question: Callable[[], StudyFile],
    follow_up: Callable[[StudyFile, xr.Dataset, Path], str],
    out: Path | None,
    as_json: bool = False,
    csv: bool = False,
    resume: bool = False,
    scheduler: str | None = None,
    style: Style = DEFAULT_STYLE,
    format_: list[Format] | None = None,
    decimal_comma: bool = False,
) -> None:
    """Answer the question that is read, write the files and print the report.

    study: its name; follow_up: a command that could follow, of the question, its result and its folder; out: the folder, if
    given; decimal_comma: of the CSV files.
    """
    from wucht.cli.progress import Progress
    from wucht.cli.surroundings import interrupt_check
    from wucht.results.formatting import units_in_print
    from wucht.results.output_folder import CHECKSUMS, SUMMARY, checksum
    from wucht.results.spreadsheets import save_csv
    from wucht.results.store import RESULT, save_summary, to_json
    from wucht.studies.runner import report as report_of
    from wucht.studies.study_file import run_study

    start_time = time.perf_counter()
    with Progress(study) as progress, interrupt_check() as check:

        def report(share: float, label: str) -> None:
            progress.update(share, label)
            check()

        study_file = read_question()
        folder = out or Path("results") / study_file.name
        names = [RESULT, *(f"{study_file.spec.kind}.{f.value}" for f in unique_formats(format_)), SUMMARY]
        document: dict[str, Any] = {}

        def write(result: xr.Dataset, new: Path) -> None:
            tables = save_csv(result, new, decimal_comma) if csv else []
            outputs = [*write_figure(result, new, style, format_), *tables]
            names.extend(table.name for table in tables)
            accessor = result.wucht
            document.update(
                {
                    "study": accessor.study,
                    "machine": result.attrs["title"],
                    "summary": accessor.summary,
                    "assumed": accessor.assumed,
                    "warnings": accessor.warnings,
                    "notes": accessor.notes,
                    "files": [str(folder / name) for name in names],
                    CHECKSUMS: {path.name: checksum(path) for path in outputs},
                    "units": "dimensionless" if result.attrs["dimensionless"] else "SI",
                    "version": wucht.__version__,
                    "elapsed_s": round(time.perf_counter() - start_time, 3),
                }
            )
            if result.attrs["failure"]:
                document.update({"error": result.attrs["failure"], "exit_code": 1})
            save_summary(document, new / SUMMARY)

        options = {"resume": resume, "progress": report, "scheduler": scheduler, "announce": progress.announce}
        result = run_study(study_file, folder=folder, files=tuple(names), write=write, **options)
    accessor = result.wucht
    if as_json:
        sys.stdout.write(to_json(document) + "\n")
    else:
        for line in report_of(result):
            typer.echo(line)
        for note in accessor.notes:
            typer.echo(f"note: {units_in_print(note)}")
        for warning in accessor.warnings:
            typer.echo(f"warning: {units_in_print(warning)}", err=True)
        typer.echo(f"files: {folder}/{', '.join(names)}")
        if result.attrs["finished"]:
            typer.echo(f"next: {follow_up(study_file, result, folder)}")
    if result.attrs["failure"]:
        sys.stderr.write(f"wucht: {result.attrs['failure']}. What was computed so far is in {folder}\n")
        raise typer.Exit(1)
    if not result.attrs["finished"]:
        raise typer.Exit(130)
