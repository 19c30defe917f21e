"""Tables and models checked key by key, with errors that say where: the tables of a file, and the parts built from them."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from wucht.errors import InputError, nearest
from wucht.quantities import Unit, article

ModelT = TypeVar("ModelT", bound=BaseModel)


def table(document: dict[str, Any], key: str, where: str) -> dict[str, Any]:
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
        raise located(cls, error, where, document) from None


def read_quantity(unit: Unit, given: object, where: str) -> float:
    """A number in SI, or a text with a unit, as a number in SI. Raises ``InputError``."""
    try:
        return unit.parse(given)
    except ValueError as error:
        raise InputError(where, given, str(error)) from None


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


def located(cls: type[BaseModel], error: ValidationError, where: str, document: Mapping[str, Any]) -> InputError:
    """The first thing that is wrong with a document, in words: which key, what was given, what is allowed.

    A ``ValueError(key, sentence)`` of the model's own is a fault of that key.
    """
    first = error.errors(include_url=False)[0]
    told = first.get("ctx", {}).get("error")
    if isinstance(told, ValueError) and len(told.args) == 2:
        key, sentence = told.args
        first = {**first, "loc": (*first["loc"], key), "input": None, "ctx": {"error": sentence}}
    inner, place = _inner(cls, first["loc"])
    if first["type"] == "missing" and len(first["loc"]) > len(place):  # an item of a pair
        first = {**first, "type": "too_short"}
    if place and isinstance(place[-1], int):  # an item of a list is reported with its list
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
    low, high = (_bound(fields.get(key), side) for side in ("ge", "le"))
    if first["type"] in ("greater_than_equal", "less_than_equal") and low is not None and high is not None:
        if fields[key].annotation is int:
            return InputError(at, given, f"allowed is a whole number from {low:g} to {high:g}")
        return InputError(at, given, f"allowed is between {low:g} and {high:g}" + (f" {unit}" if unit else ""))
    if first["type"] == "extra_forbidden":
        return InputError(at, given, f"unknown key; {nearest(key, fields)}")
    if unit and isinstance(given, list) and any(e["type"] in ("too_short", "too_long", "missing") for e in error.errors()):
        return InputError(at, given, "allowed is one number, or a pair [x, y]")
    return InputError(at, given, _allowed(first["type"], first.get("ctx", {}), what, unit, first["msg"]))


def _bound(field: FieldInfo | None, side: str) -> float | None:
    """The limit of a field on one side, ``"ge"`` or ``"le"``."""
    bounds = [getattr(m, side) for m in (field.metadata if field is not None else ()) if hasattr(m, side)]
    return bounds[0] if bounds else None


def _inner(cls: type[BaseModel], location: Iterable[int | str]) -> tuple[type[BaseModel], list[int | str]]:
    """The table in which a fault lies, and the way to its key from the outermost: names and numbers of tables inside."""
    place: list[int | str] = []
    for step in location:
        fields = {f.alias or name: f for name, f in cls.model_fields.items()}
        if place and isinstance(place[-1], str) and place[-1] in fields:
            models = models_in(fields[place[-1]].annotation)
            if not models:
                break
            if isinstance(step, int):
                place.append(step)
                continue
            cls = models[0]
        elif place and isinstance(place[-1], int) and len(place) > 1:
            models = models_in(fields[str(place[-2])].annotation)
            if not models:
                break
            cls = models[0]
        place.append(step)
    return cls, place


def models_in(annotation: Any) -> list[type[BaseModel]]:
    """The models that a field's type names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [m for inner in get_args(annotation) for m in models_in(inner)]


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
