"""Results -> one page of HTML: the answers and the machine that they share first, then a chapter each."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import wucht
from wucht.environment import date_of_files
from wucht.errors import InputError
from wucht.reports.chapter import Chapter, chapter, creation_text, versions_text
from wucht.reports.markup import html_table, html_text, page, section
from wucht.reports.subject_section import SharedSubject, shared_section, shared_subjects, study_file
from wucht.results.output_folder import COMMIT, NEW, PARTIAL, load_result, result_file
from wucht.results.store import RESULT, prepare_folder, replace_file

if TYPE_CHECKING:
    import xarray as xr

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


def write_report(places: Sequence[Path | str], file: Path | str, title: str = "", *, everything: bool = False) -> Path:
    """Write results as one page of HTML, which opens without a network and prints on A4.

    Several begin with a page of their answers and, where they share a machine, with that; a chapter each follows.

    Parameters
    ----------
    places : sequence of paths
        Files ``result.nc``, output folders, or folders in which there are such.
    file : path
        The page to write, ``NAME.html``. An earlier one is replaced, as a whole or not at all.
    title : str, optional
        Title of the report; by default that of its only result, or of the machine that all results share.
    everything : bool
        Also the candidates that a search has tried and not chosen.

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
    results = [load_result(place) for place in files]
    subjects = shared_subjects(results)
    chapters = [
        _chapter_of(place, result, number, subject, everything)
        for number, (place, result, subject) in enumerate(zip(files, results, subjects, strict=True), 1)
    ]
    for place, one in zip(files, chapters, strict=True):
        for warning in one.warnings:
            warnings.warn(f"{place}: {warning}", stacklevel=2)
    whole = _page(chapters, results, subjects, title).encode("utf-8")
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


def _chapter_of(file: Path, result: xr.Dataset, number: int, subject: SharedSubject | None, everything: bool) -> Chapter:
    try:
        return chapter(result, number, subject, everything=everything)
    except InputError as error:
        raise error.with_file(file) from None


def _page(
    chapters: Sequence[Chapter], results: Sequence[xr.Dataset], subjects: Sequence[SharedSubject | None], title: str
) -> str:
    heading = title or _title_of(chapters, subjects)
    first = f'<p class="meta">Report of {date_of_files().date()}, written by wucht {html_text(wucht.__version__)}</p>'
    body = "\n".join(one.html for one in chapters)
    if title or len(chapters) > 1:
        first_page = [f"<h1>{html_text(heading, 160)}</h1>", first, _answers(chapters, heading), *_machines(subjects)]
        body = f"<nav>\n{chr(10).join(filter(None, first_page))}\n</nav>\n{body}\n{_origins(results, subjects)}"
    else:
        body = f"{first}\n{body}"  # above: below, it may be alone on a last sheet
    return page(heading, body)


def _title_of(chapters: Sequence[Chapter], subjects: Sequence[SharedSubject | None]) -> str:
    if len(chapters) == 1:
        return chapters[0].title
    only = subjects[0] if len({id(subject) for subject in subjects}) == 1 else None
    return f"Report on {len(chapters)} results" if only is None else only.first.wucht.title


def _answers(chapters: Sequence[Chapter], heading: str) -> str:
    """The answers, each with a link to its chapter and its main numbers; empty of a single one."""
    if len(chapters) == 1:
        return ""
    rows = [
        (
            str(k),
            f'<a href="#{one.anchor}">{html_text(one.study)}</a>{_other_title(one, heading)}',
            html_text(one.verdict, 300),
            one.main_numbers,
        )
        for k, one in enumerate(chapters, 1)
    ]
    return html_table(rows, ("", "Question", "Answer", "Main numbers"), kind="contents")


def _other_title(one: Chapter, heading: str) -> str:
    return "" if one.title == heading else f'<br><span class="meta">{html_text(one.title, 160)}</span>'


def _machines(subjects: Sequence[SharedSubject | None]) -> list[str]:
    """A section for each subject that several chapters share."""
    unique = list({id(subject): subject for subject in subjects if subject is not None}.values())
    is_only_one = len(unique) == 1 and None not in subjects
    return [
        shared_section(subject, [k for k, one in enumerate(subjects, 1) if one is subject], is_only_one) for subject in unique
    ]


def _origins(results: Sequence[xr.Dataset], subjects: Sequence[SharedSubject | None]) -> str:
    """How the results about subject subjects were computed, and the files of these subjects."""
    unique = list({id(subject): subject for subject in subjects if subject is not None}.values())
    if not unique:
        return ""
    same_origin: dict[str, list[str]] = {}
    for k, (result, subject) in enumerate(zip(results, subjects, strict=True), 1):
        if subject is not None:
            same_origin.setdefault(versions_text(result.wucht), []).append(f"{k}. {creation_text(result.wucht)}".rstrip())
    rows = [(html_text("; ".join(times)), html_text(versions)) for versions, times in same_origin.items()]
    files = [
        study_file({key: value for key, value in document.items() if key != "study"}, {}, level=3)
        for subject in unique
        if (document := subject.first.wucht.document)
    ]
    table = html_table(rows, ("Computed", "With"))
    return f'<section class="brief chapter">{section("How it was computed", table, *files)}</section>'
