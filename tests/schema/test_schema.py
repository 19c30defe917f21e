"""The schema as one concept: what it exports, and its example."""

from __future__ import annotations

import doctest

import wucht.schema


def test_the_example_holds() -> None:
    assert doctest.testmod(wucht.schema) == (0, 4)
