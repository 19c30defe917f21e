"""What all questions have in common: quantities located and read, whole numbers, and units where the subject has none."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tests.refusals import Refusal, refused

from wucht import Response, RunUp, load_machine, run

DIMENSIONLESS = "drozdetskaya-2020/table-5.1"


@pytest.mark.parametrize(
    ("given", "refusal"),
    [
        ({"range": [1.0, "2 kg"]}, refused("study.range[1]", given="2 kg", code="dimension")),
        ({"range": [1.0]}, refused("study.range", given=[1.0])),
        ({"range": 3}, refused("study.range", given=3)),
        ({"range": [2.0, 1.0]}, refused("study.range", given=[2.0, 1.0])),
        ({"points": 1}, refused("study.points", "100000", given=1, code="limits")),
        ({"points": float("inf")}, refused("study.points", given=float("inf"))),
        ({"points": 10**400}, refused("study.points", "100000", code="limits")),
    ],
)
def test_a_wrong_value_is_located(given: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        Response.from_table(given)


def test_units_are_refused_where_the_machine_has_none() -> None:
    machine = load_machine(DIMENSIONLESS)
    assert run(Response.from_table({"range": [0.5, 2], "points": 2}), machine).wucht.summary["range"] == [0.5, 2.0]
    with refused("study.range[1]", given="2 rad/s", code="dimension"):
        run(Response.from_table({"range": [0.5, "2 rad/s"]}), machine)


@pytest.mark.parametrize("until", ["settled", {"turns": 3}, {"settled": True}])
def test_words_for_another_key_are_no_quantities(until: Any) -> None:
    spec = RunUp.from_table({"until": until})
    spec.refuse_units()
    angle = run(spec, load_machine(DIMENSIONLESS)).angle.values[0]
    turns = abs(angle[-1] - angle[0]) / (2 * math.pi)
    is_counted = "turns" in dict.fromkeys(until)
    assert turns == pytest.approx(3, abs=1 / 24) if is_counted else turns > 10, "of 24 samples a turn the last one is stored"
