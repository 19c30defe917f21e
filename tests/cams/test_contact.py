"""What presses on a cam: against virtual work, energy, an eccentric circle, and Hertz by hand."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.refusals import refused

from wucht.cams.contact import (
    FollowerLoad,
    Material,
    conjugate_forces,
    contact_forces,
    contact_pressure,
    hertz_pressure,
)
from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller, conjugate_cams
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.linkages.closure import LeverMotion
from wucht.cams.linkages.four_bar_and_slider_crank import FourBar, SliderCrank
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
PHI = np.linspace(0, TURN, 1441)
ANGLE = FourierSeries.of(math.radians(12), np.radians([-12.5, 0.8, -0.4]), np.radians([0.7, 0.3]))
LIFT = FourierSeries.of(0.01, [-0.011, 0.001], [0.0005, 0.0008])
OMEGA = FourierSeries.of(52.0, [1.0, 4.0], [0.5, -3.0])
STEEL = Material(210e9, 0.3)
LEVER_LOAD = FollowerLoad(inertia=0.04, stiffness=30.0, preload=25.0, damping=0.2, constant=3.0)
ROD_LOAD = FollowerLoad(inertia=6.0, stiffness=1e3, preload=200.0, damping=30.0, constant=14.7)
OUT, IN = (
    OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143)),
    OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(122)),
)
CAMS = {
    "lever": (RollerCam(ANGLE, OUT), LEVER_LOAD),
    "lever, clockwise": (RollerCam(ANGLE, OUT, True), LEVER_LOAD),
    "lever inwards": (RollerCam(ANGLE, IN), LEVER_LOAD),
    "lever, outer": (RollerCam(ANGLE, OUT, False, True), LEVER_LOAD),
    "rod": (RollerCam(LIFT, TranslatingRoller(distance=0.06, roller_radius=0.012, offset=0.007)), ROD_LOAD),
    "rod, clockwise": (RollerCam(LIFT, TranslatingRoller(distance=0.06, roller_radius=0.012, offset=0.007), True), ROD_LOAD),
    "flat": (FlatFacedCam(LIFT, FlatFaced(distance=0.08)), ROD_LOAD),
    "flat, clockwise": (FlatFacedCam(LIFT, FlatFaced(distance=0.08), True), ROD_LOAD),
}
EACH = pytest.mark.parametrize(("cam", "load"), CAMS.values(), ids=CAMS)


def energy(cam, load, omega, phi):
    return load.inertia * (cam.law(phi, 1) * omega(phi)) ** 2 / 2 + load.stiffness * cam.law(phi) ** 2 / 2


def side(cam):
    """In which sense of the law the cam pushes: known from how these cams are built."""
    inward = cam.follower is IN
    return -1 if inward or getattr(cam, "outer", False) else 1


@EACH
def test_the_shaft_pays_for_what_the_follower_stores_and_loses(cam, load):
    """Power balance: T omega = dE/dt + D psidot^2 + (constant + preload) psidot, while the speed varies."""
    stored = (energy(cam, load, OMEGA, PHI + 1e-5) - energy(cam, load, OMEGA, PHI - 1e-5)) / 2e-5
    lost = load.damping * cam.law(PHI, 1) ** 2 * OMEGA(PHI) + (load.constant + side(cam) * load.preload) * cam.law(PHI, 1)
    found = contact_forces(cam, load, OMEGA, PHI)
    assert found.torque == pytest.approx(stored + lost, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize(
    "linkage",
    [FourBar(0.3, 0.1, 0.28, 0.12, math.radians(80)), SliderCrank(0.25, 0.6, math.radians(105))],
    ids=["turns", "slides"],
)
def test_the_shaft_pays_for_what_moves_behind_a_linkage(linkage):
    """Power balance with the energy of the output J1 (psi' omega)^2/2 besides that of the lever, while the speed varies."""
    output = FourierSeries.of(0.02, [-0.05, 0.02], [0.01])
    cam = RollerCam(LeverMotion(output, linkage), OUT)
    load = FollowerLoad(inertia=0.04, preload=25.0, output_inertia=1.5)

    def stored(phi):
        return sum(J * (law(phi, 1) * OMEGA(phi)) ** 2 / 2 for J, law in ((0.04, cam.law), (1.5, output)))

    slope = (stored(PHI + 1e-5) - stored(PHI - 1e-5)) / 2e-5
    expected = slope + side(cam) * load.preload * cam.law(PHI, 1)
    assert contact_forces(cam, load, OMEGA, PHI).torque == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


@EACH
def test_torque_is_force_times_the_lever_of_the_normal(cam, load):
    """The moment of the contact force about the cam's centre, at the contact point."""
    found = contact_forces(cam, load, OMEGA, PHI)
    on_follower = found.force * cam.normal(PHI) * (-1 if getattr(cam, "outer", False) else 1)
    moment = (cam.contour(PHI).conj() * on_follower).imag * (-1 if cam.clockwise else 1)
    assert found.torque == pytest.approx(moment, rel=1e-9, abs=1e-9 * np.abs(moment).max())


@EACH
def test_the_contact_force_has_the_moment_of_its_direction(cam, load):
    """l cos alpha on a lever, cos alpha on a rod, 1 on a face; the equation of motion by hand, at constant speed."""
    w, s, v, q = 40.0, cam.law(PHI), cam.law(PHI, 1), cam.law(PHI, 2)
    effort = load.inertia * q * w**2 + load.damping * v * w + load.stiffness * s + load.constant + side(cam) * load.preload
    lever = getattr(cam.follower, "arm", 1.0) * np.cos(cam.pressure_angle(PHI))
    found = contact_forces(cam, load, w, PHI)
    assert found.effort == pytest.approx(effort)
    assert found.force == pytest.approx(side(cam) * effort / lever)
    assert np.abs(cam.grip(PHI)) == pytest.approx(lever)


def test_the_force_on_a_flat_face_acts_where_it_is_touched():
    cam, load = CAMS["flat, clockwise"]
    found = contact_forces(cam, load, 40.0, PHI)
    assert np.abs(found.torque) == pytest.approx(found.force * np.abs(cam.contact(PHI)))


def test_a_spring_presses_on_the_eccentric_circle():
    """Of the cases: the arm is 90 mm and the pressure angle 11.190639 deg at phi = 0, s' = -0.12244898."""
    theta, s = math.radians(-143.08681668), -0.12244898
    cam = RollerCam(
        FourierSeries.of(0.0, [0.0], [s]), OscillatingRoller(pivot=0.110, arm=0.090, roller_radius=0.010, angle=theta)
    )
    found = contact_forces(cam, FollowerLoad(1.0, preload=10.0), 0.0, np.zeros(1))
    assert found.force == pytest.approx(10 / (0.090 * math.cos(math.radians(11.190639))), rel=1e-7)
    assert found.torque == pytest.approx(10 * s)
    # The normal passes through the circle's centre, 12 mm from the shaft towards the pivot.
    centre, contact = 0.012, 0.110 + 0.090 * np.exp(1j * theta)
    arm = abs((np.conj(centre) * (contact - centre) / abs(contact - centre)).imag)
    assert abs(found.torque[0]) == pytest.approx(found.force[0] * arm, rel=1e-6)


@EACH
def test_the_preload_that_keeps_contact_is_exact(cam, load):
    """Just above it the force is positive all the way round, just below it is not, and the arcs are where it is not."""
    bare = FollowerLoad(load.inertia, load.stiffness, 0.0, load.damping, load.constant)
    needed = contact_forces(cam, bare, OMEGA, PHI).least_preload
    assert needed > 0
    for share, kept in ((1.0001, True), (0.9999, False), (0.5, False)):
        preloaded = FollowerLoad(bare.inertia, bare.stiffness, share * needed, bare.damping, bare.constant)
        found = contact_forces(cam, preloaded, OMEGA, PHI)
        assert (found.lift_off == ()) is kept
        assert found.least_preload == pytest.approx(needed, rel=1e-12)
        off = np.any([np.mod(PHI - b, TURN) < e - b for b, e in found.lift_off] or [np.zeros(len(PHI), bool)], axis=0)
        assert (off == (found.force < 0)).all()
    ends = contact_forces(cam, preloaded, OMEGA, np.array(found.lift_off).ravel()).force
    assert np.abs(ends).max() < 1e-9 * np.abs(found.force).max()


def test_a_follower_that_is_pressed_enough_needs_no_preload():
    assert contact_forces(CAMS["rod"][0], FollowerLoad(1.0, constant=1e6), 10.0, PHI).least_preload == 0


def test_a_varying_speed_may_be_samples_or_a_function():
    """And its acceleration is that of the motion over time: psi(t) from the angle over time, differenced twice."""
    cam, load = CAMS["lever"]
    samples = OMEGA(np.arange(64) * TURN / 64)
    by_function, by_samples = (contact_forces(cam, load, speed, PHI).force for speed in (OMEGA, samples))
    assert by_samples == pytest.approx(by_function, rel=1e-9)
    # t(phi) = integral of dphi/omega, by Simpson's rule over a small step to both sides.
    h = 2e-4
    dt = [h / 6 * (1 / OMEGA(PHI) + 4 / OMEGA(PHI + sign * h / 2) + 1 / OMEGA(PHI + sign * h)) for sign in (1, -1)]
    ahead, behind = (ANGLE(PHI + sign * h) - ANGLE(PHI) for sign in (1, -1))
    acceleration = 2 * (ahead / dt[0] + behind / dt[1]) / (dt[0] + dt[1])
    inertia = contact_forces(cam, FollowerLoad(2.0), OMEGA, PHI).effort
    assert inertia == pytest.approx(2 * acceleration, abs=1e-3 * np.abs(inertia).max())


def test_a_cam_that_turns_the_other_way_has_the_forces_of_the_motion_backwards():
    back = FourierSeries(ANGLE.mean, ANGLE.cosine, -ANGLE.sine)
    load = FollowerLoad(0.04, 30.0, 25.0)
    here, there = (
        contact_forces(RollerCam(ANGLE, OUT), load, 50.0, PHI),
        contact_forces(RollerCam(back, OUT, True), load, 50.0, -PHI),
    )
    assert there.force == pytest.approx(here.force)
    assert there.torque == pytest.approx(-here.torque)


def test_units_of_time_and_length():
    """Twice as fast with springs four times as stiff: forces four times as large. In millimetres: the same force."""
    cam = CAMS["rod"][0]
    base = contact_forces(cam, FollowerLoad(1.5, 4e3, 200.0), 40.0, PHI)
    fast = contact_forces(cam, FollowerLoad(1.5, 16e3, 800.0), 80.0, PHI)
    assert fast.force == pytest.approx(4 * base.force)
    large = FourierSeries(1e3 * LIFT.mean, 1e3 * LIFT.cosine, 1e3 * LIFT.sine)
    there = contact_forces(
        RollerCam(large, TranslatingRoller(distance=60.0, roller_radius=12.0, offset=7.0)),
        FollowerLoad(1.5e-3, 4.0, 200.0),
        40.0,
        PHI,
    )
    assert there.force == pytest.approx(base.force)
    assert there.torque == pytest.approx(1e3 * base.torque)


CAM, COUNTER = PAIR = conjugate_cams(
    ANGLE, OUT, OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.012, angle=math.radians(122))
)


