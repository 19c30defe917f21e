"""The criteria of the contract, at their edges: just inside, just outside, and with bounds that lie on both sides.

The numbers of the contract stand here once more: 0.5 % of the free speed, 1 % of the unbalance, 0.1 % lag, 0.2 % modulation,
a ten-thousandth of the largest speed; 0.1 % of the mean speed, a tenth of a turn, five periods.
"""

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import truth

from wucht.dynamics.verdicts.outcomes import Evidence, Locking, Outcome, classify

always = settings(max_examples=500, deadline=None)

FREE, RESONANCE = 200.0, 101.0


def just_above(x):
    return math.nextafter(x, math.inf)


def just_below(x):
    return math.nextafter(x, -math.inf)


def at(x):
    """Bounds of what is known exactly."""
    return x, x


def speed(low, high=None):
    """A steady speed: the mean is the lowest."""
    bounds = low, low if high is None else high
    return {"mean_speed": bounds, "lowest_speed": bounds}


AT_SPEED = Evidence(turning=True, **speed(FREE), free_speed=FREE, resonance=RESONANCE, residual=at(0.0), lags=(at(0.0),))
LEFT = replace(AT_SPEED, residual=at(1.0))
LAGGING = replace(LEFT, lags=(at(0.5),))
CAPTURED = replace(AT_SPEED, **speed(90.0), residual=at(3.6))
MODULATED = replace(CAPTURED, mean_speed=at(100.0), lowest_speed=at(88.0), modulation=at(0.2))
NEAR_RESONANCE = replace(CAPTURED, mean_speed=at(120.0), lowest_speed=at(110.0))
ENDED = Evidence(turning=False, swing=at(0.0))


def case(base, **changes):
    return classify(replace(base, **changes))


def test_every_outcome_has_a_sentence():
    assert all(o.sentence and o.sentence[0].islower() for o in Outcome)
    assert str(Outcome.CAPTURED_MODULATED) == "captured-modulated"


# --- compensated: speed within 0.5 % of what the drive reaches without vibration, less than 1 % of the unbalance left ---


@pytest.mark.parametrize("value", [199.0, 199.5, 200.0, 201.0])
def test_within_half_a_percent_of_the_free_speed_is_compensated(value):
    assert case(AT_SPEED, **speed(value)) is Outcome.COMPENSATED


@pytest.mark.parametrize("value", [just_below(199.0), just_above(201.0), 198.0, 202.0])
def test_half_a_percent_off_the_free_speed_is_only_passed(value):
    assert case(AT_SPEED, **speed(value)) is Outcome.PASSED


def test_the_lowest_speed_must_be_within_half_a_percent_too():
    assert case(AT_SPEED, lowest_speed=at(199.0)) is Outcome.COMPENSATED
    assert case(AT_SPEED, lowest_speed=at(just_below(199.0))) is Outcome.PASSED
    assert case(AT_SPEED, lowest_speed=at(201.0)) is Outcome.COMPENSATED
    assert case(AT_SPEED, lowest_speed=at(just_above(201.0))) is Outcome.PASSED


def test_the_mean_speed_must_be_within_half_a_percent_whatever_the_lowest():
    assert case(AT_SPEED, mean_speed=at(199.0)) is Outcome.COMPENSATED
    assert case(AT_SPEED, mean_speed=at(just_below(199.0))) is Outcome.PASSED
    assert case(AT_SPEED, mean_speed=at(201.0)) is Outcome.COMPENSATED
    assert case(AT_SPEED, mean_speed=at(just_above(201.0))) is Outcome.PASSED


def test_a_rotor_that_turns_against_its_drive_does_not_hold_its_speed():
    assert case(AT_SPEED, free_speed=-FREE) is Outcome.PASSED
    assert truth(replace(AT_SPEED, **speed(-199.0), free_speed=-FREE).is_at_speed) is True
    assert truth(replace(AT_SPEED, **speed(just_above(-199.0)), free_speed=-FREE).is_at_speed) is False


