"""A result as a chapter of a report: verdict, figure, machine, numbers, assumptions, and how it was computed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError
from wucht.files.toml_text import abridge, toml_text
from wucht.plots.inline_svg import inline_svg
from wucht.plots.machine_drawing import draw_machine
from wucht.plots.page import REPORT
from wucht.reports.markup import brief_text, bullets, html_table, html_text, section
from wucht.results.attempts import Attempts, with_attempt_warnings
from wucht.results.formatting import engineering_text, number_text
from wucht.results.report import is_of_version_0_1
from wucht.studies.registry import studies
from wucht.studies.runner import draw, report

if TYPE_CHECKING:
    import xarray as xr

    from wucht.results.accessor import ResultAccessor

_MOST_ROWS, _MOST_COLUMNS, _BESIDE = 40, 7, 5  # of tables of the summary: beside each other where they are few
_MOST_NUMBERS = 6  # of a list in a cell
_LONGEST, _MOST = 200, 24  # characters of a text, items of a list in the printed study file
_NAME = 15  # characters before the text of an entry, in a line of a report
_COMPUTED_OFFSETS = ".offset_"  # in the paths of parameters that are no data of a machine: they follow from its tracks
_ABRIDGEMENT = "Long texts and tables are shortened here; the result file has all of them."


@dataclass(frozen=True)
class Chapter:
    """A chapter: the name of its anchor, its title and its verdict as plain text, and its HTML.

    warnings: what could not be written in it.
    """

    anchor: str
    title: str
    verdict: str
    html: str
    warnings: tuple[str, ...] = ()


def chapter(result: xr.Dataset, number: int) -> Chapter:
    """Write the chapter of a result.

    Parameters
    ----------
    result : xarray.Dataset
    number : int
        Number of the chapter in its report, from 1.

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
    with attempts.attempt("drawing of the machine", InputError):
        drawing = _drawing(result, anchor)
    if not is_of_version_0_1(result):
        with attempts.attempt("figure", InputError):
            figure = _figure(result, anchor)
    verdict, entries = _entries(lines)
    title = accessor.title or accessor.study
    kind = studies()[accessor.study]
    numbers, tables = _numbers(result)
    parts = [
        f"<h1>{html_text(title, _TITLE)}</h1>",
        f'<p class="meta">Study {html_text(accessor.study)}: {html_text(kind.line)}</p>',
        f'<div class="verdict"><b>Verdict</b>{html_text(verdict)}</div>',
        _incomplete(accessor),
        html_table(entries, kind="entries", row_heads=True),
        section("Warnings", bullets(with_attempt_warnings(result, attempts.warnings).wucht.warnings)),
        drawing,
        figure,
        section("Machine" if accessor.parts else "Subject", _data(result), bullets(accessor.notes)),
        section("Numbers", numbers),
        *tables,
        section("Assumptions", bullets(accessor.assumed)),
        section("How it was computed", _origin(accessor), _study_file(accessor)),
    ]
    body = "\n".join(filter(None, parts))
    return Chapter(
        anchor, title, verdict, f'<section class="chapter" id="{anchor}">\n{body}\n</section>', tuple(attempts.warnings)
    )


_TITLE = 160  # characters of a heading


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


def _drawing(result: xr.Dataset, anchor: str) -> str:
    figure = draw_machine(result)
    if figure is None:
        return ""
    drawing = inline_svg(figure, f"{anchor}-machine", html_text(f"drawing of {brief_text(result.wucht.title)}"))
    scale = "Places, tracks, arms and balls are to scale; sizes of rotors and carrier are not." if not (
        result.wucht.dimensionless
    ) else "Not to scale: the machine is dimensionless."  # fmt: skip
    caption = f"{scale} Bodies of a rotor are drawn spread evenly; the black dot is the rotor's unbalance."
    if estimates := dict.fromkeys(text for part in result.wucht.parts for text in part.get("estimates", ())):
        caption += html_text(f" Not given: {'; '.join(estimates)}.")
    return f'<figure class="machine">{drawing}<figcaption>{caption}</figcaption></figure>'


