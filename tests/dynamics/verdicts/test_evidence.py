"""The evidence of synthetic motions whose end is known, on both sides of every limit."""

import math

import numpy as np
import pytest
from motions import (
    END,
    W,
    about,
    approaching,
    before,
    beyond,
    growing,
    judged,
    modulated,
    stands,
    steady,
    tenth,
    truth,
    with_ball,
)

from wucht.numerics.observers.projection import Course

# --- the speed: settled or not ---


@pytest.mark.parametrize(("off", "settled"), [(0.0032, True), (0.0034, False), (-0.0032, True), (-0.0034, False)])
def test_an_approach_is_settled_if_one_and_a_half_times_what_is_left_of_it_is_half_a_percent(off, settled):
    assert stands(beyond(), approaching(1.0, off)).evidence.has_settled is settled


def test_an_approach_is_advised_to_go_on_until_it_is_within_a_quarter_of_a_percent():
    """In tenths of the record, of which the time is told in whole records."""
    found = stands(beyond(), approaching(1.0, 0.005))
    assert found.extra_run_factor == pytest.approx(6 * math.log(1.5 * 0.005 / 0.0025) / 10, rel=0.01)


@pytest.mark.parametrize(("change", "settled"), [(0.8e-10, True), (1.25e-10, False)])
def test_a_growth_of_the_speed_counts_from_a_ten_thousand_millionth_of_it_a_window_on(change, settled):
    found = stands(beyond(), lambda t: W * (t + 50 * growing(change)(t)))
    assert found.evidence.has_settled is settled
    assert found.projections[0].course is (Course.STATIONARY if settled else Course.DRIFTING)


@pytest.mark.parametrize(("longer", "settled"), [(1.9, True), (2.1, False)])
def test_a_rotor_that_turned_back_must_have_turned_for_half_of_the_run_since_then(longer, settled):
    assert stands(beyond(), steady, end=longer * (END - 1)).evidence.has_settled is settled


@pytest.mark.parametrize(("turns", "last"), [(201, 10), (101, 5), (41, 2), (13, 2)])
def test_the_last_window_is_a_twentieth_of_the_turns_but_not_less_than_two(turns, last):
    window = stands(beyond(), steady, until=float(turns)).window
    assert window.time[-1] - window.time[0] == pytest.approx(last, abs=1e-9)


def test_it_is_advised_to_go_on_too_until_a_speed_is_known_to_a_thousandth_that_may_come_to_the_resonance():
    """Settled at 50.05 % of the free speed, from above; the resonance is at 50.08 %."""
    found = stands(beyond(), approaching(0.5005, -0.002))
    assert found.evidence.has_settled
    assert truth(found.evidence.is_beyond_resonance) is None
    lowest = 0.002 * math.exp(-5 / 60)  # at the end of the last tenth, not in the mean
    assert found.extra_run_factor == pytest.approx(6 * math.log(1.5 * lowest / 0.001) / 10, rel=0.05)


def test_it_is_advised_to_go_on_too_until_it_is_known_not_to_be_modulated():
    """The range of its speed in the last tenth may fall to nothing: until it is 0.1 %."""
    found = stands(beyond(), approaching(1.0, -0.0065, time=20.0))
    assert truth(found.evidence.is_modulated) is None
    assert found.extra_run_factor == pytest.approx(2 * math.log(0.0044 / 0.001) / 10, rel=0.02)


def wandering(height, rise):
    """A speed that goes to and fro from tenth to tenth, and rises, so that it is less in two of ten pairs of these."""
    return lambda t: W * (t + 10 * (rise / 2 * tenth(t) ** 2 - height * np.cos(np.pi * tenth(t))))


@pytest.mark.parametrize(("rise", "settled"), [(0.0, True), (1.0, False), (-1.0, False)])
def test_a_speed_that_goes_to_and_fro_by_more_than_half_a_percent_is_settled_if_it_has_no_trend(rise, settled):
    found = stands(beyond(), wandering(0.001 * (1 if rise else 4), 0.003 * rise))
    assert found.projections[0].course is Course.STATIONARY
    assert found.projections[0].width > 0.01 * W
    assert found.evidence.has_settled is settled


# --- a modulation of the speed ---

# A modulation of 20 turns a cycle is seen as it is; of two turns a cycle averages over a turn see 64 % of it.
SLOW, FAST = (20.0, 1.0), (2.0, 2 / math.pi)


@pytest.mark.parametrize(("period", "part"), [SLOW, FAST])
@pytest.mark.parametrize(("drift", "settled"), [(0.8e-3, True), (1.25e-3, False)])
def test_a_mean_speed_that_drifts_by_less_than_a_thousandth_of_the_modulation_is_at_rest(drift, settled, period, part):
    """From tenth to tenth."""
    until, slower = (501.0, 5) if period == 2.0 else (201.0, 2)
    motion = modulated(0.2, period)
    found = stands(before(), lambda t: motion(t) + W * 0.2 * part * drift * t**2 / (20 * slower), until=until, free=2 * W)
    assert found.evidence.has_settled is settled


