"""The processes that make pages and verdicts: a job that takes long in one of them does not hold up the others."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from wucht.web.worker_process import Answer, WorkerProcess

PROCESSES = 3  # two machines of many bodies, and all others
JUDGING_S = 20.0  # of a verdict, and of the one with which a page begins
MAKING_S = 120.0  # of a page: the equations of many bodies take a minute
WAITING_S = 20.0  # for a process that is idle
SUPERSEDED_ANSWER: Mapping[str, bool] = {"superseded": True}
_BUSY_ANSWER: Mapping[str, str | int] = {
    "error": f"wucht is making {PROCESSES} other pages, whose equations take long: try again when one of them is there",
    "status": 503,
}
_END_ANSWER: Mapping[str, str | int] = {"error": "the server is being stopped", "status": 503}


class Workers:
    """Do jobs in processes, each of which is started when it is needed.

    Safe to use from several threads. Of the verdicts that are asked for only the newest is given; those before it are
    cancelled, and answered as superseded.

    Parameters
    ----------
    folder : Path
        Below which files may be read.
    judging, making, waiting : float, optional
        The longest time of a verdict, of a page, and until a process is idle, in s.
    """

    def __init__(self, folder: Path, judging: float = JUDGING_S, making: float = MAKING_S, waiting: float = WAITING_S) -> None:
        self._judging, self._making, self._waiting = judging, making, waiting
        self._all = [WorkerProcess(folder) for _ in range(PROCESSES)]
        self._idle = list(self._all)
        self._state = threading.Condition()
        self._verdict_lock = threading.Lock()  # one verdict is made at a time
        self._number = 0  # of jobs
        self._newest = 0  # verdict
        self._judge: WorkerProcess | None = None  # the process in which the verdict is made
        self._is_closed = False

    def verdict(self, text: str) -> Answer:
        """Judge the study file of what is shown: ``label`` and ``sentence``, or ``error``, or ``superseded``."""
        number = self._next_number()
        with self._state:
            before, self._newest = self._newest, number
            if self._judge is not None:
                self._judge.cancel(before)
        with self._verdict_lock, self._idle_process() as process:
            with self._state:
                if self._newest != number:
                    return dict(SUPERSEDED_ANSWER)
                self._judge = process
            answer = self._answer(process, {"job": "verdict", "text": text}, number, self._judging)
            with self._state:
                self._judge = None
                return answer if self._newest == number else dict(SUPERSEDED_ANSWER)

    def page(self, name: str, server: str | None) -> Answer:
        """Make the page of a file or catalogue name: ``page``, or ``error`` and ``status``.

        A page has no verdict if that takes long.
        """
        job = {"job": "page", "name": name, "server": server}
        with self._idle_process() as process:
            answer = self._answer(process, job | {"judged": True}, self._next_number(), self._judging)
            if "timed_out" in answer:
                answer = self._answer(process, job | {"judged": False}, self._next_number(), self._making)
        return answer | {"status": 503} if "timed_out" in answer else answer

    def machines(self) -> Answer:
        """``names`` of the machines of the catalogue that a page can show."""
        with self._idle_process() as process:
            return self._answer(process, {"job": "names"}, self._next_number(), self._making)

    def check(self, name: str | None) -> Answer:
        """Whether pages can be made, and that of the file: ``error`` where not."""
        with self._idle_process() as process:
            return self._answer(process, {"job": "check", "name": name}, self._next_number(), self._making)

    def close(self) -> None:
        """End the processes; jobs that wait are answered at once. May be called in a signal handler."""
        self._is_closed = True
        for process in self._all:
            process.close()

    def _next_number(self) -> int:
        with self._state:
            self._number += 1
            return self._number

    @contextmanager
    def _idle_process(self) -> Iterator[WorkerProcess | None]:
        """A process that is idle, if possible the one used last, with what it compiled; None where none becomes so in time."""
        with self._state:
            is_one = self._state.wait_for(lambda: bool(self._idle), self._waiting)
            process = self._idle.pop() if is_one else None
        try:
            yield process
        finally:
            if process is not None:
                with self._state:
                    self._idle.append(process)
                    self._state.notify()

    def _answer(self, process: WorkerProcess | None, job: Mapping[str, object], number: int, limit: float) -> Answer:
        if self._is_closed:
            return dict(_END_ANSWER)
        return dict(_BUSY_ANSWER) if process is None else process.answer(job, number, limit)
