"""Cam drives from the tables of a file: what is built of them, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.drive import CamDrive, drive_from, laws
from wucht.cams.followers.flat_faced import FlatFacedCam
from wucht.cams.followers.oscillating_roller import OscillatingRoller
from wucht.cams.followers.roller_cam import RollerCam
from wucht.cams.laws.table_law import TableLaw
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
    return drive_from({"law": LAW} | tables, "a drive", folder)


@pytest.mark.parametrize(
    ("tables", "unit"),
    [
        ({}, "rad"),
        ({"law": SMALL}, "m"),
        ({"follower": LEVER}, "rad"),
        ({"follower": ROD, "law": SMALL}, "m"),
        ({"follower": FLAT}, "m"),
        ({"follower": LEVER, "linkage": FOUR_BAR}, "rad"),
        ({"follower": LEVER, "linkage": CRANK, "law": SMALL}, "m"),
    ],
)
def test_linkage_and_follower_say_whether_the_output_turns_or_slides(tables, unit):
    assert drive(**tables).motion_law.unit == unit


def test_cams_of_all_followers():
    (lever,) = drive(follower=LEVER).cams(drive().motion_law.law).values()
    assert lever.follower == OscillatingRoller(pivot=0.11, arm=0.09, roller_radius=0.01, angle=math.radians(-143))
    rod = drive(follower=ROD | {"groove": True, "clockwise": True}, law=SMALL)
    cams = rod.cams(rod.motion_law.law)
    assert {name: (cam.outer, cam.clockwise) for name, cam in cams.items()} == {"cam": (False, True), "outer": (True, True)}
    flat = drive(follower=FLAT)
    (cam,) = flat.cams(flat.motion_law.law).values()
    assert isinstance(cam, FlatFacedCam)
    counter = {"arm": "80 mm", "roller_radius": "8 mm", "angle": "140 deg"}
    pair = drive(follower=LEVER | {"counter": counter}).cams(drive().motion_law.law)
    assert set(pair) == {"cam", "counter"}
    assert isinstance(pair["counter"], RollerCam)
    assert pair["counter"].follower == OscillatingRoller(pivot=0.11, arm=0.08, roller_radius=0.008, angle=math.radians(140))


def test_the_law_is_asked_of_the_output_and_the_cam_made_for_the_lever():
    linked = drive(follower=LEVER, linkage=FOUR_BAR)
    lever = linked.lever(linked.motion_law.law)
    assert isinstance(lever, LeverMotion)
    assert linked.closure.output_at(lever(PHI)) == pytest.approx(linked.motion_law.law(PHI), abs=1e-12)
    assert linked.cams(linked.motion_law.law)["cam"].law(PHI) == pytest.approx(lever(PHI))


@pytest.mark.parametrize("kind", [k for k in laws() if k not in ("harmonic", "table")])
def test_standard_laws(kind):
    of = {"kind": kind, "stroke": "10 mm", "rise": ["60 deg", "150 deg"]}
    if "spline" in kind:
        of["points"] = [[0.5, 0.5]]
    law = drive(law=of).motion_law.law
    assert law(np.radians([0, 60, 180, 300, 330])) == pytest.approx([0, 0, 0.01, 0, 0], abs=1e-12)
    assert law(np.radians([105, 255])) == pytest.approx([0.005, 0.005])
    of["return"] = ["200 deg", "260 deg"]
    assert drive(law=of).motion_law.law(np.radians([190, 230, 270])) == pytest.approx([0.01, 0.005, 0], abs=1e-12)


@pytest.mark.parametrize(
    ("heading", "unit", "scale"), [("angle [deg], output [mm]", "m", 1e-3), ("deg, deg", "rad", math.pi / 180)]
)
def test_a_law_by_the_points_of_a_file(tmp_path, heading, unit, scale):
    degrees = np.arange(0, 360, 10)
    rows = "\n".join(f"{x}, {5 - 5 * math.cos(math.radians(x))}" for x in degrees)
    (tmp_path / "law.csv").write_text(f"{heading}\n{rows}\n")
    found = drive(tmp_path, law={"kind": "table", "file": "law.csv"}).motion_law
    assert found.unit == unit
    assert isinstance(found.law, TableLaw)
    assert found.law(PHI) == pytest.approx(scale * (5 - 5 * np.cos(PHI)), abs=1e-5 * scale)


def test_a_shaft_by_coefficients_over_time_or_angle():
    speed = {"mean": "500 rpm", "cosine": ["0 rad/s", "2.4 rad/s"]}
    over_time = drive(speed=speed).shaft_motion
    assert over_time.mean == pytest.approx(500 * math.pi / 30)
    assert over_time.speed.cosine == pytest.approx([0, 2.4])
    over_angle = drive(speed=speed | {"over": "angle"}).shaft_motion
    assert over_angle.mean < over_time.mean
    assert over_angle.speed(PHI) == pytest.approx(over_time.speed(over_angle.angle(PHI)), rel=1e-9)
    assert drive(speed=speed | {"period": "120 ms"}).shaft_motion.mean == over_time.mean


def test_facts_are_what_it_is():
    speed = {"mean": "500 rpm"}
    assert drive(speed=speed).facts == drive(speed=speed).facts
    assert drive(speed=speed).facts != drive(speed={"mean": "501 rpm"}).facts
    assert drive().facts["law"]["kind"] == "harmonic"
    assert drive().facts["title"] == "a drive"


def test_in_python():
    made = CamDrive(laws()["3-4-5"](stroke="10 mm", rise=("60 deg", "150 deg")))
    assert made.motion_law.unit == "m"
    assert made.motion_law.law(math.pi) == pytest.approx(0.01)


WRONG = [
    ({"law": None}, "law: the table [law] is missing"),
    ({"law": {"kind": "4-5"}}, "law.kind: given '4-5'; unknown kind; did you mean '3-4-5'?"),
    ({"law": {}}, "law.kind: this key is missing"),
    ({"follower": {"kind": "mushroom"}}, "follower.kind: given 'mushroom'; unknown kind"),
    ({"follower": LEVER | {"arm": "-90 mm"}}, "follower.arm: given '-90 mm'; must be an arm of the lever greater than 0 m"),
    ({"follower": {k: v for k, v in LEVER.items() if k != "arm"}}, "follower.arm: this key is missing; give the arm"),
    ({"follower": LEVER | {"counter": {"arm": 1}}}, "follower.counter.roller_radius: this key is missing"),
    ({"follower": LEVER | {"clockwise": "no"}}, "follower.clockwise: given 'no'; must be the sense of rotation of the cam"),
    ({"follower": ROD, "linkage": CRANK}, "linkage: a linkage is moved by a lever"),
    ({"linkage": CRANK | {"branch": "up"}}, "linkage.branch: given 'up'; must be 'open' or 'crossed'"),
    ({"linkage": FOUR_BAR | {"coupler": 1}}, "linkage.coupler: given 1.0; must be between"),
    ({"speed": {}}, "speed.mean: give the mean speed with its coefficients, or file = RECORD"),
    ({"speed": {"mean": "5 kg"}}, "speed.mean: given '5 kg'"),
    ({"speed": {"mean": 1, "file": "x.csv"}}, "speed.mean: given 1; give either a file or coefficients"),
    ({"speed": {"file": "x.csv"}}, "speed.column: a record needs a column, and the orders to keep"),
    ({"speed": {"file": "x.csv", "column": "speed"}}, "speed.orders: a record needs a column, and the orders to keep"),
    ({"speed": {"mean": 10, "cosine": [0, 11]}}, "speed: the shaft must not stand still or turn back"),
    ({"speed": {"mean": 10, "period": 1}}, "speed.mean: given 10.0; order 0 must be 2 pi/T = 6.28319 rad/s"),
    ({"shaft": {"inertia": 1}}, "shaft.output_inertia: give the output_inertia of an output that turns"),
    ({"law": {"kind": "table", "file": "none.csv"}}, "law.file: given 'none.csv'; there is no such file"),
    ({"law": {"kind": "table", "file": 3}}, "law.file: given 3; must be the name of a file"),
    ({"law": {"kind": "3-4-5", "stroke": 1, "rise": [0, 4]}}, "law.rise"),
]  # fmt: skip


@pytest.mark.parametrize(("tables", "sentence"), WRONG, ids=[s[:40] for _, s in WRONG])
def test_what_is_refused(tables, sentence):
    with pytest.raises(InputError) as raised:
        made = drive_from({k: v for k, v in ({"law": LAW} | tables).items() if v is not None}, "", Path())
        assert made.motion_law.law is not None
        if made.linkage is not None:
            assert made.closure is not None
        assert made.shaft_motion is not None
    assert str(raised.value).startswith(sentence)


def test_what_is_missing_is_asked_for_where_it_is_needed():
    with refused("follower", given=None, code="missing"):
        drive().cams(drive().motion_law.law)
    with refused("speed", given=None, code="missing"):
        assert drive().shaft_motion
