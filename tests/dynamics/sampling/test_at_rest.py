import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from wucht.dynamics.sampling.at_rest import LastHalf, approached, resting
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import MODULATION_THRESHOLD
from wucht.numerics.observers.projection import Course, projected

NOISE = Noise.of()
TIMES = np.linspace(0.0, 400.0, 160)


@settings(deadline=None)
@given(arrays(float, 5, elements=st.floats(-10, 10, width=32)), st.sampled_from([0.0, 1e-3]))
def test_an_approach_is_that_of_a_run_up(means: np.ndarray, rounding: float) -> None:
    bounds, known = approached(np.stack([means, means[::-1]], axis=1), np.full(2, rounding))
    for column, each in enumerate((means, means[::-1])):
        p = projected(each, rounding=rounding)
        still = (np.abs(np.diff(each))[-2:] <= rounding).all()
        assert known[column] == (p.course is Course.APPROACHING or still)
        if known[column]:
            assert tuple(bounds[:, column]) == p.bounds


def of(speed: np.ndarray, phase: np.ndarray | None = None, left: np.ndarray | None = None) -> LastHalf:
    """One member twice."""
    phase = np.zeros(len(TIMES)) if phase is None else phase
    left = np.full(len(TIMES), 0.5) if left is None else left
    return LastHalf(400.0, np.stack([speed] * 2, 1), np.stack([phase] * 2, 1)[None], np.stack([left] * 2, 1))


@pytest.mark.parametrize("sense", [1, -1])
def test_a_decay_is_followed_to_its_end(sense: int) -> None:
    rest = resting(of(sense * (1.0 - 1e-3 * np.exp(-TIMES / 100))), NOISE)
    assert rest.known.all() and (rest.sense == sense).all()
    assert (rest.mean[0] <= 1.0).all() and (rest.mean[1] >= 1.0).all()  # the end lies between the bounds
    assert (rest.width < 3e-4).all()


@pytest.mark.parametrize("depth", [0.1, 10.0])
def test_a_modulation_is_no_rest_but_worth_a_closer_look(depth: float) -> None:
    rest = resting(of(1 + depth * MODULATION_THRESHOLD * np.cos(2 * np.pi * TIMES / 10.3)), NOISE)
    assert not rest.known.any() and rest.cycling.all() and (abs(rest.rises - 39) <= 1).all()


def test_what_drifts_turns_back_slips_or_goes_on_swinging_is_not_at_rest() -> None:
    even = np.ones(len(TIMES))
    assert resting(of(even), NOISE).known.all()
    assert not resting(of(1 + 1e-3 * TIMES / 400), NOISE).known.any()
    assert not resting(of(np.where(TIMES < 10, -1.0, 1.0)), NOISE).known.any()
    assert not resting(of(even, phase=0.01 * TIMES), NOISE).known.any()
    assert not resting(of(even, phase=0.02 * TIMES / 400 * np.cos(TIMES / 5) * 10), NOISE).known.any()
    assert not resting(of(even, left=0.5 + 0.1 * np.cos(TIMES / 10)), NOISE).known.any()
    assert not resting(of(even * 0.01), NOISE).known.any()  # too few turns


@pytest.mark.parametrize(("speed", "expected"), [(1.0051, False), (1.0049, True), (0.9951, True), (0.9949, False)])
def test_the_free_speed_is_held_within_half_a_percent(speed: float, expected: bool) -> None:
    at_speed, known = resting(of(np.full(len(TIMES), speed)), NOISE).at_speed(np.ones(2))
    assert known.all() and (at_speed == expected).all()
    assert not resting(of(np.full(len(TIMES), speed)), NOISE).at_speed(np.full(2, np.nan))[0].any()


@pytest.mark.parametrize(("left", "expected"), [(0.0099, True), (0.0101, False)])
def test_less_than_a_percent_is_compensated(left: float, expected: bool) -> None:
    balanced, known = resting(of(np.ones(len(TIMES)), left=np.full(len(TIMES), left)), NOISE).balanced
    assert known.all() and (balanced == expected).all()


def test_rest_with_rounding_or_the_drift_of_the_tolerance_is_rest() -> None:
    noise = np.random.default_rng(1).normal(size=(2, len(TIMES)))
    rest = resting(of(1 + 1e-8 * noise[0], left=2e-5 + 1e-5 * TIMES / 400 + 1e-8 * noise[1]), NOISE)
    assert rest.known.all() and rest.still.all() and rest.even.all()
    assert rest.at_speed(np.ones(2))[0].all() and rest.balanced[0].all()


@pytest.mark.parametrize(("growth", "still"), [(0.01, True), (0.5, False), (8.0, False)])
def test_what_leaves_however_small_it_is_yet_is_not_at_rest(growth: float, still: bool) -> None:
    """An unbalance left that grows to 1e-4, by a factor e^growth in what is seen, will be more than 1 % if it goes on so."""
    rest = resting(of(np.ones(len(TIMES)), left=1e-4 * np.exp(growth * (TIMES / 400 - 1))), NOISE)
    assert (rest.still == still).all()
    assert (rest.known == still).all()
