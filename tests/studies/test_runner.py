"""The runner of all studies: units of work are remembered, results are saved, questions are told apart."""

from __future__ import annotations

import gc
import itertools
import json
import shutil
import time
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from interrupting import assert_same
from wucht import InputError, Response, RunUp, SynchronousStates, load_machine
from wucht.dynamics.work import Work
from wucht.extending import Answer, Study
from wucht.plots.sheet import save_figure
from wucht.results.output_folder import load_result
from wucht.schema import si
from wucht.studies import runner
from wucht.studies.memory import UnitMemory
from wucht.studies.subjects import Description


class Numbers:
    """A subject that is no machine: a list of numbers."""

    def from_document(self, document: Any, path: Path, name: str, settings: Any) -> Any:
        return document["numbers"], {"numbers": document["numbers"]}

    def describe(self, subject: Any) -> Description:
        return Description("numbers", True, {"numbers": list(subject)}, ("they are few",))


NUMBERS = Numbers()
computed: list[str] = []


@dataclass(frozen=True)
class Square:
    value: float
    noise: np.ndarray


class Squares(Study):
    """Squares, one at a time."""

    kind: ClassVar[str] = ""
    subject: ClassVar[str] = f"{__name__}:NUMBERS"
    horizon: ClassVar[tuple[str, ...]] = ("count",)

    count: float = si("", "count", default=10, gt=0)
    times: float = si("", "factor", default=1.0)

    def prepare(self, subject: list[float]) -> list[float]:
        if not subject:
            raise InputError("numbers", subject, "must be a number at least")
        return subject[: int(self.count)]

    def solve(self, subject: list[float], numbers: list[float], work: Work) -> Iterator[Answer]:
        squares: tuple[Square, ...] = ()
        yield self.answer(squares)
        for k, x in enumerate(numbers):

            def compute(x: float = x, k: int = k) -> Square:
                computed.append(f"square {k}")
                return Square(self.times * x * x, np.random.default_rng(k).normal(size=3))

            squares = (*squares, work.unit(f"square {k}", compute))
            work.report((k + 1) / len(numbers), f"square {k}")
            yield self.answer(squares)

    def answer(self, squares: tuple[Square, ...]) -> Answer:
        a = Answer()
        a.curve("square", [s.value for s in squares], "square", "", "number")
        a.curve("noise", np.array([s.noise for s in squares]).reshape(-1, 3), "noise", "", "number component")
        a.line("sum", f"{a.number('sum', sum(s.value for s in squares), 'sum'):g}")
        a.sentence = "done"
        a.warn("squares are large")
        a.failure = "it is negative" if self.times < 0 else None
        return a

    def draw(self, result: xr.Dataset) -> Any:
        raise ValueError("a bug of the figure")


@pytest.fixture(autouse=True)
def _study() -> Iterator[None]:
    """The study has a name while these tests run: others list those of the package."""
    Squares.kind = "squares"
    computed.clear()
    yield
    Squares.kind = ""


ask = runner.run


class Stop:
    """Ctrl-C at the n-th report."""

    def __init__(self, at: int) -> None:
        self.left, self.shares = at, list[float]()

    def __call__(self, share: float, what: str) -> None:
        self.shares.append(share)
        self.left -= 1
        if not self.left:
            raise KeyboardInterrupt


def test_what_every_result_has(tmp_path: Path) -> None:
    result = ask(Squares(count=3), [1.0, 2.0, 3.0], folder=tmp_path, document={"a": 1})
    assert {"study", "finished", "failure", "input", "versions", "created", "elapsed_s"} <= set(result.attrs)
    assert result.wucht.warnings == ["they are few", "squares are large"]
    assert (result.attrs["title"], result.attrs["dimensionless"], result.attrs["finished"]) == ("numbers", 1, 1)
    assert json.loads(result.attrs["input"])["study"] == {"kind": "squares", "count": 3.0, "times": 1.0}
    assert result.wucht.summary == {"sentence": "done", "sum": 14.0} and runner.report(result)[-1] == "  sum          14"
    assert load_result(tmp_path / "result.nc").equals(result)
    computed.clear()
    (tmp_path / "units").mkdir()  # as a kill leaves it
    again = ask(Squares(count=3), [1.0, 2.0, 3.0], folder=str(tmp_path), resume=True)
    assert again.equals(result) and again.attrs["created"] == result.attrs["created"] and not computed
    assert sorted(p.name for p in tmp_path.iterdir()) == ["result.nc"], "units are forgotten once the study is finished"


