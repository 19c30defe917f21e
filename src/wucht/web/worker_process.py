"""The server's side of a process that makes pages and verdicts: one job at a time, each in limited time."""

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

_GRACE_S = 3.0  # after which a process that does not notice the end of its time is killed

Answer = dict[str, Any]
_END_SENTENCE = "the process that computes has ended: it ran out of memory, or the server is being stopped"


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
    """Does jobs, one at a time, in a process that is started when it is needed, and anew after it was killed.

    Parameters
    ----------
    folder : Path
        Below which files may be read.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._write_lock = threading.Lock()  # a line to the process is whole
        self._process: subprocess.Popen[str] | None = None
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._is_closed = False

    def answer(self, job: Mapping[str, Any], number: int, limit: float) -> Answer:
        """Do a job of this number; ``timed_out`` and ``error`` where it takes longer than the limit, in s."""
        if self._is_closed:
            return {"error": _END_SENTENCE, "status": 503}
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

    def cancel(self, number: int) -> None:
        """Give up the job of this number, which may not have begun yet. Safe to call from other threads."""
        self._write({"cancel": number})

    def close(self) -> None:
        """End the process for good; a job that it does is answered at once. May be called in a signal handler."""
        self._is_closed = True
        if self._process is not None:
            self._process.kill()

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
