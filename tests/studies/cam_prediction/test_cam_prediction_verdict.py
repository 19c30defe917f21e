"""The verdict of cam-prediction: shafts that stand, simulations that differ or do not end, shafts that twist."""

import math
import re

import pytest
from tests.refusals import refused

import wucht
from wucht.cams.drive import laws
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable

RESTRICTIONS = [{"at": "180 deg", "equals": "24 deg"}, {"on": ["-120 deg", "120 deg"], "equals": "0 deg"}]
LAW = HarmonicLawTable(harmonics=5, restrictions=RESTRICTIONS)
OMEGA = 500 * math.pi / 30
COULOMB = {"kind": "coulomb", "torque": "150 N m"}
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
BRIEF = {"cuts": 0, "simulate": 0}


def drive(law=LAW, **shaft):
    return wucht.CamDrive(law, shaft=ShaftTable(**{"inertia": 20.0, "output_inertia": 6.0} | shaft))


# --- a shaft that stands ---

STUCK = {
    "constant-torque": {"torque": 10.0},
    "linear": {"slope": 2.0, "no_load_speed": "510 rpm"},
    "induction": {"voltage": 23, "frequency": 50, "pole_pairs": 6, "stator_resistance": 0.3, "rotor_resistance": 0.3,
                  "stator_reactance": 0.6, "rotor_reactance": 0.6},
    "table": {"points": [[0, 100], [40, 149], [60, -100]]},
}  # fmt: skip


@pytest.mark.parametrize(("kind", "expected"), [*((kind, {}) for kind in STUCK), ("linear", {"mean_speed": 50.0})])
def test_a_drive_that_does_not_move_its_dry_friction_is_refused(kind, expected):
    """Friction that is smooth about standstill lets the shaft creep; that is not a speed to make a cam for."""
    with refused("shaft.drive", "150 N", "m", code="stands") as error:
        wucht.run(wucht.CamPrediction(), drive(drive={"kind": kind, **STUCK[kind]}, loads=[COULOMB], **expected))
    assert error.value.location == "shaft.drive"
    assert error.value.value == kind
    assert "mean_speed" not in error.value.explanation  # which would not help


def test_a_controlled_drive_has_no_torque_over_the_speed():
    controlled = {"kind": "inverter", "set_speed": 50.0, "gain": 10.0, "integral_time": 1.0, "torque_limit": 100.0}
    with refused("shaft.drive.kind", "linear", "constant-speed", given="inverter") as error:
        wucht.run(wucht.CamPrediction(), drive(drive=controlled))
    assert error.value.location == "shaft.drive.kind"


def test_the_dry_friction_with_which_a_measured_load_begins_counts_too():
    loads = [{"kind": "table", "points": [[0, 80], [100, 200]]}, {"kind": "coulomb", "torque": 70.0}]
    with refused("shaft.drive", "120 N", "m", "150 N", code="stands"):
        wucht.run(wucht.CamPrediction(), drive(drive={"kind": "constant-torque", "torque": 120.0}, loads=loads))


def test_a_drive_that_carries_its_load_only_at_speed_needs_the_speed_expected():
    """100 N m at standstill, 300 N m at 40 rad/s: by itself it does not start."""
    fan = {"kind": "table", "points": [[0, 100], [40, 300], [60, -100]]}
    with refused("shaft.drive", "mean_speed", code="stands"):
        wucht.run(wucht.CamPrediction(), drive(drive=fan, loads=[COULOMB]))
    found = wucht.run(wucht.CamPrediction(**BRIEF), drive(drive=fan, loads=[COULOMB], mean_speed=45.0)).wucht.summary
    assert 45 < found["mean_speed"] < 55
    assert found["mean_power"] == pytest.approx(150 * found["mean_speed"], rel=1e-6)


# --- the simulation ---


@pytest.mark.slow
@pytest.mark.parametrize(
    "shaft",
    [
        {"output_inertia": 60.0, "mean_speed": OMEGA},
        {"inertia": 1.5, "drive": LINEAR, "loads": [COULOMB]},
    ],
    ids=["eigenmotion", "drive"],
)
def test_a_sharp_cam_is_simulated_as_it_is_predicted(shaft):
    """Of inertia ratios 1.13 and 1.51: the cam is sharp where the shaft is slow."""
    result = wucht.run(wucht.CamPrediction(cuts=0, simulate=8), drive(**shaft))
    s = result.wucht.summary
    assert s["inertia_ratio"] > 1.1
    assert s["corrected"]["fluctuation"] > 0.75
    assert s["simulation"]["corrected"]["deviation"] < 2e-8
    assert s["simulation"]["corrected"]["above"] < 2e-9
    assert s["verdict"] == "clean"
    assert s["sentence"].startswith("CLEAN on")
    assert not any("simulation" in said for said in result.wucht.warnings)


