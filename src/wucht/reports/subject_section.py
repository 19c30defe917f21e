"""The machine or other subject of results in a report: drawn and told once where several results share it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wucht.files.toml_text import abridge, toml_text
from wucht.plots.inline_svg import inline_svg
from wucht.plots.machine_drawing import draw_machine
from wucht.reports.markup import brief_text, bullets, html_table, html_text, section
from wucht.results.formatting import engineering_text

if TYPE_CHECKING:
    import xarray as xr

    from wucht.results.accessor import ResultAccessor

MOST_ROWS = 40  # of a table
_LONGEST, _MOST = 200, 24  # characters of a text, items of a list in the printed study file
_COMPUTED_OFFSETS = ".offset_"  # in the paths of parameters that are no data of a machine: they follow from its tracks
_ABRIDGEMENT = "Long texts and tables are shortened here; the result file has all of them."
_OUTSIDE = ("title", "structure", "bodies")  # facts about a subject that are none of its data


@dataclass(frozen=True)
class SharedSubject:
    """A subject of several results.

    first: the first of them; anchor: of its section; warnings, notes: those of all of them, which no chapter repeats.
    """

    first: xr.Dataset
    anchor: str
    warnings: tuple[str, ...]
    notes: tuple[str, ...]


def shared_subjects(results: Sequence[xr.Dataset]) -> list[SharedSubject | None]:
    """For each result the subject that it shares with others: a machine of the same parts, a cam with the same tables."""
    groups: dict[str, list[xr.Dataset]] = {}
    keys = [_subject_key(result) for result in results]
    for key, result in zip(keys, results, strict=True):
        groups.setdefault(key, []).append(result)
    by_key = {
        key: SharedSubject(
            of_key[0], f"m{number}",
            _common_items([result.wucht.warnings for result in of_key]),
            _common_items([result.wucht.notes for result in of_key]),
        )
        for number, (key, of_key) in enumerate(groups.items(), 1)
        if key and len(of_key) > 1
    }  # fmt: skip
    return [by_key.get(key) for key in keys]


def _common_items(lists: Sequence[Sequence[str]]) -> tuple[str, ...]:
    return tuple(item for item in lists[0] if all(item in further for further in lists[1:]))


def _subject_key(result: xr.Dataset) -> str:
    """What two results of one subject have in common; empty where nothing is known about it."""
    accessor = result.wucht
    if not accessor.parts:
        return json.dumps(facts, sort_keys=True, default=str) if (facts := _other_facts(accessor)) else ""
    places = [(part["path"], part["kind"], part["on"]) for part in accessor.parts]
    return json.dumps([accessor.dimensionless, places])


def drawing_of(result: xr.Dataset, anchor: str) -> str:
    """The drawing of the machine of a result, empty where there is none."""
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


def data_of(result: xr.Dataset) -> str:
    """The data of the machine, a table for each part; equal parts share one. Of other subjects the tables of the study file."""
    accessor = result.wucht
    if not accessor.parts:
        return _other_data(accessor)
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for part in accessor.parts:
        rows = tuple(_part_rows(part, accessor))
        if rows:
            groups.setdefault((part["kind"], rows), []).append(part)
    tables = [
        html_table(rows, caption=html_text(_part_title(equal, kind)), row_heads=True) for (kind, rows), equal in groups.items()
    ]
    return f'<div class="parts">{"".join(tables)}</div>'


def parameter_differences(result: xr.Dataset, first: xr.Dataset) -> str:
    """The parameters of a machine that differ from those of the first result about it."""
    of_first = {part["path"]: dict(_part_rows(part, first.wucht)) for part in first.wucht.parts}
    rows: dict[tuple[str, str], list[str]] = {}
    for part in result.wucht.parts:
        for name, value in _part_rows(part, result.wucht):
            if of_first.get(part["path"], {}).get(name) != value:
                rows.setdefault((name, value), []).append(part["path"] or "machine")
    cells = [(html_text(f"{', '.join(paths)}: ") + name, value) for (name, value), paths in rows.items()]
    return html_table(cells[:MOST_ROWS], row_heads=True) + remarks(left_out(cells))


def notes_once(notes: Sequence[str]) -> list[str]:
    """Notes on parts, those that say the same of several parts as one: ``drives.e1, drives.e2: circuit of the nameplate``."""
    places: dict[str, list[str]] = {}
    for note in notes:
        place, colon, text = note.partition(": ")
        is_about_part = bool(colon) and " " not in place
        places.setdefault(text if is_about_part else note, []).extend([place] if is_about_part else [])
    return [f"{', '.join(of_text)}: {text}" if of_text else text for text, of_text in places.items()]


def shared_section(subject: SharedSubject, chapters: Sequence[int], is_only_one: bool) -> str:
    """The section of a subject that several chapters share. chapters: their numbers, for the heading where others differ."""
    accessor = subject.first.wucht
    heading = "Machine" if accessor.parts else "Subject"
    heading += "" if is_only_one else f" of {', '.join(map(str, chapters))}: {brief_text(accessor.title)}"
    return f'<section class="subject" id="{subject.anchor}">' + section(
        heading,
        drawing_of(subject.first, subject.anchor),
        data_of(subject.first),
        bullets(notes_once(subject.notes)),
        bullets(subject.warnings),
    ) + "</section>"  # fmt: skip


def study_file(document: Mapping[str, Any] | None, spec: Mapping[str, Any], *, level: int = 3) -> str:
    """The study file, with the machine that it uses and all values that were set; the question alone where there is none."""
    heading = "Question" if document is None else "Study file"
    whole = {"study": spec} if document is None else document
    printed_part = abridge(whole, _LONGEST, _MOST)
    note = remarks([_ABRIDGEMENT]) if printed_part != whole else ""
    return section(heading, f"<pre>{html_text(toml_text(printed_part), 100_000)}</pre>", note, level=level)


def question_line(spec: Mapping[str, Any]) -> str:
    """A question in small print: its keys and values."""
    keys = ", ".join(f"{path} = {value}" for path, value in _flat(abridge(spec, _LONGEST, _MOST), ""))
    return f'<p class="meta">Question: {html_text(keys)}</p>'


def left_out(rows: Sequence[Any], most: int = MOST_ROWS) -> list[str]:
    """A remark on the rows that a table of at most so many leaves out, if there are some."""
    return [f"{len(rows) - most:,} more rows are in the result file."] if len(rows) > most else []


def remarks(lines: Sequence[str]) -> str:
    """Lines in small print."""
    return "".join(f'<p class="meta">{html_text(line)}</p>' for line in lines)


def sentence_case(words: str) -> str:
    """Words with a capital at their beginning."""
    return words[:1].upper() + words[1:]


def _part_title(equal_parts: Sequence[Mapping[str, Any]], kind: str) -> str:
    paths, bodies = [part["path"] for part in equal_parts], {part["on"] for part in equal_parts}
    on = bodies.pop() if len(bodies) == 1 else ""
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
            yield html_text(sentence_case(name) + start), _no_break(html_text(engineering_text(value, facts["unit"])))
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


def _other_facts(accessor: ResultAccessor) -> dict[str, Any]:
    facts = {key: value for key, value in accessor.machine.items() if key not in _OUTSIDE}
    if accessor.document is not None and not accessor.machine.get("bodies"):
        facts = {key: value for key, value in accessor.document.items() if key != "study"} or facts
    return facts


def _other_data(accessor: ResultAccessor) -> str:
    """The data of a subject that is no machine, as in its study file; of a result of an earlier version, by their paths."""
    rows = [(html_text(path), html_text(value)) for path, value in _flat(abridge(_other_facts(accessor), _LONGEST, _MOST), "")]
    tables = html_table(rows[:MOST_ROWS], row_heads=True)
    return f'<div class="parts">{tables}</div>{remarks(left_out(rows))}' if rows else ""


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
