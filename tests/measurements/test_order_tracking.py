"""Signals over the angle of a shaft."""

import numpy as np
import pytest
from known_motion import OMEGA, PERIOD, TURN, angle_at, angle_record, channel, pulse_record, speed_record, times_of
from tests.refusals import refused

from wucht.measurements.order_tracking import track_orders
from wucht.measurements.shaft_signal import ShaftSignal, angle_signal
from wucht.numerics.fourier_series import FourierSeries

T = np.linspace(0, 12.4 * PERIOD, 12000)
TRUE = FourierSeries.of(0.7, [1.0, 0.0, -0.5], [0.2, 0.0, 0.0, 0.8])


def tracked_of(values, shaft=None, per_turn=32, t=T):
    return track_orders(channel(t, values, "m/s^2", "vibration"), shaft or angle_record(T), per_turn)


def test_a_signal_of_whole_orders():
    found = tracked_of(TRUE(angle_at(T)))
    assert (found.per_turn, found.turns, len(found.values)) == (32, 12, 384)
    assert found.values == pytest.approx(TRUE(found.angle), abs=1e-7)
    assert angle_at(found.time) == pytest.approx(found.angle, abs=1e-7)
    turn = found.mean_turn()
    assert turn.mean == pytest.approx(0.7, abs=1e-7)
    assert turn.cosine[:4] == pytest.approx([1, 0, -0.5, 0], abs=1e-7)
    assert turn.sine[:4] == pytest.approx([0.2, 0, 0, 0.8], abs=1e-7)
    assert turn.count == 15


def test_the_speed_varies_as_it_may():
    """A run-up: over time no order is a line, over the angle each is."""
    t = np.linspace(0, 2, 40000)
    angle = 20 * t + 40 * t**2
    shaft = angle_signal(channel(t, angle, "rad", "angle"))
    spectrum = tracked_of(np.cos(3 * angle) + 0.5 * np.sin(2.5 * angle), shaft, 16, t).spectrum()
    assert spectrum.orders[1] == pytest.approx(1 / 31)
    lines = np.argsort(spectrum.amplitudes)[-1:]
    assert spectrum.orders[lines] == pytest.approx([3])
    whole = tracked_of(np.cos(3 * angle), shaft, 16, t).spectrum()
    assert np.sort(whole.amplitudes)[-2:] == pytest.approx([0, 1], abs=1e-6)


def test_orders_between_whole_ones():
    """Order 2.5 in an even number of turns, as of a belt."""
    found = tracked_of(0.5 * np.sin(2.5 * angle_at(T))).spectrum()
    assert found.orders[30] == 2.5
    assert found.sine[30] == pytest.approx(0.5, abs=1e-6)
    assert np.delete(found.amplitudes, 30) == pytest.approx(0, abs=1e-6)
    assert found.orders[-1] < 16


def test_high_orders_are_cut_off_not_folded_back():
    """Order 13 at 16 samples a turn would be seen as order 3."""
    found = tracked_of(np.cos(13 * angle_at(T)) + np.cos(2 * angle_at(T)), per_turn=16)
    assert found.spectrum().orders[-1] < 8
    turn = found.mean_turn().amplitudes
    assert turn[1] == pytest.approx(1, abs=1e-5)
    assert np.delete(turn, 1) == pytest.approx(0, abs=1e-5)
    assert found.values == pytest.approx(np.cos(2 * found.angle), abs=1e-5)


@pytest.mark.parametrize("kind", ["speed", "pulses"])
def test_by_the_speed_and_by_pulses(kind):
    """The angle is then known but for its zero."""
    shaft = speed_record(T) if kind == "speed" else pulse_record(12.3, 64)
    found = tracked_of(TRUE(angle_at(T)), shaft)
    off = angle_at(found.time) - found.angle
    assert np.ptp(off) < 1e-5
    assert found.values == pytest.approx(TRUE(found.angle + off[0]), abs=1e-5)


def test_from_the_index():
    index = times_of(1.0 + TURN * np.arange(12))
    shaft = angle_record(T)
    found = tracked_of(TRUE(angle_at(T)), ShaftSignal(shaft.location, "angle", T, shaft.values, index))
    assert angle_at(found.time[0]) % TURN == pytest.approx(1.0, abs=1e-5)
    assert found.values == pytest.approx(TRUE(found.angle + 1.0), abs=1e-5)


@pytest.mark.parametrize(
    ("shaft", "per_turn", "refusal"),
    [
        (None, 3, refused("r.csv: vibration", given=3, code="whole-number")),
        (None, 16.5, refused("r.csv: vibration", given=16.5, code="whole-number")),
        (None, 2000, refused("r.csv: vibration", "913", given=2000, code="too-few")),
        (angle_record(np.linspace(0, 0.9 * PERIOD, 900)), 16, refused("r.csv: vibration", code="no-turn")),
        (
            angle_record(np.linspace(20 * PERIOD, 25 * PERIOD, 900)),
            16,
            refused("r.csv: vibration", code="other-times"),
        ),
        (
            angle_signal(channel(T, np.sin(OMEGA * T / 4) * 30, "rad", "angle")),
            16,
            refused("r.csv: angle", given=None, code="turns-back"),
        ),
    ],
)
def test_what_cannot_be_tracked(shaft, per_turn, refusal):
    with refusal:
        tracked_of(TRUE(angle_at(T)), shaft, per_turn)
