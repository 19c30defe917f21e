"""Cams: contours against the geometry they come from, derivatives against differences, a cam known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.refusals import failed, refused

from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.milled_cam import milled_motion
from wucht.numerics.fourier_series import FourierSeries, even_angles

TURN = 2 * math.pi
PHI = np.linspace(0, TURN, 721)


def lever():
    law = FourierSeries.of(math.radians(12), np.radians([-12.5, 0.8, -0.4]), np.radians([0.7, 0.3]))
    return law, OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))


def rod():
    return FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008]), TranslatingRoller(
        distance=0.06, roller_radius=0.012, offset=0.007
    )


CAMS = {
    f"{name}{', clockwise' if cw else ''}{', outer' if outer else ''}": RollerCam(*of, cw, outer)
    for name, of in (("lever", lever()), ("rod", rod()))
    for cw in (False, True)
    for outer in (False, True)
}
FLAT = {f"flat{', clockwise' if cw else ''}": FlatFacedCam(rod()[0], FlatFaced(distance=0.08), cw) for cw in (False, True)}


def derivative(f, phi, h=1e-5):
    """Of fourth order in the step: to some 1e-12 of the third derivative, and 1e-11 of rounding."""
    return (8 * (f(phi + h) - f(phi - h)) - (f(phi + 2 * h) - f(phi - 2 * h))) / (12 * h)


@pytest.mark.parametrize("cam", CAMS.values(), ids=CAMS)
def test_derivatives_are_those_of_the_curves(cam):
    for order in (1, 2, 3):
        slope = derivative(lambda p, o=order: cam.pitch(p, o - 1), PHI)
        assert np.abs(cam.pitch(PHI, order) - slope).max() < 1e-9
    for order in (1, 2):
        slope = derivative(lambda p, o=order: cam.contour(p, o - 1), PHI)
        assert np.abs(cam.contour(PHI, order) - slope).max() < 1e-9


@pytest.mark.parametrize("cam", CAMS.values(), ids=CAMS)
def test_curvature_is_that_of_the_contour(cam):
    """From its derivatives, as of any plane curve; convex is positive."""
    first, second = cam.contour(PHI, 1), cam.contour(PHI, 2)
    sense = 1 if cam.clockwise else -1
    assert cam.curvature(PHI) == pytest.approx(sense * (first.conj() * second).imag / np.abs(first) ** 3, rel=1e-9)


@pytest.mark.parametrize("cam", CAMS.values(), ids=CAMS)
def test_the_contour_is_at_the_rollers_radius_from_the_pitch_curve(cam):
    """On its normal, and inside of it but for an outer flank; nowhere nearer."""
    apart = cam.pitch(PHI) - cam.contour(PHI)
    assert np.abs(apart) == pytest.approx(np.full(721, cam.follower.roller_radius), rel=1e-12)
    assert np.abs((apart.conj() * cam.pitch(PHI, 1)).real).max() < 1e-12
    assert ((apart.conj() * cam.pitch(PHI)).real > 0).all() is np.bool_(not cam.outer)
    nearest = np.abs(cam.pitch(PHI)[:, None] - cam.contour(PHI)[None, :]).min(axis=0)
    assert nearest.min() > cam.follower.roller_radius * (1 - 1e-4)


@pytest.mark.parametrize("cam", CAMS.values(), ids=CAMS)
def test_the_pressure_angle_is_that_between_normal_and_motion(cam):
    """By the power of a unit force along the normal: cos alpha times that of one along the motion."""
    fixed = np.exp(1j * (-1 if cam.clockwise else 1) * PHI)
    moves = np.exp(1j * np.angle(cam.follower.centre(cam.law, PHI, 1)))
    share = np.abs((moves.conj() * fixed * cam.normal(PHI)).real)
    assert np.cos(cam.pressure_angle(PHI)) == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize("cam", FLAT.values(), ids=FLAT)
def test_a_flat_face_touches_the_contour_and_all_of_it_lies_behind(cam):
    """In the direction of the face the contour reaches as far as the face is, and no further."""
    contour, towards = cam.contour(PHI), np.exp(-1j * (-1 if cam.clockwise else 1) * PHI)
    reach = (towards.conj()[:, None] * contour[None, :]).real
    face = cam.follower.distance + cam.law(PHI)
    assert np.diagonal(reach) == pytest.approx(face)
    assert (reach <= face[:, None] + 1e-12).all()
    assert (towards.conj() * contour).imag == pytest.approx(cam.contact(PHI))
    assert cam.normal(PHI) == pytest.approx(towards)


@pytest.mark.parametrize("cam", FLAT.values(), ids=FLAT)
def test_derivatives_and_curvature_of_a_flat_faced_cam(cam):
    for order in (1, 2):
        slope = derivative(lambda p, o=order: cam.contour(p, o - 1), PHI)
        assert np.abs(cam.contour(PHI, order) - slope).max() < 1e-9
    first, second = cam.contour(PHI, 1), cam.contour(PHI, 2)
    sense = 1 if cam.clockwise else -1
    assert cam.curvature(PHI) == pytest.approx(sense * (first.conj() * second).imag / np.abs(first) ** 3)
    assert cam.undercut(PHI) == pytest.approx(cam.radius(PHI) / cam.follower.distance)
    assert (cam.pressure_angle(PHI) == 0).all()


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    st.floats(0.05, 0.2),
    st.floats(0.03, 0.15),
    st.floats(-170, -10),
    st.lists(st.floats(-0.05, 0.05), min_size=2, max_size=6),
    st.booleans(),
)
def test_the_contour_is_at_the_rollers_radius_whatever_the_lever(pivot, arm, angle, coefficients, clockwise):
    law = FourierSeries.of(0.0, coefficients, coefficients[::-1])
    cam = RollerCam(law, OscillatingRoller(pivot=pivot, arm=arm, roller_radius=0.005, angle=math.radians(angle)), clockwise)
    assert np.abs(cam.pitch(PHI) - cam.contour(PHI)) == pytest.approx(np.full(721, 0.005), rel=1e-9)
    # The centre goes round as the cam turns: seen from the frame it is where the lever says.
    seen = cam.pitch(PHI) * np.exp(1j * (-1 if clockwise else 1) * PHI)
    assert seen == pytest.approx(pivot + arm * np.exp(1j * (math.radians(angle) + law(PHI))), abs=1e-12)


PUSHED_ROD = TranslatingRoller(distance=0.06, roller_radius=0.012, offset=0.007)
TURNED_LEVER = OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("outer", [False, True])
@pytest.mark.parametrize("follower", [TURNED_LEVER, PUSHED_ROD], ids=["lever", "rod"])
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
        milled_motion(points, TURNED_LEVER, np.zeros(1), np.zeros(1))
    small = 0.001 * np.exp(-1j * even_angles(100))
    with failed("no-contact"):
        milled_motion(small, TURNED_LEVER, np.zeros(1), np.zeros(1))
