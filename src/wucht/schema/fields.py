"""Tables with physical quantities: fields that are read with their units and checked when built, whatever builds them.

Parts of machines and specs of studies are such tables. Built from a file or in Python, they give the same error sentences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, dataclass_transform

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationInfo, field_validator
from pydantic_core import CoreSchema

from wucht.errors import InputError
from wucht.schema.checking import unit_of, validate_table
from wucht.schema.signature import docstring_of, parameter_names, prose_of, signature_of

T = TypeVar("T")
RawT = TypeVar("RawT")

if TYPE_CHECKING:
    import numpy as np

    class Conversion(Generic[T, RawT]):
        """A descriptor: type checkers take what it can be set to as the type of the parameter."""

        def __get__(self, table: Any, owner: Any) -> T: ...
        def __set__(self, table: Any, value: T | RawT) -> None: ...

    SI = Conversion[T, str | Sequence[float | str] | np.ndarray]
    Composite = Conversion[T, Sequence[Any] | Mapping[str, Any] | np.ndarray]
else:

    class Conversion:
        """Type of a field that is a T in its table, and may also be given as a RawT: ``Conversion[T, RawT]`` is T."""

        def __class_getitem__(cls, types: tuple[Any, Any]) -> Any:
            return types[0]

    class SI:
        """Type of a quantity made by ``si``, which may also be given as a text with a unit: ``SI[float]`` is ``float``."""

        def __class_getitem__(cls, number: Any) -> Any:
            return number

    class Composite(SI):
        """Type of tuples and tables made by ``composite``, which may also be given as lists and tables of a file."""


def composite(**settings: Any) -> Any:
    """A field of the type ``Composite``, with the settings of pydantic's ``Field``: its default may be of another type."""
    return Field(**settings)


def si(
    unit: str, long_name: str, symbol: str = "", default: Any = ..., alias: str | None = None, help: str = "", **limits: Any
) -> Any:
    """A field that holds a physical quantity: its SI unit, long name, symbol in equations and limits (gt, ge).

    help: an explanation where the name alone is not enough. As of every field, the name is its title and the help its
    description; a field with a description alone uses that for both. Type checkers accept a text with a unit where the
    field is annotated by ``SI``, as ``SI[float]``, and a field that is not given where its ``default`` is given by name.
    """
    return Field(
        default,
        alias=alias,
        title=long_name,
        description=help or long_name,
        json_schema_extra={"unit": unit, "symbol": symbol},
        **limits,
    )


@dataclass(frozen=True)
class Parameter:
    """A number of a machine: its path, value, unit, symbol in equations and long name."""

    path: str
    value: float
    unit: str
    symbol: str
    long_name: str

    @property
    def full_name(self) -> str:
        """Long name with the owner, see the function ``full_name``."""
        return full_name(self.path, self.long_name)

    @property
    def sentence_name(self) -> str:
        """Name in a sentence: the full name, or the path itself where it is a single symbol."""
        return self.full_name if "." in self.path else self.path

    def value_text(self, value: float, digits: int = 6) -> str:
        """A value of the parameter in a sentence: ``no-load speed of the drive = 143.7 rad/s``."""
        return f"{self.sentence_name} = {value:.{digits}g} {self.unit}".rstrip()


def full_name(path: str, long_name: str) -> str:
    """Long name with the owner: ``no-load speed of the drive`` for ``drive.no_load_speed``; a bare name has no owner."""
    *owners, name = path.split(".")
    direction = ""
    if owners and name in _AXES:
        direction, (*owners, name) = f" in {name}", owners
    owner = _owner_name(owners)
    if not owner or name == "gravity" or f" {owner.removeprefix('the ')} " in f" {long_name} ":
        return long_name + direction
    long = any(f" {word} " in long_name for word in _LONG)
    return f"{long_name}{direction}, {owner.removeprefix('the ')}" if long else f"{long_name}{direction} of {owner}"


_AXES = ("x", "y")
_LONG = ("of", "at", "to")  # words after which another ``of`` would belong to something else
_PARTS = ("carrier", "drive", "load", "foundation")  # of which a machine has one


def _owner_name(owners: list[str]) -> str:
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


