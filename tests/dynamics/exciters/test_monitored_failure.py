"""When the speed of a failing machine is measured, what its readings say, and the cliff beside the best signal."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.dynamics.exciters.failing_machine import FallingStiffness
from wucht.dynamics.exciters.monitored_failure import ScheduledFall, changes_of, measuring_windows
from wucht.dynamics.exciters.signal_points import SignalPoint, best_index, cliff_at, safe_index, values_beside_best
from wucht.dynamics.exciters.slow_beats import Beat
from wucht.dynamics.exciters.speed_readings import (
    Readings,
    Windows,
    averaged_speed,
    detection_of,
    readings_of,
)
from wucht.files.catalogue import load_machine
from wucht.piecewise import Pieces

STEP = Pieces("c", (0.0, 4.0), [(2.0, 0, 0, 0), (2.0, 0, 0, 0), (1.6, 0, 0, 0)])
FALL = ScheduledFall(STEP, 4.0, 5.0)


@pytest.mark.parametrize(
    ("fall", "broken", "gradual", "after", "learning", "end", "windows"),
    [
        (FALL, None, False, None, None, 8.0, ((2.0, 4.0), (6.5, 8.0), 4.0, 4.0)),
        (FALL, None, False, 1.0, 2.0, 8.0, ((1.0, 3.0), (6.5, 8.0), 4.0, 4.0)),
        (FALL, None, False, None, None, 4.5, ((2.0, 4.0), None, 4.0, 4.0)),
        (FALL, None, False, None, None, 3.0, ((2.0, 3.0), None, None, None)),
        (FALL, None, False, 3.5, None, 3.0, (None, None, None, None)),
        (None, 6.0, False, None, None, 10.0, ((3.0, 6.0), (8.0, 10.0), 6.0, 6.0)),
        (None, None, False, None, None, 10.0, ((5.0, 10.0), None, None, None)),
        (None, None, True, 1.0, 3.0, 10.0, ((1.0, 4.0), (7.0, 10.0), 4.0, None)),
        (None, 6.0, True, 1.0, 3.0, 10.0, ((1.0, 4.0), (8.0, 10.0), 4.0, 6.0)),
    ],
)
def test_when_the_speed_is_measured(
    fall: ScheduledFall | None,
    broken: float | None,
    gradual: bool,
    after: float | None,
    learning: float | None,
    end: float,
    windows: tuple[tuple[float, float] | None, tuple[float, float] | None, float | None, float | None],
) -> None:
    """Before the failure from half of that time on; after it over the second half of the rest of the run so far."""
    assert vars(measuring_windows(end, broken, fall, gradual, after, learning)) == vars(Windows(*windows))


def test_a_schedule_falls_between_its_changes() -> None:
    """And its share is that of the value with which it begins."""
    rows = [(2.0, 0, 0, 0), (2.0, 0, 0, 0), (2.0, -1.0, 0, 0), (1.5, -1.0, 0, 0), (1.0, 0, 0, 0)]
    assert changes_of(Pieces("c", (1.0, 3.0, 3.5, 4.0), rows)) == [3.0, 3.5, 3.5, 4.0] and changes_of(STEP) == [4.0]
    assert FALL.share(np.array([-1.0, 3.9, 4.0, 9.0])) == pytest.approx([1.0, 1.0, 0.8, 0.8])


def points(*rows: tuple[float, float | None]) -> list[SignalPoint]:
    return [SignalPoint((x,), 90.0, None if y is None else 90.0 + y, y, "passed") for x, y in rows]


def test_a_cliff_is_where_less_than_half_of_the_signal_is_left() -> None:
    edge = points((0.01, 9.0), (0.0199, 9.99), (0.02, 20.0), (0.021, 19.0), (0.022, 18.0))
    assert best_index(edge) == 2
    cliff = cliff_at(edge, 2, ["x"])
    assert cliff is not None and (cliff.distance, 1 / cliff.cost) == (pytest.approx(-0.005), pytest.approx(9.99))
    assert safe_index(edge, ["x"]) == 3, "5 % away, the next best"
    assert cliff_at(points((0.0199, 10.0), (0.02, 20.0)), 1, ["x"]) is None, "half of it is left"
    assert safe_index(points((0.019, 1.0), (0.02, 20.0)), ["x"]) == 1, "5 % away is far enough"
    lost = cliff_at(points((0.01, 4.0), (0.015, 48.0), (0.02, None)), 1, ["x"])
    assert lost is not None and (lost.value, lost.inside, 1 / lost.cost) == (0.02, 0.015, 0.0), (
        "a third away; the other is half"
    )
    nowhere = points((0.01, None), (0.02, None))
    assert best_index(nowhere) is None and safe_index(nowhere, ["x"]) is None and values_beside_best(nowhere) == []


def test_beside_the_best_value_it_is_looked_more_finely() -> None:
    """Halfway to its neighbours; at an end of the range to the only one. Four times, it is found to a sixteenth."""
    for peak, expected in (
        (0.0162, [0.0125, 0.0175, 0.01375, 0.01625, 0.015625, 0.016875, 0.0159375, 0.0165625]),
        (0.01, [0.0125, 0.01125, 0.010625, 0.0103125]),
    ):
        values, found = [0.01, 0.015, 0.02], list[float]()
        for _ in range(4):
            further = values_beside_best(points(*((x, 100 - abs(x - peak) * 1e4) for x in sorted(values))))
            values += [x for (x,) in further]
            found += [x for (x,) in further]
        assert found == pytest.approx(expected)


INTERVAL, BEAT, DEPTH = 0.5, 4.0, 3.0


def readings(sense: float = 1.0) -> Readings:
    """The speed is 100 + 3 cos(2 pi t/4) until 80 s, and by 20 less from then on."""
    time = np.linspace(0.0, 160.0, 1601)
    rate = 2 * math.pi / BEAT
    angle = 100 * time + DEPTH / rate * np.sin(rate * time) - 20 * np.maximum(time - 80.0, 0.0)
    return readings_of(time, sense * angle, INTERVAL, Windows((0.0, 80.0), (80.0, 160.0), 80.0, 80.0))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_means_and_beating_of_readings(sense: float) -> None:
    """A mean over a time T of a wave of the period B has the amplitude sin(pi T/B)/(pi T/B) of it."""
    found = readings(sense)
    x = math.pi * INTERVAL / BEAT
    assert (found.before, found.after) == (pytest.approx(sense * 100.0, abs=0.02), pytest.approx(sense * 80.0, abs=0.02))
    assert found.beating == pytest.approx(DEPTH * math.sin(x) / x / math.sqrt(2), rel=5e-3)
    assert found.time == pytest.approx(INTERVAL * np.arange(1, 321))
    middle = found.time - INTERVAL / 2
    expected = 100 + DEPTH * math.sin(x) / x * np.cos(2 * math.pi * middle / BEAT) - 20 * (middle > 80.0)
    assert found.speed == pytest.approx(sense * expected, abs=1e-8)
    assert found.normal.tolist() == [True] * 160 + [False] * 160 and found.abnormal.tolist() == [False] * 160 + [True] * 160
    deviation = math.sqrt(0.4**2 + found.beating**2)
    assert found.deviation(0.4) == pytest.approx(deviation)
    assert found.signal(0.4) == pytest.approx(20.0 / deviation, rel=1e-3)


@pytest.mark.parametrize(
    ("at_once", "damage", "stiffness"),
    [
        (True, 0.0, 5.0), (True, 0.999, 5.0), (True, 1.0, 2.0), (True, 3.0, 2.0),
        (False, 0.0, 5.0), (False, 0.5, 3.5), (False, 1.0, 2.0), (False, 2.0, 2.0),
    ],
)  # fmt: skip
def test_the_stiffness_over_the_damage(at_once: bool, damage: float, stiffness: float) -> None:
    assert FallingStiffness("k", 5.0, 0.4, at_once).stiffness_at(damage) == pytest.approx(stiffness)


def test_the_cycles_of_a_beat() -> None:
    """Three parts of a beat of 6 s, 2 s each, with 10, 20 and 10 cycles a second: 20, 40 and 20 cycles."""
    beat = Beat("modulated", 0.0, 6.0, np.arange(1.0, 7.0, 2.0), np.array([1.0, 2.0, 5.0]), np.array([10.0, 20.0, 10.0]))
    assert beat.cycles.ranges.tolist() == [2.0, 4.0, 10.0] and beat.cycles.means.tolist() == [0.0, 0.0, 0.0]
    assert beat.cycles.counts == pytest.approx([20.0, 40.0, 20.0])
    assert (beat.upper, beat.ratio) == (5.0, pytest.approx(0.2))
    assert beat.fullness == pytest.approx(((20 * 1 + 40 * 2 + 20 * 5) / 80 - 1) / 4)
    steady = Beat("steady")
    assert np.isnan([steady.upper, steady.ratio, steady.fullness]).all() and not steady.cycles.total


@pytest.mark.parametrize(("failed", "begins"), [(10.2, -1.7), (None, 0.5)])
def test_the_time_of_an_alarm_counts_from_the_failure(failed, begins):
    """The chart watches from 8 s on, and reads each half second; what falls gradually may be seen before it has failed. What
    does not fail is counted from where the chart begins."""
    time = np.linspace(0.0, 20.0, 201)
    angle = 100 * time - np.maximum(time - 9.0, 0.0) ** 2 / 2
    windows = Windows((2.0, 8.0), (14.0, 20.0), 8.0, failed)
    found = detection_of(readings_of(time, angle, 0.5, windows), 1.0, 200.0, 2.0, steady=False)
    assert (found.begins, found.interval) == pytest.approx((begins, 0.5))
    assert found.curve()[0][:2] == pytest.approx([begins, begins + 0.5])


@pytest.mark.parametrize("name", ["sperling-rollers/table-1", "practice/laundry-drum-friction"])
def test_where_averaged_equations_have_no_speed_they_say_why(name: str) -> None:
    """The drive prescribes it, or the carrier is held by dry friction."""
    found = averaged_speed(load_machine(name), 95.0, False, np.empty(0), (1.0, 1.0), 1e-10, None)
    assert found.speed is None and found.next_stable is None
    assert ("prescribes the speed" in found.reason) is (name == "sperling-rollers/table-1") and found.reason
