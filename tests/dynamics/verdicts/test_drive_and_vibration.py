"""Where drive and vibration let a rotor go, on both sides of every limit."""

import math

import numpy as np
import pytest
from motions import (
    ROTOR,
    UNBALANCE,
    W,
    approaching,
    carrier,
    judged,
    linear,
    machine,
    swinging_between,
    tenth,
    with_balls,
)

from wucht.analysis.time_constants import runaway_limit
from wucht.analysis.vibration import Vibration


def held_at(share, decay=10.0):
    """A machine of which drive and vibration are in balance at that share of the free speed."""
    brakes = Vibration.of(machine(carrier(W / 2, decay), [ROTOR])).torque(np.array([share * W]), np.zeros(1))[0]
    return machine(carrier(W / 2, decay), [ROTOR], linear(W, float(brakes[0]) / ((1 - share) * W)))


@pytest.mark.parametrize(("share", "faster"), [(0.51, True), (0.53, False)])
def test_the_drive_could_hold_a_higher_speed_as_well_just_beyond_the_maximum_of_the_vibration_torque(share, faster):
    """There the drive's torque falls faster than that of the vibration, which exceeds it for a while."""
    found = judged(held_at(share, decay=3.0), lambda t: share * W * t)
    assert found.outcome == "passed"
    assert found.faster_branch is faster


# --- a rotor that still rises beyond its resonance: whether the vibration holds it ---


@pytest.mark.parametrize(("share", "outcome"), [(0.974, "passed"), (0.986, "unidentified")])
def test_a_vibration_that_holds_the_rotor_two_percent_before_its_free_speed_lets_it_settle_early(share, outcome):
    found = judged(held_at(share), approaching(0.96, 0.02))
    assert found.evidence.settled is (outcome == "passed")
    assert found.outcome == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.9, "passed"), (1.1, "runaway")])
def test_a_torque_without_losses_runs_away_if_nothing_holds_it_before_the_limit(share, outcome):
    """Far beyond the resonance the carrier moves by U/m: the brake is c w (U/m)^2."""
    shaft = carrier(W / 2)
    brake = 3000.0 * shaft["damping"] * (UNBALANCE / 10) ** 2
    driven = machine(shaft, [ROTOR], {"kind": "constant-torque", "torque": share * brake})
    assert runaway_limit(driven) == pytest.approx(3000.0)
    found = judged(driven, approaching(0.96, 0.02), free=None)
    assert found.outcome == outcome
    assert found.evidence.unheld is (outcome == "runaway")


@pytest.mark.parametrize(("unrest", "outcome"), [(0.085, "runaway"), (0.12, "unidentified")])
def test_nobody_knows_what_it_does_with_bodies_that_move_about_it(unrest, outcome):
    driven = machine(carrier(W / 2), with_balls("a"), {"kind": "constant-torque", "torque": 1.0})
    rising, ball = approaching(0.96, 0.02), swinging_between(1.6 * (1 - unrest), 1.6)
    found = judged(driven, rising, lambda t: rising(t) + ball(t) - W * t, free=None)
    assert found.outcome == outcome


@pytest.mark.parametrize(("part", "outcome"), [(0.9, "runaway"), (1.1, "unidentified")])
def test_nor_with_bodies_that_leave(part, outcome):
    """The residual unbalance drifts to twice of what it is as far as it is looked ahead."""
    driven = machine(carrier(W / 2), with_balls("a"), {"kind": "constant-torque", "torque": 1.0})
    rising = approaching(0.96, 0.02)

    def ball(t):
        return rising(t) + math.pi - 0.1 * (1 + part / 150 * tenth(t))

    assert judged(driven, rising, ball, free=None).outcome == outcome
