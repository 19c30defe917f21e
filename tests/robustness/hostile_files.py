"""Study files that nobody should write: made at random from the schema, the catalogue and the templates, each from its seed."""

from __future__ import annotations

import datetime
import json
import random
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

_NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 1e308, -1e308, 1e-320, 5e-324, 1e300, 1e29, 1e-29, 1e12, -1e-12, 0.1, 2**63, -(2**63) - 1, 10**30,
    float("nan"), float("inf"), float("-inf"), -0.0,
)  # fmt: skip
_TEXTS = (
    "", " ", "1", "NaN kg", "inf s", "1e400 kg", "1 furlong", "1,5 mm", "5 kg^9^9^9^9", "9**9**9", "1 m/s/s/s", "-3 dB",
    "1e300 rpm", "50 Hz", "1e200 N/m", "1e-300 s", "x*(", "(((((", "x" * 5000, "\u8f6c\u5b50", "\u202eabc", "a\nb",
    "\x1b[31m", "=1+1", "../../x", "/", "~", "__import__('os').system('true')", "lambda: 0", "sin(1e308)", "x**x**x",
    "1e307 deg", "rotor", "drum", "p1", "carrier", "settled", "radau", "heyoka", "scipy-radau", "nothing.toml", "/dev/null",
    "/proc/self/mem", ".", "practice/screen", "study.toml", "t", "phi",
)  # fmt: skip
_TABLES: tuple[Any, ...] = (
    [], {}, [[]], [{}], [0, 1], [1, 0], [[0, 1e308], [1, -1e308]], ["1 mm", "2 s"], [None], {"": 1}, {"from": 0, "to": 1e308},
    {"kind": "rotor"}, {"use": "study.toml"}, [1] * 3000, [[0, 0], [0, 0]], [[0, 0], [1, 1], [2, 4]], {"points": [[0, 1]]},
    True, False, datetime.date(2026, 1, 1), datetime.time(1, 2), [0, float("nan")], {"turns": 1e300},
    {"damping": {"scale": 0}},
)  # fmt: skip
_WORDS = (
    "kind", "name", "about", "on", "mass", "use", "set", "schedules", "bodies", "start", "points", "study", "machine", "",
    "x y", "\u00fc",
)  # fmt: skip
_SETTINGS = (
    "={}", "=[]", "=", "", "=1e308", "=nan", "='x'", "=\"1 furlong\"", "=[[[[[[", "=" + "[" * 2000, "={a=1}", "=1979-05-27",
    "=-1", "=true", "=9" + "9" * 400, "=0", "=1e-320",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A study file, and the words after ``wucht run study.toml -o out``."""

    seed: int
    name: str
    text: bytes
    words: tuple[str, ...]


@cache
def bases() -> dict[str, dict[str, Any]]:
    """The documents that are spoiled: of the catalogue, and the templates of all studies, by name."""
    from wucht.files.catalogue import locate, names
    from wucht.studies.registry import studies

    files = {name: tomllib.loads(locate(name).read_text(encoding="utf-8")) for name in names()}
    templates = {kind: tomllib.loads(study.template) for kind, study in studies().items() if study.template}
    return dict(sorted((files | templates).items()))


@cache
def schema() -> dict[str, list[tuple[str, str]]]:
    """The keys of studies and parts with what they allow, by kind."""
    from wucht.cli.list_name import kinds
    from wucht.schema import keys_of
    from wucht.studies.registry import studies

    classes = {kind: study.study for kind, study in studies().items()}
    classes |= {kind: cls for of_kind in kinds().values() for kind, cls in of_kind.items()}
    return {kind: [(key.name, key.allowed) for key in keys_of(cls)] for kind, cls in sorted(classes.items())}


def case(seed: int) -> Case:
    """The case of a seed."""
    chance = random.Random(seed)
    name = chance.choice(list(bases()))
    document = json.loads(json.dumps(bases()[name], default=str))
    _shorten(document)
    changes = chance.choice((_MILD, _CHANGES))
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        chance.choice(changes)(chance, document)
    text = "".join(_toml(document)).encode()
    if changes is _CHANGES and chance.random() < 0.08:
        text = _spoilt(chance, text)
    words = tuple(
        w for _ in range(changes is _CHANGES and chance.random() < 0.2) for w in ("--set", _setting(chance, document))
    )
    return Case(seed, name, text, words + (("--json",) if chance.random() < 0.3 else ()))


def _shorten(document: dict[str, Any]) -> None:
    """What takes long otherwise."""
    study = document.get("study")
    if isinstance(study, dict) and study.get("kind", "run-up") == "run-up" and "use" not in document:
        study["until"] = 0.5
        study.pop("turns", None)
        study.pop("settled", None)


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """All places of a document: a table or list, and the key or index in it."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inside in items:
        yield value, key
        yield from _places(inside)


def _place(chance: random.Random, document: dict[str, Any], *kinds: type) -> tuple[Any, Any] | None:
    """A place, of a value of these types if any are given."""
    places = [p for p in _places(document) if not kinds or (isinstance(p[0][p[1]], kinds) and not isinstance(p[0][p[1]], bool))]
    return chance.choice(places) if places else None


def _hostile(chance: random.Random) -> Any:
    return chance.choice(chance.choice((_NUMBERS, _NUMBERS, _TEXTS, _TABLES)))


def _replace(chance: random.Random, document: dict[str, Any]) -> None:
    if place := _place(chance, document):
        place[0][place[1]] = _hostile(chance)


def _scale(chance: random.Random, document: dict[str, Any]) -> None:
    """A number, or the number of a quantity: a little, or by many powers of ten."""
    place = _place(chance, document, int, float, str)
    if place is None:
        return
    old = place[0][place[1]]
    factor = (
        10.0 ** chance.uniform(-2, 2) if chance.random() < 0.5 else chance.choice((1, 1, -1)) * 10.0 ** chance.randint(-15, 15)
    )
    if isinstance(old, str):
        number, space, unit = old.partition(" ")
        try:
            place[0][place[1]] = f"{float(number) * factor!r}{space}{unit}"
        except ValueError:
            place[0][place[1]] = chance.choice(_TEXTS)
    else:
        place[0][place[1]] = old * factor


def _remove(chance: random.Random, document: dict[str, Any]) -> None:
    if place := _place(chance, document):
        del place[0][place[1]]


def _repeat(chance: random.Random, document: dict[str, Any]) -> None:
    """An entry of a list, once or often."""
    lists = [p[0][p[1]] for p in _places(document) if isinstance(p[0][p[1]], list) and p[0][p[1]]]
    if lists:
        entries = chance.choice(lists)
        entries += [chance.choice(entries)] * chance.choice((1, 1, 1, 2, 40))


def _tables(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [document, *(p[0][p[1]] for p in _places(document) if isinstance(p[0][p[1]], dict))]


def _add(chance: random.Random, document: dict[str, Any]) -> None:
    """A key that its table may have, with a value that it may have or one that it may not."""
    tables = [t for t in _tables(document) if isinstance(t.get("kind"), str) and t["kind"] in schema()]
    if not tables:
        return
    table = chance.choice(tables)
    key, allowed = chance.choice(schema()[table["kind"]] or [("x", "")])
    choices = [word.strip("'\"") for word in allowed.split(", ") if word and word[0] not in "<>"]
    wanted = (
        chance.choice(choices)
        if choices and chance.random() < 0.5
        else chance.choice((0.5, 2, 1e-3, 30.0, "x", True, [1.0, 2.0]))
    )
    table[key.split(".")[0].split("[")[0]] = wanted if chance.random() < 0.6 else _hostile(chance)


def _add_unknown(chance: random.Random, document: dict[str, Any]) -> None:
    chance.choice(_tables(document))[chance.choice(_WORDS)] = _hostile(chance)


def _swap(chance: random.Random, document: dict[str, Any]) -> None:
    """Two values."""
    one, other = _place(chance, document, int, float, str), _place(chance, document, int, float, str)
    if one and other:
        one[0][one[1]], other[0][other[1]] = other[0][other[1]], one[0][one[1]]


_MILD = (_scale, _scale, _scale, _remove, _swap)
_CHANGES = (_replace, _replace, _scale, _remove, _repeat, _add, _add, _add_unknown, _swap)


def _setting(chance: random.Random, document: dict[str, Any]) -> str:
    path = [str(key) for _, key in _places(document)] or ["x"]
    begin = chance.choice(("study.", "machine.", "carrier.", "", "machine.drive.", "drum."))
    return begin + chance.choice(path) + chance.choice(_SETTINGS)


def _spoilt(chance: random.Random, text: bytes) -> bytes:
    """A text cut off, with bytes that are none, or in another encoding."""
    at = chance.randrange(len(text) + 1)
    return chance.choice((
        text[:at], text[:at] + bytes([chance.randrange(256)]) + text[at:], text + text,
        text.decode(errors="replace").encode("utf-16"), b"\xef\xbb\xbf" + text, text.replace(b"\n", b"\r\n"),
        text.replace(b"\n", b"\r"), b"", b"\x00" + text, text[:at] + b"[" * 3000,
    ))  # fmt: skip


def _toml(table: dict[str, Any]) -> Iterator[str]:
    """A document as TOML, its tables inline."""
    for key, value in table.items():
        if value is not None:
            yield f"{json.dumps(key)} = {_inline(value)}\n"


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_inline(v)}" for k, v in value.items() if v is not None) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_inline(v) for v in value if v is not None) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value).replace("e+", "e")
