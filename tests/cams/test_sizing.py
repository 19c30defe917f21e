"""The smallest cams: against brute force, closed forms, and a direct optimisation; angles by the cams themselves."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.refusals import failed, refused

from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam, smallest_flat_faced_cam
from wucht.cams.followers.oscillating_roller import OscillatingRoller, smallest_lever_cam
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller, smallest_rod_cam
from wucht.cams.laws.standard_laws import STANDARD_LAWS, RiseAndReturn
from wucht.cams.sizing import smallest_cam
from wucht.cams.sizing.layout import Layout
from wucht.cams.sizing.smallest_cam import _Rays
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
PHI = np.arange(1440) * (TURN / 1440)
FEW = PHI[::8]
SWING = FourierSeries.of(math.radians(12), np.radians([-12.5, 0.8, -0.4]), np.radians([0.7, 0.3]))
LIFT = FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008])
DWELLS = RiseAndReturn(STANDARD_LAWS["modified-sine"], math.radians(24), (0.0, 1.5), (2.5, 5.0))
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
@pytest.mark.parametrize("law", [SWING, DWELLS], ids=["harmonic", "dwells"])
@pytest.mark.parametrize(
    ("outward", "clockwise"),
    [(True, False), (False, True), *(pytest.param(same, same, marks=pytest.mark.slow) for same in (True, False))],
)
def test_no_lever_has_a_smaller_base_circle(law, outward, clockwise):
    """The angle permitted is reached, and no more; whatever pivot and angle of a grid have a smaller base circle exceed it."""
    found = smallest_lever_cam(law, ARM, ROLLER, 30 * DEG, clockwise=clockwise, outward=outward)
    cam = RollerCam(law, found.follower, clockwise)
    assert found.pressure_angle == pytest.approx(30 * DEG, abs=1e-9)
    assert steepest(cam) == pytest.approx(30 * DEG, abs=1e-4)
    assert np.abs(cam.pressure_angle(np.array(found.binding))) == pytest.approx(np.full(len(found.binding), 30 * DEG), abs=1e-9)
    assert len(found.binding) in (1, 2)
    radii = np.abs(cam.pitch(PHI))
    assert (radii.min(), radii.max()) == pytest.approx((found.base_radius, found.largest_radius), rel=1e-5)
    assert (np.sin(found.follower.angle + law(PHI)) * (-1 if outward else 1) > 0).all()
    smallest, sense, swing = math.inf, -1 if outward else 1, law(FEW)
    for angle in np.linspace(0.02, math.pi, 60):
        if not (np.sin(sense * angle + swing) * sense > 0).all():
            continue
        for pivot in np.linspace(0.06, 0.14, 33):
            other = RollerCam(law, found.follower.model_copy(update={"pivot": pivot, "angle": sense * angle}), clockwise)
            radius = base(other, FEW)
            if radius < smallest and steepest(other, FEW) <= 30 * DEG:
                smallest = radius
    assert found.base_radius * (1 - 1e-3) < smallest < found.base_radius * 1.3


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-6, 1e-4, 3e-3])
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
    """Just above there is a cam; just below there is none, not even one a thousand times as large as its lever."""
    low, high = SWING.bounds
    half = (high - low) / 2
    found = smallest_lever_cam(SWING, ARM, ROLLER, 1.01 * half, outward=outward)
    assert steepest(RollerCam(SWING, found.follower)) <= 1.01 * half + 1e-9
    for angle in (0.99 * half, (0.99 * half, 1.0)):
        with refused("pressure_angle", given="12.8034 deg") as error:
            smallest_lever_cam(SWING, ARM, ROLLER, angle, outward=outward)
    told = float(re.search(r"greater than (\S+) deg", str(error.value)).group(1)) * DEG
    assert told == pytest.approx(half, rel=1e-5)
    sense = -1 if outward else 1
    tried, swing = 0, SWING(FEW[::4])
    for angle in np.linspace(0, math.pi, 120):
        if not (np.sin(sense * angle + swing) * sense > 0).all():
            continue
        for pivot in ARM * np.geomspace(0.3, 1000, 40):
            cam = RollerCam(SWING, OscillatingRoller(pivot=pivot, arm=ARM, roller_radius=ROLLER, angle=sense * angle))
            assert steepest(cam, FEW[::4]) > 0.99 * half
            tried += 1
    assert tried > 1000


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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("permitted", "least", "size"),
    [
        (45, 0.05, "base"),
        (40, 0.02, "blank"),
        *(
            pytest.param(*more, marks=pytest.mark.slow)
            for more in ((45, 0.05, "blank"), (40, 0.02, "base"), (35, 0.022, "base"), (35, 0.022, "blank"))
        ),
    ],
)
def test_no_lever_with_that_curvature_is_smaller(permitted, least, size):
    """A grid of centres: those that keep both and have the smallest circle have none smaller than that found."""
    found = smallest_lever_cam(SWING, ARM, ROLLER, permitted * DEG, least_radius=least, size=size)
    cam = RollerCam(SWING, found.follower)
    assert found.least_radius == pytest.approx(sharpest(cam), rel=1e-4)
    assert found.least_radius >= least * (1 - 1e-7)
    assert found.pressure_angle <= permitted * DEG + 1e-9
    assert found.least_radius == pytest.approx(least, rel=1e-6)  # it binds: without it the cam is smaller
    free = smallest_lever_cam(SWING, ARM, ROLLER, permitted * DEG, size=size)
    assert free.least_radius < least
    best, mine = math.inf, found.base_radius if size == "base" else found.largest_radius
    for pivot in np.linspace(0.05, 0.15, 41):
        for angle in np.linspace(-math.pi, -1.5, 41):
            other = RollerCam(SWING, found.follower.model_copy(update={"pivot": pivot, "angle": angle}))
            radii = np.abs(other.pitch(FEW))
            radius = radii.min() if size == "base" else radii.max()
            if radius < best and steepest(other, FEW) <= permitted * DEG and sharpest(other, FEW) >= least:
                best = radius
    assert mine * (1 - 1e-3) < best < mine * 1.1


@pytest.mark.slow
def test_no_undercut_when_none_is_permitted():
    """A least radius of 0; with a roller too large for the cam that the pressure angle alone would make."""
    free = smallest_rod_cam(LIFT, 0.03, 50 * DEG)
    assert free.least_radius < 0
    assert RollerCam(LIFT, free.follower).undercut(PHI).min() < 0
    kept = smallest_rod_cam(LIFT, 0.03, 50 * DEG, least_radius=0.0)
    assert kept.base_radius > free.base_radius
    assert RollerCam(LIFT, kept.follower).undercut(PHI).min() == pytest.approx(0, abs=1e-4)
    assert kept.least_radius == pytest.approx(0, abs=1e-9)


def test_a_radius_that_is_kept_anyway_changes_nothing():
    free = smallest_lever_cam(SWING, ARM, ROLLER, 30 * DEG)
    assert smallest_lever_cam(SWING, ARM, ROLLER, 30 * DEG, least_radius=0.99 * free.least_radius) == free
    bound = smallest_lever_cam(SWING, ARM, ROLLER, 30 * DEG, least_radius=1.01 * free.least_radius)
    assert bound.base_radius > free.base_radius


def test_lengths_scale_and_the_way_the_cam_turns_is_the_motion_backwards():
    here = smallest_lever_cam(SWING, ARM, ROLLER, 30 * DEG)
    there = smallest_lever_cam(SWING, 1e3 * ARM, 1e3 * ROLLER, 30 * DEG)
    assert there.follower.pivot == pytest.approx(1e3 * here.follower.pivot, rel=1e-9)
    assert there.base_radius == pytest.approx(1e3 * here.base_radius, rel=1e-9)
    assert there.follower.angle == pytest.approx(here.follower.angle, abs=1e-9)
    back = FourierSeries(SWING.mean, SWING.cosine, -SWING.sine)
    assert smallest_lever_cam(back, ARM, ROLLER, 30 * DEG, clockwise=True).follower.angle == pytest.approx(here.follower.angle)
    turned = FourierSeries(SWING.mean + 3.0, SWING.cosine, SWING.sine)  # the zero of the law is nobody's business
    assert smallest_lever_cam(turned, ARM, ROLLER, 30 * DEG).base_radius == pytest.approx(here.base_radius, rel=1e-9)


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


def test_a_flat_faced_cam_goes_round_its_shaft():
    """A law of one harmonic leaves the radius of curvature at the distance: the shaft needs more."""
    law = FourierSeries.of(0.0, [0.03])
    assert smallest_flat_faced_cam(law, 0.005).base_radius == pytest.approx(0, abs=1e-12)
    shaft = smallest_flat_faced_cam(law, 0.005, shaft_radius=0.012)
    assert (shaft.base_radius, shaft.follower.distance) == pytest.approx((0.012, 0.042))
    assert smallest_flat_faced_cam(law, 0.05, shaft_radius=0.012).follower.distance == pytest.approx(0.05)


def test_a_flat_face_has_a_distance_even_where_its_law_is_never_zero():
    found = smallest_flat_faced_cam(FourierSeries.of(0.020, [0.012]), 0.002)
    assert found.follower.distance == pytest.approx(1e-6)
    assert found.base_radius == pytest.approx(0.008001)


def test_the_pitch_curve_of_a_rod_cam_clears_the_shaft_by_the_roller(monkeypatch):
    bases = []

    def centre_around_shaft(layout, centre, base, centre_for):
        bases.append(base)
        return centre

    monkeypatch.setattr(smallest_cam, "_centre_around_shaft", centre_around_shaft)
    law = FourierSeries.of(0.015, [-0.015])
    assert smallest_rod_cam(law, ROLLER, 60 * DEG, least_radius=0.0, shaft_radius=0.012).base_radius < ROLLER + 0.012
    assert bases == pytest.approx([ROLLER + 0.012])


@pytest.mark.slow
@pytest.mark.parametrize("size", ["base", pytest.param("blank", marks=pytest.mark.slow)])
def test_a_rod_cam_goes_round_its_shaft(size):
    """In harmonic motion D = roller + shaft, and sin alpha = (h/2)/(D + h/2) is the least pressure angle there is."""
    law = FourierSeries.of(0.015, [-0.015])
    free = smallest_rod_cam(law, ROLLER, 60 * DEG, least_radius=0.0, size=size)
    assert free.base_radius < ROLLER, "the shaft would lie outside of the cam"
    found = smallest_rod_cam(law, ROLLER, 60 * DEG, least_radius=0.0, shaft_radius=0.012, size=size)
    assert found.base_radius == pytest.approx(ROLLER + 0.012, rel=1e-6)
    assert found.base_radius >= ROLLER + 0.012
    assert math.sin(found.pressure_angle) == pytest.approx(0.015 / (ROLLER + 0.012 + 0.015), rel=1e-6)
    never_zero = smallest_rod_cam(FourierSeries.of(0.045, [-0.015]), ROLLER, 60 * DEG, shaft_radius=0.0, size=size)
    assert never_zero.follower.distance == pytest.approx(1e-6, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("outward", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_lever_cam_goes_round_its_shaft(outward):
    """Its base circle is the shaft's, with the pressure angle from which on a smaller one would do."""
    found = smallest_lever_cam(SWING, ARM, ROLLER, 45 * DEG, outward=outward, shaft_radius=0.02)
    assert found.base_radius == pytest.approx(ROLLER + 0.02, rel=1e-6)
    assert found.pressure_angle < 45 * DEG
    again = smallest_lever_cam(SWING, ARM, ROLLER, found.pressure_angle, outward=outward)
    assert again.base_radius == pytest.approx(found.base_radius, rel=1e-6)
    free = smallest_lever_cam(SWING, ARM, ROLLER, 45 * DEG, outward=outward)
    assert free.base_radius < found.base_radius


