"""Frozen data written and read back: to the last bit, and nothing else is read."""

from __future__ import annotations

import json
import math
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4
from zipfile import ZipFile

import numpy as np
import pytest
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
    file = folder / uuid4().hex
    archive.write_values(file, values)
    return {name: archive.read_value(file, name) for name in values}


@pytest.mark.slow
@given(data)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_is_written_is_read(tmp_path: Path, value: Any) -> None:
    read = back(tmp_path, one=value, two=(value, 1))
    assert same(read["one"], value)
    assert same(read["two"], (value, 1))


@pytest.mark.parametrize("value", [object(), {1, 2}, lambda: None, Path(), np.array([object()])])
def test_what_is_no_frozen_data_is_refused(tmp_path: Path, value: Any) -> None:
    with pytest.raises((WuchtError, ValueError)):
        archive.write_values(tmp_path / "a", {"x": value})
    assert not (tmp_path / "a").exists()


def read_again(path: Path) -> Any:
    return archive.read_value(path, "x")


def test_a_file_that_is_not_whole_is_refused(tmp_path: Path) -> None:
    """Cut off anywhere, as a write that was killed leaves it, empty or missing."""
    file = tmp_path / "a"
    archive.write_values(file, {"x": (np.arange(9.0), np.arange(9))})
    whole = file.read_bytes()
    for length in range(len(whole)):
        file.write_bytes(whole[:length])
        with rejected("incomplete"):
            read_again(file)
    file.unlink()
    with rejected("incomplete"):
        read_again(file)


@pytest.mark.parametrize("name", ["os:system", "builtins:eval", "nowhere:Class", "pathlib:Path"])
def test_reading_makes_nothing_but_dataclasses(tmp_path: Path, name: str) -> None:
    crafted(tmp_path / "a", {"x": {"class": name, "fields": {}}})
    with rejected("incomplete"):
        read_again(tmp_path / "a")


def crafted(file: Path, tree: Any, array: bytes = b"") -> None:
    """A file that was not written by wucht, but well."""
    with ZipFile(file, "w") as entries:
        entries.writestr("tree.json", json.dumps(tree))
        entries.writestr("0.npy", array)


@pytest.mark.parametrize("place", ["entry", "array", "file"])
def test_pickled_numbers_are_not_read(tmp_path: Path, place: str) -> None:
    """A pickle can call any function."""
    file, evil = tmp_path / "a", pickle.dumps(Evil(tmp_path / "written"))
    np.save(tmp_path / "objects.npy", np.array([Evil(tmp_path / "written")]), allow_pickle=True)
    objects = (tmp_path / "objects.npy").read_bytes()
    if place == "file":
        file.write_bytes(evil)
    else:
        crafted(file, {"x": {"array": 0}}, evil if place == "entry" else objects)
    with rejected("incomplete"):
        read_again(file)
    assert not (tmp_path / "written").exists()
    if place == "array":
        np.load(tmp_path / "objects.npy", allow_pickle=True)
    else:
        pickle.loads(evil)
    assert (tmp_path / "written").exists(), "so that the test can fail"


class Evil:
    """What a crafted pickle is: it calls any function when it is loaded."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.target,)


@pytest.mark.skipif(sys.platform != "linux", reason="the peak is told in other units elsewhere")
def test_a_large_array_is_not_copied_to_be_written(tmp_path: Path) -> None:
    """Of 100 MB: an array as it lies in memory, and one that does not."""
    script = (
        "import resource, sys\nimport numpy as np\nfrom pathlib import Path\nfrom wucht.results import archive\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024\n"
        "whole = np.ones((2500, 5000))\nbefore = peak()\n"
        "archive.write_values(Path(sys.argv[1]), {'x': whole if sys.argv[2] == 'whole' else whole[:, ::2].T})\n"
        "print(peak() - before)"
    )
    for layout in ("whole", "part"):
        command = [sys.executable, "-c", script, str(tmp_path / "a"), layout]
        assert float(subprocess.run(command, check=True, capture_output=True, text=True).stdout) < 60


def test_numbers_of_numpy_and_complex_numbers(tmp_path: Path) -> None:
    assert back(tmp_path, a=np.float64(0.1), b=np.int64(3), c=1 + 2j) == {"a": 0.1, "b": 3, "c": 1 + 2j}
