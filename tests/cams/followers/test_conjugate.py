"""Conjugate cams: one angle of the lever touches both contours, found from the contours alone."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize_scalar
from tests.refusals import refused

from wucht.cams.followers.oscillating_roller import OscillatingRoller, conjugate_cams
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
LAW = FourierSeries.of(math.radians(12), np.radians([-12.5, 0.8, -0.4]), np.radians([0.7, 0.3]))
FOLLOWER = OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))
COUNTER = OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.012, angle=math.radians(122))


def touching_angle(cam, phi, near):
    """The value of the law at which the roller touches the contour as it has turned by phi: from the contour's points alone."""
    grid = np.linspace(0, TURN, 4097)
    points = cam.contour(grid)
    points[-1] = points[0]
    turned = CubicSpline(grid, points * np.exp(1j * (-1 if cam.clockwise else 1) * phi), bc_type="periodic")

    def gap(value):
        centre = complex(cam.follower.place(value))
        start = grid[np.argmin(np.abs(turned(grid) - centre))]
        step = 2 * TURN / 4096
        found = minimize_scalar(
            lambda t: abs(complex(turned(t)) - centre), bounds=(start - step, start + step), method="bounded",
            options={"xatol": 1e-10},
        )  # fmt: skip
        return found.fun - cam.follower.roller_radius

    return brentq(gap, near - 0.02, near + 0.02, xtol=1e-13)


@pytest.mark.parametrize("clockwise", [False, True])
def test_both_contours_are_touched_at_one_angle_of_the_lever(clockwise):
    """The counter cam closes with the cam to 1e-9."""
    cams = conjugate_cams(LAW, FOLLOWER, COUNTER, clockwise)
    for phi in np.linspace(0.1, 0.1 + TURN, 16, endpoint=False):
        near = float(LAW(phi)) + 0.003
        on_cam, on_counter = (touching_angle(cam, phi, near) for cam in cams)
        assert on_cam == pytest.approx(float(LAW(phi)), abs=1e-9)
        assert on_counter == pytest.approx(on_cam, abs=1e-9)


@pytest.mark.parametrize("end", ["lowest", "highest"])
def test_a_counter_arm_that_comes_into_line_is_refused(end):
    """Its angle must stay between 0 and 180 deg over the whole range of the law: both sides of both ends."""
    low, high = LAW.bounds
    at = -low if end == "lowest" else math.pi - high
    into = 1e-4 if end == "lowest" else -1e-4
    conjugate_cams(LAW, FOLLOWER, OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.01, angle=at + into))
    with refused("follower.counter.angle", "-180", "0 deg", "180 deg") as error:
        conjugate_cams(LAW, FOLLOWER, OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.01, angle=at - into))
    assert error.value.location == "follower.counter.angle"
    worst = LAW.stationary()[np.argmin(LAW(LAW.stationary())) if end == "lowest" else np.argmax(LAW(LAW.stationary()))]
    assert f"at a cam angle of {math.degrees(worst):.4g} deg" in str(error.value)


def test_two_pivots_are_refused():
    with refused("follower.counter.pivot", "0.11 m", given=0.12):
        conjugate_cams(LAW, FOLLOWER, OscillatingRoller(pivot=0.12, arm=0.08, roller_radius=0.01, angle=math.radians(122)))
