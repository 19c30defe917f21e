"""The depth of a modulation, apart from what the speed does within a turn."""

import math

import numpy as np
import pytest

from wucht import RunUp
from wucht.files.building import machine_from
from wucht.studies.runner import report, run


@pytest.mark.parametrize(("gravity", "sense"), [(0.0, -1), (9.81, 1)])
def test_the_ripple_within_a_turn_is_no_modulation(gravity: float, sense: int) -> None:
    """A rotor at w beside a vibration x0 cos(W t) beats: its torque U x0 W^2 sin(phi) cos(W t) has a slow part of half that.

    J s' = -D s + (U x0 W^2/2) sin((w - W) t), whose speed s, averaged over a turn, is sinc((w - W)/w) times as large. Gravity
    adds a ripple of U g/(J w^2), here seventeen times the modulation.
    """
    inertia, unbalance, slope, drive, frequency, amplitude = 3e-4, 1e-2, 3e-4, 60.0, 54.0, 4e-5
    machine = machine_from({
        "carrier": {"directions": "x", "gravity": gravity,
                    "motion": {"direction": "x", "amplitude": amplitude, "frequency": frequency}},
        "bodies": [{"kind": "rotor", "name": "r", "mass": 1.0, "unbalance": unbalance, "inertia": inertia}],
        "drive": {"kind": "linear", "slope": slope, "no_load_speed": sense * drive},
    })  # fmt: skip
    result = run(RunUp(until=40.0, start={"r": {"speed": sense * drive}}), machine)
    summary = result.wucht.summary
    speed = sense * summary["final_speed"]
    beat = speed - frequency
    swing = unbalance * amplitude * frequency**2 / 2 / inertia / math.hypot(beat, slope / inertia) * np.sinc(beat / speed)
    assert summary["modulation_period"] == pytest.approx(2 * math.pi / beat, rel=2e-3)
    assert summary["modulation_depth"] == pytest.approx(swing / speed, rel=0.01)
    within = (summary["max_speed"] - summary["min_speed"]) / (2 * speed)
    assert within - summary["modulation_depth"] == pytest.approx(unbalance * gravity / inertia / speed**2, abs=1e-3)
    assert summary["min_speed"] < summary["final_speed"] < summary["max_speed"]
    assert any(f"+-{100 * summary['modulation_depth']:.2g} %" in line for line in report(result) if "modulation" in line)
