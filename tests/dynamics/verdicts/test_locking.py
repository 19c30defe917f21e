"""Rotors that may be entrained, of synthetic motions: locked or not, on both sides of every limit."""

from functools import cache
from typing import Any

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

from wucht.dynamics.verdicts.locking import (
    assess_locking,
    rotor_phases,
)

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
    assert found.locking.evidence.is_bounded is bounded
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
    early = assess_locking(pair(), seen(pair(), END, steady, lambda t: W * (t + 5 * np.exp(-t / 5))))
    assert early.window == pytest.approx((END - 50, END), abs=1e-9)
    assert early.evidence.periods == 50
    assert early.speeds == pytest.approx({"d": W, "e": W * (1 - 0.1 * np.exp(-51 / 5))}, rel=1e-7)


@pytest.mark.parametrize(("until", "settled"), [(399.0, False), (401.0, True)])
def test_a_run_until_settled_of_such_rotors_lasts_four_hundred_turns(until, settled):
    assert judged(pair(), steady, steady, until=until).settled_within(1e-3) is settled


def test_too_few_periods_take_some_times_as_long():
    found = judged(pair(), steady, steady, until=7.0)
    assert found.outcome == "unidentified"
    assert found.advice.startswith("fewer than 5 whole periods lie in the last half of the run")
    assert found.needed_time == just_over(LONGER * 7.0)


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
    assert found.assessment.drifting is (outcome == "unidentified")
    assert found.outcome == outcome


CAPTURED = "; captured at the resonance: d, e, at 50 % of the speed without vibration"
SYNCHRONISED = "the rotors turn at the same mean speed"


@cache
def exciters(resonance, *free, inertias=(0.1, 0.1)):
    """Rotors d, e, ..., which their drives turn at given multiples of W, 0: none drives it; their resonance likewise."""
    names = "def"[: len(free)]
    bodies = [ROTOR | {"name": n, "mass": 2.0, "inertia": j} for n, j in zip(names, (*inertias, 0.1), strict=False)]
    drives = [linear(f * W) | {"on": n} for n, f in zip(names, free, strict=True) if f]
    return machine(carrier(resonance * W) | {"directions": "x"}, bodies, drives=drives)


def swinging(share, sense=1, decay=70.0):
    """A turn a second, and a swing that decays slowly: in the last tenth it is that share of the speed, to either side."""
    return lambda t: sense * W * t + share * W * np.exp((100 - t) / decay) * 4 / (2 * np.pi) * np.sin(2 * np.pi * t / 4)


def test_exciters_that_swing_against_each_other_at_the_resonance_are_captured():
    """The swing of each decays too slowly to say what comes of it; the mean of both is steady."""
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002), swinging(-0.002))
    assert verdict.outcome == "synchronised"
    assert verdict.rotors == {"d": "captured", "e": "captured"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


def test_exciters_that_turn_against_each_other_too():
    verdict = judged(exciters(1.2, 2.0, -2.0), swinging(0.002), swinging(0.002, sense=-1))
    assert verdict.rotors == {"d": "captured", "e": "captured"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


def test_in_the_mean_a_heavy_rotor_counts_more():
    """What they do to each other, equal and opposite, moves the light one more."""
    unequal = exciters(1.2, 2.0, 2.0, inertias=(0.1, 0.3))
    assert judged(unequal, swinging(0.003), swinging(-0.001)).rotors == {"d": "captured", "e": "captured"}
    assert judged(unequal, swinging(0.003), swinging(-0.003)).rotors == {"d": "unidentified", "e": "unidentified"}


def test_what_becomes_of_a_swing_that_they_share_is_not_known():
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002), swinging(0.002))
    assert verdict.rotors == {"d": "unidentified", "e": "unidentified"}
    assert verdict.sentence == SYNCHRONISED


def test_a_swing_against_each_other_that_lasts_is_a_modulation_of_each():
    verdict = judged(exciters(1.2, 2.0, 2.0), swinging(0.002, decay=1e9), swinging(-0.002, decay=1e9))
    assert verdict.rotors == {"d": "captured-modulated", "e": "captured-modulated"}
    assert verdict.sentence == SYNCHRONISED + CAPTURED


@pytest.mark.parametrize(
    ("resonance", "free"),
    [(0.5, (1.0, 1.0)), (3.0, (1.1, 1.1)), (1.2, (1.5, 0.5)), (0.5, (2.0, 2.0))],
    ids=["beyond it", "below all", "all drives together stop short of it", "far beyond it"],
)
def test_exciters_that_are_not_held_at_the_resonance_are_not_called_captured(resonance, free):
    """Among them one whose drive would reach beyond the resonance, and is braked by that of the other."""
    verdict = judged(exciters(resonance, *free), swinging(0.002), swinging(-0.002))
    assert set(verdict.rotors.values()) == {"passed"}
    assert verdict.sentence == SYNCHRONISED


