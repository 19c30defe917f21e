"""What all questions have in common: quantities located and read, whole numbers, and units where the subject has none."""

from __future__ import annotations

from typing import Any

import pytest

from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.studies.response.prepare import prepare
from wucht.studies.response.spec import Response
from wucht.studies.run_up.prepare import prepare as prepare_run_up
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

DIMENSIONLESS = "drozdetskaya-2020/table-5.1"


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"range": [1.0, "2 kg"]}, r"^study\.range\[1\]: given '2 kg'; .*this one is a mass"),
        ({"range": [1.0]}, r"^study\.range: .*must be a pair \[low, high\]"),
        ({"range": 3}, r"^study\.range: given 3; must be a pair \[low, high\]"),
        ({"range": [2.0, 1.0]}, r"^study\.range: .*with low below high"),
        ({"points": 1}, r"^study\.points: given 1; must be a whole number from 2 to 100000"),
        ({"points": float("inf")}, r"^study\.points: given inf; must be a whole number"),
        ({"points": 10**400}, r"^study\.points: .*must be a whole number from 2 to 100000"),
    ],
)
def test_a_wrong_value_is_located(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        Response.read(given)


def test_units_are_refused_where_the_machine_has_none() -> None:
    machine = load_machine(DIMENSIONLESS)
    assert prepare(Response.read({"range": [0.5, 2]}), machine).range == (0.5, 2.0)
    with pytest.raises(InputError, match=r"^study\.range\[1\]: given '2 rad/s'"):
        run(Response.read({"range": [0.5, "2 rad/s"]}), machine)


@pytest.mark.parametrize("until", ["settled", {"turns": 3}, {"settled": True}])
def test_words_for_another_key_are_no_quantities(until: Any) -> None:
    spec = RunUp.read({"until": until})
    spec.refuse_units()
    (case,) = prepare_run_up(spec, load_machine(DIMENSIONLESS)).cases
    assert case.run.horizon.until_settled == ("turns" not in dict.fromkeys(until))
