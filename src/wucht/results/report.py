"""The report of a result in words, from the Dataset alone.

Its lines are data: a heading, a text, and texts for fields of it. Other fields are numbers of the summary by their paths, with
formats of a few forms. A file may have been edited: what is no such line is left out, and a note says so.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from wucht.file_names import printable
from wucht.results.formatting import number_text, round_numbers, rpm_first, units_in_print

if TYPE_CHECKING:
    import xarray as xr

MOST_LINES = 200  # an answer of more is shortened when it is stored
_FIRST = 8  # lines that answer, below the sentence
_VERDICT = "verdict: "
_MOST_LETTERS = 10_000  # of a text
_FIELD = re.compile(r"\{([^{}:]+)(?::([^{}]*))?\}")
_FORM = re.compile(r"(?:\.(?:\d|1[0-6])[gfe])?%?")
_PATH = re.compile(r"[^.\[\]]+(?:\[\d{1,9}\]|\.[^.\[\]]+)*")
_STEP = re.compile(r"\[(\d+)\]|([^.\[\]]+)")


class _NoLineError(ValueError):
    """Why an entry of a stored result is no line of its report."""


def report_of(result: xr.Dataset) -> list[str]:
    """Return the report of a result.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    list of str
        Title, verdict, and a line for each entry. Of a result without lines, as earlier versions wrote it, the main numbers; of
        version 0.1, which did not name them, those of its summary.
    """
    report = result.wucht.stored_report
    numbers = _summary_numbers if is_of_version_0_1(result) else _main_numbers
    entries: list[Any] = [*numbers(result)] if report is None else report["lines"]
    lines, faults = list[str](), list[str]()
    for entry in entries[:MOST_LINES]:
        try:
            line = _line(result, entry)
        except _NoLineError as fault:
            faults.append(str(fault))
        else:
            lines += [] if line is None else [line]
    if len(entries) > MOST_LINES:
        faults += [f"at most {MOST_LINES} lines are read"] * (len(entries) - MOST_LINES)
    if faults:
        what = "a line that is" if len(faults) == 1 else f"{len(faults)} lines that are"
        lines.append(_column_line("note", f"{what} left out cannot be read: {faults[0]}"))
    verdict = (report or {}).get("verdict")
    verdict_lines = [] if verdict == "" else [f"{_VERDICT}{answer_in_print(result)}"]
    return [result.wucht.title, *verdict_lines, *lines]


def lines_in_print(lines: Iterable[str], result: xr.Dataset) -> list[str]:
    """Return the lines of a report as they are printed, and what is assumed at their end."""
    assumption_text = "; ".join(result.wucht.assumed)
    all_lines = [*lines, *([_column_line("assumed", assumption_text)] if assumption_text else [])]
    return [text_in_print(line, result) for line in all_lines]


def text_in_print(text: str, result: xr.Dataset) -> str:
    """Return a text about a result with the units of print; speeds in rpm first where the study file has such."""
    return units_in_print(rpm_first(text) if result.wucht.speaks_rpm else text)


def answer_in_print(result: xr.Dataset) -> str:
    """Return the answer in one sentence, the same in the report, in the figure and on every page."""
    return text_in_print(round_numbers((result.wucht.stored_report or {}).get("verdict") or result.wucht.sentence), result)


def first_lines(lines: Sequence[str]) -> list[str]:
    """Return title, answer and the first lines of a report; of the others their number."""
    count = _FIRST + 1 + any(line.startswith(_VERDICT) for line in lines[1:2])
    left = len(lines) - count
    return [
        *lines[:count],
        *([_column_line("more", f"{left} {'line' if left == 1 else 'lines'} with --details")] if left > 0 else []),
    ]


def paths_in_report(result: xr.Dataset) -> set[str]:
    """Return the paths of the numbers of the summary that the lines of a report show."""
    paths = set[str]()
    for entry in (result.wucht.stored_report or {}).get("lines", [])[:MOST_LINES]:
        with suppress(_NoLineError):
            if _line(result, entry) is not None:
                paths |= {field[1] for field in _FIELD.finditer(entry[1])}
    return paths


def _main_numbers(result: xr.Dataset) -> Iterator[tuple[str, str, dict[str, str]]]:
    for path in result.wucht.headlines:
        yield "", f"{{what}}: {{{path}}}", {"what": result.wucht.description_at(path)}


def is_of_version_0_1(result: xr.Dataset) -> bool:
    """True for a result as version 0.1 wrote it: it states neither its contents nor facts about its numbers."""
    return not {"contents", "quantities"} & set(result.attrs)


def _summary_numbers(result: xr.Dataset) -> Iterator[tuple[str, str, dict[str, str]]]:
    yield "note", "of version 0.1 of wucht: its verdict and the numbers of its summary, in SI or dimensionless", {}
    for name, value in result.wucht.summary.items():
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield "", f"{{what}}: {{{name}}}", {"what": name.replace("_", " ")}


def _column_line(heading: str | None, text: str) -> str:
    return text if heading is None else f"  {heading:13}{text}"


def _line(result: xr.Dataset, entry: Any) -> str | None:
    """Return a line; None if one of its numbers is None. Raises ``_NoLineError``."""
    match entry:
        case [str() | None as heading, str(text), dict(texts)] if all(isinstance(one, str) for one in texts.values()):
            if max(map(len, (heading or "", text, *texts.values()))) > _MOST_LETTERS:
                raise _NoLineError(f"a text has at most {_MOST_LETTERS:,} characters")
        case _:
            raise _NoLineError("a line is a heading, a text, and texts for its fields")
    values = list[str | None]()

    def fill_field(field: re.Match[str]) -> str:
        values.append(texts[field[1]] if field[1] in texts else _number(result, field[1], field[2] or ""))
        return values[-1] or ""

    filled_text = _FIELD.sub(fill_field, text)
    return None if None in values else printable(_column_line(heading, filled_text))


def _number(result: xr.Dataset, path: str, form: str) -> str | None:
    """Return a number of the summary in words; None for None. Raises ``_NoLineError``."""
    value: Any = result.wucht.summary
    is_number = _PATH.fullmatch(path) is not None
    for index, name in _STEP.findall(path) if is_number else ():
        try:
            is_number = is_number and not isinstance(value, str)
            value = None if value is None else value[int(index) if index else name]
        except (LookupError, TypeError):
            is_number = False
    if not is_number:
        raise _NoLineError(f"{path[:60]!r} is no number of the summary")
    if _FORM.fullmatch(form) is None:
        raise _NoLineError(f"{form[:20]!r} is no format; allowed are .4g, .4f, .1e with at most 16 digits, and %")
    try:
        return number_text(value, result.wucht.unit_at(path), form, result.wucht.dimensionless)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise _NoLineError(f"{path[:60]!r} is no number") from None