def _data(result: xr.Dataset) -> str:
    """The data of the machine, a table for each part; equal parts share one. Of other subjects the tables of the study file."""
    accessor = result.wucht
    if not accessor.parts:
        return _other_data(result)
    groups: dict[tuple[Any, ...], list[str]] = {}
    for part in accessor.parts:
        rows = tuple(_part_rows(part, accessor))
        if rows:
            groups.setdefault((part["kind"], part["on"], rows), []).append(part["path"])
    tables = [
        html_table(rows, caption=html_text(_part_title(names, kind, on)), row_heads=True)
        for (kind, on, rows), names in groups.items()
    ]
    return f'<div class="parts">{"".join(tables)}</div>'


def _part_title(paths: Sequence[str], kind: str, on: str) -> str:
    names = ", ".join(paths) or "machine"
    on_text = f" on {on}" if on and on not in names else ""
    return f"{names} ({kind}{on_text})" if kind not in paths else f"{names}{on_text}"


def _part_rows(part: Mapping[str, Any], result: ResultAccessor) -> Iterator[tuple[str, str]]:
    values, before = result.machine.get("parameters", {}), f"{part['path']}." if part["path"] else ""
    for path, facts in part["parameters"].items():
        value = values.get(path)
        if isinstance(value, int | float) and _COMPUTED_OFFSETS not in path:
            start = ", at the start" if facts.get("over_time") else ""
            name = _parameter_name(path.removeprefix(before), facts["what"])
            yield html_text(_sentence_case(name) + start), _no_break(html_text(engineering_text(value, facts["unit"])))
    for estimate in part.get("estimates", ()):
        yield "Estimate", html_text(estimate)


def _parameter_name(key: str, what: str) -> str:
    """A parameter in words: ``mount 1, stiffness in x`` for ``mounts.1.stiffness.x``."""
    *owners, last = key.split(".")
    direction = f" in {last}" if owners and last in ("x", "y") else ""
    inside = [word for word in (owners[:-1] if direction else owners) if word != "at"]
    return " ".join(word.removesuffix("s") for word in inside) + ", " * bool(inside) + what + direction


def _no_break(cell: str) -> str:
    return f'<span style="white-space:nowrap">{cell}</span>'


def _other_data(result: xr.Dataset) -> str:
    """The data of a subject that is no machine, as in its study file; of a result of an earlier version, by their paths."""
    accessor = result.wucht
    facts = {key: value for key, value in accessor.machine.items() if key not in ("title", "structure", "bodies")}
    if accessor.document is not None and not accessor.machine.get("bodies"):
        facts = {key: value for key, value in accessor.document.items() if key != "study"} or facts
    rows = [(html_text(path), html_text(value)) for path, value in _flat(abridge(facts, _LONGEST, _MOST), "")]
    tables = html_table(rows[:_MOST_ROWS], row_heads=True)
    return f'<div class="parts">{tables}</div>{_remarks(_left_out(rows))}' if rows else ""


def _left_out(rows: Sequence[Any]) -> list[str]:
    return [f"{len(rows) - _MOST_ROWS:,} more rows are in the result file."] if len(rows) > _MOST_ROWS else []


def _remarks(lines: Sequence[str]) -> str:
    return "".join(f'<p class="meta">{html_text(line)}</p>' for line in lines)


