"""What is seen of members, in the full equations and in the averaged ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import Variants, member_equations
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.files.building import machine_from


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("model", ["full", "slow"])
def test_phases_are_seen_as_the_bodies_turn(model: str, sense: int) -> None:
    """A pendulum 0.4 rad counter-clockwise of its rotor, whichever way both turn."""
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": 1e3, "damping": 5.0},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, ball],
        "drive": {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": sense * 50.0},
    })  # fmt: skip
    speed = sense * 40.0
    begun = initial_state(machine, {"a": {"angle": 0.9, "speed": speed}, "p": {"angle": 0.4, "speed": speed}})
    equations = member_equations(EnsembleQuestion(machine, model=model), begun)
    variants = Variants.from_values(machine, {}, 2)
    starts = equations.starts(np.repeat(begun[:, None], 2, axis=1), variants)
    seen = equations.view(variants).view(starts[None], variants.machine_index)
    assert np.remainder(seen.phases, 2 * math.pi) == pytest.approx(np.full((1, 1, 2), 0.4))
    assert seen.speed == pytest.approx(np.full((1, 2), speed))


@pytest.mark.parametrize("sense", [1, -1])
def test_members_whose_rotor_has_a_prescribed_speed_start_with_it(sense: int) -> None:
    """Seven members with two speeds, not in order, and a body of each that starts slower than any of them."""
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e3, "damping": 5.0},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, ball],
        "drive": {"on": "a", "kind": "constant-speed", "speed": sense * 50.0},
    })  # fmt: skip
    begun = initial_state(machine, {"p": {"angle": 0.4, "speed": sense * 40.0}})
    speeds = sense * np.array([50.0, 60.0, 60.0, 50.0, 60.0, 50.0, 50.0])
    variants = Variants.from_values(machine, {"drive.speed": speeds}, len(speeds))
    equations = member_equations(EnsembleQuestion(machine, model="slow"), begun)
    starts = equations.starts(np.repeat(begun[:, None], len(speeds), axis=1), variants)
    seen = equations.view(variants).view(starts[None], variants.machine_index)
    assert seen.speed == pytest.approx(speeds[None])
