"""The processes that make pages and verdicts: the newest verdict wins, time and memory are limited, none holds up another."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.conftest import STUDY
from tests.web.built_page import needs_page

from wucht.web.worker_process import Answer, timeout_sentence
from wucht.web.workers import PROCESSES, Workers

SHORT = STUDY.replace('"0.5 s"', '"2 s"')
LONG = STUDY.replace('"0.5 s"', '"20000 s"')  # minutes
HEAVY = STUDY.replace('name = "p1"', 'name = "p1"\ncount = 90').replace("p1 = ", "p11 = ")  # its equations take 20 s or more
on_linux = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked at by programs of Linux")


@pytest.fixture(scope="module")
def workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workers]:
    processes = Workers(tmp_path_factory.mktemp("machines"), judging=120.0)
    assert "label" in processes.verdict(SHORT)
    yield processes
    processes.close()


def processes_of_workers() -> set[int]:
    """Processes of this one that make pages and verdicts."""
    command = ["pgrep", "-P", str(os.getpid()), "-f", "wucht.web.live_worker"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return {int(word) for word in done.stdout.split()}


def in_thread(job: Callable[[], Answer], answers: list[Answer]) -> threading.Thread:
    thread = threading.Thread(target=lambda: answers.append(job()))
    thread.start()
    return thread


def answers_of(workers: Workers, studies: list[str], pause: float) -> list[Answer]:
    """Answers to questions that are asked one after another, none of them waited for."""
    answers: dict[int, Answer] = {}
    threads = []
    for k, study in enumerate(studies):
        threads.append(threading.Thread(target=lambda k=k, study=study: answers.update({k: workers.verdict(study)})))
        threads[-1].start()
        time.sleep(pause)
    for thread in threads:
        thread.join(60)
    return [answers[k] for k in range(len(studies))]


@pytest.mark.parametrize("pause", [0.0, 1.0])
def test_the_newest_question_is_answered_and_those_before_it_are_superseded(workers: Workers, pause: float) -> None:
    """Whether they wait or are being judged: a run of minutes ends at once."""
    begin = time.monotonic()
    *before, last = answers_of(workers, [LONG, LONG, SHORT], pause)
    assert before == [{"superseded": True}] * 2
    assert last["label"] == workers.verdict(SHORT)["label"]
    assert time.monotonic() - begin < 15


@on_linux
def test_a_run_that_takes_too_long_is_ended_but_not_its_process(tmp_path: Path) -> None:
    before = processes_of_workers()
    workers = Workers(tmp_path, judging=8.0)
    workers.verdict(SHORT)
    processes = processes_of_workers() - before
    answer = workers.verdict(LONG)
    assert answer["error"] == timeout_sentence("verdict", 8.0)
    assert "wucht run" in answer["error"]
    assert "label" in workers.verdict(SHORT)
    assert processes_of_workers() - before == processes
    assert len(processes) == 1, "what is asked for one after the other is done in one process, with what it compiled"
    workers.close()


@on_linux
@pytest.mark.slow
def test_what_does_not_notice_the_end_of_its_time_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the derivation of the equations of many bodies: nothing in it asks how late it is."""
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path / "cache"))  # in which they are not yet
    before = processes_of_workers()
    workers = Workers(tmp_path, judging=6.0)
    workers.verdict(SHORT)
    (process,) = processes_of_workers() - before
    begin = time.monotonic()
    assert workers.verdict(HEAVY)["error"] == timeout_sentence("verdict", 6.0)
    assert time.monotonic() - begin < 15
    assert process not in processes_of_workers()
    assert "label" in workers.verdict(SHORT), "another process was started"
    workers.close()


