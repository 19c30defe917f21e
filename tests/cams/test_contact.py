"""What presses on a cam: against virtual work, energy, an eccentric circle, and Hertz by hand."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.refusals import refused

from wucht.cams.contact import FollowerLoad, Material, conjugate_forces, contact_forces, contact_pressure, hertz_pressure
from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller, conjugate_cams
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.linkages.closure import LeverMotion
from wucht.cams.linkages.four_bar_and_slider_crank import FourBar, SliderCrank
from wucht.errors import InputError
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


def test_what_cannot_press_is_refused():
    for make, key in (
        (lambda: FollowerLoad(-1.0), "inertia"), (lambda: FollowerLoad(1.0, damping=-0.1), "damping"),
        (lambda: FollowerLoad(1.0, preload=math.inf), "preload"), (lambda: Material(0.0, 0.3), "modulus"),
        (lambda: Material(1e9, 0.51), "poisson"), (lambda: conjugate_forces(*PAIR, LEVER_LOAD, 1.0, PHI, 1.1), "share"),
        (lambda: conjugate_forces(*PAIR, FollowerLoad(1.0, preload=-1.0), 1.0, PHI), "preload"),
        (lambda: hertz_pressure(PHI, 0.0, PHI, 1.0, (STEEL, STEEL)), "width"),
    ):  # fmt: skip
        with pytest.raises(InputError) as raised:
            make()
        assert raised.value.location == key
    assert Material(1e9, 0.5).compliance == pytest.approx(0.75e-9)
