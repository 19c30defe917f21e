"""``wucht compare``: several machines or variants side by side, in one result."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wucht.cli.completing import settable_keys, study_names
from wucht.cli.options import DEFAULT_STYLE, DecimalOption, FormatOption, Imports, StyleOption, is_decimal_comma

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.study_file import StudyFile

_LONGEST = 80  # letters in a folder's name


def compare(
    of: Annotated[
        list[str],
        typer.Argument(
            metavar="STUDY...", autocompletion=study_names, help="Study files, catalogue names, folders of results."
        ),
    ],
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", autocompletion=settable_keys, help="Set a parameter in all of them; repeatable."
        ),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="KEY=A,B,...",
            autocompletion=settable_keys,
            help="A variant for each value; twice: for each pair of values.",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default results/compare/NAMES.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    csv: Annotated[bool, typer.Option("--csv", help="Write the table and the curves as CSV too, with units.")] = False,
    decimal: DecimalOption = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the interrupted run in the output folder.")] = False,
    style: StyleOption = DEFAULT_STYLE,
    format_: FormatOption = None,
    import_: Imports = None,
) -> None:
    """Set several machines, variants or results side by side: a table of their summaries, and one figure."""
    from wucht.cli.next_command import next_command
    from wucht.cli.run import run_and_print

    def read_question() -> StudyFile:
        from wucht.cli.options import parse_lists, parse_settings
        from wucht.studies.study_file import read_comparison

        return read_comparison(of, parse_settings(set_ or []), parse_lists(vary or []))

    def follow_up(study_file: StudyFile, result: xr.Dataset, folder: Path) -> str:
        return next_command(study_file, result, folder, None, [], [])

    folder = out or _folder([*of, *(v.partition("=")[0] for v in vary or [])])
    comma = is_decimal_comma(csv, decimal)
    run_and_print(
        ", ".join(of), read_question, follow_up, folder, as_json, csv, resume, style=style, format_=format_, decimal_comma=comma
    )


def _folder(names: list[str]) -> Path:
    words = [re.sub(r"[^\w.-]+", "-", name.removesuffix(".toml")).strip("-.") for name in names]
    return Path("results") / "compare" / ("+".join(filter(None, words))[:_LONGEST] or "all")