def test_less_than_one_percent_of_the_unbalance_may_be_left():
    assert case(AT_SPEED, residual=at(just_below(0.01))) is Outcome.COMPENSATED
    assert case(AT_SPEED, residual=at(0.01)) is Outcome.PASSED


def test_without_unbalance_nothing_is_compensated():
    assert case(AT_SPEED, residual=None) is Outcome.PASSED


@pytest.mark.parametrize("sign", [1, -1])
def test_compensated_needs_bodies_that_do_not_lag(sign):
    assert case(AT_SPEED, lags=(at(sign * 0.001),)) is Outcome.COMPENSATED
    assert case(AT_SPEED, lags=(at(sign * just_above(0.001)),)) is Outcome.BALANCER_CAPTURED


def test_compensated_needs_no_body():
    assert case(AT_SPEED, lags=()) is Outcome.COMPENSATED


def test_compensated_holds_before_the_last_decimals_have_settled():
    assert (
        case(AT_SPEED, **speed(199.0, 201.0), residual=(0.0, just_below(0.01)), lags=((-0.001, 0.001),)) is Outcome.COMPENSATED
    )


# --- captured and passed: a steady speed at or before, or beyond, the last maximum of the vibration torque ---


def test_at_the_resonance_exactly_is_captured_just_beyond_is_passed():
    assert case(CAPTURED, **speed(RESONANCE)) is Outcome.CAPTURED
    assert case(CAPTURED, **speed(just_above(RESONANCE))) is Outcome.PASSED
    assert case(CAPTURED, **speed(30.0)) is Outcome.CAPTURED


def test_compensated_comes_before_captured():
    assert case(AT_SPEED, resonance=FREE) is Outcome.COMPENSATED
    assert case(LEFT, resonance=FREE) is Outcome.CAPTURED


def test_without_a_resonance_below_the_free_speed_there_is_nothing_to_be_captured_at():
    assert case(CAPTURED, resonance=None) is Outcome.PASSED


def test_the_free_speed_need_not_be_known():
    assert case(CAPTURED, free_speed=None) is Outcome.CAPTURED
    assert case(AT_SPEED, free_speed=None) is Outcome.PASSED


# --- captured-modulated: held there, modulated ---


def test_modulation_around_the_resonance_is_captured_modulated():
    assert case(MODULATED) is Outcome.CAPTURED_MODULATED


def test_a_modulation_that_only_touches_the_resonance_is_still_held():
    assert case(MODULATED, mean_speed=at(120.0), lowest_speed=at(RESONANCE)) is Outcome.CAPTURED_MODULATED
    assert case(MODULATED, mean_speed=at(120.0), lowest_speed=at(just_above(RESONANCE))) is Outcome.PASSED


def test_a_range_of_two_thousandths_of_the_speed_is_no_modulation():
    assert case(CAPTURED, modulation=at(0.002)) is Outcome.CAPTURED
    assert case(CAPTURED, modulation=at(just_above(0.002))) is Outcome.CAPTURED_MODULATED


# --- balancer-captured: the rotor at its speed, bodies lagging behind ---


def test_bodies_that_lag_behind_a_rotor_at_speed():
    assert case(LAGGING) is Outcome.BALANCER_CAPTURED


def test_one_body_that_lags_is_enough():
    assert case(AT_SPEED, lags=(at(0.0), at(0.5))) is Outcome.BALANCER_CAPTURED
    assert case(AT_SPEED, lags=(at(-0.5), at(0.0))) is Outcome.BALANCER_CAPTURED


def test_lagging_at_or_before_the_resonance_is_captured():
    assert case(CAPTURED, lags=(at(0.1),)) is Outcome.CAPTURED
    assert case(MODULATED, lags=(at(0.1),)) is Outcome.CAPTURED_MODULATED


