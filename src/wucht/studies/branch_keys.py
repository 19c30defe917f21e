"""Keys of questions about branches of steady states and of orbits, and how summaries state the values of parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from wucht.schema import Unit

NAMES = ("compensating", "together", "opposed")
VALUES = ("value", "second_value")


def with_values(
    entry: Mapping[str, Any], paths: Sequence[str], values: Sequence[float], optional: Sequence[str] = ()
) -> dict[str, Any]:
    """An entry of a summary with the values of its parameters: under ``value`` and ``second_value``, and under their names.

    A name that is another key of the table keeps that meaning. optional: keys that only some entries of the table have.
    """
    named = {path: value for path, value in zip(paths, values, strict=True) if path not in optional}
    return named | dict(zip(VALUES, values, strict=False)) | dict(entry)


def _names(given: Any) -> Any:
    listed = [given] if isinstance(given, str) else given
    if not isinstance(listed, list | tuple) or not listed or any(one not in NAMES for one in listed):
        raise ValueError(f"must be one or more of: {', '.join(NAMES)}")
    return tuple(dict.fromkeys(listed))


def _ranges(given: Any) -> Any:
    if not isinstance(given, Mapping):
        raise ValueError("must be a table: ranges = { STATE = [low, high], ... }")
    read = dict[str, tuple[float, float]]()
    for name, pair in given.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2 or any(isinstance(x, bool) for x in pair):
            raise ValueError(f"must give a pair [low, high] for {name}")
        low, high = (Unit("", f"end of the range of {name}").parse(x) for x in pair)
        if not low < high:
            raise ValueError(f"must give a pair [low, high] with low below high for {name}")
        read[str(name)] = low, high
    return read


Ranges = Annotated[
    dict[str, tuple[float, float]],
    BeforeValidator(_ranges),
    Field(description="ranges of the states of a system, by name, in which equilibria are searched"),
]
Names = Annotated[
    tuple[str, ...], BeforeValidator(_names), Field(description="names of steady states that are kept, others are left out")
]
