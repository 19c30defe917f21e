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
SPEEDS = "mean_speed", "lowest_speed"
ENDED = Evidence(turning=False, swing=at(0.0))


def case(base, **changes):
    return classify(replace(base, **changes))


@pytest.mark.parametrize(
    ("base", "changes", "outcome"),
    [
        # Compensated: within 0.5 % of what the drive reaches without vibration, less than 1 % of the unbalance left.
        *((AT_SPEED, speed(value), Outcome.COMPENSATED) for value in (199.0, 200.0, 201.0)),
        *((AT_SPEED, speed(value), Outcome.PASSED) for value in (just_below(199.0), just_above(201.0))),
        *((AT_SPEED, {name: at(199.0)}, Outcome.COMPENSATED) for name in SPEEDS),
        *((AT_SPEED, {name: at(just_below(199.0))}, Outcome.PASSED) for name in SPEEDS),
        *((AT_SPEED, {name: at(201.0)}, Outcome.COMPENSATED) for name in SPEEDS),
        *((AT_SPEED, {name: at(just_above(201.0))}, Outcome.PASSED) for name in SPEEDS),
        (AT_SPEED, {"free_speed": -FREE}, Outcome.PASSED),
        (AT_SPEED, {"residual": at(just_below(0.01))}, Outcome.COMPENSATED),
        (AT_SPEED, {"residual": at(0.01)}, Outcome.PASSED),
        (AT_SPEED, {"residual": None}, Outcome.PASSED),
        (AT_SPEED, {"lags": ()}, Outcome.COMPENSATED),
        *((AT_SPEED, {"lags": (at(sign * 0.001),)}, Outcome.COMPENSATED) for sign in (1, -1)),
        *((AT_SPEED, {"lags": (at(sign * just_above(0.001)),)}, Outcome.BALANCER_CAPTURED) for sign in (1, -1)),
        (AT_SPEED, {"resonance": FREE}, Outcome.COMPENSATED),
        # Captured and passed: at or before the last maximum of the vibration torque, or beyond it.
        (CAPTURED, speed(30.0), Outcome.CAPTURED),
        (CAPTURED, speed(RESONANCE), Outcome.CAPTURED),
        (CAPTURED, speed(just_above(RESONANCE)), Outcome.PASSED),
        (LEFT, {"resonance": FREE}, Outcome.CAPTURED),
        (CAPTURED, {"resonance": None}, Outcome.PASSED),
        (CAPTURED, {"free_speed": None}, Outcome.CAPTURED),
        (AT_SPEED, {"free_speed": None}, Outcome.PASSED),
        # Held there, modulated: by more than 0.2 %.
        (MODULATED, {}, Outcome.CAPTURED_MODULATED),
        (MODULATED, {"mean_speed": at(120.0), "lowest_speed": at(RESONANCE)}, Outcome.CAPTURED_MODULATED),
        (MODULATED, {"mean_speed": at(120.0), "lowest_speed": at(just_above(RESONANCE))}, Outcome.PASSED),
        (CAPTURED, {"modulation": at(0.002)}, Outcome.CAPTURED),
        (CAPTURED, {"modulation": at(just_above(0.002))}, Outcome.CAPTURED_MODULATED),
        # The rotor at its speed or beyond the resonance, and a body that lags by more than 0.1 %.
        (LAGGING, {}, Outcome.BALANCER_CAPTURED),
        (AT_SPEED, {"lags": (at(0.0), at(0.5))}, Outcome.BALANCER_CAPTURED),
        (CAPTURED, {"lags": (at(0.1),)}, Outcome.CAPTURED),
        (MODULATED, {"lags": (at(0.1),)}, Outcome.CAPTURED_MODULATED),
        (LAGGING, speed(199.0) | {"resonance": FREE}, Outcome.BALANCER_CAPTURED),
        (LAGGING, speed(just_below(199.0)) | {"resonance": FREE}, Outcome.CAPTURED),
        (LAGGING, speed(180.0), Outcome.BALANCER_CAPTURED),
        (LEFT, speed(180.0) | {"lags": (at(0.001),)}, Outcome.PASSED),
        (LEFT, speed(180.0) | {"lags": (at(just_above(0.001)),)}, Outcome.BALANCER_CAPTURED),
        # A rotor that does not turn: to a ten-thousandth of its largest speed.
        (ENDED, {"swing": at(1e-4)}, Outcome.STOPPED),
        (ENDED, {"swing": at(just_above(1e-4))}, Outcome.OSCILLATING),
        (ENDED, {"swing": (0.1, math.inf)}, Outcome.OSCILLATING),
        (ENDED, {"swing": (0.0, 0.1)}, Outcome.UNIDENTIFIED),
        (ENDED, {"swing": (0.0, math.inf)}, Outcome.UNIDENTIFIED),
        *((base, {"has_settled": False}, Outcome.UNIDENTIFIED) for base in (AT_SPEED, LEFT, LAGGING, CAPTURED, MODULATED)),
        (ENDED, {"has_settled": False}, Outcome.STOPPED),
        *((base, {"beyond_limit": True}, Outcome.RUNAWAY) for base in (AT_SPEED, CAPTURED, LAGGING, ENDED)),
    ],
)
def test_outcomes_at_the_edges(base, changes, outcome):
    assert classify(replace(base, **changes)) is outcome