def test_lagging_at_the_free_speed_need_not_be_beyond_the_resonance():
    assert case(LAGGING, **speed(199.0), resonance=FREE) is Outcome.BALANCER_CAPTURED
    assert case(LAGGING, **speed(just_below(199.0)), resonance=FREE) is Outcome.CAPTURED


def test_lagging_beyond_the_resonance_but_off_the_free_speed():
    assert case(LAGGING, **speed(180.0)) is Outcome.BALANCER_CAPTURED


@pytest.mark.parametrize("sign", [1, -1])
def test_lag_of_a_thousandth_of_the_speed_is_none(sign):
    at_180 = replace(LEFT, **speed(180.0))
    assert case(at_180, lags=(at(sign * 0.001),)) is Outcome.PASSED
    assert case(at_180, lags=(at(sign * just_above(0.001)),)) is Outcome.BALANCER_CAPTURED


# --- the others ---


@pytest.mark.parametrize("base", [AT_SPEED, CAPTURED, MODULATED, LAGGING, ENDED, replace(CAPTURED, has_settled=False)])
def test_beyond_the_limit_is_a_runaway_whatever_else(base):
    assert case(base, beyond_limit=True) is Outcome.RUNAWAY


def test_at_rest_is_stopped():
    assert case(ENDED) is Outcome.STOPPED
    assert case(ENDED, swing=at(1e-4)) is Outcome.STOPPED


def test_an_oscillation_that_is_left_is_oscillating():
    assert case(ENDED, swing=at(just_above(1e-4))) is Outcome.OSCILLATING
    assert case(ENDED, swing=(0.1, math.inf)) is Outcome.OSCILLATING


def test_an_oscillation_still_changing_is_unidentified():
    assert case(ENDED, swing=(0.0, 0.1)) is Outcome.UNIDENTIFIED


def test_too_short_a_run_is_unidentified():
    assert classify(Evidence(turning=False)) is Outcome.UNIDENTIFIED


@pytest.mark.parametrize("base", [AT_SPEED, LEFT, LAGGING, CAPTURED, MODULATED])
def test_a_mean_speed_that_has_not_settled_is_unidentified(base):
    assert case(base, has_settled=True) is not Outcome.UNIDENTIFIED
    assert case(base, has_settled=False) is Outcome.UNIDENTIFIED


def test_a_rotor_that_does_not_turn_needs_no_settled_speed():
    assert case(ENDED, has_settled=False) is Outcome.STOPPED
    assert case(ENDED, has_settled=False, swing=at(0.1)) is Outcome.OSCILLATING


# --- bounds: on one side of an edge they decide, on both they do not ---


@pytest.mark.parametrize("name", ["mean_speed", "lowest_speed"])
@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((198.0, just_below(199.0)), Outcome.PASSED),
        ((198.0, 199.0), Outcome.UNIDENTIFIED),
        ((just_below(199.0), 200.0), Outcome.UNIDENTIFIED),
        ((199.0, 201.0), Outcome.COMPENSATED),
        ((200.0, just_above(201.0)), Outcome.UNIDENTIFIED),
        ((201.0, 202.0), Outcome.UNIDENTIFIED),
        ((just_above(201.0), 202.0), Outcome.PASSED),
        ((198.0, 202.0), Outcome.UNIDENTIFIED),
    ],
)
def test_bounds_of_the_speeds(name, bounds, outcome):
    assert case(AT_SPEED, **{name: bounds}) is outcome
    assert truth(replace(AT_SPEED, **{name: bounds}).is_at_speed) is {Outcome.COMPENSATED: True, Outcome.PASSED: False}.get(
        outcome
    )


