"""Tables with physical quantities: fields that are read with their units and checked when built, whatever builds them.

Parts of machines and specs of studies are such tables. Built from a file or in Python, they give the same error sentences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationInfo, field_validator
from pydantic_core import CoreSchema

from wucht.schema.checking import checked, fields_of, unit_of


def si(
    unit: str, what: str, symbol: str = "", default: Any = ..., alias: str | None = None, help: str = "", **limits: Any
) -> Any:
    """A field that holds a physical quantity: its SI unit, long name, symbol in equations and limits (gt, ge).

    help: an explanation where the name alone is not enough. As of every field, the name is its title and the help its
    description; a field with a description alone uses that for both.
    """
    return Field(
        default, alias=alias, title=what, description=help or what, json_schema_extra={"unit": unit, "symbol": symbol}, **limits
    )


@dataclass(frozen=True)
class Parameter:
    """A number of a machine: its path, value, unit, symbol in equations and long name."""

    path: str
    value: float
    unit: str
    symbol: str
    what: str

    @property
    def words(self) -> str:
        """Long name with the owner, see the function ``full_name``."""
        return in_words(self.path, self.what)

    @property
    def called(self) -> str:
        """Name in a sentence: the full name, or the path itself where it is a single symbol."""
        return self.words if "." in self.path else self.path

    def at(self, value: float, digits: int = 6) -> str:
        """A value of the parameter in a sentence: ``no-load speed of the drive = 143.7 rad/s``."""
        return f"{self.called} = {value:.{digits}g} {self.unit}".rstrip()


def in_words(path: str, what: str) -> str:
    """Long name with the owner: ``no-load speed of the drive`` for ``drive.no_load_speed``; a bare name has no owner."""
    *owners, name = path.split(".")
    along = ""
    if owners and name in _AXES:
        along, (*owners, name) = f" in {name}", owners
    whose = _whose(owners)
    if not whose or name == "gravity" or f" {whose.removeprefix('the ')} " in f" {what} ":
        return what + along
    long = any(f" {word} " in what for word in _LONG)
    return f"{what}{along}, {whose.removeprefix('the ')}" if long else f"{what}{along} of {whose}"


_AXES = ("x", "y")
_LONG = ("of", "at", "to")  # words after which another ``of`` would belong to something else
_PARTS = ("carrier", "drive", "load", "foundation")  # of which a machine has one


def _whose(owners: list[str]) -> str:
    """The part to which a parameter belongs, as text: ``drives.e1`` is the drive of e1."""
    match owners:
        case ["tracks" | "mounts" as parts, of] | ["carrier", "mounts" as parts, of]:
            return f"{parts.removesuffix('s')} {of}"
        case ["carrier", "motion"]:
            return "the motion of the carrier"
        case [*_, part] if part in _PARTS:
            return f"the {part}"
        case [parts, of] if parts.removesuffix("s") in _PARTS:
            return f"the {parts.removesuffix('s')} of {of}"
        case _:
            return " ".join(owners)


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _Metaclass
else:
    _Metaclass = type(BaseModel)


class _Located(_Metaclass):
    """Classes whose call raises ``InputError`` instead of pydantic's error."""

    def __call__(self: Any, *values: Any, **fields: Any) -> Any:
        return checked(self, dict(zip(fields_of(self, given=True), values, strict=False)) | fields, self.where())


class Described(BaseModel, metaclass=_Located):
    """A table of a file, or the same built in Python: its quantities are numbers in SI, or strings with a unit.

    Raises ``InputError`` for invalid values. Its JSON schema admits strings with a unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    kind: ClassVar[str] = ""

    @classmethod
    def where(cls) -> str:
        """Location of a fault in Python code."""
        return cls.kind or cls.__name__

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, given: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        unit = unit_of(field)
        if unit is None or given is None:
            return given
        positive = any(getattr(limit, "gt", None) == 0 for limit in field.metadata)
        read = unit.positive if positive else unit.parse
        return [read(g) for g in given] if isinstance(given, list | tuple) else read(given)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        described = handler.resolve_ref_schema(handler(schema))
        properties = described.get("properties", {})
        properties |= {name: _admitting_text(field) for name, field in properties.items() if "unit" in field}
        return described

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """The given quantities as parameters ``path.field``, or ``field`` without a path.

        Pairs by component ``.x``, ``.y``; tables inside likewise.
        """
        parameters: list[Parameter] = []
        for name, described in type(self).model_fields.items():
            unit, value = unit_of(described), getattr(self, name)
            key = f"{path}.{described.alias or name}".removeprefix(".")
            if isinstance(value, Described):
                parameters += value.parameters_at(key)
            elif unit is None:
                for i, table in enumerate(value if isinstance(value, tuple) else (), 1):
                    parameters += table.parameters_at(f"{key}.{i}") if isinstance(table, Described) else ()
            elif isinstance(value, tuple):
                for c, x in zip("xy", value, strict=True):
                    parameters.append(Parameter(f"{key}.{c}", float(x), unit.si, f"{unit.symbol}_{c}", unit.what))
            elif value is not None:
                parameters.append(Parameter(key, float(value), unit.si, unit.symbol, unit.what))
        return tuple(parameters)


def _admitting_text(schema: Any) -> Any:
    """A JSON schema in which each number may also be a string with a unit."""
    if isinstance(schema, Mapping):
        if schema.get("type") == "number":
            number = {k: v for k, v in schema.items() if k in _OF_A_NUMBER}
            rest = {k: v for k, v in schema.items() if k not in _OF_A_NUMBER}
            return rest | {"anyOf": [number, {"type": "string", "description": "a number with its unit, as '2.5 kg'"}]}
        return {k: v if k == "default" else _admitting_text(v) for k, v in schema.items()}
    return [_admitting_text(s) for s in schema] if isinstance(schema, list) else schema


_OF_A_NUMBER = ("type", "exclusiveMinimum", "exclusiveMaximum", "minimum", "maximum")
