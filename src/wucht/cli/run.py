"""``wucht run``: a study file or catalogue name -> result, figure, summary, verdict."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wucht.cli.options import (
    DEFAULT_STYLE,
    DecimalOption,
    Format,
    FormatOption,
    Imports,
    Settings,
    StudyName,
    Style,
    StyleOption,
    figure_names,
    is_decimal_comma,
)

if TYPE_CHECKING:
    import xarray as xr

    from wucht.cli.presenting import Presentation
    from wucht.studies.study_file import StudyFile


def run(
    study: StudyName,
    set_: Settings = None,
    details: Annotated[bool, typer.Option("--details", help="Print all lines of the report.")] = False,
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
        format_, is_decimal_comma(csv, decimal), details,
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
    details: bool = True,
) -> None:
    """Answer the question that is read, write the files and print the report.

    study: its name; follow_up: a command that could follow, of the question, its result and its folder; out: the folder, if
    given; decimal_comma: of the CSV files; details: whether all lines of the report are printed, or the first ones.
    """
    from wucht.results.attempts import is_attempt_warning
    from wucht.results.report import first_lines, text_in_print
    from wucht.results.store import to_json
    from wucht.studies.memory import interruption

    result, presentation = run_and_show(
        study, read_question, follow_up, out, csv, resume, scheduler, style, format_, decimal_comma
    )
    accessor = result.wucht
    if as_json:
        sys.stdout.write(to_json(presentation.document) + "\n")
    else:
        for line in presentation.lines if details else first_lines(presentation.lines):
            typer.echo(line)
        for note in accessor.notes:
            typer.echo(f"note: {text_in_print(note, result)}")
    for warning in accessor.warnings:
        if not as_json or is_attempt_warning(warning):
            typer.echo(f"warning: {text_in_print(warning, result)}", err=True)
    if not as_json:
        typer.echo(f"files: {presentation.folder}/{', '.join(presentation.names(result))}")
        if presentation.next_command:
            typer.echo(f"next: {presentation.next_command}")
    if not result.attrs["finished"]:
        failure = result.attrs["failure"]
        sys.stderr.write(f"wucht: {interruption(presentation.folder, failure)}\n")
        raise typer.Exit(1 if failure else 130)


def run_and_show(
    title: str,
    read_question: Callable[[], StudyFile],
    follow_up: Callable[[StudyFile, xr.Dataset, Path], str],
    out: Path | None,
    csv: bool = False,
    resume: bool = False,
    scheduler: str | None = None,
    style: Style = DEFAULT_STYLE,
    format_: list[Format] | None = None,
    decimal_comma: bool = False,
    check: Callable[[], None] | None = None,
) -> tuple[xr.Dataset, Presentation]:
    """Answer the question that is read and write the files, with progress under a title.

    check: that of an ``interrupt_check`` around several questions; by default this one has its own. Others: see
    ``run_and_print``.
    """
    from wucht.cli.presenting import Presentation
    from wucht.cli.progress import Progress
    from wucht.cli.surroundings import interrupt_check
    from wucht.results.output_folder import SUMMARY
    from wucht.results.store import RESULT
    from wucht.studies.study_file import run_study

    start_time = time.perf_counter()
    with Progress(title) as progress, interrupt_check() if check is None else nullcontext(check) as raise_interrupt:

        def report(share: float, label: str) -> None:
            progress.update(share, label)
            raise_interrupt()

        study_file = read_question()
        folder = out or Path("results") / study_file.name
        presentation = Presentation(
            folder, style, format_, csv, decimal_comma, lambda result: follow_up(study_file, result, folder), start_time
        )
        files = (RESULT, *figure_names(study_file.spec.kind, format_), SUMMARY)
        options = {"resume": resume, "progress": report, "scheduler": scheduler, "announce": progress.announce}
        result = run_study(
            study_file, folder=folder, files=files, write=presentation.write, summarise=presentation.summarise, **options
        )
    return result, presentation
