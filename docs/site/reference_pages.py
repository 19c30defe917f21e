"""A page for every study and every part, from the schemas: those of other packages that are installed, too."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from wucht.cams.drive import followers, laws, linkages
from wucht.files.catalogue import FOLDER
from wucht.kinds import classes_of
from wucht.machines.models import DimensionlessMachine
from wucht.machines.parts import GROUP, part_kinds
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support
from wucht.schema import Key, keys_of, prose_of
from wucht.studies.registry import Study, studies

from .gallery import Entry
from .markdown import table, toml_block

# What a file calls them: the table where they stand, and the key that names one of them.
FAMILIES: dict[str, tuple[type[Part], str]] = {
    "carriers": (Support, "`[machine.carrier]`"),
    "bodies": (Body, "`[[machine.bodies]]`"),
    "drives": (Drive, "`[machine.drive]`, or `[[machine.drives]]` with `on`"),
    "loads": (Load, "`[machine.load]`, or `[[machine.loads]]` with `on`"),
    "attachments": (Attachment, "`[[machine.attachments]]`"),
    "dimensionless": (DimensionlessMachine, "`[machine.parameters]`, beside `model` in `[machine]`"),
}
CAMS = {"laws": (laws, "`[law]`"), "followers": (followers, "`[follower]`"), "linkages": (linkages, "`[linkage]`")}
HEADS = ("key", "what", "unit", "default", "what it may be")


def pages(entries: Sequence[Entry]) -> dict[str, str]:
    """All of them by file name, and a list of each."""
    by_kind = {kind: [e for e in entries if e.study_file.spec.kind == kind] for kind in studies()}
    written = {f"studies/{kind}.md": _study(study, by_kind[kind]) for kind, study in studies().items()}
    rows = [(f"[`{kind}`]({kind}.md)", study.line) for kind, study in studies().items()]
    written["studies/index.md"] = _list("Studies", "What can be asked. `wucht new STUDY` writes a file to start from.", rows)
    texts = {e.name: (FOLDER / f"{e.name}.toml").read_text(encoding="utf-8") for e in entries}
    all_parts = dict(parts())
    for place, (kind, cls, where) in all_parts.items():
        written[f"parts/{place}.md"] = _part(kind, cls, where, [e for e in entries if f'"{kind}"' in texts[e.name]])
    listed = [(f"[`{kind}`]({place}.md)", place.partition("/")[0], _first(cls)) for place, (kind, cls, _) in all_parts.items()]
    return written | {"parts/index.md": _list("Parts", "What machines and cams are made of.", listed)}


def parts() -> Iterator[tuple[str, tuple[str, type[Any], str]]]:
    """Place of the page, and kind, class, table of each part; those of a family that is not known here are others."""
    for family, (base, where) in FAMILIES.items():
        yield from ((f"{family}/{kind}", (kind, cls, where)) for kind, cls in part_kinds(base).items())
    bases = tuple(base for base, _ in FAMILIES.values())
    others = sorted((c for c in classes_of(Part, GROUP) if not issubclass(c, bases)), key=lambda c: c.kind)
    yield from ((f"others/{cls.kind}", (cls.kind, cls, "")) for cls in others)
    for family, (kinds, where) in CAMS.items():
        yield from ((f"{family}/{kind}", (kind, cls, where)) for kind, cls in kinds().items())


def _list(title: str, text: str, rows: Sequence[tuple[str, ...]]) -> str:
    return "\n".join([f"# {title}", "", text, "", *table([""] * len(rows[0]), rows), ""])


def _linked(entries: Sequence[Entry], up: str) -> list[str]:
    lines = [f"- [{e.about.get('title', e.name)}]({up}gallery/{e.name}.md), `{e.name}`" for e in entries]
    return ["## In the gallery", "", *lines, ""] if lines else []


def _study(study: Study, entries: Sequence[Entry]) -> str:
    spec = study.study
    lines = [f"# {study.kind}", "", *_prose(spec), ""]
    lines += [f"In Python `wucht.{spec.__name__}(...)`. " + (_TILED if spec.tiled else ""), ""]
    lines += ["```sh", f"wucht new {study.kind} my-{study.kind}.toml", f"wucht run my-{study.kind}.toml", "```", ""]
    lines += _picture(entries)
    lines += ["## Keys", "", "In `[study]`, beside `kind`:", "", *_keys(spec)]
    lines += _linked(entries, "../")
    lines += _answers(entries)
    if study.template:
        lines += ["## A file to start from", "", *toml_block(study.template), ""]
    return "\n".join(lines)


_TILED = "Several machines can compute it: [`--scheduler`](../several-machines.md)."


def _picture(entries: Sequence[Entry]) -> list[str]:
    """The figure of the first answer that the gallery has."""
    shown = next((e for e in entries if e.result is not None), None)
    if shown is None:
        return []
    title, page = shown.about.get("title", shown.name), f"../gallery/{shown.name}"
    return [
        f'<figure markdown="span">\n![{title}]({page}.png)\n<figcaption markdown>[{title}]({page}.md)</figcaption>\n</figure>',
        "",
    ]


def _answers(entries: Sequence[Entry]) -> list[str]:
    """The keys of a summary with what they are, as an answer in the gallery has them."""
    answered = next((e for e in entries if e.result is not None), None)
    if answered is None:
        return []
    quantities = answered.result.wucht.quantities.items()
    rows = [(f"`{key}`", facts.get("what", ""), facts.get("unit", "")) for key, facts in quantities]
    text = f"`summary.json` of [{answered.name}](../gallery/{answered.name}.md) has `sentence`, the answer in words, and"
    return ["## Its summary", "", text, "", *table(("key", "what", "unit"), rows), ""]


def _part(kind: str, cls: type[Any], where: str, used: Sequence[Entry]) -> str:
    lines = [f"# {kind}", "", *_prose(cls), ""]
    if where:
        lines += [f"Stands in {where}.", ""]
    if issubclass(cls, Part):
        lines += [f"In Python `wucht.parts.{cls.__name__}(...)`.", ""]
    return "\n".join([*lines, "## Keys", "", *_keys(cls), *_own_states(cls), *_linked(used, "../../")])


def _own_states(cls: type[Any]) -> list[str]:
    """What of a part is a state of its own, which a result has and a start may give."""
    rows = [(f"`{x.name}`", x.what, x.unit) for x in getattr(cls, "internal_states", ())]
    text = "Beside the motion the part has states of its own. They begin at 0, or where `start` says; a run-up stores them."
    return ["## States", "", text, "", *table(("state", "what", "unit"), rows), ""] if rows else []


def _keys(cls: type[Any]) -> list[str]:
    return [*table(HEADS, [_cells(key) for key in keys_of(cls)]), ""]


def _cells(key: Key) -> tuple[str, ...]:
    default = "**needed**" if key.needed else "" if key.default is None else f"`{json.dumps(key.default)}`"
    value = f"{key.type} {key.allowed}" if key.allowed and not key.type.startswith("word") else key.allowed or key.type
    return f"`{key.name}`", key.what, key.unit or "", default, value


def _first(cls: type[Any]) -> str:
    return prose_of(cls).partition("\n")[0]


def _prose(cls: type[Any]) -> list[str]:
    """The docstring of a class as paragraphs of Markdown."""
    paragraphs = prose_of(cls).split("\n\n")
    return "\n\n".join(" ".join(p.split()).replace("``", "`") for p in paragraphs).splitlines()