@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((0.0, just_below(0.01)), Outcome.COMPENSATED),
        ((0.0, 0.01), Outcome.UNIDENTIFIED),
        ((0.005, 0.02), Outcome.UNIDENTIFIED),
        ((just_below(0.01), 0.02), Outcome.UNIDENTIFIED),
        ((0.01, 0.02), Outcome.PASSED),
    ],
)
def test_bounds_of_the_unbalance(bounds, outcome):
    assert case(AT_SPEED, residual=bounds) is outcome
    assert truth(replace(AT_SPEED, residual=bounds).is_balanced) is {Outcome.COMPENSATED: True, Outcome.PASSED: False}.get(
        outcome
    )


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((-0.0005, 0.001), Outcome.COMPENSATED),
        ((0.0, just_above(0.001)), Outcome.UNIDENTIFIED),
        ((0.001, 0.01), Outcome.UNIDENTIFIED),
        ((just_above(0.001), 0.01), Outcome.BALANCER_CAPTURED),
        ((-0.01, 0.01), Outcome.UNIDENTIFIED),
    ],
)
def test_bounds_of_a_lag(sign, bounds, outcome):
    lags = (tuple(sorted(sign * x for x in bounds)),)
    assert case(AT_SPEED, lags=lags) is outcome
    lagging = {Outcome.COMPENSATED: False, Outcome.BALANCER_CAPTURED: True}.get(outcome)
    assert truth(replace(AT_SPEED, lags=lags).asynchronous) is lagging


@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((80.0, RESONANCE), Outcome.CAPTURED),
        ((80.0, just_above(RESONANCE)), Outcome.UNIDENTIFIED),
        ((RESONANCE, 110.0), Outcome.UNIDENTIFIED),
        ((just_above(RESONANCE), 110.0), Outcome.PASSED),
    ],
)
def test_bounds_about_the_resonance(bounds, outcome):
    assert case(NEAR_RESONANCE, lowest_speed=bounds) is outcome
    assert truth(replace(NEAR_RESONANCE, lowest_speed=bounds).is_beyond_resonance) is {
        Outcome.CAPTURED: False,
        Outcome.PASSED: True,
    }.get(outcome)


@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((0.0, 0.002), Outcome.CAPTURED),
        ((0.0, just_above(0.002)), Outcome.UNIDENTIFIED),
        ((0.0, 0.1), Outcome.UNIDENTIFIED),
        ((0.002, 0.1), Outcome.UNIDENTIFIED),
        ((just_above(0.002), 0.1), Outcome.CAPTURED_MODULATED),
    ],
)
def test_bounds_of_a_modulation(bounds, outcome):
    assert case(CAPTURED, modulation=bounds) is outcome
    modulated = {Outcome.CAPTURED: False, Outcome.CAPTURED_MODULATED: True}.get(outcome)
    assert truth(replace(CAPTURED, modulation=bounds).is_modulated) is modulated


@pytest.mark.parametrize(
    ("bounds", "outcome"),
    [
        ((0.0, 1e-4), Outcome.STOPPED),
        ((0.0, just_above(1e-4)), Outcome.UNIDENTIFIED),
        ((1e-4, 0.1), Outcome.UNIDENTIFIED),
        ((just_above(1e-4), 0.1), Outcome.OSCILLATING),
    ],
)
def test_bounds_of_a_swing(bounds, outcome):
    assert case(ENDED, swing=bounds) is outcome


# --- what cannot be told does not matter where all that can come of it gives the same ---

OPEN_SPEEDS = [{name: b} for name in ("mean_speed", "lowest_speed") for b in ((198.0, 200.0), (200.0, 202.0))]
OPEN_RESIDUAL = {"residual": (0.005, 0.02)}
OPEN_LAG = {"lags": ((0.0, 0.01),)}
OPEN_MODULATION = {"modulation": (0.0, 0.1)}


@pytest.mark.parametrize("undecided", OPEN_SPEEDS)
def test_whether_the_rotor_is_at_speed_matters_only_where_it_is_balanced_or_bodies_lag_before_the_resonance(undecided):
    assert case(AT_SPEED, **undecided) is Outcome.UNIDENTIFIED
    assert case(AT_SPEED, **undecided, residual=at(0.01)) is Outcome.PASSED
    assert case(AT_SPEED, **undecided, residual=None) is Outcome.PASSED
    assert case(LAGGING, **undecided) is Outcome.BALANCER_CAPTURED
    assert case(LAGGING, **undecided, resonance=202.0) is Outcome.UNIDENTIFIED
    assert case(LEFT, **undecided, resonance=202.0) is Outcome.CAPTURED
    assert case(AT_SPEED, **undecided, free_speed=None) is Outcome.PASSED