@pytest.mark.slow
@needs_page
def test_a_heavy_page_does_not_hold_up_a_light_one_or_a_verdict(tmp_path: Path) -> None:
    """There are as many at a time as processes: one more is refused, once it has waited."""
    for name, text in {"heavy": LONG, "light": STUDY}.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    workers = Workers(tmp_path, judging=120.0, waiting=1.0)
    answers: list[Answer] = []
    heavy = [in_thread(lambda: workers.page(str(tmp_path / "heavy.toml"), "/verdict"), answers)]
    time.sleep(0.2)
    assert "page" in workers.page(str(tmp_path / "light.toml"), "/verdict")
    assert "label" in workers.verdict(SHORT)
    assert answers == [], "the heavy page is still being made"
    heavy += [in_thread(lambda: workers.page(str(tmp_path / "heavy.toml"), None), answers) for _ in range(PROCESSES - 1)]
    time.sleep(0.2)
    begin = time.monotonic()
    one_more = workers.page(str(tmp_path / "light.toml"), "/verdict")
    assert one_more["status"] == 503
    assert f"wucht is making {PROCESSES} other pages" in one_more["error"]
    assert 0.9 < time.monotonic() - begin < 3.0
    workers.close()
    for thread in heavy:
        thread.join(10)
    assert len(answers) == PROCESSES
    assert all("stopped" in answer["error"] for answer in answers)


@pytest.mark.slow
@on_linux
def test_a_process_that_is_killed_from_outside_is_reported_and_replaced(tmp_path: Path) -> None:
    before = processes_of_workers()
    workers = Workers(tmp_path, judging=120.0)
    workers.verdict(SHORT)
    (process,) = processes_of_workers() - before
    answers: list[Answer] = []
    thread = in_thread(lambda: workers.verdict(LONG), answers)
    time.sleep(1.0)
    os.kill(process, signal.SIGKILL)
    thread.join(20)
    assert "ran out of memory" in answers[0]["error"]
    assert "label" in workers.verdict(SHORT)
    workers.close()


def test_a_run_for_which_the_memory_does_not_suffice_is_refused(workers: Workers) -> None:
    study = LONG.replace("[study]", "[study]\nstored_samples = 100000000000")
    assert "memory" in workers.verdict(study)["error"]


@pytest.mark.slow
def test_no_module_is_imported_from_the_folder(tmp_path: Path) -> None:
    """A file of the folder that is called as a library must not be run."""
    for name in ("numpy", "sympy", "json", "wucht"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'w').close()\nraise SystemExit\n", encoding="utf-8")
    workers = Workers(tmp_path, judging=120.0)
    assert "label" in workers.verdict(SHORT)
    assert not (tmp_path / "imported").exists()
    workers.close()


@pytest.mark.parametrize(("count", "is_refused"), [(100, False), (101, True)])
def test_a_machine_has_at_most_a_hundred_bodies(workers: Workers, count: int, is_refused: bool) -> None:
    """They are counted before any is built: those of several tables together. Another fault is reported of fewer."""
    table = STUDY.split("[[machine.bodies]]")[2]
    numbers = {"q": 50, "r": count - 53}  # beside a rotor and two pendulums
    more = "".join(f"[[machine.bodies]]{table.replace('p1', name)}count = {number}\n" for name, number in numbers.items())
    study = STUDY.replace("[machine.drive]", f"{more}\n[machine.drive]").replace('damping = "200 N s/m"', "damping = -1", 1)
    error = workers.verdict(study)["error"]
    if is_refused:
        assert (
            error
            == "machine.bodies: given 101; at most 100 bodies are shown here; use `wucht run`, or `wucht share` for a page"
        )
    else:
        assert error.startswith("machine.carrier.damping: given -1")


def test_after_its_end_nothing_is_answered(tmp_path: Path) -> None:
    workers = Workers(tmp_path, judging=120.0)
    answers: list[Answer] = []
    thread = in_thread(lambda: workers.verdict(LONG), answers)
    time.sleep(1.0)
    workers.close()
    thread.join(10)
    assert "stopped" in answers[0]["error"]
    assert "stopped" in workers.verdict(SHORT)["error"]


def test_a_page_that_takes_too_long_says_what_makes_it(tmp_path: Path) -> None:
    """It has no study file to copy: that is what a verdict says."""
    (tmp_path / "drum.toml").write_text(STUDY, encoding="utf-8")
    workers = Workers(tmp_path, judging=0.0, making=0.0)
    assert workers.page(str(tmp_path / "drum.toml"), None) == {
        "timed_out": True, "error": "the equations of this machine take longer than 0 s: use `wucht share FILE`", "status": 503,
    }  # fmt: skip
    assert workers.machines()["error"] == "the list of machines takes longer than 0 s: use `wucht list`, and `wucht app FILE`"
    workers.close()
