"""The server's side of the process that makes pages and verdicts: one job at a time, each in limited time."""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from wucht.environment import environment_of_libraries

JUDGING_S = 20.0  # of a verdict, and of the one with which a page begins
MAKING_S = 120.0  # of a page: the equations of many bodies take a minute
_GRACE_S = 3.0  # after which a process that does not notice the end of its time is killed

Answer = dict[str, Any]
_END_SENTENCE = "the process that computes has ended: it ran out of memory, or the server is being stopped"
SUPERSEDED_ANSWER: Mapping[str, Any] = {"superseded": True}


def timeout_sentence(job: str, limit: float) -> str:
    """Return why there is no answer to a job that took too long: a verdict, the list of names, or a page or its check."""
    match job:
        case "verdict":
            return f"the run takes longer than {limit:g} s: copy the study file, and use `wucht run`"
        case "names":
            return f"the list of machines takes longer than {limit:g} s: use `wucht list`, and `wucht app FILE`"
        case _:
            return f"the equations of this machine take longer than {limit:g} s: use `wucht share FILE`"


class WorkerProcess:
    """Does jobs in a process that is started when it is needed, and anew after it was killed.

    Safe to use from several threads: jobs wait for each other. Of the verdicts that are asked for only the newest is given;
    those before it are cancelled, and answered as superseded.

    Parameters
    ----------
    folder : Path
        Below which files may be read.
    judging, making : float, optional
        The longest time of a verdict, and of a page, in s.
    """

    def __init__(self, folder: Path, judging: float = JUDGING_S, making: float = MAKING_S) -> None:
        self._folder, self._judging, self._making = folder, judging, making
        self._job_lock = threading.Lock()  # one job is done at a time
        self._state = threading.Lock()
        self._write_lock = threading.Lock()  # a line to the process is whole
        self._process: subprocess.Popen[str] | None = None
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._number = 0
        self._newest = 0  # verdict
        self._verdict_number = 0  # the job of the verdict that is being made
        self._is_closed = False

    def verdict(self, text: str) -> Answer:
        """Judge the study file of what is shown: ``label`` and ``sentence``, or ``error``, or ``superseded``."""
        number = self._supersede()
        with self._job_lock:
            with self._state:
                if self._newest != number:
                    return dict(SUPERSEDED_ANSWER)
                self._verdict_number = number
            answer = self._answer_to({"job": "verdict", "text": text}, number, self._judging)
            with self._state:
                self._verdict_number = 0
            return answer if self._newest == number else dict(SUPERSEDED_ANSWER)

    def page(self, name: str, server: str | None) -> Answer:
        """Make the page of a file or catalogue name: ``page``, or ``error`` and ``status``.

        A page has no verdict if that takes long. A verdict that is being made, of a page before this one, is given up.
        """
        job = {"job": "page", "name": name, "server": server}
        self._supersede()
        with self._job_lock:
            answer = self._answer_to(job | {"judged": True}, self._next_number(), self._judging)
            if "timed_out" in answer:
                answer = self._answer_to(job | {"judged": False}, self._next_number(), self._making)
        return answer | {"status": 503} if "timed_out" in answer else answer

    def machines(self) -> Answer:
        """``names`` of the machines of the catalogue that a page can show."""
        with self._job_lock:
            return self._answer_to({"job": "names"}, self._next_number(), self._making)

    def check(self, name: str | None) -> Answer:
        """Whether pages can be made, and that of the file: ``error`` where not."""
        with self._job_lock:
            return self._answer_to({"job": "check", "name": name}, self._next_number(), self._making)

    def close(self) -> None:
        """End the process; jobs that wait are answered at once. May be called in a signal handler."""
        self._is_closed = True
        if self._process is not None:
            self._process.kill()

    def _next_number(self) -> int:
        with self._state:
            self._number += 1
            return self._number

    def _supersede(self) -> int:
        """Give up the verdict that is being made, and those that wait; return the number of the newest job."""
        number = self._next_number()
        with self._state:
            self._newest = number
            if self._verdict_number:
                self._write({"cancel": self._verdict_number})
        return number

    def _answer_to(self, job: Mapping[str, Any], number: int, limit: float) -> Answer:
        """The answer to a job; ``timed_out`` and ``error`` where it takes too long."""
        if self._is_closed:
            return {"error": "the server is being stopped", "status": 503}
        process = self._running_process()
        self._write({"id": number, "folder": str(self._folder), "limit": limit, **job})
        try:
            line = self._lines.get(timeout=limit + _GRACE_S)
        except queue.Empty:
            self._kill(process)
            return {"timed_out": True, "error": timeout_sentence(job["job"], limit)}
        if line is None:
            self._kill(process)
            return {"error": _END_SENTENCE, "status": 503}
        answer: Answer = {key: value for key, value in json.loads(line).items() if key != "id"}
        return answer | {"error": timeout_sentence(job["job"], limit)} if "timed_out" in answer else answer

    def _running_process(self) -> subprocess.Popen[str]:
        if self._process is None:
            self._lines = queue.SimpleQueue()
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "wucht.web.live_worker"],  # -P: no module is imported from the folder
                cwd=self._folder, env=environment_of_libraries(), text=True, encoding="utf-8", bufsize=1,
                stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            )  # fmt: skip
            threading.Thread(target=_read_lines, args=(self._process, self._lines), daemon=True).start()
        return self._process

    def _write(self, message: Mapping[str, Any]) -> None:
        process = self._process
        if process is None or process.stdin is None:
            return
        with self._write_lock, suppress(OSError, ValueError):  # it may have ended: the reader of its answers says so
            process.stdin.write(json.dumps(message) + "\n")

    def _kill(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.wait()
        self._process = None


def _read_lines(process: subprocess.Popen[str], lines: queue.SimpleQueue[str | None]) -> None:
    """Pass on what a process answers, and that it has ended."""
    assert process.stdout is not None
    for line in process.stdout:
        lines.put(line)
    lines.put(None)
