"""What is seen of a speed that falls while nobody knows yet that the specimen has failed."""

import numpy as np
import pytest

from wucht.dynamics.exciters.speed_readings import Windows, detection_of, readings_of


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
