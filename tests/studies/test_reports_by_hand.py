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


def test_a_map_of_basins() -> None:
    level = {"cells": [4, 6], "fractions": {"passed": 0.25, "unidentified": 0.5}}
    given: dict[str, Any] = {
        "levels": [level], "axes": {"psi": {}, "delta": {}}, "fractions": level["fractions"],
        "bound": {"passed": 0.02, "unidentified": 0.03}, "runs": 24, "runs_of_dense_map": 96, "integration": "in batches",
        "followed": {"unidentified": [1.5, 1.5]}, "time_unit": "s", "failures": 2, "sentence": "",
    }  # fmt: skip
    _, verdict, *told = lines("basin", **given)
    assert verdict == "verdict: nothing is computed yet"
    assert told == [
        "  map          4 x 6 cells over psi and delta",
        "  runs         24, instead of 96 with one in each cell of the finest map",
        "  shares       ± holds in 19 of 20 cases; the error is at most 3 % if the map resolves the borders",
        "  integrated   in batches",
        "  unidentified 50 % of the map, integrated until 1.5 s",
        "  failed       2 runs: see the warnings",
    ]
    finer = {"cells": [8, 12], "fractions": {"passed": 0.125, "unidentified": 0.5}}
    more = given | {
        "levels": [level, finer],
        "runs": 96,
        "followed": {"unidentified": [1.5, 2.0]},
        "time_unit": "",
        "failures": 1,
    }
    told = lines("basin", **more)[2:]
    assert told[0] == "  map          4 x 6 cells over psi and delta, at the borders halved to those of 8 x 12"
    assert told[1] == "  runs         96"
    assert told[3:5] == ["  by level     passed 25 %, 12.5 %", "               unidentified 50 %, 50 %"]
    assert told[-2:] == ["  unidentified 50 % of the map, integrated until 1.5 to 2", "  failed       1 run: see the warnings"]


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
