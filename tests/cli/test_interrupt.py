"""Ctrl-C, SIGTERM and kill -9: what was computed stays readable and can be continued."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht.cli.progress import Progress
from wucht.cli.surroundings import interrupt_check

Command = Callable[..., Any]
Study = Callable[..., Path]
Refused = Callable[..., str]

LONG = ('until = "0.5 s"', 'until = "100000 s"')
MINUTES = ('until = "0.5 s"', 'until = "1000 s"')
PARTIAL = ["result.partial.nc", "run-up.partial.png", "summary.partial.json", "units"]
pytestmark = pytest.mark.usefixtures("unpainted")
POSIX = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


def _load(file: str | Path) -> xr.Dataset:
    return xr.load_dataset(file, engine="h5netcdf")


@pytest.fixture
def signal_at(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """``signal_at(3)``: the third report of progress is answered with Ctrl-C (or another signal)."""
    before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}

    def arm(count: int, number: int = signal.SIGINT) -> None:
        calls = iter(range(1, 10**9))

        def update(_self: Progress, _reached: float, _goal: float) -> None:
            if next(calls) == count:
                signal.raise_signal(number)

        monkeypatch.setattr(Progress, "update", update)

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that an unhandled one does not end pytest
    yield arm
    for number, handler in before.items():
        signal.signal(number, handler)


def test_ctrl_c_leaves_a_valid_result(wucht: Command, study: Study, signal_at: Callable[..., None]) -> None:
    signal_at(3)
    completed = wucht("run", study(*MINUTES), "-o", "out", "--json")
    assert completed.code == 130
    assert "Traceback" not in completed.err
    assert any("--resume" in warning for warning in completed.document["warnings"])
    assert completed.document["summary"]["outcome"] == "unidentified"
    actual = _load("out/result.partial.nc")
    assert actual.attrs["finished"] == 0
    assert actual.sizes["time"] > 1
    assert np.isfinite(actual.angle.values).all()
    assert sorted(p.name for p in Path("out").iterdir()) == PARTIAL
    assert json.loads(Path("out/summary.partial.json").read_text()) == completed.document
    assert wucht("plot", "out").out == "out/run-up.partial.png\n"


@pytest.mark.usefixtures("no_figures")
@POSIX
def test_a_batch_system_ends_it_like_ctrl_c(wucht: Command, study: Study, signal_at: Callable[..., None]) -> None:
    signal_at(2, signal.SIGTERM)
    completed = wucht("run", study(*MINUTES), "-o", "out", "--json")
    assert completed.code in (130, 143)
    assert _load("out/result.partial.nc").attrs["finished"] == 0


QUESTIONS = {"settled": "settled = true", "radau": 'until = "0.5 s"\nengine = "radau"'}


# The others are resumed as what must settle is, which also looks for its end.
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    "question",
    [pytest.param(q, id=name, marks=pytest.mark.slow if name != "settled" else ()) for name, q in QUESTIONS.items()],
)
def test_a_resumed_run_is_the_uninterrupted_one(
    wucht: Command, study: Study, signal_at: Callable[..., None], question: str
) -> None:
    file = study(LONG[0], question)
    whole = wucht("run", file, "-o", "whole", "--json").document
    signal_at(2)
    assert wucht("run", file, "-o", "parts", "--json").code == 130
    part = _load("parts/result.partial.nc")
    assert 0 < part.attrs["end_time"] < _load("whole/result.nc").attrs["end_time"]
    completed = wucht("run", file, "-o", "parts", "--json", "--resume")
    assert completed.code == 0, completed.err
    expected, actual = _load("whole/result.nc"), _load("parts/result.nc")
    assert actual.attrs["finished"] == 1
    np.testing.assert_allclose(actual.time, expected.time, rtol=0, atol=1e-9)
    for name in ("angle", "speed", "supplied_work", "dissipated_work"):
        np.testing.assert_allclose(actual[name], expected[name], rtol=1e-6, atol=1e-6)
    summary = completed.document["summary"]
    assert summary["outcome"] == whole["summary"]["outcome"]
    assert summary["final_speed"] == pytest.approx(whole["summary"]["final_speed"], rel=1e-9)
    assert summary["final_phases"] == pytest.approx(whole["summary"]["final_phases"], abs=1e-6)
    assert summary["energy_residual"] < 1e-9
    assert not any("interrupted" in warning for warning in completed.document["warnings"])


@pytest.mark.usefixtures("no_figures")
def test_resume_refuses_the_result_of_another_kind_of_study(wucht: Command, refused: Refused, study: Study) -> None:
    file = study('"0.5 s"', '"0.02 s"')
    assert wucht("run", file, "-o", "out").code == 0
    kept = Path("out/result.nc").read_bytes()
    says = ("--resume", "answers study.kind = 'run-up'", "torque-balance")
    refused("run", file, "-o", "out", "--resume", "--set", "study.kind=torque-balance", says=says)
    assert Path("out/result.nc").read_bytes() == kept


OTHERS = {
    "mass": (("--set", "p1.mass=0.13"), ()),
    "tolerance": (("--set", "study.tolerance=1e-9"), ()),
    "directions": ((), ('"1 kg"', '"1 kg"\ndirections = "x"')),
}


# A value, what the machine consists of, and the question: one each.
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(("words", "changes"), OTHERS.values(), ids=OTHERS)
def test_resume_refuses_another_run(
    wucht: Command, refused: Refused, study: Study, words: tuple[str, ...], changes: tuple[str, ...]
) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    before = Path("out/result.nc").read_bytes()
    refused("run", study('"0.5 s"', '"0.02 s"', *changes), "-o", "out", "--json", "--resume", *words, says=("--resume",))
    assert Path("out/result.nc").read_bytes() == before


def test_ctrl_c_before_the_run(wucht: Command, study: Study) -> None:
    """While a module of the user's own is imported."""
    Path("own.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    completed = wucht("run", study(), "-o", "out", "--json", "--import", "own.py")
    assert (completed.code, completed.err) == (130, "wucht: interrupted\n")
    assert (completed.document["error"], completed.document["exit_code"]) == ("interrupted", 130)


# As a process of its own


def test_a_later_signal_is_answered_before_the_step_is_done(capfd: pytest.CaptureFixture[str]) -> None:
    with interrupt_check() as check:
        check()
        signal.raise_signal(signal.SIGINT)
        assert "stopping" in capfd.readouterr().err
        with pytest.raises(KeyboardInterrupt):
            check()


def test_a_library_that_fails_on_ctrl_c_is_an_interruption() -> None:
    """An import that Ctrl-C cuts off half-way says something else."""
    with pytest.raises(KeyboardInterrupt), interrupt_check():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None


@pytest.mark.usefixtures("no_figures")
def test_writing_that_is_cut_off_leaves_the_earlier_result(
    wucht: Command, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert wucht("run", study('"0.5 s"', '"0.01 s"'), "-o", "out", "--json").code == 0
    before = Path("out/result.nc").read_bytes()

    def half(path: Path, whole: bytes) -> None:
        with path.open("wb") as file:
            file.write(whole[: len(whole) // 2])
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", half)
        completed = wucht("run", study(), "-o", "out", "--json")
    assert completed.code == 130
    stays = "there is no result yet, and --resume continues from there; the earlier result, out/result.nc, is unchanged"
    assert completed.err.endswith(f"wucht: interrupted: {stays}\n")
    assert Path("out/result.nc").read_bytes() == before
    assert wucht("run", study(), "-o", "out", "--json").code == 0
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "run-up.png", "summary.json"]


def test_what_fails_by_itself_is_no_interruption() -> None:
    with pytest.raises(ImportError), interrupt_check():
        raise ImportError("no such module")
