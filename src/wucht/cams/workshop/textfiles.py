"""Text files for programs of the workshop."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wucht.errors import InputError
from wucht.results.store import replace_file


def write_ascii(path: Path, text: str) -> Path:
    """Write a text: ASCII, as controllers and old CAM programs read it. Raises ``InputError`` for other
    letters, ``RunError`` where it cannot be written."""
    if not text.isascii():
        raise InputError(str(path), None, "names in files for the workshop must be of plain ASCII characters")
    return replace_file(path, lambda beside: beside.write_text(text, encoding="ascii", newline="\n"))


def format_decimals(values: np.ndarray, decimals: int) -> list[str]:
    """Return numbers (N,) with so many decimals; never a minus before a zero."""
    return [f"{v:.{decimals}f}" for v in np.round(values, decimals) + 0.0]
