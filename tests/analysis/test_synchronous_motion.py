"""A synchronous motion from a relative equilibrium that is made by hand, for either sense of rotation."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.synchronous_motion import SynchronousMotion, SynchronousMotions
from wucht.errors import RunError


def motion_at(speed: float) -> SynchronousMotion:
    """The motion at the equilibrium of such a speed, near a state whose main rotor is at the angle 0.5."""
    equilibrium = SimpleNamespace(speed=speed, exponents=np.array([-3.0, -1 + 130j, -1 - 130j]), state=np.array([7.0]))
    relative: Any = SimpleNamespace(
        to_turning_frame=lambda start: start + 1,
        find_near=lambda start, neutral: equilibrium if (start.tolist(), neutral) == ([1.5, 3.0], 1) else None,
        to_fixed_frame=np.append,
    )
    rotor = SimpleNamespace(coordinate=SimpleNamespace(position="phi"))
    machine: Any = SimpleNamespace(rotor=rotor, row={"phi": 0}.__getitem__)
    motions = SynchronousMotions(machine, {"drum": math.copysign(1.0, speed)}, relative, "")
    return motions.find_near(np.array([0.5, 2.0]), 100.0, neutral=1)


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_a_turn_takes_as_long_in_either_sense(speed: float) -> None:
    """Imaginary parts are within half a frequency of the rotation, the fastest growing first."""
    motion = motion_at(speed)
    assert motion.period == pytest.approx(2 * math.pi / 100.0)
    assert motion.exponents == pytest.approx(np.array([-1 + 30j, -1 - 30j, -3.0]))
    assert motion.state.tolist() == [7.0, 0.5]


def test_an_equilibrium_at_rest_is_no_rotation() -> None:
    with pytest.raises(RunError, match="the nearest equilibrium is at rest"):
        motion_at(0.0)
