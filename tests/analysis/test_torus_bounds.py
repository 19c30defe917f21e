"""Bounds on how much the Jacobian of the torque balance changes over a box: nothing in the box exceeds them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.configurations.torus import TorusProblem
from wucht.files.building import machine_from
from wucht.machines.structure import SPEED
from wucht.piecewise import PiecewiseCubic, interpolated_pieces

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
BALLS = [
    {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02, "name": f"b{k}", "mass": m}
    for k, m in enumerate((0.008, 0.006))
]


def problem(damping: float, **torques: Any) -> TorusProblem:
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [damping, 1.5 * damping]}
    return TorusProblem(SteadyTorques.of(machine_from({"carrier": carrier, "bodies": [ROTOR, *BALLS], **torques})))


LINEAR = {"drive": {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}}
# So steep that the vibration hardly counts.
STEEP = {"drive": {"kind": "table", "points": [[0, 1e6], [105, 9e5], [112, 8e5], [118, -9e5], [400, -1e6]]}}
ROUNDED = LINEAR | {
    "load": {"kind": "table", "points": [[0, 1e3], [112, 2e3], [118, 9e5], [400, 1e6]], "transition_speed": 0.1}
}


@pytest.mark.parametrize("damping", [40.0, 3000.0])
@pytest.mark.parametrize("torques", [STEEP, ROUNDED], ids=["steep", "rounded"])
@pytest.mark.parametrize(("wide", "turn"), [(0.0, 0.3), (2.0, 1e-3), (2.0, 0.3)], ids=["phases", "speed", "both"])
def test_no_change_of_the_jacobian_within_a_box_exceeds_its_bound(
    damping: float, torques: dict[str, Any], wide: float, turn: float
) -> None:
    torus = problem(damping, **torques)
    rng = np.random.default_rng(3)
    centre = np.concatenate([rng.uniform(-3, 3, (2, 100)), rng.uniform(95, 130, (1, 100))])
    radius = np.repeat([[turn], [turn], [wide]], 100, axis=1)
    bound, here = torus.spread(centre, radius), torus.jacobian(centre)
    assert np.isfinite(bound).all()
    corner = rng.choice([-1.0, 1.0], (3, 100)) * radius
    for share in (0.3, 1.0):
        change = np.abs(torus.jacobian(centre + share * corner) - here)
        assert (change <= bound * (1 + 1e-6) + 1e-9 * np.abs(here).max()).all()


@pytest.mark.parametrize("bend", [1, -1])
def test_at_a_kink_of_a_torque_the_slopes_of_both_sides_are_within_the_bound(bend: int) -> None:
    """Its slope falls, or rises, by 2e5 at 100: from a little below and a little above."""
    of = problem(40.0, **LINEAR).torques
    kink = PiecewiseCubic(SPEED, interpolated_pieces("kink", [0.0, 100.0, 400.0], [0.0, 0.0, bend * 300 * 2e5], "linear"))
    torus = TorusProblem(replace(of, shaft_torques=(of.shaft_torques[0] + kink, *of.shaft_torques[1:])))
    for side in (-1, 1):
        centre, radius = np.array([[0.3], [2.0], [100.0 + side]]), np.array([[0.0], [0.0], [1.5]])
        bound, here = torus.spread(centre, radius), torus.jacobian(centre)
        change = np.abs(torus.jacobian(centre - side * radius) - here)
        assert change[0, 2] == pytest.approx(2e5, rel=1e-2)
        assert (change <= bound * (1 + 1e-6)).all()
        assert bound[0, 2] < 3e5
