"""Spec of a comparison."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import date, time
from itertools import product
from math import prod
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from wucht.errors import InputError
from wucht.file_names import printable
from wucht.schema import Composite, composite
from wucht.studies import spec as common

MOST_VARIED, MOST_VARIANTS = 2, 500


def _sources(raw: Any) -> Any:
    texts = isinstance(raw, list | tuple) and raw and all(isinstance(g, str) and g.strip() for g in raw)
    if not texts:
        raise ValueError('must be a list of study files, catalogue names and folders of results: of = ["A", "B"]')
    for name in raw:
        if printable(name) != name:
            raise InputError("study.of", name, "must be a name in UTF-8 without control characters: it is stored in the result")
    return tuple(raw)


def _table(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table: set = { PATH = VALUE, ... }")
    return _flat(raw)


def _lists(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table of lists: vary = { PATH = [VALUE, ...], ... }")
    table = _flat(raw)
    for path, values in table.items():
        if not isinstance(values, list | tuple) or not values:
            raise InputError(f"study.vary.{path}", values, "must be a list of values")
        for i, value in enumerate(values):
            if (moment := _date_in(value)) is not None:
                raise InputError(f"study.vary.{path}[{i}]", moment, "must be a number or a text, not a date")
    if len(table) > MOST_VARIED:
        raise InputError("study.vary", sorted(table), f"at most {MOST_VARIED} parameters are varied at once")
    return {path: tuple(values) for path, values in table.items()}


def _date_in(value: Any) -> date | time | None:
    """Return a date or a time of day in a value, as TOML has them; None if there is none."""
    if isinstance(value, date | time):
        return value
    inside = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return next((moment for one in inside if (moment := _date_in(one)) is not None), None)


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the values by path: TOML reads ``b1.damping = 3`` as a table within a table."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) and value else {prefix + key: value}
    return flat


class Comparison(common.Spec):
    """Comparison of machines or variants side by side: the study of each, in one result."""

    kind: ClassVar[str] = "comparison"
    subject: ClassVar[str] = "wucht.studies.comparison.variants:VARIANTS"
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()

    of: Composite[Annotated[tuple[str, ...], BeforeValidator(_sources)]] = composite(
        title="compared files", description="study files, catalogue names, and folders of existing results"
    )
    set: Composite[Annotated[dict[str, Any], BeforeValidator(_table)]] = composite(
        default_factory=dict,
        title="keys set in all variants",
        description="keys set in all variants, by path; those of the study begin with `study.`",
    )
    vary: Composite[Annotated[dict[str, tuple[Any, ...]], BeforeValidator(_lists)]] = composite(
        default_factory=dict,
        title="values of varied keys",
        description="values of one or two keys; every combination is a variant of each file",
    )

    def check(self) -> None:
        """Check that there are at least two variants, and not too many to read."""
        count = len(self.of) * prod(map(len, self.vary.values()))
        if not 2 <= count <= MOST_VARIANTS:
            requirement = f"there must be 2 to {MOST_VARIANTS} variants, files times values; these are {count}"
            raise InputError("study.vary" if self.vary else "study.of", None, requirement)
        if duplicates := sorted(set(self.vary) & set(self.set)):
            raise InputError(f"study.vary.{duplicates[0]}", None, "this key is also in set; give it once")

    @property
    def combinations(self) -> tuple[dict[str, Any], ...]:
        """Varied values of each variant of a file, the last key changing fastest."""
        return tuple(dict(zip(self.vary, values, strict=True)) for values in product(*self.vary.values()))
