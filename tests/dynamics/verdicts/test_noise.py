"""What is below the stated noise of an integration is rest, and ten times as much is a motion."""

import numpy as np
import pytest
from motions import W, beyond, modulated, stands, steady, swinging_between, truth, with_ball

from wucht.dynamics.verdicts.evidence import REASON_IN_NOISE
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import Outcome, classify
from wucht.numerics.observers.projection import Course

TOLERANCES = (1e-9, 1e-6, 1e-4, 1e-3)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_the_noise_follows_the_tolerance(tolerance):
    noise = Noise.of(tolerance)
    assert noise.speed == pytest.approx(max(tolerance, 1e-10))
    assert noise.angle == pytest.approx(max(10 * tolerance, 1e-7))


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_a_force_below_the_noise_is_zero(tolerance):
    noise = Noise.of(tolerance)
    assert noise.without(-0.9 * noise.angle * 500.0, 500.0) == 0.0
    assert noise.without(-1.1 * noise.angle * 500.0, 500.0) == -1.1 * noise.angle * 500.0


@pytest.mark.parametrize("tolerance", [1e-9, 1e-6, 1e-3])
def test_a_growth_within_the_noise_is_none_and_one_of_ten_times_that_is(tolerance):
    """Changes of the residual unbalance that grow from window to window; beside the ball's phase."""
    size = Noise.of(tolerance).angle

    def left(share):
        """The residual unbalance is twice the sine of half the ball's distance from where it compensates."""
        return stands(
            with_ball(), steady, lambda t: W * t + np.pi + share * size * np.exp(t / 20 - 5), noise=Noise.of(tolerance)
        )

    within, beyond_it = left(0.5).projections[1], left(20.0).projections[1]
    assert within.course is Course.STATIONARY
    assert beyond_it.course is Course.DRIFTING


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_an_oscillation_of_ten_times_the_noise_is_reported(tolerance):
    noise = Noise.of(tolerance)
    of_speed = stands(beyond(), modulated(10 * noise.speed, 7.0), noise=noise).evidence.modulation
    assert of_speed[1] >= 9 * noise.speed
    swing = 0.5, 0.5 + 10 * noise.angle
    left = stands(with_ball(), steady, swinging_between(*swing), noise=noise).evidence.residual
    assert left is not None
    assert left[1] >= 0.5 + 9 * noise.angle


def test_a_coarse_tolerance_does_not_hide_a_modulation():
    """A range of 1 % with a tolerance of 1e-3: the motion is not called steady."""
    noise = Noise.of(1e-3)
    evidence = stands(beyond(), modulated(10 * noise.speed, 7.0), noise=noise).evidence
    assert truth(evidence.is_modulated) is True


def test_where_the_noise_is_as_large_as_the_limit_that_is_the_advice():
    """The unbalance that is left goes to and fro about 1 %, the limit of ``compensated``, more slowly than the windows."""

    def ball(t):
        return W * t + np.pi + 0.01 + 0.002 * np.sin(2 * np.pi * t / 33)

    coarse, fine = (stands(with_ball(), steady, ball, noise=Noise.of(tolerance)) for tolerance in (1e-2, 1e-6))
    assert classify(coarse.evidence) is classify(fine.evidence) is Outcome.UNIDENTIFIED
    assert coarse.undecidable_reason == REASON_IN_NOISE
    assert fine.undecidable_reason != REASON_IN_NOISE
