"""``wucht export``: files of a result for other programs and machines."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from wucht.cli.options import DecimalOption, Imports, is_decimal_comma
from wucht.errors import InputError


def export(
    result: Annotated[Path, typer.Argument(help="A result.nc written by `wucht run`, or the folder that has it.")],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default beside the result.")] = None,
    csv: Annotated[bool, typer.Option("--csv", help="The tables and numbers of any result as CSV, with units.")] = False,
    decimal: DecimalOption = None,
    xlsx: Annotated[
        bool,
        typer.Option(
            "--xlsx", help="One XLSX workbook: answers in mm, rpm and kN, the course over time on 500 rows, and tables."
        ),
    ] = False,
    everything: Annotated[bool, typer.Option("--all", help="Of --xlsx: all samples over time as well.")] = False,
    import_: Imports = None,
) -> None:
    """Export a result: of a cam the points to mill, drawings and tables for controllers; of any study its tables."""
    from wucht.results.output_folder import load_result, note_figure, result_file
    from wucht.results.spreadsheets import save_csv, save_xlsx
    from wucht.results.store import prepare_folder
    from wucht.studies.runner import export as export_files

    if everything and not xlsx:
        raise InputError("--all", None, "this is for the samples in a workbook; give --xlsx too")
    decimal_comma = is_decimal_comma(csv, decimal)
    dataset, file = load_result(result), result_file(result)
    folder = out or file.parent
    try:
        tables = [*(save_csv(dataset, prepare_folder(folder), decimal_comma) if csv else [])]
        tables += [save_xlsx(dataset, prepare_folder(folder), everything)] if xlsx else []
        for table in tables if folder.absolute() == file.parent.absolute() else []:
            note_figure(table, dataset)
        lines = list(map(str, tables)) if csv or xlsx else export_files(dataset, folder)
    except InputError as error:
        if error.code == "not-exported":
            command = shlex.join(["wucht", "export", str(result)])
            explanation = f"{error.explanation}. Its tables and numbers: {command} --csv, or --xlsx"
            error = InputError(error.location, None, explanation, code=error.code)
        raise error if error.location.startswith("-") else error.with_file(file) from None
    for line in lines:
        typer.echo(line)