@pytest.mark.parametrize(("tenths", "whole"), [(18.5, True), (21.5, False)])
def test_means_are_taken_over_whole_cycles_up_to_twenty_a_tenth(tenths, whole):
    found = stands(before(), modulated(0.4, 3.0), until=30 * tenths, free=2 * W)
    assert (found.projections[0].width < 1e-6 * W) is whole


def test_the_speed_of_a_modulated_motion_is_that_of_its_last_whole_cycles():
    """Three cycles of seven turns; the last twentieth of 105 turns is not even one, and its mean speed is another."""
    rotor = stands(before(), modulated(0.4, 7.0), until=105.0, free=2 * W)
    assert truth(rotor.evidence.is_modulated) is True
    assert rotor.window is rotor.modulation.window
    assert rotor.window.time[-1] - rotor.window.time[0] == pytest.approx(21.0, abs=0.2)
    assert rotor.speed == pytest.approx(W, rel=0.003)


def irregular(period):
    """Cycles of different lengths and heights."""
    turned = 2 * np.pi / period
    return lambda t: W * (t - 0.2 / (2 * turned) * np.cos(turned * t + 0.7 * np.sin(0.43 * turned * t)))


@pytest.mark.parametrize(("tenths", "whole"), [(1.8, True), (2.2, False)])
def test_means_are_taken_over_irregular_cycles_up_to_two_a_tenth(tenths, whole):
    found = stands(before(), irregular(5.0), until=50 * tenths, free=2 * W)
    assert (abs(found.projections[0].last - W) < 1e-3 * W) is whole


@pytest.mark.parametrize(("cycles", "lasts"), [(29, False), (34, True)])
def test_thirty_irregular_cycles_are_seen_to_last(cycles, lasts):
    """In the last half of the record."""
    found = stands(before(), irregular(3.0), until=6.0 * cycles, free=2 * W)
    assert truth(found.evidence.is_modulated) is (True if lasts else None)
    assert found.evidence.has_settled is lasts
    assert found.extra_run_factor == (0.0 if lasts else math.inf)  # they may become regular before


def changing(change, kind):
    """The range of a modulation over time, whose bounds will be a share of it apart: half as far again as it has to go."""
    return lambda t: 0.2 * (1 + (change if kind == "falling" else -change) / 1.5 * np.exp(-(t - 190) / 40))


@pytest.mark.parametrize(
    ("kind", "change", "lasts"),
    [("rising", 0.13, True), ("rising", 0.17, False), ("falling", 0.017, True), ("falling", 0.023, False)],
)
def test_a_modulation_lasts_that_will_rise_by_fifteen_percent_or_fall_by_two(kind, change, lasts):
    found = stands(before(), modulated(changing(change, kind), 5.0), until=201.0, free=2 * W)
    assert truth(found.evidence.is_modulated) is (True if lasts else None)
    assert found.evidence.has_settled is lasts


@pytest.mark.parametrize(("fall", "lasts"), [(0.0, True), (0.01, None)])
def test_a_modulation_that_falls_to_and_fro_may_die_out(fall, lasts):
    """From group to group of its cycles, four of them each, by a hundredth in all."""

    def share(t):
        return 0.2 * (1 - fall / 80 * (t - 207) + 0.004 * np.cos(np.pi * (t - 195) / 20))

    assert truth(stands(before(), modulated(share, 5.0), until=207.0, free=2 * W).evidence.is_modulated) is lasts


@pytest.mark.parametrize(
    ("until", "uneven", "lasts"), [(95.0, 0.0, True), (95.0, 0.02, False), (97.0, 0.02, False), (107.0, 0.02, True)]
)
def test_a_modulation_whose_ranges_differ_may_die_out_unseen_in_less_than_ten_cycles(until, uneven, lasts):
    """Eight, nine and ten of them in the last half of the record, each as long as the others; ranges go to and fro."""

    def share(t):
        return 0.2 * (1 + uneven * np.cos(np.pi * (t - until) / 10))

    found = stands(before(), modulated(share, 5.0), until=until, free=2 * W)
    assert truth(found.evidence.is_modulated) is (True if lasts else None)
    if until == 95.0:
        assert found.extra_run_factor == (0.0 if lasts else pytest.approx(2 * 10 * 5.0 / until - 1, rel=0.01))


@pytest.mark.parametrize(("part", "known"), [(0.9, True), (1.1, False)])
def test_what_comes_of_a_modulation_that_drifts_to_twice_of_what_it_is_is_not_known(part, known):
    """As far as it is looked ahead, fifteen records of ten groups of its cycles."""
    found = stands(before(), modulated(lambda t: 0.05 * (1 + part / 150 * (t - 201) / 20), 5.0), until=201.0, free=2 * W)
    assert found.growing is not known
    assert found.evidence.has_settled is known


