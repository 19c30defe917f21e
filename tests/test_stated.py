"""What the comparison with stated results notices, and what it leaves alone."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from tests import stated
from tests.refusals import SENTENCES


@pytest.mark.parametrize(
    ("actual", "expected", "is_noticed"),
    [
        ({"speed": 100.0}, {"speed": 100.01}, False),
        ({"speed": 100.0}, {"speed": 100.03}, True),
        ({"speed": 1e-13}, {"speed": 0.0}, False),
        ({"throw_direction": 3e-7}, {"throw_direction": 2e-7}, False),
        ({"throw_direction": 5e-7}, {"throw_direction": 2e-7}, True),
        ({"speed": None}, {"speed": 0.0}, True),
        ([1e-7, 1.0], [-1e-8, 1.0], False),
        ([1e-6, 1.0], [-1e-6, 1.0], True),
        ([1.0, 2.0], [1.0], True),
        ("12.34 mm at the end", "12.35 mm at the end", False),
        ("12.34 mm at the end", "12.34 m at the end", True),
        ("12.34 mm at the end", "12.54 mm at the end", True),
    ],
)
def test_what_is_noticed(actual: Any, expected: Any, is_noticed: bool) -> None:
    assert bool(list(stated._differences(actual, expected, ""))) == is_noticed


def test_a_stated_refusal_is_a_printable_line_that_names_its_key() -> None:
    refusals = json.loads(SENTENCES.read_text(encoding="utf-8"))
    assert list(refusals) == sorted(refusals)
    for case, (key, code, sentence) in refusals.items():
        assert sentence.isprintable() and key in sentence and len(sentence) < 2000, case
        assert re.fullmatch(r"[a-z-]*", code), case
