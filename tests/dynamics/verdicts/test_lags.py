"""Bodies that lag, or go to and fro, by formulas: on both sides of every limit."""

import math

import numpy as np
import pytest
from motions import END, W, about, growing, rigid, stands, steady, tenth, truth

from wucht import RunUp, run
from wucht.files.catalogue import load_machine


def lagging(share, change=0.0):
    """A body that lags by a share of the speed, a mean over time; in one tenth by half a change more, in the next by less."""
    return lambda t: W * ((1 - share) * t - 10 * change / 4 * np.cos(np.pi * tenth(t)))


@pytest.mark.parametrize(("lag", "lags"), [(0.0008, False), (0.0012, True), (-0.0012, True)])
def test_a_body_lags_by_a_thousandth_of_the_speed(lag, lags):
    """For 12 000 turns: it slips by more than two turns in the last fifth."""
    found = stands(rigid(), steady, lagging(lag), until=12_001.0)
    assert truth(found.evidence.asynchronous) is lags
    assert found.evidence.has_settled


@pytest.mark.parametrize(("way", "lags"), [(+1, None), (-1, False)])
def test_a_body_that_catches_up_does_not_overtake(way, lags):
    """It lags by half a thousandth: as far as it is looked ahead by two thousandths, or by a thousandth less than nothing."""

    def late(t):
        return W * (t - 0.0005 * t - way * 0.0015 / 150 * (t - 12_001.0) ** 2 / 2400)

    assert truth(stands(rigid(), steady, late, until=12_001.0).evidence.asynchronous) is lags


@pytest.mark.parametrize(("slips", "lags"), [(0.92, None), (1.08, True)])
def test_a_body_that_has_not_slipped_by_a_turn_in_the_last_fifth_may_keep_its_place(slips, lags):
    found = stands(rigid(), steady, lagging(slips / 20))
    assert truth(found.evidence.asynchronous) is lags
    assert found.evidence.has_settled is (lags is True)
    assert found.extra_run_factor == (0.0 if lags else math.inf)


@pytest.mark.parametrize(("part", "lags"), [(0.9, True), (1.1, None)])
def test_a_lag_may_go_beyond_what_was_seen_by_twice_its_range(part, lags):
    """Half its range about 12, and twice that: 0 is just not reached, or just reached. It slips by twelve hundred turns."""
    assert truth(stands(rigid(), steady, lagging(12.0, part * 12.0 / 2.5)).evidence.asynchronous) is lags


@pytest.mark.parametrize(("slips", "lags"), [(960, None), (1040, True)])
def test_a_body_that_tumbles_irregularly_lags_if_it_has_slipped_by_a_thousand_turns(slips, lags):
    """Transients that tumble may last long before a body is caught."""
    found = stands(rigid(), steady, lagging(slips / END, 0.3 * slips / END))
    assert truth(found.evidence.asynchronous) is lags
    assert found.extra_run_factor == (0.0 if lags else math.inf)  # it may be caught before


@pytest.mark.parametrize(("change", "lags"), [(0.085, True), (0.12, None)])
def test_it_tumbles_irregularly_if_its_lag_varies_by_a_tenth(change, lags):
    assert truth(stands(rigid(), steady, lagging(1.0, change)).evidence.asynchronous) is lags


@pytest.mark.parametrize(("fall", "lags"), [(0.060, True), (0.066, None)])
def test_a_lag_that_may_fall_to_a_thousandth_as_far_as_it_is_looked_ahead_is_not_known(fall, lags):
    """It approaches 12. ln(12000)/150 = 0.0626 a tenth; ``early`` and ``late`` are means of exp(-u/2) over tenths."""
    early, late = (2 * np.exp(k / 2) * (1 - np.exp(-0.5)) for k in (5, 1))
    height = np.expm1(4 * fall) / (early - np.exp(4 * fall) * late)
    found = stands(rigid(), steady, lambda t: W * (-11 * t + 20 * 12 * height * np.exp(-tenth(t) / 2)))
    assert truth(found.evidence.asynchronous) is lags


@pytest.mark.parametrize(
    ("size", "growth", "grows"), [(0.4, 1.02, False), (0.4, 1.08, True), (0.05, 1.5, False), (0.08, 1.5, True)]
)
def test_a_swing_that_grows_is_no_end(size, growth, grows):
    """By a twentieth from quarter to quarter of the run; averaged over turns it must be larger than a tenth of a radian."""
    swing = stands(
        rigid(), steady, about(1.0, lambda t: size * growth ** ((t - END) / (END / 4)) * np.sin(2 * np.pi * t / 2.5))
    )
    assert swing.growing is grows
    assert swing.evidence.has_settled is not grows


