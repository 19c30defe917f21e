"""Contours of a cam and a counter cam made by hand: every quantity, verdicts beside their limits, report and figure."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import cam_files_to_study as given
import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of, with_answer

from wucht.cams.shape import Extreme, Shape
from wucht.cams.undercut import RadiusAt
from wucht.cams.workshop.points import PointList
from wucht.plots.style import COLOURS
from wucht.studies.cam_contour.computation import Curves, Findings, Plan, contour_verdict
from wucht.studies.cam_contour.contact_load import ContactHistory
from wucht.studies.cam_contour.dataset import dataset, report
from wucht.studies.cam_contour.spec import CamContour

PHI = np.linspace(0.0, 2 * math.pi, 9)
DEG = math.pi / 180
CAM = Shape(
    RadiusAt(0.020, 1.0), RadiusAt(0.090, 2.0), Extreme(40 * DEG, 3.0), Extreme(0.030, 0.5), Extreme(0.050, 3.5), (), (),
    0.025, RadiusAt(0.080, 2.5), "roller",
)  # fmt: skip
COUNTER = Shape(
    RadiusAt(0.015, 1.5), None, Extreme(42 * DEG, 4.0), Extreme(0.028, 0.25), Extreme(0.060, 4.5), (), (), 0.018, None, "roller"
)


def planned(permitted: Any = None, shapes: Any = None, **asked: Any) -> Plan:
    follower = given.FOLLOWER | ({"counter": given.COUNTER} if shapes is None or len(shapes) > 1 else {})
    drive = given.drive(given.SMOOTH, follower)
    law = drive.motion_law.function
    asked |= {"contact": {"inertia": 0.02, "width": "12 mm"}, "speed": 30.0} | ({"permitted": permitted} if permitted else {})
    spec = CamContour(**asked)
    contact: Any = SimpleNamespace(mean_speed=30.0)
    names = list(shapes or {"cam": CAM, "counter": COUNTER})
    cams: Any = {name: SimpleNamespace(roller_radius=0.010 + 0.002 * k) for k, name in enumerate(names)}
    return Plan(spec, drive, law, drive.follower_law(law), cams, shapes or {"cam": CAM, "counter": COUNTER}, contact, None)


def curves(first: float) -> Curves:
    contour = (first + 0.04) * np.exp(1j * PHI)
    return Curves(
        contour, contour * 1.25, np.exp(1j * (PHI + first)), 20.0 + first + PHI, first + np.cos(PHI), first + 0.1 * np.sin(PHI)
    )


def history(phi: np.ndarray, scale: float = 1.0, lift_off: Any = None) -> ContactHistory:
    wave = scale * (2.0 + np.sin(phi))
    return ContactHistory(
        phi, {"cam": 100 * wave, "counter": 50 * (4 * scale - wave)}, {"cam": 1e8 * wave, "counter": 3e7 * (4 * scale - wave)},
        -7.0 * scale * np.cos(phi), lift_off or {"cam": (), "counter": ()}, 12.5,
    )  # fmt: skip


FINE = np.linspace(0.0, 2 * math.pi, 3601)


def made(**other: Any) -> Findings:
    points = {
        "cam": PointList(np.array([0.0, 2.0]), np.array([1 + 2j, 3 + 4j]), np.array([1j, -1.0])),
        "counter": PointList(np.array([1.0, 3.0, 5.0]), np.array([5 + 6j, 7 + 8j, 9 + 10j]), np.array([1.0, 1j, -1j])),
    }
    common = {
        "angles": PHI, "output": np.stack([k + PHI for k in range(3)]), "lever": np.stack([10 + k + PHI for k in range(3)]),
        "transmission": 1.0 + 0.25 * np.cos(PHI), "curves": {"cam": curves(0.0), "counter": curves(0.01)},
        "points_to_mill": points, "contact_history": history(PHI), "dense_history": history(FINE, 2.0), "notes": ("a note",),
    }  # fmt: skip
    return Findings(**common | other)


@pytest.fixture(scope="module")
def plan() -> Plan:
    permitted = {"pressure_angle": "44 deg", "least_radius": "14 mm", "contact_pressure": "700 MPa"}
    return replace(planned(permitted, wheel_radius="70 mm"), smallest=None)


@pytest.fixture(scope="module")
def result(plan: Plan) -> xr.Dataset:
    return titled(dataset(plan, made()))


# --- the Dataset ---


def test_curves_of_each_cam(result: xr.Dataset) -> None:
    assert result.cam.values.tolist() == ["cam", "counter"] and result.cam_angle.values == pytest.approx(PHI)
    for i, first in enumerate((0.0, 0.01)):
        of = curves(first)
        expected = {
            "contour_x": of.contour.real, "contour_y": of.contour.imag, "pitch_x": 1.25 * of.contour.real,
            "pitch_y": 1.25 * of.contour.imag, "normal_x": of.normal.real, "normal_y": of.normal.imag,
            "curvature": of.curvature, "uncut": of.uncut, "pressure_angle": of.pressure_angle,
            "contact_force": (history(PHI).force["cam"], history(PHI).force["counter"])[i],
            "contact_pressure": (history(PHI).pressure["cam"], history(PHI).pressure["counter"])[i],
        }  # fmt: skip
        for name, values in expected.items():
            assert result[name].values[i] == pytest.approx(values), name
    assert result.camshaft_torque.values == pytest.approx(-7 * np.cos(PHI))
    for k, suffix in enumerate(("", "_velocity", "_acceleration")):
        assert result[f"output{suffix}"].values == pytest.approx(k + PHI)
        assert result[f"follower{suffix}"].values == pytest.approx(10 + k + PHI)
        assert result[f"follower{suffix}"].attrs["units"] == "rad" + ("", "/rad", "/rad^2")[k]
    assert result.transmission_angle.values == pytest.approx(1 + 0.25 * np.cos(PHI))


def test_points_to_mill(result: xr.Dataset) -> None:
    assert result.mill_cam.values.tolist() == [0, 0, 1, 1, 1] and result.mill_angle.values.tolist() == [0, 2, 1, 3, 5]
    assert result.mill_x.values.tolist() == [1, 3, 5, 7, 9] and result.mill_y.values.tolist() == [2, 4, 6, 8, 10]
    assert result.mill_normal_x.values.tolist() == [0, -1, 1, 0, 0] and result.mill_normal_y.values.tolist() == [1, 0, 0, 1, -1]
    cams = result.wucht.summary["cams"]
    assert [cams[name]["points_to_mill"] for name in ("cam", "counter")] == [2, 3]


def test_layout_and_limits(plan: Plan, result: xr.Dataset) -> None:
    assert result.roller_radius.values == pytest.approx([0.010, 0.012])
    assert result.base_radius.values.tolist() == [0.030, 0.028] and float(result.pivot) == pytest.approx(0.110)
    assert float(result.permitted_pressure_angle) == pytest.approx(44 * DEG) and float(
        result.permitted_radius
    ) == pytest.approx(0.014)
    assert float(result.permitted_contact_pressure) == pytest.approx(7e8) and float(result.wheel_radius) == pytest.approx(0.07)
    assert float(result.common_pressure_angle) == pytest.approx(45 * DEG), "of a lever"
    bare = dataset(planned(), made())
    assert all(math.isnan(float(bare[f"permitted_{n}"])) for n in ("pressure_angle", "radius", "contact_pressure"))


def test_the_summary_is_of_both_cams(result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert (s["outcome"], s["follower"], s["clockwise"], s["undercut"]) == ("cuttable", "oscillating-roller", False, False)
    assert (s["min_curvature_radius"], s["min_hollow_radius"]) == (0.015, 0.090)
    assert s["max_pressure_angle"] == pytest.approx(42 * DEG) and (s["base_radius"], s["largest_radius"]) == (0.030, 0.050)
    assert s["min_transmission_angle"] == pytest.approx(0.75)
    assert s["cams"]["cam"] == {
        "min_curvature": {"radius": 0.020, "at": 1.0}, "min_hollow": {"radius": 0.090, "at": 2.0},
        "largest_wheel": {"radius": 0.080, "at": 2.5}, "largest_roller": 0.025,
        "max_pressure_angle": {"angle": pytest.approx(40 * DEG), "at": 3.0}, "base_radius": 0.030, "largest_radius": 0.050,
        "undercut": [], "missing": [], "points_to_mill": 2,
    }  # fmt: skip
    counter = s["cams"]["counter"]
    assert counter["min_hollow"] is None is counter["largest_wheel"] and counter["largest_radius"] == 0.060


def test_the_largest_of_the_contact_is_that_of_the_denser_angles(result: xr.Dataset) -> None:
    """Of twice the size here: 600 N at 90 degrees, of the counter cam 350 N at 270; the torque's size at either end."""
    contact = result.wucht.summary["contact"]
    assert contact["max_force"]["cam"] == {"value": pytest.approx(600.0), "at": pytest.approx(math.pi / 2, abs=2e-3)}
    assert contact["max_force"]["counter"] == {"value": pytest.approx(300.0), "at": pytest.approx(1.5 * math.pi, abs=2e-3)}
    assert contact["max_pressure"]["cam"]["value"] == pytest.approx(6e8)
    assert contact["max_pressure"]["counter"]["value"] == pytest.approx(1.8e8)
    assert contact["max_torque"]["value"] == pytest.approx(14.0) and contact["max_torque"]["at"] == 0.0
    assert (contact["mean_speed"], contact["least_preload"]) == (30.0, 12.5)
    assert contact["lift_off"] == {"cam": [], "counter": []}


