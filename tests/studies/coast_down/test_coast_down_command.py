"""``wucht run`` of coast-downs, and their template."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from wucht.cli.progress import Progress

Command = Callable[..., Any]
Refused = Callable[..., str]

FIGURE_7 = "sperling-vibration/figure-7"


def test_run_a_coast_down(wucht: Command) -> None:
    done = wucht("run", FIGURE_7, "--set", "study.until=30 s", "-o", "out", "--json")
    assert done.code == 0, done.err
    summary = done.document["summary"]
    assert summary["half_time"] is None
    assert summary["reversal_time"] is None
    assert summary["outcome"] is None
    assert wucht("plot", "out/result.nc").code == 0
    done = wucht("run", FIGURE_7, "--set", "study.until=30 s", "-o", "out")
    assert "still turns" in done.out


@pytest.mark.usefixtures("unpainted")
def test_ctrl_c_leaves_a_valid_result_that_is_resumed(wucht: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = iter(range(1, 10**9))

    def update(_self: Progress, _share: float, _what: str) -> None:
        if next(calls) == 3:
            signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patched:
        patched.setattr(Progress, "update", update)
        done = wucht("run", FIGURE_7, "-o", "out")
    assert done.code == 130
    assert "interrupted" in done.err
    assert "Traceback" not in done.err
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0
    again = wucht("run", FIGURE_7, "-o", "out", "--resume")
    assert again.code == 0
    assert "interrupted" not in again.err
    assert sorted(p.name for p in Path("out").iterdir()) == ["coast-down.png", "result.nc", "summary.json"]


@pytest.mark.slow
def test_the_template_runs(wucht: Command) -> None:
    assert wucht("new", "coast-down").code == 0
    done = wucht("run", "coast-down.toml", "--set", "study.until=10 s", "-o", "out")
    assert done.code == 0, done.err
    assert "verdict" in done.out


def test_bad_input_says_where(refused: Refused) -> None:
    refused("run", FIGURE_7, "--set", "study.start={}", says=("study.start", "nothing turns"))
