"""Files for other people's programs: written beside their place and moved there, so that they are never half there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from wucht.errors import InputError, RunError


def written(path: Path, write: Callable[[Path], object]) -> Path:
    """Let ``write`` write a file beside its place, and move it there. Raises ``RunError`` where that cannot be done."""
    beside = path.with_name(f".{path.name}.part")
    try:
        write(beside)
        beside.replace(path)
    except OSError as error:
        _remove(beside)
        raise RunError(f"{path} cannot be written: {error.strerror or error}") from None
    return path


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return


def written_text(path: Path, text: str) -> Path:
    """Write a text: ASCII, as controllers and old CAM programs read it. Raises ``RunError``, ``InputError`` as above."""
    if not text.isascii():
        raise InputError(str(path), None, "names in files for the workshop must be plain ASCII letters")
    return written(path, lambda beside: beside.write_text(text, encoding="ascii", newline="\n"))


def read_text(path: Path) -> str:
    """Read a text. Raises ``InputError`` if there is none."""
    if not path.is_file():
        raise InputError(str(path), None, "there is no such file")
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(str(path), None, f"it cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(str(path), None, "it is no text file") from None


def decimal(values: np.ndarray, decimals: int) -> list[str]:
    """Numbers (N,) with so many decimals; never a minus before a zero."""
    return [f"{v:.{decimals}f}" for v in np.round(values, decimals) + 0.0]