def test_arcs_have_their_cams_and_kinds() -> None:
    cut = replace(CAM, undercut=((1.0, 2.0),), missing=((0.5, 2.5), (6.0, 7.0)))
    plan = planned(shapes={"cam": cut, "counter": COUNTER})
    off = {"cam": ((3.0, 4.0),), "counter": ((5.0, 6.0),)}
    some = dataset(plan, made(dense_history=history(FINE, 1.0, off), points_to_mill={}))
    arcs = [some[f"arc_{n}"].values.tolist() for n in ("cam", "of", "begin", "end")]
    assert list(zip(*arcs, strict=True)) == [
        ("cam", "undercut", 1.0, 2.0), ("cam", "missing", 0.5, 2.5), ("cam", "missing", 6.0, 7.0),
        ("cam", "lift-off", 3.0, 4.0),
        ("counter", "lift-off", 5.0, 6.0),
    ]  # fmt: skip
    s = some.wucht.summary
    assert s["undercut"] is True and s["cams"]["cam"]["missing"] == [[0.5, 2.5], [6.0, 7.0]]
    assert s["cams"]["cam"]["undercut"] == [[1.0, 2.0]] and s["cams"]["cam"]["points_to_mill"] == 0
    assert s["contact"]["lift_off"] == {"cam": [[3.0, 4.0]], "counter": [[5.0, 6.0]]}


