"""The folder of a result: one run at a time writes there, and a new result replaces the earlier one as a whole, or not at all.

``result.nc`` is always complete. What is not, of a run that goes on, was stopped or failed, is ``result.partial.nc``, and its
figures and summary are named likewise: it never replaces a complete one. The files of the next commit are in ``.wucht-new``.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError, RunError, WuchtError
from wucht.results.accessor import register_accessor
from wucht.results.provenance import verify_checksums
from wucht.results.store import RESULT, file_name, move, partial_name, prepare_folder, save, save_summary

if TYPE_CHECKING:
    import h5py
    import xarray as xr

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

SUMMARY, CHECKSUMS = "summary.json", "checksums"  # checksums of the figures and tables, by name
NEW, COMMIT = ".wucht-new", ".wucht-commit"
PARTIAL = partial_name(RESULT)
_PARTIAL_SUMMARY = partial_name(SUMMARY)
_TRIES = 10
_LOCK = ".wucht.lock"


@contextmanager
def claim_folder(folder: Path) -> Iterator[Path]:
    """Claim a folder while the block lasts; it is made if missing, and removed again if it remains empty.

    A commit that was cut off is finished first, and unfinished files of a killed run are removed. The system releases the
    folder when the process ends, however it does; without file locks in the file system nothing is claimed. Raises
    ``InputError`` if another run writes there, or no file can be written.
    """
    place = folder.absolute()
    new_folders = [p for p in (place, *place.parents) if not os.path.exists(p)]  # noqa: PTH110 - Path raises for a name too long
    prepare_folder(folder)
    lock = _lock_file(folder / _LOCK)
    try:
        _finish_commit(folder)
        shutil.rmtree(folder / NEW, ignore_errors=True)
        yield folder
    finally:
        shutil.rmtree(folder / NEW, ignore_errors=True)
        with suppress(OSError):  # Windows does not remove an open file
            (folder / _LOCK).unlink(missing_ok=True)
        lock.close()
        with suppress(OSError):  # it is not empty
            for empty in new_folders:
                empty.rmdir()


def _lock_file(path: Path) -> FileIO:
    """Open and lock the file at this path. Raises ``InputError`` if another run holds it."""
    requirement = "another run is writing a result there: wait until it has ended, or give another folder with -o"
    for _ in range(_TRIES):
        try:
            file = FileIO(path, "a+")
        except OSError as error:
            raise InputError("-o", str(path.parent), f"nothing can be written there: {error.strerror}") from None
        if _is_lock_held(file):
            file.close()
            break
        with suppress(OSError):
            if os.path.samestat(path.stat(), os.fstat(file.fileno())):
                return file
        file.close()  # it was removed by a run that has ended meanwhile
    raise InputError("-o", str(path.parent), requirement)


def _is_lock_held(file: FileIO) -> bool:
    """True if another process holds the lock; otherwise lock the file now."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return True
    except OSError:
        return False  # the file system has no locks
    return False


def checksum(file: Path) -> str:
    """Checksum of a file's content."""
    return sha256(file.read_bytes()).hexdigest()


def _has_content(path: Path) -> bool:
    """True for a file that can be read to its end: devices, pipes, and files of the system without a size, may never end."""
    try:
        return path.is_file() and path.stat().st_size > 0
    except OSError:
        return False


def note_figure(file: Path, result: xr.Dataset) -> None:
    """Record a figure or table of a result in the summary of its folder, if there is one: the next result removes it."""
    path = file.parent / file_name(SUMMARY, result)
    summary = _read_summary(path)
    if summary:
        save_summary(summary | {CHECKSUMS: summary[CHECKSUMS] | {file.name: checksum(file)}}, path)


def save_partial(result: xr.Dataset, folder: Path) -> None:
    """Write what a run has computed so far as ``result.partial.nc``. Figures and summary of an earlier one are removed."""
    save(result, folder / PARTIAL)
    _remove_presentation(folder / _PARTIAL_SUMMARY)


def remove_partial(folder: Path) -> None:
    """Remove the result that is not complete, with its figures and summary."""
    _remove_presentation(folder / _PARTIAL_SUMMARY)
    with suppress(OSError):
        (folder / PARTIAL).unlink(missing_ok=True)


def commit(folder: Path) -> None:
    """Replace the earlier result by the files in the sub-folder ``.wucht-new``, all or none of them.

    They are flushed to disk, and a single renaming decides: a process killed before it leaves the earlier result unchanged;
    after it, the next access to the folder moves the rest. The summary and figures of the earlier result are removed, except a
    figure that was changed since. Raises ``RunError`` if that is not possible.
    """
    new = folder / NEW
    try:
        for path in (*new.iterdir(), new):
            _flush(path)
        move(new, folder / COMMIT)
        _flush(folder)
    except OSError as error:
        raise RunError(f"{new} cannot be put in its place: {error.strerror or error}") from None
    _finish_commit(folder)