@pytest.mark.parametrize("share", [0.3, 0.5])
@pytest.mark.parametrize("preload", [0.0, 5.0, 300.0])
def test_conjugate_forces_are_those_of_two_springs_that_only_press(share, preload):
    """Contacts of stiffness share and 1 - share, squeezed at rest: where the lever's torque is in balance."""
    load = FollowerLoad(0.4, 30.0, preload, 0.2, 3.0)
    force, *_ = conjugate_forces(*PAIR, load, OMEGA, PHI, share)
    needed = contact_forces(CAM, FollowerLoad(0.4, 30.0, 0.0, 0.2, 3.0), OMEGA, PHI).effort
    arms = np.abs(CAM.grip(PHI)), np.abs(COUNTER.grip(PHI))

    def out(x):
        return max(0.0, preload + share * x)

    def back(x):
        return max(0.0, preload - (1 - share) * x)

    for k in range(0, len(PHI), 60):
        x = brentq(lambda x, k=k: out(x) - back(x) - needed[k], -1e5, 1e5, xtol=1e-10)
        assert force["cam"][k] * arms[0][k] == pytest.approx(out(x), abs=1e-6)
        assert force["counter"][k] * arms[1][k] == pytest.approx(back(x), abs=1e-6)


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_both_contours_together_take_the_shafts_torque(share, clockwise):
    """The moments of both contact forces about the shaft, whatever the preload."""
    pair = conjugate_cams(ANGLE, OUT, COUNTER.follower, clockwise)
    forces, torque, *_ = conjugate_forces(*pair, FollowerLoad(0.4, 30.0, 7.0, 0.2, 3.0), OMEGA, PHI, share)
    moments = [
        (cam.contour(PHI).conj() * force * cam.normal(PHI)).imag * (-1 if clockwise else 1)
        for cam, force in zip(pair, forces.values(), strict=True)
    ]
    assert torque == pytest.approx(moments[0] + moments[1], abs=1e-9 * np.abs(torque).max())
    assert min(force.min() for force in forces.values()) >= 0


