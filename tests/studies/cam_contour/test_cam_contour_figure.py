"""The figure of ``cam-contour``: the cam to scale, the panels and their limits; drawn from the Dataset alone."""

from __future__ import annotations

import io
from typing import Any

import cam_files_to_study as given
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from tests.refusals import refused

from wucht import CamContour, draw, run

pytestmark = pytest.mark.usefixtures("coarse_angles")

CONTACT = {"inertia": 0.02, "preload": 5.0, "width": "12 mm"}


def line(axis: Axes, name: str) -> Any:
    return next(drawn for drawn in axis.get_lines() if drawn.get_label() == name)


def named(axis: Axes) -> str:
    """The name of its ordinate, in however many lines."""
    return " ".join(axis.get_ylabel().split())


def names(result: xr.Dataset) -> list[str]:
    [legend] = draw(result).legends
    return [text.get_text() for text in legend.get_texts()]


@pytest.fixture(scope="module")
def lever() -> xr.Dataset:
    permitted = {"pressure_angle": "15 deg", "least_radius": "5 mm", "contact_pressure": "1 GPa"}
    asked = CamContour(permitted=permitted, contact=CONTACT, speed="700 rpm", wheel_radius="75 mm")
    return run(asked, given.drive(given.SMOOTH, given.FOLLOWER))


@pytest.fixture(scope="module")
def flat() -> xr.Dataset:
    return run(CamContour(), given.drive(given.MODIFIED_SINE, given.FLAT))


@pytest.mark.slow
def test_the_cam_is_drawn_to_scale(lever: xr.Dataset) -> None:
    above = draw(lever).axes[0]
    assert above.get_aspect() == 1
    contour = line(above, "contour")
    assert contour.get_xdata() == pytest.approx(1e3 * lever.contour_x.values[0])
    base = line(above, "base circle")
    assert np.hypot(base.get_xdata(), base.get_ydata()) == pytest.approx(1e3 * lever.wucht.summary["base_radius"])
    roller = line(above, "roller")
    gaps = np.abs((roller.get_xdata() + 1j * roller.get_ydata())[:, None] - (contour.get_xdata() + 1j * contour.get_ydata()))
    assert gaps.min() < 0.1, "the roller touches the contour (mm)"
    assert line(above, "pivot").get_xdata() == [pytest.approx(110)]
    arm = line(above, "lever")
    assert np.hypot(np.diff(arm.get_xdata()), np.diff(arm.get_ydata())) == pytest.approx([90])
    assert line(above, "pitch curve").get_linestyle() == "--"


def test_the_panels_and_their_limits(lever: xr.Dataset) -> None:
    figure = draw(lever)
    above, *below = figure.axes
    assert [named(a) for a in below] == [
        "radius of curvature (mm)", "pressure angle (°)", "contact force (N)", "contact pressure (MPa)",
        "torque of the camshaft (N·m)", "motion of the lever (°)",
    ]  # fmt: skip
    shown = [
        1e3 / lever.curvature.values[0], np.degrees(lever.pressure_angle.values[0]), lever.contact_force.values[0],
        1e-6 * lever.contact_pressure.values[0], lever.camshaft_torque.values, np.degrees(lever.follower.values),
    ]  # fmt: skip
    for axis, values in zip(below, shown, strict=True):
        drawn = np.asarray(axis.get_lines()[0].get_ydata())
        assert np.isfinite(drawn).any() and drawn[np.isfinite(drawn)] == pytest.approx(values[np.isfinite(drawn)])
    assert {a.get_xlabel() for a in below} == {"cam angle (°)"}
    assert above.get_xlabel() == "x (mm), cam at 0°"
    limits = [
        sorted({float(np.asarray(x.get_ydata())[0]) for x in axis.get_lines() if x.get_label() == "permitted"})
        for axis in below
    ]
    assert [pytest.approx(found) for found in limits] == [[5], [-15, 15], [], [1000], [], []]
    assert line(below[0], "grinding wheel").get_ydata()[0] == -75
    assert below[2].patches, "a band where the roller lifts off"
    assert {"contour", "pitch curve", "base circle", "roller", "lever", "pivot", "permitted", "lifts off"} <= set(names(lever))
    assert "(permitted 15°)" in " ".join(text.get_text() for text in figure.texts).replace("\n", " "), (
        "in small type, since it is long"
    )


def test_a_flat_face_has_no_pressure_angle(flat: xr.Dataset) -> None:
    above, *below = draw(flat).axes
    assert [named(a) for a in below] == ["radius of curvature (mm)", "motion of the follower (mm)"]
    assert {float(x) for x in line(above, "face, touched part").get_xdata()} == {40.0}
    assert "roller" not in names(flat)


