"""Tables and models checked key by key, with located errors: the tables of a file, and the parts built from them."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeGuard, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from wucht.errors import InputError, code_of, nearest
from wucht.schema.python_values import python_value
from wucht.schema.units import Unit, article

ModelT = TypeVar("ModelT", bound=BaseModel)
LONGEST_TEXT = 10_000  # characters of a title, a note or a name: they are printed, and drawn


def require_table(document: dict[str, Any], key: str, location: str) -> dict[str, Any]:
    """The sub-table ``key``. Raises ``InputError`` if it is missing or not a table."""
    value = document.get(key)
    if value is None:
        raise InputError(location, None, f"the table [{location}] is missing", code="missing")
    if not isinstance(value, dict):
        raise InputError(location, value, f"must be a table: [{location}]", code="type")
    return value


def refuse_unknown(document: Mapping[str, Any], known_keys: Iterable[str], location: str) -> None:
    """Raises ``InputError`` for a key that is not known."""
    known_keys = list(known_keys)
    for key, value in document.items():
        if key not in known_keys:
            at = f"{location}.{key}" if location else key
            raise InputError(at, value, f"unknown key; {nearest(key, known_keys)}", code="unknown-key")


def fields_of(cls: type[BaseModel], settable_only: bool = False) -> dict[str, FieldInfo]:
    """The fields of a model by key; ``settable_only``: only those that may be given."""
    return {f.alias or name: f for name, f in cls.model_fields.items() if not (settable_only and f.exclude)}


def unit_of(field: FieldInfo | None) -> Unit | None:
    """The unit of a field made by ``si``; None for other fields, and where there is none."""
    extra = field.json_schema_extra if field else None
    if field is None or not isinstance(extra, dict) or "unit" not in extra:
        return None
    return Unit(str(extra["unit"]), field.title or "", str(extra["symbol"]))


def validate_table(cls: type[ModelT], document: Mapping[str, Any], location: str) -> ModelT:
    """Build the instance of a class that a table describes. Raises ``InputError`` for the first fault."""
    document = python_value(document)
    refuse_unknown(document, fields_of(cls, settable_only=True), location)
    try:
        return cls.model_validate(dict(document))
    except ValidationError as error:
        raise locate_error(cls, error, location, document) from None


def read_quantity(unit: Unit, value: object, location: str) -> float:
    """A number in SI, or a text with a unit, as a number in SI. Raises ``InputError``."""
    try:
        return unit.parse_quantity(value)
    except ValueError as error:
        raise InputError(location, value, str(error), code=code_of(error)) from None


def text(document: Mapping[str, Any], key: str, location: str) -> str | None:
    """The text under a key, None if there is none. Raises ``InputError`` if it is something else or empty."""
    value, at = document.get(key), f"{location}.{key}" if location else key
    if value is not None and (not isinstance(value, str) or not value.strip()):
        raise InputError(at, value, "must be a text", code="type")
    if value is not None and len(value) > LONGEST_TEXT:
        raise InputError(
            at, value, f"must be a text of at most {LONGEST_TEXT} characters; it has {len(value)}", code="too-long"
        )
    if value is not None and any(unicodedata.category(c) == "Cc" and c not in "\n\t" for c in value):
        raise InputError(at, value, "must be a text without control characters", code="control-characters")
    return value


def is_pairs(value: object) -> TypeGuard[Sequence[Sequence[Any]]]:
    """True if the value is a list of pairs."""
    return isinstance(value, list | tuple) and all(isinstance(p, list | tuple) and len(p) == 2 for p in value)


def choice(document: Mapping[str, Any], key: str, location: str, known_names: Iterable[str]) -> str:
    """The name under a key, one of those known. Raises ``InputError``: missing, misspelt, or not a name."""
    at, known_names = f"{location}.{key}", list(known_names)
    value = document.get(key)
    if value is None:
        for similar_key in document:
            if get_close_matches(key, [similar_key], cutoff=0.6):
                raise InputError(
                    f"{location}.{similar_key}",
                    document[similar_key],
                    f"unknown key; did you mean {key!r}?",
                    code="unknown-key",
                )
        raise InputError(at, None, f"this key is missing; known: {', '.join(known_names)}", code="missing")
    if isinstance(value, str) and value in known_names:
        return value
    hint = nearest(value if isinstance(value, str) else "", known_names)
    raise InputError(at, value, f"unknown {key}; {hint}", code="unknown-name")


def locate_error(cls: type[BaseModel], error: ValidationError, table_location: str, document: Mapping[str, Any]) -> InputError:
    """The first fault of a document as an error: which key, the given value, what is allowed.

    A ``ValueError(key, sentence)`` raised by the model is a fault of that key.
    """
    first = error.errors(include_url=False)[0]
    kind, context, location, value = first["type"], first.get("ctx", {}), first["loc"], first["input"]
    model_error = context.get("error")
    if isinstance(model_error, ValueError) and len(model_error.args) == 2:
        location, value, context = (*location, model_error.args[0]), None, {"error": model_error.args[1]}
    inner, place = _inner(cls, location)
    if kind == "missing" and place and location[-1] != place[-1]:  # an item of a pair
        kind = "too_short"
    if place and isinstance(place[-1], int):  # an item of a list is reported with its list
        inner, place = cls, place[:-1]
    if len(place) > 1 and inner is not cls:  # the fault is in a table inside: located from there
        inside: Any = document
        for step in place[:-1]:
            inside = inside[step]
        cls, document = inner, inside
        table_location += "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in place[:-1])
    key = str(place[-1]) if place else ""
    at = f"{table_location}.{key}" if table_location and key else table_location or key
    fields = fields_of(cls)
    field = fields.get(key, FieldInfo())
    quantity = unit_of(field)
    unit = quantity.si if quantity else ""
    long_name, in_unit = field.title or field.description or key, f" in {unit}" if unit else ""
    if kind == "missing":
        return InputError(at, None, f"this key is missing; give the {long_name}{in_unit}", code=kind)
    value = document.get(key, value) if isinstance(document, Mapping) else value
    if kind == "extra_forbidden":
        return InputError(at, value, f"unknown key; {nearest(key, fields)}", code="unknown-key")
    if (
        unit
        and isinstance(value, list | tuple)
        and any(e["type"] in ("too_short", "too_long", "missing") for e in error.errors())
    ):
        return InputError(at, value, "must be one number, or a pair [x, y]", code="pair")
    bounds = {side: getattr(m, side) for side in ("ge", "le") for m in field.metadata if hasattr(m, side)}
    if kind in ("greater_than_equal", "less_than_equal") and len(bounds) == 2:
        between = "a whole number from {ge:g} to {le:g}" if field.annotation is int else "between {ge:g} and {le:g}"
        suffix = f" {unit}" if unit and field.annotation is not int else ""
        return InputError(at, value, f"must be {between.format(**bounds)}{suffix}", code="limits")
    code = code_of(model_error) if isinstance(model_error, ValueError) else _CODES.get(kind, "type")
    return InputError(at, value, _requirement(kind, context, long_name, unit, first["msg"]), code=code)


def _inner(cls: type[BaseModel], location: Iterable[int | str]) -> tuple[type[BaseModel], list[int | str]]:
    """The table with the fault, and the path to its key from the outermost: names and numbers of tables inside."""
    inner: type[BaseModel] | None = cls
    place: list[int | str] = []
    forms: dict[str, type[BaseModel]] = {}  # of a key that may be one table or another, by the tag of each
    for step in location:
        if isinstance(step, str) and step in forms:
            inner, forms = forms[step], {}
            continue
        if inner is None:
            break
        place.append(step)
        if isinstance(step, str):
            cls, field = inner, fields_of(inner).get(step)
            models = models_in(field.annotation) if field else []
            inner, forms = next(iter(models), None), {m.__name__: m for m in models[1:] and models}
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


def _requirement(kind: str, context: Mapping[str, Any], long_name: str, unit: str, message: str) -> str:
    in_unit = f" in {unit}" if unit else ""
    for key, words in _LIMITS.items():
        if key in context:
            return f"must be {article(long_name)} {words} {context[key]:g}" + (f" {unit}" if unit else "")
    at_least = f", at least {context['min_length']}" if "min_length" in context else ""
    several = f"a pair [x, y]: {article(long_name)} in {unit}" if unit else f"a list of {long_name}{at_least}"
    requirements = {
        "value_error": str(context.get("error", "")),
        "literal_error": f"must be {context.get('expected')}",
        "string_pattern_mismatch": "must be a name of up to 64 letters, digits, '-' and '_' that begins with a letter",
        "string_type": f"must be {article(long_name)}, a text",
        "model_type": "must be a table: { KEY = VALUE, ... }",
        "float_type": f"must be one number or quantity: {article(long_name)}{in_unit}",
        **dict.fromkeys(("tuple_type", "too_short", "too_long"), f"must be {several}"),
    }
    return requirements.get(kind, f"must be the {long_name}: {message[:1].lower()}{message[1:]}")
