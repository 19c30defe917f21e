"""Synthetic swings of a rotor that does not turn any more, on both sides of every limit."""

import math
from functools import cache

import numpy as np
import pytest
from motions import DECAYS, END, FIXED, LONGER, ROTOR, W, approaching, beyond, growing, judged, just_over, machine, seen, tenth

from wucht.dynamics.verdicts.swings import mean_turning_evidence, swing_of

STOP = 100.0


def coasting(angle, **more):
    return judged(machine(FIXED, [ROTOR | more]), angle, until=STOP, free=0.0)


@pytest.mark.parametrize("time", [200.0, 2000.0])
def test_one_that_a_viscous_damper_brakes_is_given_its_time_to_a_ten_thousandth(time):
    found = coasting(lambda t: 5 * W * time * (1 - np.exp(-t / time)))
    assert found.outcome == "unidentified"
    assert found.needed_time == pytest.approx((STOP + time * math.log(1e4)), rel=0.05)


@pytest.mark.parametrize("stop", [150.0, 1000.0])
def test_one_that_dry_friction_brakes_is_given_its_time_to_the_stop(stop):
    found = coasting(lambda t: 5 * W * (t - t**2 / (2 * stop)))
    assert found.outcome == "unidentified"
    assert found.needed_time == pytest.approx(max(LONGER * STOP, stop), rel=0.05)


def test_one_that_air_brakes_does_not_come_to_rest():
    """J w' = -c w^2: it falls with the time, and its angle grows without bound."""
    found = coasting(lambda t: 5 * W * 50 * np.log(1 + t / 50))
    assert found.outcome == "unidentified"
    assert found.needed_time is None
    assert found.advice == "the rotor coasts ever more slowly, and does not stop: a longer run would not change the verdict"


def test_where_the_vibration_holds_a_rotor_the_slip_in_its_bearing_does_not_say_how_long():
    """Before its resonance: it slips by the factor e in days, but stands within minutes."""
    slow = machine({"mass": 6.0, "stiffness": 10 * (1.2 * W) ** 2, "damping": 2.0},
                   [ROTOR | {"bearing_damping": 1e-7}],
                   {"kind": "constant-torque", "torque": 1.0, "on": "d"})  # fmt: skip
    found = judged(slow, approaching(1.0, 0.05), free=1e7)
    assert found.outcome == "unidentified"
    assert found.needed_time < 2 * DECAYS * STOP


@cache
def braked():
    """It can only lose energy."""
    return machine({"directions": "x", "mass": 6.0, "stiffness": 1e3, "damping": 10.0, "gravity": 9.81}, [ROTOR])


@cache
def shaken():
    motion = {"direction": "x", "amplitude": 1e-3, "frequency": 2.5}
    return machine({"directions": "x", "mass": 6.0, "motion": motion}, [ROTOR | {"bearing_damping": 1e-3}])


def swinging(size):
    """To and fro once in two seconds, of a size over time; its speed is greatest at whole seconds."""
    return lambda t: size(t) * np.sin(np.pi * t)


def falling(first, last, before=0.0, until=100.0):
    """A size over time, ``first`` and ``last`` where it is greatest in the last five tenths, after a larger one."""
    begin, end = until / 2 + 1, until - until / 10 + 1
    rate = math.log(last / first) / (end - begin)
    return lambda t: first * np.exp(rate * (t - begin)) + before * np.exp(-t)


@pytest.mark.parametrize(
    ("first", "last", "outcome"),
    [(0.6, 0.48, "stopped"), (0.6, 0.52, "unidentified"), (0.4, 0.355, "stopped"), (0.4, 0.365, "unidentified")],
)
def test_a_swing_that_can_only_lose_energy_stops_at_half_of_the_largest_speed_once_it_has_lost_a_tenth(first, last, outcome):
    """A tenth of its speed from the first to the last window. It began with twice that of a size of a half."""
    found = judged(braked(), swinging(falling(first, last, 1.0 - falling(first, last)(0.0))), until=100.0, free=None)
    assert found.outcome == outcome