@pytest.mark.parametrize("share", [0.3, 0.5, 1.0])
def test_the_preload_that_keeps_both_cams_in_contact(share):
    def forces(preload):
        return conjugate_forces(*PAIR, FollowerLoad(0.4, 30.0, preload, 0.2, 3.0), OMEGA, PHI, share)

    *_, needed = forces(0.0)
    (force, _, off, least), (_, _, off_below, least_below) = forces(1.0001 * needed), forces(0.9999 * needed)
    assert off == {"cam": (), "counter": ()}
    assert sum(map(len, off_below.values())) == 1
    assert least == least_below == pytest.approx(needed, rel=1e-12)
    assert min(of_cam.min() for of_cam in force.values()) > 0


def test_without_preload_one_of_the_two_cams_carries():
    forces, _, lift_off, _ = conjugate_forces(*PAIR, FollowerLoad(0.4), 50.0, PHI)
    assert ((forces["cam"] == 0) != (forces["counter"] == 0)).mean() > 0.99
    for name, force in forces.items():
        off = np.any([np.mod(PHI - b, TURN) < e - b for b, e in lift_off[name]], axis=0)
        assert (off == (force == 0)).mean() > 0.99


def test_hertz_by_hand():
    """1000 N on 10 mm of steel, radii 50 and 10 mm: R = 8.3333 mm, p = 0.418 sqrt(F E/(b R)) = 663.6 N/mm^2 (the constant of
    machine design for nu = 0.3); and half the contact's width a = sqrt(4 F R/(pi b E*)), p = 2 F/(pi a b)."""
    p = hertz_pressure(np.array([1000.0]), 0.010, np.array([20.0]), 100.0, (STEEL, STEEL))[0]
    assert p == pytest.approx(0.418 * math.sqrt(1000 * 210e3 / (10 * 8.33333)) * 1e6, rel=6e-4)
    together = 1 / (2 * (1 - 0.09) / 210e9)
    a = math.sqrt(4 * 1000 * 0.00833333333 / (math.pi * 0.010 * together))
    assert p == pytest.approx(2 * 1000 / (math.pi * a * 0.010), rel=1e-9)


