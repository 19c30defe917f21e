"""Numbers at the end of a run are those of its final window, also of rotors that do not turn together."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from wucht import RunUp
from wucht.files.catalogue import load_document, machine_of
from wucht.studies.runner import report, run

LOST = {"parameter": "drives.e2.voltage", "points": [[0.0, 230.0], [5.0, 0.0]], "interpolation": "steps"}
START = {"e1": -1.5708, "e2": -1.5708}


@pytest.fixture(scope="module")
def without_second_motor() -> xr.Dataset:
    """A screen whose second motor loses its voltage at 5 s: the rotor passes the resonances and comes to a stop by 12 s."""
    document, path = load_document("practice/screen-unsynchronised")
    machine = machine_of({"machine": document["machine"] | {"schedules": [LOST]}}, path, "screen", {})[0]
    return run(RunUp(until=15.0, start=START), machine)


def test_stroke_and_amplitude_are_those_of_the_last_twentieth(without_second_motor: xr.Dataset) -> None:
    """0.71 s of 14.2 s of turns; over the last half the stroke was 7.8 mm."""
    result, s = without_second_motor, without_second_motor.wucht.summary
    turns = (result.angle.sel(body="e1") - result.angle.sel(body="e1")[0]).values / (2 * np.pi)
    last = turns >= 0.95 * turns[-1]
    x, y = (result.displacement.sel(direction=d).values[last] for d in "xy")
    angles = np.linspace(0.0, np.pi, 721)
    widths = np.array([np.ptp(x * np.cos(a) + y * np.sin(a)) for a in angles])
    assert s["outcome"] == "not-synchronised" and s["rotor_outcomes"]
    assert s["stroke"] == pytest.approx(widths.max(), rel=0.02) and s["stroke"] < 3e-3
    assert s["final_amplitude"] == pytest.approx(result.amplitude.values[last].mean(), rel=0.015)
    assert abs(s["mean_speeds"]["e2"]) < 1.0 and s["mean_speeds"]["e1"] == pytest.approx(155.3, abs=0.1)


def test_an_amplitude_that_still_decays_is_not_reported_as_settled(without_second_motor: xr.Dataset) -> None:
    assert without_second_motor.wucht.summary["amplitude_settling_time"] is None
    assert next(x for x in report(without_second_motor) if "settled at" in x).endswith("s, the speed")
