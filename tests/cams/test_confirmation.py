"""A prediction simulated in time: in closed form, off its prediction, given up, stopped."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from wucht.cams.confirmation import confirmation
from wucht.cams.correction import CorrectedLaw
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.prediction import CamShaft, Torque
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

J0, OMEGA = 20.0, 500 * math.pi / 30
SERIES = FourierSeries.of(0.5, [-0.4, 0.1])


def predicted(torque: Torque | None = None) -> tuple[CamShaft, CorrectedLaw, ShaftMotion]:
    camshaft, law = CamShaft(J0, 6.0, OMEGA, torque), equiripple(5, math.radians(120), math.radians(24))
    motion = camshaft.motion_with_corrected_cam(law)
    return camshaft, CorrectedLaw(law, motion), motion


def test_a_simulation_shows_the_last_turn_and_the_deviation_in_all() -> None:
    """A shaft that begins off its steady speed: v = v0 + (v1 - v0) exp(-s t/J0), of an output without inertia."""
    v0, v1, s, turns = 60.0, 50.0, 40.0, 4
    camshaft = CamShaft(J0, 0.0, v0, lambda v: (s * (v0 - v), -s + 0 * v))
    made_of = confirmation(camshaft, SERIES, ShaftMotion(FourierSeries.of(v1)), turns, lambda share: None)
    period = 2 * math.pi / v1
    time = period * (turns - 1 + np.arange(2048) / 2048)
    v, phi = v0 + (v1 - v0) * np.exp(-s * time / J0), v0 * time - (v0 - v1) * J0 / s * (1 - np.exp(-s * time / J0))
    expected = FourierSeries.from_samples(v)
    assert made_of.speed.mean == pytest.approx(expected.mean, rel=1e-10)
    assert made_of.speed.amplitudes == pytest.approx(expected.amplitudes, abs=1e-9)
    assert made_of.deviation == pytest.approx((v0 - v1) * (1 - math.exp(-s * period * turns / J0)) / v1, rel=1e-9)
    slope, bend = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)
    expected = FourierSeries.from_samples((bend * v**2 + slope * s * (v0 - v) / J0) / v1**2)
    assert made_of.acceleration.amplitudes[:20] == pytest.approx(expected.amplitudes[:20], rel=1e-8)


def test_a_simulation_that_stays_behind_departs_as_one_that_leads() -> None:
    """The speed computed for another output: below that predicted, or above it; the deviation is a size."""
    shaft, cam, motion = predicted()
    for factor in (0.9, 1.1):
        other = replace(shaft, inertia=factor * shaft.inertia)
        assert confirmation(other, cam, motion, 1, lambda share: None).deviation > 1e-4


def test_a_simulation_that_would_not_end_is_given_up_and_says_so() -> None:
    """A torque that falls by 1e5 N m for each rad/s: a step must be shorter than its time constant."""
    stiff = lambda v: (1e5 * (OMEGA - v), np.full(np.shape(v), -1e5))  # noqa: E731
    found = confirmation(*predicted(stiff), 20, lambda share: None, most_calls=2500)
    assert math.isnan(found.deviation)
    assert found.failure.startswith("fails in turn 1 of 20: a turn takes more than 2500 evaluations")
    assert not confirmation(*predicted(), 1, lambda share: None, most_calls=2500).failure


def test_a_simulation_reports_and_can_be_stopped() -> None:
    shares = []

    def stop(share: float) -> None:
        shares.append(share)
        if len(shares) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        confirmation(*predicted(), 20, stop)
    assert 0 < shares[0] < shares[3] < 0.2
