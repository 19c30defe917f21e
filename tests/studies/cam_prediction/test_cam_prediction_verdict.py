"""The verdict of cam-prediction: shafts that stand, simulations that differ or do not end, shafts that twist."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.refusals import failed, refused

import wucht
from wucht.cams.correction import CorrectedLaw, Deviation
from wucht.cams.prediction import CamShaft
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.dynamics.work import Work
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.cam_prediction import confirmation as simulation
from wucht.studies.cam_prediction import summary_of_prediction
from wucht.studies.cam_prediction.computation import prepare, run
from wucht.studies.cam_prediction.confirmation import confirmation
from wucht.studies.cam_prediction.elasticity import RIGID_SHAFT_CAM, TWIST_CAM
from wucht.studies.cam_prediction.summary_of_prediction import _departure_text, prediction_quantities, verdict, warnings

RESTRICTIONS = [{"at": "180 deg", "equals": "24 deg"}, {"on": ["-120 deg", "120 deg"], "equals": "0 deg"}]
LAW = HarmonicLawTable(harmonics=5, restrictions=RESTRICTIONS)
OMEGA = 500 * math.pi / 30
COULOMB = {"kind": "coulomb", "torque": "150 N m"}
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
BRIEF = {"cuts": 0, "simulate": 0}


def drive(**shaft):
    return wucht.CamDrive(LAW, shaft=ShaftTable(**{"inertia": 20.0, "output_inertia": 6.0} | shaft))


# --- a shaft that stands ---

STUCK = {
    "constant-torque": {"torque": 10.0},
    "linear": {"slope": 2.0, "no_load_speed": "510 rpm"},
    "induction": {"voltage": 23, "frequency": 50, "pole_pairs": 6, "stator_resistance": 0.3, "rotor_resistance": 0.3,
                  "stator_reactance": 0.6, "rotor_reactance": 0.6},
    "table": {"points": [[0, 100], [40, 149], [60, -100]]},
}  # fmt: skip


@pytest.mark.parametrize("kind", STUCK)
@pytest.mark.parametrize("expected", [{}, {"mean_speed": 50.0}])
def test_a_drive_that_does_not_move_its_dry_friction_is_refused(kind, expected):
    """Friction that is smooth about standstill lets the shaft creep; that is not a speed to make a cam for."""
    with refused("shaft.drive", "150 N", "m", code="stands") as error:
        prepare(wucht.CamPrediction(), drive(drive={"kind": kind, **STUCK[kind]}, loads=[COULOMB], **expected))
    assert error.value.location == "shaft.drive"
    assert error.value.value == kind
    assert "mean_speed" not in error.value.explanation  # which would not help


def test_a_controlled_drive_has_no_torque_over_the_speed():
    controlled = {"kind": "inverter", "set_speed": 50.0, "gain": 10.0, "integral_time": 1.0, "torque_limit": 100.0}
    with refused("shaft.drive.kind", "linear", "constant-speed", given="inverter") as error:
        prepare(wucht.CamPrediction(), drive(drive=controlled))
    assert error.value.location == "shaft.drive.kind"


def test_the_dry_friction_with_which_a_measured_load_begins_counts_too():
    loads = [{"kind": "table", "points": [[0, 80], [100, 200]]}, {"kind": "coulomb", "torque": 70.0}]
    with refused("shaft.drive", "120 N", "m", "150 N", code="stands"):
        prepare(wucht.CamPrediction(), drive(drive={"kind": "constant-torque", "torque": 120.0}, loads=loads))


def test_a_drive_that_carries_its_load_only_at_speed_needs_the_speed_expected():
    """100 N m at standstill, 300 N m at 40 rad/s: by itself it does not start."""
    fan = {"kind": "table", "points": [[0, 100], [40, 300], [60, -100]]}
    with refused("shaft.drive", "mean_speed", code="stands"):
        prepare(wucht.CamPrediction(), drive(drive=fan, loads=[COULOMB]))
    found = wucht.run(wucht.CamPrediction(**BRIEF), drive(drive=fan, loads=[COULOMB], mean_speed=45.0)).wucht.summary
    assert 45 < found["mean_speed"] < 55
    assert found["mean_power"] == pytest.approx(150 * found["mean_speed"], rel=1e-6)


def test_a_slow_shaft_that_does_turn_is_not_refused():
    slow = drive(drive={"kind": "linear", "slope": 1000.0, "no_load_speed": 0.3}, loads=[COULOMB])
    assert prepare(wucht.CamPrediction(), slow).shaft.mean_speed == pytest.approx(0.157, abs=0.01)


def test_a_motion_that_ends_at_standstill_is_a_sentence():
    """The shaft was expected at 50 rad/s, where the drive carries the load; it is found creeping."""
    plan = prepare(wucht.CamPrediction(**BRIEF), drive(drive=LINEAR, loads=[COULOMB]))
    torques = lambda v: (np.array([10.0 + 0 * v, 150 * np.tanh(v / 0.1)]), np.zeros((2, 1)))  # noqa: E731
    creeping = replace(plan.driving, torques=torques)
    stuck = SimpleNamespace(**vars(plan) | {"is_enforced": False, "driving": creeping})
    stuck.shaft = SimpleNamespace(motion_with_cam=lambda law: SimpleNamespace(mean=0.0067))
    with failed("stands", "0.0067 rad/s", "10 N", "m"):
        list(run(stuck, Work()))


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


def predicted(inertia=20.0, torque=None):
    camshaft, law = CamShaft(inertia, 6.0, OMEGA, torque), LAW.make_motion_law("rad").function
    motion = camshaft.motion_with_corrected_cam(law)
    return camshaft, CorrectedLaw(law, motion), motion


def test_the_simulated_output_keeps_its_energy():
    """psi'' is the derivative of the tabulated psi', so that no energy is made or lost, whatever the table."""
    _, cam, motion = predicted()
    table = simulation._Table.of(cam, motion)
    phi, step = np.linspace(0.01, 6.2, 50), 1e-6
    slopes = [(table(p + step)[0] - table(p - step)[0]) / (2 * step) for p in phi]
    assert [table(p)[1] for p in phi] == pytest.approx(slopes, abs=1e-8)
    for order in (1, 2):
        assert [table(p)[order - 1] for p in phi] == pytest.approx(cam(phi, order), abs=1e-9)


