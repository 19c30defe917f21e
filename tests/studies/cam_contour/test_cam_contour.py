"""The study ``cam-contour``: an eccentric circle, all followers, groove, counter cam, linkage, contact, sizing, bad input."""

from __future__ import annotations

import math
from typing import Any

import cam_files_to_study as given
import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from wucht import CamContour, draw, report, run
from wucht.cams.workshop.points import chord_deviation
from wucht.studies.cam_contour.export import drive_of, points_to_mill

pytestmark = pytest.mark.usefixtures("coarse_angles")

LEVER_CONTACT = {"inertia": "0.02 kg m^2", "preload": "50 N m", "stiffness": "30 N m/rad", "width": "12 mm"}
ROD_CONTACT = {"mass": "0.4 kg", "preload": "60 N", "stiffness": "8 N/mm", "width": "15 mm"}


def answered(law: dict[str, Any], follower: dict[str, Any], tables: dict[str, Any] | None = None, **asked: Any) -> xr.Dataset:
    return run(CamContour(**asked), given.drive(law, follower, **(tables or {})))


def contour(result: xr.Dataset, i: int = 0) -> np.ndarray:
    return np.asarray(result.contour_x.values[i] + 1j * result.contour_y.values[i])


def pitch(result: xr.Dataset, i: int = 0) -> np.ndarray:
    return np.asarray(result.pitch_x.values[i] + 1j * result.pitch_y.values[i])


@pytest.fixture(scope="module")
def circle() -> xr.Dataset:
    return run(CamContour(), given.drive(**given.eccentric()))


@pytest.fixture(scope="module")
def pair() -> xr.Dataset:
    follower, permitted = given.FOLLOWER | {"counter": given.COUNTER}, {"pressure_angle": "45 deg"}
    return answered(given.FIVE, follower, contact=LEVER_CONTACT, speed="300 rpm", permitted=permitted)


@pytest.fixture(scope="module")
def groove() -> xr.Dataset:
    contact = LEVER_CONTACT | {"preload": 0.0, "stiffness": 0.0}
    return answered(given.SMOOTH, given.FOLLOWER | {"groove": True}, contact=contact, speed="300 rpm")


def test_an_eccentric_circle_by_its_numbers(circle: xr.Dataset) -> None:
    """Of the cases: theta', theta'', pressure angle, contour point and radius at cam angle 0."""
    assert float(circle.follower_velocity[0]) == pytest.approx(-0.12244898, abs=1e-7)
    assert float(circle.follower_acceleration[0]) == pytest.approx(-0.06621334, abs=1e-6)
    assert abs(math.degrees(float(circle.pressure_angle[0, 0]))) == pytest.approx(11.190639, rel=1e-5)
    assert contour(circle)[0] == pytest.approx(0.03370068 - 0.04504532j, abs=1e-8)
    s = circle.wucht.summary
    assert s["min_curvature_radius"] == pytest.approx(given.R, rel=1e-4)
    assert s["base_radius"] == pytest.approx(given.R - given.E, abs=1e-9)
    assert s["largest_radius"] == pytest.approx(given.R + given.E, abs=1e-9)
    assert s["undercut"] is False
    assert s["outcome"] == "cuttable"
    assert s["min_hollow_radius"] is None
    at = np.deg2rad(np.arange(0, 360, 0.05))  # tan alpha = (l (1 - s) + d cos theta)/(-d sin theta), s from differences
    theta = np.array([given.lever_on_circle(x) for x in at])
    s1 = (np.roll(theta, -1) - np.roll(theta, 1)) / (2 * np.deg2rad(0.05))
    tangent = (given.ARM * (1 - s1) + given.PIVOT * np.cos(theta)) / (given.PIVOT * np.sin(theta))
    assert s["max_pressure_angle"] == pytest.approx(np.abs(np.arctan(tangent)).max(), rel=1e-5)


