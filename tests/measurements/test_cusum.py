"""The cumulative sum chart against the tables of the field, and against simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.refusals import failed

from wucht.measurements.cusum import Cusum, design_chart

NONE = np.zeros(1)
# D. C. Montgomery, Introduction to Statistical Quality Control, table 9.3, after J. M. Lucas: average run lengths of the
# two-sided chart with k = 1/2 over the shift of the mean in standard deviations.
TABLE = {
    4.0: {0.0: 168, 0.25: 74.2, 0.5: 26.6, 0.75: 13.3, 1.0: 8.38, 1.5: 4.75, 2.0: 3.34, 2.5: 2.62, 3.0: 2.19, 4.0: 1.71},
    5.0: {0.0: 465, 0.25: 139, 0.5: 38.0, 0.75: 17.0, 1.0: 10.4, 1.5: 5.75, 2.0: 4.01, 2.5: 3.11, 3.0: 2.57, 4.0: 2.01},
}


@pytest.mark.parametrize("threshold", TABLE)
def test_run_lengths_are_those_of_the_table(threshold):
    for shift, printed in TABLE[threshold].items():
        digit = 10.0 ** (math.floor(math.log10(printed)) - 2)
        assert Cusum(0.5, threshold, 1.0).mean_alarm_interval(np.array([shift])) == pytest.approx(printed, abs=0.51 * digit)


def siegmund(threshold: float, reference: float) -> float:
    """D. Siegmund, Sequential Analysis, 1985: of one side, without a shift."""
    d, b = -reference, threshold + 1.166
    return (math.exp(-2 * d * b) + 2 * d * b - 1) / (2 * d * d)


@pytest.mark.parametrize(("reference", "readings"), [(0.25, 1e3), (0.5, 1e7)])
def test_a_chart_has_the_false_alarms_that_are_wanted(reference, readings):
    """In any unit; by Siegmund's formula, which is good to a few per cent where k is no more than half a deviation."""
    unit = 3.7
    made = design_chart(unit * reference, unit, readings, NONE)
    assert made.mean_alarm_interval(NONE) == pytest.approx(readings, rel=1e-5)
    assert siegmund(made.threshold / unit, reference) / 2 == pytest.approx(readings, rel=0.05)


@pytest.mark.parametrize("amplitude", [0.0, 3.0])
def test_false_alarms_by_simulation(amplitude):
    """Also of a mean that beats: nothing that is drawn from normal numbers knows of it."""
    beat = amplitude * np.sin(2 * np.pi * np.arange(20) / 20)
    made = design_chart(1.0, 1.0, 250.0, beat)
    readings = np.tile(beat, 150) + np.random.default_rng(5).standard_normal((3000, 3000))
    first = made.first_alarms(readings)
    assert first.max() < 3000
    assert (first + 1).mean() == pytest.approx(250.0, abs=4 * first.std() / math.sqrt(len(first)))
    if amplitude:  # taken for even readings it would alarm in each beat
        assert design_chart(1.0, 1.0, 250.0, NONE).mean_alarm_interval(beat) < 20


@pytest.mark.parametrize("steady", [True, False])
def test_the_probability_of_an_alarm_by_simulation(steady):
    """After a change that comes slowly; for charts that have run for long without an alarm, and for charts that begin."""
    made, before, charts = Cusum(0.5, 4.0, 1.0), 60 if steady else 0, 30_000
    changed = -np.minimum(np.arange(1, 41) / 8, 1.0)
    readings = np.random.default_rng(6).standard_normal((charts, before + 40))
    readings[:, before:] += changed
    first = made.first_alarms(readings)
    first = first[first >= before] - before
    simulated = np.array([(first <= i).mean() for i in range(40)])
    computed = made.detection(NONE if steady else None, changed)
    # The two sums exclude each other: that they are taken for independent costs a few thousandths.
    assert computed == pytest.approx(simulated, abs=0.006 + 4 / math.sqrt(len(first)) / 2)
    assert computed[-1] > 0.9


