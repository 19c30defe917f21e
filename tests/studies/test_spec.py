"""What all questions have in common: quantities located and read, whole numbers, and units where the subject has none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht import Response, RunUp, UserSystem, load_machine, parts, run

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


@pytest.mark.parametrize(
    ("array", "in_a_file"),
    [
        ({"range": np.array([5.0, 25.0])}, {"range": [5.0, 25.0]}),
        ({"range": np.array(["300 rpm", "600 rpm"])}, {"range": ["300 rpm", "600 rpm"]}),
        ({"range": range(5, 7), "points": np.int64(7)}, {"range": [5.0, 6.0], "points": 7}),
        ({"range": [np.float32(5.0), np.array(6.0)]}, {"range": [5.0, 6.0]}),
    ],
)
def test_arrays_ranges_and_numbers_of_numpy_are_lists_and_numbers(array: dict[str, Any], in_a_file: dict[str, Any]) -> None:
    assert Response(**array) == Response.from_table(in_a_file)


def test_arrays_within_tables_parts_and_settings() -> None:
    values = np.linspace(0.01, 0.02, 3)
    asked = RunUp(until=np.float32(0.5), start={"p1": np.float32(0.5)}, along="drive.slope", values=values)
    assert asked == RunUp(until=0.5, start={"p1": 0.5}, along="drive.slope", values=[0.01, 0.015, 0.02])
    machine = load_machine("drozdetskaya-2020/r1", {"drive.slope": values[1], "carrier.stiffness": np.array([1e5, 2e5])})
    assert (
        machine.values["carrier.stiffness.y"] == 2e5
        and machine.with_values({"drive.slope": np.int64(2)}).values["drive.slope"] == 2
    )
    assert parts.Carrier(mass=np.int32(2), stiffness=np.array([1e5, 2e5])) == parts.Carrier(mass=2.0, stiffness=(1e5, 2e5))
    decay = UserSystem.from_formulas({"x": "-a*x"}, {"a": np.int64(2)}, angles=())
    assert decay.with_values({"a": values[0]}).values == {"a": 0.01}
    with refused("a", given=[0.01, 0.02], code="no-quantity"):
        decay.with_values({"a": values[::2].tolist()})
    with refused("carrier.stiffness", "pair", given=[1.0, 2.0, 3.0], code="pair"):
        parts.Carrier(stiffness=np.arange(1.0, 4.0))
    with refused("study.range", "pair", given=[1.0, 2.0, 3.0]):
        Response(range=np.arange(1.0, 4.0))
    with refused("study.until", "time", given=[2.0], code="type"):
        RunUp(until=np.array([2.0]))
    with refused("study.until", "s", given=True, code="no-quantity"):
        RunUp(until=np.bool_(True))


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