def test_an_eccentric_circle_is_one_all_the_way_round(circle: xr.Dataset) -> None:
    assert np.abs(contour(circle) - given.E) == pytest.approx(given.R, abs=1e-8)
    assert np.abs(pitch(circle) - contour(circle)) == pytest.approx(given.ROLLER, rel=1e-12)
    normal = circle.normal_x.values[0] + 1j * circle.normal_y.values[0]
    assert np.abs(contour(circle) - given.E - given.R * normal).max() < 2e-8
    assert circle.curvature.values == pytest.approx(1 / given.R, rel=1e-3)
    assert circle.uncut.values == pytest.approx(given.R / (given.R + given.ROLLER), rel=1e-3)


def test_points_to_mill_keep_the_chord_tolerance(circle: xr.Dataset) -> None:
    result = run(CamContour(chord_tolerance="20 um", spacing="1 m"), given.drive(**given.eccentric(90)))
    points = points_to_mill(result, "cam")
    deviation = chord_deviation(drive_of(result).make_cams(drive_of(result).motion_law.function)["cam"].contour, points.phi)
    kept = 20e-6
    assert 0.5 * kept < deviation <= kept
    assert result.wucht.summary["cams"]["cam"]["points_to_mill"] == len(points.phi)
    # of a circle the sagitta is h^2/(8 R)
    assert points.spacing.max() == pytest.approx(math.sqrt(8 * given.R * kept), rel=0.1)
    assert np.abs(points.position - given.E - given.R * points.normal).max() < 1e-6


def test_the_turn_closes(circle: xr.Dataset, pair: xr.Dataset, groove: xr.Dataset) -> None:
    for result in (circle, pair, groove):
        for name in ("contour_x", "contour_y", "pitch_x", "curvature", "pressure_angle"):
            values = result[name].values
            assert values[:, -1] == pytest.approx(values[:, 0], rel=1e-9, abs=1e-12)


def test_a_counter_cam_holds_the_same_lever(pair: xr.Dataset) -> None:
    assert pair.cam.values.tolist() == ["cam", "counter"]
    back = np.exp(1j * pair.cam_angle.values)
    centres = [pitch(pair, i) * back - given.PIVOT for i in (0, 1)]
    between = np.angle(centres[1] / centres[0])
    assert between == pytest.approx(math.radians(120 + 143 - 360), abs=1e-12), "the arms keep their angle"
    assert np.abs(contour(pair, 1) - pitch(pair, 1)) == pytest.approx(0.010)
    assert pair.wucht.summary["contact"]["lift_off"] == {"cam": [], "counter": []}
    assert (pair.contact_force.values > 0).all()


def test_the_forces_of_a_pair_move_the_lever(pair: xr.Dataset) -> None:
    """Grip times force of the two: the lever's inertia and its spring; and the camshaft gives what the lever takes."""
    speed, motion = 10 * math.pi, pair.follower.values
    needed = 0.02 * speed**2 * pair.follower_acceleration.values + 30 * motion
    torque = np.array([90e-3 * np.cos(pair.pressure_angle.values[i]) * pair.contact_force.values[i] for i in (0, 1)])
    assert torque[0] - torque[1] == pytest.approx(needed, abs=1e-9)
    assert pair.camshaft_torque.values == pytest.approx(needed * pair.follower_velocity.values, abs=1e-9)


def test_a_groove_has_two_flanks(groove: xr.Dataset) -> None:
    assert groove.cam.values.tolist() == ["cam", "outer"]
    assert np.abs(contour(groove, 1) - contour(groove, 0)) == pytest.approx(2 * given.ROLLER)
    inner, outer = groove.contact_force.values
    assert (inner * outer == 0).all(), "the roller presses one flank at a time"
    assert inner.max() > 0
    assert outer.max() > 0
    s = groove.wucht.summary
    assert s["outcome"] == "cuttable", "it does not lift off: it goes over to the other flank"
    inside = [sum(end - begin for begin, end in s["contact"]["lift_off"][name]) for name in ("cam", "outer")]
    assert sum(inside) == pytest.approx(2 * math.pi)
    assert s["cams"]["outer"]["min_curvature"] is None, "around an outer flank this cam is hollow everywhere"
    assert s["cams"]["outer"]["min_hollow"]["radius"] == pytest.approx(s["min_curvature_radius"] + 2 * given.ROLLER)


