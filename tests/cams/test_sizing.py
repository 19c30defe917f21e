"""The smallest cams: against brute force, closed forms, and a direct optimisation; angles by the cams themselves."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.refusals import failed, refused

from wucht.cams.followers.flat_faced import FlatFacedCam, smallest_flat_faced_cam
from wucht.cams.followers.oscillating_roller import OscillatingRoller, smallest_lever_cam
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller, smallest_rod_cam
from wucht.cams.sizing.size_limits import CamLimits
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
PHI = np.arange(1440) * (TURN / 1440)
SWING = FourierSeries.of(math.radians(12), np.radians([-12.5, 0.8, -0.4]), np.radians([0.7, 0.3]))
LIFT = FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008])
ARM, ROLLER = 0.09, 0.01
DEG = math.pi / 180


def steepest(cam, phi=PHI):
    return float(np.abs(cam.pressure_angle(phi)).max())


def base(cam, phi=PHI):
    return float(np.abs(cam.pitch(phi)).min())


def sharpest(cam, phi=PHI):
    """The least convex radius of the contour."""
    return 1 / float(np.maximum(cam.pitch_curvature(phi), 1e-9).max()) - cam.follower.roller_radius


def moved(follower, by):
    """The same follower with the cam's centre elsewhere, by a vector in the follower's own frame."""
    if isinstance(follower, TranslatingRoller):
        return follower.model_copy(update={"distance": follower.distance - by.real, "offset": follower.offset - by.imag})
    centre = -follower.pivot * np.exp(-1j * follower.angle) + by
    return follower.model_copy(update={"pivot": abs(centre), "angle": math.pi - float(np.angle(centre))})


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-4, 3e-3])
@pytest.mark.parametrize("kind", ["lever", "lever, blank", "rod", "lever, radius", "rod, radius"])
def test_nothing_near_by_is_smaller(kind, step):
    """The cam's centre moved by any small vector: it is no smaller, or breaks what is permitted."""
    least = 0.02 if "radius" in kind else None
    size = "blank" if "blank" in kind else "base"
    if "lever" in kind:
        found, law = smallest_lever_cam(SWING, ARM, ROLLER, 40 * DEG, least_radius=least, size=size), SWING
    else:
        found, law = smallest_rod_cam(LIFT, ROLLER, 40 * DEG, least_radius=least, size=size), LIFT
    fine = np.concatenate([PHI, found.binding, [found.sharpest]])
    measure = (lambda cam: np.abs(cam.pitch(fine)).max()) if size == "blank" else (lambda cam: base(cam, fine))
    here = measure(RollerCam(law, found.follower))
    smaller = 0
    for turned in np.exp(1j * np.linspace(0, TURN, 48, endpoint=False)):
        cam = RollerCam(law, moved(found.follower, step * turned))
        if measure(cam) < here - 0.02 * step:
            smaller += 1
            broken = max(steepest(cam, fine) - 40 * DEG, least - sharpest(cam, fine) if least else 0)
            assert broken > 0
    assert smaller > 10


def test_the_smallest_blank_is_not_the_smallest_base_circle():
    """Where the curvature binds the two differ, each is the better by its own measure."""
    base_best, blank = (smallest_lever_cam(SWING, ARM, ROLLER, 0.8, least_radius=0.05, size=s) for s in ("base", "blank"))
    assert base_best.base_radius < 0.99 * blank.base_radius
    assert blank.largest_radius < 0.99 * base_best.largest_radius


