"""A record of the acceleration beside the computed one: when a delay counts, how many orders are enough, folded samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.cams.measured_acceleration import MeasuredAcceleration
from wucht.measurements.recording import Channel
from wucht.numerics.fourier_series import FourierSeries


def measured(
    delay: float = 0.0,
    amplitude: float = 1.0,
    noise: float = 0.0,
    above: tuple[float, ...] = (1.0, 0.0),
    channel: Channel | None = None,
    turns: float = 5.0,
) -> MeasuredAcceleration:
    """A record of cos(tau - delay) about 100, of which amplitude cos(tau) is computed."""
    record = FourierSeries.of(100.0, [math.cos(delay)], [math.sin(delay)])
    some = Channel("record", "a", "m/s^2", np.arange(2.0), np.arange(2.0)) if channel is None else channel
    return MeasuredAcceleration(some, record, FourierSeries.of(0.0, [amplitude]), noise, turns, 1.0, 0.25, np.array(above))


def test_a_delay_counts_where_it_explains_noticeably_more() -> None:
    """Of the mean square the delay costs 2 (1 - cos delay): half a percent."""
    enough, less = (math.acos(1 - gain / 2) for gain in (0.00505, 0.00495))
    assert measured(enough).delay == (pytest.approx(enough, abs=1e-6), pytest.approx(1.0))
    assert measured(-enough).delay == (pytest.approx(-enough, abs=1e-6), pytest.approx(1.0))
    assert measured(less).delay is None


def test_a_delay_counts_where_it_explains_most_of_the_record() -> None:
    """An amplitude c explains 2 c - c^2 of the orders, whose power of one half stands beside that of the noise."""
    assert measured(0.5, 1 - math.sqrt(0.495)).delay is not None and measured(0.5, 1 - math.sqrt(0.505)).delay is None
    assert measured(0.5, noise=math.sqrt(0.49)).delay is not None and measured(0.5, noise=math.sqrt(0.51)).delay is None
    assert measured(noise=math.sqrt(0.5)).share_of_record(0.8) == pytest.approx(0.4)


def test_with_too_few_orders_there_is_no_delay() -> None:
    """A tenth of the root mean square may be above the fitted order; enough are those with a hundredth above them."""
    few = measured(0.5, above=(1.0, 0.101, 0.02, 0.0099, 0.0))
    assert (few.delay, few.enough_orders, few.share_above) == (None, 3, 0.101)
    assert measured(0.5, above=(1.0, 0.099, 0.0)).enough_orders is None


@pytest.mark.parametrize(("count", "shown"), [(1000, 1000), (7001, 3000)])
def test_of_a_long_record_some_samples_are_shown_of_a_short_one_all(count: int, shown: int) -> None:
    """Each once, within a turn from its zero on, about the mean; those of a long one from all of it."""
    time = np.linspace(1.0, 3.0, count)
    tau, values = measured(channel=Channel("record", "a", "m/s^2", time, 100.0 + np.arange(count))).folded_samples(3000)
    numbers = values.astype(int)
    assert len(set(numbers.tolist())) == len(values) == shown
    assert numbers.min() < 20 and numbers.max() > count - 20
    assert tau == pytest.approx(np.mod(5 * math.pi * (time[numbers] - 0.25), 2 * math.pi), abs=1e-9)
