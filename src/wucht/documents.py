"""Documents: TOML files read, values set by path, and models checked, with errors that say where.

Shared by machines and studies. A document is the nested dictionary of a TOML file.
"""

from __future__ import annotations

import math
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from wucht.errors import InputError, nearest
from wucht.quantities import article

Document = dict[str, Any]
ModelT = TypeVar("ModelT", bound=BaseModel)


def read_toml(path: Path) -> Document:
    """The document in a TOML file. Raises ``InputError`` for an unreadable file or one that is no TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(str(path), None, "there is no such file") from None
    except IsADirectoryError:
        raise InputError(str(path), None, "this is a folder; a study file is needed") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise InputError(str(path), None, f"the file cannot be read: {reason}") from None
    except ValueError as error:  # TOMLDecodeError among others, such as integers of thousands of digits
        raise InputError(str(path), None, f"the file is no valid TOML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise InputError(str(path), None, "the file is no valid TOML: it is nested too deeply") from None


def flatten(settings: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """``{"drive": {"slope": 1}}`` and ``{"drive.slope": 1}`` both become ``{"drive.slope": 1}``."""
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping) and value:
            flat |= flatten(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat


def no_nan(document: Any, where: str = "") -> None:
    """Raises ``InputError`` if a number anywhere in the document is NaN or infinite."""
    if isinstance(document, Mapping):
        for key, value in document.items():
            no_nan(value, f"{where}.{key}" if where else str(key))
    elif isinstance(document, list):
        for i, value in enumerate(document):
            no_nan(value, f"{where}[{i}]")
    elif isinstance(document, float) and not math.isfinite(document):
        raise InputError(where, document, "allowed is a finite number")


def table(document: Document, key: str, where: str) -> Document:
    """The sub-table ``key``. Raises ``InputError`` if it is missing or no table."""
    value = document.get(key)
    if value is None:
        raise InputError(where, None, f"the table [{where}] is missing")
    if not isinstance(value, dict):
        raise InputError(where, value, f"allowed is a table: [{where}]")
    return value


def refuse_unknown(document: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """Raises ``InputError`` for a key that is not known."""
    known = list(known)
    for key, value in document.items():
        if key not in known:
            raise InputError(f"{where}.{key}" if where else key, value, f"unknown key; {nearest(key, known)}")


def checked(cls: type[ModelT], document: Mapping[str, Any], where: str) -> ModelT:
    """Build a pydantic model. Raises ``InputError`` with the first thing that is wrong."""
    keys = [f.alias or name for name, f in cls.model_fields.items() if not f.exclude]
    refuse_unknown(document, keys, where)
    try:
        return cls.model_validate(dict(document))
    except ValidationError as error:
        raise _located(cls, error, where, document) from None


def text(document: Mapping[str, Any], key: str, where: str) -> str | None:
    """The text under a key, None if there is none. Raises ``InputError`` if it is something else or empty."""
    value = document.get(key)
    if value is not None and (not isinstance(value, str) or not value.strip()):
        raise InputError(f"{where}.{key}" if where else key, value, "allowed is a text")
    if value is not None and any(unicodedata.category(c) == "Cc" and c not in "\n\t" for c in value):
        raise InputError(f"{where}.{key}" if where else key, value, "allowed is a text without control characters")
    return value


def choice(document: Mapping[str, Any], key: str, where: str, known: Iterable[str], not_yet: Iterable[str] = ()) -> str:
    """The name under a key, one of those known. Raises ``InputError``: missing, misspelt, not yet there, or no name at all."""
    at, known = f"{where}.{key}", list(known)
    value = document.get(key)
    if value is None:
        for other in document:
            if get_close_matches(key, [other], cutoff=0.6):
                raise InputError(f"{where}.{other}", document[other], f"unknown key; did you mean {key!r}?")
        raise InputError(at, None, f"this key is missing; known: {', '.join(known)}")
    if isinstance(value, str) and value in known:
        return value
    if isinstance(value, str) and value in not_yet:
        raise InputError(at, value, f"not yet: this one comes with a later version; known: {', '.join(known)}")
    raise InputError(at, value, f"unknown {key}; {nearest(value if isinstance(value, str) else '', known)}")


def _located(cls: type[BaseModel], error: ValidationError, where: str, document: Mapping[str, Any]) -> InputError:
    first = error.errors(include_url=False)[0]
    inner, place = _inner(cls, first["loc"])
    if first["type"] == "missing" and len(first["loc"]) > len(place):  # an item of a pair
        first = {**first, "type": "too_short"}
    if place and isinstance(place[-1], int):  # an item of a list is told with its list
        inner, place = cls, place[:-1]
    if len(place) > 1 and inner is not cls:
        # The fault lies in a table inside: seen from there.
        inside: Any = document
        for step in place[:-1]:
            inside = inside[step]
        document = inside
        within = "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in place[:-1])
        cls, where = inner, f"{where}{within}"
    key = str(place[-1]) if place else ""
    at = f"{where}.{key}" if where and key else where or key
    fields = {f.alias or name: f for name, f in cls.model_fields.items()}
    extra = fields[key].json_schema_extra if key in fields else None
    unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
    what = (fields[key].description if key in fields else None) or key
    if first["type"] == "missing":
        return InputError(at, None, f"this key is missing; needed is the {what}" + (f" in {unit}" if unit else ""))
    given = document.get(key, first["input"]) if isinstance(document, Mapping) else first["input"]
    if first["type"] == "extra_forbidden":
        return InputError(at, given, f"unknown key; {nearest(key, fields)}")
    if unit and isinstance(given, list) and any(e["type"] in ("too_short", "too_long", "missing") for e in error.errors()):
        return InputError(at, given, "allowed is one number, or a pair [x, y]")
    return InputError(at, given, _allowed(first["type"], first.get("ctx", {}), what, unit, first["msg"]))


def _inner(cls: type[BaseModel], location: Iterable[int | str]) -> tuple[type[BaseModel], list[int | str]]:
    """The table in which a fault lies, and the way to its key from the outermost: names and numbers of tables inside."""
    place: list[int | str] = []
    for step in location:
        fields = {f.alias or name: f for name, f in cls.model_fields.items()}
        if place and isinstance(place[-1], str) and place[-1] in fields:
            models = _models(fields[place[-1]].annotation)
            if not models:
                break
            if isinstance(step, int):
                place.append(step)
                continue
            cls = models[0]
        elif place and isinstance(place[-1], int) and len(place) > 1:
            models = _models(fields[str(place[-2])].annotation)
            if not models:
                break
            cls = models[0]
        place.append(step)
    return cls, place


def _models(annotation: Any) -> list[type[BaseModel]]:
    """The models that a field's type names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [m for inner in get_args(annotation) for m in _models(inner)]


_LIMITS = {"gt": "greater than", "ge": "of at least", "le": "of at most", "lt": "less than"}


def _allowed(kind: str, context: Mapping[str, Any], what: str, unit: str, message: str) -> str:
    for key, words in _LIMITS.items():
        if key in context:
            return f"allowed is {article(what)} {words} {context[key]:g}" + (f" {unit}" if unit else "")
    at_least = f", at least {context['min_length']}" if "min_length" in context else ""
    several = f"a pair [x, y]: {article(what)} in {unit}" if unit else f"a list of {what}{at_least}"
    known = {
        "value_error": str(context.get("error", "")),
        "literal_error": f"allowed is {context.get('expected')}",
        "string_pattern_mismatch": "allowed is a name of up to 64 letters, digits, '-' and '_' that begins with a letter",
        "string_type": f"allowed is {article(what)}, a text",
        "model_type": "allowed is a table: { KEY = VALUE, ... }",
        "float_type": f"allowed is one number or quantity: {article(what)}" + (f" in {unit}" if unit else ""),
        **dict.fromkeys(("tuple_type", "too_short", "too_long"), f"allowed is {several}"),
    }
    if kind in known:
        return known[kind]
    return f"allowed is the {what}: {message[0].lower()}{message[1:]}"
