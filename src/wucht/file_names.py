"""Names of files made from text of a file or a user: never a path, and valid on every system."""

from __future__ import annotations

import re
import unicodedata

_FORBIDDEN = re.compile(r"[^\w.+ -]+")
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # reserved by Windows
_LONGEST, _MOST_BYTES = 100, 200  # characters and bytes: endings are added, and file systems end at 255 bytes
DEFAULT_NAME = "unnamed"


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
