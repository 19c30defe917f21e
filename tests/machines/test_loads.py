"""Loads: each resists, alike in both directions, and takes power at every speed."""

import math

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.machines.parts import loads
from wucht.machines.parts.base import Frame
from wucht.mechanics.lagrange import Coordinate
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


def test_the_kinds_of_the_contract_are_known():
    assert set(DESCRIBED) <= set(loads())


@pytest.mark.parametrize("kind", sorted(DESCRIBED))
def test_all_symbols_are_parameters(kind):
    made = load(kind)
    w = sp.Symbol("m.speed", real=True)
    assert {s.name for s in made.torque(w).free_symbols - {w}} == set(values(made))


@pytest.mark.parametrize("kind", sorted(DESCRIBED))
@few
@given(speed=SPEEDS)
def test_a_load_is_odd_and_takes_power(kind, speed):
    made = load(kind)
    torque = made.torque_at(speed)
    assert made.torque_at(-speed) == pytest.approx(-torque, rel=1e-12, abs=1e-12)
    assert torque * speed >= -1e-12


@pytest.mark.parametrize("kind", sorted(DESCRIBED))
def test_the_power_is_booked_as_lost(kind):
    made = load(kind)
    turning = Coordinate.from_names("m.angle", "m.speed", angle=True)
    (applied,) = made.energies(Frame(bodies={"m": turning})).applied_forces
    assert applied.energy_side == "lost"
    numbers = {sp.Symbol(k, real=True): sp.Float(v) for k, v in values(made).items()}
    assert float(applied.power.xreplace(numbers).subs(turning.velocity, 30.0)) == pytest.approx(-30 * made.torque_at(30.0))


@few
@given(speed=SPEEDS)
def test_formulas(speed):
    assert load("viscous").torque_at(speed) == pytest.approx(0.2 * speed, rel=1e-12, abs=1e-300)
    assert load("quadratic").torque_at(speed) == pytest.approx(0.03 * speed * abs(speed), rel=1e-12, abs=1e-300)
    assert load("coulomb").torque_at(speed) == pytest.approx(4 * math.tanh(speed / 0.1), rel=1e-12, abs=1e-300)


def test_the_quadratic_load_has_a_continuous_slope():
    w = sp.Symbol("w", real=True)
    slope = sp.diff(load("quadratic").torque(w), w).xreplace({sp.Symbol("load.coefficient", real=True): sp.Float(0.03)})
    assert [float(slope.subs(w, at)) for at in (-2.0, 0.0, 2.0)] == pytest.approx([0.12, 0, 0.12])


def test_dry_friction_is_full_beyond_its_transition():
    made = load("coulomb", transition_speed="1 rpm")
    assert made.torque_at(0.0) == 0
    assert made.torque_at(0.4) == pytest.approx(4, rel=2e-3)
    assert values(made) == {"load.torque": 4.0, "load.transition_speed": pytest.approx(math.pi / 30)}


def test_a_curve_that_begins_with_a_torque_begins_as_dry_friction():
    made = load("table")
    assert made.torque_at(0.0) == 0
    assert made.torque_at(0.1) == pytest.approx(2 * math.tanh(1), rel=1e-2)
    assert [made.torque_at(w) for w in (50.0, 100.0, 500.0)] == pytest.approx([3, 8, 8], rel=1e-12)
    assert values(made) == {"load.transition_speed": 0.1}


@pytest.mark.parametrize("points", [[[0, 0.0], [50, 3.0], [100, 8.0]], [[50, 3.0], [100, 8.0]]])
def test_a_curve_without_dry_friction_goes_through_zero(points):
    made = load("table", points=points)
    assert made.torque_at(0.0) == pytest.approx(0.0, abs=1e-12)
    assert [made.torque_at(w) for w in (-100.0, -50.0, 50.0)] == pytest.approx([-8, -3, 3])
    assert values(made) == {}


def test_points_in_both_directions_are_taken_as_they_are():
    made = load("table", points=[[-100, -5.0], [0, 0.0], [100, 8.0]])
    assert [made.torque_at(w) for w in (-200.0, -100.0, 0.0, 100.0)] == pytest.approx([-5, -5, 0, 8], abs=1e-12)


@few
@given(torques=st.lists(st.floats(0, 50), min_size=2, max_size=6), first=st.sampled_from([0.0, 7.0]), speed=SPEEDS)
def test_any_measured_load_is_odd_and_takes_power(torques, first, speed):
    made = load("table", points=[[first + 20 * i, t] for i, t in enumerate(torques)])
    assert made.torque_at(-speed) == pytest.approx(-made.torque_at(speed), rel=1e-9, abs=1e-9)
    if abs(speed) > 2:  # beyond the transition
        assert made.torque_at(speed) * speed >= -1e-9


@pytest.mark.parametrize(
    ("kind", "changes", "refusal"),
    [
        (
            "viscous",
            {"coefficient": -1},
            refused("machine.loads[0].coefficient", given=-1, code="limits"),
        ),
        ("viscous", {"coefficient": "1 N m s^2"}, refused("machine.loads[0].coefficient", code="dimension")),
        ("coulomb", {"transition_speed": 0}, refused("machine.loads[0].transition_speed", "0 rad/s", code="limits")),
        ("coulomb", {"torqe": 0}, refused("machine.loads[0].torqe", "torque", code="unknown-key")),
        ("table", {"points": [[1, 0], [0, 1]]}, refused("machine.loads[0].points", given=[[1, 0], [0, 1]])),
    ],
)
def test_bad_values_are_refused_with_place_and_remedy(kind, changes, refusal):
    with refusal:
        load(kind, **changes)
