"""The criteria of the contract, at their edges: just inside, just outside."""

import math
from dataclasses import replace

import pytest

from wucht.results.outcomes import FEWEST_PERIODS, Evidence, Locking, Outcome, classify

FREE, RESONANCE = 200.0, 101.0
AT_SPEED = Evidence(
    turning=True, mean_speed=FREE, lowest_speed=FREE, free_speed=FREE, resonance=RESONANCE, residual=0.0, steady=True
)
CAPTURED = replace(AT_SPEED, mean_speed=90.0, lowest_speed=90.0, residual=3.6)
MODULATED = replace(CAPTURED, mean_speed=100.0, lowest_speed=88.0, steady=False, modulated=True)


def just_above(x):
    return math.nextafter(x, math.inf)


def just_below(x):
    return math.nextafter(x, -math.inf)


def case(base, **changes):
    return classify(replace(base, **changes))


def test_every_outcome_has_a_sentence():
    assert all(o.sentence and o.sentence[0].islower() for o in Outcome)
    assert str(Outcome.CAPTURED_MODULATED) == "captured-modulated"


# --- compensated: speed within 0.5 % of what the drive reaches without vibration, less than 1 % of the unbalance left ---


@pytest.mark.parametrize("speed", [199.0, 199.5, 200.0, 201.0])
def test_within_half_a_percent_of_the_free_speed_is_compensated(speed):
    assert case(AT_SPEED, mean_speed=speed, lowest_speed=speed) is Outcome.COMPENSATED


@pytest.mark.parametrize("speed", [just_below(199.0), just_above(201.0), 198.0, 202.0])
def test_half_a_percent_off_the_free_speed_is_only_passed(speed):
    assert case(AT_SPEED, mean_speed=speed, lowest_speed=speed) is Outcome.PASSED


def test_the_lowest_speed_must_be_within_half_a_percent_too():
    assert case(AT_SPEED, lowest_speed=199.0) is Outcome.COMPENSATED
    assert case(AT_SPEED, lowest_speed=just_below(199.0)) is Outcome.PASSED


def test_less_than_one_percent_of_the_unbalance_may_be_left():
    assert case(AT_SPEED, residual=just_below(0.01)) is Outcome.COMPENSATED
    assert case(AT_SPEED, residual=0.01) is Outcome.PASSED


def test_without_unbalance_nothing_is_compensated():
    assert case(AT_SPEED, residual=None) is Outcome.PASSED


def test_compensated_needs_bodies_that_do_not_lag():
    assert case(AT_SPEED, lag=0.2) is Outcome.COMPENSATED  # 0.1 % of 200 rad/s
    assert case(AT_SPEED, lag=just_above(0.2)) is Outcome.BALANCER_CAPTURED


def test_compensated_holds_before_the_last_decimals_have_settled():
    assert case(AT_SPEED, steady=False) is Outcome.COMPENSATED


# --- captured and passed: a steady speed at or before, or beyond, the last maximum of the vibration torque ---


def test_at_the_resonance_exactly_is_captured_just_beyond_is_passed():
    assert case(CAPTURED, mean_speed=RESONANCE, lowest_speed=RESONANCE) is Outcome.CAPTURED
    beyond = just_above(RESONANCE)
    assert case(CAPTURED, mean_speed=beyond, lowest_speed=beyond) is Outcome.PASSED
    assert case(CAPTURED, mean_speed=30.0, lowest_speed=30.0) is Outcome.CAPTURED


def test_without_a_resonance_below_the_free_speed_there_is_nothing_to_be_captured_at():
    assert case(CAPTURED, resonance=None) is Outcome.PASSED


def test_the_free_speed_need_not_be_known():
    assert case(CAPTURED, free_speed=None) is Outcome.CAPTURED
    assert case(AT_SPEED, free_speed=None) is Outcome.PASSED


# --- captured-modulated: held there, modulated ---


def test_modulation_around_the_resonance_is_captured_modulated():
    assert case(MODULATED) is Outcome.CAPTURED_MODULATED


def test_a_modulation_that_only_touches_the_resonance_is_still_held():
    assert case(MODULATED, mean_speed=120.0, lowest_speed=RESONANCE) is Outcome.CAPTURED_MODULATED
    assert case(MODULATED, mean_speed=120.0, lowest_speed=just_above(RESONANCE)) is Outcome.PASSED


def test_steady_and_modulated_is_modulated():
    """A modulation of small range passes the test of steadiness as well."""
    assert case(MODULATED, steady=True) is Outcome.CAPTURED_MODULATED