@pytest.mark.slow
def test_a_shaft_beyond_all_bounds_is_refused():
    with failed("no-cam"):
        smallest_lever_cam(SWING, ARM, ROLLER, 45 * DEG, shaft_radius=1e9)


@pytest.mark.parametrize(
    ("make", "refusal"),
    [
        (lambda: smallest_lever_cam(SWING, 0.0, 0.01, 0.5), refused("arm", given=0.0)),
        (lambda: smallest_lever_cam(SWING, 0.1, -0.01, 0.5), refused("roller_radius", given=-0.01)),
        (lambda: smallest_rod_cam(LIFT, 0.01, 0.0), refused("pressure_angle", "89 deg", given=0.0)),
        (lambda: smallest_rod_cam(LIFT, 0.01, (0.5, 1.56)), refused("pressure_angle", given=1.56)),
        (lambda: smallest_rod_cam(LIFT, 0.01, math.nan), refused("pressure_angle", given=float("nan"))),
        (lambda: smallest_rod_cam(FourierSeries.of(0.01), 0.01, 0.5), refused("law", given=None)),
        (lambda: smallest_rod_cam(LIFT, 0.0, 0.5, least_radius=0.0), refused("least_radius", given=0.0)),
        (lambda: smallest_flat_faced_cam(LIFT, -0.1), refused("least_radius", given=-0.1)),
        (lambda: smallest_flat_faced_cam(LIFT, 0.1, shaft_radius=math.inf), refused("shaft_radius", given=float("inf"))),
    ],
)
def test_bad_input_is_refused_by_its_sentence(make, refusal):
    with refusal:
        make()