def test_the_same_swing_on_a_shaken_carrier_may_go_on():
    shape = swinging(falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0)))
    assert judged(braked(), shape, until=100.0, free=None).outcome == "stopped"
    assert judged(shaken(), shape, until=100.0, free=None).outcome == "unidentified"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_so_it_stops_after_it_has_made_some_turns_itself(sense):
    """A swing that loses energy, after six turns within some seconds: these are no other rotor's, which could give energy."""
    shape = swinging(falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0)))
    found = judged(braked(), lambda t: shape(t) - sense * 6 * W * np.exp(-t / 3), until=100.0, free=None)
    assert found.outcome == "stopped"


@pytest.mark.parametrize("turns", [0.0, 1.0])
def test_the_same_swing_beside_a_rotor_that_turns_may_go_on(turns):
    """What turns has energy to give, through the carrier."""
    described = {"directions": "x", "mass": 6.0, "stiffness": 1e3, "damping": 10.0, "gravity": 9.81}
    two = machine(described, [ROTOR, ROTOR | {"name": "e"}])
    shape = swinging(falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0)))
    watched = seen(two, 100.0, shape, lambda t: turns * W * t)
    low, high = swing_of(two, watched)[0]
    assert (low, high > 0.1) == (0.0, turns > 0)


@pytest.mark.parametrize(("change", "outcome"), [(0.8e-2, "stopped"), (1.25e-2, "unidentified")])
def test_its_place_is_leaving_if_it_moves_ever_faster_by_a_hundredth_of_a_radian_from_window_to_window(change, outcome):
    swing, place = swinging(falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0))), growing(change)
    assert judged(braked(), lambda t: swing(t) + place(t + END - 0.5 - 100), until=100.0, free=None).outcome == outcome


@pytest.mark.parametrize(("part", "outcome"), [(0.9, "stopped"), (1.1, "unidentified")])
def test_its_place_may_go_to_and_fro_by_a_quarter_turn(part, outcome):
    """From window to window, with half as much again."""
    swing, mean = swinging(falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0))), part * math.pi / 2 / 1.5 / 2
    to_and_fro = judged(braked(), lambda t: swing(t) + mean * np.pi / 2 * np.sin(np.pi * t / 10), until=100.0, free=None)
    assert to_and_fro.outcome == outcome


@pytest.mark.parametrize(("growth", "outcome"), [(1.04, "stopped"), (1.06, "unidentified")])
def test_a_swing_that_has_grown_again_by_a_twentieth_may_turn_over(growth, outcome):
    """In the last window, after it has fallen for four."""
    size = falling(0.6, 0.4, 1.0 - falling(0.6, 0.4)(0.0))
    larger = growth * size(80.0) / size(91.0) - 1

    def grown(t):
        return size(t) * (1 + larger * (1 + np.tanh(10 * (t - 90.5))) / 2)

    assert judged(braked(), swinging(grown), until=100.0, free=None).outcome == outcome


@pytest.mark.parametrize(("of", "rest"), [(braked, 0.45), (shaken, 1e-4)])
def test_a_swing_that_falls_is_given_its_time_to_rest(of, rest):
    """It is at rest at a ten-thousandth of its largest speed; one that can only lose energy at nine tenths of a half."""
    found = judged(of(), swinging(lambda t: np.exp(-t / 600)), until=100.0, free=None)
    assert found.outcome == "unidentified"
    last = math.exp(-90 / 600)
    assert found.needed_time == pytest.approx((100 + 600 * math.log(last / rest)), rel=0.015)


@pytest.mark.parametrize(("off", "outcome"), [(0.018, "oscillating"), (0.022, "unidentified")])
def test_a_swing_whose_size_approaches_its_limit_to_three_percent_goes_on(off, outcome):
    """In its logarithm, with half as far again as it has to go."""

    def size(t):
        return 0.5 * np.exp(off * np.exp((91 - t) / 20))

    assert judged(shaken(), swinging(size), until=100.0, free=None).outcome == outcome


