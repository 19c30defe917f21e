"""The keys of a table of a file, from the JSON schema of its class: unit, default, what is allowed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from wucht.checking import fields_of

_LIMITS = {
    "exclusiveMinimum": "> {}",
    "minimum": ">= {}",
    "exclusiveMaximum": "< {}",
    "maximum": "<= {}",
    "gt": "> {}",
    "ge": ">= {}",
    "lt": "< {}",
    "le": "<= {}",
    "minLength": None,
    "maxLength": None,
    "minItems": "at least {} items",
    "maxItems": "at most {} items",
    "pattern": None,
}
_PLAIN = {
    "number": "number", "integer": "whole number", "string": "text", "boolean": "`true`, `false`", "object": "table",
    "array": "list",
}  # fmt: skip


@dataclass(frozen=True)
class Row:
    """A key. default: None where it must be given; "" where it may be left out and then is not there."""

    key: str
    what: str
    unit: str
    default: str | None
    allowed: str
    tables: tuple[str, ...]


def rows_of(cls: type[BaseModel]) -> dict[str, list[Row]]:
    """The keys of a class, and after it those of the tables inside it, by the name of the table's class."""
    schema = cls.model_json_schema()
    definitions = schema.get("$defs", {})
    inside = {name: table for name, table in definitions.items() if "properties" in table}
    own = [row for row in _rows(schema, definitions) if row.key in fields_of(cls, given=True)]
    return {"": own} | {name: list(_rows(t, definitions)) for name, t in inside.items()}


def about(cls: type[BaseModel]) -> dict[str, str]:
    """What the tables inside a class are, by the names of their classes."""
    return {name: t.get("description", "") for name, t in cls.model_json_schema().get("$defs", {}).items()}


def _rows(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> Iterator[Row]:
    required = schema.get("required", ())
    for key, field in schema.get("properties", {}).items():
        default = None if key in required else _shown(field.get("default"))
        kinds = list(dict.fromkeys(_allowed(field, definitions, "unit" in field)))
        yield Row(key, _what(field), field.get("unit", ""), default, ", or ".join(kinds), tuple(_tables(field)))


def _what(field: Mapping[str, Any]) -> str:
    symbol, inner = field.get("symbol"), [f for f in field.get("anyOf", ()) if f.get("type") != "null"]
    said = field.get("description") or " or ".join(f["description"] for f in inner if "description" in f)
    return f"{said}{f' ({symbol})' if symbol else ''}"


def _shown(default: Any) -> str:
    return "" if default is None or default in ({}, []) else f"`{json.dumps(default)}`"


def _tables(field: Any) -> Iterator[str]:
    """The classes of tables inside."""
    if isinstance(field, Mapping):
        if "$ref" in field:
            yield field["$ref"].rpartition("/")[2]
        for key, inner in field.items():
            if key not in ("default", "description"):
                yield from _tables(inner)
    elif isinstance(field, list):
        for inner in field:
            yield from _tables(inner)


def _allowed(field: Mapping[str, Any], definitions: Mapping[str, Any], with_unit: bool) -> Iterator[str]:
    """What a key may be, in words; texts are not told where they are a number with its unit."""
    if "$ref" in field:
        name = field["$ref"].rpartition("/")[2]
        found = definitions.get(name, {})
        if "enum" in found:
            yield from _allowed(found, definitions, with_unit)
        else:
            yield f"table `{name}`"
    elif "anyOf" in field:
        kinds = [f for f in field["anyOf"] if f.get("type") != "null"]
        numbers = any(f.get("type") == "number" for f in kinds)
        for inner in kinds:
            if not (numbers and inner.get("type") == "string"):
                yield from _allowed(inner, definitions, with_unit)
    elif "enum" in field:
        yield ", ".join(f"`{json.dumps(value)}`" for value in field["enum"])
    elif "const" in field:
        yield f"`{json.dumps(field['const'])}`"
    elif field.get("type") == "array":
        yield _list(field, definitions, with_unit)
    else:
        limits = [text.format(f"{field[k]:g}") for k, text in _LIMITS.items() if text and k in field]
        yield " ".join(filter(None, [_PLAIN.get(field.get("type", ""), "see below"), " and ".join(limits)]))


def _list(field: Mapping[str, Any], definitions: Mapping[str, Any], with_unit: bool) -> str:
    if "prefixItems" in field:
        kinds = list(dict.fromkeys(k for f in field["prefixItems"] for k in _allowed(f, definitions, with_unit)))
        length = len(field["prefixItems"])
        return f"{'pair' if length == 2 else f'{length}'} of {_several(kinds)}"
    return f"list of {_several(_allowed(field.get('items', {}), definitions, with_unit))}"


def _several(kinds: Iterable[str]) -> str:
    """In the plural, where it is a word."""
    return ", or ".join(re.sub(r"^(number|table|list|pair|text)\b", r"\1s", kind) for kind in kinds)
