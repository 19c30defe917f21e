"""The design is compared with its neighbours in the full equations, over beats that the search has not counted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import wucht
from wucht.studies.exciter_design.spec import ExciterDesign
from wucht.studies.load_spectrum.study import LoadSpectrum

TARGET = [["0.7 mm", 2e6], ["1.0 mm", 1.4e6], ["1.4 mm", 6e5], ["1.7 mm", 2.5e5], ["1.9 mm", 4e4]]
SMALL: dict[str, Any] = {
    "target": TARGET, "vary": {"p1.mass": ["0.3 kg", "3 kg"]}, "signal": "displacement", "direction": "x", "reach": 4,
    "evaluations": 4, "population": 4, "candidates": 1, "polish": 12, "corrections": 1, "beats": 8, "samples": 8,
}  # fmt: skip


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return wucht.run(ExciterDesign(**SMALL), wucht.load_machine("practice/exciter"))


def test_no_neighbour_that_is_shown_is_nearer(result: xr.Dataset) -> None:
    s = result.wucht.summary
    rows = {what: [r["distance"] for r in s["compared"] if r["what"] == what] for what in ("design", "neighbour", "as it is")}
    assert rows["design"] == [s["distance"]] and len(rows["neighbour"]) == 2 and len(rows["as it is"]) == 1
    assert s["distance"] <= min(r["distance"] for r in s["compared"] if r["distance"] is not None)
    ends = [100 * f(rows["neighbour"]) for f in (min, max)]
    assert f"; 2 % away from it within {ends[0]:.2f} to {ends[1]:.2f} %" in s["sentence"]


def test_its_distance_is_that_of_later_beats(result: xr.Dataset) -> None:
    """Beats 9 to 16 of an own run, counted by the study of load spectra, against the amplitudes that are wanted."""
    s = result.wucht.summary
    machine = wucht.load_machine("practice/exciter").with_values(s["parameters"])
    shown = result.turning_value.values
    assert np.abs(shown).max() == pytest.approx(s["upper"], rel=0.02), "the beat is one of the full equations"
    assert np.abs(shown).max() < 0.97 * result.beat_amplitude.values.max(), "those of the averaged ones are larger"
    assert result.turning_time.values[-1] <= s["beat"] and len(shown) == pytest.approx(2 * s["cycles_per_beat"], abs=4)
    run = wucht.run(LoadSpectrum(signal="displacement", direction="x", until=40 * s["beat"]), machine).wucht.summary
    largest = max(row["range"] for row in run["spectrum"]) / 2
    assert largest == pytest.approx(s["upper"], rel=0.05)
