"""Lines of several reports from summaries that are made by hand, and questions of a few studies that do not fit."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import answered, titled
from tests.refusals import refused

from wucht.results.quantities import Quantity, StudyResult
from wucht.studies.registry import study_of
from wucht.studies.run_up import combined_runs
from wucht.studies.run_up.combined_runs import join_models
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


def test_an_averaged_run_that_fails_is_a_warning_of_the_full_one(monkeypatch: pytest.MonkeyPatch) -> None:
    speed, radius = (
        Quantity("speed", [[1.0, 2.0, 3.0]], "speed", "rad/s", "body time"),
        Quantity("radius", [0.0] * 3, "r", "m", "time"),
    )
    full = StudyResult([speed, radius], "full", ["w"])
    slow = StudyResult([replace(speed, value=[[5.0, 6.0]]), replace(radius, value=[7.0, 8.0])], "slow", failure="it burst")
    motions = [SimpleNamespace(), SimpleNamespace()]
    assert join_models(motions[:1], [full]) is full  # type: ignore[arg-type]
    monkeypatch.setattr(combined_runs, "compared_motion", lambda motion: None)
    for name in ("deviations_by_angle", "deviations_by_phase"):
        monkeypatch.setattr(combined_runs, name, lambda *courses: None)
    both = join_models(motions, [full, slow])  # type: ignore[arg-type]
    assert both.warnings == ["w", "averaged equations: it burst"]
    assert both.attributes == {"model": "both"}
    result = both.to_dataset()
    assert result.slow_speed.values[0, :2].tolist() == [5.0, 6.0]
    assert np.isnan(result.slow_speed.values[0, 2])
    assert result.slow_radius.dims == ("time",)
    assert result.slow_speed.attrs == {"long_name": "speed, averaged equations", "units": "rad/s"}
    assert result.wucht.summary["slow"] == {"sentence": "slow"}
    assert result.wucht.summary["deviations"] == {"at_equal_angle": None, "at_equal_phase": None}