def test_a_rod_with_an_offset() -> None:
    result = answered(given.MODIFIED_SINE, given.ROD | {"clockwise": True}, permitted={"pressure_angle": "20 deg"})
    phi, h, v = result.cam_angle.values, result.follower.values, result.follower_velocity.values
    assert np.abs(pitch(result) * np.exp(-1j * phi) - (0.06 + h + 0.005j)).max() < 1e-15
    # the classical formula: tan alpha = (s' -+ e)/(d + s)
    assert np.abs(np.tan(result.pressure_angle.values[0])) == pytest.approx(np.abs((v - 0.005) / (0.06 + h)), abs=1e-12)
    assert result.wucht.summary["max_pressure_angle"] == pytest.approx(np.abs(result.pressure_angle.values).max(), rel=1e-4)
    assert result.wucht.summary["smallest"]["max_pressure_angle"] == pytest.approx(math.radians(20))
    assert result.wucht.summary["smallest"]["base_radius"] < result.wucht.summary["base_radius"]


def test_a_flat_face() -> None:
    asked: dict[str, Any] = {"contact": ROD_CONTACT, "speed": "600 rpm", "permitted": {"least_radius": "8 mm"}}
    result = answered(given.MODIFIED_SINE, given.FLAT, **asked)
    s, h, q = result.wucht.summary, result.follower.values, result.follower_acceleration.values
    assert 1 / result.curvature.values[0] == pytest.approx(0.04 + h + q)
    assert s["min_curvature_radius"] == pytest.approx((0.04 + h + q).min(), rel=1e-5)
    assert s["max_pressure_angle"] == 0
    assert np.isnan(result.pitch_x.values).all()
    assert result.contact_force.values[0] == pytest.approx(0.4 * (20 * math.pi) ** 2 * q + 8e3 * h + 60)
    compliance = 2 * (1 - 0.3**2) / 210e9
    hertz = np.sqrt(result.contact_force.values[0] / (math.pi * 0.015) / (0.04 + h + q) / compliance)
    assert result.contact_pressure.values[0] == pytest.approx(hertz)
    assert s["smallest"]["follower"]["distance"] == pytest.approx(0.008 - (h + q).min(), abs=1e-6)
    face = -result.follower_velocity.values
    assert [float(result.face_from), float(result.face_to)] == pytest.approx([face.min(), face.max()], rel=1e-4)


@pytest.mark.slow
def test_a_linkage_is_between_lever_and_output() -> None:
    result = answered(given.SMOOTH, given.FOLLOWER, {"linkage": given.FOUR_BAR}, contact=LEVER_CONTACT, speed=10.0)
    assert result.output.values == pytest.approx(
        np.radians(6 - 6 * np.cos(result.cam_angle) + 0.7 * np.cos(2 * result.cam_angle))
    )
    assert np.abs(result.follower.values - result.output.values).max() > 0.01
    joint = 0.1 * np.exp(1j * (math.radians(70) + result.follower.values))
    rod = np.abs(joint[:, None] - (0.3 + 0.12 * np.exp(1j * (np.linspace(0, np.pi, 20001)))))
    k = np.argmin(np.abs(rod[0] - 0.29))
    angle = np.linspace(0, np.pi, 20001)[k] + result.output.values - result.output.values[0]
    assert np.abs(np.abs(joint - 0.3 - 0.12 * np.exp(1j * angle)) - 0.29).max() < 1e-4
    coupler = joint - 0.3 - 0.12 * np.exp(1j * angle)
    between = np.abs(np.angle(coupler * np.exp(-1j * angle)))
    expected = np.minimum(between, np.pi - between)
    assert result.transmission_angle.values == pytest.approx(expected, abs=2e-3)
    assert result.wucht.summary["min_transmission_angle"] == result.transmission_angle.values.min()
    assert any("study.contact.output_inertia" in warning for warning in result.wucht.warnings)


