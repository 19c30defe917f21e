"""Followers: where their rollers and faces are, what they give to the search of their smallest cam, and what it gives back."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.followers import flat_faced, oscillating_roller, translating_roller
from wucht.cams.followers.flat_faced import FlatFaced
from wucht.cams.followers.oscillating_roller import CounterTable, OscillatingRoller
from wucht.cams.followers.translating_roller import TranslatingRoller
from wucht.cams.milled_cam import milled_motion
from wucht.cams.sizing.size_limits import CamLimits, SmallestCam
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


def test_places_of_rollers_and_faces() -> None:
    assert LEVER.place(np.array(math.radians(53))) == pytest.approx(0.11 - 0.09j)
    assert ROD.place(np.array(0.01)) == pytest.approx(0.06 + 0.006j) and FACE.place(np.array(0.01)) == pytest.approx(0.05)
    assert LEVER.outline(LAW).pivot == 0.11 and ROD.outline(LAW).rod_offset == 0.006


@pytest.mark.parametrize("clockwise", [True, False])
def test_the_face_that_is_touched_by_a_contour(clockwise: bool) -> None:
    """From -psi' on, in the sense of the cam: psi' = 0.012 sin phi."""
    law = FourierSeries.of(0.012, [-0.012, 0.0], [0.0, 0.001])
    slopes = law(np.linspace(0, 2 * math.pi, 721), 1)
    outline = FlatFaced(distance=0.04, clockwise=clockwise).outline(law)
    ends = (slopes.min(), slopes.max()) if clockwise else (-slopes.max(), -slopes.min())
    assert (outline.face_from, outline.face_to) == pytest.approx(ends) and outline.face_at == pytest.approx(0.04)
    assert FACE.outline(LAW).face_at == pytest.approx(0.04 + 0.012)


def searched(monkeypatch: pytest.MonkeyPatch, module: Any, name: str) -> list[tuple[tuple[Any, ...], dict[str, Any]]]:
    calls = list[tuple[tuple[Any, ...], dict[str, Any]]]()
    monkeypatch.setattr(module, name, lambda *given, **keys: calls.append((given, keys)))
    return calls


ALL = CamLimits(pressure_angle=0.5, least_radius=0.003, shaft_radius=0.02)
ANGLE = CamLimits(pressure_angle=0.5)


def test_what_the_smallest_cam_of_a_lever_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """The roller goes out where the lever is between -180 and 0 deg as the law begins."""
    calls = searched(monkeypatch, oscillating_roller, "smallest_lever_cam")
    law = FourierSeries.of(0.3, [])
    for angle, clockwise, limits in (
        (-0.1, True, ALL),
        (-0.4, False, ANGLE),
        (math.pi - 0.1, False, ANGLE),
        (3.0, False, ANGLE),
    ):
        follower = LEVER.model_copy(update={"angle": angle, "clockwise": clockwise})
        follower.smallest_cam(law, limits, "blank")
    given = {"clockwise": False, "least_radius": 0.0, "shaft_radius": 0.0, "size": "blank"}
    assert [keys for _, keys in calls] == [
        {"clockwise": True, "outward": False, "least_radius": 0.003, "shaft_radius": 0.02, "size": "blank"},
        given | {"outward": True}, given | {"outward": True}, given | {"outward": True},
    ]  # fmt: skip
    assert {place for place, _ in calls} == {(law, 0.09, 0.01, 0.5)}
    assert LEVER.smallest_cam(law, CamLimits(least_radius=0.003), "base") is None and len(calls) == 4


def test_what_the_smallest_cam_of_a_rod_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = searched(monkeypatch, translating_roller, "smallest_rod_cam")
    ROD.model_copy(update={"clockwise": True}).smallest_cam(LAW, ALL, "base")
    ROD.smallest_cam(LAW, ANGLE, "blank")
    assert [place for place, _ in calls] == [(LAW, 0.008, 0.5)] * 2
    assert [keys for _, keys in calls] == [
        {"clockwise": True, "least_radius": 0.003, "shaft_radius": 0.02, "size": "base"},
        {"clockwise": False, "least_radius": 0.0, "shaft_radius": 0.0, "size": "blank"},
    ]
    assert ROD.smallest_cam(LAW, CamLimits(shaft_radius=0.003), "base") is None and len(calls) == 2


def test_what_the_smallest_cam_of_a_face_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """By its radius of curvature or its shaft, never by a pressure angle."""
    calls = searched(monkeypatch, flat_faced, "smallest_flat_faced_cam")
    FACE.model_copy(update={"clockwise": True}).smallest_cam(LAW, CamLimits(least_radius=0.003), "base")
    FACE.smallest_cam(LAW, CamLimits(shaft_radius=0.02), "base")
    assert calls == [
        ((LAW, 0.003), {"clockwise": True, "shaft_radius": 0.0}),
        ((LAW, 0.0), {"clockwise": False, "shaft_radius": 0.02}),
    ]
    assert FACE.smallest_cam(LAW, CamLimits(), "base") is None
    with refused("pressure_angle"):
        FACE.smallest_cam(LAW, ALL, "base")


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


def test_a_follower_about_another_centre() -> None:
    """The pivot of a lever is then on +x; a rod is along +x, at its offset."""
    moved = LEVER.relative_to(0.03 - 0.04j)
    assert moved.pivot == pytest.approx(0.05)
    assert moved.angle == pytest.approx(math.atan2(4, 3) + math.pi - 2 * math.pi) and moved.arm == 0.09
    rod = ROD.relative_to(-0.03 - 0.04j)
    assert (rod.distance, rod.offset) == pytest.approx((0.03, 0.04))
    assert ROD.distance_from(-0.03 - 0.04j) == 0.03 and LEVER.distance_from(0.5j) == math.inf
    assert (ROD.swing(0.1, 0.4), LEVER.swing(0.1, 0.4)) == (0.0, pytest.approx(0.3))


def test_the_summary_of_a_smallest_cam_is_that_of_its_contour() -> None:
    """Of a roller that is within the pitch curve by its radius."""
    cam = SmallestCam(ROD, 0.05, 0.09, 0.004, 1.0, ROD.roller_radius, 0.5, (1.0,))
    assert cam.summary() == {
        "follower": {"distance": 0.05, "offset": 0.006}, "base_radius": pytest.approx(0.042),
        "largest_radius": pytest.approx(0.082), "min_curvature_radius": 0.004, "max_pressure_angle": 0.5,
    }  # fmt: skip
    lever = SmallestCam(LEVER, 0.05, 0.09, math.inf, 1.0, LEVER.roller_radius, 0.5)
    assert lever.summary()["min_curvature_radius"] is None
    assert dict(lever.placement) == {"pivot": 0.11, "angle": LEVER.angle}
    face = SmallestCam(FACE, 0.05, 0.09, 0.004, 1.0, face=(-0.01, 0.02))
    assert face.summary() == {
        "follower": {"distance": 0.04}, "base_radius": 0.05, "largest_radius": 0.09, "min_curvature_radius": 0.004,
        "face": [-0.01, 0.02],
    }  # fmt: skip


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
