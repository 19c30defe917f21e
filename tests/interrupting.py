"""Studies that are stopped and resumed: a progress report that stops them, and whether two results are one."""

from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from wucht import run
from wucht.extending import Study
from wucht.machines.machine import Machine


def stop_at(call: int, during: str = "") -> Callable[[float, str], None]:
    """A progress report that interrupts a study when it is called for the n-th time, from 1 on, of work named ``during...``."""
    calls = count(1)

    def report(_share: float, what: str) -> None:
        if what.startswith(during) and next(calls) == call:
            raise KeyboardInterrupt

    return report


def stopped_often(question: Study, machine: Machine, folder: Path, first: int, further: int) -> xr.Dataset:
    """Stopped at its first report of these, then again and again, so many reports further each time, until it is finished."""
    result = run(question, machine, folder=folder, progress=stop_at(first))
    assert not result.attrs["finished"]
    times = 1
    while not result.attrs["finished"]:
        result = run(question, machine, folder=folder, resume=True, progress=stop_at(first + further * times))
        times += 1
        assert times < 40
    assert times > 3
    assert not (folder / "units").exists()
    return result


def stopped_at_once(question: Study, machine: Machine, folder: Path, call: int) -> xr.Dataset:
    """Stopped before there is anything to save, at this report, and then asked again to go on."""
    with pytest.raises(KeyboardInterrupt):
        run(question, machine, folder=folder, progress=stop_at(call))
    return run(question, machine, folder=folder, resume=True)


def assert_same(result: xr.Dataset, other: xr.Dataset) -> None:
    """To the last bit, with summary and warnings."""
    assert set(result.variables) == set(other.variables)
    for name in result.variables:
        a, b = result[name].values, other[name].values
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
    assert result.attrs["summary"] == other.attrs["summary"]
    assert result.attrs["warnings"] == other.attrs["warnings"]