SHIFT, SMALL = -0.4904, Cusum(1.0, 26.4088, 2.0)  # half of what the chart is made for: of a machine that falls by 0.7 %


def test_a_small_change_takes_long_by_siegmund():
    """Ten thousand readings, of which 5,000 are followed one by one; a shift by a quarter of a deviation."""
    alarms = SMALL.alarms(NONE, np.full(1, SHIFT), np.full(1, SHIFT), 0.9999)
    rates = [1 / siegmund(SMALL.threshold / 2, (1.0 - sign * SHIFT) / 2) for sign in (1, -1)]
    assert 5000 <= len(alarms.first) < 5010 and alarms.first[-1] < 0.4
    assert alarms.mean() == pytest.approx(1 / sum(rates), rel=0.01)
    assert alarms.quantile(0.5) == pytest.approx(math.log(2) * alarms.mean(), rel=0.01)


def test_beyond_the_horizon_as_if_it_were_followed():
    """What is known of all readings, which beat, from 5,000 of them is what comes out where 60,000 are followed one by one."""
    again = SHIFT + np.sin(2 * np.pi * np.arange(7) / 7)
    changed = np.array([0.1, 0.2, SHIFT])
    alarms = SMALL.alarms(NONE, changed, again, 0.9999)
    every = SMALL.detection(NONE, np.append(changed, np.resize(again, 60_000)))
    for probability in (0.2, 0.5, 0.9):
        assert alarms.quantile(probability) == int(np.argmax(every >= probability))
    at, probability = alarms.curve(0.9999, 50)
    known = at < len(every)
    assert probability[known] == pytest.approx(every[at[known].astype(int)], abs=1e-6)
    assert probability[-1] >= 0.9999 and len(at) == len(alarms.first) + 50
    rest = (1 - every[-1]) * alarms.mean()  # of those that have not alarmed by then, who wait as long as all did at the begin
    assert alarms.mean() == pytest.approx((1 - every).sum() + rest, rel=1e-4)


def test_what_is_not_known_is_not_stated():
    """70 standard deviations, which are 0 to rounding; too few nodes for the noise; readings that do not come again."""
    known = np.zeros(3)
    for made, again, most, readings in (
        (Cusum(10.0, 60.0, 1.0), known, 9000, 5004), (Cusum(1.0, 50.0, 0.01), known, 6000, 6000),
        (SMALL, np.empty(0), 9000, 3), (SMALL, known, 100, 100),
    ):  # fmt: skip
        alarms = made.alarms(None, known, again, 0.9999, most)
        assert len(alarms.first) == readings
        assert not alarms.is_certain and alarms.quantile(0.5) is None
        assert alarms.curve(0.9999, 10)[0][-1] == readings - 1


def test_beating_far_beyond_the_noise():
    """The density is computed with a little more noise then: false alarms are no more frequent than wanted."""
    beat = 3.0 * np.sin(2 * np.pi * np.arange(20) / 20)
    made = design_chart(1.0, 0.01, 1e4, beat)
    readings = np.tile(beat, 100) + 0.01 * np.random.default_rng(7).standard_normal((200, 2000))
    assert (made.first_alarms(readings) == 2000).all()
    assert made.detection(beat, beat + 4.0 * np.ones(20))[-1] == pytest.approx(1.0, abs=1e-9)


def test_no_such_chart():
    with failed("too-few-alarms"):
        design_chart(5.0, 1.0, 2.0, NONE)


# --- the reading of the alarm, of shares that are known ---


def test_the_first_alarm_of_charts_on_either_side():
    """k = 1, h = 3: of readings 3, 3 the upper sum is 2, then 4; of -5 the lower one is 4 at once; small ones never are."""
    charts = Cusum(1.0, 3.0, 1.0)
    readings = np.array([[3.0, 3.0, 0.0, 0.0], [-5.0, 0.0, 0.0, 0.0], [1.0, -1.0, 1.0, -1.0], [3.0, -9.0, 0.0, 0.0],
                         [4.0, 1.0, 1.0, 1.1]])  # fmt: skip
    assert charts.first_alarms(readings).tolist() == [1, 0, 4, 1, 3]
