"""The folder of a result: one run at a time writes there, and a new result replaces the earlier one as a whole, or not at all.

While a run goes on, what it writes lies in the sub-folder ``.wucht-new``.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from hashlib import sha256
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError, RunError, WuchtError
from wucht.results.accessor import register
from wucht.results.provenance import unsealed
from wucht.results.store import RESULT, prepare_folder, save_summary

if TYPE_CHECKING:
    import xarray as xr

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

SUMMARY, CHECKSUMS = "summary.json", "checksums"  # the latter: of the figures, by name
NEW, COMMIT = ".wucht-new", ".wucht-commit"
_TRIES = 10
_PATIENCE_S, _PAUSE_S = 5.0, 0.1
_LOCK = ".wucht.lock"
_ours: ContextVar[frozenset[Path]] = ContextVar("folders that this run has claimed", default=frozenset())


@contextmanager
def claimed(folder: Path) -> Iterator[Path]:
    """Keep a folder for what is done within; it is made if it is not there, and removed again where it stays empty.

    A commit that was left is finished first, and what a run that was killed had not finished is removed. Claiming a folder once
    more within is allowed. The system itself gives it free when the process ends, however it does; where a
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
        _finish(folder)
        shutil.rmtree(folder / NEW, ignore_errors=True)
        yield folder
    finally:
        _ours.reset(before)
        shutil.rmtree(folder / NEW, ignore_errors=True)
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


def commit(folder: Path) -> None:
    """Put what was written into the sub-folder ``.wucht-new`` in the place of the earlier result, all of it or nothing.

    It is flushed to disk, and one renaming is the step: a process that is killed before it leaves the earlier result as it was;
    after it, whoever opens the folder next moves the rest. With an earlier result go its summary and figures, but for a figure
    that was changed since. Raises ``RunError`` where that cannot be done.
    """
    new = folder / NEW
    try:
        for path in (*new.iterdir(), new):
            _flush(path)
        _trying(lambda: new.replace(folder / COMMIT))
        _flush(folder)
    except OSError as error:
        raise RunError(f"{new} cannot be put in its place: {error.strerror or error}") from None
    _finish(folder)


def latest(file: Path) -> Path:
    """Where this file of the last complete result is: in its place, where a commit that was left can be finished now."""
    left = file.parent / COMMIT
    if left.is_dir():
        with suppress(WuchtError), claimed(file.parent):
            pass
    return left / file.name if (left / file.name).is_file() else file


def _finish(folder: Path) -> None:
    """Move what a commit has to its place; again and again the same, wherever it was cut off. Nothing if there is none.

    The summary is moved last: until then it is known which figures are of the earlier result.
    """
    left = folder / COMMIT
    if not left.is_dir():
        return
    files = sorted(left.iterdir(), key=lambda f: f.name == SUMMARY)
    earlier = _summary_in(folder) if files else {}  # else the summary in the folder is the new one
    new = _summary_in(left).get(CHECKSUMS, {})
    for name, noted in earlier.get(CHECKSUMS, {}).items():
        file = folder / Path(name).name
        with suppress(OSError, ValueError):
            if file.name not in new and checksum(file) == noted:
                file.unlink()
    if earlier and not (left / SUMMARY).is_file():
        with suppress(OSError):
            (folder / SUMMARY).unlink()
    for file in files:
        try:
            _trying(lambda file=file: file.replace(folder / file.name))  # type: ignore[misc]
        except OSError as error:
            why = f"{folder / file.name} cannot be replaced: {error.strerror or error}"
            raise RunError(
                f"{why}. Close what has it open; the new result is in {left} until the folder is used again",
                code="not-replaced",
            ) from None
    with suppress(OSError):
        left.rmdir()


def _trying(move: Callable[[], object]) -> None:
    """Move a file, again for some seconds where a program has it open, as on Windows and network drives."""
    end = time.monotonic() + _PATIENCE_S
    while True:
        try:
            move()
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EBUSY, errno.EPERM) or time.monotonic() > end:
                raise
            time.sleep(_PAUSE_S)
        else:
            return


def _flush(path: Path) -> None:
    """Have the system write a file or folder to the disk."""
    if path.is_dir() and os.name == "nt":  # a folder cannot be opened there
        return
    opened = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(opened)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # file systems that know no flushing
            raise
    finally:
        os.close(opened)


def _summary_in(folder: Path) -> dict[str, Any]:
    """The summary of a result, empty where there is none of ours."""
    try:
        document = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    ours = isinstance(document, dict) and isinstance(document.get(CHECKSUMS), dict)
    return document if ours else {}


def result_file(path: Path) -> Path:
    """The file of a result: the path itself, or that in an output folder."""
    return path / RESULT if path.is_dir() else path


def load(path: Path) -> xr.Dataset:
    """Read a result. What a run that was killed had begun to put into its folder is put there first.

    Raises ``InputError`` if there is no such file, it is none of ours, or it was changed since it was written.
    """
    import h5py
    import xarray as xr_

    register()
    path = result_file(path)
    file = latest(path)
    if not file.is_file():
        raise InputError.of_file(path, "this is no file" if path.exists() else "there is no such file")
    try:
        with h5py.File(file) as opened:  # where this fails, h5netcdf leaves a file half open, and says so on stderr
            opened.attrs.get("_nc3_strict")
        result = xr_.load_dataset(file, engine="h5netcdf")
    except Exception as error:
        # The readers beneath raise whatever a damaged file makes them stumble over; to the user it is one thing.
        lines = str(error).splitlines() or [type(error).__name__]
        raise InputError.of_file(path, f"this is no NetCDF file that can be read: {lines[0]}") from None
    if "study" not in result.attrs:
        raise InputError.of_file(path, "this file was not written by wucht: it names no study")
    try:
        return unsealed(result)
    except InputError as error:
        raise error.in_file(path) from None
