"""The verdict in words: what an engineer reads first. One file a study."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def verdict_lines(document: dict[str, Any]) -> list[str]:
    """The lines that ``wucht run`` prints for a study."""
    study = import_module(f"{__name__}.{document['study'].replace('-', '_')}")
    found: list[str] = study.lines(document)
    return found
