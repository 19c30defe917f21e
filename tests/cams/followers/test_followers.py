"""Followers: where their rollers and faces are, what they give to the search of their smallest cam, and what it gives back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.followers.flat_faced import FlatFaced
from wucht.cams.followers.oscillating_roller import CounterTable, OscillatingRoller
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.milled_cam import milled_motion
from wucht.cams.sizing.size_limits import CamLimits
from wucht.numerics.fourier_series import FourierSeries

LAW = FourierSeries.of(0.02, [-0.012, 0.004], [0.003, 0.001])
PHI = np.linspace(0.1, 6.0, 7)
LEVER = OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))
ROD = TranslatingRoller(distance=0.05, roller_radius=0.008, offset=0.006)
FACE = FlatFaced(distance=0.04)


@pytest.mark.parametrize("follower", [LEVER, ROD])
def test_derivatives_of_the_roller_s_centre(follower: Any) -> None:
    h = 1e-4
    for order in (1, 2, 3):
        below, above = (follower.centre(LAW, PHI + sign * h, order - 1) for sign in (-1, 1))
        assert follower.centre(LAW, PHI, order) == pytest.approx((above - below) / (2 * h), abs=1e-7)
    value = LAW(PHI)
    assert follower.centre(LAW, PHI) == pytest.approx(follower.place(value))
    assert follower.rate(value) == pytest.approx((follower.place(value + h) - follower.place(value - h)) / (2 * h), abs=1e-8)


@pytest.mark.parametrize("clockwise", [True, False])
def test_the_face_that_is_touched_by_a_contour(clockwise: bool) -> None:
    """From -psi' on, in the sense of the cam: psi' = 0.012 sin phi."""
    law = FourierSeries.of(0.012, [-0.012, 0.0], [0.0, 0.001])
    slopes = law(np.linspace(0, 2 * math.pi, 721), 1)
    outline = FlatFaced(distance=0.04, clockwise=clockwise).outline(law)
    ends = (slopes.min(), slopes.max()) if clockwise else (-slopes.max(), -slopes.min())
    assert (outline.face_from, outline.face_to) == pytest.approx(ends) and outline.face_at == pytest.approx(0.04)
    assert FACE.outline(LAW).face_at == pytest.approx(0.04 + 0.012)


def test_a_permitted_pressure_angle_is_less_than_a_right_one() -> None:
    assert CamLimits(pressure_angle="89 deg").pressure_angle == pytest.approx(math.radians(89))
    with refused("CamLimits.pressure_angle", given="89.01 deg"):
        CamLimits(pressure_angle="89.01 deg")


def test_a_smallest_cam_gives_its_follower_another_place() -> None:
    counter = CounterTable(arm=0.08, roller_radius=0.012, angle=2.0)
    placed, notes = LEVER.model_copy(update={"counter": counter}).with_placement({"pivot": 0.2, "angle": 0.7})
    assert (placed.pivot, placed.angle, placed.arm, placed.counter, len(notes)) == (0.2, 0.7, 0.09, None, 1)
    assert LEVER.with_placement({"pivot": 0.2, "angle": 0.7})[1] == ()
    rod, notes = ROD.with_placement({"distance": 0.07, "offset": -0.01})
    assert (rod.distance, rod.offset, rod.roller_radius, notes) == (0.07, -0.01, 0.008, ())


@pytest.mark.parametrize("clockwise", [True, False])
def test_an_edge_lies_on_the_contour(clockwise: bool) -> None:
    """On a circle of the radius r about e: x = e cos phi + sqrt(r^2 - e^2 sin^2 phi) along the line of a rod without offset."""
    radius, off = 0.03, 0.006
    at = np.linspace(0, 2 * math.pi, 256, endpoint=False)
    edge = TranslatingRoller(distance=0.02, roller_radius=1.0).model_copy(update={"roller_radius": 0.0})
    phi = np.linspace(0.0, 6.0, 9)
    distance = off * np.cos(phi) + np.sqrt(radius**2 - (off * np.sin(phi)) ** 2)
    motion = milled_motion(off + radius * np.exp(1j * at), edge, phi, distance - 0.02 + 1e-3, clockwise)
    assert motion == pytest.approx(distance - 0.02, abs=1e-8)


LEVER_TABLE = {"pivot": "110 mm", "arm": "90 mm", "roller_radius": "10 mm", "angle": "-143 deg"}
COUNTER_TABLE = {"arm": "90 mm", "roller_radius": "10 mm", "angle": "120 deg"}


def test_a_groove_and_a_counter_cam_are_one_choice():
    assert OscillatingRoller(**LEVER_TABLE, counter=COUNTER_TABLE).groove is False
    assert OscillatingRoller(**LEVER_TABLE, groove=True).counter is None
    with refused("follower.groove", "groove = true", "counter cam", given=True):
        OscillatingRoller(**LEVER_TABLE, counter=COUNTER_TABLE, groove=True)


def test_both_cams_of_a_lever_are_for_the_sense_of_its_shaft():
    law = FourierSeries.of(0.1, [-0.1])
    for clockwise in (False, True):
        cams = OscillatingRoller(**LEVER_TABLE, counter=COUNTER_TABLE, clockwise=clockwise).make_cams(law)
        assert {name: cam.clockwise for name, cam in cams.items()} == {"cam": clockwise, "counter": clockwise}
