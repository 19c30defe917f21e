"""Cams that are cut away: against a cam known in closed form, and against all distances of many points."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.cam import value_past_limit
from wucht.cams.followers.flat_faced import FlatFaced, FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.laws.cam_segments import RiseAndReturn
from wucht.cams.laws.standard_laws import STANDARD_LAWS
from wucht.cams.undercut import is_on_arcs, least_radius
from wucht.errors import InputError
from wucht.numerics.angles import GRID
from wucht.numerics.fourier_series import FourierSeries

TURN, PI = 2 * math.pi, math.pi
LEVER = FourierSeries.of(math.radians(12), np.radians([-12.5, 3.5, 0.8]), np.radians([0.7, 0.3]))


@functools.cache
def waisted(roller, outer=False, clockwise=False, unit=1.0):
    """A disc whose pitch curve is 0.1 + 0.08 cos 2 phi from the centre: with a waist, 0.02 from it."""
    law = FourierSeries.of(0.0, [0.0, 0.08 * unit])
    return RollerCam(law, TranslatingRoller.model_construct(distance=0.1 * unit, roller_radius=roller * unit), clockwise, outer)


@functools.cache
def levered(roller, outer=False):
    lever = OscillatingRoller.model_construct(pivot=0.11, arm=0.09, roller_radius=roller, angle=math.radians(-143))
    return RollerCam(LEVER, lever, False, outer)


cut = functools.cache(RollerCam.cut_away)


def nearest_roller(cam, phi, count=20_000):
    """The distances of the contour's points from the nearest of many places of the roller's centre."""
    pitch = cam.pitch(np.arange(count) * (TURN / count))
    return np.array([np.abs(pitch - c).min() for c in cam.contour(phi)])


def inside(arcs, phi, margin=0.0):
    parts = [np.mod(phi - b + margin, TURN) <= e - b + 2 * margin for b, e in arcs]
    return np.any(parts, axis=0) if parts else np.zeros(len(phi), bool)


@pytest.mark.parametrize("clockwise", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_waist_is_cut_through_by_a_roller_of_its_half_width(clockwise):
    """There the pitch curve is 0.02 from the centre on both sides: the roller meets itself. Locally it is hollow."""
    assert waisted(0.0, clockwise=clockwise).largest_roller().radius == pytest.approx(0.02, rel=1e-9)
    below, above = cut(waisted(0.01999, clockwise=clockwise)), cut(waisted(0.02001, clockwise=clockwise))
    assert below.missing == below.remote_arcs == ()
    assert above.undercut == ()
    assert above.missing == above.remote_arcs
    assert [0.5 * (b + e) for b, e in above.missing] == pytest.approx([PI / 2, 3 * PI / 2], abs=1e-6)


def test_radii_of_the_waisted_disc():
    """By (rho^2 + 2 rho'^2 - rho rho'')/(rho^2 + rho'^2)^(3/2): at the tips 1.8 (1.8 + 3.2)/1.8^3, at the waist
    0.2 (0.2 - 3.2)/0.2^3, in units of 0.1 m."""
    found = cut(waisted(0.01))
    assert found.convex.radius == pytest.approx(0.1 * 1.8**2 / 5.0 - 0.01, rel=1e-9)
    assert math.remainder(found.convex.phi, PI) == pytest.approx(0, abs=1e-6)
    assert found.hollow.radius == pytest.approx(0.1 * 0.2**2 / 3.0 + 0.01, rel=1e-9)
    assert math.remainder(found.hollow.phi - PI / 2, PI) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("cam", [waisted(0.03), waisted(0.01, outer=True), levered(0.0695)])
def test_what_is_missing_is_nearer_to_the_roller_elsewhere(cam):
    """Everywhere, by brute force, but within 0.01 rad of the ends, where the depth is next to nothing."""
    found, phi, r = cut(cam), np.linspace(0.0003, TURN, 500), cam.follower.roller_radius
    nearer = nearest_roller(cam, phi) < r * (1 - 1e-6)
    deep, kept = inside(found.missing, phi, -0.01), ~inside(found.missing, phi, 0.01)
    assert deep.sum() > 10
    assert kept.sum() > 10
    assert nearer[deep].all()
    assert not nearer[kept].any()
    assert (cam.undercut(phi)[inside(found.undercut, phi, -1e-9)] <= 0).all()
    assert (cam.undercut(phi)[~inside(found.undercut, phi, 1e-9)] > 0).all()
    assert r > found.largest_roller


@pytest.mark.parametrize(("cam", "key"), [(waisted(0.03), "follower.distance"), (levered(0.0695), "follower.pivot")])
def test_the_sentence_names_a_roller_that_will_do(cam, key):
    with pytest.raises(InputError, match="would cut the contour away at a cam angle of") as error:
        cam.check()
    assert error.value.location == "follower.roller_radius"
    assert key in str(error.value)
    told = float(re.search(r"at most (\S+) m", str(error.value)).group(1))
    replace(cam, follower=cam.follower.model_copy(update={"roller_radius": told})).check()
    with pytest.raises(InputError):
        replace(cam, follower=cam.follower.model_copy(update={"roller_radius": told * 1.0002})).check()


@pytest.mark.slow
@pytest.mark.parametrize("cam", [waisted(0.01), waisted(0.001, outer=True)], ids=["inner", "outer"])
def test_the_largest_wheel_touches_the_whole_contour_and_no_larger_one_does(cam):
    """By brute force: a wheel at any point of the contour has no other point of it within."""
    largest = cam.largest_wheel()
    phi = np.linspace(0, TURN, 361)[:-1]
    side, contour = -1 if cam.outer else 1, cam.contour(GRID)
    for share, fits in ((0.999, True), (1.001, False)):
        wheel = share * largest.radius
        centres = cam.contour(phi) + side * wheel * cam.normal(phi)
        nearest = np.array([np.abs(contour - c).min() for c in centres])
        assert (nearest.min() > wheel * (1 - 1e-6)) is np.bool_(fits)
    cam.check_wheel(0.999 * largest.radius)
    with pytest.raises(InputError, match=r"wheel_radius.* too hollow for it at a cam angle of") as error:
        cam.check_wheel(1.001 * largest.radius)
    cam.check_wheel(float(re.search(r"at most (\S+) m", str(error.value)).group(1)))


def test_a_flat_face_needs_the_distance_of_the_closed_form():
    """h + h'' = distance + 0.01 - 0.015 cos 2 phi: 5 mm, both sides, and what the sentence says."""
    law = FourierSeries.of(0.01, [-0.01, 0.005])
    FlatFacedCam(law, FlatFaced(distance=0.00500001)).check()
    with refused("follower.distance", "0 deg", "0.0050001 m") as error:
        FlatFacedCam(law, FlatFaced(distance=0.0049)).check()
    told = float(re.search(r"at least (\S+) m", str(error.value)).group(1))
    assert told == pytest.approx(0.005, rel=3e-4)
    FlatFacedCam(law, FlatFaced(distance=told)).check()


@functools.cache
def faced(clockwise=False, unit=1.0):
    """3-4-5 up within 60 deg and down within 80: far too small for its face."""
    law = RiseAndReturn(STANDARD_LAWS["3-4-5"], 0.02 * unit, (0.1, 0.1 + PI / 3), (4.0, 4.0 + 4 * PI / 9))
    return FlatFacedCam(law, FlatFaced(distance=0.02 * unit), clockwise)


@functools.cache
def cut_by_face(clockwise=False, unit=1.0):
    return faced(clockwise, unit).cut_away()


@pytest.mark.parametrize("clockwise", [False, True])
def test_what_a_face_leaves_lies_behind_all_faces(clockwise):
    """By the half-planes of many cam angles: a contour point is left where it lies in all of them. Ends of an arc are one
    point of the contour; where the radius is negative it is a part only."""
    cam, found = faced(clockwise), cut_by_face(clockwise)
    phi, many = np.linspace(0.0007, TURN, 700), np.linspace(0, TURN, 8000)
    beyond = (cam.contour(phi)[:, None] * cam.normal(many).conj()).real - (cam.follower.distance + cam.law(many))
    gone = beyond.max(axis=1) > 1e-9
    assert (gone == inside(found.missing, phi)).all()
    assert len(found.missing) == len(found.undercut) == 2
    for (begin, end), (first, last) in zip(found.missing, found.undercut, strict=True):
        assert begin < first < last < end
        assert cam.contour(np.array(begin)) == pytest.approx(cam.contour(np.array(end)), abs=1e-12)
    left = phi[~gone]
    assert found.convex.radius <= cam.radius(left).min() * (1 + 1e-12)
    assert found.convex.radius == pytest.approx(cam.radius(left).min(), rel=1e-2)
    assert (found.hollow, found.largest_roller, found.remote_arcs) == (None, math.inf, ())


def test_a_straight_flank_has_no_radius_and_a_round_one_has():
    """Curvatures of rounding are none, of either sign; the least radius is that where it bends most."""
    circle = lambda phi: np.exp(1j * phi)  # noqa: E731
    for rounding in (0.0, 1e-11, -1e-11):
        assert least_radius(circle, lambda phi, by=rounding: by * (2 + np.cos(phi))) is None
    bent = least_radius(circle, lambda phi: -4.0 * np.exp(-4 * (1 - np.cos(phi - 2.0))))
    assert (bent.radius, bent.phi) == (pytest.approx(0.25), pytest.approx(2.0, abs=1e-4))


@pytest.mark.parametrize(
    ("limit", "direction", "value"),
    [(0.0123456, 1, 0.012346), (0.0123456, -1, 0.012345), (0.02, 1, 0.020001), (0.02, -1, 0.019999),
     (-3.45678, 1, -3.4567), (-3.45678, -1, -3.4568), (0.0, 1, 1e-9), (0.0, -1, -1e-9)],
)  # fmt: skip
def test_a_number_of_five_digits_beside_a_limit(limit: float, direction: int, value: float) -> None:
    assert value_past_limit(limit, direction) == pytest.approx(value, rel=1e-12)
    assert direction * (value_past_limit(limit, direction) - limit) > 0


def test_arcs_may_pass_the_end_of_a_turn() -> None:
    """From 350 to 370 degrees: at 0, 9 and -9 degrees, not at 11, nor at 349."""
    arcs = ((math.radians(350), math.radians(370)), (math.radians(90), math.radians(100)))
    at = np.radians([0.0, 9.0, -9.0, 95.0, 11.0, 349.0, 101.0])
    assert is_on_arcs(arcs, at).tolist() == [True, True, True, True, False, False, False]
    assert not is_on_arcs((), at).any()


def test_the_sentence_names_a_wheel_that_will_do():
    """To five digits: the next larger number will not do any more."""
    cam = waisted(0.01)
    with refused("wheel_radius", "90 deg", "0.011333 m", given=1.0) as error:
        cam.check_wheel(1.0)
    assert error.value.location == "wheel_radius"
    told = float(re.search(r"at most (\S+) m", str(error.value)).group(1))
    cam.check_wheel(told)
    with pytest.raises(InputError):
        cam.check_wheel(told * 1.0002)
