"""Types of keys that tables of files have: each with its check, and the sentence on what is allowed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator


def validator(
    is_allowed: Callable[[Any], bool], sentence: str, convert: Callable[[Any], Any] = lambda raw: raw
) -> BeforeValidator:
    """Return the validator of a raw value, with the sentence for forbidden values. convert: applied to the others."""

    def validate(raw: Any) -> Any:
        if not is_allowed(raw):
            raise ValueError(sentence)
        return convert(raw)

    return BeforeValidator(validate)


def is_bool(raw: Any) -> bool:
    """True for true and false."""
    return isinstance(raw, bool)


def is_whole(raw: Any) -> bool:
    """True for a whole number; 5.0, as given by ``--set``, is one."""
    return not is_bool(raw) and (isinstance(raw, int) or (isinstance(raw, float) and raw.is_integer()))


Value = Annotated[
    float | str, validator(lambda raw: not is_bool(raw), "must be a number, or a string with a unit")
]  # in a unit that the table's subject determines
Whole = Annotated[int, validator(is_whole, "must be a whole number", int)]
TrueOrFalse = Annotated[bool, validator(is_bool, "must be true or false")]
