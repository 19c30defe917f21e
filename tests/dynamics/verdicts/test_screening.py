from dataclasses import replace

import numpy as np
import pytest

from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import MODULATION_THRESHOLD, OUTCOMES, Evidence, Outcome, classify, classify_each
from wucht.dynamics.verdicts.screening import Screening, screening_of

TIMES = np.linspace(0.0, 400.0, 160)


LastHalf = tuple[float, np.ndarray, np.ndarray, np.ndarray]  # its duration, with speed, phases and residual of two members


def screen(half: LastHalf, free: float = np.nan) -> Screening:
    return screening_of(*half, np.full(2, free), Noise.of())


def of(speed: np.ndarray, phase: np.ndarray | None = None, left: np.ndarray | None = None) -> LastHalf:
    """One member twice."""
    phase = np.zeros(len(TIMES)) if phase is None else phase
    left = np.full(len(TIMES), 0.5) if left is None else left
    return 400.0, np.stack([speed] * 2, 1), np.stack([phase] * 2, 1)[None], np.stack([left] * 2, 1)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_decay_is_followed_to_its_end(sense: int) -> None:
    rest = screen(of(sense * (1.0 - 1e-3 * np.exp(-TIMES / 100))))
    assert rest.has_settled.all() and (rest.sense == sense).all()
    low, high = rest.evidence.mean_speed
    assert (low <= 1.0).all() and (high >= 1.0).all()  # the end lies between the bounds
    assert (rest.width < 3e-4).all()


@pytest.mark.parametrize("depth", [0.1, 10.0])
def test_a_modulation_is_no_rest_but_worth_a_closer_look(depth: float) -> None:
    rest = screen(of(1 + depth * MODULATION_THRESHOLD * np.cos(2 * np.pi * TIMES / 10.3)))
    assert not rest.has_settled.any() and rest.cycling.all() and (abs(rest.rises - 39) <= 1).all()


def test_what_drifts_turns_back_slips_or_goes_on_swinging_is_not_at_rest() -> None:
    even = np.ones(len(TIMES))
    assert screen(of(even)).has_settled.all()
    assert not screen(of(1 + 1e-3 * TIMES / 400)).has_settled.any()
    assert not screen(of(np.where(TIMES < 10, -1.0, 1.0))).has_settled.any()
    assert not screen(of(even, phase=0.01 * TIMES)).has_settled.any()
    assert not screen(of(even, phase=0.02 * TIMES / 400 * np.cos(TIMES / 5) * 10)).has_settled.any()
    assert not screen(of(even, left=0.5 + 0.1 * np.cos(TIMES / 10))).has_settled.any()
    assert not screen(of(even * 0.01)).has_settled.any()  # too few turns


@pytest.mark.parametrize(("speed", "expected"), [(1.0051, False), (1.0049, True), (0.9951, True), (0.9949, False)])
def test_the_free_speed_is_held_within_half_a_percent(speed: float, expected: bool) -> None:
    at_speed = screen(of(np.full(len(TIMES), speed)), free=1.0).evidence.is_at_speed
    assert at_speed.is_known.all() and (at_speed.yes == expected).all()
    assert screen(of(np.full(len(TIMES), speed))).evidence.is_at_speed.no.all()


@pytest.mark.parametrize(("left", "expected"), [(0.0099, True), (0.0101, False)])
def test_less_than_a_percent_is_compensated(left: float, expected: bool) -> None:
    balanced = screen(of(np.ones(len(TIMES)), left=np.full(len(TIMES), left))).evidence.is_balanced
    assert balanced.is_known.all() and (balanced.yes == expected).all()


@pytest.mark.parametrize(("tolerance", "limit"), [(1e-12, 1e-4), (1e-7, 1e-4), (1e-6, 3e-4), (1e-5, 1e-3), (1e-3, 1e-3)])
@pytest.mark.parametrize("share", [0.95, 1.05])
def test_how_far_the_tolerance_keeps_a_motion_at_rest_moving(tolerance: float, limit: float, share: float) -> None:
    """A ten-thousandth of the speed, or 300 times the tolerance up to a thousandth.

    Slow equations at 1e-6 ring by 2e-4 of it and do not decay.
    """
    ringing = of(1 + share * limit / 2 * np.cos(2 * np.pi * TIMES / 7.0))
    still = screening_of(*ringing, np.ones(2), Noise.of(tolerance)).still
    assert (still == (share < 1)).all()


@pytest.mark.parametrize(("growth", "still"), [(0.01, True), (0.5, False), (8.0, False)])
def test_what_leaves_however_small_it_is_yet_is_not_at_rest(growth: float, still: bool) -> None:
    """An unbalance left that grows to 1e-4, by a factor e^growth in what is seen, will be more than 1 % if it goes on so."""
    rest = screen(of(np.ones(len(TIMES)), left=1e-4 * np.exp(growth * (TIMES / 400 - 1))))
    assert (rest.still == still).all()
    assert (rest.has_settled == still).all()


def test_outcomes_are_those_of_the_same_criteria() -> None:
    """At the free speed or below it, a resonance between, with and without an unbalance that is left: one beside the other."""
    speeds, left = np.array([1.0, 1.0, 0.6, 0.6]), np.array([0.001, 0.5, 0.5, 0.5])
    half = 400.0, np.ones((160, 1)) * speeds, np.zeros((1, 160, 4)), np.ones((160, 1)) * left
    evidence = replace(screening_of(*half, np.ones(4), Noise.of()).evidence, resonance=np.array([0.7, 0.7, 0.7, np.nan]))
    outcomes = [OUTCOMES[i] for i in classify_each(evidence)]
    assert outcomes == [Outcome.COMPENSATED, Outcome.PASSED, Outcome.CAPTURED, Outcome.PASSED]
    alone = Evidence(True, (0.6, 0.6), (0.6, 0.6), free_speed=1.0, resonance=0.7, residual=(0.5, 0.5))
    assert classify(alone) is Outcome.CAPTURED


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("turns", "expected"), [(5.9, False), (6.1, True)])
def test_six_turns_are_needed(turns: float, expected: bool, sense: int) -> None:
    speed = sense * turns * 2 * np.pi / 400.0
    assert (screen(of(np.full(len(TIMES), speed))).has_settled == expected).all()
