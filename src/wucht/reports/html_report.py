"""Results -> one page of HTML: a chapter each, with a table of contents where there are several."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path

import wucht
from wucht.environment import date_of_files
from wucht.errors import InputError
from wucht.reports.chapter import Chapter, chapter
from wucht.reports.markup import html_table, html_text, page
from wucht.results.output_folder import COMMIT, NEW, PARTIAL, load_result, result_file
from wucht.results.store import RESULT, prepare_folder, replace_file

_ENDINGS = (".html", ".htm")


def result_files(places: Iterable[Path]) -> list[Path]:
    """The files of results in these places, each once: files, output folders, and folders in which there are such.

    Raises ``InputError`` for a folder without a result.
    """
    unique_files: dict[str, Path] = {}
    for place in places:
        files = [result_file(place)]
        if place.is_dir() and not files[0].is_file() and not (place / COMMIT).is_dir():
            folders = {file.parent for file in place.rglob("*.nc") if file.name in (RESULT, PARTIAL)}
            files = sorted(result_file(folder) for folder in folders if not {NEW, COMMIT} & set(folder.parts))
            if not files:
                raise InputError("RESULT", str(place), f"there is no {RESULT} in this folder, nor in the folders inside")
        unique_files |= {path: file for file in files if (path := os.path.realpath(file)) not in unique_files}
    return list(unique_files.values())


def write_report(places: Sequence[Path | str], file: Path | str, title: str = "") -> Path:
    """Write results as one page of HTML, which opens without a network and prints on A4.

    Parameters
    ----------
    places : sequence of paths
        Files ``result.nc``, output folders, or folders in which there are such.
    file : path
        The page to write, ``NAME.html``. An earlier one is replaced, as a whole or not at all.
    title : str, optional
        Title of the report; by default that of its only result.

    Returns
    -------
    Path
        The page. It is the same to the last byte for the same results and the same day (or ``SOURCE_DATE_EPOCH``). Where a
        figure cannot be drawn, it has a warning instead, which is issued too.

    Raises
    ------
    InputError
        If there is no result, or one cannot be read; if the file is a folder or no page of HTML.
    RunError
        If the page cannot be written.
    """
    path = place_of_page(Path(file), "report.html")
    files = result_files(map(Path, places))
    if not files:
        raise InputError("RESULT", None, "give at least one result.nc, or a folder that has one")
    chapters = [_chapter_of(place, number) for number, place in enumerate(files, 1)]
    for place, one in zip(files, chapters, strict=True):
        for warning in one.warnings:
            warnings.warn(f"{place}: {warning}", stacklevel=2)
    whole = _page(chapters, title).encode("utf-8")
    return replace_file(path, lambda beside: beside.write_bytes(whole))


def place_of_page(path: Path, usual_name: str) -> Path:
    """The path of a page that can be written; its folder is made if it is missing. Raises ``InputError``.

    usual_name: of such a page, for the error.
    """
    try:
        if path.is_dir():
            example = path / usual_name
            raise InputError("-o", str(path), f"this is a folder: give the file to write, such as {example}", code="folder")
        if path.suffix.lower() not in _ENDINGS:
            raise InputError("-o", str(path), f"must be the name of a page of HTML, such as {usual_name}")
        prepare_folder(path.parent, [path.name])
    except (OSError, ValueError) as error:
        raise InputError("-o", str(path), f"this cannot be the name of a file: {error}") from None
    return path


def _chapter_of(file: Path, number: int) -> Chapter:
    result = load_result(file)
    try:
        return chapter(result, number)
    except InputError as error:
        raise error.with_file(file) from None


def _page(chapters: Sequence[Chapter], title: str) -> str:
    heading = title or (chapters[0].title if len(chapters) == 1 else f"Report on {len(chapters)} results")
    origin = f'<p class="meta">Report of {date_of_files().date()}, written by wucht {html_text(wucht.__version__)}</p>'
    body = "\n".join(one.html for one in chapters)
    if title or len(chapters) > 1:
        body = f"<nav>\n<h1>{html_text(heading, 160)}</h1>\n{origin}\n{_contents(chapters)}\n</nav>\n{body}"
    else:
        body = f"{origin}\n{body}"  # above: below, it may be alone on a last sheet
    return page(heading, body)


def _contents(chapters: Sequence[Chapter]) -> str:
    """The table of contents: each result with its verdict."""
    if len(chapters) == 1:
        return ""
    rows = [
        (str(k), f'<a href="#{one.anchor}">{html_text(one.title, 160)}</a>', html_text(one.verdict, 300))
        for k, one in enumerate(chapters, 1)
    ]
    return html_table(rows, ("", "Result", "Verdict"), kind="contents")
