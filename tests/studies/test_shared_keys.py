"""Keys that several studies share: Woehler lines, and questions of a few studies that do not fit."""

from __future__ import annotations

from typing import Any

import pytest
from tests.refusals import refused

from wucht.studies.shared_keys import Woehler, woehler_line, woehler_validator


def test_woehler_lines() -> None:
    read: Any = woehler_validator("study.woehler").func
    line = read({"k": 5, "ND": 1e6, "SD": "8 mm"})
    assert isinstance(line, Woehler) and read(line) is line and read(None) is None
    with pytest.raises(ValueError, match=r"^must be a table: woehler = \{ k = SLOPE"):
        read(3)
    assert pytest.approx(8e-3) == woehler_line(line, "m", "study.woehler").SD
    for knee in ("0 mm", "-1 mm"):
        with refused("study.woehler.SD", "greater than 0", given=knee):
            woehler_line(read({"k": 5, "ND": 1e6, "SD": knee}), "m", "study.woehler")
