"""The figure of ``cam-contour``: the cam to scale, the panels and their limits; drawn from the Dataset alone."""

from __future__ import annotations

from typing import Any

import cam_files_to_study as given
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

from wucht import CamContour, draw, run

pytestmark = pytest.mark.usefixtures("coarse_angles")


def line(axis: Axes, name: str) -> Any:
    return next(drawn for drawn in axis.get_lines() if drawn.get_label() == name)


def named(axis: Axes) -> str:
    """The name of its ordinate, in however many lines."""
    return " ".join(axis.get_ylabel().split())


def eccentric_face(clockwise: bool = False, cosine: str = "-10 mm", preload: float = 60.0) -> xr.Dataset:
    """A circle of 40 mm radius, 10 mm off its centre."""
    law = {"kind": "harmonic", "coefficients": {"mean": "0 mm", "cosine": [cosine]}}
    contact = {"mass": 0.4, "preload": preload, "width": "15 mm"}
    asked = CamContour(contact=contact, speed=20.0, points=36, chord_tolerance="50 um")
    return run(asked, given.drive(law, given.FLAT | {"clockwise": clockwise}))


@pytest.mark.parametrize("clockwise", [True, False])
def test_where_a_flat_face_is_touched_and_how_the_cam_turns(clockwise: bool) -> None:
    """It is touched at -y, for a cam that turns clockwise at y: s' by the cam angle."""
    cam, *below = draw(eccentric_face(clockwise)).axes
    (touched,) = (a for a in below if named(a) == "face touched at y (mm)")
    phi = np.linspace(0.0, 2 * np.pi, 37)
    assert touched.get_lines()[0].get_xdata() == pytest.approx(np.degrees(phi))
    assert touched.get_lines()[0].get_ydata() == pytest.approx((10 if clockwise else -10) * np.sin(phi), abs=1e-9)
    (arrow,) = (t for t in cam.texts if not t.get_text())
    begin, end = np.array(arrow.xyann), np.array(arrow.xy)
    assert begin[1] > 0 and end[1] == pytest.approx(begin[1])
    assert bool(begin[0] * end[1] - begin[1] * end[0] > 0) is not clockwise
    assert [np.hypot(*begin), np.hypot(*end)] == pytest.approx([9.0, 9.0]), "three tenths of the base circle"


def test_an_arc_that_passes_zero_is_drawn_at_both_ends_of_the_turn() -> None:
    """By half the preload that is needed the face lifts off from 300 to 420 degrees."""
    figure = draw(eccentric_face(cosine="10 mm", preload=0.8))
    (axis,) = (a for a in figure.axes if named(a) == "contact force (N)")
    boxes = [patch.get_extents().transformed(axis.transData.inverted()) for patch in axis.patches]
    assert sorted((round(box.x0), round(box.x1)) for box in boxes) == [(0, 60), (300, 360)]


def test_what_is_cut_away_is_not_drawn_as_what_is_left() -> None:
    cut = run(CamContour(allow_undercut=True), given.drive(given.MODIFIED_SINE, given.FLAT | {"distance": "2 mm"}))
    above, radius, *_ = draw(cut).axes
    away, left = (np.isfinite(line(above, name).get_xdata()) for name in ("cut away", "contour"))
    assert away.any() and np.array_equal(left, ~away)
    assert radius.patches, "a band where it is cut away"
    assert not (np.isfinite(radius.get_lines()[0].get_ydata()) & away).any()


def test_a_counter_cam_and_a_linkage_are_drawn() -> None:
    counter = given.FOLLOWER | {"counter": given.COUNTER}
    asked = CamContour(points=36, chord_tolerance="50 um", wheel_radius="75 mm")
    pair = run(asked, given.drive(given.SMOOTH, counter))
    assert len([x for x in draw(pair).axes[0].get_lines() if x.get_label() == "roller"]) == 2
    linked = run(asked, given.drive(given.SMOOTH, given.FOLLOWER, linkage=given.FOUR_BAR))
    (panel,) = (a for a in draw(linked).axes if named(a) == "transmission angle (\u00b0)")
    assert panel.get_lines()[0].get_ydata() == pytest.approx(np.degrees(linked.transmission_angle.values))
