"""A document as TOML reads back as the same, and the study file in a result asks the same question."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wucht.files.catalogue import names
from wucht.files.toml_text import abridge, toml_text
from wucht.studies.study_file import read_study
from wucht.studies.subjects import subject_of

_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
_SINGLE = st.one_of(_TEXT, st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False))
_VALUES = st.recursive(
    _SINGLE, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_TEXT, inner, max_size=3), max_leaves=12
)


@given(st.dictionaries(_TEXT, _VALUES, max_size=4))
def test_any_document_reads_back(document: dict[str, object]) -> None:
    assert tomllib.loads(toml_text(document)) == document


def test_what_has_no_value_is_left_out() -> None:
    assert tomllib.loads(toml_text({"a": None, "b": [1, None], "c": {"d": None}})) == {"b": [1], "c": {}}
    assert math.isnan(tomllib.loads(toml_text({"a": math.nan}))["a"])


def test_what_is_long_is_counted() -> None:
    short = abridge({"text": "x" * 30, "list": list(range(9)), "tables": [{"a": k} for k in range(9)], "few": [1]}, 10, 2)
    assert short == {
        "text": "x" * 10 + "… (20 more characters)",
        "list": [0, 1, "… 7 more"],
        "tables": [{"a": 0}, {"a": 1}, {"abridged": "… 7 more"}],
        "few": [1],
    }
    assert tomllib.loads(toml_text(short)) == short


@pytest.mark.parametrize("name", sorted(n for n in names() if n.startswith(("practice/", "kaltofen", "sperling-rollers/"))))
def test_the_study_file_of_a_result_asks_the_same(name: str, tmp_path: Path) -> None:
    first = read_study(name)
    file = tmp_path / "again.toml"
    file.write_text(toml_text(json.loads(json.dumps(first.document, default=str))), encoding="utf-8")
    again = read_study(str(file))
    subject = subject_of(first.spec)
    facts = [{k: v for k, v in dict(subject.describe(s).facts).items() if k != "title"} for s in (first.subject, again.subject)]
    assert facts[0] == facts[1]
    assert first.spec.to_table() == again.spec.to_table()
