"""The keys of a table of a file, from its JSON schema: description, unit, default and limits of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from wucht.schema.checking import fields_of

Schema = Mapping[str, Any]  # or a part of one
_TYPES = {"boolean": "true or false", "integer": "whole number", "string": "text", "array": "list", "object": "table"}
_LIMITS = (
    (("exclusiveMinimum", "gt"), ">"), (("minimum", "ge"), ">="), (("exclusiveMaximum", "lt"), "<"), (("maximum", "le"), "<="),
)  # fmt: skip


@dataclass(frozen=True)
class Key:
    """One key. name: with the tables it is in, as ``motion.amplitude``; ``mounts[].at`` of each table of a list.

    unit: SI; None where it is not a quantity. needed: the key must be given; default: else, None where it may be omitted.
    allowed: limits in SI, or the known words. what: its description.
    """

    name: str
    type: str
    unit: str | None
    needed: bool
    default: Any
    allowed: str
    what: str


class _StatedTitles(GenerateJsonSchema):
    """Uses the titles of the fields, and makes none from their names."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def keys_of(cls: type[BaseModel]) -> tuple[Key, ...]:
    """The keys that may be given in a table, those of tables inside after them."""
    schema, settable_fields = cls.model_json_schema(schema_generator=_StatedTitles), fields_of(cls, settable_only=True)
    properties = {
        name: property_schema for name, property_schema in schema.get("properties", {}).items() if name in settable_fields
    }
    return tuple(_keys(schema | {"properties": properties}, schema.get("$defs", {}), "", ()))


def _keys(table: Schema, defs: Schema, path: str, outer_tables: tuple[str, ...]) -> Iterator[Key]:
    """Keys of a table and of those inside. outer_tables: the tables around this one, which may be recursive."""
    for name, property_schema in table.get("properties", {}).items():
        pairs = list(_forms(property_schema))
        forms, default = [property_schema, *(form for form, _ in pairs)], property_schema.get("default")
        yield Key(
            path + name, _type([form for form, _ in pairs]), next((f["unit"] for f in forms if "unit" in f), None),
            name in table.get("required", ()), None if default in ([], {}) else default, _allowed_values(forms),
            _description(forms),
        )  # fmt: skip
        for form, is_in_list in pairs:
            title = form.get("$ref", "").rpartition("/")[2]
            if title and title not in outer_tables:
                yield from _keys(defs[title], defs, f"{path}{name}{'[]' if is_in_list else ''}.", (*outer_tables, title))


def _forms(property_schema: Schema) -> Iterator[tuple[Schema, bool]]:
    """The ways in which a value may be given, without null; and True for a table in a list."""
    if several := property_schema.get("anyOf") or property_schema.get("oneOf") or property_schema.get("allOf"):
        for form in several:
            yield from _forms(form)
    elif property_schema.get("type") == "array" and "$ref" in property_schema.get("items", {}):
        yield property_schema["items"], True
    elif property_schema.get("type") != "null":
        yield property_schema, False


def _type(forms: Sequence[Schema]) -> str:
    """Type as text, such as ``number or pair``."""
    words: dict[str, None] = {}
    numeric = any(form.get("type") == "number" for form in forms)
    for form in forms:
        if numeric and form.get("type") == "string" and "enum" not in form and "const" not in form:
            continue  # the number with its unit
        if "$ref" in form:
            words["table"] = None
        elif form.get("type") == "array" and form.get("maxItems") == form.get("minItems") == 2:
            words["pair"] = None
        elif "enum" in form or "const" in form:
            words["word"] = None
        else:
            words[_TYPES.get(form.get("type", ""), "number" if form.get("type") == "number" else "value")] = None
    return " or ".join(words)


def _allowed_values(forms: Sequence[Schema]) -> str:
    """Limits, or the known words."""
    words = [str(w) for form in forms for w in (*form.get("enum", ()), *([form["const"]] if "const" in form else []))]
    if words:
        return ", ".join(dict.fromkeys(words))
    limits = {sign: form[name] for names, sign in _LIMITS for name in names for form in forms if name in form}
    return ", ".join(f"{sign} {limit:g}" for sign, limit in limits.items())


def _description(forms: Sequence[Schema]) -> str:
    """Description, empty where the schema has none: the help, or else the title."""
    return next((str(form[text]) for text in ("description", "title") for form in forms if text in form), "")
