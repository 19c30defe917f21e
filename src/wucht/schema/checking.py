"""Tables and models checked key by key, with located errors: the tables of a file, and the parts built from them."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeGuard, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from wucht.errors import InputError, code_of, nearest
from wucht.schema.units import Unit, article

ModelT = TypeVar("ModelT", bound=BaseModel)


def table(document: dict[str, Any], key: str, where: str) -> dict[str, Any]:
    """The sub-table ``key``. Raises ``InputError`` if it is missing or not a table."""
    value = document.get(key)
    if value is None:
        raise InputError(where, None, f"the table [{where}] is missing", code="missing")
    if not isinstance(value, dict):
        raise InputError(where, value, f"must be a table: [{where}]", code="type")
    return value


def refuse_unknown(document: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """Raises ``InputError`` for a key that is not known."""
    known = list(known)
    for key, value in document.items():
        if key not in known:
            at = f"{where}.{key}" if where else key
            raise InputError(at, value, f"unknown key; {nearest(key, known)}", code="unknown-key")


def fields_of(cls: type[BaseModel], given: bool = False) -> dict[str, FieldInfo]:
    """The fields of a model by key; ``settable_only``: only those that may be given."""
    return {f.alias or name: f for name, f in cls.model_fields.items() if not (given and f.exclude)}


def unit_of(field: FieldInfo | None) -> Unit | None:
    """The unit of a field made by ``si``; None for other fields, and where there is none."""
    extra = field.json_schema_extra if field else None
    if field is None or not isinstance(extra, dict) or "unit" not in extra:
        return None
    return Unit(str(extra["unit"]), field.title or "", str(extra["symbol"]))


def checked(cls: type[ModelT], document: Mapping[str, Any], where: str) -> ModelT:
    """Build a pydantic model. Raises ``InputError`` for the first fault."""
    refuse_unknown(document, fields_of(cls, given=True), where)
    try:
        return cls.model_validate(dict(document))
    except ValidationError as error:
        raise located(cls, error, where, document) from None


def read_quantity(unit: Unit, given: object, where: str) -> float:
    """A number in SI, or a text with a unit, as a number in SI. Raises ``InputError``."""
    try:
        return unit.parse(given)
    except ValueError as error:
        raise InputError(where, given, str(error), code=code_of(error)) from None


def text(document: Mapping[str, Any], key: str, where: str) -> str | None:
    """The text under a key, None if there is none. Raises ``InputError`` if it is something else or empty."""
    value, at = document.get(key), f"{where}.{key}" if where else key
    if value is not None and (not isinstance(value, str) or not value.strip()):
        raise InputError(at, value, "must be a text", code="type")
    if value is not None and any(unicodedata.category(c) == "Cc" and c not in "\n\t" for c in value):
        raise InputError(at, value, "must be a text without control characters", code="control-characters")
    return value


def is_pairs(given: object) -> TypeGuard[Sequence[Sequence[Any]]]:
    """True if the value is a list of pairs."""
    return isinstance(given, list | tuple) and all(isinstance(p, list | tuple) and len(p) == 2 for p in given)


def choice(document: Mapping[str, Any], key: str, where: str, known: Iterable[str]) -> str:
    """The name under a key, one of those known. Raises ``InputError``: missing, misspelt, or not a name."""
    at, known = f"{where}.{key}", list(known)
    value = document.get(key)
    if value is None:
        for other in document:
            if get_close_matches(key, [other], cutoff=0.6):
                raise InputError(f"{where}.{other}", document[other], f"unknown key; did you mean {key!r}?", code="unknown-key")
        raise InputError(at, None, f"this key is missing; known: {', '.join(known)}", code="missing")
    if isinstance(value, str) and value in known:
        return value
    allowed = nearest(value if isinstance(value, str) else "", known)
    raise InputError(at, value, f"unknown {key}; {allowed}", code="unknown-name")


def located(cls: type[BaseModel], error: ValidationError, where: str, document: Mapping[str, Any]) -> InputError:
    """The first fault of a document as an error: which key, the given value, what is allowed.

    A ``ValueError(key, sentence)`` raised by the model is a fault of that key.
    """
    first = error.errors(include_url=False)[0]
    kind, context, location, given = first["type"], first.get("ctx", {}), first["loc"], first["input"]
    own = context.get("error")
    if isinstance(own, ValueError) and len(own.args) == 2:
        location, given, context = (*location, own.args[0]), None, {"error": own.args[1]}
    inner, place = _inner(cls, location)
    if kind == "missing" and len(location) > len(place):  # an item of a pair
        kind = "too_short"
    if place and isinstance(place[-1], int):  # an item of a list is reported with its list
        inner, place = cls, place[:-1]
    if len(place) > 1 and inner is not cls:  # the fault is in a table inside: located from there
        inside: Any = document
        for step in place[:-1]:
            inside = inside[step]
        cls, document = inner, inside
        where += "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in place[:-1])
    key = str(place[-1]) if place else ""
    at = f"{where}.{key}" if where and key else where or key
    fields = fields_of(cls)
    field = fields.get(key, FieldInfo())
    quantity = unit_of(field)
    unit = quantity.si if quantity else ""
    what, in_unit = field.title or field.description or key, f" in {unit}" if unit else ""
    if kind == "missing":
        return InputError(at, None, f"this key is missing; needed is the {what}{in_unit}", code=kind)
    given = document.get(key, given) if isinstance(document, Mapping) else given
    if kind == "extra_forbidden":
        return InputError(at, given, f"unknown key; {nearest(key, fields)}", code="unknown-key")
    if unit and isinstance(given, list) and any(e["type"] in ("too_short", "too_long", "missing") for e in error.errors()):
        return InputError(at, given, "must be one number, or a pair [x, y]", code="pair")
    bounds = {side: getattr(m, side) for side in ("ge", "le") for m in field.metadata if hasattr(m, side)}
    if kind in ("greater_than_equal", "less_than_equal") and len(bounds) == 2:
        between = "a whole number from {ge:g} to {le:g}" if field.annotation is int else "between {ge:g} and {le:g}"
        suffix = f" {unit}" if unit and field.annotation is not int else ""
        return InputError(at, given, f"must be {between.format(**bounds)}{suffix}", code="limits")
    code = code_of(own) if isinstance(own, ValueError) else _CODES.get(kind, "type")
    return InputError(at, given, _allowed(kind, context, what, unit, first["msg"]), code=code)


def _inner(cls: type[BaseModel], location: Iterable[int | str]) -> tuple[type[BaseModel], list[int | str]]:
    """The table with the fault, and the path to its key from the outermost: names and numbers of tables inside."""
    inner: type[BaseModel] | None = cls
    place: list[int | str] = []
    for step in location:
        if inner is None:
            break
        place.append(step)
        if isinstance(step, str):
            cls, field = inner, fields_of(inner).get(step)
            inner = next(iter(models_in(field.annotation)), None) if field else None
    return cls, place


def models_in(annotation: Any) -> list[type[BaseModel]]:
    """The models that a field's type names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [m for inner in get_args(annotation) for m in models_in(inner)]


