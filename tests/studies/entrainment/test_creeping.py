"""Just beyond the band of existence a phase creeps for long past where it could have rested: that is no lock.

Two exciters on motors so stiff that they are entrained from rest wherever the locked motion exists: the bands are the same.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht import Entrainment, Machine, run
from wucht.dynamics.entrainment.runs_from_start import RunsFromStart
from wucht.dynamics.verdicts.locking import LockingAssessment, assess_locking
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver
from wucht.files.building import machine_from
from wucht.numerics.observers.turns import Samples

ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
START = {"e1": {"speed": 12.0}, "e2": {"angle": 0.5, "speed": 12.0}}
FOLD = 0.33307  # rad/s, between which motors the locked motion exists
FREQUENCY = 6.0


def _exciters() -> Machine:
    carrier = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
    drives = [{"on": n, "kind": "linear", "slope": 3e-4, "no_load_speed": w} for n, w in (("e1", 12.0), ("e2", 12.1))]
    return machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "e1"}, ROTOR | {"name": "e2"}], "drives": drives})


# --- runs from the start ---


@pytest.mark.parametrize(
    ("share", "entrained", "sign"), [(0.99, True, 1.0), (1 + 1e-4, False, 1.0), (1 + 1e-4, False, -1.0), (1.01, False, 1.0)]
)
def test_a_run_beyond_the_fold_is_not_entrained(share: float, entrained: bool, sign: float) -> None:
    """It lasts for 320 s: at 1 + 1e-4 times the fold the phase takes 1300 s for a turn, most of it where it would rest."""
    runs = RunsFromStart(Entrainment.from_table({"start": START, "until": 10.0, "range": [-0.4, 0.4]}).prepare(_exciters()))
    assert runs(sign * share * FOLD, lambda _: None).is_entrained is entrained


def _beyond(**table: Any) -> float:
    """By how much the band from the start goes beyond that of the locked motions."""
    summary = run(Entrainment.from_table({"start": START, "points": 5} | table), _exciters()).wucht.summary
    least, most = summary["existence_band_full"]
    low, high = summary["band_from_rest"]
    assert (least, most) == pytest.approx((-FOLD, FOLD), abs=5e-6)
    assert (low, high) == pytest.approx((-FOLD, FOLD), rel=5e-3)
    return float(max(least - low, high - most))


@pytest.mark.slow
def test_the_band_from_the_start_lies_within_the_band_of_existence() -> None:
    assert _beyond(resolution=3e-7) <= 1e-6 * FOLD


# --- what is seen of a phase ---


def _seen(time: np.ndarray, phase: np.ndarray, rate: np.ndarray) -> LockingAssessment:
    """Of a rotor at a phase (N,) to a vibration."""
    motion = {"direction": "x", "amplitude": 1e-3, "frequency": FREQUENCY}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "motion": motion},
        "bodies": [ROTOR | {"name": "r"}],
        "drive": {"kind": "linear", "slope": 3e-5, "no_load_speed": 6.1},
    })  # fmt: skip
    watch = MotionObserver(machine, 2 * math.pi / FREQUENCY, Noise.of())
    seen = assess_locking(
        machine, watch.update_from_samples(watch.begin(), Samples.of(time, (FREQUENCY * time + phase, FREQUENCY + rate)))
    )
    assert seen is not None
    return seen


def _samples(end: float) -> np.ndarray:
    return np.linspace(0.0, end, math.ceil(16 * end * FREQUENCY / (2 * math.pi)) + 1)


@pytest.mark.parametrize("slow", [0.3, 0.05])
@pytest.mark.parametrize(("beyond", "share"), [(1e-2, 0.6), (1e-2, 0.9), (1e-4, 0.8), (1e-5, 0.9)])
def test_a_phase_that_creeps_past_the_bottleneck_is_not_locked(beyond: float, share: float, slow: float) -> None:
    """phi' = slow (a - sin phi), a = 1 + beyond, from 0 on for such a share of a period: beyond pi/2, where it is slowest.

    tan(phi/2) = (1 + q tan(slow q t/2 - atan(1/q)))/a, q = sqrt(a^2 - 1).
    """
    a = 1 + beyond
    q = math.sqrt(a * a - 1)
    time = _samples(share * 2 * math.pi / (slow * q))
    phase = 2 * np.arctan((1 + q * np.tan(slow * q * time / 2 - math.atan(1 / q))) / a)
    assert math.pi / 2 < phase[-1] < 0.75 * math.pi
    seen = _seen(time, phase, slow * (a - np.sin(phase)))
    assert seen.evidence.periods > 30
    assert seen.evidence.is_locked is not True


@pytest.mark.parametrize("slow", [0.3, 0.05])
@pytest.mark.parametrize("within", [1e-1, 1e-2, 1e-3])
def test_a_phase_that_comes_to_rest_within_the_band_is_locked(within: float, slow: float) -> None:
    """phi' = slow (a - sin phi), a = 1 - within, for thirty of its decay times: at rest to 1e-6."""
    a = 1 - within
    q = math.sqrt(1 - a * a)
    time = _samples(30 / (slow * q))
    e = (1 - q) / (1 + q) * np.exp(-slow * q * time)  # tan(phi/2) = (1 - q (1 + e)/(1 - e))/a
    phase = 2 * np.arctan((1 - q * (1 + e) / (1 - e)) / a)
    assert math.sin(phase[-1]) == pytest.approx(a, abs=1e-9)
    seen = _seen(time, phase, slow * (a - np.sin(phase)))
    assert seen.evidence.is_locked is True
    assert seen.creep < 1e-4
    assert seen.phases["vibration"] == pytest.approx(math.asin(a), abs=1e-6)
