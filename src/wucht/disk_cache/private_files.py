"""Files and folders of the user that nobody else can write."""

from __future__ import annotations

import os
import stat
import sys
import warnings
from functools import cache
from pathlib import Path

WINDOWS = sys.platform == "win32"
_BINARY = getattr(os, "O_BINARY", 0)  # on Windows
# Neither a link is followed, nor a pipe waited for.
_READ_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | _BINARY
_CREATE_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY


def make_folder(folder: Path) -> None:
    """Make a folder that only the user can read, unless it is there. Raises ``OSError``."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)


def privacy_problem(path: Path, status: os.stat_result) -> str | None:
    """Describe why a file or folder is not the user's, or may be written by others.

    None if nothing. On Windows its place decides.
    """
    if WINDOWS:
        return None if path.resolve().is_relative_to(Path.home()) else "is not in your profile folder"
    is_private = status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return None if is_private else "is not yours alone (others may write there)"


def read_file(path: Path, limit: int) -> tuple[bytes, os.stat_result]:
    """Read a regular file, once, with its status. Raises ``OSError``, and ``ValueError`` for anything else or above the limit.

    limit: in bytes.
    """
    with os.fdopen(os.open(path, _READ_FLAGS), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or status.st_size > limit:
            raise ValueError(f"{path} is not a regular file of at most {limit} bytes")
        return file.read(limit), status


def write_new_file(path: Path, content: bytes, durable: bool = False) -> None:
    """Write a file that is not there yet and that only the user can read. Raises ``OSError``.

    durable: wait until it is on the disk.
    """
    with os.fdopen(os.open(path, _CREATE_FLAGS, 0o600), "wb") as file:
        file.write(content)
        if durable:
            file.flush()
            os.fsync(file.fileno())


def temporary_beside(path: Path) -> Path:
    """A path that is not in use, in the same folder."""
    return path.with_name(f"{path.name}.{os.urandom(8).hex()}")


@cache
def warn_once(message: str) -> None:
    """Warn once in a process."""
    warnings.warn(message, RuntimeWarning, stacklevel=2)
