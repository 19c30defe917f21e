"""Names of files that are made of what a file or a user says: never a path, and good on every system."""

from __future__ import annotations

import re

_ALLOWED = re.compile(r"[^\w.+ -]+")
_DEVICES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)  # which Windows keeps for itself
_LONGEST = 100  # characters: endings are added, and file systems end at 255 bytes
UNNAMED = "unnamed"


def safe_name(text: str) -> str:
    """A text as the name of a file or folder: of letters, digits, blanks and ``_ . + -``, stretches of others being ``-``."""
    name = _ALLOWED.sub("-", text)[:_LONGEST].strip(".- ")
    return UNNAMED if not name else f"{name}-" if _DEVICES.fullmatch(name) else name


def printable(name: str) -> str:
    """The name of a file in a text: bytes of it that are no UTF-8 are replaced."""
    return name.encode("utf-8", "replace").decode("utf-8")
