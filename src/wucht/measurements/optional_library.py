"""Libraries that come with the extra ``measure``, and what they raise on broken files, in our words."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from wucht.errors import InputError


def library(name: str, path: Path) -> Any:
    """The module that reads a file. Raises ``InputError`` if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(str(path), None, f"reading {path.suffix} needs the extra: pip install wucht[measure]") from None


@contextmanager
def reading(path: Path, what: str) -> Iterator[None]:
    """Whatever a library raises on a file becomes one ``InputError``: on a broken one it may be anything. what: it is to be."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [""])[0]
        raise InputError(
            str(path), None, f"this cannot be read as {what}: {reason or type(error).__name__}", code="unreadable"
        ) from None


def unique(names: list[str], longer: list[str]) -> list[str]:
    """The names, and where several are alike or empty, the longer ones."""
    return [name if name and names.count(name) == 1 else other for name, other in zip(names, longer, strict=True)]
