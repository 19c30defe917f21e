"""Compiled once, run many: after the first run of a structure no symbolic work is done, whatever the values."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numpy as np
import pytest

from wucht import load_machine, run
from wucht.studies.registry import study_of

START = {"p1": 0.3, "p2": -0.5}
QUESTIONS: dict[str, tuple[str, dict[str, Any], dict[str, float]]] = {
    "run-up of both": ("drozdetskaya-2020/r1", {"until": 1.0, "start": START, "model": "both"}, {"drive.slope": 0.05}),
    "run-up with contacts": ("practice/grinder-4-balls", {"until": 0.2}, {}),
    "coast-down": ("drozdetskaya-2020/r1", {"until": 2.0}, {"carrier.damping": 150.0}),
    "response": ("drozdetskaya-2020/r1", {}, {"carrier.damping": 150.0}),
    "sweep": ("drozdetskaya-2020/table-3.1-carrier", {"along": "u", "range": (1.0, 1.1), "rate": 1e-3}, {}),
}


SYMBOLIC = {"lambdify", "diff", "simplify", "solve", "together", "expand"}  # functions of SymPy


@contextmanager
def called(package: str) -> Iterator[set[str]]:
    """The names of a package's functions that are called while the block lasts."""
    names = set[str]()

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and f"{os.sep}{package}{os.sep}" in frame.f_code.co_filename:
            names.add(frame.f_code.co_name)

    sys.setprofile(note)
    try:
        yield names
    finally:
        sys.setprofile(None)


@pytest.mark.slow
@pytest.mark.parametrize("name", QUESTIONS)
def test_nothing_symbolic_in_a_second_run(name: str) -> None:
    file, keys, values = QUESTIONS[name]
    spec = study_of(name.split(" ", maxsplit=1)[0]).study(**keys)
    first = run(spec, load_machine(file))
    with called("sympy") as names:
        again = run(spec, load_machine(file))  # another object of the same structure
        other = run(spec, load_machine(file).with_values(values))
    assert not names & SYMBOLIC
    for variable in first.data_vars:
        assert np.array_equal(first[variable].values, again[variable].values, equal_nan=first[variable].dtype.kind == "f")
    assert not values or other.wucht.summary != first.wucht.summary
