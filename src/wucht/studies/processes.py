"""Units of work in several processes of this computer: each is sent as bytes, with all that it needs, and its result returned.

The processes are started for one study and end with it. They do not load the program that asks, as those of
``multiprocessing`` do, so that a script needs no ``if __name__ == "__main__"``.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any, TypeVar

import numpy as np

from wucht.dynamics.work import Task
from wucht.environment import environment_of_libraries
from wucht.errors import RunError

T = TypeVar("T")
_TICK_S = 0.1  # between two checks for an interrupt by the user
_REPORT_S = 0.2  # between two progress reports of a process
_SHARE, _RESULT, _ERROR = "share", "result", "error"
_News = SimpleQueue[tuple[str, str, Any]]  # name of a task, what has come of it, and its value


class LocalProcesses:
    """Processes of this computer that compute units of work, as the workers of ``cluster`` do on others."""

    def __init__(self, count: int) -> None:
        self._count = count

    def compute(self, tasks: Mapping[str, Task[T]], report: Callable[[float, str], None]) -> Iterator[tuple[str, T]]:
        """Yield the results of tasks by name, in the order of completion.

        report: called with the completed share of all tasks and the number of processes; it may raise ``KeyboardInterrupt``.
        Raises the error of a task, and ``RunError`` where a process ends.
        """
        waiting, news, shares, done = SimpleQueue[tuple[str, Task[T]] | None](), _News(), dict[str, float](), 0
        for item in tasks.items():
            waiting.put(item)
        processes = [_Process(waiting, news) for _ in range(min(self._count, len(tasks)))]
        try:
            while done < len(tasks):
                report((done + sum(shares.values())) / len(tasks), f", {len(processes)} processes")
                try:
                    name, kind, value = news.get(timeout=_TICK_S)
                except Empty:
                    continue
                if kind == _SHARE:
                    shares[name] = value
                    continue
                if kind == _ERROR:
                    raise value
                shares.pop(name, None)
                done += 1
                yield name, value
        finally:
            for process in processes:
                process.end()


class _Process:
    """A process, and the thread that sends it one task after the other."""

    def __init__(self, waiting: SimpleQueue[Any], news: _News) -> None:
        self._waiting, self._news = waiting, news
        folders = os.pathsep.join(folder or str(Path.cwd()) for folder in sys.path)
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", "from wucht.studies.processes import compute_tasks; compute_tasks()"],
            env=environment_of_libraries() | {"PYTHONPATH": folders}, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        Thread(target=self._send_tasks, daemon=True).start()

    def end(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.wait()

    def _send_tasks(self) -> None:
        tasks, answers = self._process.stdin, self._process.stdout
        assert tasks is not None and answers is not None
        with tasks, answers, suppress(Empty):
            while True:
                name, task = self._waiting.get_nowait()
                try:
                    for kind, value in _answers(task, tasks, answers):
                        self._news.put((name, kind, value))
                except (OSError, EOFError):
                    sentence = f"a process has ended while it computed {name}: it may lack memory; fewer processes need less"
                    self._news.put((name, _ERROR, RunError(sentence, code="process-ended")))
                    return
                except Exception as error:  # what cannot be pickled raises what it likes
                    self._news.put(
                        (name, _ERROR, RunError(f"{name} cannot be sent to another process: {error}", code="not-sent"))
                    )
                    return


def _answers(task: Task[Any], tasks: IO[bytes], answers: IO[bytes]) -> Iterator[tuple[str, Any]]:
    """Send a task, and yield what comes of it, up to its result or error."""
    pickle.dump(pickle.dumps(task), tasks)
    tasks.flush()
    kind = _SHARE
    while kind == _SHARE:
        kind, value = pickle.load(answers)
        yield kind, value


def compute_tasks() -> None:
    """Compute the tasks that come on stdin, one after the other, until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asks, which ends this one
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    with suppress(EOFError, BrokenPipeError):
        while True:
            _send(answers, *_outcome(pickle.load(sys.stdin.buffer), answers))


def _outcome(payload: bytes, answers: IO[bytes]) -> tuple[str, Any]:
    """The result of a task, or its error."""
    report_time = clock.monotonic()

    def report_share(share: float) -> None:
        nonlocal report_time
        if clock.monotonic() - report_time > _REPORT_S:
            report_time = clock.monotonic()
            _send(answers, _SHARE, float(share))

    try:
        with np.errstate(all="ignore"):
            return _RESULT, pickle.loads(payload)(report_share)
    except BrokenPipeError:
        raise
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # of an error that is made of other arguments than it keeps
            return _ERROR, RunError(f"a process has failed: {type(error).__name__}: {error}", code="process-failed")
        return _ERROR, error


def _send(answers: IO[bytes], kind: str, value: Any) -> None:
    pickle.dump((kind, value), answers)
    answers.flush()
