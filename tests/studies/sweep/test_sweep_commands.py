"""``wucht run`` of sweeps, and the template."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from wucht.cli.progress import Progress

Command = Callable[..., Any]
Refused = Callable[..., str]

QUICK = ("--set", "study.range=[9.0, 10.5]", "--set", "study.rate=0.02", "--set", "study.jump_tolerance=1e-3")


@pytest.mark.usefixtures("unpainted")
def test_run_a_sweep(wucht: Command) -> None:
    done = wucht("run", "sperling-vibration/figure-5", *QUICK, "-o", "out")
    assert done.code == 0, done.err
    assert "ONE JUMP" in done.out
    assert "from 9 to 10.5 rad/s at 0.02 rad/s per s" in done.out
    summary = json.loads(Path("out/summary.json").read_text())["summary"]
    (jump,) = summary["jumps"]
    assert jump["direction"] == "up"
    assert jump["drive.no_load_speed"] == pytest.approx(9.7856, rel=1e-3)
    assert {"from_speed", "to_speed"} <= set(jump)
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "summary.json", "sweep.png"]
    assert wucht("plot", "out/result.nc").code == 0


@pytest.mark.usefixtures("unpainted")
def test_ctrl_c_leaves_a_valid_sweep(wucht: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = iter(range(1, 10**9))

    def update(_self: Progress, _reached: float, _goal: float) -> None:
        if next(calls) == 3:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Progress, "update", update)
    done = wucht("run", "sperling-vibration/figure-5", "-o", "out")
    assert done.code == 130
    assert "interrupted" in done.err
    assert "Traceback" not in done.err
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0


@pytest.mark.usefixtures("no_figures")
def test_resume_of_an_interrupted_sweep_continues(wucht: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as m:
        m.setattr(Progress, "update", lambda *_: signal.raise_signal(signal.SIGINT))
        assert wucht("run", "sperling-vibration/figure-5", *QUICK, "-o", "out").code == 130
    done = wucht("run", "sperling-vibration/figure-5", *QUICK, "-o", "out", "--resume")
    assert done.code == 0
    assert "interrupted" not in done.err


@pytest.mark.usefixtures("no_figures")
@pytest.mark.slow
def test_the_template_runs(wucht: Command) -> None:
    assert wucht("new", "sweep").code == 0
    done = wucht("run", "sweep.toml", "--set", "study.rate=1", "-o", "out")
    assert done.code == 0, done.err
    assert "verdict" in done.out


@pytest.mark.parametrize("rate", ["1e-30", "1e30", "1e-320", "1e29"])
def test_a_rate_that_takes_forever_or_no_time_is_refused(wucht: Command, refused: Refused, rate: str) -> None:
    assert wucht("new", "sweep").code == 0
    refused("run", "sweep.toml", "--set", f"study.rate={rate}", says=("sweep.toml", "study.rate", "must be a rate from"))


def test_bad_input_says_where(refused: Refused) -> None:
    refused("run", "sperling-vibration/figure-5", "--set", "study.along=drive.sloped", says=("study.along", "drive.slope"))
    refused("run", "sperling-vibration/figure-5", "--set", "study.range=[3, 1]", says=("study.range", "low below high"))
