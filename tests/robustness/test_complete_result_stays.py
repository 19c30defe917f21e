"""A complete result is replaced by a complete one only: what was stopped, killed or failed lies beside it."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from tests.interrupting import assert_same, stop_at
from tests.robustness import children

import wucht as package

R1, FIGURE_5 = "drozdetskaya-2020/r1", "sperling-vibration/figure-5"
AXES = {"psi": [0.0, 6.28, 4], "delta": [0.0, 3.14, 2]}
QUESTIONS: dict[str, tuple[str, dict[str, Any], str]] = {  # the last: during which work they are stopped
    "run-up": (R1, {"study.until": 30.0}, ""),
    "sweep": (FIGURE_5, {"study.range": [9.0, 9.2], "study.rate": 0.02, "study.jump_tolerance": 1e-2}, ""),
    "basin": (
        R1,
        {"study.kind": "basin", "study.axes": AXES, "study.start": {}, "study.until": 20.0, "study.refine": 1},
        "borders",
    ),
}
UNITS = 6
OWN_STUDY = Path(__file__).parents[2] / "examples" / "own_study.py"
SLOW_STUDY = f"""
    def solve(self, machine, vibration, work):
        for k in range({UNITS}):
            what = os.environ["WHAT"] if str(k) == os.environ.get("AT") else ""
            if what == "memory":
                raise MemoryError
            if what and what != "failure":
                os.kill(os.getpid(), int(what))
            if os.environ["WHAT"] == "{int(signal.SIGKILL)}" and k == 1:
                time.sleep(2.1)  # units are written every two seconds
            work.report(k / {UNITS}, "poles")
            (answer,) = self.quick_solve(machine, vibration, work.part(str(k), k / {UNITS}, (k + 1) / {UNITS}))
            answer.failure = "the poles are lost" if what == "failure" else None
            yield answer
            if answer.failure:
                return
"""


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """A folder with a complete result in ``out``, and a study that ends in many ways."""
    children.load_everything()
    text = OWN_STUDY.read_text(encoding="utf-8").replace("def solve(", "def quick_solve(")
    text = text.replace("import numpy", "import os\nimport time\n\nimport numpy", 1)
    (tmp_path / "my_study.py").write_text(text + SLOW_STUDY, encoding="utf-8")
    assert poles(tmp_path).code == 0
    assert set(complete(tmp_path / "out")) == {"result.nc", "poles.png", "summary.json"}
    return tmp_path


def poles(place: Path, *words: str, at: int = -1, what: int | str = 0) -> children.Ended:
    """The study in a process of its own. what: happens before the unit of this number."""

    def run() -> int:
        os.environ.update(AT=str(at), WHAT=str(int(what) if isinstance(what, int) else what))
        return children.wucht(
            "run", "practice/laundry-drum", "--import", "my_study.py", "--set", "study.kind=poles", "-o", "out", *words
        )()

    return children.call(run, place)


def complete(folder: Path) -> dict[str, bytes]:
    """The files of the complete result in a folder."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file() and ".partial." not in p.name and p.name[0] != "."}


def names(folder: Path) -> set[str]:
    """The files and folders in a folder."""
    return {path.name for path in folder.iterdir()}


