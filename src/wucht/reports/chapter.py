"""A result as a chapter of a report: verdict, figure, machine, numbers, assumptions, and how it was computed.

A chapter of several about one machine is brief: the machine, what holds for all of them, and its file are told once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wucht.errors import InputError
from wucht.plots.inline_svg import inline_svg
from wucht.plots.page import REPORT
from wucht.reports.markup import brief_text, bullets, html_table, html_text, section
from wucht.reports.numbers import brief_numbers, main_numbers, number_sections
from wucht.reports.subject_section import (
    SharedSubject,
    data_of,
    drawing_of,
    notes_once,
    parameter_differences,
    question_line,
    remarks,
    study_file,
)
from wucht.results.attempts import Attempts, with_attempt_warnings
from wucht.results.report import is_of_version_0_1
from wucht.studies.registry import studies
from wucht.studies.runner import draw, report

if TYPE_CHECKING:
    import xarray as xr

    from wucht.results.accessor import ResultAccessor

_NAME = 15  # characters before the text of an entry, in a line of a report
_TITLE = 160  # characters of a heading


@dataclass(frozen=True)
class Chapter:
    """A chapter: the name of its anchor, its title, study and verdict as plain text, its main numbers and itself as HTML.

    warnings: what could not be written in it.
    """

    anchor: str
    title: str
    study: str
    verdict: str
    main_numbers: str
    html: str
    warnings: tuple[str, ...] = ()


def chapter(result: xr.Dataset, number: int, subject: SharedSubject | None = None, *, everything: bool = False) -> Chapter:
    """Write the chapter of a result.

    Parameters
    ----------
    result : xarray.Dataset
    number : int
        Number of the chapter in its report, from 1.
    subject : SharedSubject, optional
        The subject that is told once for this and other chapters: this one tells only what differs from it.
    everything : bool
        Also the candidates that a search has tried and not chosen.

    Returns
    -------
    Chapter

    Raises
    ------
    InputError
        For an unknown study, or a Dataset that lacks variables of the written result.
    """
    accessor, anchor, attempts = result.wucht, f"r{number}", Attempts()
    lines, drawing, figure = ["", f"verdict: {accessor.sentence}"], "", ""
    with attempts.attempt("lines of the report", InputError):
        lines = report(result)
    if subject is None:
        with attempts.attempt("drawing of the machine", InputError):
            drawing = drawing_of(result, anchor)
    if not is_of_version_0_1(result):
        with attempts.attempt("figure", InputError):
            figure = _figure(result, anchor)
    verdict, entries = _entries(lines)
    title, kind = accessor.title or accessor.study, studies()[accessor.study]
    heading = title if subject is None else f"{number}. {accessor.study}{_other_title(result, subject)}"
    warnings = with_attempt_warnings(result, attempts.warnings).wucht.warnings
    without = () if everything else kind.study.trials
    tables = number_sections(result, without) if subject is None or everything else brief_numbers(result, without)
    parts = [
        f"<h1>{html_text(heading, _TITLE)}</h1>",
        f'<p class="meta">Study {html_text(accessor.study)}: {html_text(kind.line)}</p>',
        f'<div class="verdict"><b>Verdict</b>{html_text(verdict)}</div>',
        _incomplete(accessor),
        html_table(entries, kind="entries", row_heads=True),
        section("Warnings", bullets(w for w in warnings if subject is None or w not in subject.warnings)),
        drawing,
        figure,
        _subject(result, subject),
        *tables,
        *_ground(result, subject),
    ]
    body = "\n".join(filter(None, parts))
    kind_of_chapter = "chapter" if subject is None else "brief chapter"
    html = f'<section class="{kind_of_chapter}" id="{anchor}">\n{body}\n</section>'
    return Chapter(anchor, title, accessor.study, verdict, main_numbers(accessor), html, tuple(attempts.warnings))


def _other_title(result: xr.Dataset, subject: SharedSubject) -> str:
    """The title of a machine in which something was changed; empty where it is that of the others."""
    title = result.wucht.title
    return "" if title == subject.first.wucht.title else f": {title}"


def _subject(result: xr.Dataset, subject: SharedSubject | None) -> str:
    """The machine of a chapter, or what differs in it from that of the others."""
    notes = result.wucht.notes
    if subject is None:
        return section("Machine" if result.wucht.parts else "Subject", data_of(result), bullets(notes_once(notes)))
    further_notes = notes_once([note for note in notes if note not in subject.notes])
    return section("Different in this machine", parameter_differences(result, subject.first), bullets(further_notes))


def _ground(result: xr.Dataset, subject: SharedSubject | None) -> list[str]:
    """Assumptions, and how it was computed: of one of several chapters about a machine, the question alone."""
    accessor = result.wucht
    if subject is None:
        document = study_file(accessor.document, accessor.spec)
        return [
            section("Assumptions", bullets(accessor.assumed)),
            section("How it was computed", _origin(accessor), document),
        ]
    question = (accessor.document or {}).get("study", accessor.spec)
    assumption = [f"Assumed: {'; '.join(accessor.assumed)}"] if accessor.assumed else []
    return [remarks(assumption), question_line(question)]


def creation_text(result: ResultAccessor) -> str:
    """When a result was computed, empty where that is not recorded."""
    return "" if result.created is None else str(result.created).replace("+00:00", " UTC")


def versions_text(result: ResultAccessor) -> str:
    """The versions of wucht and of its libraries with which a result was computed."""
    versions = result.versions or {}
    libraries = [f"{name} {version}" for name, version in versions.items() if name != "wucht" and version != "not installed"]
    return ", ".join([f"wucht {versions.get('wucht', 'a version that is not recorded')}", *libraries])


def _origin(result: ResultAccessor) -> str:
    rows = [("Computed", creation_text(result)), ("With", versions_text(result))]
    return html_table([(name, html_text(value)) for name, value in rows if value], kind="entries", row_heads=True)


def _entries(lines: Sequence[str]) -> tuple[str, list[tuple[str, str]]]:
    """The verdict, and the named entries of a report; a line without a name continues the one before."""
    verdict, entries = "", list[tuple[str, str]]()
    for line in lines[1:]:
        if line.startswith("verdict: "):
            verdict = line.removeprefix("verdict: ")
        elif line.startswith("  ") and (name := line[2:_NAME].strip()):
            entries.append((html_text(name), html_text(line[_NAME:].strip())))
        elif entries:
            entries[-1] = (entries[-1][0], f"{entries[-1][1]}<br>{html_text(line.strip())}")
        else:
            entries.append(("", html_text(line.strip())))
    return verdict, [entry for entry in entries if entry[0] != "assumed"]


def _incomplete(result: ResultAccessor) -> str:
    if result.finished:
        return ""
    reason = result.failure or "it was interrupted"
    return f'<div class="verdict incomplete"><b>This result is incomplete</b>{html_text(reason)}</div>'


def _figure(result: xr.Dataset, anchor: str) -> str:
    accessor = result.wucht
    label = html_text(f"{accessor.study} of {brief_text(accessor.title)}")
    drawing = inline_svg(draw(result, REPORT), f"{anchor}-figure", label)
    return f"<figure>{drawing}<figcaption>Result of the study {html_text(accessor.study)}</figcaption></figure>"
