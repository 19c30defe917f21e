"""Nameplates: what is printed on a motor, from which its parameters follow when it is built."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pydantic import ValidationError

from wucht.schema import Described, Parameter

LARGE = 0.1  # of a value: a fit that misses more of it is told as a warning


class Nameplate(Described):
    """What is printed on a motor. It has no parameters of its own: what follows from it are those of the motor."""

    def parameters_at(self, path: str) -> tuple[Parameter, ...]:
        """None."""
        return ()


PlateT = TypeVar("PlateT", bound=Nameplate)


def read_nameplate(given: Any, cls: type[PlateT], follow: Sequence[str]) -> tuple[Any, PlateT | None]:
    """The table of a motor and the nameplate in it from which its parameters are to be found.

    follow: the keys that follow from the nameplate. None where there is no nameplate, or one that is wrong, which its own field
    reports; and where all keys are there already, as in a motor that was built before. Raises ``ValueError(key, sentence)``
    where some are given beside it.
    """
    if not isinstance(given, Mapping) or given.get("nameplate") is None or all(key in given for key in follow):
        return given, None
    try:
        plate = cls.model_validate(given["nameplate"])
    except ValidationError:
        return given, None
    for key in follow:
        if given.get(key) is not None:
            raise ValueError(key, "not allowed beside nameplate, from which it follows")
    return given, plate


def required_without(schema: dict[str, Any], keys: Sequence[str]) -> dict[str, Any]:
    """The JSON schema of a motor in which these keys are required only where there is no nameplate."""
    required = schema.get("required", [])
    always = [key for key in required if key not in keys]
    choice = [{"required": ["nameplate"]}, {"required": [key for key in required if key in keys]}]
    return {k: v for k, v in schema.items() if k != "required"} | {"anyOf": choice} | ({"required": always} if always else {})


def missed(fitted: Mapping[str, tuple[float, float, str]]) -> dict[str, tuple[float, str]]:
    """By how much each fitted value differs from the printed one, relatively, and both in words.

    fitted: printed and fitted value, and their unit, by name.
    """
    errors = {}
    for name, (printed, found, unit) in fitted.items():
        error, suffix = found / printed - 1, f" {unit}" if unit else ""
        met = f"{name} {printed:.4g}{suffix} met" if abs(error) < 5e-4 else ""
        errors[name] = error, met or f"{name} {found:.4g}{suffix} for {printed:.4g}{suffix} ({100 * error:+.2g} %)"
    return errors
