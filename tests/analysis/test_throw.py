"""Stroke, direction and acceleration of a throw: of ellipses known by pencil, harmonic and sampled."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.analysis.throw import GRAVITY, Throw

MAJOR, MINOR, SPEED = 3e-3, 0.4e-3, 150.0


def ellipse(angle: float, sense: float, phase: float = 0.7) -> np.ndarray:
    """z (2,) of an ellipse with its major axis at an angle, run through counter-clockwise (sense 1) or clockwise."""
    own = np.array([MAJOR, -1j * sense * MINOR]) * np.exp(1j * phase)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.asarray(turn @ own)


def sampled(z: np.ndarray, a_turn: float, deck: float | None) -> Throw:
    """From samples in uneven steps."""
    steps = np.where(np.arange(int(40 * a_turn)) % 7 == 3, 0.8, 1.0)
    time = np.cumsum(steps) * 2 * math.pi / SPEED / a_turn
    turning = np.exp(1j * SPEED * time)
    return Throw.from_samples(time, (z[:, None] * turning).real, (1j * SPEED * z[:, None] * turning).real, deck)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("angle", [-1.2, 0.78])
def test_an_ellipse(angle: float, sense: float) -> None:
    z, deck = ellipse(angle, sense), -0.1
    own = math.hypot(MAJOR * math.sin(angle - deck), MINOR * math.cos(angle - deck))  # half its height over the deck
    for throw, exact in ((Throw.from_harmonic(z, SPEED, deck), 1e-12), (sampled(z, 24.3, deck), 1e-4)):
        assert (throw.stroke, throw.across) == pytest.approx((2 * MAJOR, 2 * MINOR), rel=max(exact, 2e-3))
        assert math.sin(throw.direction - angle) == pytest.approx(0.0, abs=max(exact, 3e-3)), "a line has no sense"
        assert throw.acceleration == pytest.approx(MAJOR * SPEED**2, rel=exact)
        assert throw.machine_number == pytest.approx(MAJOR * SPEED**2 / GRAVITY, rel=exact)
        assert throw.throw_number(deck) == pytest.approx(own * SPEED**2 / GRAVITY / math.cos(deck), rel=exact)


def test_samples_that_follow_one_another_at_once() -> None:
    """The last one of a run may lie just behind the last of its grid."""
    time = np.append(np.linspace(0.0, 1.0, 401), 1.0 + 1e-13)
    turning = ellipse(0.78, 1.0)[:, None] * np.exp(1j * SPEED * time)
    throw = Throw.from_samples(
        np.append(time, time[-1]), *(np.hstack([q, q[:, -1:]]) for q in (turning.real, (1j * SPEED * turning).real))
    )
    assert throw.acceleration == pytest.approx(MAJOR * SPEED**2, rel=2e-3)


def test_a_line_a_circle_and_rest() -> None:
    line = Throw.from_harmonic(np.array([0.0, 1e-3]), 100.0, 0.0)
    assert (line.direction, line.ratio) == (pytest.approx(math.pi / 2), pytest.approx(0.0, abs=1e-12))
    assert line.throw_number(0.0) == pytest.approx(line.machine_number)
    assert Throw.from_harmonic(np.array([1e-3, -1e-3j]), 100.0).ratio == pytest.approx(1.0)
    rest = Throw.from_samples(np.arange(5.0), np.zeros((2, 5)), np.zeros((2, 5)))
    assert (rest.stroke, rest.ratio, rest.acceleration) == (0.0, None, 0.0)


@pytest.mark.parametrize(("noise", "stroke", "ratio", "direction"), [
    (0.9e-3, 4e-3, 0.25, 0.4), (1.1e-3, 4e-3, 0.0, 0.4), (2.9e-3, 4e-3, 0.0, 0.4), (3.1e-3, 4e-3, 0.0, None),
    (4.1e-3, 0.0, None, None),
])  # fmt: skip
def test_what_is_below_the_noise_is_no_throw(noise: float, stroke: float, ratio: float | None, direction: float | None) -> None:
    """First the motion across, then the direction, of which the circle is none, then all."""
    throw = Throw(stroke=4e-3, across=1e-3, direction=0.4, acceleration=40.0, normal=30.0).beyond(noise)
    assert (throw.stroke, throw.ratio, throw.direction) == (stroke, ratio, direction)
    assert (throw.acceleration, throw.normal) == ((40.0, 30.0) if stroke else (0.0, 0.0))
    circle = Throw(stroke=4e-3, across=3.9e-3, direction=0.4, acceleration=40.0)
    assert (circle.beyond(0.9e-4).direction, circle.beyond(1.1e-4).direction) == (0.4, None)


@pytest.mark.parametrize("deck", [0.3, -0.4])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_bounce_that_is_larger_to_one_side(deck: float, sense: float) -> None:
    """x = a (cos w t + 0.3 cos 2 w t): from 1.3 a to -0.7 a - ...; accelerations of 2.2 a w^2 outward at one end."""
    time = np.linspace(0.0, 4 * math.pi / SPEED, 801)
    phase, way = SPEED * time, np.array([math.cos(0.5), math.sin(0.5)])
    along = sense * MAJOR * (np.cos(phase) + 0.3 * np.cos(2 * phase))
    rate = -sense * MAJOR * SPEED * (np.sin(phase) + 0.6 * np.sin(2 * phase))
    throw = Throw.from_samples(time, np.outer(way, along), np.outer(way, rate), deck)
    assert throw.stroke == pytest.approx(np.ptp(along), rel=1e-4)
    assert throw.across == pytest.approx(0.0, abs=1e-12)
    assert throw.direction == pytest.approx(0.5, abs=1e-9)
    assert throw.acceleration == pytest.approx(2.2 * MAJOR * SPEED**2, rel=1e-3)
    assert throw.normal == pytest.approx(2.2 * MAJOR * SPEED**2 * abs(math.sin(0.5 - deck)), rel=1e-3)
