"""Fields of a part that hold physical quantities: read with their units, addressed by path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from wucht.quantities import Unit


def si(unit: str, what: str, symbol: str, default: Any = ..., alias: str | None = None, **limits: Any) -> Any:
    """A field that holds a physical quantity: its SI unit, its name in words, its symbol in equations, its limits (gt, ge)."""
    return Field(default, alias=alias, description=what, json_schema_extra={"unit": unit, "symbol": symbol}, **limits)


def unit_of(cls: type[BaseModel], name: str) -> Unit | None:
    """The unit of a field made by ``si``, None for other fields."""
    extra = cls.model_fields[name].json_schema_extra
    if not isinstance(extra, dict):
        return None
    return Unit(str(extra["unit"]), cls.model_fields[name].description or name, str(extra["symbol"]))


@dataclass(frozen=True)
class Parameter:
    """A number of a machine: its path, value, unit, symbol in equations and name in words."""

    path: str
    value: float
    unit: str
    symbol: str
    what: str


class Described(BaseModel):
    """A table of a machine file: its quantities are numbers in SI, or strings with a unit."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @field_validator("*", mode="before")
    @classmethod
    def _read_units(cls, given: Any, info: ValidationInfo) -> Any:
        unit = unit_of(cls, info.field_name) if info.field_name else None
        if unit is None or given is None:
            return given
        return [unit.parse(g) for g in given] if isinstance(given, list) else unit.parse(given)

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """The quantities given, as parameters ``path.field``; pairs by component ``.x``, ``.y``; tables inside likewise."""
        found: list[Parameter] = []
        for name, described in type(self).model_fields.items():
            unit, value = unit_of(type(self), name), getattr(self, name)
            key = f"{path}.{described.alias or name}"
            if isinstance(value, Described):
                found += value.parameters_at(key)
            elif isinstance(value, tuple) and value and isinstance(value[0], Described):
                for i, inner in enumerate(value):
                    found += inner.parameters_at(f"{key}.{i + 1}")
            if unit is None or value is None:
                continue
            pairs = zip((".x", ".y"), value, strict=True) if isinstance(value, tuple) else (("", value),)
            for suffix, number in pairs:
                label = unit.symbol + (f"_{suffix[1:]}" if suffix else "")
                found.append(Parameter(key + suffix, float(number), unit.si, label, unit.what))
        return tuple(found)