@pytest.mark.parametrize(("beat", "outcome"), [(0.17, "oscillating"), (0.19, "unidentified")])
def test_a_swing_whose_size_goes_to_and_fro_may_fall_unseen_however_its_changes_contract(beat, outcome):
    """From tenth to tenth by a third of the change before, in its logarithm; at rest is a ten-thousandth."""

    def size(t):
        return 0.5 * np.exp(beat * (-0.35) ** np.maximum(np.floor(np.real(t) / 10) - 5, 0))

    found = judged(shaken(), lambda t: size(t) * np.cos(np.pi * t), until=100.0, free=None)  # at rest where the size changes
    assert found.outcome == outcome


@pytest.mark.parametrize(("fall", "outcome"), [(0.8e-3, "oscillating"), (1.25e-3, "unidentified")])
def test_swings_that_fall_by_less_than_a_thousandth_from_window_to_window_are_alike(fall, outcome):
    found = judged(shaken(), swinging(lambda t: 0.5 * np.exp(-fall * t / 10)), until=100.0, free=None)
    assert found.outcome == outcome


@pytest.mark.parametrize(("size", "outcome"), [(1.2e-4, "oscillating"), (1.05e-4, "unidentified")])
def test_alike_they_may_still_fall_unseen(size, outcome):
    """By 0.08 % a window, 150 windows long; at rest is a ten-thousandth of the largest speed."""

    def small(t):
        return size * np.exp(0.8e-3 * (91 - t) / 10) + np.exp(-t)

    found = judged(shaken(), swinging(small), until=100.0, free=None)
    assert found.evidence.swing[0] == pytest.approx(found.evidence.swing[1] * math.exp(-0.8e-3 * 152), rel=1e-3)
    assert found.outcome == outcome


def test_what_creeps_and_does_not_say_where_to_is_given_some_times_as_long():
    assert judged(braked(), lambda t: 0.01 * t, until=100.0, free=None).needed_time == just_over(LONGER * 100)


@pytest.mark.parametrize(("change", "outcome"), [(0.0, "passed"), (0.05, "passed"), (0.065, "unidentified")])
def test_a_rotor_that_turns_back_in_each_turn_is_judged_by_its_mean_speed_if_that_is_even(change, outcome):
    """Means over tenths of the run that go to and fro, with half their range allowed for: within a fifth of the speed."""

    def angle(t):
        place = t - 10 * change / 4 * np.cos(np.pi * tenth(t))
        return W * place + 1.2 * np.sin(W * place)

    found = judged(beyond(), angle)
    assert found.outcome == outcome
    assert found.assessment is None


@pytest.mark.parametrize(("until", "told"), [(60_000.0, False), (3000.0, True)])
def test_of_what_turns_over_for_ever_nothing_more_is_told_by_a_longer_run(until, told):
    """To and fro by more than a turn, for tens of thousands of spans of time."""
    found = judged(machine(FIXED, [ROTOR]), lambda t: 1.2 * np.pi * np.sin(np.pi * t / 100), until=until, free=None, step=0.5)
    assert found.outcome == "unidentified"
    assert (found.needed_time is not None) is told
    assert ("a longer run would not change the verdict" in found.advice) is not told
    assert ("too short" in found.sentence) is told


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("turns", "turning"), [(12.0, False), (12.6, True)])
def test_a_rotor_that_turns_back_in_each_turn_turns_in_its_sense(sense, turns, turning):
    """It turns back each second, and makes six turns or not in the half of the run that counts, less a second."""
    speed = turns * W / STOP

    def angle(t):
        return sense * (speed * t + 0.1 * np.sin(W * t))

    of = beyond()
    found = mean_turning_evidence(of, seen(of, STOP, angle), sense * W)
    assert (found is not None) is turning
    if found is not None:
        assert found.free_speed == pytest.approx(W) and found.mean_speed == pytest.approx((speed, speed), rel=0.05)
        backward = mean_turning_evidence(of, seen(of, STOP, angle), -sense * W)
        assert backward.free_speed == pytest.approx(-W)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize(("range_", "swings"), [(0.99, True), (1.01, False)])
def test_what_goes_through_more_than_a_turn_does_not_swing(sense, range_, swings):
    found = swing_of(braked(), seen(braked(), STOP, lambda t: sense * range_ * np.pi * np.sin(W * t)))
    assert (found is not None) is swings
