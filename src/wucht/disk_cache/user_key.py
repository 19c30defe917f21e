"""The user's key, with which entries of the cache are authenticated: 32 random bytes that are made at the first use.

They lie in the user's folder for the state of programs, outside the cache, so that a copy of the cache is of no use to others.
"""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from errno import ELOOP
from functools import cache
from pathlib import Path

from wucht.disk_cache.private_files import (
    WINDOWS,
    make_folder,
    privacy_problem,
    read_file,
    temporary_beside,
    warn_once,
    write_new_file,
)

_SIZE = 32  # bytes
# Both fail where the file exists: of processes that make a key at the same time, one does, and all read that.
_publish = os.rename if WINDOWS else os.link


def key_for(cache: Path) -> bytes | None:
    """The user's key for a cache folder, made at the first use; None where none can be kept.

    Warns, once in a process, of a key that is not the user's alone, and returns None.
    """
    from platformdirs import user_state_path

    return _key(user_state_path("wucht", appauthor=False) / "cache-key", cache)


@cache
def _key(path: Path, cache: Path) -> bytes | None:
    if not path.is_absolute():  # without a home
        return None
    try:
        if path.resolve().is_relative_to(cache.resolve()):
            raise _RefusedKeyError("lies in the cache itself", "give another folder by WUCHT_CACHE_DIR")
        with suppress(FileNotFoundError):
            return _read(path)
        _make(path)
        return _read(path)
    except _RefusedKeyError as error:
        warn_once(f"the key of the cache, {path}, {error}: the cache is not used; {error.remedy}")
    except (OSError, RuntimeError):  # no room, no right to write there, no home
        pass
    return None


class _RefusedKeyError(Exception):
    """Why a key is not used, and what can be done."""

    def __init__(self, reason: str, remedy: str = "remove this file, and a new key is made") -> None:
        super().__init__(reason)
        self.remedy = remedy


def _read(path: Path) -> bytes:
    """Read a key. Raises ``OSError``, and ``_RefusedKeyError`` for a key that other accounts may have read or written."""
    try:
        key, status = read_file(path, _SIZE)
    except ValueError:
        raise _RefusedKeyError(f"is no file of {_SIZE} bytes") from None
    except PermissionError:
        path.lstat()  # not reachable at all: then there is none
        raise _RefusedKeyError("belongs to another account") from None
    except OSError as error:
        if error.errno == ELOOP:
            raise _RefusedKeyError("is a link") from None
        raise
    if problem := privacy_problem(path.parent, path.parent.stat()):
        raise _RefusedKeyError(f"is in a folder that {problem}", "that folder must be yours alone (mode 0700)")
    if problem := privacy_problem(path, status):
        raise _RefusedKeyError(problem)
    if not WINDOWS and status.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise _RefusedKeyError(f"can be read by other accounts (mode {stat.S_IMODE(status.st_mode):04o})")
    if len(key) != _SIZE:
        raise _RefusedKeyError(f"is no file of {_SIZE} bytes")
    return key


def _make(path: Path) -> None:
    """Make a key, complete or not at all, unless another process has just made it. Raises ``OSError``."""
    make_folder(path.parent)
    temporary = temporary_beside(path)
    try:
        write_new_file(temporary, os.urandom(_SIZE), durable=True)
        with suppress(FileExistsError):
            _publish(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