@pytest.mark.slow
def test_what_moves_behind_a_linkage_presses_too() -> None:
    """The work on lever and output over a part of the turn in which both gain energy, by the camshaft's torque."""
    heavy = LEVER_CONTACT | {"preload": "900 N m", "output_inertia": "2 kg m^2"}
    result = answered(given.SMOOTH, given.FOLLOWER, {"linkage": given.FOUR_BAR}, contact=heavy, speed=10.0)
    light = answered(
        given.SMOOTH, given.FOLLOWER, {"linkage": given.FOUR_BAR}, contact=LEVER_CONTACT | {"preload": "900 N m"}, speed=10.0
    )
    assert not result.wucht.warnings
    more = (result.camshaft_torque - light.camshaft_torque).values
    energy = 2 * (10 * np.gradient(result.output.values, result.cam_angle.values)) ** 2 / 2
    work = np.append(0, np.cumsum((more[1:] + more[:-1]) / 2 * np.diff(result.cam_angle.values)))
    assert work == pytest.approx(energy - energy[0], abs=2e-3 * energy.max())


@pytest.mark.parametrize(("key", "more"), [("output_mass", {"linkage": given.FOUR_BAR}), ("output_inertia", {})])
def test_an_output_that_cannot_be_is_refused(key: str, more: dict[str, Any]) -> None:
    with refused(f"study.contact.{key}", given=2.0):
        answered(given.SMOOTH, given.FOLLOWER, more, contact=LEVER_CONTACT | {key: 2.0}, speed=10.0)


def test_a_preload_keeps_the_roller_on_its_cam() -> None:
    asked: dict[str, Any] = {"speed": "700 rpm", "points": 360}
    lifting = answered(given.SMOOTH, given.FOLLOWER, contact={"inertia": 0.02, "preload": "1 N m"}, **asked)
    s = lifting.wucht.summary
    assert s["outcome"] == "lifts-off"
    assert "the roller lifts off from" in s["sentence"]
    needed = s["contact"]["least_preload"]
    acceleration = lifting.follower_acceleration.values
    assert needed == pytest.approx(-0.02 * (700 * math.pi / 30) ** 2 * acceleration.min(), rel=1e-4)
    off = np.zeros(361, bool)
    for begin, end in s["contact"]["lift_off"]["cam"]:
        off |= np.mod(lifting.cam_angle.values - begin, 2 * math.pi) < end - begin
    assert np.array_equal(off, lifting.contact_force.values[0] == 0)
    held = answered(given.SMOOTH, given.FOLLOWER, contact={"inertia": 0.02, "preload": 1.001 * needed}, **asked)
    assert held.wucht.summary["outcome"] == "cuttable"
    assert held.contact_force.values.min() > 0


def test_without_contact_there_is_no_torque() -> None:
    """A spring that pulls the roller off."""
    contact = {"inertia": 0.02, "preload": "-500 N m", "width": "12 mm"}
    off = answered(given.SMOOTH, given.FOLLOWER, contact=contact, speed="700 rpm", points=36, chord_tolerance="50 um")
    assert (off.camshaft_torque.values == 0).all() and (off.contact_force.values == 0).all()
    assert report(off) and draw(off).axes


def test_the_table_speed_stands_for_the_speed() -> None:
    """A shaft that turns unevenly: the acceleration has psi' omega omega' besides."""
    tables = {"speed": {"mean": 30.0, "sine": [0.0, 4.0]}}
    result = answered(given.SMOOTH, given.FOLLOWER, tables, contact={"inertia": 1.0, "preload": 1e4}, points=3600)
    tau = np.linspace(0, 2 * math.pi, 200_001)
    speed = 30 + 4 * np.sin(2 * tau)
    angle = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2) * (tau[1] / 30)])
    w = np.interp(result.cam_angle.values, angle, speed)
    along = result.follower_acceleration.values * w**2 + result.follower_velocity.values * w * np.gradient(
        w, 2 * math.pi / 3600
    )
    torque = 90e-3 * np.cos(result.pressure_angle.values[0]) * result.contact_force.values[0]
    assert (torque - 1e4)[1:-1] == pytest.approx(along[1:-1], abs=2e-3 * np.abs(along).max())
    assert result.wucht.summary["contact"]["mean_speed"] == pytest.approx(30)