@pytest.mark.parametrize(("rate", "known"), [(0.0, True), (0.25, False)])
def test_what_comes_of_a_modulation_that_grows_is_not_known(rate, known):
    found = stands(before(), modulated(lambda t: 0.05 * np.exp(rate * (t - 201) / 20), 5.0), until=201.0, free=2 * W)
    assert found.growing is not known
    assert found.evidence.has_settled is known
    # It may grow until it is as large as the speed.
    assert found.extra_run_factor == (0.0 if known else pytest.approx(math.log(1 / 0.047) / rate / 10, rel=0.05))


@pytest.mark.parametrize(("ranges", "settled"), [(1.8, False), (2.2, True)])
def test_a_modulation_that_may_die_out_does_not_matter_two_ranges_beyond_the_resonance(ranges, settled):
    """Its lowest speed lies so far beyond it."""
    height = 0.5 / (ranges + 0.5) / 0.935  # averages over a turn see less
    fading = modulated(lambda t: height * np.exp(-(t - 195) / 400), 5.0)
    found = stands(beyond(), fading, until=201.0)
    assert truth(found.evidence.is_modulated) is None
    assert found.evidence.has_settled is settled


# --- the unbalance that is left: about twice the sine of half the angle by which a ball is off the place opposite ---


def off(angle):
    return about(math.pi, angle)


@pytest.mark.parametrize(("part", "leaving"), [(0.9, False), (1.1, True)])
def test_bodies_leave_if_the_residual_unbalance_drifts_to_twice_of_what_it_is(part, leaving):
    """As far as it is looked ahead, 150 tenths."""
    found = stands(with_ball(), steady, off(lambda t: 0.1 * (1 + part / 150 * tenth(t))))
    assert found.growing is leaving
    assert found.evidence.has_settled is not leaving


@pytest.mark.parametrize(("change", "leaving"), [(0.8e-7, False), (1.25e-7, True)])
def test_a_growth_of_the_residual_unbalance_counts_from_a_ten_millionth_a_window_on(change, leaving):
    found = stands(with_ball(), steady, off(growing(change)))
    assert found.growing is leaving
    assert found.evidence.has_settled is not leaving


@pytest.mark.parametrize(("part", "balanced"), [(0.9, True), (1.1, None)])
def test_a_residual_unbalance_that_has_begun_to_rise_may_go_on_to_do_so(part, balanced):
    """As far as it is looked ahead, 150 tenths: from 0.4 % to 1 %. It fell until three windows before the last."""
    rise = part * 0.006 / 150
    found = stands(with_ball(), steady, off(lambda t: 0.004 + rise * np.maximum(tenth(t), -3 - 0.5 * (tenth(t) + 3))))
    assert truth(found.evidence.is_balanced) is balanced
    assert found.growing is (balanced is None)


@pytest.mark.parametrize(("fall", "outcome"), [(0.85e-3, "passed"), (1.2e-3, "unidentified")])
def test_a_residual_unbalance_falls_to_and_fro_if_it_is_less_by_a_thousandth_than_four_windows_before(fall, outcome):
    """It is just above a hundredth; in four fifths of all pairs of windows the later one is less."""
    falling = off(lambda t: 0.0103 * (1 - fall / 4 * tenth(t) + 2.2 * fall / 4 * np.sin(np.pi * tenth(t))))
    found = judged(with_ball(), steady, falling)
    assert found.assessment.projections[1].course is (Course.STATIONARY if outcome == "passed" else Course.APPROACHING)
    assert found.outcome == outcome


def test_it_is_advised_to_go_on_until_the_residual_unbalance_is_half_a_hundredth():
    found = stands(with_ball(), steady, off(lambda t: 0.03 * np.exp((END - 10 - t) / 40)))
    assert truth(found.evidence.is_balanced) is None
    assert found.extra_run_factor == pytest.approx(4 * math.log(0.03 / 0.005) / 10, rel=0.02)


def falling_from(start, width):
    """A residual unbalance that is above 1.1 % by a share, falling exponentially, and goes to and fro down from there."""

    def angle(t):
        return 0.011 * (1 + start * np.exp((50 - t) / 20)) * (1 - width / 2 + width / 2 * np.cos(2 * np.pi * t / 5))

    return off(angle)


@pytest.mark.parametrize(("width", "outcome"), [(0.06, "passed"), (0.11, "unidentified")])
def test_a_residual_unbalance_may_fall_to_nothing_as_long_as_bodies_change_it_by_a_tenth(width, outcome):
    """Whatever it seems to approach."""
    found = judged(with_ball(decay=1.0), steady, falling_from(0.03, width))
    assert found.assessment.unrest == pytest.approx(width + 0.02, abs=0.01)
    assert found.outcome == outcome


# --- the machines of these tests ---
