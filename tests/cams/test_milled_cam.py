"""What a milled cam does, from its points alone: the independent proof of what was made."""

import math

import numpy as np
import pytest
from tests.refusals import failed, refused

from wucht.cams.correction import CorrectedLaw, share_above_order
from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.linkages.closure import LeverMotion
from wucht.cams.linkages.four_bar_and_slider_crank import FourBar
from wucht.cams.milled_cam import MilledContour, dot, milled_motion
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries, even_angles

LAW = equiripple(5, math.radians(120), math.radians(24))
SHAFT = ShaftMotion(FourierSeries.of(500 * math.pi / 30, [0, 2.4, 1, 0.5, 0.3], [0, 1, -1.3, 0.2, 0.4]))
LINKAGE = FourBar(0.3, 0.1, 0.28, 0.12, math.radians(80))
ROD = TranslatingRoller(distance=0.06, roller_radius=0.012, offset=0.007)
LEVER = OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))
ORDERS = 60  # looked at: differentiation makes more of the rounding of higher ones


def acceleration(law, count, rounding=0.0):
    """Of the output over time, recovered: points -> contact -> lever -> linkage -> psi(t), at even times."""
    rho = LeverMotion(law, LINKAGE)
    points = RollerCam(rho, LEVER).contour(even_angles(count))
    if rounding:
        points = rounding * (np.round(points.real / rounding) + 1j * np.round(points.imag / rounding))
    phi = SHAFT.angle(even_angles(1024))
    lever = milled_motion(points, LEVER, phi, rho(phi) + 1e-3 * np.cos(phi))
    found = FourierSeries.from_samples(LINKAGE.output_at(lever)).derivative(2)
    return FourierSeries(0.0, found.cosine[:ORDERS], found.sine[:ORDERS])


def test_the_corrected_cam_runs_clean_and_the_original_one_does_not():
    """Issue 11, 9: orders above N below 1e-9 of order 1 at 1440 points; the original one has orders N + 1 to 2 N."""
    assert share_above_order(acceleration(CorrectedLaw(LAW, SHAFT), 1440), 5) < 1e-11
    original = acceleration(LAW, 1440)
    assert original.amplitudes[5:10].max() > 0.1 * original.amplitudes[0]


def test_more_points_make_it_cleaner_until_rounding():
    """Of a quintic spline: by nearly 2^6 for twice the points, 64; at 1e-12 it ends."""
    coarse, fine = (share_above_order(acceleration(CorrectedLaw(LAW, SHAFT), count), 5) for count in (360, 720))
    assert coarse > 30 * fine > 1e-12


def test_points_rounded_to_a_micrometre_leave_something():
    """cam-mathematics: 8e-5 of order 1 in its example, whatever the number of points; orders up to 2 N."""
    found = acceleration(CorrectedLaw(LAW, SHAFT), 720, 1e-6)
    assert 1e-5 < found.amplitudes[5:10].max() / found.amplitudes[0] < 1e-3


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("outer", [False, True])
@pytest.mark.parametrize("follower", [LEVER, ROD], ids=["lever", "rod"])
def test_a_cam_moves_its_follower_as_the_law_says(follower, outer, clockwise):
    law = FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008])
    phi = np.linspace(0, 7, 200)
    points = RollerCam(law, follower, clockwise, outer).contour(even_angles(720))
    found = milled_motion(points, follower, phi, law(phi) + 1e-4, clockwise)
    assert found == pytest.approx(law(phi), abs=1e-12)


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_cam_moves_its_flat_face_as_the_law_says(clockwise):
    law, follower = FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008]), FlatFaced(distance=0.05)
    phi = np.linspace(0, 7, 200)
    points = FlatFacedCam(law, follower, clockwise).contour(even_angles(720))
    assert milled_motion(points, follower, phi, law(phi), clockwise) == pytest.approx(law(phi), abs=1e-12)


def test_what_cannot_be_is_a_sentence():
    points = 0.05 * np.exp(1j * even_angles(9))
    with refused("points", "10", given=9):
        milled_motion(points, LEVER, np.zeros(1), np.zeros(1))
    small = 0.001 * np.exp(-1j * even_angles(100))
    with failed("no-contact"):
        milled_motion(small, LEVER, np.zeros(1), np.zeros(1))


def test_ten_points_are_a_contour_and_nine_are_not():
    """A circle about 2 + 1j: the spline of fifth degree, its derivative by the number of the point, and the nearest ones."""
    points = 2 + 1j + 3 * np.exp(2j * np.pi * np.arange(10) / 10)
    contour = MilledContour(points)
    at = np.array([0.0, 2.5, 7.0, 9.5])
    assert contour(at) == pytest.approx(2 + 1j + 3 * np.exp(2j * np.pi * at / 10), abs=1e-3)
    assert contour(at, 1) == pytest.approx(3 * 2j * np.pi / 10 * np.exp(2j * np.pi * at / 10), abs=2e-3)
    assert contour.nearest(np.array([2 + 5j, -9 + 1j, 6 + 1j])).tolist() in ([2.0, 5.0, 0.0], [3.0, 5.0, 0.0])
    with refused("points", "10", given=9):
        MilledContour(points[:9])


def test_a_scalar_product():
    assert dot(np.array([1 + 2j, 1j]), np.array([3 - 1j, 1.0])).tolist() == [1.0, 0.0]