@pytest.mark.parametrize("outward", [True, False])
def test_two_permitted_angles_hold_each_on_its_own_way(outward):
    """As the roller goes out 25 deg, as it comes in 45; one of them for both makes the cam larger, the other smaller."""
    found = smallest_lever_cam(SWING, ARM, ROLLER, (25 * DEG, 45 * DEG), outward=outward)
    cam = RollerCam(SWING, found.follower)
    out = SWING(PHI, 1) * (1 if outward else -1) > 0
    goes_out = np.gradient(np.abs(cam.pitch(PHI))) > 0
    assert (out == goes_out).mean() > 0.99
    angles = np.abs(cam.pressure_angle(PHI))
    assert angles[out].max() == pytest.approx(25 * DEG, abs=1e-4)
    assert 26 * DEG < angles[~out].max() < 45 * DEG + 1e-9
    assert not outward or angles[~out].max() == pytest.approx(45 * DEG, abs=1e-4)
    strict, loose = (smallest_lever_cam(SWING, ARM, ROLLER, a * DEG, outward=outward) for a in (25, 45))
    assert loose.base_radius < found.base_radius < strict.base_radius


@pytest.mark.parametrize("outward", [True, False])
def test_half_the_swing_is_the_least_pressure_angle(outward):
    """Just above there is a cam; just below there is none."""
    low, high = SWING.bounds
    half = (high - low) / 2
    found = smallest_lever_cam(SWING, ARM, ROLLER, 1.01 * half, outward=outward)
    assert steepest(RollerCam(SWING, found.follower)) <= 1.01 * half + 1e-9
    for angle in (0.99 * half, (0.99 * half, 1.0)):
        with refused("pressure_angle", given="12.8034 deg") as error:
            smallest_lever_cam(SWING, ARM, ROLLER, angle, outward=outward)
    told = float(re.search(r"greater than (\S+) deg", str(error.value)).group(1)) * DEG
    assert told == pytest.approx(half, rel=1e-5)


def test_a_rod_in_harmonic_motion_by_closed_form():
    """s = h/2 (1 - cos phi). One angle for both ways: no offset, D = h/2 (1/sin alpha - 1). For a out and b in, the two
    tangents to the circle of (s, s') meet at D = h/2 ((1/cos a + 1/cos b)/(tan a + tan b) - 1), e = (D + h/2) tan a -
    h/2/cos a.
    """
    h, law = 0.03, FourierSeries.of(0.015, [-0.015])
    one = smallest_rod_cam(law, ROLLER, 30 * DEG)
    assert one.follower.distance == pytest.approx(h / 2 * (1 / math.sin(30 * DEG) - 1), rel=1e-9)
    assert one.follower.offset == pytest.approx(0, abs=1e-11)
    a, b = 30 * DEG, 45 * DEG
    for clockwise in (False, True):
        two = smallest_rod_cam(law, ROLLER, (a, b), clockwise=clockwise)
        distance = h / 2 * ((1 / math.cos(a) + 1 / math.cos(b)) / (math.tan(a) + math.tan(b)) - 1)
        offset = (distance + h / 2) * math.tan(a) - h / 2 / math.cos(a)
        assert two.follower.distance == pytest.approx(distance, rel=1e-9)
        assert two.follower.offset == pytest.approx(-offset if clockwise else offset, rel=1e-9)
        assert two.base_radius == pytest.approx(math.hypot(distance, offset), rel=1e-9)


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("angles", [(30 * DEG, 30 * DEG), (25 * DEG, 50 * DEG)])
def test_a_rod_against_a_direct_optimisation(angles, clockwise):
    """tan alpha = (s' + e)/(D + s), at many angles, given to SciPy."""
    found = smallest_rod_cam(LIFT, ROLLER, angles, clockwise=clockwise)
    s, v = LIFT(PHI), LIFT(PHI, 1) * (-1 if clockwise else 1)
    tangent = np.where(LIFT(PHI, 1) > 0, *np.tan(angles))

    def room(x):
        return np.concatenate([tangent * (x[0] + s / 0.1) - sign * (v / 0.1 + x[1]) for sign in (1, -1)])

    low = LIFT.bounds[0] / 0.1
    direct = minimize(
        lambda x: np.hypot(x[0] + low, x[1]), [1.0, 0.0], method="SLSQP", constraints={"type": "ineq", "fun": room},
        options={"ftol": 1e-13, "maxiter": 500},
    )  # fmt: skip
    assert found.base_radius == pytest.approx(0.1 * direct.fun, rel=1e-4)
    assert (found.follower.distance, found.follower.offset) == pytest.approx(tuple(0.1 * direct.x), abs=1e-5)


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_flat_face_by_closed_form(clockwise):
    """psi + psi'' = 0.01 - 0.003 cos 2 phi for 0.01 - 0.011 cos phi + 0.001 cos 2 phi: least 0.007."""
    law = FourierSeries.of(0.01, [-0.011, 0.001])
    found = smallest_flat_faced_cam(law, 0.02, clockwise=clockwise)
    assert found.follower.distance == pytest.approx(0.013, abs=1e-12)
    assert found.least_radius == pytest.approx(0.02, abs=1e-12)
    cam = FlatFacedCam(law, found.follower, clockwise)
    assert cam.radius(PHI).min() == pytest.approx(0.02, abs=1e-9)
    assert cam.radius(np.array(found.sharpest)) == pytest.approx(0.02, abs=1e-12)
    radii = np.abs(cam.contour(PHI))
    assert (radii.min(), radii.max()) == pytest.approx((found.base_radius, found.largest_radius), rel=1e-9)
    touched = (cam.contour(PHI) * np.exp(1j * (-1 if clockwise else 1) * PHI)).imag
    assert (touched.min(), touched.max()) == pytest.approx(found.face, rel=1e-4)


