"""Names of files made from text of a file or a user: never a path, and valid on every system; and the date they state."""

from __future__ import annotations

import os
import re
import unicodedata
from datetime import UTC, datetime

from wucht.errors import InputError

_FORBIDDEN = re.compile(r"[^\w.+ -]+")
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # reserved by Windows
_LONGEST, _MOST_BYTES = 100, 200  # characters and bytes: endings are added, and file systems end at 255 bytes
DEFAULT_NAME = "unnamed"
_EPOCH = "SOURCE_DATE_EPOCH"  # read by other libraries too: when they are loaded, and when a figure is written
_LAST_SECOND = 253402300799  # of the year 9999, the last that a date can have


def safe_name(text: str) -> str:
    """A text as the name of a file or folder: of letters, digits, blanks and ``_ . + -``, runs of others being ``-``."""
    short = _FORBIDDEN.sub("-", text)[:_LONGEST].encode("utf-8", "replace")[:_MOST_BYTES].decode("utf-8", "ignore")
    name = short.strip(".- ")
    return DEFAULT_NAME if not name else f"{name}-" if _DEVICES.fullmatch(name) else name


def printable(name: str) -> str:
    """The name of a file for printing: bytes that are not UTF-8, and control characters, are replaced."""
    return "".join("?" if unicodedata.category(c) == "Cc" else c for c in replace_non_utf8(name))


def replace_non_utf8(text: str) -> str:
    """Replace bytes of a file name that are not UTF-8."""
    return text.encode("utf-8", "replace").decode("utf-8")


def date_of_files() -> datetime:
    """Return the date that files state which are written now, in UTC.

    Returns
    -------
    datetime.datetime
        That of the environment variable SOURCE_DATE_EPOCH, in seconds since 1970, so that equal input gives equal files; now
        where it is not set.

    Raises
    ------
    InputError
        (SOURCE_DATE_EPOCH) Where it is no such number.
    """
    value = os.environ.get(_EPOCH)
    if value is None:
        return datetime.now(UTC)
    if not (value.isascii() and value.isdigit() and int(value[:20]) <= _LAST_SECOND):
        requirement = f"this environment variable must be seconds since 1970, a number from 0 to {_LAST_SECOND}, or not be set"
        raise InputError(_EPOCH, value, requirement)
    return datetime.fromtimestamp(int(value), UTC)
