"""When the speed of a failing machine is measured; and the choice of the value with the largest signal, and its cliff."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.exciters.monitored_failure import ScheduledFall, changes_of, measuring_windows
from wucht.dynamics.exciters.signal_points import SignalPoint, best_index, cliff_at, safe_index, values_beside_best
from wucht.dynamics.exciters.speed_readings import Windows
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