OTHER = ("--set", "study.below=1e4")
EARLIER = "; the earlier result, out/result.nc, is unchanged"
NOTHING = "there is no result yet, and nothing to continue"
PARTIAL = {"result.partial.nc", "poles.partial.png", "summary.partial.json", "units"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", QUESTIONS)
def test_stopped_twice_it_lies_beside_and_is_continued(tmp_path: Path, kind: str) -> None:
    """Single runs, sweeps and maps: in the end it is the uninterrupted one, to the last bit."""
    out, (name, question, during) = tmp_path / "out", QUESTIONS[kind]
    package.run_file(R1, {"study.until": 1.0}, folder=out)
    before, whole = complete(out), package.run_file(name, question)
    for at, resume in ((4, False), (5, True)):
        part = package.run_file(name, question, folder=out, resume=resume, progress=stop_at(at, during))
        assert not part.wucht.finished
        assert package.load(out / "result.partial.nc").identical(part)
        assert complete(out) == before and package.load(out).wucht.finished
    last = package.run_file(name, question, folder=out, resume=True)
    for result in (last, package.load(out)):
        assert_same(result, whole)
    assert names(out) == {"result.nc"}


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_a_second_run(begun: Path, number: int) -> None:
    """Both are named, then and where it is continued."""
    out = begun / "out"
    before = complete(out)
    stopped = poles(begun, *OTHER, at=3, what=number)
    assert stopped.code == 130
    part = "what was computed so far is in out/result.partial.nc, and --resume continues from there"
    assert stopped.sentence == f"wucht: interrupted: {part}{EARLIER}"
    assert "files: out/result.partial.nc, poles.partial.png, summary.partial.json\n" in stopped.out
    assert complete(out) == before and names(out) - set(before) == PARTIAL
    summary = json.loads((out / "summary.partial.json").read_text(encoding="utf-8"))
    assert set(summary["files"]) == {f"out/{name}" for name in PARTIAL - {"units"}}
    again = poles(begun, *OTHER, "--resume")
    assert again.code == 0
    assert "the unfinished run in out is continued; out/result.nc, which is complete, stays until it ends\n" in again.err
    assert names(out) == set(before) and complete(out).keys() == before.keys()
    assert package.load(out).wucht.question["study"]["below"] == 1e4


@pytest.mark.slow
def test_killed_in_a_second_run(begun: Path) -> None:
    before = complete(begun / "out")
    assert poles(begun, *OTHER, at=3, what=signal.SIGKILL).code == -signal.SIGKILL
    assert complete(begun / "out") == before
    again = poles(begun, *OTHER, "--resume")
    assert again.code == 0 and "the unfinished run in out is continued" in again.err
    assert names(begun / "out") == set(before)


@pytest.mark.slow
def test_a_second_run_that_fails(begun: Path) -> None:
    """With a sentence of its own, or for want of memory."""
    before = complete(begun / "out")
    failed = poles(begun, *OTHER, at=3, what="failure")
    assert failed.code == 1
    assert failed.sentence == f"wucht: the poles are lost. What was computed so far is in out/result.partial.nc{EARLIER}"
    assert complete(begun / "out") == before
    assert package.load(begun / "out" / "result.partial.nc").attrs["failure"] == "the poles are lost"
    assert poles(begun, *OTHER, at=3, what="memory").code == 1
    assert complete(begun / "out") == before


@pytest.mark.slow
def test_before_the_first_result_no_file_is_promised(begun: Path) -> None:
    out = begun / "out"
    before = complete(out)
    stopped = poles(begun, *OTHER, at=0, what=signal.SIGINT)
    assert (stopped.code, names(out)) == (130, set(before))
    assert stopped.sentence == f"wucht: interrupted: {NOTHING}{EARLIER}"
    assert complete(out) == before
    assert "saved" not in stopped.err
    again = poles(begun, *OTHER, "--resume")
    assert again.code == 2 and "answers another question: study.below was not given, now 10000.0" in again.sentence


@pytest.mark.slow
def test_one_rule_also_for_the_first_run(begun: Path) -> None:
    """What reads a folder finds the part where there is no complete result; a new run begins without it."""
    (begun / "out").rename(begun / "earlier")
    assert poles(begun, at=3, what=signal.SIGINT).code == 130
    assert names(begun / "out") == PARTIAL
    for words, written in ((("plot", "out"), "out/poles.partial.png"), (("report", "out"), "report.html")):
        shown = children.call(children.wucht(*words, "--import", "my_study.py"), begun)
        assert (shown.code, shown.out) == (0, f"{written}\n"), shown.err
    shown = children.call(children.wucht("plot", "out/result.nc", "--import", "my_study.py"), begun)
    assert "there is no such file; the run is not complete: what it has so far is out/result.partial.nc" in shown.sentence
    csv = children.call(children.wucht("export", "out", "--csv", "--import", "my_study.py"), begun)
    assert csv.out.split() == [f"out/poles-{name}.partial.csv" for name in ("pole", "poles", "numbers")]
    # They are of this result, as its figures are: the next one removes them.
    assert poles(begun, at=0, what=signal.SIGINT).sentence == f"wucht: interrupted: {NOTHING}"
    assert not (begun / "out").exists() or not names(begun / "out")


@pytest.mark.slow
def test_both_questions_of_a_folder_are_answered(begun: Path) -> None:
    """The complete result of one, and the other, which was stopped; a third one is refused, and leaves both."""
    out = begun / "out"
    assert poles(begun, *OTHER, at=3, what=signal.SIGINT).code == 130
    files = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    third = poles(begun, "--set", "study.below=1e5", "--resume")
    assert third.code == 2 and "study.below was 10000.0, now 100000.0" in third.sentence
    assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == files
    first = poles(begun, "--resume")
    assert first.code == 0 and "the result in out is complete: it is not computed again" in first.err
    assert (out / "result.partial.nc").read_bytes() == files["result.partial.nc"]
    assert poles(begun, *OTHER, "--resume").code == 0
    assert names(out) == {"result.nc", "poles.png", "summary.json"}


@pytest.mark.slow
def test_the_same_question_again_is_continued_too(begun: Path) -> None:
    before = complete(begun / "out")
    assert poles(begun, at=3, what=signal.SIGINT).code == 130
    assert complete(begun / "out") == before
    again = poles(begun, "--resume")
    assert again.code == 0 and "the unfinished run in out is continued" in again.err
    assert names(begun / "out") == set(before)


@pytest.mark.slow
def test_what_an_earlier_version_left_unfinished_is_begun_anew(begun: Path) -> None:
    """It wrote an incomplete result as ``result.nc``, and units with Zarr: a sentence, and they stay until the next run."""
    out = begun / "out"
    assert poles(begun, *OTHER, at=3, what=signal.SIGINT).code == 130
    for path in out.glob("*.partial.*"):
        path.rename(out / path.name.replace(".partial", ""))
    for file in (out / "units").iterdir():
        store = file.with_name(file.name[:16])
        store.mkdir(exist_ok=True)
        file.rename(store / "zarr.json")
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    refused = poles(begun, *OTHER, "--resume")
    assert refused.code == 2 and "the unfinished run in out was begun by an earlier version of wucht" in refused.sentence
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert poles(begun, *OTHER).code == 0
    assert names(out) == {"result.nc", "poles.png", "summary.json"} and package.load(out).wucht.finished
