from dataclasses import replace

import numpy as np
import pytest

from wucht.analysis.vibration import Vibration
from wucht.dynamics.sampling.screening_observer import PARTS, SAMPLES, DoublingSchedule, _of_one_shape
from wucht.files.building import machine_from


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


def test_bodies_about_one_axis_have_a_torque_of_one_shape() -> None:
    """On unequal supports, with a damper of one direction: the last maximum lies at one speed, whatever the phases."""
    balls = [
        {"kind": "pendulum", "name": n, "about": "a", "mass": m, "length": 0.1, "damping": 0.01}
        for n, m in (("p", 0.05), ("q", 0.2))
    ]
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": [1e3, 2.2e3], "damping": [5.0, 20.0]},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, *balls],
        "drive": {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": 90.0},
    })  # fmt: skip
    vibration = Vibration.of(machine)
    alone = _of_one_shape(vibration)
    assert len(alone.excitation) == 1
    expected, draw = alone.last_maximum(90.0, np.zeros(1)), np.random.default_rng(2)
    for _ in range(8):
        assert vibration.last_maximum(90.0, draw.uniform(-3, 3, 3)) == pytest.approx(expected, rel=1e-8)
    unlike = replace(vibration, excitation=vibration.excitation * np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 1.1]]))
    assert _of_one_shape(unlike) is unlike