@pytest.mark.parametrize(
    ("bent", "expected"),
    [(-1.0, 2.0), (2.0, 2.0), (2.03, 2.03), (3.123, 3.123), (9.9, 9.9), (11.0, math.inf)],
)
def test_the_first_distance_on_a_ray_at_which_no_curvature_is_too_sharp(bent, expected):
    """From 2 to 10 the pressure angles allow it, and from ``bent`` on the curvature; found as exactly as it is halved."""

    class Rays(_Rays):
        free_distance = 10.0

        def worst(self, ray, at):
            return np.where(at < bent, 2.0, 1.0) * self.most

    ahead = np.array([-1.0 + 0j])  # so that a distance along the ray is at least 2
    rays = Rays(0j, 5.0, np.zeros(1, complex), np.ones(1, complex), ahead, np.array([-2.0]))
    assert rays.feasible_distance(0.0) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("clockwise", [True, False])
def test_the_outline_of_a_flat_face_holds_where_it_is_touched(clockwise):
    """The contact is at -psi'(phi) along the face of a cam that turns anticlockwise, at psi' of one that turns clockwise."""
    outline = FlatFaced(distance=0.05, clockwise=clockwise).outline(LIFT)
    touched = (1 if clockwise else -1) * LIFT(np.linspace(0, TURN, 721), 1)
    assert (outline.face_from, outline.face_to) == (touched.min(), touched.max())
    assert abs(outline.face_from + outline.face_to) > 1e-4


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("inward", [1, -1])
def test_cones_are_narrower_on_the_way_that_permits_less_and_at_rest(inward, clockwise):
    """A lever that comes in as its law rises, or goes out: 20 deg are permitted outwards, 40 deg inwards, both in a dwell."""
    guide = OscillatingRoller.model_construct(pivot=0.0, arm=ARM, roller_radius=ROLLER, angle=0.0)
    layout = Layout(DWELLS, guide, clockwise, inward, (math.tan(20 * DEG), math.tan(40 * DEG)))
    rising, dwelling, returning = layout.cones(np.array([0.7, 2.0, 3.7]))[2]
    out, back = (returning, rising) if inward > 0 else (rising, returning)
    assert np.degrees(np.arctan([out, dwelling, back])) == pytest.approx([20.0, 20.0, 40.0])
    inner, outer = (ARM * np.exp(1j * value) for value in ((24 * DEG, 0.0) if inward > 0 else (0.0, 24 * DEG)))
    assert layout.ends == (pytest.approx(inner), pytest.approx(outer))