@pytest.mark.slow
def test_a_simulation_that_would_not_end_is_given_up_and_says_so():
    """A torque that falls by 5e6 N m for each rad/s: the steps are too many."""
    stiff = drive(drive={"kind": "linear", "slope": 5e6, "no_load_speed": OMEGA})
    result = wucht.run(wucht.CamPrediction(cuts=0, simulate=20, points=36), stiff)
    s = result.wucht.summary
    for said, cam in zip(result.wucht.warnings, ("original", "corrected"), strict=True):
        assert re.fullmatch(rf"the simulation with the {cam} cam fails in turn \d of 20: a turn takes more than 50000 .*", said)
    corrected = s["simulation"]["corrected"]
    assert s["verdict"] == "clean" and corrected["deviation"] is None is corrected["above"]
    assert any("20 turns with the corrected cam: it fails" in line for line in wucht.report(result))
    assert (result.simulated_speed.isnull()).all() and wucht.draw(result)


@pytest.fixture(scope="module")
def departing():
    """A law whose acceleration jumps twice within two degrees: orders that the prediction leaves out."""
    law = laws()["simple-harmonic"](stroke="24 deg", rise=("178 deg", "180 deg"))
    return wucht.run(wucht.CamPrediction(cuts=0, simulate=1, points=36), drive(law, output_inertia=0.01, mean_speed=OMEGA))


def test_a_simulation_that_differs_does_not_confirm_and_the_reason_is_said(departing):
    s = departing.wucht.summary
    assert s["verdict"] == "not confirmed"
    share = 100 * s["simulation"]["corrected"]["above"]
    assert share > 1e-4
    for name in ("original", "corrected"):
        deviation = 100 * s["simulation"][name]["deviation"]
        assert (
            f"the simulation with the {name} cam departs from the prediction by {deviation:.3g} % of the speed, by the orders "
            "that the prediction leaves out"
        ) in departing.wucht.warnings


# --- the verdict ---


TWISTS = {"shaft_stiffness": 4e6, "shaft_damping": 1000.0, "cam_inertia": 0.5}


def test_the_verdict_counts_the_shaft_that_twists():
    springs = TWISTS | {"output_frequency": "60 Hz"}
    result = wucht.run(wucht.CamPrediction(**BRIEF, speed_points=2), drive(mean_speed=OMEGA, elastic=springs))
    s = result.wucht.summary
    assert s["verdict"] == "not clean"
    assert s["sentence"].startswith("NOT CLEAN on the elastic shaft that fluctuates by 5.78 %")
    assert s["above"]["corrected"] < 1e-12  # on the rigid shaft


def test_where_one_cam_has_no_motion_on_the_shaft_that_twists_the_others_are_still_looked_at():
    """Soft and undamped: with the cam for the rigid shaft there is no motion, with that for the twist there is."""
    soft = {"shaft_stiffness": 8e5, "shaft_damping": 0.0, "cam_inertia": 0.5}
    result = wucht.run(wucht.CamPrediction(**BRIEF), drive(mean_speed=OMEGA, elastic=soft))
    assert result.twisted.values.tolist() == ["corrected for the twist too"]
    s = result.wucht.summary
    assert s["verdict"] == "not clean"
    none = "no periodic motion was obtained with the cam corrected for a rigid shaft"
    assert s["sentence"].endswith(f"{none}, corrected for the twist too it leaves nothing")
    first, second = (told for told in result.wucht.warnings if told.startswith("on the elastic shaft"))
    assert "original cam: at 52.3599 rad/s the cam would have to stand still" in first
    assert "corrected cam: no periodic motion" in second
    assert wucht.draw(result)


def test_an_enforced_speed_behind_a_shaft_that_twists_is_not_clean_either():
    held = {"kind": "constant-speed", "speed": "500 rpm"}
    s = wucht.run(wucht.CamPrediction(), drive(drive=held, elastic=TWISTS)).wucht.summary
    assert s["verdict"] == "not clean"
    assert s["sentence"].startswith("NOT CLEAN on the elastic shaft: the cam corrected for a rigid shaft leaves")
    assert wucht.run(wucht.CamPrediction(), drive(drive=held)).wucht.summary["verdict"] == "enforced"
