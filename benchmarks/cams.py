"""Cams: synthesis of a motion law, correction with its contours, orders of a record.

Asked: a synthesis of 12 harmonics with 6 restrictions under 0.5 s, correction and contours at 3600 angles under 0.2 s, the
orders of a million samples under 0.5 s. Peers: the correction by SciPy's brentq angle by angle, one FFT of the record.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from benchmarks.timing import processor_time
from wucht.cams.correction import CorrectedLaw
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.measurements.order_fit import fit_orders
from wucht.measurements.recording import Recording
from wucht.measurements.shaft_signal import shaft_signal
from wucht.numerics.fourier_series import FourierSeries

_OMEGA = 500 * math.pi / 30
_SPEED = FourierSeries.of(_OMEGA, [0, 2.4, 1, 0.5, 0.3], [0, 1, -1.3, 0.2, 0.4])
_LAW = HarmonicLawTable(
    harmonics=12,
    objective="least-peak-acceleration",
    restrictions=[
        {"at": "180 deg", "equals": "24 deg"},
        {"on": ["-90 deg", "90 deg"], "equals": 0, "tolerance": "0.02 deg"},
        {"on": ["170 deg", "190 deg"], "min": "23.5 deg"},
        {"of": "velocity", "min": "-40 deg/rad", "max": "40 deg/rad"},
        {"of": "jerk", "min": "-900 deg/rad^3", "max": "900 deg/rad^3"},
        {"min": "-0.5 deg", "max": "24.2 deg"},
    ],
)
_SAMPLES = 1_000_000


def measure() -> Iterator[tuple[str, str]]:
    yield (
        "synthesis, 12 harmonics, 6 restrictions (asked: 500 ms)",
        f"{1e3 * processor_time(lambda: _LAW.make_motion_law('rad'), 5):8.1f} ms",
    )
    phi = 2 * math.pi * np.arange(3600) / 3600
    corrected = processor_time(lambda: _correction(phi), 5)
    yield "correction and both contours at 3600 angles (asked: 200 ms)", f"{1e3 * corrected:8.1f} ms"
    shaft = ShaftMotion(_SPEED)
    begun = time.perf_counter()
    one_by_one = [brentq(lambda tau, at=at: float(shaft.angle(tau)) - at, at - 1, at + 1, xtol=1e-15) for at in phi[:360]]
    by_roots = 10 * (time.perf_counter() - begun)
    together = processor_time(lambda: shaft.time(phi), 5)
    assert np.abs(shaft.time(phi[:360]) - one_by_one).max() < 1e-12
    yield "the time of 3600 cam angles, times faster than one root after the other", f"{by_roots / together:8.0f}"
    signal = _record()
    fitted, transformed = (
        processor_time(lambda: fit_orders(signal, (2, 3, 4, 5)), 3),
        processor_time(lambda: np.fft.rfft(signal.values), 3),
    )
    yield "orders of a million samples (asked: 500 ms)", f"{1e3 * fitted:8.1f} ms"
    yield "the same, times one FFT of the record", f"{fitted / transformed:8.1f}"


def _correction(phi: np.ndarray) -> None:
    law = CorrectedLaw(equiripple(5, math.radians(120), math.radians(24)), ShaftMotion(_SPEED))
    for outer in (False, True):
        cam = RollerCam(law, OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143)), outer=outer)
        cam.contour(phi)
        cam.normal(phi)


def _record():  # type: ignore[no-untyped-def]
    t = np.linspace(0, 10.0, _SAMPLES)
    noise = np.random.default_rng(1).normal(0, 0.5, _SAMPLES)
    recording = Recording.of("record", t, {"speed": _SPEED(_OMEGA * t) + noise}, {"speed": "rad/s"})
    return shaft_signal(recording, "speed")
