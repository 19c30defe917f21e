"""What shows a result on the command line: figure, tables, summary, report. What fails becomes a warning."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import wucht
from wucht.cli.options import Format, Style, draw_on, figure_names
from wucht.results.attempts import Attempts
from wucht.results.output_folder import CHECKSUMS, SUMMARY, checksum
from wucht.results.result_tables import table_names
from wucht.results.spreadsheets import save_csv_table
from wucht.results.store import RESULT, file_name, save_summary

if TYPE_CHECKING:
    import xarray as xr


@dataclass
class Presentation:
    """The files and the text of one result.

    folder: of the result; csv: whether its tables are written, with decimal_comma; follow_up: a command that could
    follow; start_time: of the command, by ``time.perf_counter``.
    figures, tables: written files; lines, next_command: of the report; document: the contents of ``summary.json``.
    """

    folder: Path
    style: Style
    formats: list[Format] | None
    csv: bool
    decimal_comma: bool
    follow_up: Callable[[xr.Dataset], str]
    start_time: float
    figures: list[Path] = field(default_factory=list)
    tables: list[Path] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    next_command: str = ""
    document: dict[str, Any] = field(default_factory=dict)

    def names(self, result: xr.Dataset) -> list[str]:
        """Names of the files in the folder."""
        figures, tables = ([path.name for path in paths] for paths in (self.figures, self.tables))
        return [file_name(RESULT, result), *figures, file_name(SUMMARY, result), *tables]

    def write(self, result: xr.Dataset, new: Path) -> list[str]:
        """Draw the figure, write the tables into a folder, make the report; a sentence on each that fails."""
        from wucht.plots.sheet import save_figure
        from wucht.studies.runner import report

        attempts, names = Attempts(), figure_names(str(result.attrs["study"]), self.formats)
        with attempts.attempt(f"figure {', '.join(names)}"):
            figure = draw_on(result, self.style)
            for name in names:
                with attempts.attempt(f"figure {name}"):
                    self.figures.append(save_figure(figure, new / file_name(name, result)))
        if self.csv:
            with attempts.attempt("tables"):
                for table in table_names(result):
                    with attempts.attempt(f"table {table}"):
                        self.tables.append(save_csv_table(result, table, new, self.decimal_comma))
        self.lines = [f"verdict: {result.wucht.sentence}"]  # where the report fails
        with attempts.attempt("report"):
            self.lines = report(result)
        if result.attrs["finished"]:
            with attempts.attempt("next command"):
                self.next_command = self.follow_up(result)
        return attempts.warnings

    def summarise(self, result: xr.Dataset, new: Path) -> None:
        """Write the summary into a folder."""
        accessor = result.wucht
        self.document = {
            "study": accessor.study,
            "machine": result.attrs["title"],
            "summary": accessor.summary,
            "assumed": accessor.assumed,
            "warnings": accessor.warnings,
            "notes": accessor.notes,
            "files": [str(self.folder / name) for name in self.names(result)],
            CHECKSUMS: {path.name: checksum(path) for path in (*self.figures, *self.tables)},
            "units": "dimensionless" if result.attrs["dimensionless"] else "SI",
            "version": wucht.__version__,
            "elapsed_s": round(time.perf_counter() - self.start_time, 3),
        }
        if result.attrs["failure"]:
            self.document |= {"error": result.attrs["failure"], "exit_code": 1}
        save_summary(self.document, new / file_name(SUMMARY, result))