@pytest.mark.parametrize("at", [1, 2, 5])
def test_interrupted_and_resumed_it_is_the_uninterrupted_one(tmp_path: Path, at: int) -> None:
    numbers = [1.0, 2.0, 3.0, 4.0, 5.0]
    whole = ask(Squares(), numbers)
    computed.clear()
    part = ask(Squares(), numbers, folder=tmp_path, progress=Stop(at))
    assert part.attrs["finished"] == 0
    assert part.sizes["number"] == at - 1
    assert any("--resume" in w for w in part.wucht.warnings)
    assert load_result(tmp_path / "result.partial.nc").attrs["finished"] == 0
    again = ask(Squares(), numbers, folder=tmp_path, resume=True)
    assert computed == [f"square {k}" for k in range(5)], "no unit is computed twice"
    assert_same(again, whole)


@pytest.mark.parametrize(
    ("spec", "subject"), [(Squares(times=2.0), [1.0, 2.0]), (Squares(), [1.0, 3.0])], ids=["key", "subject"]
)
@pytest.mark.parametrize("at", [2, 99])
def test_another_question_is_refused(tmp_path: Path, spec: Squares, subject: list[float], at: int) -> None:
    ask(Squares(), [1.0, 2.0], folder=tmp_path, progress=Stop(at))
    [file] = tmp_path.glob("result*.nc")
    before = file.read_bytes()
    with refused("--resume", "was 1.0, now 2.0" if subject == [1.0, 2.0] else "[1.0, 3.0]", code="other-question"):
        ask(spec, subject, folder=tmp_path, resume=True)
    assert file.read_bytes() == before


@pytest.mark.parametrize("at", [2, 99])
def test_one_that_only_goes_further_is_begun_anew(tmp_path: Path, at: int) -> None:
    ask(Squares(count=2), [1.0, 2.0, 3.0], folder=tmp_path, progress=Stop(at))
    computed.clear()
    result = ask(Squares(count=3), [1.0, 2.0, 3.0], folder=tmp_path, resume=True)
    assert len(computed) == 3
    assert any("study.count" in w and "restarted" in w for w in result.wucht.warnings)


def test_without_resume_a_folder_is_begun_anew(tmp_path: Path) -> None:
    ask(Squares(), [1.0, 2.0], folder=tmp_path, progress=Stop(2))
    computed.clear()
    ask(Squares(), [1.0, 2.0], folder=tmp_path)
    assert computed == ["square 0", "square 1"]


def test_what_is_no_question_is_refused() -> None:
    with refused("study", "wucht.RunUp", given="run-up"):
        runner.run("run-up", load_machine("drozdetskaya-2020/r1"))  # type: ignore[arg-type]


@pytest.mark.slow
def test_figures_do_not_depend_on_each_other_nor_on_the_users_settings(tmp_path: Path) -> None:
    """A figure is the same whatever was drawn before it, and changes no setting of matplotlib."""
    import matplotlib as mpl

    machine = load_machine("sperling-rollers/table-1")
    states = runner.run(
        SynchronousStates(speed=80.0, axes={"speed": [60.0, 100.0, 4], "ratio": [0.5, 2.0, 3]}, full=False), machine
    )
    response = runner.run(Response(), load_machine("drozdetskaya-2020/r1"))
    before = dict(mpl.rcParams)
    alone = save_figure(runner.draw(states), tmp_path / "alone.png").read_bytes()
    runner.draw(response)
    assert dict(mpl.rcParams) == before
    with mpl.rc_context({"font.size": 20, "axes.linewidth": 3}):
        assert save_figure(runner.draw(states), tmp_path / "after.png").read_bytes() == alone


