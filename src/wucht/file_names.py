"""Names of files that are made of what a file or a user says: never a path, and good on every system."""

from __future__ import annotations

import re
import unicodedata

_ALLOWED = re.compile(r"[^\w.+ -]+")
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # which Windows keeps for itself
_LONGEST, _MOST_BYTES = 100, 200  # characters and bytes: endings are added, and file systems end at 255 bytes
UNNAMED = "unnamed"


def safe_name(text: str) -> str:
    """A text as the name of a file or folder: of letters, digits, blanks and ``_ . + -``, stretches of others being ``-``."""
    short = _ALLOWED.sub("-", text)[:_LONGEST].encode("utf-8", "replace")[:_MOST_BYTES].decode("utf-8", "ignore")
    name = short.strip(".- ")
    return UNNAMED if not name else f"{name}-" if _DEVICES.fullmatch(name) else name


def printable(name: str) -> str:
    """The name of a file in a text: bytes of it that are no UTF-8, and control characters, are replaced."""
    return "".join("?" if unicodedata.category(c) == "Cc" else c for c in in_utf8(name))


def in_utf8(text: str) -> str:
    """A text in which bytes of the name of a file that are no UTF-8 are replaced."""
    return text.encode("utf-8", "replace").decode("utf-8")
