"""Cam drives from the tables of a file: what is built of them, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.drive import cam_drive_from
from wucht.cams.dwells import dwells_of, position_error
from wucht.cams.elastic_output import Dwell
from wucht.cams.followers.flat_faced import FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.linkages.closure import LeverMotion
from wucht.errors import InputError

LAW = {"kind": "harmonic", "coefficients": {"mean": 0.2, "cosine": [-0.2]}}
LEVER = {"kind": "oscillating-roller", "pivot": "110 mm", "arm": "90 mm", "roller_radius": "10 mm", "angle": "-143 deg"}
ROD = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm", "offset": "7 mm"}
FLAT = {"kind": "flat-faced", "distance": "80 mm"}
FOUR_BAR = {"kind": "four-bar", "ground": 0.3, "input": 0.1, "coupler": 0.28, "output": 0.12, "angle": "80 deg"}
CRANK = {"kind": "slider-crank", "crank": 0.1, "rod": 0.3, "angle": "60 deg"}
SMALL = {"kind": "harmonic", "coefficients": {"cosine": ["-10 mm"]}}
PHI = np.linspace(0, 2 * math.pi, 50)


def drive(folder=Path(), **tables):
    return cam_drive_from({"law": LAW} | tables, "a drive", folder)


@pytest.mark.parametrize(
    ("tables", "unit"),
    [
        ({}, "rad"),
        ({"law": SMALL}, "m"),
        ({"follower": LEVER}, "rad"),
        ({"follower": FLAT}, "m"),
        ({"follower": LEVER, "linkage": CRANK, "law": SMALL}, "m"),
    ],
)
def test_linkage_and_follower_say_whether_the_output_turns_or_slides(tables, unit):
    assert drive(**tables).motion_law.unit == unit


def test_cams_of_all_followers():
    (lever,) = drive(follower=LEVER).make_cams(drive().motion_law.function).values()
    assert lever.follower == OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))
    rod = drive(follower=ROD | {"groove": True, "clockwise": True}, law=SMALL)
    cams = rod.make_cams(rod.motion_law.function)
    assert {name: (cam.outer, cam.clockwise) for name, cam in cams.items()} == {"cam": (False, True), "outer": (True, True)}
    flat = drive(follower=FLAT)
    (cam,) = flat.make_cams(flat.motion_law.function).values()
    assert isinstance(cam, FlatFacedCam)
    counter = {"arm": "80 mm", "roller_radius": "8 mm", "angle": "140 deg"}
    pair = drive(follower=LEVER | {"counter": counter}).make_cams(drive().motion_law.function)
    assert set(pair) == {"cam", "counter"}
    assert isinstance(pair["counter"], RollerCam)
    assert pair["counter"].follower == OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.008, angle=math.radians(140))


def test_the_law_is_asked_of_the_output_and_the_cam_made_for_the_lever():
    linked = drive(follower=LEVER, linkage=FOUR_BAR)
    lever = linked.follower_law(linked.motion_law.function)
    assert isinstance(lever, LeverMotion)
    assert linked.closure.output_at(lever(PHI)) == pytest.approx(linked.motion_law.function(PHI), abs=1e-12)
    assert linked.make_cams(linked.motion_law.function)["cam"].law(PHI) == pytest.approx(lever(PHI))


def test_a_shaft_by_coefficients_over_time_or_angle():
    speed = {"mean": "500 rpm", "cosine": ["0 rad/s", "2.4 rad/s"]}
    over_time = drive(speed=speed).shaft_motion
    assert over_time.mean == pytest.approx(500 * math.pi / 30)
    assert over_time.speed.cosine == pytest.approx([0, 2.4])
    over_angle = drive(speed=speed | {"over": "angle"}).shaft_motion
    assert over_angle.mean < over_time.mean
    assert over_angle.speed(PHI) == pytest.approx(over_time.speed(over_angle.angle(PHI)), rel=1e-9)
    assert drive(speed=speed | {"period": "120 ms"}).shaft_motion.mean == over_time.mean


WRONG = [
    ({"law": None}, "law: the table [law] is missing"),
    ({"law": {"kind": "4-5"}}, "law.kind: given '4-5'; unknown kind; did you mean '3-4-5'?"),
    ({"follower": ROD, "linkage": CRANK}, "linkage: a linkage is moved by a lever"),
    ({"linkage": FOUR_BAR | {"coupler": 1}}, "linkage.coupler: given 1.0; must be between"),
    ({"speed": {}}, "speed.mean: give the mean speed with its coefficients, or file = RECORD"),
    ({"speed": {"mean": 1, "file": "x.csv"}}, "speed.mean: given 1; give either a file or coefficients"),
    ({"speed": {"file": "x.csv"}}, "speed.column: a record needs a column, and the orders to keep"),
    ({"speed": {"mean": 10, "cosine": [0, 11]}}, "speed: the shaft must not stand still or turn back"),
    ({"speed": {"mean": 10, "period": 1}}, "speed.mean: given 10.0; order 0 must be 2 pi/T = 6.28319 rad/s"),
    ({"shaft": {"inertia": 1}}, "shaft.output_inertia: give the output_inertia of an output that turns"),
]  # fmt: skip


@pytest.mark.parametrize(("tables", "sentence"), WRONG, ids=[s[:40] for _, s in WRONG])
def test_what_is_refused(tables, sentence):
    with pytest.raises(InputError) as raised:
        made = cam_drive_from({k: v for k, v in ({"law": LAW} | tables).items() if v is not None}, "", Path())
        assert made.motion_law.function is not None
        if made.linkage is not None:
            assert made.closure is not None
        assert made.shaft_motion is not None
    assert str(raised.value).startswith(sentence)


def test_what_is_missing_is_asked_for_where_it_is_needed():
    with refused("follower", given=None, code="missing"):
        drive().make_cams(drive().motion_law.function)
    with refused("speed", given=None, code="missing"):
        assert drive().shaft_motion


STANDARD = {"kind": "3-4-5", "stroke": "10 mm", "rise": ["60 deg", "150 deg"], "return": ["200 deg", "300 deg"]}
DWELLING = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg"}
BARE = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm"}
LINKED = {"kind": "four-bar", "ground": 0.3, "input": 0.1, "coupler": 0.29, "output": 0.12, "angle": "70 deg"}
SLIDING = {"kind": "slider-crank", "crank": "50 mm", "rod": "200 mm", "angle": "60 deg"}


def test_a_late_motion_is_off_by_what_it_has_not_yet_done():
    """A straight line: 0.1 a radian, from its value at the begin on; a dwell past the end of the turn too."""
    line = lambda tau: 0.1 * np.asarray(tau)  # noqa: E731
    assert position_error(line, [Dwell(1.0, 2.0, 0.1)]) == pytest.approx(0.1)
    assert position_error(line, [Dwell(1.0, 2.0, 0.1), Dwell(6.0, 1.0, 0.6)]) == pytest.approx(0.1 * (1 + 2 * math.pi) - 0.6)
    assert position_error(np.sin, [Dwell(0.0, 3.0)]) == pytest.approx(1.0, rel=1e-6)


def test_a_standard_law_rests_where_it_neither_rises_nor_returns():
    motion_law = cam_drive_from({"law": STANDARD}, "", None).motion_law
    top, bottom = sorted(dwells_of(motion_law), key=lambda d: d.begin)
    assert np.degrees([top.begin, top.end]) == pytest.approx([150, 200], abs=0.11)
    assert np.degrees([bottom.begin, bottom.end]) == pytest.approx([300, 420], abs=0.11)
    assert (top.value, bottom.value) == pytest.approx((0.01, 0.0), abs=1e-15)
    assert position_error(motion_law.function, [top, bottom]) < 1e-15


@pytest.mark.parametrize(
    ("tables", "arm"),
    [({"follower": DWELLING}, 0.07), ({"follower": DWELLING, "linkage": LINKED}, 0.12), ({"follower": BARE}, None), ({}, None),
     ({"follower": DWELLING, "linkage": SLIDING}, None)],
)  # fmt: skip
def test_the_arm_of_an_output_that_turns(tables, arm):
    law = {"kind": "harmonic", "coefficients": {"cosine": [0.001]}}
    assert cam_drive_from({"law": law, **tables}, "", None).output_arm == arm