def test_without_contact_and_linkage_there_are_no_numbers(plan: Plan) -> None:
    some = dataset(plan, made(contact_history=None, dense_history=None, transmission=None))
    assert np.isnan(some.contact_force.values).all() and np.isnan(some.camshaft_torque.values).all()
    assert np.isnan(some.transmission_angle.values).all()
    assert some.wucht.summary["contact"] is None is some.wucht.summary["min_transmission_angle"]


def test_a_large_pressure_angle_is_told_where_none_is_permitted() -> None:
    steep = {"cam": replace(CAM, pressure_angle=Extreme(46 * DEG, 3.0)), "counter": COUNTER}
    told = warnings_of(dataset(planned(shapes=steep), made()))
    assert told[0] == "a note" and told[1].startswith("the pressure angle reaches 46°")
    assert warnings_of(dataset(planned({"pressure_angle": "50 deg"}, steep), made())) == ["a note"]
    assert warnings_of(dataset(planned({"least_radius": "1 mm"}, steep), made()))[1].startswith(
        "the pressure angle reaches 46°"
    )
    assert warnings_of(dataset(planned(), made())) == ["a note"]


# --- the verdict ---


def verdict(permitted: Any = None, shapes: Any = None, **other: Any) -> tuple[str, str]:
    return contour_verdict(planned(permitted, shapes), made(**other))


def test_what_can_be_cut() -> None:
    assert verdict() == (
        "cuttable", f"cuttable: least convex radius 15 mm at {math.degrees(1.5):.4g}°, pressure angle at most 42° at "
        f"{math.degrees(4.0):.4g}°",
    )  # fmt: skip
    hollow = {"cam": replace(CAM, convex=None, pressure_angle=Extreme(0.0, 0.0))}
    assert verdict(shapes=hollow, dense_history=None)[1] == "cuttable: the contour is nowhere convex"