@pytest.mark.slow
def test_the_smallest_cam_is_as_permitted() -> None:
    permitted = {"pressure_angle": "25 deg", "least_radius": "20 mm"}
    first = answered(given.SMOOTH, given.FOLLOWER, permitted=permitted).wucht.summary
    size = first["smallest"]
    made = answered(given.SMOOTH, given.FOLLOWER | size["follower"], permitted=permitted).wucht.summary
    assert made["base_radius"] == pytest.approx(size["base_radius"])
    assert made["base_radius"] < first["base_radius"]
    assert made["max_pressure_angle"] == pytest.approx(size["max_pressure_angle"])
    assert made["outcome"] == "cuttable", "a limit that is just reached is kept"
    assert max(made["max_pressure_angle"] / math.radians(25), 0.02 / made["min_curvature_radius"]) == pytest.approx(1, rel=1e-6)
    blank = answered(given.SMOOTH, given.FOLLOWER, permitted=permitted, smallest="blank").wucht.summary["smallest"]
    assert blank["largest_radius"] <= size["largest_radius"] * (1 + 1e-9)


def test_undercut_is_shown_where_that_is_asked_for() -> None:
    law = {"kind": "3-4-5", "stroke": "25 mm", "rise": ["20 deg", "80 deg"], "return": ["120 deg", "200 deg"]}
    follower = given.ROD | {"distance": "26 mm", "roller_radius": "16 mm", "offset": 0.0}
    with refused("follower.roller_radius", given="16 mm"):
        answered(law, follower)
    result = answered(law, follower, allow_undercut=True, contact=ROD_CONTACT, speed=10.0)
    s = result.wucht.summary
    assert s["undercut"] is True
    assert s["outcome"] == "undercut"
    [[begin, end]] = s["cams"]["cam"]["undercut"]
    inside = np.mod(result.cam_angle.values - begin, 2 * math.pi) < end - begin
    assert inside.any()
    assert np.array_equal(inside, result.uncut.values[0] < 0)
    assert result.sizes["mill_point"] == 0
    assert np.isnan(result.contact_force.values).all()
    assert [w.split(":")[0] for w in result.wucht.warnings][:2] == ["no points to mill", "no contact forces"]


def test_a_face_leaves_what_lies_behind_it_at_all_angles() -> None:
    """3-4-5 over 60 deg: the radius is negative from 33.58 to 57.5 deg; half-planes cut away more, all of a swallowtail."""
    law = {"kind": "3-4-5", "stroke": "20 mm", "rise": ["0 deg", "60 deg"]}
    result = answered(law, given.FLAT | {"distance": "20 mm"}, allow_undercut=True)
    s = result.wucht.summary
    assert np.degrees(s["cams"]["cam"]["undercut"][0]) == pytest.approx([33.58, 57.5], abs=0.05)
    [rise, back] = np.degrees(s["cams"]["cam"]["missing"])
    assert rise == pytest.approx([22.1, 72.9], abs=0.05)
    assert back == pytest.approx(360 - rise[::-1], abs=1e-6)
    assert s["min_curvature_radius"] == pytest.approx(0.020)
    assert (s["base_radius"], s["largest_radius"]) == pytest.approx((0.020, 0.040))


