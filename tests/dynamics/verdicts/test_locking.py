"""Rotors that may be entrained, of synthetic motions: locked or not, on both sides of every limit."""

from functools import cache

import numpy as np
import pytest
from motions import (
    END,
    LONGER,
    ROTOR,
    W,
    carrier,
    growing,
    judged,
    just_over,
    linear,
    machine,
    seen,
    steady,
    tenth,
    with_balls,
)

from wucht.dynamics.verdicts.locking import is_locking, locked

DECAY = 10.0  # s, of the free vibrations of the carriers


@cache
def pair(decay=DECAY):
    """Two rotors, of which the main one is ``d``, each driven to a turn a second."""
    bodies = [ROTOR | {"mass": 2.0}, ROTOR | {"mass": 2.0, "name": "e"}]
    return machine(carrier(W / 2, decay), bodies, drives=[linear(W), linear(W) | {"on": "e"}])


@cache
def shaken():
    """A rotor on a carrier that is shaken once a second."""
    return machine({"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": W}}, [ROTOR], linear(W))


def test_several_free_rotors_or_one_on_a_shaken_carrier_are_judged_by_locking():
    assert is_locking(pair())
    assert is_locking(shaken())
    assert not is_locking(machine(carrier(W / 2), [ROTOR], linear(W)))
    assert not is_locking(machine(carrier(W / 2), [ROTOR], {"on": "d", "kind": "constant-speed", "speed": W}))


@pytest.mark.parametrize(
    ("off", "outcome"), [(0.0, "synchronised"), (1e-5, "synchronised"), (0.0005, "unidentified"), (0.0015, "not-synchronised")]
)
def test_rotors_that_are_off_by_a_thousandth_are_not_synchronised(off, outcome):
    """And their phases must be at rest."""
    assert judged(pair(), steady, lambda t: (1 - off) * W * t + 1.0).outcome == outcome


@pytest.mark.parametrize(
    ("off", "outcome"), [(0.0, "entrained"), (1e-5, "entrained"), (0.0005, "unidentified"), (0.0015, "not-entrained")]
)
def test_a_rotor_that_is_off_by_a_thousandth_is_not_entrained(off, outcome):
    assert judged(shaken(), lambda t: (1 - off) * W * t + 1.0).outcome == outcome


@pytest.mark.parametrize(("change", "bounded"), [(0.19, True), (0.21, False)])
def test_rotors_at_speeds_of_their_own_may_meet_if_these_change_by_a_fifth(change, bounded):
    """As far as it is looked ahead, 150 tenths: a drift of the speed from tenth to tenth."""

    def main(t):
        return W * (t + change / 150 * 5 * tenth(t) ** 2)

    found = judged(pair(), main, lambda t: 0.9 * main(t))
    assert found.locked.evidence.bounded is bounded
    assert found.outcome == ("not-synchronised" if bounded else "unidentified")


@pytest.mark.parametrize(("change", "outcome"), [(0.8e-8, "synchronised"), (1.25e-8, "unidentified")])
def test_a_growth_of_the_difference_of_speeds_counts_from_a_hundred_millionth_a_window_on(change, outcome):
    assert judged(pair(), steady, lambda t: W * (t + 50 * growing(change)(t))).outcome == outcome


@pytest.mark.parametrize(("change", "outcome"), [(0.8e-8, "not-synchronised"), (1.25e-8, "unidentified")])
def test_a_growth_of_the_speed_counts_from_a_hundred_millionth_a_window_on(change, outcome):
    def main(t):
        return W * (t + 50 * growing(change)(t))

    assert judged(pair(), main, lambda t: 0.9 * main(t)).outcome == outcome


@pytest.mark.parametrize(("fall", "outcome"), [(0.025, "not-synchronised"), (0.04, "unidentified")])
def test_a_difference_of_speeds_that_falls_to_and_fro_goes_on_to_fall(fall, outcome):
    """It is 10 %, and falls from window to window by such a share: as far as it is looked ahead to a thousandth, or not."""

    def slower(t):
        return W * t - 0.1 * W * (t - 5 * fall * tenth(t) ** 2 - 10 * 1.4 * fall / np.pi * np.cos(np.pi * tenth(t)))

    assert judged(pair(), steady, slower).outcome == outcome


@pytest.mark.slow
@pytest.mark.parametrize(("change", "outcome"), [(0.8e-4, "synchronised"), (1.25e-4, "unidentified")])
def test_a_phase_that_grows_by_a_ten_thousandth_a_window_is_leaving(change, outcome):
    """Within a quarter of a million turns: there the change of the speed is too small to be seen."""
    until = 250_001.0

    def slow(t):
        return END + (t - until) * (END - 1) / (until - 1)

    found = judged(pair(), steady, lambda t: W * t + growing(change)(slow(t)), until=until, step=5.0)
    assert found.outcome == outcome


def test_means_are_over_the_last_half_of_the_run():
    early = locked(pair(), seen(pair(), END, steady, lambda t: W * (t + 5 * np.exp(-t / 5))))
    assert early.window == pytest.approx((END - 50, END), abs=1e-9)
    assert early.evidence.periods == 50
    assert early.speeds == pytest.approx({"d": W, "e": W * (1 - 0.1 * np.exp(-51 / 5))}, rel=1e-7)


def test_phases_are_means_over_the_last_tenth_of_that():
    def slow(t):
        return W * t + 1 + 0.01 * (t - END)

    found = locked(pair(), seen(pair(), END, steady, slow))
    assert found.phases == {"e": pytest.approx(1 - 0.01 * 2.5, abs=1e-3)}
    assert found.creep == pytest.approx(0.01 * 25, rel=0.02)


@pytest.mark.parametrize(("until", "settled"), [(399.0, False), (401.0, True)])
def test_a_run_until_settled_of_such_rotors_lasts_four_hundred_turns(until, settled):
    assert judged(pair(), steady, steady, until=until).settled_within(1e-3) is settled


def test_too_few_periods_take_some_times_as_long():
    found = judged(pair(), steady, steady, until=7.0)
    assert found.outcome == "unidentified"
    assert found.advice.startswith("fewer than 5 whole periods were made in the last half")
    assert found.needed == just_over(LONGER * 7.0)


def test_phases_that_still_move_are_given_some_times_as_long():
    found = judged(pair(), steady, lambda t: 0.9995 * W * t)
    assert found.advice.startswith("the phases still move")
    assert found.needed == just_over(LONGER * END)


def test_each_of_several_rotors_has_an_outcome():
    found = judged(pair(), steady, lambda t: 0.45 * W * t, free=W)
    assert found.outcome == "not-synchronised"
    assert found.rotors == {"d": "passed", "e": "captured"}
    assert found.sentence.endswith("captured at the resonance: e")


@pytest.mark.parametrize(("drift", "outcome"), [(0.0, "not-entrained"), (0.15, "unidentified")])
def test_a_rotor_whose_ball_may_catch_up_may_be_entrained_yet(drift, outcome):
    """Its lag of a fifth falls by a share as far as it is looked ahead, 150 tenths."""
    with_ball = machine(
        {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": W}}, with_balls("a"), linear(W)
    )

    def rotor(t):
        return 0.98 * W * t

    def ball(t):
        return rotor(t) - 0.2 * W * (t - 2 * drift / 150 * 5 * tenth(t) ** 2)

    found = judged(with_ball, rotor, ball)
    assert found.standing.drifting is (outcome == "unidentified")
    assert found.outcome == outcome