@pytest.fixture(scope="module")
def groove() -> xr.Dataset:
    return run(CamContour(), given.drive(given.SMOOTH, given.FOLLOWER | {"groove": True}))


@pytest.mark.slow
def test_counter_cam_groove_linkage_and_undercut_can_be_drawn(groove: xr.Dataset) -> None:
    counter = given.FOLLOWER | {"counter": given.COUNTER}
    pair = run(CamContour(chord_tolerance="50 um"), given.drive(given.SMOOTH, counter))
    assert {"contour of the counter cam", "counter cam", "common limit"} <= set(names(pair))
    drawn = draw(pair).axes[0].get_lines()
    assert len([x for x in drawn if x.get_label() == "roller"]) == 2
    colours = {name: [x.get_color() for x in drawn if x.get_label() in named] for name, named in {
        "base": ("base circle",), "cams": ("contour", "contour of the counter cam")}.items()}  # fmt: skip
    assert colours["base"] == colours["cams"], "whose base circle it is"
    assert "outer flank" in names(groove)
    linked = draw(run(CamContour(), given.drive(given.SMOOTH, given.FOLLOWER, linkage=given.FOUR_BAR)))
    assert [named(a) for a in linked.axes[3:]] == ["transmission angle (°)", "motion of the lever (°)"]
    cut = run(CamContour(allow_undercut=True), given.drive(given.MODIFIED_SINE, given.FLAT | {"distance": "2 mm"}))
    above, *below = draw(cut).axes
    away, left = (np.isfinite(line(above, name).get_xdata()) for name in ("cut away", "contour"))
    assert away.any()
    assert np.array_equal(left, ~away), "what is cut away is not drawn as what is left"
    assert below[0].patches, "a band where it is cut away"
    assert np.array_equal(np.isfinite(below[0].get_lines()[0].get_ydata()) & away, np.zeros(len(away), bool))
    assert [named(a) for a in below] == ["radius of curvature (mm)", "motion of the follower (mm)"]


def test_words_lie_beside_each_other(groove: xr.Dataset) -> None:
    """The legend below the names of the axes, and "hollow" beside the curves: measured as they are drawn."""
    figure = draw(groove)
    figure.canvas.draw()
    _, *below = figure.axes
    [legend] = figure.legends
    assert legend.get_window_extent().y1 < min(a.xaxis.label.get_window_extent().y0 for a in below) - 3
    [hollow] = below[0].texts
    assert hollow.get_text() == "hollow"
    assert below[0].get_window_extent().x1 < hollow.get_window_extent().x0
    assert hollow.get_window_extent().x1 < below[1].yaxis.label.get_window_extent().x0


def test_forces_that_are_nowhere_have_no_panels() -> None:
    asked = CamContour(
        contact={"inertia": 0.02, "preload": "-50 N m", "width": "12 mm"}, speed="60 rpm", chord_tolerance="50 um"
    )
    _, *below = draw(run(asked, given.drive(given.SMOOTH, given.FOLLOWER))).axes
    assert [named(a) for a in below] == ["radius of curvature (mm)", "pressure angle (°)"]


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format_of_the_contour_figure(lever: xr.Dataset, ending: str) -> None:
    file = io.BytesIO()
    draw(lever).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 5000


def test_a_dataset_that_is_no_contour_is_refused(flat: xr.Dataset) -> None:
    with refused("cam-contour", given=None):
        draw(flat.drop_vars("contour_x"))


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


def test_how_a_linkage_moves() -> None:
    """The transmission angle is drawn in degrees, to a right angle at most."""
    result = run(
        CamContour(points=36, chord_tolerance="50 um"), given.drive(given.SMOOTH, given.FOLLOWER, linkage=given.FOUR_BAR)
    )
    (panel,) = (a for a in draw(result).axes if named(a) == "transmission angle (\u00b0)")
    assert panel.get_lines()[0].get_ydata() == pytest.approx(np.degrees(result.transmission_angle.values))
    assert panel.get_ylim() == (0, 92)


def test_an_arc_that_passes_zero_is_drawn_at_both_ends_of_the_turn() -> None:
    """By half the preload that is needed the face lifts off from 300 to 420 degrees."""
    figure = draw(eccentric_face(cosine="10 mm", preload=0.8))
    (axis,) = (a for a in figure.axes if named(a) == "contact force (N)")
    boxes = [patch.get_extents().transformed(axis.transData.inverted()) for patch in axis.patches]
    assert sorted((round(box.x0), round(box.x1)) for box in boxes) == [(0, 60), (300, 360)]