@pytest.mark.parametrize(("key", "within", "beyond", "clause"), [
    ("pressure_angle", 42 * DEG, 41.99 * DEG, f"pressure angle 42° at {math.degrees(4.0):.4g}° (permitted 41.99°)"),
    ("least_radius", 0.015, 0.01501, "least radius 15 mm (permitted 15.01 mm)"),
    ("shaft_radius", 0.028, 0.02801, "base circle 28 mm (permitted 28.01 mm, that of the shaft)"),
    ("contact_pressure", 6.0001e8, 5.99e8, "contact pressure 600 MPa (permitted 599 MPa)"),
])  # fmt: skip
def test_limits_on_both_sides(key: str, within: float, beyond: float, clause: str) -> None:
    """The worse of both cams counts; a limit that is just reached is kept."""
    assert verdict({key: within})[0] == "cuttable"
    assert verdict({key: beyond}) == ("not-permitted", f"cuttable, but outside the permitted limits: {clause}")


def test_several_violations_and_where_it_lifts_off() -> None:
    off = {"cam": ((1.0, 2.0),), "counter": ()}
    lifting = history(FINE, 2.0, off)
    clause = f"the roller of the cam lifts off from {math.degrees(1):.4g}° to {math.degrees(2):.4g}° "
    clause += "(a preload of 12.5 N m holds it)"
    label, sentence = verdict(dense_history=lifting)
    assert label == "lifts-off" and sentence.endswith(f"; {clause}")
    label, sentence = verdict({"shaft_radius": 0.03, "least_radius": 0.02}, dense_history=lifting)
    assert label == "not-permitted" and sentence.count("permitted ") == 3 and sentence.endswith(f"; {clause}")
    single = {"cam": CAM}
    _, sentence = contour_verdict(planned(shapes=single), made(dense_history=history(FINE, 2.0, {"cam": ((1.0, 2.0),)})))
    assert "; the roller lifts off from" in sentence
    groove = {"cam": CAM, "outer": replace(COUNTER, part="roller")}
    assert contour_verdict(planned(shapes=groove), made(dense_history=lifting))[0] == "cuttable"


def test_what_is_cut_away() -> None:
    arcs = tuple((k + 0.0, k + 0.5) for k in range(5))
    texts = [f"from {math.degrees(a):.4g}° to {math.degrees(b):.4g}°" for a, b in arcs]
    cut = {"cam": replace(CAM, undercut=arcs[:1]), "counter": replace(COUNTER, missing=arcs, undercut=arcs[:1], part="face")}
    label, sentence = verdict(shapes=cut)
    assert label == "undercut"
    assert sentence == (
        f"undercut: the roller cuts the cam away {texts[0]}; the face cuts the counter cam away {' and '.join(texts[:3])} and "
        "on 2 more arcs"
    )


# --- the report ---


def test_the_lines_of_the_report(result: xr.Dataset) -> None:
    d = math.degrees
    assert report(result)[2:] == [
        f"  cam          base circle 30 mm, largest radius 50 mm, pressure angle at most 40° at {d(3):.4g}°",
        f"               convex radius at least 20 mm at {d(1):.4g}°; hollow radius at least 90 mm at {d(2):.4g}°",
        "               roller at most 25 mm without cutting the contour away",
        f"               grinding wheel at most 80 mm (at {d(2.5):.4g}°)",
        f"  counter cam  base circle 28 mm, largest radius 60 mm, pressure angle at most 42° at {d(4):.4g}°",
        f"               convex radius at least 15 mm at {d(1.5):.4g}°; hollow none",
        "               roller at most 18 mm without cutting the contour away",
        f"  transmission angle of the linkage at least {d(0.75):.4g}°",
        "  contact      cam at most 600 N at 90°, counter cam at most 300 N at 270°, at 286.5 rpm",
        "  Hertz        cam at most 600 MPa at 90°, counter cam at most 180 MPa at 270°",
        "  camshaft     torque at most 14 N m at 0°",
        "  preload      at least 12.5 N m to keep contact over the whole turn",
        "  to mill      5 points, chords within 1 um, 5 decimals in mm",
    ]


# --- the figure ---