def test_hertz_of_two_materials_of_hollow_contours_and_of_nothing():
    """Cast iron gives way more; a hollow of the roller's radius fits it; no force, no pressure."""
    force, iron = np.array([500.0]), Material(110e9, 0.25)
    both = hertz_pressure(force, 0.02, np.array([20.0]), 100.0, (iron, STEEL))
    ratio = math.sqrt((2 * 0.91 / 210) / (0.91 / 210 + (1 - 0.0625) / 110))
    assert both / hertz_pressure(force, 0.02, np.array([20.0]), 100.0, (STEEL, STEEL)) == pytest.approx(ratio)
    assert hertz_pressure(force, 0.02, np.array([-100.0]), 100.0, (STEEL, STEEL)) == 0
    assert hertz_pressure(force, 0.02, np.array([-99.0]), 100.0, (STEEL, STEEL)) > 0
    with refused("follower.roller_radius", "0.00990099 m", given=0.01):
        hertz_pressure(force, 0.02, np.array([-101.0]), 100.0, (STEEL, STEEL))
    assert (hertz_pressure(np.array([0.0, -5.0]), 0.02, np.array([20.0, 20.0]), 100.0, (STEEL, STEEL)) == 0).all()


def test_the_pressure_on_cams():
    """With the radius that the contour has there: convex within, hollow on the outer flank of a groove, a face flat."""
    force, phi = np.full(3, 800.0), np.array([0.3, 2.0, 5.0])
    pair = (STEEL, STEEL)
    for cam, kappa in ((CAMS["lever"][0], 1.0), (CAMS["lever, outer"][0], -1.0)):
        pitch = 1 / cam.pitch_curvature(phi)
        radius = pitch - kappa * 0.010
        expected = hertz_pressure(force, 0.012, kappa / radius, 100.0, pair)
        assert contact_pressure(cam, force, phi, 0.012, pair) == pytest.approx(expected)
    flat = CAMS["flat"][0]
    expected = hertz_pressure(force, 0.012, 1 / flat.radius(phi), 0.0, pair)
    assert contact_pressure(flat, force, phi, 0.012, pair) == pytest.approx(expected)