def test_a_flat_face_has_a_distance_even_where_its_law_is_never_zero():
    found = smallest_flat_faced_cam(FourierSeries.of(0.020, [0.012]), 0.002)
    assert found.follower.distance == pytest.approx(1e-6)
    assert found.base_radius == pytest.approx(0.008001)


def test_a_rod_cam_goes_round_its_shaft():
    """In harmonic motion D = roller + shaft, and sin alpha = (h/2)/(D + h/2) is the least pressure angle there is."""
    law = FourierSeries.of(0.015, [-0.015])
    free = smallest_rod_cam(law, ROLLER, 60 * DEG, least_radius=0.0)
    assert free.base_radius < ROLLER, "the shaft would lie outside of the cam"
    found = smallest_rod_cam(law, ROLLER, 60 * DEG, least_radius=0.0, shaft_radius=0.012)
    assert found.base_radius == pytest.approx(ROLLER + 0.012, rel=1e-6)
    assert found.base_radius >= ROLLER + 0.012
    assert math.sin(found.pressure_angle) == pytest.approx(0.015 / (ROLLER + 0.012 + 0.015), rel=1e-6)


def test_a_shaft_beyond_all_bounds_is_refused():
    with failed("no-cam"):
        smallest_lever_cam(SWING, ARM, ROLLER, 45 * DEG, shaft_radius=1e9)


@pytest.mark.parametrize(("angle", "outward"), [(-0.1, False), (3.0, True)])
def test_the_roller_goes_out_where_the_lever_is_on_the_far_side_as_its_law_begins(angle, outward):
    """Between -180 and 0 deg, its law being 0.3 rad there."""
    law = FourierSeries.of(0.4, [-0.1])
    follower = OscillatingRoller(pivot=0.11, arm=ARM, roller_radius=ROLLER, angle=angle)
    found = follower.smallest_cam(law, CamLimits(pressure_angle=0.5), "base")
    assert (np.sin(found.follower.angle + law(PHI)) * (-1 if outward else 1) > 0).all()
    assert follower.smallest_cam(law, CamLimits(least_radius=0.003), "base") is None


def test_a_cam_that_cannot_be_sized_is_refused():
    for make, key in (
        (lambda: smallest_lever_cam(SWING, 0.0, 0.01, 0.5), "arm"),
        (lambda: smallest_rod_cam(LIFT, 0.01, 1.56), "pressure_angle"),
        (lambda: smallest_rod_cam(FourierSeries.of(0.01), 0.01, 0.5), "law"),
        (lambda: smallest_flat_faced_cam(LIFT, -0.1), "least_radius"),
    ):  # fmt: skip
        with refused(key):
            make()