_CODES = {
    **dict.fromkeys(("greater_than", "greater_than_equal", "less_than", "less_than_equal"), "limits"),
    **dict.fromkeys(("too_short", "too_long", "string_too_short", "string_too_long"), "length"),
    "literal_error": "unknown-name",
    "string_pattern_mismatch": "no-name",
}
_LIMITS = {"gt": "greater than", "ge": "of at least", "le": "of at most", "lt": "less than"}


def _allowed(kind: str, context: Mapping[str, Any], what: str, unit: str, message: str) -> str:
    in_unit = f" in {unit}" if unit else ""
    for key, words in _LIMITS.items():
        if key in context:
            return f"must be {article(what)} {words} {context[key]:g}" + (f" {unit}" if unit else "")
    at_least = f", at least {context['min_length']}" if "min_length" in context else ""
    several = f"a pair [x, y]: {article(what)} in {unit}" if unit else f"a list of {what}{at_least}"
    known = {
        "value_error": str(context.get("error", "")),
        "literal_error": f"must be {context.get('expected')}",
        "string_pattern_mismatch": "must be a name of up to 64 letters, digits, '-' and '_' that begins with a letter",
        "string_type": f"must be {article(what)}, a text",
        "model_type": "must be a table: { KEY = VALUE, ... }",
        "float_type": f"must be one number or quantity: {article(what)}{in_unit}",
        **dict.fromkeys(("tuple_type", "too_short", "too_long"), f"must be {several}"),
    }
    return known.get(kind, f"must be the {what}: {message[:1].lower()}{message[1:]}")