def test_a_simulation_that_would_not_end_is_given_up_and_says_so(monkeypatch):
    """A torque that falls by 1e5 N m for each rad/s: a step must be shorter than its time constant."""
    stiff = lambda v: (1e5 * (OMEGA - v), np.full(np.shape(v), -1e5))  # noqa: E731
    monkeypatch.setattr(simulation, "_MOST_CALLS", 3000)
    found = confirmation(*predicted(torque=stiff), 20, lambda share: None)
    assert math.isnan(found.deviation)
    assert found.failure.startswith("fails in turn 1 of 20: a turn takes more than 3000 evaluations")
    given_up = wucht.CamPrediction(cuts=0, simulate=20)
    result = wucht.run(given_up, drive(drive={"kind": "linear", "slope": 1e5, "no_load_speed": OMEGA}))
    assert "the simulation with the corrected cam fails in turn 1 of 20" in result.attrs["warnings"]
    assert result.wucht.summary["verdict"] == "clean"
    assert result.wucht.summary["simulation"]["corrected"] == {"deviation": None, "above": None, "failure": found.failure}
    assert any("with the corrected cam: it fails" in line for line in wucht.report(result))
    assert wucht.draw(result)


def test_a_simulation_reports_and_can_be_stopped():
    shares = []

    def stop(share):
        shares.append(share)
        if len(shares) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        confirmation(*predicted(), 20, stop)
    assert 0 < shares[0] < shares[3] < 0.2


# --- the verdict ---


@pytest.fixture(scope="module")
def found():
    """A clean prediction, whose findings are changed below."""
    plan = prepare(wucht.CamPrediction(cuts=0, simulate=1), drive(mean_speed=OMEGA))
    (findings,) = run(plan, Work())
    return plan, findings


def summary(plan, findings):
    return {quantity.name: quantity.value for quantity in prediction_quantities(plan, findings)}


def said(found, **corrected):
    plan, findings = found
    findings = replace(findings, corrected_cam=replace(findings.corrected_cam, **corrected))
    return verdict(plan, summary(plan, findings))


def test_a_motion_that_is_not_stable_is_not_clean(found):
    label, sentence = said(found, multiplier=1.3)
    assert label == "not clean"
    assert sentence.endswith("nothing in orders above 5, but this motion is not stable: a disturbance grows 1.3-fold in a turn")


def test_a_simulation_that_differs_does_not_confirm_and_the_reason_is_said(found):
    plan, findings = found
    off = replace(findings.confirmations[1], deviation=2e-3, acceleration=FourierSeries.of(0.0, [1.0, 0, 0, 0, 0, 3e-3]))
    label, sentence = verdict(plan, summary(plan, replace(findings, confirmations=(findings.confirmations[0], off))))
    assert label == "not confirmed"
    assert sentence.endswith("leaves nothing in orders above 5, by simulation 0.3 % of order 1")
    assert "by 0.2 % of the speed: without a drive nothing restores the motion" in _departure_text(off, findings.corrected_cam)
    assert _departure_text(off, replace(findings.corrected_cam, multiplier=2.0)).endswith("this motion is not stable")
    assert _departure_text(off, replace(findings.corrected_cam, multiplier=0.5)).endswith("0.2 % of the speed")


def test_what_the_corrected_cam_leaves_is_the_first_thing_said(found):
    label, sentence = said(found, deviation=Deviation(0.02, 0.0))
    assert (label, sentence[:9]) == ("not clean", "NOT CLEAN")
    assert ": the corrected cam leaves 2 % of order 1 in orders above 5, its position is off by 0 % of the stroke" in sentence
    stroke = found[0].purity.stroke
    assert said(found, deviation=Deviation(0.9e-6, 0.9e-6 * stroke))[0] == "clean"
    assert said(found, deviation=Deviation(0.0, 1.1e-6 * stroke))[0] == "not clean", "over time"


