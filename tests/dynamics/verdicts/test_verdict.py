"""Verdicts on synthetic motions, on both sides of every limit, and what is advised where there is none."""

import math
from functools import cache

import numpy as np
import pytest
from motions import (
    DECAYS,
    END,
    LONGER,
    ROTOR,
    RUN_UPS,
    UNBALANCE,
    W,
    about,
    approaching,
    beyond,
    carrier,
    judged,
    just_over,
    knocking,
    linear,
    machine,
    steady,
    swinging_between,
    tenth,
    with_ball,
    with_balls,
)

from wucht.analysis.time_constants import run_up_time, runaway_limit
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
    assert found.evidence.has_settled is (outcome == "passed")
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


DECAY = 10.0  # s, of the free vibrations of the carriers


# --- too short ---


def test_six_turns_are_enough_for_a_verdict():
    """The first average is over the first turn."""
    assert judged(beyond(), steady, until=7.0).outcome == "passed"
    early = judged(beyond(), steady, until=6.8)
    assert early.outcome == "unidentified"
    assert early.needed_time == just_over(LONGER * 6.8)
    assert "fewer than 6 turns were made" in early.advice


@pytest.mark.parametrize(
    "changing",
    [
        {"schedules": [{"parameter": "drive.slope", "points": [[0, 0.1], [110, 0.2]]}]},
        {"bodies": [ROTOR | {"mass": 3.5}, with_balls("a")[1] | {"release": {"time": 110.0}}]},
    ],
    ids=["schedule", "release"],
)
@pytest.mark.parametrize(("until", "outcome"), [(109.0, "unidentified"), (111.0, "passed")])
def test_there_is_no_verdict_before_the_machine_changes_for_the_last_time(changing, until, outcome):
    bodies = changing.get("bodies", [ROTOR])
    changed = machine(carrier(W / 2), bodies, linear(W), **{k: v for k, v in changing.items() if k != "bodies"})
    found = judged(changed, *[steady] * len(bodies), until=until)
    assert found.outcome == outcome
    assert found.needed_time == (220.0 if outcome == "unidentified" else None)
    assert outcome == "passed" or found.advice == "the machine still changes at 110 s: run at least until 220 s"


def turning_until(end):
    """A rotor that turns once a second and then comes to rest within a second."""
    return lambda t: W / 2 * (t - 0.2 * np.log(np.cosh((t - end) / 0.2)))


@pytest.mark.parametrize(
    ("end", "turns", "outcome"),
    [(78.0, True, "unidentified"), (72.0, False, "unidentified"), (54.0, False, "unidentified"), (46.0, False, "stopped")],
)
def test_a_rotor_that_has_not_turned_in_the_last_quarter_does_not_turn_and_has_an_end_if_not_in_the_last_half(
    end, turns, outcome
):
    found = judged(beyond(), turning_until(end), until=100.0)
    assert (found.assessment is not None) is turns
    assert found.outcome == outcome


# --- how long to go on ---


@pytest.mark.parametrize(("off", "time", "observed"), [(0.005, 60.0, False), (0.05, 60.0, True), (0.05, 150.0, False)])
def test_an_approach_is_given_what_its_observed_decay_still_takes(off, time, observed):
    """Until half as far again as it has to go is a quarter of a percent; observed is what takes two thirds of the run."""
    found = judged(beyond(), approaching(1.0, off, time))
    assert found.outcome == "unidentified"
    needed = END + time * math.log(1.5 * off / 0.0025)
    assert (needed > LONGER * END and time < 2 / 3 * END) is observed
    assert found.needed_time == pytest.approx(needed if observed else LONGER * END, rel=0.015)


@pytest.mark.parametrize("until", [201.0, 11.0])
def test_what_does_not_say_where_it_goes_is_given_less_than_three_times_as_long(until):
    """Its speed rises: 0.8 turns a second at first."""
    found = judged(beyond(), lambda t: W * (0.8 * t + t**2 / 2000), until=until)
    assert found.outcome == "unidentified"
    assert found.needed_time == just_over(LONGER * until)


@pytest.mark.parametrize("speed", [0.9, 0.3])
def test_a_slow_drive_is_given_two_of_its_run_ups(speed):
    """Its slip falls by the factor e in a thousand seconds. Before the resonance the vibration holds it."""
    slow = machine(carrier(W / 2, decay=100.0), [ROTOR | {"unbalance": 1e-4}], linear(W, 1e-4))
    found = judged(slow, approaching(speed, 0.005))
    assert found.outcome == "unidentified"
    run_up = run_up_time(slow, found.speed)
    assert run_up == pytest.approx(1000 * math.log((1 - speed) / 0.005), rel=0.05)
    assert found.needed_time == just_over(RUN_UPS * run_up if speed == 0.9 else LONGER * END)


# --- from when on it is settled ---


@pytest.mark.parametrize("sign", [1, -1])
def test_a_rotor_has_settled_when_it_is_within_half_a_percent(sign):
    found = judged(beyond(), lambda t: W * (t + sign * 0.5 * 8 * np.exp(-t / 8)))
    assert found.settling_time == pytest.approx(8 * math.log(0.5 / 0.005), abs=1.0)


# --- transients: free vibrations, and bodies that still move ---


@pytest.mark.parametrize(("decays", "outcome"), [(5.1, "balancer-captured"), (4.9, "unidentified")])
def test_bodies_that_lag_may_be_a_transient_until_free_vibrations_have_decayed_five_times(decays, outcome):
    found = judged(with_ball((END - 1) / decays), steady, lambda t: 0.5 * W * t, until=END - 1)
    assert found.outcome == outcome
    assert found.needed_time == (None if outcome != "unidentified" else pytest.approx(5 * (END - 1) / decays, rel=0.01))
    assert outcome != "unidentified" or "free vibrations have hardly decayed" in found.advice