def test_limits_and_lines_of_the_panels(result: xr.Dataset) -> None:
    cam, *panels = drawn("cam-contour", result).axes
    by_name = {" ".join(a.get_ylabel().split()): a for a in panels}
    assert list(by_name) == [
        "radius of curvature (mm)", "pressure angle (°)", "transmission angle (°)", "contact force (N)",
        "contact pressure (MPa)", "torque of the camshaft (N·m)",
    ]  # fmt: skip
    expected = {
        "radius of curvature (mm)": 1e3 / result.curvature.values,
        "pressure angle (°)": np.degrees(result.pressure_angle.values),
        "contact force (N)": result.contact_force.values, "contact pressure (MPa)": 1e-6 * result.contact_pressure.values,
    }  # fmt: skip
    for name, rows in expected.items():
        lines = {str(x.get_label()): x for x in by_name[name].get_lines()}
        for label, row in zip(("cam", "counter cam"), rows, strict=True):
            assert lines[label].get_xdata() == pytest.approx(np.degrees(PHI))
            assert lines[label].get_ydata() == pytest.approx(row), name
    limits = {
        name: sorted(x.get_ydata()[0] for x in axis.get_lines() if x.get_linestyle() == ":") for name, axis in by_name.items()
    }
    assert limits["radius of curvature (mm)"] == pytest.approx([-70.0, 14.0]), "a wheel limits hollow radii"
    assert limits["pressure angle (°)"] == pytest.approx([-44.0, 44.0])
    assert limits["contact pressure (MPa)"] == pytest.approx([700.0])
    assert by_name["transmission angle (°)"].get_lines()[0].get_ydata() == pytest.approx(np.degrees(1 + 0.25 * np.cos(PHI)))
    assert by_name["torque of the camshaft (N·m)"].get_lines()[0].get_ydata() == pytest.approx(-7 * np.cos(PHI))
    shown = {str(x.get_label()): x for x in cam.get_lines()}
    assert shown["contour"].get_xdata() == pytest.approx(1e3 * result.contour_x.values[0])
    assert shown["contour of the counter cam"].get_ydata() == pytest.approx(1e3 * result.contour_y.values[1])
    circles = [x for x in cam.get_lines() if str(x.get_label()) == "base circle"]
    assert [x.get_xdata().max() for x in circles] == pytest.approx([30.0, 28.0])
    rollers = [x for x in cam.get_lines() if str(x.get_label()) == "roller"]
    centres = [((x.get_xdata().max() + x.get_xdata().min()) / 2, np.ptp(x.get_xdata()) / 2) for x in rollers]
    assert centres == [pytest.approx((50.0, 10.0)), pytest.approx((62.5, 12.0))]
    levers = [(list(x.get_xdata()), list(x.get_ydata())) for x in cam.get_lines() if str(x.get_label()) == "lever"]
    assert levers == [
        ([pytest.approx(110.0), pytest.approx(50.0)], [0, 0.0]),
        ([pytest.approx(110.0), pytest.approx(62.5)], [0, 0.0]),
    ]


def test_arcs_that_are_missing_or_lift_off_are_shaded() -> None:
    cut = replace(CAM, missing=((6.0, 7.0),))
    plan = planned(shapes={"cam": cut, "counter": COUNTER})
    off = {"cam": (), "counter": ((1.0, 2.0),)}
    some = titled(dataset(plan, made(dense_history=history(FINE, 1.0, off), points_to_mill={}, transmission=None)))
    cam, radius, _, force, *_ = drawn("cam-contour", some).axes

    def bands(axis: Any) -> list[tuple[float, float]]:
        boxes = [p.get_extents().transformed(axis.transData.inverted()) for p in axis.patches]
        return [(b.x0, b.x1) for b in boxes]

    d = math.degrees
    assert bands(radius) == [pytest.approx((d(6), 360.0)), pytest.approx((0.0, d(7) - 360.0))]
    assert bands(force) == [pytest.approx((d(1), d(2)))]
    away = next(x for x in cam.get_lines() if str(x.get_label()) == "cut away")
    assert np.isfinite(away.get_xdata()).tolist() == [True, *[False] * 7, True] and away.get_color() == COLOURS[3]
    contour = next(x for x in cam.get_lines() if str(x.get_label()) == "contour")
    assert np.isnan(contour.get_xdata()).tolist() == [True, *[False] * 7, True]


@pytest.mark.parametrize("clockwise", [True, False])
def test_the_arrow_turns_as_the_cam_does(result: xr.Dataset, clockwise: bool) -> None:
    axis = drawn("cam-contour", with_answer(result, clockwise=clockwise)).axes[0]
    (arrow,) = (t for t in axis.texts if not t.get_text())
    begin, end = np.array(arrow.xyann), np.array(arrow.xy)
    assert begin[1] > 0 and end[1] == pytest.approx(begin[1])
    assert bool(begin[0] * end[1] - begin[1] * end[0] > 0) is not clockwise
    assert [np.hypot(*begin), np.hypot(*end)] == pytest.approx([9.0, 9.0]), "three tenths of the base circle"
