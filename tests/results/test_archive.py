"""Frozen data written and read back: to the last bit, and nothing else is read."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from wucht.errors import WuchtError
from wucht.results import archive
from wucht.results.outcomes import Outcome


@dataclass(frozen=True)
class Inner:
    values: np.ndarray
    label: str = ""


@dataclass(frozen=True)
class Outer:
    inner: Inner
    several: tuple[Inner, ...]
    number: float
    outcome: Outcome | None = None


def same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    if isinstance(a, float) and math.isnan(a):
        return isinstance(b, float) and math.isnan(b)
    if isinstance(a, dict):
        return type(b) is dict and list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if isinstance(a, tuple | list):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if hasattr(a, "__dataclass_fields__"):
        return type(a) is type(b) and same(vars(a), vars(b))
    return type(a) is type(b) and a == b


simple = st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats() | st.text() | st.sampled_from(list(Outcome))
number_arrays = arrays(st.sampled_from([float, int, complex, bool]), st.tuples(st.integers(0, 3), st.integers(0, 3)))
data = st.recursive(
    simple | number_arrays | st.builds(Inner, number_arrays, st.text()),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.lists(inner, max_size=3).map(tuple)
        | st.dictionaries(st.text(), inner, max_size=3)
    ),
    max_leaves=8,
)  # fmt: skip


@given(data)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_is_read(tmp_path: Path, value: Any) -> None:
    archive.write(tmp_path / "a.npz", {"one": value, "two": (value, 1)})
    read = archive.read(tmp_path / "a.npz")
    assert same(read["one"], value)
    assert same(read["two"], (value, 1))


def test_dataclasses_in_dataclasses(tmp_path: Path) -> None:
    value = Outer(Inner(np.arange(3.0)), (Inner(np.eye(2), "b"),), math.inf, Outcome.CAPTURED)
    archive.write(tmp_path / "a.npz", {"x": value})
    assert same(archive.read(tmp_path / "a.npz")["x"], value)


def test_numbers_of_numpy_and_complex_numbers(tmp_path: Path) -> None:
    archive.write(tmp_path / "a.npz", {"a": np.float64(0.1), "b": np.int64(3), "c": 1 + 2j})
    assert archive.read(tmp_path / "a.npz") == {"a": 0.1, "b": 3, "c": 1 + 2j}


@pytest.mark.parametrize("value", [object(), {1, 2}, lambda: None, Path(), np.array([object()])])
def test_what_is_no_frozen_data_is_refused(tmp_path: Path, value: Any) -> None:
    with pytest.raises((WuchtError, ValueError)):
        archive.write(tmp_path / "a.npz", {"x": value})
        archive.read(tmp_path / "a.npz")


@pytest.mark.parametrize("content", [b"", b"nothing", b"PK\x03\x04 broken"])
def test_another_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(WuchtError, match=r"a\.npz cannot be read"):
        archive.read(tmp_path / "a.npz")


@pytest.mark.parametrize("name", ["os:system", "builtins:eval", "nowhere:Class", "pathlib:Path"])
def test_reading_makes_nothing_but_dataclasses(tmp_path: Path, name: str) -> None:
    tree = json.dumps({"x": {"class": name, "fields": {}}})
    np.savez(tmp_path / "a.npz", tree=np.array(tree))
    with pytest.raises(WuchtError, match="is not loaded"):
        archive.read(tmp_path / "a.npz")