def told(found, failure="", **summary_):
    """Warnings of findings, with other numbers of the summary."""
    plan, findings = found
    findings = replace(findings, failure=failure)
    return warnings(plan, findings, summary(plan, findings) | summary_)


def test_a_large_inertia_ratio_and_cutting_again_are_warned_of(found):
    cutting = "cutting a cam and measuring again"
    slow = f"{cutting} converges slowly, each cam leaves 40 % of the residual of the one before; take the predicted cam"
    assert told(found, inertia_ratio=0.5, contraction=0.4) == []
    assert told(found, inertia_ratio=0.51, contraction=0.4) == [f"the inertia ratio J1 max psi'^2/J0 is 0.51: {slow}"]
    assert told(found, inertia_ratio=1.0, contraction=None) == [
        f"the inertia ratio J1 max psi'^2/J0 is 1: {cutting} converges slowly; take the predicted cam"
    ]
    assert told(found, inertia_ratio=1.01, contraction=None) == [
        "the inertia ratio J1 max psi'^2/J0 is 1.01: above about 1 cutting a cam and measuring again may diverge; take the "
        "predicted cam, or a larger flywheel"
    ]
    assert told(found, inertia_ratio=0.1, contraction=0.99) == []
    diverges = [f"{cutting} diverges: the last cam is worse than the one before"]
    assert told(found, inertia_ratio=0.1, contraction=1.0) == diverges
    assert told(found, "it burst", inertia_ratio=0.1, contraction=1.5) == ["it burst"]


def test_why_a_simulation_departs(found):
    _, findings = found
    off = replace(findings.confirmations[1], deviation=2e-3)
    shaft = SimpleNamespace()
    with pytest.MonkeyPatch.context() as patch:
        for share, why in ((2e-6, ", by the orders that the prediction leaves out"), (1e-6, "")):
            patch.setattr(summary_of_prediction, "unresolved_share", lambda _, share=share: share)
            turning = replace(findings.corrected_cam, multiplier=0.5, shaft=shaft)
            assert _departure_text(off, turning) == f"departs from the prediction by 0.2 % of the speed{why}"
            assert _departure_text(off, replace(turning, multiplier=1.01)).endswith("of the speed: this motion is not stable")


def test_a_shaft_that_twists_for_which_there_is_no_cam(found):
    plan, findings = found
    s = summary(plan, findings)
    rigid = {"name": RIGID_SHAFT_CAM, "above": 0.182}
    label, sentence = verdict(plan, s | {"shaft": [rigid]})
    assert label == "not clean"
    assert sentence.endswith(": the cam corrected for a rigid shaft leaves 18.2 % of order 1 in orders above 5")
    assert verdict(plan, s | {"shaft": []})[1].endswith(
        ": no periodic motion was obtained with the cam corrected for a rigid shaft"
    )
    both = [rigid, {"name": TWIST_CAM, "above": 2e-6}]
    assert verdict(plan, s | {"shaft": both})[1].endswith("corrected for the twist too it leaves 0.0002 %")
    assert verdict(plan, s | {"shaft": [rigid | {"above": 1e-3}]})[0] == "clean"


TWISTS = {"shaft_stiffness": 4e6, "shaft_damping": 1000.0, "cam_inertia": 0.5}


def test_the_verdict_counts_the_shaft_that_twists():
    springs = TWISTS | {"output_frequency": "60 Hz"}
    result = wucht.run(wucht.CamPrediction(**BRIEF, speed_points=2), drive(mean_speed=OMEGA, elastic=springs))
    s = result.wucht.summary
    assert s["verdict"] == "not clean"
    begin, end = s["sentence"].split(": ")
    assert begin == "NOT CLEAN on the elastic shaft that fluctuates by 5.78 %"
    left = "leaves 18.2 % of order 1 in orders above 5, corrected for the twist too it leaves nothing"
    assert end == f"the cam corrected for a rigid shaft {left}"
    assert s["above"]["corrected"] < 1e-12  # on the rigid shaft
    assert "each is computed with the other rigid" in "\n".join(wucht.report(result))


def test_a_stiff_shaft_stays_clean_and_one_spring_alone_needs_no_note():
    stiff = {"shaft_stiffness": 4e9, "shaft_damping": 2e5, "cam_inertia": 0.5}
    result = wucht.run(wucht.CamPrediction(**BRIEF), drive(mean_speed=OMEGA, elastic=stiff))
    assert result.wucht.summary["verdict"] == "clean"
    assert "twists" not in result.attrs["warnings"]
    assert "rigid" not in "\n".join(wucht.report(result))


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


def test_a_simulation_that_stays_behind_departs_as_one_that_leads():
    """The speed computed for another output: below that predicted, or above it; the deviation is a size."""
    shaft, cam, motion = predicted()
    for factor in (0.9, 1.1):
        other = replace(shaft, inertia=factor * shaft.inertia)
        assert confirmation(other, cam, motion, 1, lambda share: None).deviation > 1e-4
