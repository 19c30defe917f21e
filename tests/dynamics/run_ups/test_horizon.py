"""How far a run goes and how densely it is sampled, by what may happen in it."""

from __future__ import annotations

import math

import pytest

from wucht.dynamics.run_ups.horizon import SAMPLES_PER_TURN, Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from


@pytest.mark.parametrize(("shaking", "fastest"), [(300.0, 300.0), (100.0, 200.0)])
def test_samples_are_as_dense_as_the_faster_of_rotor_and_shaking_asks(shaking: float, fastest: float) -> None:
    machine = machine_from(
        {
            "carrier": {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": shaking}},
            "bodies": [{"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 0.01, "inertia": 0.1}],
            "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": 200.0},
        }
    )
    turn = 2 * math.pi / fastest
    horizon = Horizon.of(machine, RunSettings(until=100 * turn), initial_state(machine, {}))
    assert horizon.step == pytest.approx(turn / SAMPLES_PER_TURN, rel=1e-3)
    assert horizon.vibration == shaking
