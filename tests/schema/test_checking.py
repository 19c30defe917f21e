"""Tables checked key by key: what is wrong is located at its key, in tables inside and in lists too."""

from __future__ import annotations

from typing import Any, Literal

import pytest
from pydantic import Field
from tests.refusals import Refusal, refused

from wucht.schema import TableModel, Unit, choice, is_pairs, validate_table
from wucht.schema.checking import text
from wucht.schema.fields import si


class Spring(TableModel):
    stiffness: float = si("N/m", "stiffness", "c", gt=0)
    place: tuple[float, float] | None = si("m", "place", "r", None)


class Part(TableModel):
    mass: float = si("kg", "mass", "m", gt=0)
    share: float = Field(0.5, title="share", ge=0, le=1)
    angle: float = si("rad", "angle", "alpha", 0.0, ge=-1, le=2)
    count: int = Field(3, title="count", ge=2, le=9)
    law: Literal["linear", "smooth"] = "linear"
    spring: Spring | None = None
    springs: tuple[Spring, ...] = ()
    heavy: float = si("kg", "load", "M", 1.0, le=7)


SPRING = {"stiffness": "2 kN/m"}


@pytest.mark.parametrize(
    ("document", "refusal"),
    [
        ({}, refused("part.mass", "mass", "kg", given=None, code="missing")),
        ({"mass": 1.0, "masss": 2.0}, refused("part.masss", "mass", given=2.0, code="unknown-key")),
        ({"mass": "1 m"}, refused("part.mass", "kg", given="1 m", code="dimension")),
        ({"mass": 1.0, "share": 1.1}, refused("part.share", "0", "1", given=1.1, code="limits")),
        ({"mass": 1.0, "angle": "120 deg"}, refused("part.angle", "-1", "2 rad", given="120 deg", code="limits")),
        ({"mass": 1.0, "count": 10}, refused("part.count", "whole", "2", "9", given=10, code="limits")),
        ({"mass": 1.0, "heavy": "9 kg"}, refused("part.heavy", "most", "7 kg", given="9 kg", code="limits")),
        ({"mass": 1.0, "law": "rough"}, refused("part.law", "linear", "smooth", given="rough", code="unknown-name")),
        (
            {"mass": 1.0, "spring": SPRING | {"stiff": 2.0}},
            refused("part.spring.stiff", "stiffness", given=2.0, code="unknown-key"),
        ),
        ({"mass": 1.0, "springs": [SPRING, {}]}, refused("part.springs[1].stiffness", given=None, code="missing")),
        ({"mass": 1.0, "spring": SPRING | {"place": [1.0]}}, refused("part.spring.place", given=[1.0], code="pair")),
    ],
    ids=lambda value: "" if isinstance(value, Refusal) else str(value),
)
def test_what_is_wrong_is_at_its_key(document: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        validate_table(Part, document, "part")


@pytest.mark.parametrize(
    ("value", "code"), [(3, "type"), ("", "type"), (" \n", "type"), (True, "type"), ("a\x1b[0m", "control-characters")]
)
def test_what_is_no_text(value: object, code: str) -> None:
    with refused("study.title", given=value, code=code):
        text({"title": value}, "title", "study")
    with refused("title", given=value, code=code):
        text({"title": value}, "title", "")


@pytest.mark.parametrize(
    ("value", "pairs"),
    [([], True), ([[1, 2]], True), ([(1, "b"), [2, 3]], True), ((), True), ([[1, 2, 3]], False), ([[1, 2], 3], False),
     ([[1, 2], [3]], False), ("ab", False), (["ab"], False), (None, False)],
)  # fmt: skip
def test_pairs(value: object, pairs: bool) -> None:
    assert is_pairs(value) is pairs


def test_a_name_of_those_known() -> None:
    known = ["linear", "smooth"]
    assert choice({"kind": "smooth"}, "kind", "drive", known) == "smooth"
    with refused("drive.kind", "linear", "smooth", given=None, code="missing"):
        choice({"slope": 1}, "kind", "drive", known)
    with refused("drive.kinds", "kind", given="linear", code="unknown-key"):
        choice({"slope": 1, "kinds": "linear"}, "kind", "drive", known)
    with refused("drive.kind", "smooth", given="smoth", code="unknown-name"):
        choice({"kind": "smoth"}, "kind", "drive", known)
    with refused("drive.kind", given=["linear"], code="unknown-name"):
        choice({"kind": ["linear"]}, "kind", "drive", known)


@pytest.mark.parametrize(("value", "kept"), [(1e-31, False), (1e-30, True), (-5.0, True), (0.0, True), ("1e-28 g", False)])
def test_what_is_divided_by_is_not_below_the_smallest(value: object, kept: bool) -> None:
    unit = Unit("kg", "mass")
    assert unit.accepts(value)
    if kept:
        assert unit.parse_positive(value) == value
    else:
        with pytest.raises(ValueError, match="1e-30 kg"):
            unit.parse_positive(value)
