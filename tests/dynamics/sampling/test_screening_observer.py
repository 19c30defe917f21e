import numpy as np
import pytest

from wucht.dynamics.sampling.screening_observer import PARTS, SAMPLES, DoublingSchedule


def test_each_chunk_is_as_long_as_all_before_and_its_samples_rise_to_its_end() -> None:
    pace = DoublingSchedule.from_end(1000.0, 300.0)
    assert pace.end == 1000.0 and pace.chunks == 3
    begin = 0.0
    for i, end in enumerate((250.0, 500.0, 1000.0)):
        times = pace.times(i)
        assert times[0] == begin and times[-1] == end and (np.diff(times) > 0).all()
        assert len(times) - 1 == (SAMPLES if i else PARTS)
        begin = end


@pytest.mark.parametrize("cycles", [1, 2, 3, 5])
def test_a_motion_of_the_samples_own_period_is_not_taken_for_rest(cycles: int) -> None:
    times = DoublingSchedule(100.0, 3).times(2)[1:]
    wave = np.sin(2 * np.pi * cycles * SAMPLES / (times[-1] - 200.0) * (times - 200.0) + 0.5)
    assert np.ptp(wave) > 1.0