@dataclass_transform(kw_only_default=True, field_specifiers=(Field, si, composite))
class _TableMeta(_Metaclass):
    """Classes whose call raises ``InputError`` instead of pydantic's error, and which show their fields.

    ``inspect.signature``, ``help`` and completion see the fields as parameters; type checkers do by ``dataclass_transform``.
    """

    if not TYPE_CHECKING:

        def __call__(self, *values: Any, **fields: Any) -> Any:
            keys, location = parameter_names(self), self.error_location()
            if len(values) > len(keys):
                raise InputError(location, len(values), f"at most {len(keys)} values can be given by position", code="too-many")
            by_position = dict(zip(keys, values, strict=False))
            if twice := [name for name in by_position if name in fields]:
                raise InputError(
                    f"{location}.{twice[0]}", fields[twice[0]], "this key is also given by position", code="given-twice"
                )
            document = {keys.get(name, name): value for name, value in (by_position | fields).items()}
            return validate_table(self, document, location)

        # Made when they are read, as hundreds of tables are imported. Pydantic sets a signature with addresses of objects.
        __signature__ = property(signature_of, lambda cls, signature: None)
        __doc__ = property(docstring_of, type.__dict__["__doc__"].__set__)


class TableModel(BaseModel, metaclass=_TableMeta):
    """A table of a file, or the same built in Python: its quantities are numbers in SI, or strings with a unit.

    Raises ``InputError`` for invalid values. Its JSON schema admits strings with a unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    kind: ClassVar[str] = ""

    @classmethod
    def error_location(cls) -> str:
        """Location of a fault in Python code."""
        return cls.kind or cls.__name__

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        unit = unit_of(field)
        if unit is None or value is None:
            return value
        positive = any(getattr(limit, "gt", None) == 0 for limit in field.metadata)
        parse = unit.parse_positive if positive else unit.parse_quantity
        return [parse(g) for g in value] if isinstance(value, list | tuple) else parse(value)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        table_schema = handler.resolve_ref_schema(handler(schema))
        table_schema.pop("description", None)  # with the section of the parameters, which are its properties
        if prose := prose_of(cls):
            table_schema["description"] = prose
        properties = table_schema.get("properties", {})
        properties |= {name: _with_unit_strings(field) for name, field in properties.items() if "unit" in field}
        return table_schema

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """The given quantities as parameters ``path.field``, or ``field`` without a path.

        Pairs by component ``.x``, ``.y``; tables inside likewise.
        """
        parameters: list[Parameter] = []
        for name, field_info in type(self).model_fields.items():
            unit, value = unit_of(field_info), getattr(self, name)
            key = f"{path}.{field_info.alias or name}".removeprefix(".")
            if isinstance(value, TableModel):
                parameters += value.parameters_at(key)
            elif unit is None:
                for i, table in enumerate(value if isinstance(value, tuple) else (), 1):
                    parameters += table.parameters_at(f"{key}.{i}") if isinstance(table, TableModel) else ()
            elif isinstance(value, tuple):
                for c, x in zip("xy", value, strict=True):
                    parameters.append(Parameter(f"{key}.{c}", float(x), unit.si, f"{unit.symbol}_{c}", unit.long_name))
            elif value is not None:
                parameters.append(Parameter(key, float(value), unit.si, unit.symbol, unit.long_name))
        return tuple(parameters)


def _with_unit_strings(schema: Any) -> Any:
    """A JSON schema in which each number may also be a string with a unit."""
    if isinstance(schema, Mapping):
        if schema.get("type") == "number":
            number = {k: v for k, v in schema.items() if k in _OF_A_NUMBER}
            rest = {k: v for k, v in schema.items() if k not in _OF_A_NUMBER}
            return rest | {"anyOf": [number, {"type": "string", "description": "a number with its unit, as '2.5 kg'"}]}
        return {k: v if k == "default" else _with_unit_strings(v) for k, v in schema.items()}
    return [_with_unit_strings(s) for s in schema] if isinstance(schema, list) else schema


_OF_A_NUMBER = ("type", "exclusiveMinimum", "exclusiveMaximum", "minimum", "maximum")
