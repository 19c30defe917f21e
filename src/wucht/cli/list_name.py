"""What one name of ``wucht list`` is: a study or part with its keys, or a file of the catalogue, on one screen.

A screen has 24 lines of 100 characters. Keys that do not fit with their help are listed in a line each, those that must be
given first; ``--all`` lists every key at length.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError
from wucht.file_names import printable

if TYPE_CHECKING:
    from wucht.schema import Key

LINES, WIDTH = 24, 100  # of a screen
_WIDEST = 44  # of a column
_HELP = " " * 6  # before the help of a key, below it
_LABEL = 8  # characters before the text of a line that has a name
_NOTES = 8  # lines of the notes of a file
_DOCS = "of the documentation (make docs)"

# Where each kind is in a file, and the folder of its pages in the documentation.
_PLACES = {
    "carriers": ('[machine.carrier] directions = "{}"', "parts/carriers"),
    "bodies": ('[[machine.bodies]] kind = "{}"', "parts/bodies"),
    "drives": ('[machine.drive] kind = "{}"', "parts/drives"),
    "loads": ('[[machine.loads]] kind = "{}"', "parts/loads"),
    "attachments": ('[[machine.attachments]] kind = "{}"', "parts/attachments"),
    "dimensionless machines": ('[machine] model = "{}", keys of [machine.parameters]', "parts/dimensionless"),
    "laws of cams": ('[law] kind = "{}"', "parts/laws"),
    "followers": ('[follower] kind = "{}"', "parts/followers"),
    "linkages": ('[linkage] kind = "{}"', "parts/linkages"),
    "studies": ('[study] kind = "{}"', "studies"),
}


@dataclass(frozen=True)
class Entry:
    """A study or part. table: where it is in a file; prose: its description; page: its page in the documentation."""

    name: str
    title: str
    prose: str
    keys: Sequence[Key]
    states: Sequence[Any]
    page: str

    @property
    def table(self) -> str:
        """Its table in a file."""
        return _PLACES[self.title][0].format(self.name)

    @property
    def hints(self) -> list[str]:
        """Lines on its page, and on the template of a study."""
        template = [_labelled_line("copy", f"wucht new {self.name} my-{self.name}.toml")] if self.title == "studies" else []
        return [*template, _labelled_line("page", f"{self.page} {_DOCS}")]

    @property
    def json_table(self) -> dict[str, Any]:
        """The table of one name in the output of ``--json``."""
        states = {"states": [asdict(x) for x in self.states]} if self.states else {}
        return {
            "table": self.table,
            "description": self.prose,
            "keys": [asdict(k) for k in self.keys],
            "page": self.page,
        } | states


def kinds() -> dict[str, Mapping[str, type]]:
    """All kinds that a file can name, except studies, by category."""
    from wucht.cams.drive import followers, laws, linkages
    from wucht.machines.models import models
    from wucht.machines.parts import attachments, bodies, carriers, drives, loads

    parts: dict[str, Mapping[str, type]] = {"carriers": carriers(), "bodies": bodies(), "drives": drives(), "loads": loads()}
    parts["attachments"] = attachments()
    of_cams: dict[str, Mapping[str, type]] = {"laws of cams": laws(), "followers": followers(), "linkages": linkages()}
    return {**parts, "dimensionless machines": models(), **of_cams}


def describe_name(name: str, *, as_json: bool = False, every_key: bool = False, groups: Sequence[str] = ()) -> str:
    """Describe a study, a part, or a file of the catalogue as text.

    Parameters
    ----------
    name : str
        A drive and a load may share one, as both kinds ``table`` do.
    as_json : bool
        As one JSON object.
    every_key : bool
        All keys with their help, however long that is.
    groups : sequence of str
        Names of groups, which an error may suggest.

    Returns
    -------
    str
        At most a screen, unless ``as_json`` or ``every_key``.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one.
    """
    from wucht.files.catalogue import names

    if name in names():
        facts = _catalogue_facts(name)
        return json.dumps(facts, indent=2, ensure_ascii=False) if as_json else "\n".join(_catalogue_lines(facts))
    entries = _entries(name, names(), groups)
    if as_json:
        return json.dumps({"name": name, "tables": [e.json_table for e in entries]}, indent=2, ensure_ascii=False)
    whole = ["\n".join(_long_lines(entry)) for entry in entries]
    if every_key or _fits("\n\n".join(whole)):
        return "\n\n".join(whole)
    last = _labelled_line("all", f"wucht list {name} --all")
    room = LINES // len(entries) - 1  # of each, with the blank line or the last one after it
    return "\n".join(["\n\n".join("\n".join(_short_lines(entry, room)) for entry in entries), last])


def _fits(text: str) -> bool:
    lines = text.split("\n")
    return len(lines) <= LINES and max(map(len, lines)) <= WIDTH


def _entries(name: str, catalogue: Sequence[str], groups: Sequence[str]) -> list[Entry]:
    from wucht.files.catalogue import nearest_names
    from wucht.files.equal_bodies import keys_in_files
    from wucht.schema import prose_of
    from wucht.studies.registry import studies

    by_title: dict[str, Mapping[str, Any]] = {**kinds(), "studies": studies()}
    entries = []
    for title, of_kind in by_title.items():
        if name in of_kind:
            cls = of_kind[name].study if title == "studies" else of_kind[name]
            states, page = getattr(cls, "internal_states", ()), f"{_PLACES[title][1]}/{cls.kind}.html"
            entries.append(Entry(name, title, prose_of(cls).replace("``", ""), keys_in_files(cls), states, page))
    if not entries:
        every_name = {kind for of_kind in by_title.values() for kind in of_kind} | {*catalogue, *groups}
        requirement = f"must be a study, a part or a catalogue name; {nearest_names(name, every_name)}"
        raise InputError("NAME", name, requirement)
    return entries


def _long_lines(entry: Entry) -> Iterator[str]:
    """All keys of an entry with their help."""
    yield from (entry.table, "", *(line for one in entry.prose.split("\n") for line in wrap(one, WIDTH) or [""]), "")
    if entry.keys:
        head, *rows = _rows([("key", "value", "unit", "default", "allowed"), *map(_cells, entry.keys)])
        yield head
        for key, row in zip(entry.keys, rows, strict=True):
            yield row
            yield from fill(_help(key), WIDTH, initial_indent=_HELP, subsequent_indent=_HELP).split("\n")
    if entry.states:
        yield from ("", "Internal states, in results and in start:", "")
        yield from _rows([("state", "unit", ""), *((x.name, x.unit, x.what) for x in entry.states)])
    yield from ("", *entry.hints)


def _short_lines(entry: Entry, room: int) -> Iterator[str]:
    """The keys of an entry in at most this many lines: the needed ones first, the names of the others at the end."""
    first = " ".join(entry.prose.split("\n\n")[0].split())
    about = wrap(first, WIDTH, max_lines=2 if room > LINES // 2 else 1, placeholder=" ...")
    keys = sorted(entry.keys, key=lambda key: (bool({".", "["} & set(key.name)), not key.needed))  # a table before its keys
    most = room - len(about) - len(entry.hints) - 2  # less the lines of the table's place and of the heads
    listed_keys = keys if len(keys) <= most else keys[: most - 1]
    cells = [
        (k.name, "needed" if k.needed else _brief_text(_default(k.default), _WIDEST // 2), k.unit or "") for k in listed_keys
    ]
    yield from (entry.table, *about)
    helps = ["meaning", *map(_help, listed_keys)]
    for row, words in zip(_rows([("key", "default", "unit"), *cells], pad=True), helps, strict=True):
        yield f"{row}  {_brief_text(words, WIDTH - len(row) - 2)}"
    if len(listed_keys) < len(keys):
        further = ", ".join(key.name for key in keys[len(listed_keys) :])
        yield f"  {_brief_text(f'and {len(keys) - len(listed_keys)} more: {further}', WIDTH - 2)}"
    yield from entry.hints


def _brief_text(words: str, longest: int) -> str:
    """A text of at most this many characters."""
    return words if len(words) <= longest else f"{words[: longest - 3].rstrip()}..."


def _labelled_line(label: str, text: str) -> str:
    return f"{label:{_LABEL}}{text}"


def _help(key: Key) -> str:
    return " ".join(key.what.replace("`", "").split())


def _cells(key: Key) -> tuple[str, ...]:
    default = "needed" if key.needed else _default(key.default)
    return key.name, key.type, key.unit or "", default, key.allowed


def _rows(cells: Sequence[tuple[str, ...]], *, pad: bool = False) -> list[str]:
    """The lines of a table with aligned columns. pad: the last one, too."""
    widths = [min(max(map(len, column)), _WIDEST) for column in zip(*cells, strict=True)]
    lines = ["  " + "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) for row in cells]
    return lines if pad else [line.rstrip() for line in lines]


def _default(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value)


def _catalogue_facts(name: str) -> dict[str, Any]:
    """What a file of the catalogue is: title, source, notes, its study, its parts, and how it is run, moved and copied."""
    from wucht.files.catalogue import load_document
    from wucht.studies.registry import requested_study
    from wucht.studies.study_file import DEFAULT_KIND

    document, path = load_document(name)
    study = requested_study(document.get("study", {"kind": DEFAULT_KIND}))
    copy = Path(name).name
    return {
        "name": name,
        "title": str(document.get("title", name)),
        "source": str(document.get("source", "")),
        "notes": " ".join(str(document.get("notes", "")).split()),
        "study": study.kind,
        "answers": study.line,
        "parts": _parts_in(document, path, name),
        "page": f"gallery/{name}.html",
        "run": f"wucht run {name}",
        "move": f"wucht share {name}" if _can_be_shared(document, path, name) else "",
        "copy": f"wucht new {name} my-{copy}.toml",
    }


def _can_be_shared(document: Mapping[str, Any], path: Path, name: str) -> bool:
    """Whether a file has a machine, none of whose bodies is locked until its release."""
    from wucht.files.catalogue import described_machine

    if "machine" not in document:
        return False
    bodies = described_machine(dict(document), path, name, {}).get("bodies", [])
    return not any("release" in body for body in bodies)


def _parts_in(document: Mapping[str, Any], path: Path, name: str) -> list[str]:
    """The parts of a machine or cam drive in words; of a table of equations its states."""
    from wucht.files.catalogue import described_equations, described_machine

    if "machine" in document:
        return _machine_parts(described_machine(dict(document), path, name, {}))
    if "system" in document:
        equations = described_equations(dict(document), path, name, {})
        return [f"equations of {', '.join(equations.get('equations') or equations.get('states') or ())}"]
    return [f"{key} ({document[key].get('kind', 'constant')})" for key in ("law", "follower", "linkage") if key in document]


def _machine_parts(machine: Mapping[str, Any]) -> list[str]:
    if "model" in machine:
        return [f"dimensionless machine ({machine['model']})"]
    parts = [f"carrier ({machine.get('carrier', {}).get('directions', 'xy')})"]
    bodies = [(b["kind"], b.get("about", ""), str(b["name"])) for b in machine.get("bodies", [])]
    for (kind, about), of_kind in groupby(bodies, key=lambda body: body[:2]):
        same = [body[2] for body in of_kind]
        label = ", ".join(same) if len(same) <= 2 else f"{same[0]} to {same[-1]}"
        parts.append(f"{label} ({kind}{f' on {about}' if about else ''})")
    for group in ("drive", "load", "attachment"):
        shafts = machine.get(f"{group}s") or ([machine[group]] if group in machine else [])
        on = [f" on {s['on']}" if s.get("on") and len(shafts) > 1 else "" for s in shafts]
        parts += [f"{group} ({shaft['kind']}{place})" for shaft, place in zip(shafts, on, strict=True)]
    return parts


def _catalogue_lines(facts: Mapping[str, Any]) -> Iterator[str]:
    """A file of the catalogue on a screen."""
    yield from wrap(printable(facts["title"]), WIDTH, max_lines=2, placeholder=" ...")
    yield from wrap(facts["notes"], WIDTH, max_lines=_NOTES, placeholder=" ...")
    study = f"{facts['study']}: {facts['answers'].replace('``', '')}"
    values = {"source": facts["source"], "study": study, "parts": "; ".join(facts["parts"]), "page": f"{facts['page']} {_DOCS}"}
    for label, text in (values | {key: facts[key] for key in ("run", "move", "copy")}).items():
        indent = " " * _LABEL
        yield from wrap(
            text, WIDTH, initial_indent=_labelled_line(label, ""), subsequent_indent=indent, max_lines=3, placeholder=" ..."
        ) if text else ()  # fmt: skip