def test_one_speed_off_for_good_decides_whatever_the_other():
    assert case(AT_SPEED, mean_speed=(199.5, 202.0), lowest_speed=at(198.0)) is Outcome.PASSED
    assert case(AT_SPEED, mean_speed=at(202.0), lowest_speed=(198.0, 200.0)) is Outcome.PASSED


def test_whether_one_percent_is_left_matters_only_at_speed_without_lag():
    assert case(AT_SPEED, **OPEN_RESIDUAL) is Outcome.UNIDENTIFIED
    assert case(AT_SPEED, **OPEN_RESIDUAL, **speed(180.0)) is Outcome.PASSED
    assert case(AT_SPEED, **OPEN_RESIDUAL, free_speed=None) is Outcome.PASSED
    assert case(LAGGING, **OPEN_RESIDUAL) is Outcome.BALANCER_CAPTURED
    assert case(CAPTURED, **OPEN_RESIDUAL) is Outcome.CAPTURED
    assert case(MODULATED, **OPEN_RESIDUAL) is Outcome.CAPTURED_MODULATED


def test_whether_a_body_lags_matters_at_speed_or_beyond_the_resonance():
    assert case(AT_SPEED, **OPEN_LAG) is Outcome.UNIDENTIFIED
    assert case(LEFT, **OPEN_LAG) is Outcome.UNIDENTIFIED
    assert case(LEFT, **OPEN_LAG, **speed(180.0)) is Outcome.UNIDENTIFIED
    assert case(LEFT, **OPEN_LAG, resonance=FREE) is Outcome.UNIDENTIFIED
    assert case(CAPTURED, **OPEN_LAG) is Outcome.CAPTURED
    assert case(MODULATED, **OPEN_LAG) is Outcome.CAPTURED_MODULATED


def test_whether_a_body_lags_does_not_matter_where_another_one_does():
    assert case(AT_SPEED, lags=((0.0, 0.01), at(0.5))) is Outcome.BALANCER_CAPTURED
    assert case(AT_SPEED, lags=((0.0, 0.01), at(0.0))) is Outcome.UNIDENTIFIED


def test_whether_the_rotor_is_beyond_the_resonance_matters_unless_it_compensates_or_bodies_lag_at_speed():
    assert case(NEAR_RESONANCE, lowest_speed=(100.0, 102.0)) is Outcome.UNIDENTIFIED
    assert case(NEAR_RESONANCE, lowest_speed=(100.0, 102.0), resonance=None) is Outcome.PASSED
    at_resonance = {**speed(199.5, 200.5), "resonance": FREE}
    assert case(AT_SPEED, **at_resonance) is Outcome.COMPENSATED
    assert case(LAGGING, **at_resonance) is Outcome.BALANCER_CAPTURED
    assert case(LEFT, **at_resonance) is Outcome.UNIDENTIFIED


def test_whether_the_speed_is_modulated_matters_only_at_the_resonance():
    assert case(CAPTURED, **OPEN_MODULATION) is Outcome.UNIDENTIFIED
    assert case(CAPTURED, **OPEN_MODULATION, lags=(at(0.1),)) is Outcome.UNIDENTIFIED
    assert case(CAPTURED, **OPEN_MODULATION, resonance=None) is Outcome.PASSED
    assert case(NEAR_RESONANCE, **OPEN_MODULATION) is Outcome.PASSED
    assert case(AT_SPEED, **OPEN_MODULATION) is Outcome.COMPENSATED
    assert case(LAGGING, **OPEN_MODULATION) is Outcome.BALANCER_CAPTURED


