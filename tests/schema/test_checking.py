"""Tables checked key by key: what is wrong is located at its key, in tables inside and in lists too."""

from __future__ import annotations

from typing import Any, Literal

import pytest
from pydantic import Field
from tests.refusals import Refusal, refused

from wucht.errors import InputError
from wucht.schema import TableModel, Unit, choice, is_pairs, read_quantity, refuse_unknown, require_table, validate_table
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
        ({"mass": 0.0}, refused("part.mass", "greater", "0", given=0.0, code="limits")),
        ({"mass": 1.0, "masss": 2.0}, refused("part.masss", "mass", given=2.0, code="unknown-key")),
        ({"mass": "1 m"}, refused("part.mass", "kg", given="1 m", code="dimension")),
        ({"mass": 1.0, "share": -0.1}, refused("part.share", "0", "1", given=-0.1, code="limits")),
        ({"mass": 1.0, "share": 1.1}, refused("part.share", "0", "1", given=1.1, code="limits")),
        ({"mass": 1.0, "angle": "120 deg"}, refused("part.angle", "-1", "2 rad", given="120 deg", code="limits")),
        ({"mass": 1.0, "count": 10}, refused("part.count", "whole", "2", "9", given=10, code="limits")),
        ({"mass": 1.0, "heavy": "9 kg"}, refused("part.heavy", "most", "7 kg", given="9 kg", code="limits")),
        ({"mass": 1.0, "law": "rough"}, refused("part.law", "linear", "smooth", given="rough", code="unknown-name")),
        ({"mass": 1.0, "spring": {}}, refused("part.spring.stiffness", "N/m", given=None, code="missing")),
        ({"mass": 1.0, "spring": {"stiffness": -2.0}}, refused("part.spring.stiffness", "0 N/m", given=-2.0, code="limits")),
        (
            {"mass": 1.0, "spring": SPRING | {"stiff": 2.0}},
            refused("part.spring.stiff", "stiffness", given=2.0, code="unknown-key"),
        ),
        ({"mass": 1.0, "springs": [SPRING, {}]}, refused("part.springs[1].stiffness", given=None, code="missing")),
        (
            {"mass": 1.0, "springs": [SPRING, SPRING | {"stiffness": 0}]},
            refused("part.springs[1].stiffness", given=0, code="limits"),
        ),
        (
            {"mass": 1.0, "spring": SPRING | {"place": [1.0]}},
            refused("part.spring.place", given=[1.0], code="pair"),
        ),
        (
            {"mass": 1.0, "spring": SPRING | {"place": [1.0, 2.0, 3.0]}},
            refused("part.spring.place", given=[1.0, 2.0, 3.0], code="pair"),
        ),
    ],
    ids=lambda value: "" if isinstance(value, Refusal) else str(value),
)
def test_what_is_wrong_is_at_its_key(document: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        validate_table(Part, document, "part")


def test_a_table_in_python_is_located_by_its_class() -> None:
    with refused("Part.mass", given=-1.0, code="limits"):
        Part(mass=-1.0)
    made = Part("2 t", springs=({"stiffness": 5.0},))  # type: ignore[arg-type]
    assert made.mass == 2000.0
    assert made.springs[0].stiffness == 5.0


def test_without_a_location_the_key_stands_alone() -> None:
    with refused("mass", given=None, code="missing"):
        validate_table(Part, {}, "")
    with refused("b", "a", given=1, code="unknown-key"):
        refuse_unknown({"a": 0, "b": 1}, ["a"], "")
    refuse_unknown({"a": 0}, ["a", "b"], "part")


def test_a_sub_table_is_there_and_is_one() -> None:
    assert require_table({"study": {"kind": "sweep"}}, "study", "study") == {"kind": "sweep"}
    with refused("machine.drive", given=None, code="missing"):
        require_table({}, "drive", "machine.drive")
    with refused("machine.drive", given=[1], code="type"):
        require_table({"drive": [1]}, "drive", "machine.drive")


@pytest.mark.parametrize(
    ("value", "code"), [(3, "type"), ("", "type"), (" \n", "type"), (True, "type"), ("a\x1b[0m", "control-characters")]
)
def test_what_is_no_text(value: object, code: str) -> None:
    with refused("study.title", given=value, code=code):
        text({"title": value}, "title", "study")
    with refused("title", given=value, code=code):
        text({"title": value}, "title", "")


def test_a_text_may_have_lines_and_may_be_left_out() -> None:
    assert text({"title": "one\n\ttwo"}, "title", "") == "one\n\ttwo"
    assert text({}, "title", "") is None


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


def test_a_quantity_is_located_where_it_is_given() -> None:
    assert read_quantity(Unit("m", "length"), "3 mm", "points[0][1]") == pytest.approx(3e-3)
    with refused("points[0][1]", "length", given="3 kg", code="dimension"):
        read_quantity(Unit("m", "length"), "3 kg", "points[0][1]")


@pytest.mark.parametrize(("value", "kept"), [(1e-31, False), (1e-30, True), (-5.0, True), (0.0, True), ("1e-28 g", False)])
def test_what_is_divided_by_is_not_below_the_smallest(value: object, kept: bool) -> None:
    unit = Unit("kg", "mass")
    assert unit.accepts(value)
    if kept:
        assert unit.parse_positive(value) == value
    else:
        with pytest.raises(ValueError, match="1e-30 kg"):
            unit.parse_positive(value)


def test_only_fields_above_zero_have_a_smallest_value() -> None:
    """A mass is divided by; an angle, or a number that may be zero, may be as small as it is."""
    with pytest.raises(InputError):
        Part(mass=1e-40)
    assert Part(mass=1.0, angle=1e-40).angle == 1e-40
    assert Part(mass=1.0, heavy=1e-40).heavy == 1e-40
