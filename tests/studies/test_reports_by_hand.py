"""Lines of several reports from summaries that are made by hand, and questions of a few studies that do not fit."""

from __future__ import annotations

from typing import Any

import pytest
import xarray as xr
from tests.hand_made import answered, titled
from tests.refusals import refused

from wucht.studies.registry import study_of
from wucht.studies.shared_keys import Woehler, woehler_line, woehler_validator

AT = "10 rad/s (95 rpm)"


def lines(kind: str, dimensionless: bool = False, data: Any = None, /, **summary: Any) -> list[str]:
    made = titled(answered(xr.Dataset(data or {}), summary, dimensionless=dimensionless), dimensionless)
    told: list[str] = study_of(kind).drawer.report(made)
    return told


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