def test_there_is_no_pressure_where_there_is_no_contour():
    sharp = RollerCam(FourierSeries.of(0.0, [0.0, 0.02]), TranslatingRoller(distance=0.06, roller_radius=0.045))
    with refused("follower.roller_radius", "5.221e-07 deg", "0.039999 m", given=0.045):
        contact_pressure(sharp, np.ones(9), np.linspace(0, 3, 9), 0.01, (STEEL, STEEL))
    flat = FlatFacedCam(FourierSeries.of(0.0, [0.0, 0.02]), FlatFaced(distance=0.05))
    with refused("follower.distance", "0 deg", "0.060001 m", given=0.05):
        contact_pressure(flat, np.ones(9), np.linspace(0, 3, 9), 0.01, (STEEL, STEEL))


def test_a_lever_in_line_with_the_cam_cannot_be_driven():
    """Its angle must keep off 0 and 180 deg over the whole range of the law: both sides."""
    low, _ = ANGLE.bounds
    for into, fine in ((0.01, True), (-0.01, False)):
        cam = RollerCam(ANGLE, OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=-math.pi - low + into))
        if fine:
            contact_forces(cam, LEVER_LOAD, 10.0, PHI)
            continue
        with refused("follower", "90 deg", given=None):
            contact_forces(cam, LEVER_LOAD, 10.0, PHI)


