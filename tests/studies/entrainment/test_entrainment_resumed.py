"""The study ``entrainment`` stopped and resumed: what it keeps, to the last bit, and that no run is made again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from wucht import Entrainment, InputError, Machine, load_machine, run
from wucht.dynamics.entrainment.existence import Continuation
from wucht.dynamics.entrainment.locked_motions import LockedMotions
from wucht.dynamics.entrainment.runs_from_start import RunsFromStart
from wucht.results import output_folder
from wucht.results.output_folder import load_result
from wucht.studies import runner

WORK = {"runs": (RunsFromStart, "__call__"), "branches": (Continuation, "follow_branch"), "motions": (LockedMotions, "motion")}


def bild_2() -> Machine:
    return load_machine("sperling-vibration/figure-2a")


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> Iterator[Counter[str]]:
    """How many runs, branches and locked motions have been computed to their end."""
    count: Counter[str] = Counter()

    def counted(name: str, genuine: Callable[..., object]) -> Callable[..., object]:
        def call(*values: object) -> object:
            computed = genuine(*values)
            count[name] += 1
            return computed

        return call

    for name, (owner, method) in WORK.items():
        monkeypatch.setattr(owner, method, counted(name, getattr(owner, method)))
    yield count


def stop(made: Counter[str], name: str, after: int) -> Callable[[float, str], None]:
    """Ctrl-C at the first report after so many of them."""

    def report(_share: float, _what: str) -> None:
        if made[name] >= after:
            raise KeyboardInterrupt

    return report


WHOLE: dict[str, tuple[xr.Dataset, dict[str, int]]] = {}


def uninterrupted(question: Entrainment, file: str, made: Counter[str]) -> tuple[xr.Dataset, dict[str, int]]:
    """The result of a machine of the catalogue, and how much had to be computed."""
    if file not in WHOLE:
        WHOLE[file] = run(question, load_machine(file)), dict(made)
        made.clear()
    return WHOLE[file]


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    """To the last bit, with the answer."""
    alike = [np.array_equal(one[n].values, other[n].values, equal_nan=one[n].dtype.kind == "f") for n in one.variables]
    attributes = [one.attrs[k] == other.attrs[k] for k in ("summary", "sentence", "warnings", "finished")]
    return set(one.variables) == set(other.variables) and all(alike) and all(attributes)


def test_a_study_that_is_interrupted_keeps_what_it_has(made: Counter[str]) -> None:
    result = run(Entrainment.from_table({"points": 9}), bild_2(), progress=stop(made, "runs", 4))
    assert result.attrs["finished"] == 0
    assert result.sizes["run"] == 3  # the machine's own value is not yet reached by the scan
    s = result.wucht.summary
    assert s["sentence"].endswith("the study was interrupted before its band was determined")
    assert "3 runs from the start are finished, but the search is not" in result.attrs["warnings"]
    assert "only a run with a folder can be resumed" in result.attrs["warnings"]
    assert s["existence_band"] is not None
    assert s["band_from_rest"] is None


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    [
        "sperling-vibration/figure-2a",
        pytest.param("sperling-vibration/self-synchronisation-soft-unequal", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    ("name", "after"),
    [
        pytest.param("runs", 1, marks=pytest.mark.slow),
        pytest.param("branches", 1, marks=pytest.mark.slow),
        pytest.param("runs", 6, marks=pytest.mark.slow),
        ("runs", 20),
        ("motions", 3),
    ],
    ids=str,
)
def test_resumed_it_is_the_uninterrupted_one(file: str, name: str, after: int, tmp_path: Path, made: Counter[str]) -> None:
    """From the folder, with all the runs, branches and locked motions that were made."""
    machine, question = load_machine(file), Entrainment.from_table({"points": 6, "resolution": 0.2})
    whole, needed = uninterrupted(question, file, made)
    broken = run(question, machine, folder=tmp_path / "broken", progress=stop(made, name, after))
    assert broken.attrs["finished"] == 0
    assert load_result(tmp_path / "broken" / "result.partial.nc").attrs["finished"] == 0
    first = dict(made)
    assert first[name] == after
    again = run(question, machine, folder=tmp_path / "broken", resume=True)
    assert dict(made) == needed, "no more than without the interruption: what was done is not done again"
    assert same(again, whole)
    assert again.attrs["finished"] == 1
    made.clear()
    assert same(run(question, machine, folder=tmp_path / "broken", resume=True), whole)
    assert not made, "of a finished study nothing is left to do"


@pytest.mark.slow
def test_interrupted_again_and_again(tmp_path: Path, made: Counter[str]) -> None:
    question = Entrainment.from_table({"points": 6, "resolution": 0.2})
    whole, needed = uninterrupted(question, "sperling-vibration/figure-2a", made)
    for after in range(1, 60, 9):
        result = run(question, bild_2(), folder=tmp_path, resume=True, progress=stop(made, "runs", after))
        if result.attrs["finished"]:
            break
    assert after > 10
    result = run(question, bild_2(), folder=tmp_path, resume=True)
    assert same(result, whole)
    assert dict(made) == needed


@pytest.mark.slow
def test_only_the_same_question_is_resumed(tmp_path: Path, made: Counter[str]) -> None:
    machine = bild_2()
    run(Entrainment.from_table({"points": 5, "resolution": 0.5}), machine, folder=tmp_path, progress=stop(made, "runs", 3))
    others: list[tuple[Machine, dict[str, object], str]] = [
        (machine, {"resolution": 0.4}, "study.resolution was 0.5, now 0.4"),
        (machine, {"points": 6}, "study.points was 5, now 6"),
        (machine, {"range": [4.0, 7.0]}, r"study.range was not given, now \[4.0, 7.0\]"),
        (machine, {"until": 100.0}, "study.until was not given, now 100.0"),
        (machine.with_values({"rotor.inertia": 1.0}), {}, "rotor.inertia was 1e-05, now 1.0"),
    ]
    for other, keys, difference in others:
        question = Entrainment.from_table({"points": 5, "resolution": 0.5} | keys)
        with pytest.raises(InputError, match=f"--resume: the result in .* answers another question: {difference}"):
            run(question, other, folder=tmp_path, resume=True)
    done = made["runs"]
    finished = run(Entrainment.from_table({"points": 5, "resolution": 0.5}), machine, folder=tmp_path, resume=True)
    assert finished.attrs["finished"] == 1
    assert made["runs"] > done


def test_it_can_be_stopped_within_a_run() -> None:
    reports = 0

    def report(share: float, _what: str) -> None:
        nonlocal reports
        reports += 1
        if reports == 3:  # the first step is done after the machine's own run, of many legs
            assert share == 0
            raise KeyboardInterrupt

    result = run(Entrainment.from_table({"until": 3000.0}), bild_2(), progress=report)
    assert result.attrs["finished"] == 0
    assert result.wucht.summary["outcome"] == "unidentified" and result.sizes["run"] == 0
    assert [line.split()[0] for line in runner.report(result)[2:4]] == ["parameter", "assumed"]


def test_progress_rises_to_its_end_and_results_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "_SAVE_EVERY_S", 0.0)
    reports, saved, genuine = [], [], runner.save

    def save(result: xr.Dataset, path: Path) -> None:
        saved.append(result)
        genuine(result, path)

    monkeypatch.setattr(runner, "save", save)
    monkeypatch.setattr(output_folder, "save", save)
    question = Entrainment.from_table({"points": 5, "resolution": 0.5})
    run(question, bild_2(), folder=tmp_path, progress=lambda share, what: reports.append((share, what)))
    shares = [share for share, _ in reports]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert {what for _, what in reports} >= {"averaged equations", "locked motions", "drive.no_load_speed = 5.5"}
    assert len(saved) > 1
    assert {"run_value", "phase"} <= set(saved[-1])
    assert all(k.attrs["finished"] == 0 for k in saved[:-1])
