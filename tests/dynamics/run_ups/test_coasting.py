"""The steady vibration in which a coast-down starts, against its closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.coasting import (
    with_steady_vibration,
)
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.errors import InputError
from wucht.files.building import machine_from

MASS, UNBALANCE, STIFFNESS, DAMPING, SPEED = 10.0, 9e-3, 1e5, 400.0, 80.0


def machine(**more: Any) -> Any:
    rotor = {"kind": "rotor", "name": "d", "mass": MASS - 1.5, "unbalance": UNBALANCE, "inertia": 0.1}
    ball = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.5, "length": 0.1, "damping": 0.01}
    return machine_from(
        {
            "carrier": {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": DAMPING},
            "bodies": [rotor, ball],
            "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": SPEED},
        }
        | more
    )


@pytest.mark.parametrize("driven", [1.0, -1.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.0, 0.75])
def test_the_steady_vibration_at_the_start(sense: float, angle: float, driven: float) -> None:
    """x = Re u W^2 e^(i sigma phi)/(c - M W^2 + i d W) of all unbalances u, and its velocity, beside the rest position."""
    of = machine(drive={"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": driven * SPEED})
    state = initial_state(
        of, {"d": {"angle": sense * angle, "speed": sense * 90.0}, "p": {"angle": 2.0, "speed": sense * 90.0}}
    )
    found = with_steady_vibration(of, state)
    unbalance = UNBALANCE + 0.5 * 0.1 * np.exp(1j * sense * 2.0)
    amplitude = unbalance * 90.0**2 * np.exp(1j * angle) / (STIFFNESS - MASS * 90.0**2 + 1j * DAMPING * 90.0)
    (x,) = of.free_carrier
    assert found[of.row(x.position)] - state[of.row(x.position)] == pytest.approx(amplitude.real, rel=1e-9)
    assert found[of.row(x.velocity)] == pytest.approx((1j * 90.0 * amplitude).real, rel=1e-9)
    others = [i for i in range(len(state)) if i not in (of.row(x.position), of.row(x.velocity))]
    assert found[others].tolist() == state[others].tolist()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_at_an_undamped_resonance_there_is_none(sense: float) -> None:
    carrier = {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": 0.0}
    of, resonance = machine(carrier=carrier), math.sqrt(STIFFNESS / MASS)
    for share, refused in ((1 + 0.9e-6, True), (1 - 0.9e-6, True), (1 + 3e-6, False)):
        speed = sense * share * resonance
        state = initial_state(of, {"d": {"speed": speed}, "p": {"speed": speed}})
        if refused:
            with pytest.raises(InputError) as raised:
                with_steady_vibration(of, state)
            assert raised.value.location == "study.vibration"
        else:
            assert np.isfinite(with_steady_vibration(of, state)).all()
