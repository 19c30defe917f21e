"""The keys of a table, from its schema: of made-up tables, and of all that a file can name."""

from __future__ import annotations

from typing import Literal

import pytest
from pydantic import Field

from wucht.cli.list_name import kinds
from wucht.schema import Key, TableModel, keys_of, si
from wucht.studies.registry import studies


class Inner(TableModel):
    """A table inside."""

    at: tuple[float, float] = si("m", "place", alias="@", help="place in the frame")
    then: Inner | None = None


class Outer(TableModel):
    """A table."""

    mass: float = si("kg", "mass", gt=0, le=5)
    stiffness: float | tuple[float, float] = si("N/m", "stiffness", default=1.0)
    model: Literal["full", "slow"] = Field("full", title="equations", description="which equations are solved")
    count: int | None = Field(None, ge=1)
    inner: Inner | None = Field(None, description="a table")
    many: tuple[Inner, ...] = ()
    made: str = Field("", exclude=True)


def test_what_a_key_is() -> None:
    keys = {key.name: key for key in keys_of(Outer)}
    assert list(keys) == [
        "mass",
        "stiffness",
        "model",
        "count",
        "inner",
        "inner.@",
        "inner.then",
        "many",
        "many[].@",
        "many[].then",
    ]
    assert keys["mass"] == Key("mass", "number", "kg", True, None, "> 0, <= 5", "mass")
    assert keys["stiffness"] == Key("stiffness", "number or pair", "N/m", False, 1.0, "", "stiffness")
    assert keys["model"] == Key("model", "word", None, False, "full", "full, slow", "which equations are solved")
    assert keys["count"] == Key("count", "whole number", None, False, None, ">= 1", "")
    assert keys["inner"] == Key("inner", "table", None, False, None, "", "a table")
    assert keys["many[].@"] == Key("many[].@", "pair", "m", True, None, "", "place in the frame")


EVERY = {name: cls for of_kind in kinds().values() for name, cls in of_kind.items()}
EVERY |= {kind: study.study for kind, study in studies().items()}


@pytest.mark.parametrize("name", EVERY)
def test_of_all_that_a_file_can_name(name: str) -> None:
    keys = keys_of(EVERY[name])
    own = [key for key in keys if "." not in key.name]
    fields = {f.alias or n: f for n, f in EVERY[name].model_fields.items() if not f.exclude}
    assert [key.name for key in own] == list(fields)
    # A nameplate and a circuit are two ways to give the same: neither alone is needed.
    either = {key for way in EVERY[name].model_json_schema().get("anyOf", ()) for key in way["required"]}
    for key in own:
        assert "value" not in key.type, key
        assert key.needed == (fields[key.name].is_required() and key.name not in either)