def _flat(value: Any, path: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _flat(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and any(isinstance(one, Mapping | list) for one in value):
        for k, one in enumerate(value, 1):
            yield from _flat(one, f"{path}.{k}")
    elif value not in (None, "", []):
        yield path, ", ".join(map(_plain, value)) if isinstance(value, list) else _plain(value)


def _plain(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _numbers(result: xr.Dataset) -> tuple[str, list[str]]:
    """The table of all single numbers of a summary, and a section for each list of tables in it."""
    accessor = result.wucht
    dimensionless, rows, tables = accessor.dimensionless, list[tuple[str, str]](), list[str]()
    for key, value in accessor.summary.items():
        facts = accessor.quantities.get(key, {})
        name = _sentence_case(str(facts.get("what", key)))
        if key == "sentence" or value in (None, {}, []):
            continue
        if isinstance(value, list) and all(isinstance(row, Mapping) for row in value):
            tables.append(section(name, _rows_table(value, facts.get("parts", {}), dimensionless)))
        else:
            rows.append((html_text(name), _cell(value, facts, dimensionless)))
    return f'<div class="parts">{html_table(rows, row_heads=True, kind="long")}</div>' if rows else "", tables


def _sentence_case(words: str) -> str:
    return words[:1].upper() + words[1:]


def _rows_table(rows: Sequence[Mapping[str, Any]], parts: Mapping[str, Any], dimensionless: bool) -> str:
    """A list of tables as one: a few beside each other, many below each other with their first columns."""
    every_key = dict.fromkeys(key for row in rows for key in row)
    keys = [key for key in every_key if any(row.get(key) not in (None, {}, []) for row in rows)]
    keys.sort(key=lambda key: any(isinstance(row.get(key), list | Mapping) for row in rows))  # single values first
    names = {key: str(parts.get(key, {}).get("what", key)) for key in keys}
    if len(rows) <= _BESIDE:
        cells = [
            [html_text(_sentence_case(names[key])), *(_cell(row.get(key), parts.get(key, {}), dimensionless) for row in rows)]
            for key in keys
        ]
        return html_table(cells, ("", *map(str, range(1, len(rows) + 1))), row_heads=True, kind="beside")
    columns, left_out = keys[:_MOST_COLUMNS], keys[_MOST_COLUMNS:]
    cells = [[_cell(row.get(key), parts.get(key, {}), dimensionless) for key in columns] for row in rows[:_MOST_ROWS]]
    further = [f"Also in the result file: {', '.join(names[key] for key in left_out)}."] if left_out else []
    head = [html_text(_sentence_case(names[key])) for key in columns]
    return html_table(cells, head) + _remarks([*_left_out(rows), *further])


def _cell(value: Any, facts: Mapping[str, Any], dimensionless: bool) -> str:
    """A value of the summary in HTML, with its unit; in words where it is no number. facts: its unit, and its parts."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        cells = [_cell(one, facts, dimensionless) for one in value[: _MOST_NUMBERS + 1]]
        return "; ".join(cells) if len(cells) <= _MOST_NUMBERS else f"{len(value):,} values, in the result file"
    if isinstance(value, Mapping):
        parts = facts.get("parts", {})
        inner = {
            name: _cell(one, parts.get(name, facts), dimensionless) for name, one in value.items() if one not in (None, {}, [])
        }
        return "<br>".join(f"{html_text(parts.get(name, {}).get('what', name))}: {cell}" for name, cell in inner.items())
    if isinstance(value, int | float):
        unit = str(facts.get("unit", ""))
        has_words = not unit or dimensionless or "/rad" in unit
        return html_text(number_text(value, unit, "", dimensionless) if has_words else engineering_text(value, unit))
    return html_text(value)


def _origin(result: ResultAccessor) -> str:
    """When and with which versions a result was computed."""
    versions = result.versions or {}
    libraries = [f"{name} {version}" for name, version in versions.items() if name != "wucht" and version != "not installed"]
    rows = [
        ("Computed", "" if result.created is None else str(result.created).replace("+00:00", " UTC")),
        ("wucht", versions.get("wucht", "a version that is not recorded")),
        ("With", ", ".join(libraries)),
    ]
    return html_table([(name, html_text(value)) for name, value in rows if value], kind="entries", row_heads=True)


def _study_file(result: ResultAccessor) -> str:
    """The study file, with the machine that it uses and all values that were set; the question alone where there is none."""
    document, heading = result.document, "Study file"
    if document is None:
        document, heading = {"study": result.spec}, "Question"
    printed_part = abridge(document, _LONGEST, _MOST)
    note = _remarks([_ABRIDGEMENT]) if printed_part != document else ""
    return section(heading, f"<pre>{html_text(toml_text(printed_part), 100_000)}</pre>", note, level=3)