def test_outcomes_within_bounds():
    """Bounds within the limits decide, whatever else is not known; those of all points within them are tested below."""
    within = speed(199.0, 201.0) | {"residual": (0.0, just_below(0.01)), "lags": ((-0.001, 0.001),)}
    assert case(AT_SPEED, **within) is Outcome.COMPENSATED
    assert case(AT_SPEED, residual=(0.0, 0.01)) is Outcome.UNIDENTIFIED
    assert case(CAPTURED, residual=(0.0, 0.02), lags=((0.0, 0.01),)) is Outcome.CAPTURED
    assert case(LEFT, modulation=(0.0, 0.1), **speed(150.0, 300.0)) is Outcome.PASSED
    assert classify(Evidence(turning=False)) is Outcome.UNIDENTIFIED


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


@pytest.mark.slow
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


# --- entrained, synchronised: by the mean speed over whole periods ---

LOCKED = Locking(periods=50, speed_differences=(at(0.0),), phases=(at(1.0),))
VERDICTS = {
    True: {True: Outcome.ENTRAINED, False: Outcome.NOT_ENTRAINED, None: Outcome.UNIDENTIFIED},
    False: {True: Outcome.SYNCHRONISED, False: Outcome.NOT_SYNCHRONISED, None: Outcome.UNIDENTIFIED},
}
TURN_TENTH = 0.2 * math.pi


@pytest.mark.parametrize(
    ("changes", "locked"),
    [
        # Within a thousandth of the speed; bounds on one side of it decide.
        *(({"speed_differences": (at(sign * 0.001),)}, True) for sign in (1, -1)),
        *(({"speed_differences": (at(sign * just_above(0.001)),)}, False) for sign in (1, -1)),
        ({"speed_differences": ((-0.0005, 0.001),)}, True),
        ({"speed_differences": ((0.0, just_above(0.001)),)}, None),
        ({"speed_differences": ((0.001, 0.01),)}, None),
        ({"speed_differences": ((just_above(0.001), 0.01),)}, False),
        ({"speed_differences": (at(0.01),), "is_bounded": False}, None),
        ({"is_bounded": False}, True),
        # Every rotor keeps the speed of the first; one that does not decides.
        ({"speed_differences": (at(0.0), at(-0.1)), "phases": 2 * (at(1.0),)}, False),
        ({"speed_differences": ((0.0, 0.01), at(-0.1)), "phases": 2 * (at(1.0),)}, False),
        ({"speed_differences": ((0.0, 0.01), at(0.0)), "phases": 2 * (at(1.0),)}, None),
        # Every phase rests to a tenth of a turn, wherever it is.
        ({"phases": ((0.0, just_below(TURN_TENTH)),)}, True),
        ({"phases": ((0.0, TURN_TENTH),)}, None),
        ({"phases": ((-40.0, -39.5),)}, True),
        ({"speed_differences": 2 * (at(0.0),), "phases": (at(1.0), (0.0, 1.0))}, None),
        ({"speed_differences": (at(0.01),), "phases": ((0.0, 1.0),)}, False),
        # Over five periods at least.
        ({"periods": 5}, True),
        ({"periods": 5, "speed_differences": (at(0.01),)}, False),
        ({"periods": 4}, None),
        ({"periods": 4, "speed_differences": (at(0.01),)}, None),
    ],
)
def test_locked_at_the_edges(changes, locked):
    actual = replace(LOCKED, **changes)
    assert actual.is_locked is locked
    for by_vibration, outcomes in VERDICTS.items():
        assert actual.outcome(by_vibration=by_vibration) is outcomes[locked]


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
