"""All studies from the command line: their questions spoilt, their templates run, interrupted, resumed and drawn."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from wucht.cli.progress import Progress

Refused = Callable[..., str]
Command = Callable[..., Any]
Study = Callable[..., Path]

CASES = [
    ("response", "range=[3,1]", ("study.range", "low below high")),
    ("response", "range=[-1,3]", ("study.range", "at least 0")),
    ("response", 'range=["1 kg","2 kg"]', ("study.range[0]", "this one is a mass")),
    ("response", "points=1", ("study.points", "whole number from 2")),
    ("response", "points=1e9", ("study.points", "100000")),
    ("response", "start.p1=3", ("study.start.p1", "known: carrier, drum")),
    ("torque-balance", "on=dram", ("study.on", "given 'dram'", "fan")),
    ("torque-balance", 'on=["fan"]', ("study.on", "must be a rotor")),
    ("sweep", "along=drum.name", ("study.along", "unknown parameter")),
    ("sweep", "range=[160,80]", ("study.range", "low below high")),
    ("sweep", "rate=0", ("study.rate", "greater than 0")),
    ("sweep", "direction=sideways", ("study.direction", "'both', 'up' or 'down'")),
    ("sweep", "jump_tolerance=1", ("study.jump_tolerance", "between")),
    ("coast-down", "until=0", ("study.until", "greater than 0")),
    ("coast-down", "start.drum.speed=0", ("study.start", "nothing turns")),
    ("voltage-dip", "duration=1e7", ("study.duration", "must be at most")),
]


@pytest.mark.parametrize(("kind", "setting", "says"), CASES, ids=[f"{kind}: {setting}" for kind, setting, _ in CASES])
def test_a_wrong_question(refused: Refused, wucht: Command, here: Path, kind: str, setting: str, says: tuple[str, ...]) -> None:
    assert wucht("new", kind, "my.toml").code == 0
    refused("run", "my.toml", "-o", "out", "--json", "--set", f"study.{setting}", says=("my.toml: ", *says))
    assert not Path("out").exists()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ["run-up"])
def test_a_template_runs_and_is_drawn_again(wucht: Command, here: Path, kind: str) -> None:
    assert wucht("new", kind).code == 0
    words = ("run", f"{kind}.toml", "-o", "out", "--json", "--set", "study.until=0.2")
    completed = wucht(*words)
    assert completed.code == 0, completed.err
    assert completed.document["study"] == kind
    assert sorted(p.name for p in Path("out").iterdir()) == sorted([f"{kind}.png", "result.nc", "summary.json"])
    assert json.loads(Path("out/summary.json").read_text()) == completed.document
    assert xr.load_dataset("out/result.nc", engine="h5netcdf").attrs["finished"] == 1
    for extension in ("pdf", "svg"):
        assert wucht("plot", "out/result.nc", "--format", extension).code == 0
        assert Path(f"out/{kind}.{extension}").stat().st_size > 1000
    again = wucht(*words, "--resume")
    assert again.code == 0, again.err
    assert again.document["summary"] == completed.document["summary"]


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """``interrupted(3)``: the third report of progress, after a share of the whole, is answered with Ctrl-C."""
    before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}

    def arm(count: int, share: float = 0.0) -> None:
        calls = iter(range(1, 10**9))

        def update(_self: Progress, done: float, _what: str) -> None:
            if done >= share and next(calls) == count:
                signal.raise_signal(signal.SIGINT)

        monkeypatch.setattr(Progress, "update", update)

    yield arm
    for number, handler in before.items():
        signal.signal(number, handler)


LONG = {
    "many": ("study.until=0.1", "study.along=drive.slope", "study.values=[0.03, 0.04, 0.05]"),
    "coast-down": ("study.until=100",),
    "start-stop": ("study.until=100",),
    "sweep": ("study.rate=2",),
}


# A single run is interrupted in test_interrupt.py.
@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_leaves_a_valid_result(wucht: Command, here: Path, interrupted: Callable[..., None], name: str) -> None:
    kind = "run-up" if name == "many" else name
    wucht("new", kind, "my.toml")
    settings = [word for setting in LONG[name] for word in ("--set", setting)]
    interrupted(3, 0.4 if name == "many" else 0.0)
    completed = wucht("run", "my.toml", "-o", "out", "--json", *settings)
    assert completed.code == 130, completed.err
    assert "Traceback" not in completed.err
    assert any("interrupted" in warning for warning in completed.document["warnings"])
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0


@pytest.mark.usefixtures("unpainted")
def test_ctrl_c_in_the_first_of_many_runs(wucht: Command, here: Path, interrupted: Callable[..., None]) -> None:
    wucht("new", "run-up", "my.toml")
    settings = [word for setting in LONG["many"] for word in ("--set", setting)]
    interrupted(2)
    completed = wucht("run", "my.toml", "-o", "out", "--json", *settings)
    assert completed.code == 130, completed.err
    assert xr.load_dataset("out/result.partial.nc", engine="h5netcdf").attrs["finished"] == 0
    assert wucht("plot", "out/result.partial.nc").code == 0
    assert wucht("run", "my.toml", "-o", "out", "--json", "--resume", *settings).code == 0


@pytest.mark.usefixtures("no_figures")
def test_many_runs_go_on_where_they_were_interrupted(wucht: Command, here: Path, interrupted: Callable[..., None]) -> None:
    wucht("new", "run-up", "my.toml")
    lines = [line for line in Path("my.toml").read_text().splitlines() if not line.startswith("start =")]
    Path("my.toml").write_text("\n".join([*lines, 'starts = [{ p1 = "0.3 rad" }, { p1 = "-1 rad", p2 = "90 deg" }]', ""]))
    words = ("run", "my.toml", "--json", "--set", "study.until=0.2")
    whole = wucht(*words, "-o", "whole").document["summary"]
    assert [c["label"] for c in whole["cases"]] == ["p1 = 0.3 rad", "p1 = -1 rad, p2 = 90 deg"]
    interrupted(1, 0.6)
    assert wucht(*words, "-o", "out").code == 130
    assert wucht(*words, "-o", "out", "--resume").document["summary"]["cases"] == whole["cases"]