def test_bad_input_makes_no_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        ask(Squares(), [], folder=tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_a_result_that_is_not_complete_is_saved_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = itertools.count(step=100.0)
    monkeypatch.setattr(time, "perf_counter", lambda: next(ticks))  # never too soon for the next one
    seen: list[tuple[int, int]] = []

    def look(_share: float, _what: str) -> None:
        assert not (tmp_path / "result.nc").exists(), "it takes its place when it is complete"
        if (tmp_path / "result.partial.nc").exists():
            saved = load_result(tmp_path / "result.partial.nc")
            seen.append((saved.attrs["finished"], saved.sizes["number"]))
        time.sleep(0.01)

    ask(Squares(), [1.0, 2.0, 3.0, 4.0], folder=tmp_path, progress=look)
    assert seen
    assert all(finished == 0 for finished, _ in seen)
    assert [path.name for path in tmp_path.iterdir()] == ["result.nc"]


@pytest.mark.slow
def test_results_saved_on_the_way_are_freed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where Python collects seldom, as on the command line: of a map of a million cells each takes 25 MB."""
    unfinished = list[weakref.ref[np.ndarray]]()

    def save(result: xr.Dataset, folder: Path) -> None:
        assert all(earlier() is None for earlier in unfinished)
        unfinished.append(weakref.ref(result.noise.values))
        saving(result, folder)

    saving = runner.save_partial
    monkeypatch.setattr(runner, "save_partial", save)
    ticks = itertools.count()
    monkeypatch.setattr(time, "perf_counter", lambda: 20.0 ** next(ticks))  # never too soon for the next one
    gc.disable()
    try:
        ask(Squares(), [1.0, 2.0, 3.0, 4.0], folder=tmp_path)
    finally:
        gc.enable()
    assert len(unfinished) >= 2


def test_a_failure_is_no_finished_result() -> None:
    result = ask(Squares(times=-1.0), [1.0])
    assert (result.attrs["finished"], result.attrs["failure"]) == (0, "it is negative")


def test_a_finished_result_of_another_question_is_not_handed_back(tmp_path: Path) -> None:
    """One that was killed before its first result stood in the place of the one before."""
    ask(Squares(times=2.0), [1.0, 2.0], folder=tmp_path)
    memory = UnitMemory.start(tmp_path, {"study": Squares().to_table(), "machine": {"numbers": [1.0, 2.0]}})
    memory.keep("square 0", Square(1.0, np.random.default_rng(0).normal(size=3)))
    memory.flush()
    computed.clear()
    assert ask(Squares(), [1.0, 2.0], folder=tmp_path, resume=True).wucht.summary == {"sentence": "done", "sum": 5.0}
    assert computed == ["square 1"]


def test_what_an_earlier_version_has_begun_is_not_continued(tmp_path: Path) -> None:
    """Version 0.2.0 stored units with Zarr, 0.1.0 an unfinished ``result.nc``. Without resume nothing is left of it."""
    ask(Squares(), [1.0, 2.0], folder=tmp_path, progress=Stop(2))
    (tmp_path / "result.partial.nc").rename(tmp_path / "result.nc")
    for begun in ("units", "result.nc"):
        if begun == "units":
            (store := tmp_path / "units" / f"{7:016x}").mkdir()
            (store / "zarr.json").write_text("{}", encoding="utf-8")
            for file in (tmp_path / "units").glob("*.npz"):
                file.unlink()
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        with refused("--resume", str(tmp_path), given=None, code="earlier-version"):
            ask(Squares(), [1.0, 2.0], folder=tmp_path, resume=True)
        assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
        if begun == "units":
            shutil.rmtree(store)
    assert ask(Squares(), [1.0, 2.0], folder=tmp_path).wucht.finished
    assert [path.name for path in tmp_path.iterdir()] == ["result.nc"]


# Figures and reports


def test_a_bug_of_a_figure_is_no_incomplete_result() -> None:
    result = ask(Squares(), [3.0])
    with pytest.raises(ValueError, match="a bug of the figure"):
        runner.draw(result)
    with refused("squares", given=None):
        runner.draw(result.drop_vars("noise"))
    with refused("study", given="nothing"):
        runner.draw(result.assign_attrs(study="nothing"))


# Parts of work


def test_parts_share_the_progress_and_name_their_units() -> None:
    stop, memory, names = Stop(-1), UnitMemory(), list[str]()
    work = Work(memory, stop)
    first, second = work.part("a", 0.0, 0.5), work.part("b", 0.5, 1.0)
    first.report(0.5)
    second.part("c", 0.0, 0.5).report(1.0)
    second.report(2.0)
    assert stop.shares == [0.25, 0.75, 1.0]
    names.append(second.part("c", 0, 1).name)
    assert names == ["b/c/"]


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.0, 1e3])
def test_no_result_depends_on_the_clock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: float) -> None:
    """A machine so slow that every unit is written and every finding saved gives the bits of one that is never interrupted."""
    machine = load_machine("practice/grinder-10-balls")
    asked = RunUp(until=2.0)
    alone = ask(asked, machine)
    ticks = itertools.count()
    monkeypatch.setattr(time, "perf_counter", lambda: step * next(ticks))
    loaded = ask(asked, machine, folder=tmp_path)
    assert set(loaded.variables) == set(alone.variables)
    for name in alone.variables:
        assert np.array_equal(loaded[name].values, alone[name].values, equal_nan=loaded[name].dtype.kind == "f"), name
    assert loaded.attrs["summary"] == alone.attrs["summary"]
