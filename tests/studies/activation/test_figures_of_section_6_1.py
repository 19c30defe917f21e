"""002, figures 6.1 to 6.5, which are qualitative: what the text says of them, with the numbers of our own machine.

The peaks were confirmed by run-ups of the machines themselves (``test_activation.py``); six digits of this program.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import RunUp, run
from wucht.studies.study_file import read_study

NONE, ALIGNED = 4.42584e-3, 4.68467e-3


@cache
def ran(name: str) -> xr.Dataset:
    study = read_study(f"drozdetskaya-2020/{name}")
    return run(study.spec, study.subject)


def numbers(name: str) -> dict[str, Any]:
    summary = ran(name).wucht.summary
    assert summary["energy_residual"] < 5e-11
    return summary


@pytest.mark.slow
def test_rigid_pendulums_more_than_treble_the_peak() -> None:
    """Figure 6.1, with a motor that gets through the resonance: it compensates all the same."""
    s = numbers("figure-6.1")
    assert s["none"]["peak_amplitude"] == pytest.approx(NONE, rel=1e-4)
    (rigid,) = s["rigid"]
    assert rigid["peak_amplitude"] == pytest.approx(0.0142000, rel=1e-3)
    assert rigid["outcomes"] == {"compensated": 1}
    assert s["switchable"] == []


def test_with_switchable_pendulums_the_amplitude_follows_that_without_any_until_they_open() -> None:
    """Figure 6.2b: up to the activation speed within what their inertia, which slows the run-up, does; then compensation."""
    s, result = numbers("figure-6.2"), ran("figure-6.2")
    (switchable,) = s["switchable"]
    assert switchable["peak_amplitude"] == pytest.approx(4.68549e-3, rel=1e-4)
    assert switchable["peak_before"] == pytest.approx(4.68549e-3, rel=1e-4)
    assert switchable["peak_after"] < 0.75 * switchable["peak_before"]
    assert switchable["opened_at"] == pytest.approx(150.0, rel=0.02)
    assert switchable["outcomes"] == {"compensated": 1}
    assert float(result.final_amplitude[0, 0, 0]) < 1e-6
    assert s["rigid"][0]["peak_amplitude"] > 3 * switchable["peak_amplitude"]
    assert s["pendulums"][0]["opening"] == [pytest.approx(150.0)]
    assert s["pendulums"][0]["closing"] == [pytest.approx(119.373, rel=1e-5)]


@pytest.mark.slow
def test_opposite_orientation_is_the_best() -> None:
    """Figure 6.3: the nearer to 180 degrees, the lower the peak, which there is that of the resonance; so for any phase."""
    s, result = numbers("figure-6.3"), ran("figure-6.3")
    peaks = [g["peak_amplitude"] for g in s["switchable"]]
    assert peaks == pytest.approx([8.537e-3, 8.301e-3, 7.781e-3, 6.378e-3, ALIGNED], rel=2e-3)
    assert s["best"]["orientation"] == pytest.approx(math.pi)
    assert s["best"]["peak_after"] < s["best"]["peak_before"]
    assert np.ptp(result.peak.values[0, -1]) < 1e-5 * ALIGNED
    assert np.ptp(result.peak.values[0, 0]) > 1e-3
    # Nothing turns closed pendulums against each other: they open as they started.
    at = result.orientation_at_activation.values[0]
    assert np.cos(at) == pytest.approx(np.cos(np.repeat(result.orientation.values[:, None], 4, axis=1)), abs=2e-2)
    assert [g["outcomes"] for g in s["switchable"]] == [{"compensated": 4}] * 5


@pytest.mark.slow
def test_small_permanent_unbalances_bring_them_into_opposition() -> None:
    """Figures 6.4 and 6.5: from 20 degrees as from 180 they open in opposition; without them as they stand."""
    s = numbers("figure-6.5")
    assert [g["orientations_at_activation"][0] for g in s["switchable"]] == pytest.approx([math.pi] * 2, abs=0.02)
    assert [g["orientations_at_activation"][0] for g in s["balanced"]] == pytest.approx(np.radians([20, 180]), abs=0.05)
    assert [g["peak_amplitude"] for g in s["switchable"]] == pytest.approx([4.21718e-3] * 2, rel=1e-3)
    assert [g["peak_amplitude"] for g in s["balanced"]] == pytest.approx([6.321e-3, 4.962e-3], rel=2e-3)
    assert all(g["peak_after"] < 0.85 * g["peak_before"] for g in s["switchable"])
    assert all(g["outcomes"] == {"compensated": 1} for g in (*s["switchable"], *s["balanced"]))


@pytest.mark.slow
def test_the_permanent_unbalances_raise_the_amplitude_below_the_resonance() -> None:
    """As 002 says. While the drum waits at 90 rad/s both stand where they add to the drum's unbalance."""
    study = read_study("drozdetskaya-2020/figure-6.5")
    start = {"p1": 0.0, "p2": math.radians(20.0)}
    amplitudes = []
    for share in (1.0, 0.0):
        unbalances = {f"p{k}.permanent_unbalance": sign * share * 1e-3 for k, sign in ((1, 1.0), (2, -1.0))}
        waiting = run(RunUp(until="20 s", start=start), study.subject.with_values(unbalances))
        amplitudes.append(float(waiting.amplitude[-1]))
    w = float(waiting.speed[0, -1]) / 100  # the vibration holds the motor a little below 90 rad/s
    assert 0.87 < w < 0.9
    assert amplitudes[1] == pytest.approx(9.75e-4 * w**2 / math.hypot(1 - w**2, 0.2 * w), rel=1e-3)
    assert amplitudes[0] == pytest.approx(1.123 * amplitudes[1], rel=2e-3)


@pytest.mark.slow
def test_the_later_they_open_the_lower_the_peak() -> None:
    """At 105 rad/s, next to the resonance, they are nearly as bad as rigid ones; in opposition the speed does not matter."""
    result = ran("switchable-activation-speeds")
    worst = result.peak.values.max(axis=2)
    assert worst[:, 2] == pytest.approx([ALIGNED] * 6, rel=1e-3)
    assert (np.diff(worst[:, :2], axis=0) < 0).all()
    assert worst[0, 0] > 0.9 * float(result.rigid_peak.max())
    assert worst[-1, 1] == pytest.approx(ALIGNED, rel=1e-3)
    warned = [w for w in result.wucht.warnings if "repeatedly" in w]
    assert len(warned) == 4