@pytest.mark.parametrize("base", [AT_SPEED, CAPTURED, MODULATED, LAGGING])
def test_a_swing_does_not_matter_while_the_rotor_turns(base):
    assert classify(base) is case(base, swing=(0.0, 1.0)) is case(base, swing=at(0.0)) is case(base, swing=at(1.0))


def test_nothing_else_matters_where_the_rotor_does_not_turn():
    assert case(ENDED, **OPEN_RESIDUAL, **OPEN_LAG, **OPEN_MODULATION, **speed(0.0, 300.0)) is Outcome.STOPPED


def test_several_that_cannot_be_told_do_not_matter_together_either():
    assert case(CAPTURED, **OPEN_RESIDUAL, **OPEN_LAG) is Outcome.CAPTURED
    assert case(LAGGING, **OPEN_RESIDUAL, **OPEN_MODULATION, **speed(150.0, 300.0)) is Outcome.BALANCER_CAPTURED
    assert case(LEFT, **OPEN_MODULATION, **speed(150.0, 300.0)) is Outcome.PASSED


def test_a_run_beyond_the_limit_is_a_runaway_whatever_cannot_be_told():
    assert case(AT_SPEED, **OPEN_LAG, beyond_limit=True) is Outcome.RUNAWAY
    assert case(ENDED, swing=(0.0, math.inf), beyond_limit=True) is Outcome.RUNAWAY


# --- always ---

POINTS = {  # of every number, about its edges
    "mean_speed": [90.0, RESONANCE, 110.0, just_below(199.0), 199.0, 200.0, 201.0, just_above(201.0), 220.0],
    "lowest_speed": [80.0, RESONANCE, just_above(RESONANCE), 110.0, just_below(199.0), 199.0, 200.0, 201.0, just_above(201.0)],
    "residual": [0.0, 0.005, just_below(0.01), 0.01, 1.0],
    "lags": [-0.5, -just_above(0.001), -0.001, 0.0, 0.001, just_above(0.001), 0.5],
    "modulation": [0.0, 0.002, just_above(0.002), 0.1],
    "swing": [0.0, 1e-4, just_above(1e-4), 0.1],
}
APART = [-0.5, -just_above(0.001), -0.001, 0.0, 0.001, just_above(0.001), 0.5]
PHASES = [0.0, just_below(0.2 * math.pi), 0.2 * math.pi, 1.0, 3.0]


def bounds_of(points):
    """Known exactly, or two of these numbers."""
    return st.one_of(st.sampled_from(points).map(at), st.tuples(*2 * [st.sampled_from(points)]).map(lambda b: tuple(sorted(b))))


def within(draw, bounds, points):
    """Narrower bounds."""
    return draw(bounds_of([x for x in points if bounds[0] <= x <= bounds[1]]))


@st.composite
def evidences(draw, resonances=(None, RESONANCE, FREE)):
    return Evidence(
        turning=draw(st.integers(0, 4)) > 0,
        has_settled=draw(st.integers(0, 9)) > 0,
        free_speed=draw(st.sampled_from([FREE, FREE, FREE, None])),
        resonance=draw(st.sampled_from(resonances)),
        lags=tuple(draw(st.lists(bounds_of(POINTS["lags"]), max_size=2))),
        residual=draw(st.one_of(bounds_of(POINTS["residual"]), st.none())),
        **{name: draw(bounds_of(POINTS[name])) for name in ("mean_speed", "lowest_speed", "modulation", "swing")},
        beyond_limit=draw(st.integers(0, 9)) == 0,
    )


@st.composite
def narrowed(draw):
    """Evidence, and what may become of it as more is seen."""
    e = draw(evidences())
    names = ("mean_speed", "lowest_speed", "modulation", "swing", *(() if e.residual is None else ("residual",)))
    changes = {name: within(draw, getattr(e, name), POINTS[name]) for name in names}
    return e, replace(e, **changes, lags=tuple(within(draw, lag, POINTS["lags"]) for lag in e.lags))