def test_the_smallest_cam_goes_round_its_shaft() -> None:
    """By default round a shaft of no radius; and what is proposed is a file that runs."""
    law = {"kind": "harmonic", "coefficients": {"mean": "20 mm", "cosine": ["12 mm"]}}
    for shaft, base in (("0 mm", 8e-3), ("12 mm", 12e-3)):
        permitted = {"least_radius": "2 mm", "shaft_radius": shaft}
        size = answered(law, given.FLAT, permitted=permitted, chord_tolerance="50 um").wucht.summary["smallest"]
        assert size["base_radius"] == pytest.approx(base, abs=2e-6)
        made = answered(law, given.FLAT | size["follower"], permitted=permitted, chord_tolerance="50 um").wucht.summary
        assert made["outcome"] == "cuttable"
        assert made["base_radius"] == pytest.approx(size["base_radius"])


def test_a_smallest_cam_that_is_not_all_is_warned_of(pair: xr.Dataset) -> None:
    """With a counter cam it is that of the main lever; of a groove the roller may cut the other flank away."""
    [said] = pair.wucht.warnings
    assert "the lever of the counter cam must be chosen anew" in said
    law = {"kind": "harmonic", "coefficients": {"mean": "0 mm", "cosine": ["0 mm", "8 mm"]}}
    groove = given.ROD | {"distance": "150 mm", "roller_radius": "20 mm", "groove": True, "offset": 0.0}
    [said] = answered(law, groove, permitted={"pressure_angle": "45 deg"}, chord_tolerance="50 um").wucht.warnings
    assert said.startswith("the smallest permitted cam cannot be made: the roller would cut the contour away")


LEVER, SLIDES = (given.SMOOTH, given.FOLLOWER), (given.MODIFIED_SINE, given.FLAT)


@pytest.mark.parametrize(
    ("drive", "asked"),
    [
        (LEVER, {"contact": {"inertia": 1.0}}), (LEVER, {"contact": {"mass": 1.0}, "speed": 1.0}),
        (SLIDES, {"contact": {"inertia": 1.0}, "speed": 1.0}), (LEVER, {"contact": {}, "speed": 1.0}),
        (LEVER, {"contact": {"inertia": 1, "preload": "3 N"}, "speed": 1}),
        (LEVER, {"contact": {"inertia": 1, "stiffness": -1}, "speed": 1}),
        (LEVER, {"permitted": {"pressure_angle": "5 deg"}}), (SLIDES, {"permitted": {"pressure_angle": "5 deg"}}),
        (LEVER, {"chord_tolerance": 1e-16}), ((given.SMOOTH, given.FOLLOWER | {"roller_radius": 0.2}), {}),
        ((given.MODIFIED_SINE, given.FLAT | {"distance": 1e-3}), {}),
        (LEVER, {"contact": {"inertia": 1, "stiffness": "30 N/m"}, "speed": 1}),
        (LEVER, {"permitted": {"pressure_angle": "95 deg"}}), (LEVER, {"permitted": {"shaft_radius": "-1 mm"}}),
        ((given.FIVE, given.FOLLOWER), {"wheel_radius": "1 m"}),
    ],
)  # fmt: skip
def test_what_cannot_be_is_a_sentence(drive: Any, asked: dict[str, Any]) -> None:
    check_refusal(f"cam-contour: {asked}, {drive[1]}", lambda: answered(*drive, **asked))


def test_where_one_flank_lifts_off_the_other_one_presses(groove: xr.Dataset) -> None:
    """The rest of the turn, arcs that end beyond it included; all of it where nothing lifts off."""
    phi, turn = groove.cam_angle.values, 2 * math.pi
    off = {
        name: np.any([np.mod(phi - begin, turn) < end - begin for begin, end in arcs], axis=0)
        for name, arcs in groove.wucht.summary["contact"]["lift_off"].items()
    }
    assert np.array_equal(off["outer"], ~off["cam"])
    assert (groove.contact_force.values[0][off["cam"]] == 0).all()
    pressed = {"inertia": "0.02 kg m^2", "preload": "500 N m"}
    asked: dict[str, Any] = {"contact": pressed, "speed": 10.0, "points": 36, "chord_tolerance": "50 um"}
    s = answered(given.SMOOTH, given.FOLLOWER | {"groove": True}, **asked).wucht.summary
    assert s["contact"]["lift_off"] == {"cam": [], "outer": [[0.0, turn]]}
