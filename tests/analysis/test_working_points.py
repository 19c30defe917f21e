"""What drives a rotor and what brakes it: whether a swing can only lose energy, and what is left beside a vibration."""

from functools import partial

import numpy as np
import pytest

from wucht.analysis.vibration import ForcedVibration, Vibration
from wucht.analysis.working_points import TorqueCurves, dry_friction, energy_scale, is_only_braked, torque_surplus
from wucht.files.building import machine_from

CARRIER = {"mass": 6.0, "stiffness": 1e4, "damping": 20.0, "gravity": 9.81}
ROTOR = {"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 0.05, "inertia": 0.1, "bearing_damping": 1e-3}
BALL = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.1, "length": 0.1, "damping": 0.01}
MOTION = {"direction": "x", "amplitude": 1e-3, "frequency": 30.0}
SLOPE, FREE = 0.02, 90.0
LINEAR = {"kind": "linear", "slope": SLOPE, "no_load_speed": FREE}
RISING = {"kind": "table", "points": [[-50, 1.5], [0, 1.0], [10, 0.5], [20, 0.9], [30, 2.0]]}


def machine(bodies=(ROTOR,), carrier=CARRIER, **more):
    return machine_from({"carrier": carrier, "bodies": list(bodies)} | more)


@pytest.mark.parametrize(
    "braked",
    [
        partial(machine),
        partial(machine, [ROTOR | {"bearing_damping": 0.0}]),
        partial(machine, [ROTOR, BALL]),
        partial(machine, carrier={"directions": "fixed"}),
        partial(machine, drive=LINEAR),
        partial(machine, drive={"kind": "constant-torque", "torque": 0.5}),
        partial(machine, loads=[{"kind": "viscous", "coefficient": 0.01}, {"kind": "coulomb", "torque": 0.05}]),
        partial(machine, [ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e"} | LINEAR]),
    ],
    ids=["bearing", "no losses", "ball", "fixed", "linear drive", "constant torque", "loads", "two rotors"],
)
def test_a_swing_can_only_lose_energy_to_what_is_damped(braked):
    assert is_only_braked(braked(), 50.0)


@pytest.mark.parametrize(
    "fed",
    [
        partial(machine, carrier={"directions": "x", "mass": 6.0, "motion": MOTION}),
        partial(machine, drive={"kind": "constant-speed", "speed": 10.0}),
        partial(machine, [ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e", "kind": "constant-speed", "speed": 10.0}]),
        partial(machine, [ROTOR, BALL | {"damping": 0.0}]),
        partial(machine, carrier=CARRIER | {"damping": 0.0}),
        partial(machine, drive=RISING),
        partial(machine, [ROTOR, ROTOR | {"name": "e"}], drives=[{"on": "e"} | RISING]),
    ],
    ids=["shaken", "prescribed", "another prescribed", "free ball", "free carrier", "rising torque", "of another rotor"],
)
def test_not_so_where_it_is_shaken_driven_by_more_at_a_speed_than_at_rest_or_not_damped(fed):
    assert not is_only_braked(fed(), 50.0)


@pytest.mark.parametrize(("fastest", "braked"), [(20.0, True), (21.0, True), (25.0, False)])
def test_speeds_beyond_the_fastest_do_not_matter(fastest, braked):
    """The torque of the drive exceeds that at rest from 21 rad/s on."""
    assert is_only_braked(machine([ROTOR | {"bearing_damping": 0.0}], drive=RISING), fastest) is braked


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_surplus_of_the_drive_over_the_vibration(sense):
    """On an isotropic carrier the vibration takes c w z^2 with z = U w^2/|k - m w^2 + i c w|; bearings take b w."""
    driven = machine(carrier=CARRIER | {"gravity": 0.0}, drive=LINEAR | {"no_load_speed": sense * FREE})
    w = np.array([5.0, 30.0, 31.6, 35.0, 80.0, 120.0])
    z = 0.05 * w**2 / np.abs(1e4 - 10 * w**2 + 20j * w)
    surplus = torque_surplus(driven, Vibration.of(driven), np.zeros(1), w)
    assert surplus == pytest.approx(SLOPE * (FREE - w) - 1e-3 * w - 20 * w * z**2, rel=1e-9)
    assert surplus[0] > 0 > surplus[2]


def test_bodies_that_compensate_leave_the_drive_all_of_its_torque():
    driven = machine([ROTOR | {"unbalance": 0.01}, BALL], drive=LINEAR)
    w = np.array([20.0, 50.0])
    surplus = torque_surplus(driven, Vibration.of(driven), np.array([0.0, np.pi]), w)
    assert surplus == pytest.approx(SLOPE * (FREE - w) - 1e-3 * w, rel=1e-9)


# --- a motor and a fan, with nothing that vibrates ---

FIXED = {"directions": "fixed"}
FAN = {"kind": "quadratic", "coefficient": 1e-4}
STEADY = (-SLOPE + np.sqrt(SLOPE**2 + 4e-4 * SLOPE * FREE)) / 2e-4  # slope (free - w) = 1e-4 w^2


def balance(low, high, points=51, **parts):
    """Torques on the only rotor."""
    made = machine([ROTOR | {"bearing_damping": 0.0}], FIXED, **parts)
    return TorqueCurves(made, made.rotor, ForcedVibration.of(made, np.zeros(1)), (low, high), points)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_working_point_of_a_fan(sense):
    curves = balance(-100.0, 100.0, drive=LINEAR | {"no_load_speed": sense * FREE}, loads=[FAN])
    (point,) = curves.working_points
    assert point.speed == pytest.approx(sense * STEADY, rel=1e-12)
    assert point.torque == pytest.approx(sense * SLOPE * (FREE - STEADY), rel=1e-12)
    assert (point.slope, point.no_load_speed) == pytest.approx((SLOPE, sense * FREE), rel=1e-9)
    assert point.stable
    assert not point.tangential
    assert (point.slip, curves.breakdown, curves.runaway) == (None, None, False)
    w = np.array([-70.0, 30.0])
    (drive, load, vibration), (drive_slope, load_slope, _) = curves.torques(w)
    assert drive == pytest.approx(SLOPE * (sense * FREE - w))
    assert load == pytest.approx(1e-4 * w * np.abs(w))
    assert not vibration.any()
    assert drive_slope == pytest.approx([-SLOPE] * 2)
    assert load_slope == pytest.approx(2e-4 * np.abs(w))
    assert curves.surplus(w)[0] == pytest.approx(drive - load)
    assert curves.surplus(w)[1] == pytest.approx(drive_slope - load_slope)


def test_the_grid_has_both_ends_and_is_dense_at_standstill():
    grid = balance(-20.0, 100.0, drive=LINEAR).grid
    assert (grid[0], grid[-1]) == (-20.0, 100.0)
    assert (np.diff(grid) > 0).all()
    assert np.isin(np.linspace(-20, 100, 51), grid).all()
    assert np.abs(grid[grid != 0]).min() == pytest.approx(100 * 1e-5)


@pytest.mark.parametrize(("level", "speeds"), [(0.5, []), (1.0, [(20.0, False, True)]), (1.2, [None, None])])
def test_points_of_a_table_that_is_crossed_touched_or_missed(level, speeds):
    """A hump of 1 N m at 20 rad/s over a constant load: below its height two points, at it one that is only touched."""
    bump = {"kind": "table", "points": [[-50, 0], [0, 0], [20, level], [40, 0], [60, 0]]}
    load = {"kind": "table", "points": [[-1, 1.0], [0, 1.0], [60, 1.0]]}
    points = balance(1.0, 50.0, drive=bump, loads=[load]).working_points
    assert len(points) == len(speeds)
    if len(points) == 1:
        (point,) = points
        assert (point.speed, point.stable, point.tangential) == (pytest.approx(20.0, abs=1e-3), False, True)
        assert point.torque == pytest.approx(1.0)
    if len(points) == 2:
        rising, falling = points
        assert rising.speed < 20 < falling.speed
        assert [p.stable for p in points] == [False, True]
        assert not (rising.tangential or falling.tangential)
        assert rising.slope < 0 < falling.slope
        assert falling.speed == pytest.approx(40 - rising.speed, rel=1e-6)


@pytest.mark.parametrize("gear", [1.0, 3.0])
def test_slip_and_breakdown_of_an_induction_motor(gear):
    """Without reactance of magnetising: s_k = R2/sqrt(R1^2 + X^2), T_k = 3 V^2/(2 w_s (R1 + sqrt(R1^2 + X^2)))."""
    motor = {
        "kind": "induction", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 2.0,
        "rotor_resistance": 1.5, "stator_reactance": 3.0, "rotor_reactance": 3.0,
    }  # fmt: skip
    driven = motor | ({} if gear == 1.0 else {"transmission": {"ratio": gear, "inertia": 0.0}})
    curves = balance(1.0, 160.0 / gear, drive=driven, loads=[{"kind": "quadratic", "coefficient": 1e-4}])
    synchronous, impedance = 2 * np.pi * 50 / 2, np.hypot(2.0, 6.0)
    slip, speed, torque = curves.breakdown
    assert slip == pytest.approx(1.5 / impedance)
    assert speed == pytest.approx((1 - slip) * synchronous / gear)
    assert torque == pytest.approx(gear * 3 * 230**2 / (2 * synchronous * (2 + impedance)), rel=1e-9)
    point = curves.working_points[-1]
    assert point.slip == pytest.approx(1 - point.speed * gear / synchronous)
    assert 0 < point.slip < slip
    assert point.torque == pytest.approx(1e-4 * point.speed**2, rel=1e-6)


@pytest.mark.parametrize(("drive", "loads", "away"), [
    ({"kind": "constant-torque", "torque": 0.5}, [], True),
    ({"kind": "constant-torque", "torque": -0.5}, [], True),
    ({"kind": "constant-torque", "torque": 0.5}, [FAN], False),
    ({"kind": "constant-torque", "torque": 0.5}, [{"kind": "coulomb", "torque": 0.4}], True),
    ({"kind": "constant-torque", "torque": 0.5}, [{"kind": "coulomb", "torque": 0.6}], False),
    (None, [], False),
    (None, [FAN], False),
    (LINEAR, [], False),
])  # fmt: skip
def test_a_runaway_is_a_torque_that_no_load_ever_takes(drive, loads, away):
    parts = {"drive": drive} if drive else {}
    assert balance(1.0, 50.0, loads=loads, **parts).runaway is away


@pytest.mark.parametrize("gear", [1.0, 2.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("most", "within"), [(5.0, True), (0.17, True), (0.15, False)])
def test_a_controlled_speed_is_held_where_the_torque_is_within_limits(most, within, sense, gear):
    """At 40 rad/s the fan takes 0.16 N m: the drive gives as much, up to its limit."""
    held = {
        "kind": "inverter",
        "set_speed": sense * 40.0 * gear,
        "gain": 1.0,
        "integral_time": 0.1,
        "torque_limit": most / gear,
    }
    held |= {} if gear == 1.0 else {"transmission": {"ratio": gear, "inertia": 0.0}}
    points = balance(-80.0, 80.0, drive=held, loads=[FAN]).working_points
    at_speed = [p for p in points if abs(p.speed - sense * 40) < 1e-6]
    assert bool(at_speed) is within
    for point in at_speed:
        assert point.torque == pytest.approx(sense * 0.16)
        assert (point.slope, point.no_load_speed) == (np.inf, sense * 40.0)
        assert point.stable
        assert not point.tangential


def test_dry_friction_is_the_sum_of_all_loads_with_the_widest_transition():
    loads = [
        {"kind": "coulomb", "on": "d", "torque": 0.3, "transition_speed": 0.2},
        {"kind": "coulomb", "on": "e", "torque": 0.5, "transition_speed": 0.1},
        {"kind": "viscous", "on": "d", "coefficient": 0.1},
    ]
    assert dry_friction(machine([ROTOR, ROTOR | {"name": "e"}], loads=loads)) == pytest.approx((0.8, 0.2))
    assert dry_friction(machine()) == (0.0, 0.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_scale_of_energies_is_that_of_all_bodies_in_operation(sense):
    """J w^2/2 of rotor and ball at the no-load speed, without bearing; 1 J where nothing turns."""
    turning = machine([ROTOR | {"bearing_damping": 0.0}, BALL], drive=LINEAR | {"no_load_speed": sense * FREE})
    assert energy_scale(turning) == pytest.approx((0.1 + 0.1 * 0.1**2) * FREE**2 / 2, rel=1e-9)


@pytest.mark.parametrize("excess", [5e-10, -5e-10])
def test_curves_that_cross_by_next_to_nothing_do_not_also_touch(excess):
    """A hump that is that much higher than the load: two points beside its top, or its top alone."""
    bump = {"kind": "table", "points": [[-50, 0], [0, 0], [20, 1 + excess], [40, 0], [60, 0]]}
    load = {"kind": "table", "points": [[-1, 1.0], [0, 1.0], [60, 1.0]]}
    points = balance(1.0, 50.0, drive=bump, loads=[load]).working_points
    assert [p.tangential for p in points] == ([False, False] if excess > 0 else [True])
    assert [p.speed for p in points] == pytest.approx([20.0] * len(points), abs=1e-2)
    assert [p.stable for p in points] == ([False, True] if excess > 0 else [False])


@pytest.mark.parametrize("share", [0.9999, 1.0])
def test_an_end_of_the_range_at_which_the_torques_balance_is_a_working_point(share):
    """Of a straight characteristic without load: its no-load speed."""
    points = balance(1.0, share * FREE, drive=LINEAR).working_points
    assert [p.speed for p in points] == ([] if share < 1 else [FREE])
