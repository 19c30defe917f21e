"""The signature of a table in Python and the section of its docstring on its parameters, both from its fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from inspect import Parameter, Signature, cleandoc
from keyword import iskeyword
from textwrap import fill
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from wucht.schema.checking import fields_of, unit_of

_WIDTH = 100  # of a docstring
_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
_SECTION = re.compile(r"^[A-Z]\w+\n-{3,}$", re.MULTILINE)


class _Text(str):
    """A type as text; a signature shows it without quotes."""

    __slots__ = ()
    __repr__ = str.__str__


def parameter_names(cls: type[BaseModel]) -> dict[str, str]:
    """The keys of the fields that may be given, in order, by their names in Python.

    A key that is a word of Python, such as ``lambda``, has the name of its attribute.
    """
    settable = ((name, field) for name, field in cls.model_fields.items() if not field.exclude)
    keys = ((name, field.alias or name) for name, field in settable)
    return {name if iskeyword(key) else key: key for name, key in keys}


def signature_of(cls: type[BaseModel]) -> Signature:
    """The fields that may be given, in order, with their defaults.

    A field without a default after one with a default can only be given by name, and so all after it.
    """
    parameters: list[Parameter] = []
    by_name = has_defaults = False
    for name, field in zip(parameter_names(cls), fields_of(cls, settable_only=True).values(), strict=True):
        by_name = by_name or (has_defaults and field.is_required())
        has_defaults = has_defaults or not field.is_required()
        kind = Parameter.KEYWORD_ONLY if by_name else Parameter.POSITIONAL_OR_KEYWORD
        default = Parameter.empty if field.is_required() else _default(field)
        parameters.append(Parameter(name, kind, default=default, annotation=_type_of(field)))
    return Signature(parameters)


def prose_of(cls: type) -> str:
    """The docstring of a class as it is written, without the section on its parameters; empty where there is none."""
    return cleandoc(vars(cls).get("__doc__") or "")


def docstring_of(cls: type[BaseModel]) -> str | None:
    """The docstring of a table with a section ``Parameters``, before its other sections."""
    prose, parameters = prose_of(cls), "\n".join(_entries(cls))
    if not parameters:
        return prose or None
    other_sections = _SECTION.search(prose)
    at = other_sections.start() if other_sections else len(prose)
    parts = (prose[:at].rstrip(), f"Parameters\n----------\n{parameters}", prose[at:])
    return "\n\n".join(part for part in parts if part) + "\n"


def _entries(cls: type[BaseModel]) -> Iterator[str]:
    """Each field in NumPy's form: ``name : type, default`` and its help, unit and limits."""
    for name, field in zip(parameter_names(cls), fields_of(cls, settable_only=True).values(), strict=True):
        default = None if field.is_required() else _default(field)
        suffix = "" if field.is_required() else ", optional" if default in (None, (), {}) else f", default {default!r}"
        yield f"{name} : {_type_of(field)}{suffix}"
        unit = unit_of(field)
        limits = (f"{_SIGNS[k]} {getattr(m, k):g}" for m in _limits(field) for k in _SIGNS if getattr(m, k, None) is not None)
        notes = ", ".join(filter(None, (unit.si if unit else "", *limits)))
        help_text = f"{_description(field)}{f' [{notes}]' if notes else ''}".strip()
        if help_text:
            yield fill(help_text, _WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)


def _default(field: FieldInfo) -> Any:
    return field.default_factory() if field.default_factory else field.default  # type: ignore[call-arg]


def _annotations(annotation: Any) -> Iterator[Any]:
    """What is annotated to a type, and to those that it is a union of."""
    if get_origin(annotation) is Annotated:
        inner, *notes = get_args(annotation)
        yield from notes
        yield from _annotations(inner)
    elif get_origin(annotation) in (Union, UnionType):
        for one in get_args(annotation):
            yield from _annotations(one)


def _limits(field: FieldInfo) -> list[Any]:
    """Annotations with limits; those of a common type are in its field."""
    notes = (*field.metadata, *_annotations(field.annotation))
    return [limit for note in notes for limit in (note.metadata if isinstance(note, FieldInfo) else [note])]


def _description(field: FieldInfo) -> str:
    """The help of a field, or of its type, as there are types that several studies share."""
    texts = (field, *(note for note in _annotations(field.annotation) if isinstance(note, FieldInfo)))
    return next((text for one in texts for text in (one.description, one.title) if text), "")


def _type_of(field: FieldInfo) -> _Text:
    """The type of a field; a quantity may also be a text with a unit."""
    members = list(dict.fromkeys(_members(field.annotation)))
    if unit_of(field) is not None and "float" in members and "str" not in members:
        members.insert(members.index("float") + 1, "str")
    return _Text(" | ".join(sorted(members, key=lambda member: member == "None")))


def _members(annotation: Any) -> Iterator[str]:
    """The types of a union, or the one type, as short texts."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin in (Union, UnionType):
        for one in arguments:
            yield from _members(one)
    elif origin is Annotated:
        yield from _members(arguments[0])
    elif origin is Literal:
        yield f"Literal[{', '.join(map(repr, arguments))}]"
    elif origin is not None:
        items = ("..." if one is Ellipsis else " | ".join(_members(one)) for one in arguments)
        yield f"{origin.__name__}[{', '.join(items)}]"
    else:
        yield "None" if annotation is NoneType else getattr(annotation, "__name__", str(annotation))
