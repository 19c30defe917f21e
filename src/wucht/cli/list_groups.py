"""Groups of names of ``wucht list``: all on one screen, and each with a line for every name."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from textwrap import wrap

from wucht.cli.list_name import WIDTH, kinds

CATALOGUE, STUDIES = "catalogue", "studies"
_SHORT_TITLES = {"dimensionless machines": "models", "laws of cams": "laws"}  # as arguments of the command
_SENTENCE = re.compile(r"(?<=[.:])\s+(?=[A-Z])")
_HINTS = (
    "wucht list GROUP       a line for each of its names: carriers, studies, practice",
    "wucht list NAME        what it is, with its keys: induction, run-up, practice/screen",
    "wucht list --search W  what has this word in its name, its text, its keys or its results",
    "wucht new --ask        a file from five questions",
)


def groups() -> dict[str, Mapping[str, type]]:
    """Kinds of parts by the name of their group as an argument of the command."""
    return {_SHORT_TITLES.get(title, title): of_kind for title, of_kind in kinds().items()}


def group_names() -> list[str]:
    """Names of all groups: of parts, ``studies``, ``catalogue`` and the folders of the catalogue."""
    return [*groups(), STUDIES, CATALOGUE, *catalogue_folders()]


def catalogue_folders() -> Counter[str]:
    """The folders of the catalogue with the number of files in each."""
    from wucht.files.catalogue import names

    return Counter(name.rpartition("/")[0] for name in names())


def overview() -> Iterator[str]:
    """All groups with the names in them, and how many files each folder of the catalogue has."""
    from wucht.studies.registry import studies

    for group, of_kind in groups().items():
        yield from _name_lines(group, list(of_kind))
    yield from _name_lines(STUDIES, list(studies()))
    yield from _name_lines(CATALOGUE, [f"{folder} ({count})" for folder, count in catalogue_folders().items()])
    yield from ("", *_HINTS)


def lines_of(group: str) -> dict[str, str]:
    """Each name of a group with what it is, in a sentence."""
    from wucht.files.catalogue import FOLDER, names
    from wucht.files.documents import read_toml
    from wucht.schema import prose_of
    from wucht.studies.registry import studies

    if group in groups():
        return {name: first_sentence(prose_of(cls)) for name, cls in groups()[group].items()}
    if group == STUDIES:
        return {kind: first_sentence(study.line) for kind, study in studies().items()}
    in_folder = [name for name in names() if group == CATALOGUE or name.rpartition("/")[0] == group]
    return {name: str(read_toml(FOLDER / f"{name}.toml").get("title", "")) for name in in_folder}


def first_sentence(prose: str) -> str:
    """The first sentence of the first line of a text, without marks of code."""
    return _SENTENCE.split(prose.partition("\n")[0].replace("``", ""))[0].rstrip(":")


def column_lines(entries: Mapping[str, str]) -> Iterator[str]:
    """A line for each entry, aligned."""
    width = max(map(len, entries), default=0)
    yield from (f"  {name:{width}}  {line}".rstrip() for name, line in entries.items())


def _name_lines(group: str, names: list[str]) -> list[str]:
    return wrap(
        f"{group + ':':13}{', '.join(names)}", WIDTH, subsequent_indent=" " * 13, break_long_words=False, break_on_hyphens=False
    )
