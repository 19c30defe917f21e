"""What a contour is assessed by: of an ellipse, whose distances are known, as it is and with parts cut away."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.cam import format_metres, value_past_limit
from wucht.cams.shape import Extreme, format_cam_angle, largest_pressure_angle, shapes
from wucht.cams.undercut import CutAway, RadiusAt, is_on_arcs, signed_angle
from wucht.errors import InputError

CONVEX, HOLLOW, WHEEL = RadiusAt(0.012, 0.5), RadiusAt(0.03, 2.0), RadiusAt(0.025, 2.1)
NONE: tuple[tuple[float, float], ...] = ()


class Ellipse:
    """50 mm along x, 30 mm along y; a pressure angle of -0.5 rad at 1 rad, and of 0.7 rad half a turn later."""

    part = "roller"

    def __init__(
        self,
        missing: tuple[tuple[float, float], ...] = NONE,
        roller: float | None = 0.01,
        largest: float = 0.02,
        hollow: RadiusAt | None = HOLLOW,
        sense: float = 1.0,
    ) -> None:
        self.sense = sense
        self.roller_radius, self.cut, self.checked = roller, CutAway(NONE, missing, CONVEX, hollow, largest), False

    def contour(self, phi: np.ndarray) -> np.ndarray:
        return 0.05 * np.cos(phi) + 0.03j * np.sin(phi)

    def pressure_angle(self, phi: np.ndarray) -> np.ndarray:
        return self.sense * (0.1 - 0.6 * np.cos(phi - 1.0))

    def cut_away(self) -> CutAway:
        return self.cut

    def largest_wheel(self) -> RadiusAt:
        return WHEEL

    def check(self, format_length: Any) -> None:
        self.checked = True
        raise InputError("follower.roller_radius", 0.01, f"take at most {format_length(0.02)}")


def shape_of(cam: Ellipse, **options: Any) -> Any:
    return shapes({"cam": cam}, **options)["cam"]  # type: ignore[dict-item]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_of_a_contour_that_is_all_there(sense: float) -> None:
    """A pressure angle counts by its magnitude."""
    shape = shape_of(Ellipse(sense=sense))
    assert shape.base.value == pytest.approx(0.03)
    assert shape.base.phi % math.pi == pytest.approx(math.pi / 2, abs=1e-6)
    assert shape.blank.value == pytest.approx(0.05)
    assert min(shape.blank.phi % math.pi, math.pi - shape.blank.phi % math.pi) < 1e-6
    assert shape.pressure_angle.value == pytest.approx(0.7)
    assert shape.pressure_angle.phi == pytest.approx(1.0 + math.pi, abs=1e-6)
    assert (shape.convex, shape.hollow, shape.wheel) == (CONVEX, HOLLOW, WHEEL)
    assert (shape.largest_roller, shape.part, shape.missing, shape.undercut) == (0.02, "roller", (), ())


def test_distances_are_those_of_what_remains() -> None:
    """Both far ends are missing: the farthest is at the ends of these arcs; then both near ends, and the nearest is."""
    far = Ellipse(((-0.3, 0.4), (math.pi - 0.2, math.pi + 0.5)), largest=0.005)
    blank = shape_of(far, allow_undercut=True).blank
    assert blank.value == pytest.approx(abs(far.contour(np.array(0.2))), rel=1e-2)
    assert blank.value < 0.05
    near = Ellipse(((math.pi / 2 - 0.3, math.pi / 2 + 0.4), (3 * math.pi / 2 - 0.2, 3 * math.pi / 2 + 0.5)), largest=0.005)
    base = shape_of(near, allow_undercut=True).base
    assert base.value == pytest.approx(abs(near.contour(np.array(math.pi / 2 - 0.2))), rel=1e-2)
    assert base.value > 0.03


@pytest.mark.parametrize(("largest", "allowed", "made"), [(0.02, False, True), (0.005, False, False), (0.005, True, True)])
def test_a_roller_that_cuts_is_refused_unless_that_is_allowed(largest: float, allowed: bool, made: bool) -> None:
    cam = Ellipse(((0.0, 1.0),), largest=largest)
    if made:
        assert shape_of(cam, allow_undercut=allowed).largest_roller == largest
        assert (shape_of(cam, allow_undercut=allowed).wheel is None) is (largest == 0.005)
    else:
        with refused("follower.roller_radius", "20 mm", given="10 mm"):
            shape_of(cam, allow_undercut=allowed)
    assert cam.checked is not made


def test_a_contour_of_which_nothing_remains_is_never_allowed() -> None:
    with refused("follower.roller_radius"):
        shape_of(Ellipse(((0.0, 7.0),), largest=0.005), allow_undercut=True)


def test_a_flat_face_has_no_roller_and_any_wheel_reaches_what_bulges() -> None:
    flat = Ellipse(roller=None)
    flat.check = lambda _format: None  # type: ignore[method-assign]
    shape = shape_of(flat)
    assert shape.largest_roller is None
    assert shape.wheel is None
    assert shape_of(Ellipse(hollow=None), wheel_radius=1.0).wheel is None


@pytest.mark.parametrize(("name", "label"), [("cam", "the cam"), ("counter", "the counter cam"), ("outer", "the outer flank")])
def test_a_wheel_that_is_too_large_for_a_cam(name: str, label: str) -> None:
    assert shapes({name: Ellipse()}, wheel_radius=0.025)[name].wheel == WHEEL  # type: ignore[dict-item]
    with refused("wheel_radius", label, "120.3 deg", "25 mm", given="25.1 mm"):
        shapes({name: Ellipse()}, wheel_radius=0.0251)  # type: ignore[dict-item]


def test_the_roller_of_the_counter_cam_has_a_key_of_its_own() -> None:
    with refused("follower.counter.roller_radius", given="10 mm"):
        shapes({"cam": Ellipse(), "counter": Ellipse(largest=0.005)})  # type: ignore[dict-item]
    with refused("follower.roller_radius", given="10 mm"):
        shapes({"cam": Ellipse(), "outer": Ellipse(largest=0.005)})  # type: ignore[dict-item]


def test_the_largest_pressure_angle_of_several_cams() -> None:
    one, other = shape_of(Ellipse()), shape_of(Ellipse())
    object.__setattr__(other, "pressure_angle", Extreme(0.71, 3.0))
    assert largest_pressure_angle([one, other, one]) == Extreme(0.71, 3.0)


@pytest.mark.parametrize(("degrees", "text"), [(0, "0°"), (12.3456, "12.35°"), (360, "360°"), (372.5, "12.5°")])
def test_cam_angles_are_within_a_turn(degrees: float, text: str) -> None:
    assert format_cam_angle(math.radians(degrees)) == text


@pytest.mark.parametrize(
    ("limit", "direction", "value"),
    [(0.0123456, 1, 0.012346), (0.0123456, -1, 0.012345), (0.02, 1, 0.020001), (0.02, -1, 0.019999),
     (-3.45678, 1, -3.4567), (-3.45678, -1, -3.4568), (0.0, 1, 1e-9), (0.0, -1, -1e-9)],
)  # fmt: skip
def test_a_number_of_five_digits_beside_a_limit(limit: float, direction: int, value: float) -> None:
    assert value_past_limit(limit, direction) == pytest.approx(value, rel=1e-12)
    assert direction * (value_past_limit(limit, direction) - limit) > 0


def test_lengths_of_a_sentence() -> None:
    assert format_metres(0.0123456789) == "0.012346 m"


def test_arcs_may_pass_the_end_of_a_turn() -> None:
    """From 350 to 370 degrees: at 0, 9 and -9 degrees, not at 11, nor at 349."""
    arcs = ((math.radians(350), math.radians(370)), (math.radians(90), math.radians(100)))
    at = np.radians([0.0, 9.0, -9.0, 95.0, 11.0, 349.0, 101.0])
    assert is_on_arcs(arcs, at).tolist() == [True, True, True, True, False, False, False]
    assert not is_on_arcs((), at).any()


def test_arcs_that_the_roller_cuts_from_elsewhere_have_no_fold() -> None:
    cut = CutAway(undercut=((1.1, 1.2),), missing=((1.0, 1.3), (4.0, 4.2)), convex=None, hollow=None, largest_roller=1.0)
    assert cut.remote_arcs == ((4.0, 4.2),)
    assert cut.is_missing(np.array([1.05, 2.0, 4.1])).tolist() == [True, False, True]


def test_an_angle_from_minus_to_plus_half_a_turn() -> None:
    angles = signed_angle(np.array([0.1, -0.1, 3.5, -3.5, 2 * math.pi + 0.2]))
    assert angles == pytest.approx([0.1, -0.1, 3.5 - 2 * math.pi, 2 * math.pi - 3.5, 0.2])