def latest_file(file: Path) -> Path:
    """Path of this file of the last complete result: in its place, if a commit that was cut off can be finished now."""
    commit_folder = file.parent / COMMIT
    if commit_folder.is_dir():
        with suppress(WuchtError), claim_folder(file.parent):
            pass
    return commit_folder / file.name if (commit_folder / file.name).is_file() else file


def _finish_commit(folder: Path) -> None:
    """Move the files of a commit to their places, wherever it was cut off before. Without a commit do nothing.

    A summary is moved last: until then it tells which figures belong to the earlier result.
    """
    commit_folder = folder / COMMIT
    if not commit_folder.is_dir():
        return
    files = {file.name: file for file in sorted(commit_folder.iterdir(), key=lambda f: f.name in (SUMMARY, _PARTIAL_SUMMARY))}
    for result, summary in ((RESULT, SUMMARY), (PARTIAL, _PARTIAL_SUMMARY)):
        if result in files or summary in files:  # otherwise the summary in the folder is the new one
            _remove_presentation(folder / summary, files.get(summary))
    for file in files.values():
        try:
            move(file, folder / file.name)
        except OSError as error:
            reason = f"{folder / file.name} cannot be replaced: {error.strerror or error}"
            raise RunError(
                f"{reason}. Close the program that has it open; the new result is in {commit_folder} until "
                "the folder is used again",
                code="not-replaced",
            ) from None
    with suppress(OSError):
        commit_folder.rmdir()


def _flush(path: Path) -> None:
    """Flush a file or folder to the disk."""
    if path.is_dir() and os.name == "nt":  # a folder cannot be opened on Windows
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # file systems without flushing
            raise
    finally:
        os.close(descriptor)


def _remove_presentation(summary: Path, next_summary: Path | None = None) -> None:
    """Remove the unchanged figures and tables of a result, and its summary; what the next one replaces, whose summary is given,
    stays.
    """
    earlier, replacements = (_read_summary(path) if path else {} for path in (summary, next_summary))
    for name, recorded_sum in earlier.get(CHECKSUMS, {}).items():
        file = summary.parent / Path(name).name
        with suppress(OSError, ValueError):
            if file.name not in replacements.get(CHECKSUMS, {}) and _has_content(file) and checksum(file) == recorded_sum:
                file.unlink()
    if earlier and next_summary is None:
        with suppress(OSError):
            summary.unlink()


def _read_summary(path: Path) -> dict[str, Any]:
    """The summary of a result, empty if there is none written by wucht."""
    if not _has_content(path):
        return {}
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    is_summary = isinstance(document, dict) and isinstance(document.get(CHECKSUMS), dict)
    return document if is_summary else {}


def result_file(path: Path) -> Path:
    """The file of a result: the path itself, or that in an output folder, which may have one only that is not complete."""
    if not path.is_dir():
        return path
    has_only_part = not latest_file(path / RESULT).is_file() and (path / PARTIAL).is_file()
    return path / (PARTIAL if has_only_part else RESULT)


def load_result(path: Path) -> xr.Dataset:
    """Read a result. A commit of a killed run is finished first; a warning names what cannot be read but is not indispensable.

    Raises ``InputError`` if there is no such file, it was not written by wucht, or it was changed since.
    """
    import h5py
    import xarray as xr_

    register_accessor()
    path = result_file(path)
    file = latest_file(path)
    if not file.is_file():
        part = path.with_name(PARTIAL)
        hint = f"; the run is not complete: what it has so far is {part}" if path.name == RESULT and part.is_file() else ""
        raise InputError.file_error(path, "this is not a file" if path.exists() else f"there is no such file{hint}")
    if not _has_content(file):
        raise InputError.file_error(path, "this is not a readable NetCDF file: it is empty")
    try:
        with h5py.File(file) as h5_file:  # where this fails, h5netcdf would leave a file half open and print to stderr
            h5_file.attrs.get("_nc3_strict")
            _refuse_other_files(h5_file)
        result = xr_.load_dataset(file, engine="h5netcdf")
    except Exception as error:
        # A damaged file can cause any error in the libraries beneath: to the user they mean the same.
        lines = str(error).splitlines() or [type(error).__name__]
        raise InputError.file_error(path, f"this is not a readable NetCDF file: {lines[0]}") from None
    if "study" not in result.attrs:
        raise InputError.file_error(path, "this file was not written by wucht: it names no study")
    try:
        result = verify_checksums(result)
    except InputError as error:
        raise error.with_file(path) from None
    for fault in result.wucht.faults:
        warnings.warn(f"{path}: {fault}", stacklevel=2)
    return result


def _refuse_other_files(file: h5py.File) -> None:
    """Raise ``ValueError`` where numbers lie in another file: any that the user can read, and may pass on as a report."""
    import h5py as h5

    def refuse(name: str, item: Any) -> None:
        if isinstance(item, h5.Dataset) and (item.external or item.is_virtual):
            raise ValueError(f"the numbers of {name} lie in another file")

    for name in file:
        if isinstance(file.get(name, getlink=True), h5.ExternalLink):
            raise ValueError(f"{name} lies in another file")
    file.visititems(refuse)
