"""The folder of a result: one run at a time writes there, and nothing of an earlier result stays beside a new one."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from hashlib import sha256
from io import FileIO
from pathlib import Path
from typing import Any

from wucht.errors import InputError
from wucht.results.store import prepare_folder, save_summary

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

SUMMARY, CHECKSUMS = "summary.json", "checksums"  # the latter: of the figures, by name
_TRIES = 10
_LOCK = ".wucht.lock"
_ours: ContextVar[frozenset[Path]] = ContextVar("folders that this run has claimed", default=frozenset())


@contextmanager
def claimed(folder: Path) -> Iterator[Path]:
    """Keep a folder for what is done within; it is made if it is not there, and removed again where it stays empty.

    Claiming it once more within is allowed. The system itself gives it free when the process ends, however it does; where a
    file system has no locks nothing is kept. Raises ``InputError`` where another run writes there, or nobody can.
    """
    place = folder.absolute()
    if place in _ours.get():
        yield folder
        return
    made = [p for p in (place, *place.parents) if not os.path.exists(p)]  # noqa: PTH110 - Path raises for a name too long
    prepare_folder(folder)
    lock = _locked(folder / _LOCK)
    before = _ours.set(_ours.get() | {place})
    try:
        yield folder
    finally:
        _ours.reset(before)
        with suppress(OSError):  # Windows keeps a file that is open
            (folder / _LOCK).unlink(missing_ok=True)
        lock.close()
        with suppress(OSError):  # there is something in it
            for empty in made:
                empty.rmdir()


def _locked(path: Path) -> FileIO:
    """The file at this path, locked. Raises ``InputError`` where another has it."""
    allowed = "another run is writing a result there: wait until it has ended, or give another folder with -o"
    for _ in range(_TRIES):
        try:
            file = FileIO(path, "a+")
        except OSError as error:
            raise InputError("-o", str(path.parent), f"nothing can be written there: {error.strerror}") from None
        if _taken(file):
            file.close()
            break
        with suppress(OSError):
            if os.path.samestat(path.stat(), os.fstat(file.fileno())):
                return file
        file.close()  # it was removed by the run that ended meanwhile
    raise InputError("-o", str(path.parent), allowed)


def _taken(file: FileIO) -> bool:
    """Whether another has locked it; else it is locked now."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return True
    except OSError:
        return False  # there are no locks here
    return False


def checksum(file: Path) -> str:
    """Of what a file holds."""
    return sha256(file.read_bytes()).hexdigest()


def note_figure(file: Path) -> None:
    """Note in the summary of its folder, if there is one, that this figure was drawn of the result."""
    summary = _summary_in(file.parent)
    if summary:
        save_summary(summary | {CHECKSUMS: summary[CHECKSUMS] | {file.name: checksum(file)}}, file.parent / SUMMARY)


def remove_earlier(folder: Path) -> None:
    """Remove the summary and the figures that wucht wrote of an earlier result: a figure that was changed since stays."""
    summary = _summary_in(folder)
    for name, noted in summary.get(CHECKSUMS, {}).items():
        file = folder / Path(name).name
        with suppress(OSError):
            if checksum(file) == noted:
                file.unlink()
    if summary:
        with suppress(OSError):
            (folder / SUMMARY).unlink()


def _summary_in(folder: Path) -> dict[str, Any]:
    """The summary of a result, empty where there is none of ours."""
    try:
        document = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    ours = isinstance(document, dict) and isinstance(document.get(CHECKSUMS), dict)
    return document if ours else {}
