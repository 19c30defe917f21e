"""Frozen data written and read back: to the last bit, and nothing else is read."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import pytest
import zarr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from tests.refusals import rejected

from wucht import WuchtError
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.results import archive


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


def back(folder: Path, **values: Any) -> dict[str, Any]:
    """What is read of values that were written."""
    group = folder / uuid4().hex
    archive.write_values(group, values)
    return archive.read_values(group)


@given(data)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_is_read(tmp_path: Path, value: Any) -> None:
    read = back(tmp_path, one=value, two=(value, 1))
    assert same(read["one"], value)
    assert same(read["two"], (value, 1))


def test_dataclasses_in_dataclasses(tmp_path: Path) -> None:
    value = Outer(Inner(np.arange(3.0)), (Inner(np.eye(2), "b"),), math.inf, Outcome.CAPTURED)
    assert same(back(tmp_path, x=value)["x"], value)


def test_numbers_of_numpy_and_complex_numbers(tmp_path: Path) -> None:
    assert back(tmp_path, a=np.float64(0.1), b=np.int64(3), c=1 + 2j) == {"a": 0.1, "b": 3, "c": 1 + 2j}


@pytest.mark.parametrize("kind", ["int8", "uint16", "float32", "bool", "complex128", "<U3"])
def test_arrays_keep_type_and_shape(tmp_path: Path, kind: str) -> None:
    arrays_ = {"a": np.ones((2, 3), kind), "b": np.zeros((0, 4), kind), "c": np.array(["x", ""]).astype("<U3")}
    read = back(tmp_path, **arrays_)
    for name, array in arrays_.items():
        assert same(read[name], array), name
        assert read[name].shape == array.shape


def test_other_readers_of_zarr_find_the_numbers(tmp_path: Path) -> None:
    archive.write_values(tmp_path / "a", {"x": Inner(np.arange(3.0)), "y": np.array([4.0])})
    group = zarr.open_group(tmp_path / "a", mode="r")
    assert group["float64"][:].tolist() == [0.0, 1.0, 2.0, 4.0]
    assert json.loads(str(group.attrs["tree"]))["y"] == {"array": "float64", "begin": 3, "shape": [1]}


@pytest.mark.parametrize("value", [object(), {1, 2}, lambda: None, Path(), np.array([object()])])
def test_what_is_no_frozen_data_is_refused(tmp_path: Path, value: Any) -> None:
    with pytest.raises((WuchtError, ValueError)):
        archive.write_values(tmp_path / "a", {"x": value})
    assert not (tmp_path / "a").exists()


def _files(group: Path) -> list[Path]:
    return sorted(p for p in group.rglob("*") if p.is_file())


@pytest.mark.parametrize("content", [None, b"", b"{}", b"half of it"], ids=["missing", "empty", "object", "text"])
@pytest.mark.parametrize("number", range(5))
def test_a_group_that_is_not_whole_is_refused(tmp_path: Path, number: int, content: bytes | None) -> None:
    """Whichever of its files is not there, or is another: its own description, those of its two arrays, and their numbers."""
    archive.write_values(tmp_path / "a", {"x": np.arange(9.0), "y": np.arange(9)})
    files = _files(tmp_path / "a")
    assert len(files) == 5
    if content is None:
        files[number].unlink()
    else:
        files[number].write_bytes(content)
    with rejected("incomplete"):
        archive.read_values(tmp_path / "a")


def test_numbers_of_another_group_are_refused(tmp_path: Path) -> None:
    """Well written, but not those that belong to it."""
    for name, x in {"a": 1.0, "b": 2.0}.items():
        archive.write_values(tmp_path / name, {"x": np.full(9, x)})
    numbers = Path("float64") / "c" / "0"
    (tmp_path / "a" / numbers).write_bytes((tmp_path / "b" / numbers).read_bytes())
    with rejected("incomplete"):
        archive.read_values(tmp_path / "a")


@pytest.mark.parametrize("name", ["os:system", "builtins:eval", "nowhere:Class", "pathlib:Path"])
def test_reading_makes_nothing_but_dataclasses(tmp_path: Path, name: str) -> None:
    tree = json.dumps({"x": {"class": name, "fields": {}}})
    zarr.create_group(tmp_path / "a", attributes={"tree": tree, "types": [], "digest": sha256(tree.encode()).hexdigest()})
    with rejected("incomplete"):
        archive.read_values(tmp_path / "a")


@pytest.mark.parametrize("dtype", ["|O", "<f8"])
@pytest.mark.parametrize("place", ["filters", "compressor"])
def test_pickled_numbers_are_not_read(tmp_path: Path, dtype: str, place: str) -> None:
    """The older format of Zarr can name pickle as the form of an array, and a pickle can call any function."""
    array = tmp_path / "a" / "float64"
    array.mkdir(parents=True)
    attributes = {"tree": "{}", "types": ["float64"], "digest": ""}
    description = {"zarr_format": 2, "shape": [1], "chunks": [1], "dtype": dtype, "fill_value": 0, "order": "C"}
    coded = {"id": "pickle", "protocol": 5}
    coding = {"filters": [coded], "compressor": None} if place == "filters" else {"filters": None, "compressor": coded}
    for name, content in {
        ".zgroup": {"zarr_format": 2},
        ".zattrs": attributes,
        "float64/.zarray": description | coding,
    }.items():
        (tmp_path / "a" / name).write_text(json.dumps(content), encoding="utf-8")
    evil = pickle.dumps(Evil(tmp_path / "written"))
    (array / "0").write_bytes(evil)
    with rejected("incomplete"):
        archive.read_values(tmp_path / "a")
    assert not (tmp_path / "written").exists()
    pickle.loads(evil)
    assert (tmp_path / "written").exists(), "so that the test can fail"


class Evil:
    """What a crafted pickle is: it calls any function when it is loaded."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.target,)


def test_more_numbers_than_are_written_at_once(tmp_path: Path) -> None:
    """By chunks."""
    values = {
        "many": np.arange(2_500_000.0),
        "few": np.arange(3.0),
        "table": np.arange(15.0).reshape(3, 5).T,
        "none": np.zeros((0, 2)),
    }
    archive.write_values(tmp_path / "group", values)
    assert same(archive.read_values(tmp_path / "group"), values)
    (chunk,) = zarr.open_group(tmp_path / "group", mode="r")["float64"].chunks
    assert 1000 < chunk < 2_500_000


def test_the_size_is_that_of_all_arrays() -> None:
    inner = Inner(np.zeros(5), "x")
    assert archive.size({"a": Outer(inner, (inner, inner), 1.0), "b": [np.zeros((2, 3), np.int32)]}) == 3 * 40 + 24
