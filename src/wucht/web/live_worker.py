"""A process that makes pages and verdicts for ``wucht app``: jobs come as lines of JSON on stdin, answers go to stdout.

A process of its own, so that the time and the memory of a job can be bounded; it stays, with what was compiled, for the next.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from wucht.errors import InputError, WuchtError
from wucht.files.catalogue import FOLDER, described_machine, load_document, names, short_name
from wucht.files.documents import files_below
from wucht.studies.resource_limits import machine_memory
from wucht.web.live_page import built_file
from wucht.web.shared_study import shareable_study, shared_page
from wucht.web.shown_study import refuse_many_bodies, shown_verdict

_LIBRARY_BYTES = 3e9  # of address space that libraries take, most of it unused
_MEMORY_SHARE, _MOST_MEMORY = 0.25, 16e9  # of the memory, in bytes: three such processes leave a quarter of it
_MISSING = frozenset({"no-file", "unknown-name", "outside"})


class _Inbox:
    """Jobs that have come, and the numbers of those that nobody waits for any longer."""

    def __init__(self) -> None:
        self.jobs: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self.cancelled: set[int] = set()

    def read(self) -> None:
        """Read lines until the server has gone; then the process ends, whatever it does."""
        for line in sys.stdin:
            message = json.loads(line)
            if "cancel" in message:
                self.cancelled.add(int(message["cancel"]))
            else:
                self.jobs.put(message)
        os._exit(0)


def main() -> None:
    """Answer jobs until stdin ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this process
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", buffering=1)
    os.dup2(2, 1)  # what a library prints is no answer
    _limit_memory()
    inbox = _Inbox()
    threading.Thread(target=inbox.read, daemon=True).start()
    while True:
        job = inbox.jobs.get()
        answers.write(json.dumps({"id": job["id"], **_answer(job, inbox)}) + "\n")


def _limit_memory() -> None:
    """Limit the address space, where the system can."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        limit, hard = (
            int(_LIBRARY_BYTES + _MEMORY_SHARE * min(machine_memory(), _MOST_MEMORY)),
            resource.getrlimit(resource.RLIMIT_AS)[1],
        )
        resource.setrlimit(resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(hard, limit), hard))


def _answer(job: dict[str, Any], inbox: _Inbox) -> dict[str, Any]:
    """The answer to a job, or why there is none."""
    deadline = time.monotonic() + float(job["limit"])

    def check() -> None:
        if job["id"] in inbox.cancelled or time.monotonic() > deadline:
            raise KeyboardInterrupt

    try:
        check()
        return _JOBS[job["job"]](job, check)
    except KeyboardInterrupt:
        return {"superseded": True} if job["id"] in inbox.cancelled else {"timed_out": True}
    except MemoryError:
        return {"error": "there is not enough memory for this machine", "status": 422}
    except InputError as error:
        place = {"location": error.location, "explanation": _explanation(error)}
        return {"error": str(error), "status": 404 if error.code in _MISSING else 422, **place}
    except WuchtError as error:
        return {"error": str(error), "status": 503 if error.code == "not-built" else 422}
    except Exception as error:  # a fault of ours: the page says so, and the next job is answered
        return {"error": f"an error inside wucht: {type(error).__name__}: {error}", "status": 500}


def _explanation(error: InputError) -> str:
    return f"given {error.value_text}; {error.explanation}" if error.value_text else error.explanation


def _judge(job: dict[str, Any], check: Callable[[], None]) -> dict[str, Any]:
    label, sentence = shown_verdict(job["text"], lambda _share, _label: check())
    return {"label": label, "sentence": sentence}


def _make_page(job: dict[str, Any], _check: Callable[[], None]) -> dict[str, Any]:
    with files_below(Path(job["folder"]), FOLDER):
        _refuse_many_bodies(job["name"])
        return {"page": shared_page(job["name"], verdict=None if job["judged"] else False, server=job["server"])}


def _refuse_many_bodies(name: str) -> None:
    document, path = load_document(name)
    try:
        description = described_machine(document, path, name, {})
    except InputError:  # reported where the machine is built
        return
    try:
        refuse_many_bodies(description)
    except InputError as error:
        raise error.with_file(path) from None


def _list_machines(_job: dict[str, Any], _check: Callable[[], None]) -> dict[str, Any]:
    return {"names": [n for n in names() if _can_move(n)]}


@cache
def _can_move(name: str) -> bool:
    """True for a machine of the catalogue that can be exported: none of its bodies is locked until a release."""
    document, path = load_document(name)
    return "machine" in document and not any(
        "release" in body for body in described_machine(document, path, name, {}).get("bodies", [])
    )


def _check_file(job: dict[str, Any], _check: Callable[[], None]) -> dict[str, Any]:
    """Whether the page was built, and the file has a machine that it can show: before a browser is opened."""
    built_file("live.js")
    if job["name"] is None:
        return {}
    with files_below(Path(job["folder"]), FOLDER):
        _refuse_many_bodies(job["name"])
        return {"title": str(short_name(shareable_study(job["name"])[0].path))}


_JOBS = {"verdict": _judge, "page": _make_page, "names": _list_machines, "check": _check_file}

if __name__ == "__main__":
    main()
