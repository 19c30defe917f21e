"""Cams: contours against the geometry they come from, derivatives against differences, a cam known in closed form."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.shape import Extreme, pressure_angle_remarks
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
PHI = np.linspace(0, TURN, 721)
R, E, ROLLER, PIVOT, ARM = 0.050, 0.012, 0.010, 0.110, 0.090  # m: the eccentric circle of the cases


class EccentricCircle:
    """The lever's angle where the pitch curve is a circle of radius R + ROLLER about E: by the cosine rule."""

    def __init__(self, clockwise=False):
        self.sense = -1 if clockwise else 1

    def __call__(self, phi, order=0):
        if order:
            # Complex steps and their differences: third derivatives to some 1e-6.
            h = 1e-3
            if order == 1:
                return np.imag(self(np.asarray(phi) + 1e-30j)) / 1e-30
            below, above = self(np.asarray(phi) - h, order - 1), self(np.asarray(phi) + h, order - 1)
            return (above - below) / (2 * h)
        x, y = PIVOT - E * np.cos(phi), -self.sense * E * np.sin(phi)
        square = x * x + y * y
        # Of the pivot seen from the circle's centre; the lever turns from there by the angle of the triangle.
        return np.arctan(y / x) + math.pi + np.arccos((square + ARM**2 - (R + ROLLER) ** 2) / (2 * ARM * np.sqrt(square)))


def eccentric(clockwise=False, inner=True):
    follower = OscillatingRoller(pivot=PIVOT, arm=ARM, roller_radius=ROLLER, angle=0.0)
    return RollerCam(EccentricCircle(clockwise), follower, clockwise, not inner)


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


def test_the_eccentric_circle_of_the_cases():
    """At phi = 0; with the sign of the lever's angle that the case has."""
    cam = eccentric()
    theta = cam.law(0.0)
    assert math.degrees(np.mod(theta, TURN) - TURN) == pytest.approx(-143.08681668, abs=1e-8)
    assert cam.law(0.0, 1) == pytest.approx(-0.12244898, abs=1e-8)
    assert cam.law(0.0, 2) == pytest.approx(-0.06621334, abs=1e-6)
    assert abs(math.degrees(cam.pressure_angle(0.0))) == pytest.approx(11.190639, abs=1e-6)
    assert cam.contour(0.0) * 1e3 == pytest.approx(33.70068 - 45.04532j, abs=1e-5)
    assert 1 / cam.pitch_curvature(0.0) == pytest.approx(0.060, rel=1e-6)


@pytest.mark.parametrize("clockwise", [False, True])
def test_an_eccentric_circle_is_what_its_follower_says(clockwise):
    """All the way round, inside and outside of the roller."""
    for inner, radius in ((True, R), (False, R + 2 * ROLLER)):
        cam = eccentric(clockwise, inner)
        assert np.abs(cam.contour(PHI) - E) == pytest.approx(np.full(721, radius), rel=1e-9)
        assert cam.curvature(PHI) == pytest.approx(np.full(721, 1 / radius), rel=1e-5)
        assert cam.undercut(PHI) == pytest.approx(np.full(721, radius / (R + ROLLER)), rel=1e-5)


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


def test_the_pressure_angle_of_a_lever_is_that_of_the_formula():
    """cam-mathematics: tan alpha = (l (1 - s) + d cos theta)/(-d sin theta)."""
    law, follower = lever()
    theta, s = follower.angle + law(PHI), law(PHI, 1)
    formula = (follower.arm * (1 - s) + follower.pivot * np.cos(theta)) / (-follower.pivot * np.sin(theta))
    assert np.abs(np.tan(RollerCam(law, follower).pressure_angle(PHI))) == pytest.approx(np.abs(formula))


def test_the_curvature_of_a_lever_is_that_of_the_formula():
    """cam-mathematics, of the pitch curve."""
    law, follower = lever()
    theta, s, q, d, arm = follower.angle + law(PHI), law(PHI, 1), law(PHI, 2), follower.pivot, follower.arm
    u = d + (1 - s) * arm * np.exp(1j * theta)
    above = d**2 + (1 - s) * (2 - s) * arm * d * np.cos(theta) + (1 - s) ** 3 * arm**2 + arm * d * q * np.sin(theta)
    assert RollerCam(law, follower).pitch_curvature(PHI) == pytest.approx(above / np.abs(u) ** 3)


@pytest.mark.parametrize("of", [lever(), rod()], ids=["lever", "rod"])
def test_a_cam_that_turns_the_other_way_has_the_contour_of_the_motion_backwards(of):
    law, follower = of
    backwards = FourierSeries(law.mean, law.cosine, -law.sine)
    there, back = RollerCam(law, follower), RollerCam(backwards, follower, clockwise=True)
    assert back.contour(-PHI) == pytest.approx(there.contour(PHI))
    assert back.curvature(-PHI) == pytest.approx(there.curvature(PHI))
    assert back.pressure_angle(-PHI) == pytest.approx(there.pressure_angle(PHI))


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


def test_an_undercut_cam_says_so():
    """A roller larger than the least radius of curvature of the pitch curve cuts its own contour away."""
    law, _ = rod()
    sharp = RollerCam(law, TranslatingRoller.model_construct(distance=0.06, roller_radius=0.0))
    least = 1 / sharp.pitch_curvature(PHI).max()
    for share, cut in ((0.99, False), (1.01, True)):
        cam = RollerCam(law, TranslatingRoller(distance=0.06, roller_radius=share * least, offset=0.0))
        assert (cam.undercut(PHI).min() < 0) is np.bool_(cut)
    bent = FourierSeries.of(0.01, [-0.01, 0.005])  # h + h'' = distance + 0.01 - 0.015 cos 2 phi
    for distance, cut in ((0.0051, False), (0.0049, True)):
        assert (FlatFacedCam(bent, FlatFaced(distance=distance)).undercut(PHI).min() < 0) is np.bool_(cut)


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


@pytest.mark.parametrize(("unit", "common"), [("rad", 45), ("m", 30)])
def test_a_pressure_angle_up_to_what_is_common_is_not_told(unit, common):
    """Of all cams the largest one counts, and an angle of the cam is given within a turn."""

    def told(*angles):
        extremes = [Extreme(math.radians(a), math.radians(at)) for a, at in angles]
        return pressure_angle_remarks([SimpleNamespace(pressure_angle=e) for e in extremes], unit)

    assert told((common - 1, 0), (common - 20, 0)) == told((common - 1e-9, 0)) == []
    (text,) = told((common - 20, 10), (common + 5, 400), (common + 1, 20))
    assert (
        text.startswith(f"the pressure angle reaches {common + 5}° at a cam angle of 40°")
        and f"at most {common}° is common" in text
    )
