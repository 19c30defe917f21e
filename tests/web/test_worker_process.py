"""The process that makes pages and verdicts: the newest wins, time and memory are limited, and it comes back after its end."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.conftest import STUDY

from wucht.web.worker_process import Answer, WorkerProcess, timeout_sentence

SHORT = STUDY.replace('"0.5 s"', '"2 s"')
LONG = STUDY.replace('"0.5 s"', '"20000 s"')  # minutes


@pytest.fixture(scope="module")
def worker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorkerProcess]:
    process = WorkerProcess(tmp_path_factory.mktemp("machines"), judging=120.0)
    assert "label" in process.verdict(SHORT)
    yield process
    process.close()


def answers_of(worker: WorkerProcess, studies: list[str], pause: float) -> list[Answer]:
    """Answers to questions that are asked one after another, none of them waited for."""
    answers: dict[int, Answer] = {}
    threads = []
    for k, study in enumerate(studies):
        threads.append(threading.Thread(target=lambda k=k, study=study: answers.update({k: worker.verdict(study)})))
        threads[-1].start()
        time.sleep(pause)
    for thread in threads:
        thread.join(60)
    return [answers[k] for k in range(len(studies))]


@pytest.mark.parametrize("pause", [0.0, 0.2, 1.0])
def test_the_newest_question_is_answered_and_those_before_it_are_superseded(worker: WorkerProcess, pause: float) -> None:
    """Whether they wait or are being judged: a run of minutes ends at once."""
    begin = time.monotonic()
    *before, last = answers_of(worker, [LONG, LONG, SHORT], pause)
    assert before == [{"superseded": True}] * 2
    assert last["label"] == worker.verdict(SHORT)["label"]
    assert time.monotonic() - begin < 15


def test_a_run_that_takes_too_long_is_ended_but_not_its_process(worker: WorkerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "_judging", 0.5)
    process = worker._process
    answer = worker.verdict(LONG)
    assert answer["error"] == timeout_sentence("verdict", 0.5)
    assert "wucht run" in answer["error"]
    monkeypatch.undo()
    assert "label" in worker.verdict(SHORT)
    assert worker._process is process


def test_what_does_not_notice_the_end_of_its_time_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the derivation of the equations of many bodies: nothing in it asks how late it is."""
    monkeypatch.setattr("wucht.web.worker_process._GRACE_S", 0.5)
    many = STUDY.replace('name = "p1"', 'name = "p1"\ncount = 60').replace("p1 = ", "p11 = ")
    worker = WorkerProcess(tmp_path, judging=120.0)
    assert "label" in worker.verdict(SHORT)
    monkeypatch.setattr(worker, "_judging", 0.5)
    begin, process = time.monotonic(), worker._process
    assert process is not None
    assert worker.verdict(many)["error"] == timeout_sentence("verdict", 0.5)
    assert time.monotonic() - begin < 10
    assert process.poll() is not None
    monkeypatch.setattr(worker, "_judging", 60.0)
    assert "label" in worker.verdict(SHORT), "another process was started"
    worker.close()


def test_a_page_that_takes_too_long_says_what_makes_it(tmp_path: Path) -> None:
    """It has no study file to copy: that is what a verdict says."""
    (tmp_path / "drum.toml").write_text(STUDY, encoding="utf-8")
    worker = WorkerProcess(tmp_path, judging=0.0, making=0.0)
    assert worker.page(str(tmp_path / "drum.toml"), None) == {
        "timed_out": True, "error": "the equations of this machine take longer than 0 s: use `wucht share FILE`", "status": 503,
    }  # fmt: skip
    assert worker.machines()["error"] == "the list of machines takes longer than 0 s: use `wucht list`, and `wucht app FILE`"
    worker.close()


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such signal")
def test_a_process_that_is_killed_from_outside_is_reported_and_replaced(worker: WorkerProcess) -> None:
    answers: list[Answer] = []
    thread = threading.Thread(target=lambda: answers.append(worker.verdict(LONG)))
    thread.start()
    time.sleep(1.0)
    assert worker._process is not None
    os.kill(worker._process.pid, signal.SIGKILL)
    thread.join(20)
    assert "ran out of memory" in answers[0]["error"]
    assert "label" in worker.verdict(SHORT)


@pytest.mark.skipif(sys.platform != "linux", reason="the memory of a process is limited on Linux")
def test_the_memory_of_the_process_is_limited(worker: WorkerProcess) -> None:
    assert worker._process is not None
    limits = Path(f"/proc/{worker._process.pid}/limits").read_text(encoding="ascii")
    (line,) = [one for one in limits.splitlines() if one.startswith("Max address space")]
    assert int(line.split()[3]) <= 11_000_000_000


def test_a_run_for_which_the_memory_does_not_suffice_is_refused(worker: WorkerProcess) -> None:
    study = LONG.replace("[study]", "[study]\nstored_samples = 100000000000")
    assert "memory" in worker.verdict(study)["error"]


def test_after_its_end_nothing_is_answered(tmp_path: Path) -> None:
    worker = WorkerProcess(tmp_path, judging=120.0)
    answers: list[Answer] = []
    thread = threading.Thread(target=lambda: answers.append(worker.verdict(LONG)))
    thread.start()
    time.sleep(1.0)
    worker.close()
    thread.join(10)
    assert "stopped" in answers[0]["error"]
    assert "stopped" in worker.verdict(SHORT)["error"]


def test_no_module_is_imported_from_the_folder(tmp_path: Path) -> None:
    """A file of the folder that is called as a library must not be run."""
    for name in ("numpy", "sympy", "json", "wucht"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'w').close()\nraise SystemExit\n", encoding="utf-8")
    worker = WorkerProcess(tmp_path, judging=120.0)
    assert "label" in worker.verdict(SHORT)
    assert not (tmp_path / "imported").exists()
    worker.close()