@pytest.mark.slow
@always
@given(narrowed())
def test_narrower_bounds_never_change_an_outcome_once_identified(pair):
    earlier, later = map(classify, pair)
    assert earlier in (Outcome.UNIDENTIFIED, later)


@settings(always, max_examples=200)
@given(evidences(resonances=(None, RESONANCE)))
def test_the_outcome_is_the_one_of_all_points_within_the_bounds(e):
    names = ("mean_speed", "lowest_speed", "modulation", "swing", *(() if e.residual is None else ("residual",)))
    inner = {"mean_speed": FREE, "lowest_speed": FREE, "lags": 0.0}  # within both limits, where the bounds may be beyond both

    def points(name, bounds):
        return {at(x) for x in (*bounds, min(max(inner.get(name, bounds[0]), bounds[0]), bounds[1]))}

    lags = list(itertools.product(*(points("lags", lag) for lag in e.lags)))
    others = itertools.product(*(points(name, getattr(e, name)) for name in names))
    each = {case(e, lags=lag, **dict(zip(names, other, strict=True))) for other in others for lag in lags}
    assert classify(e) is (each.pop() if len(each) == 1 else Outcome.UNIDENTIFIED)


def scaled(e, factor):
    """The same motion with another unit of speed."""
    free, resonance = (None if x is None else factor * x for x in (e.free_speed, e.resonance))
    mean, lowest = (tuple(factor * x for x in bounds) for bounds in (e.mean_speed, e.lowest_speed))
    return replace(e, free_speed=free, resonance=resonance, mean_speed=mean, lowest_speed=lowest)


@pytest.mark.slow
@always
@given(evidences(), st.integers(-30, 30))
def test_the_unit_of_speed_does_not_matter_to_the_last_bit(e, power):
    assert classify(scaled(e, 2.0**power)) is classify(e)


@pytest.mark.slow  # by powers of two, to the last bit: above
@always
@given(
    evidences(),
    *2 * [bounds_of([90.0, 100.9, 101.1, 198.9, 199.1, 200.9, 201.1, 220.0])],
    st.floats(1e-6, 1e6),
)
def test_the_unit_of_speed_does_not_matter(e, mean, lowest, factor):
    off_the_edges = replace(e, mean_speed=mean, lowest_speed=lowest, resonance=e.resonance and RESONANCE)
    assert classify(scaled(off_the_edges, factor)) is classify(off_the_edges)


# --- entrained, synchronised: by the mean speed over whole periods ---

LOCKED = Locking(periods=50, speed_differences=(at(0.0),), phases=(at(1.0),))
VERDICTS = {
    True: {True: Outcome.ENTRAINED, False: Outcome.NOT_ENTRAINED, None: Outcome.UNIDENTIFIED},
    False: {True: Outcome.SYNCHRONISED, False: Outcome.NOT_SYNCHRONISED, None: Outcome.UNIDENTIFIED},
}


def locking(**changes):
    """Whether that is locked, after the outcomes have been found to say the same."""
    actual = replace(LOCKED, **changes)
    for by_vibration, outcomes in VERDICTS.items():
        assert actual.outcome(by_vibration=by_vibration) is outcomes[actual.is_locked]
    return actual.is_locked


@pytest.mark.parametrize(
    ("off", "outcome"),
    [
        (0.001, Outcome.SYNCHRONISED),
        (-0.001, Outcome.SYNCHRONISED),
        (just_above(0.001), Outcome.NOT_SYNCHRONISED),
        (-just_above(0.001), Outcome.NOT_SYNCHRONISED),
    ],
)
def test_rotors_within_a_tenth_of_a_percent_are_synchronised(off, outcome):
    assert replace(LOCKED, speed_differences=(at(off),)).outcome(by_vibration=False) is outcome


