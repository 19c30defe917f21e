"""``wucht list --search WORD``: which studies, parts and files of the catalogue have to do with a word."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from inspect import getsource
from pkgutil import iter_modules
from typing import Any

from wucht.cli.list_groups import CATALOGUE, STUDIES, column_lines, first_sentence, groups, lines_of
from wucht.errors import InputError, WuchtError

MOST = 15  # lines
_LONGEST = 60  # letters of what a key is
# How the source of a study states a name of its results, and from which modules it takes what several studies state.
_NAME_OF_RESULT = re.compile(r'(?:\b(?:number|curve|table|table_of|group|Quantity)\(\s*|(?<=[{\s]))"(\w+)"(?:,|: \(")')
_IMPORT = re.compile(r"^from (wucht\.(?:studies|dynamics|analysis)[\w.]*) import", re.MULTILINE)


@dataclass(frozen=True)
class Finding:
    """What has a word. rank: 0 where it is its name; place: where the word is."""

    rank: int
    name: str
    place: str


def search_lines(word: str) -> list[str]:
    """Return a line for each of the most likely findings, the best first. Raises ``InputError`` where there is none."""
    from wucht.files.catalogue import nearest_names

    plain_word = _plain(word)
    if not plain_word:
        raise InputError("--search", word, "must be a word")
    best: dict[str, Finding] = {}
    for finding in sorted(_findings(plain_word), key=lambda one: one.rank):
        best.setdefault(finding.name, finding)
    if not best:
        names = {name for group in (*groups(), STUDIES, CATALOGUE) for name in lines_of(group)}
        raise InputError("--search", word, f"nothing has this word; {nearest_names(word, names)}")
    lines = list(column_lines({name: finding.place for name, finding in list(best.items())[:MOST]}))
    return [*lines, *([f"  and {len(best) - MOST} more: give more letters"] if len(best) > MOST else [])]


def _findings(plain_word: str) -> Iterator[Finding]:
    from wucht.studies.registry import studies

    for group, of_kind in groups().items():
        for name, line in lines_of(group).items():
            yield from _part_findings(plain_word, name, f"{group}: {line}", of_kind[name])
    for kind, entry in studies().items():
        line = f"{STUDIES}: {first_sentence(entry.line)}"
        try:
            yield from _part_findings(plain_word, kind, line, entry.study)
            names = [name for name in _result_names(entry.package) if plain_word in _plain(name)]
        except WuchtError:  # it cannot be loaded
            continue
        if names:
            best = min(names, key=lambda name: (_plain(name) != plain_word, len(name)))
            yield Finding(1 if _plain(best) == plain_word else 4, kind, f"{STUDIES}, in its results: {best}")
    for name, title in lines_of(CATALOGUE).items():
        if plain_word in _plain(name):
            yield Finding(2, name, f"{CATALOGUE}: {title}")
        elif plain_word in _plain(title):
            yield Finding(3, name, f"{CATALOGUE}: {title}")


def _part_findings(plain_word: str, name: str, line: str, cls: type[Any]) -> Iterator[Finding]:
    """Findings in the name, text and keys of a study or part."""
    from wucht.files.equal_bodies import keys_in_files
    from wucht.schema import prose_of

    if plain_word in _plain(name):
        yield Finding(0 if plain_word == _plain(name) else 1, name, line)
    elif plain_word in _plain(line):
        yield Finding(3, name, line)
    group = line.partition(":")[0]
    for key in keys_in_files(cls):
        if plain_word in _plain(key.name):
            is_whole = plain_word == _plain(key.name.rpartition(".")[2])
            yield Finding(2 if is_whole else 4, name, f"{group}, key {key.name}: {_brief(key.what)}")
        elif plain_word in _plain(key.what):
            yield Finding(5, name, f"{group}, key {key.name}: {_brief(key.what)}")
    if plain_word in _plain(prose_of(cls)):
        yield Finding(6, name, line)


@cache
def _result_names(package: str) -> frozenset[str]:
    """Names of the results of a study, as its sources and the modules of studies that they use state them."""
    module = import_module(package)
    inside = [name for _, name, _ in iter_modules(getattr(module, "__path__", []), f"{package}.")]
    sources = [_source(name) for name in (package, *inside)]
    modules = {name for source in sources for name in _IMPORT.findall(source) if not name.startswith(package)}
    return frozenset(name for source in (*sources, *map(_source, modules)) for name in _NAME_OF_RESULT.findall(source))


@cache
def _source(module: str) -> str:
    try:
        return getsource(import_module(module))
    except (OSError, TypeError):  # an empty file, or one without source
        return ""


def _plain(words: str) -> str:
    return " ".join(words.lower().replace("_", " ").replace("-", " ").split())


def _brief(words: str) -> str:
    first = first_sentence(" ".join(words.replace("`", "").split()).split(";")[0])
    return first if len(first) <= _LONGEST else f"{first[: _LONGEST - 3].rstrip()}..."