def test_exciters_in_opposition_do_not_shake_the_carrier_and_are_not_captured():
    verdict = judged(exciters(1.2, 2.0, 2.0), steady, lambda t: W * t + np.pi)
    assert verdict.outcome == "synchronised"
    assert verdict.rotors == {"d": "passed", "e": "passed"}
    assert verdict.evidence.resonance is None
    assert verdict.sentence == SYNCHRONISED
    assert judged(exciters(1.2, 2.0, 2.0), steady, lambda t: W * t + 3.0).rotors == {"d": "captured", "e": "captured"}


def test_exciters_in_opposition_rock_a_carrier_that_can_turn():
    """Beside the carrier's middle they are a couple: captured is what that holds, whatever the force alone would do."""
    bodies = [ROTOR | {"name": n, "mass": 2.0, "position": [x, 0.0]} for n, x in (("d", -0.5), ("e", 0.5))]
    rocking = {
        "directions": "xyr",
        "mass": 6.0,
        "inertia": 2.0,
        "rotation_stiffness": 3.0 * (1.3 * W) ** 2,
        "rotation_damping": 1.0,
    }
    drives = [linear(2 * W), linear(2 * W) | {"on": "e"}]
    both = machine(carrier(0.3 * W) | rocking, bodies, drives=drives)
    opposed, together = (judged(both, steady, lambda t, off=off: W * t + off) for off in (np.pi, 0.0))
    assert opposed.rotors == {"d": "captured", "e": "captured"}
    assert together.rotors == {"d": "passed", "e": "passed"}


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("resonance", "outcome"), [(1.2, "captured"), (0.7, "passed")])
def test_a_rotor_that_nothing_drives_goes_with_the_other(sense, resonance, outcome):
    """The vibration keeps it turning, one way or the other; a heavy one that turns back is no part of the mean."""
    verdict = judged(exciters(resonance, 2.0, 0.0, inertias=(0.1, 0.3)), steady, lambda t: sense * W * t)
    assert verdict.outcome == "synchronised"
    assert verdict.rotors["d"] == outcome


def test_rotors_that_are_not_locked_are_judged_each_for_itself():
    verdict = judged(exciters(1.2, 2.0, 1.5), steady, lambda t: 1.5 * W * t)
    assert verdict.outcome == "not-synchronised"
    assert verdict.rotors == {"d": "captured", "e": "passed"}
    assert verdict.sentence == "the rotors turn at different mean speeds; captured at the resonance: d"


def assessed(machine: Any, *angles: Any) -> Any:
    found = assess_locking(machine, seen(machine, END, *angles))
    assert found is not None
    return found


@pytest.mark.parametrize(("first", "second"), [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
def test_speeds_have_signs_and_phases_are_in_the_senses(first: float, second: float) -> None:
    found = assessed(pair(), lambda t: first * W * t, lambda t: second * (W * t + 0.75))
    assert found.speeds == pytest.approx({"d": first * W, "e": second * W})
    assert found.smooth_speeds == pytest.approx(found.speeds)
    assert found.phases == {"e": pytest.approx(0.75)} and found.creep == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_phase_to_the_vibration(sense: float) -> None:
    """As sigma phi - w t."""
    found = assessed(shaken(), lambda t: sense * (W * t + 0.5))
    assert found.phases == {"vibration": pytest.approx(0.5)} and found.speeds["d"] == pytest.approx(sense * W)
    assert found.evidence.is_locked is True
    time = np.array([0.0, 1.0, 2.0])
    assert rotor_phases(shaken(), time, {"d": sense * (W * time + 0.5)})["vibration"] == pytest.approx([0.5] * 3)
    assert rotor_phases(pair(), time, {"d": sense * W * time, "e": -W * time - 0.25})["e"] == pytest.approx([0.25] * 3)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("share", "turns"), [(1.0, 5), (0.0, 5), (0.9, 10), (0.96, 25), (0.99, 5), (1.25, 8), (-0.9, 10)])
def test_the_final_window_is_a_twentieth_of_the_turns_in_whole_beats(share: float, turns: int, way: float) -> None:
    """Of 101 turns; beats of 10, 25 and 4 turns; one of 100 turns is longer than the last half, and none is seen."""
    found = assessed(pair(), lambda t: way * W * t, lambda t: way * share * W * t)
    begin, end = found.final.time[0], found.final.time[-1]
    assert (end - begin) * W / (2 * np.pi) == pytest.approx(turns, abs=0.01)
    assert end == pytest.approx(END, abs=0.1) and found.window[0] == pytest.approx(END / 2, abs=1.0)
    assert found.final_speeds == pytest.approx({"d": way * W, "e": way * share * W}, rel=1e-6, abs=1e-9)


def test_numbers_at_the_end_are_those_of_the_final_window() -> None:
    """The second rotor loses its speed in the middle of the last half: the mean over that half is not its final speed."""
    late = 0.8 * END
    found = assessed(pair(), steady, lambda t: np.where(t < late, 0.5 * W * t, 0.5 * W * late))
    assert found.final_speeds["e"] == pytest.approx(0.0, abs=1e-6) and abs(found.speeds["e"]) > 0.1 * W