@pytest.mark.parametrize(("part", "lags"), [(0.22, True), (0.28, None)])
def test_a_drift_that_takes_away_a_quarter_of_the_lag_is_a_body_that_catches_up(part, lags):
    """As far as it is looked ahead, 150 tenths."""
    found = stands(rigid(), steady, lambda t: W * (0.8 * t + 0.2 * part / 150 * 5 * tenth(t) ** 2))
    assert truth(found.evidence.asynchronous) is lags
    assert found.evidence.has_settled is (lags is True)


@pytest.mark.parametrize(("change", "lags"), [(0.8e-10, True), (1.25e-10, None)])
def test_a_growth_of_the_lag_counts_from_a_ten_thousand_millionth_of_the_speed_a_window_on(change, lags):
    """A body that lags by a fifth catches up ever faster."""
    found = stands(rigid(), steady, lambda t: W * (0.8 * t + 50 * growing(change)(t)))
    assert truth(found.evidence.asynchronous) is lags


def test_a_body_that_catches_up_exponentially_is_not_left_behind():
    found = stands(rigid(), steady, lambda t: W * (t + 0.05 * 40 * np.exp((END - t) / 40)))
    assert truth(found.evidence.asynchronous) is None
    assert not found.evidence.has_settled


def librating(width, later=1.0):
    """About its place by that width in all in the last half of the run, later so many times as far a quarter of it."""
    rate, widest = math.log(later) / 25, 6.25 if later > 1 else 43.75  # s before the end, between the two widest swings
    return about(0.0, lambda t: width / 2 * np.exp(rate * (t - END + widest)) * np.sin(2 * np.pi * (t - END) / 12.5))


@pytest.mark.parametrize(("width", "stays"), [(0.45, True), (0.55, False)])
def test_a_body_that_swings_by_less_than_a_quarter_turn_keeps_its_place(width, stays):
    """In half turns; its swing falls by a fifth from quarter to quarter."""
    found = stands(rigid(), steady, librating(width * math.pi, later=0.8))
    assert truth(found.evidence.asynchronous) is (False if stays else None)
    assert found.evidence.has_settled is stays


@pytest.mark.parametrize(("later", "stays"), [(1.08, True), (1.12, False), (1 / 1.08, True), (1 / 1.12, False), (1.0, True)])
def test_one_that_swings_further_keeps_it_if_its_swings_differ_by_less_than_a_tenth(later, stays):
    found = stands(rigid(), steady, librating(3.0, later))
    assert truth(found.evidence.asynchronous) is (False if stays else None)


@pytest.mark.parametrize(("width", "stays"), [(1.45, True), (1.55, False)])
def test_one_that_swings_by_three_quarters_of_a_turn_may_tumble(width, stays):
    """In half turns."""
    assert truth(stands(rigid(), steady, librating(width * math.pi)).evidence.asynchronous) is (False if stays else None)


@pytest.mark.parametrize(("change", "stays"), [(0.8e-3, True), (1.25e-3, False)])
def test_a_body_is_leaving_if_its_phase_moves_ever_faster_by_a_milliradian_from_window_to_window(change, stays):
    found = stands(rigid(), steady, about(1.0, growing(change)))
    assert truth(found.evidence.asynchronous) is (False if stays else None)
    assert found.evidence.has_settled is stays


@pytest.mark.parametrize(("part", "stays"), [(0.9, True), (1.1, False)])
def test_a_body_is_leaving_if_its_phase_will_have_moved_by_a_turn(part, stays):
    """As far as it is looked ahead, 150 windows, in each of which it moves by two percent more."""
    times = math.exp(0.02) * math.expm1(150 * 0.02) / math.expm1(0.02)
    found = stands(rigid(), steady, about(1.0, growing(part * 2 * math.pi / times, 0.02)))
    assert truth(found.evidence.asynchronous) is (False if stays else None)


NEAR_ITS_LOSS = {"psi": 3.451, "delta": 0.087}


@pytest.mark.slow
@pytest.mark.parametrize(("u", "outcome"), [(3.0859, "compensated"), (3.05, "captured-modulated")])
def test_a_modulation_in_which_the_pendulums_part_slowly_is_not_the_end(u: float, outcome: str) -> None:
    """Beyond u = 3.08 it is not stable: here the pendulums have parted, and compensate, after 14,800 units of time."""
    machine = load_machine("drozdetskaya-2020/table-5.1").with_values({"u": u})
    result = run(RunUp(settled=True, start=NEAR_ITS_LOSS, model="slow"), machine)
    assert result.wucht.summary["outcome"] == outcome
    early = run(RunUp(until=5000.0, start=NEAR_ITS_LOSS, model="slow"), machine).wucht.summary
    assert early["outcome"] == ("unidentified" if outcome == "compensated" else outcome)
    assert outcome != "compensated" or 14_800 < float(early["advice"].split("until ")[1]) < 100_000