@pytest.mark.parametrize(
    ("unrest", "decays", "outcome"),
    [(0.085, 11.0, "passed"), (0.12, 11.5, "unidentified"), (0.12, 12.5, "passed")],
)
def test_bodies_that_change_the_residual_by_a_tenth_are_not_at_rest_for_twelve_times_the_slowest_decay(unrest, decays, outcome):
    until = DECAY * decays
    found = judged(with_ball(), steady, swinging_between(1.6 * (1 - unrest), 1.6), until=until)
    assert found.assessment.unrest == pytest.approx(unrest, rel=0.05)
    assert found.outcome == outcome
    assert found.needed_time == (None if outcome == "passed" else just_over(DECAYS * DECAY))


@pytest.mark.parametrize(("residual", "scatter"), [(0.0165, 0.001), (0.5, 0.025)])
def test_a_residual_that_fluctuates_for_good_has_an_outcome_whatever_the_chance(residual, scatter):
    """As of balls that knock under gravity: one in six of such runs seemed to drift, to fall, or to swing ever further."""
    outcomes = [judged(with_ball(), steady, knocking(seed, residual, scatter), until=201.0).outcome for seed in range(16)]
    assert outcomes == ["passed"] * 16


@pytest.mark.parametrize(("change", "outcome"), [(-0.012, "unidentified"), (0.0, "passed")])
def test_a_residual_that_falls_beyond_its_scatter_may_be_compensated(change, outcome):
    """Over the last half of the run, eight times the scatter."""
    for seed in range(4):
        at_end, rest = knocking(seed, 0.02, 0.0015), knocking(seed, 0.02 - change, 0.0015)
        found = judged(with_ball(), steady, lambda t, a=at_end, b=rest: a(t) + (b(t) - a(t)) * (201.0 - t) / 100.5, until=201.0)
        assert found.outcome == outcome


@pytest.mark.parametrize(("sense", "decay"), [(1.0, DECAY), (-1.0, (0.1 + 2e-4) / 2.5e-3)])
def test_the_slowest_decay_is_that_at_the_speed_in_its_sense(sense, decay):
    """The torque of the drive falls steeply at a turn a second counter-clockwise, and hardly at one clockwise."""
    points = [[-k * W, 2.5e-3 * (k - 1) * W] for k in (3, 2, 0.5, 0)] + [[0.5 * W, 0.05 * W], [3 * W, -0.2 * W]]
    of = machine(carrier(W / 2), with_balls("a"), {"on": "d", "kind": "table", "points": points})
    rotor, ball = steady, swinging_between(1.6 * (1 - 0.12), 1.6)
    found = judged(of, lambda t: sense * rotor(t), lambda t: sense * ball(t), until=12.5 * DECAY, free=sense * W)
    assert found.assessment.sense == sense
    assert found.outcome == ("passed" if decay == DECAY else "unidentified")
    assert found.needed_time == (None if decay == DECAY else just_over(DECAYS * decay))


@cache
def with_two_balls():
    return machine(carrier(W / 2), with_balls("a", "b"), linear(W))


def about_compensation(width):
    """Two balls that swing about where they compensate the unbalance, with an amplitude over time."""

    def swing(t):
        return width(t) * np.cos(2 * np.pi * t / 7.3)

    return about(2 * np.pi / 3, swing), about(-2 * np.pi / 3, lambda t: -swing(t))


@pytest.mark.parametrize(
    ("width", "outcome"),
    [
        (lambda t: 0.3 * np.exp(-t / 40), "unidentified"),  # 3 % at last
        (lambda t: 0.3 * np.exp(-t / 10), "compensated"),
        (lambda t: 0.03 * np.exp((t - END) / 40), "unidentified"),
        (lambda t: 0 * t, "compensated"),
        (lambda t: 0 * t + 0.003, "compensated"),
    ],
    ids=["still falling", "fallen", "rising", "at rest", "about it for good"],
)
def test_bodies_that_swing_about_where_they_compensate(width, outcome):
    """They have not passed as long as their swing falls; and they may leave if it rises."""
    found = judged(with_two_balls(), steady, *about_compensation(width))
    assert found.outcome == outcome
    assert found.needed_time is None if outcome != "unidentified" else found.needed_time >= 2 * END


def test_bodies_at_rest_elsewhere_leave_unbalance():
    assert judged(with_two_balls(), steady, about(2.0, lambda t: 0), about(-2.2, lambda t: 0)).outcome == "passed"


# --- settled within a tolerance ---


@pytest.mark.parametrize(("off", "settled"), [(6e-4, True), (7.3e-4, False)])
def test_a_run_until_settled_goes_on_until_the_speed_is_known_to_the_tolerance(off, settled):
    assert judged(beyond(), approaching(1.0, off)).settled_within(1e-3) is settled


@pytest.mark.parametrize(("width", "settled"), [(0.018, True), (0.022, False)])
def test_and_until_a_lag_is_known_to_two_percent_of_it(width, settled):
    """Its bounds are five times as far apart as its range is wide."""
    change = 0.5 * width / 5

    def ball(t):
        return W * (0.5 * t - 10 * change / 4 * np.cos(np.pi * tenth(t)))

    found = judged(with_ball(), steady, ball)
    assert found.outcome == "balancer-captured"
    assert found.settled_within(1e-3) is settled