# --- balancer-captured: the rotor at its speed, bodies lagging behind ---


def test_bodies_that_lag_behind_a_rotor_at_speed():
    assert case(AT_SPEED, residual=1.0, lag=100.0) is Outcome.BALANCER_CAPTURED


def test_lagging_at_or_before_the_resonance_is_captured():
    assert case(CAPTURED, lag=10.0) is Outcome.CAPTURED
    assert case(MODULATED, lag=10.0) is Outcome.CAPTURED_MODULATED


def test_lagging_beyond_the_resonance_but_off_the_free_speed():
    assert case(AT_SPEED, mean_speed=180.0, lowest_speed=180.0, residual=1.0, lag=80.0) is Outcome.BALANCER_CAPTURED


def test_lag_of_a_thousandth_of_the_speed_is_none():
    limit = 0.001 * 180.0
    at_180 = replace(AT_SPEED, mean_speed=180.0, lowest_speed=180.0, residual=1.0)
    assert case(at_180, lag=limit) is Outcome.PASSED
    assert case(at_180, lag=just_above(limit)) is Outcome.BALANCER_CAPTURED


# --- the others ---


@pytest.mark.parametrize("base", [AT_SPEED, CAPTURED, MODULATED, Evidence(turning=False, at_rest=True)])
def test_beyond_the_limit_is_a_runaway_whatever_else(base):
    assert case(base, beyond_limit=True) is Outcome.RUNAWAY


def test_at_rest_is_stopped():
    assert classify(Evidence(turning=False, at_rest=True)) is Outcome.STOPPED


def test_an_oscillation_that_is_left_is_oscillating():
    assert classify(Evidence(turning=False, moving=True, steady=True)) is Outcome.OSCILLATING
    assert classify(Evidence(turning=False, moving=True, modulated=True)) is Outcome.OSCILLATING


def test_an_oscillation_still_changing_is_unidentified():
    assert classify(Evidence(turning=False, moving=True)) is Outcome.UNIDENTIFIED


def test_too_short_a_run_is_unidentified():
    assert classify(Evidence(turning=False)) is Outcome.UNIDENTIFIED
    assert case(CAPTURED, steady=False) is Outcome.UNIDENTIFIED
    assert case(AT_SPEED, residual=1.0, steady=False) is Outcome.UNIDENTIFIED
    assert case(AT_SPEED, residual=1.0, lag=100.0, steady=False) is Outcome.UNIDENTIFIED


# --- entrained, synchronised: by the mean speed over whole periods ---

LOCKED = Locking(speeds=(100.0, 100.0), frequency=None, periods=50, creep=0.0)


@pytest.mark.parametrize(
    ("other", "outcome"),
    [
        (100.09, Outcome.SYNCHRONISED),
        (99.91, Outcome.SYNCHRONISED),
        (100.11, Outcome.NOT_SYNCHRONISED),
        (99.89, Outcome.NOT_SYNCHRONISED),
    ],
)
def test_rotors_within_a_tenth_of_a_percent_are_synchronised(other, outcome):
    assert replace(LOCKED, speeds=(100.0, other)).outcome() is outcome


@pytest.mark.parametrize(("speed", "outcome"), [(99.91, Outcome.ENTRAINED), (99.89, Outcome.NOT_ENTRAINED)])
def test_a_rotor_within_a_tenth_of_a_percent_of_the_vibration_is_entrained(speed, outcome):
    assert replace(LOCKED, speeds=(speed,), frequency=100.0).outcome() is outcome


def test_a_second_rotor_does_not_count_where_a_vibration_entrains_the_first():
    assert replace(LOCKED, speeds=(100.0, 50.0), frequency=100.0).outcome() is Outcome.ENTRAINED


def test_a_phase_that_still_moves_by_a_tenth_of_a_turn_is_not_locked():
    assert replace(LOCKED, creep=just_below(0.2 * math.pi)).outcome() is Outcome.SYNCHRONISED
    assert replace(LOCKED, creep=0.2 * math.pi).outcome() is Outcome.NOT_SYNCHRONISED


def test_too_few_periods_are_unidentified():
    assert replace(LOCKED, periods=FEWEST_PERIODS).outcome() is Outcome.SYNCHRONISED
    assert replace(LOCKED, periods=FEWEST_PERIODS - 1).outcome() is Outcome.UNIDENTIFIED


def test_every_rotor_must_keep_the_speed_of_the_first():
    assert replace(LOCKED, speeds=(100.0, 100.0, 90.0)).outcome() is Outcome.NOT_SYNCHRONISED