@pytest.mark.parametrize(
    ("make", "refusal"),
    [
        (lambda: FollowerLoad(-1.0), refused("inertia", given=-1.0, code="negative")),
        (lambda: FollowerLoad(1.0, stiffness=math.nan), refused("stiffness", given=float("nan"), code="negative")),
        (lambda: FollowerLoad(1.0, damping=-0.1), refused("damping", given=-0.1, code="negative")),
        (lambda: FollowerLoad(1.0, preload=math.inf), refused("preload", given=float("inf"), code="not-finite")),
        (lambda: Material(0.0, 0.3), refused("modulus", given=0.0)),
        (lambda: Material(1e9, 0.6), refused("poisson", "-1", "0.5", given=0.6)),
        (lambda: contact_forces(*CAMS["rod"], -1.0, PHI), refused("speed", "nowhere negative", given=None, code="negative")),
        (
            lambda: contact_forces(*CAMS["rod"], math.nan, PHI),
            refused("speed", "nowhere negative", given=None, code="negative"),
        ),
        (lambda: contact_forces(*CAMS["rod"], np.ones(2), PHI), refused("speed", "3", given=None, code="shape")),
        (lambda: conjugate_forces(*PAIR, LEVER_LOAD, 1.0, PHI, 1.1), refused("share", given=1.1)),
        (lambda: conjugate_forces(*PAIR, FollowerLoad(1.0, preload=-1.0), 1.0, PHI), refused("preload", given=-1.0)),
        (lambda: hertz_pressure(PHI, 0.0, PHI, 1.0, (STEEL, STEEL)), refused("width", "m", given=0.0)),
    ],
)
def test_bad_input_is_refused_by_its_sentence(make, refusal):
    with refusal:
        make()


def test_three_samples_of_a_speed_are_enough_and_two_are_not():
    """Mean, cosine and sine of order 1: 50 + 3 cos phi - 2 sin phi."""
    cam, load = CAMS["lever"]
    three = 50 + 3 * np.cos(TURN * np.arange(3) / 3) - 2 * np.sin(TURN * np.arange(3) / 3)
    by_function = contact_forces(cam, load, FourierSeries.of(50.0, [3.0], [-2.0]), PHI)
    assert contact_forces(cam, load, three, PHI).force == pytest.approx(by_function.force, rel=1e-9)
    with refused("speed", code="shape"):
        contact_forces(cam, load, three[:2], PHI)


def test_a_shaft_at_rest_has_the_forces_of_springs_alone_and_none_turns_backwards():
    cam, load = CAMS["rod"]
    at_rest = contact_forces(cam, load, 0.0, PHI)
    assert at_rest.effort == pytest.approx(load.stiffness * LIFT(PHI) + load.preload + load.constant)
    for speed in (-1e-9, math.nan, math.inf):
        with refused("speed", code="negative"):
            contact_forces(cam, load, speed, PHI)


def test_materials_may_be_incompressible():
    assert Material(1e9, 0.5).compliance == pytest.approx(0.75e-9) and Material(1e9, -0.99).compliance > 0
    with refused("poisson", given=-1.0):
        Material(1e9, -1.0)


def test_one_hollow_place_is_enough_for_a_roller_not_to_fit():
    force, curvature = np.full(3, 500.0), np.array([20.0, -101.0, 20.0])
    with refused("follower.roller_radius", given=0.01):
        hertz_pressure(force, 0.02, curvature, 100.0, (STEEL, STEEL))


def test_an_undercut_elsewhere_leaves_the_pressure_here():
    """The contour is sharp at 0 deg, and round at 90 deg."""
    sharp = RollerCam(FourierSeries.of(0.0, [0.0, 0.02]), TranslatingRoller(distance=0.06, roller_radius=0.045))
    at = np.array([math.pi / 2])
    expected = hertz_pressure(np.ones(1), 0.01, sharp.curvature(at), 1 / 0.045, (STEEL, STEEL))
    assert contact_pressure(sharp, np.ones(1), at, 0.01, (STEEL, STEEL)) == pytest.approx(expected)
