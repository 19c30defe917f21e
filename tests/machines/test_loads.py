"""Loads: each resists, alike in both directions, and takes power at every speed."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.machines.parts import loads
from wucht.schema import validate_table

few = settings(max_examples=40, deadline=None)

DESCRIBED = {
    "viscous": {"coefficient": "0.2 N m s"},
    "quadratic": {"coefficient": "0.03 N m s^2"},
    "coulomb": {"torque": "4 N m"},
    "table": {"points": [[0, 2.0], [50, 3.0], [100, 8.0]]},
}
SPEEDS = st.floats(-200, 200)


def load(kind, **changes):
    """A load as a study file describes it."""
    return validate_table(loads()[kind], {"on": "m", **DESCRIBED[kind], **changes}, "machine.loads[0]")


def values(part):
    return {p.path: p.value for p in part.parameters()}


@pytest.mark.parametrize("kind", sorted(DESCRIBED))
@few
@given(speed=SPEEDS)
def test_a_load_is_odd_and_takes_power(kind, speed):
    made = load(kind)
    torque = made.torque_at(speed)
    assert made.torque_at(-speed) == pytest.approx(-torque, rel=1e-12, abs=1e-12)
    assert torque * speed >= -1e-12


@few
@given(speed=SPEEDS)
def test_formulas(speed):
    assert load("viscous").torque_at(speed) == pytest.approx(0.2 * speed, rel=1e-12, abs=1e-300)
    assert load("quadratic").torque_at(speed) == pytest.approx(0.03 * speed * abs(speed), rel=1e-12, abs=1e-300)
    assert load("coulomb").torque_at(speed) == pytest.approx(4 * math.tanh(speed / 0.1), rel=1e-12, abs=1e-300)


def test_a_curve_that_begins_with_a_torque_begins_as_dry_friction():
    made = load("table")
    assert made.torque_at(0.0) == 0
    assert made.torque_at(0.1) == pytest.approx(2 * math.tanh(1), rel=1e-2)
    assert [made.torque_at(w) for w in (50.0, 100.0, 500.0)] == pytest.approx([3, 8, 8], rel=1e-12)
    assert values(made) == {"load.transition_speed": 0.1}


@few
@given(torques=st.lists(st.floats(0, 50), min_size=2, max_size=6), first=st.sampled_from([0.0, 7.0]), speed=SPEEDS)
def test_any_measured_load_is_odd_and_takes_power(torques, first, speed):
    made = load("table", points=[[first + 20 * i, t] for i, t in enumerate(torques)])
    assert made.torque_at(-speed) == pytest.approx(-made.torque_at(speed), rel=1e-9, abs=1e-9)
    if abs(speed) > 2:  # beyond the transition
        assert made.torque_at(speed) * speed >= -1e-9
