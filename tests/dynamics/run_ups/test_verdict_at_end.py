"""What a motion is judged by at its end: the speed that the drive would hold from there without vibration."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups import run_up
from wucht.dynamics.run_ups.horizon import SPEED_LIMIT
from wucht.files.building import machine_from


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_motor_that_cannot_lift_its_load_from_standstill_may_hold_it(sense: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """40 N m of friction, against 20 N m at standstill and 60 N m at 50 rad/s: from 80 rad/s it is held beyond 50 rad/s."""
    points = [[0.0, 20.0], [50.0, 60.0], [100.0, 0.0]]
    points = points if sense > 0 else [[-w, -torque] for w, torque in reversed(points)]
    machine = machine_from({
        "carrier": {"directions": "fixed"},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 0.0, "inertia": 1.0}],
        "drive": {"on": "a", "kind": "table", "points": points}, "loads": [{"on": "a", "kind": "coulomb", "torque": 40.0}],
    })  # fmt: skip
    judged = list[tuple[float | None, bool]]()
    monkeypatch.setattr(run_up, "judge", lambda _m, _o, free, _failure, beyond: judged.append((free, beyond)))

    def end(speed: float | None, stopped_by: str | None = None) -> float:
        last = None if speed is None else SimpleNamespace(speeds=np.array([[0.0, sense * speed]]))
        observation: Any = SimpleNamespace(main=SimpleNamespace(sample=last))
        motion: Any = SimpleNamespace(end_time=1.0, failure=None, stopped_by=stopped_by)
        run_up.verdict_at_end(machine, observation, motion)
        free, beyond = judged[-1]
        assert free is not None and beyond is (stopped_by == SPEED_LIMIT)
        return sense * free

    assert 50.0 < end(80.0) < 100.0 and abs(end(0.0)) < 1.0 and abs(end(None)) < 1.0
    assert end(80.0, SPEED_LIMIT) == end(80.0, "another event")