@pytest.mark.parametrize(
    ("off", "outcome"),
    [(-0.001, Outcome.ENTRAINED), (-just_above(0.001), Outcome.NOT_ENTRAINED), (just_above(0.001), Outcome.NOT_ENTRAINED)],
)
def test_a_rotor_within_a_tenth_of_a_percent_of_the_vibration_is_entrained(off, outcome):
    assert replace(LOCKED, speed_differences=(at(off),)).outcome(by_vibration=True) is outcome


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("bounds", "locked"),
    [
        ((-0.0005, 0.001), True),
        ((0.0, just_above(0.001)), None),
        ((0.001, 0.01), None),
        ((just_above(0.001), 0.01), False),
        ((-0.01, 0.01), None),
    ],
)
def test_bounds_of_how_far_a_rotor_is_off(sign, bounds, locked):
    assert locking(speed_differences=(tuple(sorted(sign * x for x in bounds)),)) is locked


def test_a_phase_that_still_moves_by_a_tenth_of_a_turn_is_not_yet_locked():
    assert locking(phases=((0.0, just_below(0.2 * math.pi)),)) is True
    assert locking(phases=((0.0, 0.2 * math.pi),)) is None


def test_a_phase_at_rest_may_have_any_value():
    assert locking(phases=((-40.0, -39.5),)) is True
    assert locking(phases=((-40.0, -39.0),)) is None


def test_every_phase_must_be_at_rest():
    assert locking(speed_differences=2 * (at(0.0),), phases=(at(1.0), at(2.0))) is True
    assert locking(speed_differences=2 * (at(0.0),), phases=(at(1.0), (0.0, 1.0))) is None


def test_whether_phases_are_at_rest_does_not_matter_where_a_rotor_is_off_for_good():
    assert locking(speed_differences=(at(0.01),), phases=((0.0, 1.0),)) is False
    assert locking(speed_differences=(at(0.01),), phases=(at(1.0),)) is False


def test_too_few_periods_are_unidentified():
    for periods in (5, 6):
        assert locking(periods=periods) is True
        assert locking(periods=periods, speed_differences=(at(0.01),)) is False
    for periods in (0, 4):
        assert locking(periods=periods) is None
        assert locking(periods=periods, speed_differences=(at(0.01),)) is None


def test_every_rotor_must_keep_the_speed_of_the_first():
    assert locking(speed_differences=(at(0.0), at(-0.1)), phases=2 * (at(1.0),)) is False


def test_whether_a_rotor_is_off_does_not_matter_where_another_one_is():
    assert locking(speed_differences=((0.0, 0.01), at(-0.1)), phases=2 * (at(1.0),)) is False
    assert locking(speed_differences=((0.0, 0.01), at(0.0)), phases=2 * (at(1.0),)) is None


def test_rotors_whose_speeds_have_no_bounds_are_not_off_for_good():
    assert locking(speed_differences=(at(0.01),), is_bounded=False) is None
    assert locking(speed_differences=(at(0.01),), is_bounded=True) is False


def test_whether_the_speeds_have_bounds_does_not_matter_where_the_rotors_are_locked():
    assert locking(is_bounded=False) is True


@st.composite
def narrowed_lockings(draw):
    apart, phases = (tuple(draw(st.lists(bounds_of(p), min_size=1, max_size=3))) for p in (APART, PHASES))
    e = Locking(draw(st.sampled_from([4, 5, 50])), apart, phases, draw(st.booleans()))
    narrower = [tuple(within(draw, b, p) for b in each) for each, p in ((apart, APART), (phases, PHASES))]
    return e, replace(e, speed_differences=narrower[0], phases=narrower[1])


@pytest.mark.slow
@always
@given(narrowed_lockings(), st.booleans())
def test_narrower_bounds_never_change_whether_rotors_are_locked(pair, by_vibration):
    earlier, later = (e.outcome(by_vibration=by_vibration) for e in pair)
    assert earlier in (Outcome.UNIDENTIFIED, later)
