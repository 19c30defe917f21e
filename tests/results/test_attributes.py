"""Each attribute of a result is read with its type, or named with what it has and what is expected."""

from __future__ import annotations

import json
from typing import Any

import pytest
import xarray as xr
from tests.refusals import refused

from wucht.results.attributes import number_in, read_attributes, text_in

WHOLE: dict[str, Any] = {
    "study": "a", "title": "b", "sentence": "c", "failure": "", "finished": 1, "dimensionless": 0, "summary": "{}",
    "input": '{"study": {}, "machine": {}}', "warnings": "[]",
}  # fmt: skip
QUANTITY, PART = (
    {"headline": ["b"], "parts": {"b": {"unit": "m"}}},
    {"path": "drum", "kind": "rotor", "on": "", "parameters": {}},
)


def test_what_a_result_of_an_earlier_version_lacks_is_empty() -> None:
    read = read_attributes(WHOLE, in_file=True)
    assert (read.notes, read.quantities, read.parts, read.versions, read.document, read.creation) == (
        [],
        {},
        [],
        None,
        None,
        None,
    )
    assert (read.is_finished, read.is_dimensionless, read.faults) == (True, False, ())


@pytest.mark.parametrize("name", [*WHOLE])
def test_what_every_result_has_may_not_be_missing(name: str) -> None:
    with refused(name, "is missing", given=None, code="missing"):
        read_attributes({k: v for k, v in WHOLE.items() if k != name}, in_file=True)


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        *[(name, 3, "a text") for name in ("study", "title", "sentence", "failure")],
        *[(name, wrong, "a finite number") for name in ("finished", "dimensionless") for wrong in ("1", [1, 0], float("nan"))],
        *[(name, wrong, "a table") for name in ("summary", "quantities") for wrong in ("x", "[]", 3, "[" * 10**5)],
        *[(name, wrong, "a list of texts") for name in ("warnings", "notes", "assumed", "contents") for wrong in ("[3]", "{}")],
        *[
            ("input", wrong, "tables of the question and the machine")
            for wrong in ("x", "{}", 3, '{"study": {}, "machine": []}')
        ],
        *[
            ("quantities", json.dumps({"a": wrong}), "a table of tables, one for each quantity")
            for wrong in (3, {"parts": []}, {"parts": {"b": 3}}, {"headline": 3}, {"headline": [3]}, {"unit": 3}, {"what": []})
        ],
        *[
            ("parts", json.dumps([wrong]), "a list of tables, one for each part of the machine")
            for wrong in (3, PART | {"on": 3}, PART | {"parameters": []}, PART | {"parameters": {"m": {"what": "mass"}}})
        ],
    ],
)
def test_what_the_answer_consists_of_is_refused_where_it_cannot_be_read(name: str, given: Any, expected: str) -> None:
    with refused(name, f"must be {expected}", given=given):
        read_attributes(WHOLE | {name: given})


@pytest.mark.parametrize(
    ("name", "given"),
    [
        *[("versions", wrong) for wrong in ("x", "[]", '{"wucht": 3}', 3, [1.0, 2.0])],
        *[("document", wrong) for wrong in ("", "[null]", "3", 3)],
        *[("created", wrong) for wrong in ("x", 3, "")],
    ],
)
def test_without_what_tells_how_it_was_computed_the_rest_is_read(name: str, given: Any) -> None:
    read = read_attributes(WHOLE | {"quantities": json.dumps({"a": QUANTITY}), "parts": json.dumps([PART]), name: given})
    assert (read.quantities, read.parts, getattr(read, name.replace("created", "creation"))) == ({"a": QUANTITY}, [PART], None)
    (fault,) = read.faults
    assert fault.startswith(f"{name}: given {given!r}; this attribute of the result must be a ")
    assert fault.endswith("; the result is read without it")


@pytest.mark.parametrize("given", ["1", [1.0], float("nan"), float("inf")])
def test_a_number_of_a_study(given: Any) -> None:
    assert number_in(xr.Dataset(attrs={"low": 2}), "low") == 2
    with refused("low", "a finite number"):
        number_in(xr.Dataset(attrs={"low": given}), "low")
    with refused("low", "is missing", given=None, code="missing"):
        text_in(xr.Dataset(), "low")
