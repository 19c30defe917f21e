"""Rotors that nothing drives: how long to run until they have stopped."""

import math

import numpy as np
import pytest
from motions import DECAYS, FIXED, LONGER, ROTOR, W, approaching, judged, machine

END = 100.0


def coasting(angle, **more):
    return judged(machine(FIXED, [ROTOR | more]), angle, until=END, free=0.0)


@pytest.mark.parametrize("time", [200.0, 2000.0])
def test_one_that_a_viscous_damper_brakes_is_given_its_time_to_a_ten_thousandth(time):
    found = coasting(lambda t: 5 * W * time * (1 - np.exp(-t / time)))
    assert found.outcome == "unidentified"
    assert found.needed == pytest.approx((END + time * math.log(1e4)), rel=0.05)


@pytest.mark.parametrize("stop", [150.0, 1000.0])
def test_one_that_dry_friction_brakes_is_given_its_time_to_the_stop(stop):
    found = coasting(lambda t: 5 * W * (t - t**2 / (2 * stop)))
    assert found.outcome == "unidentified"
    assert found.needed == pytest.approx(max(LONGER * END, stop), rel=0.05)


def test_one_that_air_brakes_does_not_come_to_rest():
    """J w' = -c w^2: it falls with the time, and its angle grows without bound."""
    found = coasting(lambda t: 5 * W * 50 * np.log(1 + t / 50))
    assert found.outcome == "unidentified"
    assert found.needed is None
    assert found.advice == "the rotor coasts ever more slowly, and does not come to rest: to run longer would not tell more"


def test_where_the_vibration_holds_a_rotor_the_slip_in_its_bearing_does_not_say_how_long():
    """Before its resonance: it slips by the factor e in days, but stands within minutes."""
    slow = machine({"mass": 6.0, "stiffness": 10 * (1.2 * W) ** 2, "damping": 2.0},
                   [ROTOR | {"bearing_damping": 1e-7}],
                   {"kind": "constant-torque", "torque": 1.0, "on": "d"})  # fmt: skip
    found = judged(slow, approaching(1.0, 0.05), free=1e7)
    assert found.outcome == "unidentified"
    assert found.needed < 2 * DECAYS * END
