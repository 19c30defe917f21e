"""The study cam-prediction: its numbers against integration and closed forms, every drive, what is refused, springs, files."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from tests.refusals import check_refusal, failed, refused

import wucht
from interrupting import assert_same, stop_at
from wucht import run_file
from wucht.cams.correction import CorrectedLaw
from wucht.cams.drive import laws
from wucht.cams.dwells import dwells_of
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.cams.tables.speed import SpeedTable
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.registry import study_of

RESTRICTIONS = [{"at": "180 deg", "equals": "24 deg"}, {"on": ["-120 deg", "120 deg"], "equals": "0 deg"}]
LAW = HarmonicLawTable(harmonics=5, restrictions=RESTRICTIONS)
OMEGA = 500 * math.pi / 30
TURN = 2 * math.pi
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
COULOMB = {"kind": "coulomb", "torque": "150 N m"}
BRIEF = {"cuts": 0, "simulate": 0}


def drive(law=LAW, **shaft):
    table = {"inertia": 20.0, "output_inertia": 6.0} | shaft
    return wucht.CamDrive(law, shaft=ShaftTable(**{k: v for k, v in table.items() if v is not None}))


def series(result):
    """The law of the corrected cam, by its samples over a turn."""
    return FourierSeries.from_samples(result.position.values[:-1])


def settled(law, inertia, output, torque, begin, turns):
    """phi' over phi of a shaft that is integrated over its angle for so many turns, and then its mean over time."""

    def slope(phi, energy):
        v = math.sqrt(2 * energy[0] / (inertia + output * float(law(phi, 1)) ** 2))
        return [torque(v)]

    start = (inertia + output * float(law(0.0, 1)) ** 2) * begin**2 / 2
    phi = TURN * np.linspace(turns - 1, turns, 2001)
    run = solve_ivp(slope, (0, TURN * turns), [start], "DOP853", t_eval=phi, rtol=1e-11, atol=1e-9)
    v = np.sqrt(2 * run.y[0] / (inertia + output * law(phi, 1) ** 2))
    return phi - phi[0], v, TURN / (np.mean(1 / v[:-1]) * TURN)


@pytest.fixture(scope="module")
def eigenmotion():
    return wucht.run(wucht.CamPrediction(cuts=4, simulate=5), drive(mean_speed=OMEGA))


@pytest.fixture(scope="module")
def driven():
    return wucht.run(wucht.CamPrediction(cuts=0, simulate=8), drive(drive=LINEAR, loads=[COULOMB]))


def test_the_eigenmotion_is_that_of_the_cases(eigenmotion):
    """cam-mathematics.md: of orders 6-10 a part stays after a cut, 0.26 -> 0.036 of order 1 at kappa = 0.11."""
    s = eigenmotion.wucht.summary
    assert s["inertia_ratio"] == pytest.approx(0.11345, abs=1e-5)
    assert s["cut_residuals"][:2] == pytest.approx([0.2634, 0.0358], abs=1e-4)
    assert s["contraction"] == pytest.approx(0.11, abs=0.01)
    assert s["above"]["original"] == s["cut_residuals"][0]
    assert s["above"]["corrected"] < 1e-13
    assert (s["mean_speed"], s["corrected"]["mean_speed"]) == pytest.approx((OMEGA, OMEGA))
    assert s["driven"] == "eigenmotion"
    assert eigenmotion.attrs["sentence"].startswith("CLEAN on a shaft that fluctuates by 5.78 %: ")
    assert not eigenmotion.drive_power.values.any()
    assert eigenmotion.wucht.warnings == []


def test_the_eigenmotion_keeps_its_energy(eigenmotion):
    """Original: J(phi) phi'^2 is constant; corrected: J0 phi'^2 + J1 psi_t^2, with the law over time."""
    law, tau = LAW.make_motion_law("rad").function, eigenmotion.tau.values
    speed = eigenmotion.speed.sel(cam="corrected").values
    energy = 20 * speed**2 + 6 * OMEGA**2 * law(tau, 1) ** 2
    assert energy == pytest.approx(energy[0], rel=1e-9)
    v = eigenmotion.speed.sel(cam="original").values
    turned = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(tau)) / OMEGA])
    energy = (20 + 6 * law(turned, 1) ** 2) * v**2
    assert energy == pytest.approx(energy[0], rel=2e-4)  # the angle by the trapezoidal rule
    low, high = speed.min(), speed.max()
    assert eigenmotion.wucht.summary["corrected"]["fluctuation"] == pytest.approx((high - low) / OMEGA, rel=1e-3)


@pytest.mark.parametrize("driven", [False, True])
def test_the_period_of_the_eigenmotion_of_the_cases(driven):
    """cases.md: J = 2 (1 + 0.3 cos 2 phi), E = 15300: T = 0.0505045348634485; here J = 1.4 + 1.2 cos^2 phi. A drive that moves
    the mean speed moves the energy by its square."""
    known, asked = TURN / 0.0505045348634485, {}
    if driven:
        asked = {"drive": {"kind": "linear", "slope": 0.1, "no_load_speed": known}}
    law = HarmonicLawTable(coefficients={"sine": ["1 rad"]})
    shaft = ShaftTable(inertia=1.4, output_inertia=1.2, mean_speed=known, **asked)
    s = wucht.run(wucht.CamPrediction(cuts=0, simulate=0), wucht.CamDrive(law, shaft=shaft)).wucht.summary
    mean, corrected = s["mean_speed"], s["corrected"]
    assert mean == pytest.approx(known, rel=2e-2 if driven else 1e-12)
    assert (abs(mean - known) > 1e-5) == driven
    assert s["eigenmotion"]["energy"] == pytest.approx(15300 * (mean / known) ** 2, rel=1e-12)
    assert s["eigenmotion"]["period"] == pytest.approx(TURN / mean, rel=1e-14)
    assert s["eigenmotion"]["mean_speed"] == mean
    speeds = np.sqrt(15300 / (1 + 0.3 * np.array([1.0, -1.0])))
    assert s["eigenmotion"]["fluctuation"] == pytest.approx((speeds[1] - speeds[0]) / known, rel=1e-7)
    assert s["fluctuation"] == pytest.approx(s["eigenmotion"]["fluctuation"], rel=1e-3 if driven else 1e-12)
    assert np.max(s["speed_orders"][::2]) < 1e-3 * np.max(s["speed_orders"])
    assert s["mean_power"] == pytest.approx(0, abs=1e-5)
    energy = _energy_with_the_corrected_cam(1.4, 1.2, corrected["mean_speed"])
    assert corrected["eigenmotion"]["energy"] == pytest.approx(energy, rel=1e-9)


def _energy_with_the_corrected_cam(J0, J1, mean):
    """2 E = J0 phi'^2 + J1 (mean cos tau)^2, so that phi' has that mean."""
    from scipy.optimize import brentq

    tau = TURN * np.arange(4000) / 4000
    excess = J1 * (mean * np.cos(tau)) ** 2

    return brentq(lambda E: np.sqrt((2 * E - excess) / J0).mean() - mean, excess.max() / 2, 1e6, xtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("begin", "output", "told"), [("90 deg", 6.0, False), ("178 deg", 0.01, True)])
def test_a_speed_whose_orders_have_no_end_is_told(begin, output, told):
    """The acceleration of the simple harmonic law jumps: of a rise in two degrees orders up to 1023 are not enough."""
    law = laws()["simple-harmonic"](stroke="24 deg", rise=(begin, "180 deg"))
    result = wucht.run(wucht.CamPrediction(**BRIEF), drive(law, output_inertia=output, mean_speed=OMEGA))
    assert ("highest orders of the speed" in result.attrs["warnings"]) == told


def test_the_corrected_cam_makes_the_law_of_time(eigenmotion):
    """Its law at the angle that the shaft has reached, which is integrated here, is the law at the time."""
    law, tau, speed = (
        LAW.make_motion_law("rad").function,
        eigenmotion.tau.values,
        FourierSeries.from_samples(eigenmotion.speed.values[1, :-1]),
    )
    at = TURN * np.array([0.2, 0.41, 0.5, 0.66, 0.9])
    turned = [quad(speed, 0, t, epsabs=1e-11, limit=200)[0] / OMEGA for t in at]
    assert series(eigenmotion)(turned) == pytest.approx(law(at), abs=1e-9)
    cam = eigenmotion.position.values
    assert np.abs(cam - law(tau)).max() > math.radians(0.1)  # not the original one
    for order, name in enumerate(("velocity", "acceleration", "jerk"), 1):
        expected = series(eigenmotion)(tau, order)
        assert eigenmotion[name].values == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


def test_its_speed_can_be_asked_for_as_if_it_was_measured(eigenmotion):
    """In the table [speed] of cam-correction; here its cam is the one predicted."""
    given = SpeedTable(**eigenmotion.wucht.summary["corrected"]["speed"])
    cam = CorrectedLaw(LAW.make_motion_law("rad").function, given.shaft(None))
    assert cam(eigenmotion.cam_angle.values) == pytest.approx(eigenmotion.position.values, abs=1e-10)


def test_the_simulation_confirms_the_spectrum(eigenmotion):
    s = eigenmotion.wucht.summary["simulation"]
    assert s["turns"] == 5
    assert 0 < s["corrected"]["deviation"] < 1e-9
    assert 0 < s["corrected"]["above"] < 1e-9
    assert s["original"]["above"] == pytest.approx(eigenmotion.wucht.summary["above"]["original"], rel=1e-8)
    found, predicted = eigenmotion.simulated_acceleration.values, eigenmotion.output_acceleration.values
    assert found == pytest.approx(predicted, abs=1e-8 * predicted.max())


def test_at_constant_speed_the_output_takes_what_the_cam_gives(eigenmotion):
    law, tau = LAW.make_motion_law("rad").function, np.linspace(0, TURN, 721)
    power = 6 * OMEGA**3 * law(tau, 1) * law(tau, 2)
    assert eigenmotion.power_at_constant_speed.values == pytest.approx(power, abs=1e-9 * power.max())
    found = eigenmotion.wucht.summary["power"]["constant_speed"]
    assert found["peak"] == pytest.approx(power.max())
    assert found["mean"] == pytest.approx(0.0, abs=1e-6 * power.max())
    swings = 3 * OMEGA**2 * law(TURN * np.arange(4001) / 4000, 1) ** 2 * OMEGA / TURN  # the power of each rise of the energy
    assert found["mean_positive"] == pytest.approx(np.maximum(np.diff(swings), 0).sum(), rel=1e-4)
    assert eigenmotion.wucht.summary["power_saved"] == {k: found[k] for k in ("peak", "mean_positive")}


@pytest.mark.slow
def test_with_a_drive_it_is_what_integration_settles_to(driven):
    """Both cams, over the angle, from a speed far off: 200 (53.4 - phi') - 150."""

    def torque(v):
        return 200 * (510 * math.pi / 30 - v) - 150

    s = driven.wucht.summary
    for one, law in ((s, LAW.make_motion_law("rad").function), (s["corrected"], series(driven))):
        _, v, mean = settled(law, 20.0, 6.0, torque, 40.0, 30)
        assert one["mean_speed"] == pytest.approx(mean, rel=1e-8)
        assert one["fluctuation"] == pytest.approx((v.max() - v.min()) / mean, rel=1e-4)  # of samples
    assert s["left_after_a_turn"]["original"] == pytest.approx(math.exp(-200 * TURN / OMEGA / 20.5), rel=0.03)
    assert s["simulation"]["corrected"]["deviation"] < 1e-9
    mean_load = 150 * s["corrected"]["mean_speed"]
    assert s["power"]["corrected"]["mean"] == pytest.approx(mean_load, rel=1e-9)  # work in, work out
    assert s["power"]["constant_speed"]["mean"] == pytest.approx(mean_load, rel=1e-9)
    assert s["power_saved"]["peak"] > 0.9 * s["power"]["constant_speed"]["peak"]


@pytest.mark.slow
def test_a_disturbance_decays_as_it_is_said(driven):
    law = LAW.make_motion_law("rad").function

    def after_a_turn(begin):
        return settled(law, 20.0, 6.0, lambda v: 200 * (510 * math.pi / 30 - v) - 150, begin, 1)[1][-1]

    steady = float(driven.speed.sel(cam="original")[0])
    grown = after_a_turn(steady * (1 + 1e-4)) - steady
    assert grown / (1e-4 * steady) == pytest.approx(driven.wucht.summary["left_after_a_turn"]["original"], rel=1e-3)


DRIVES = {
    "linear": {"slope": 50.0, "no_load_speed": 55.0},
    "constant-torque": {"torque": 100.0},
    "table": {"points": [[0, 900], [40, 700], [60, -100]]},
    "induction": {"voltage": 230, "frequency": 50, "pole_pairs": 6, "stator_resistance": 0.3, "rotor_resistance": 0.3,
                  "stator_reactance": 0.6, "rotor_reactance": 0.6},
    "dc-separate": {"voltage": 220, "armature_resistance": 0.3, "motor_constant": 1.0, "flux": 4.0},
    "dc-shunt": {"voltage": 220, "armature_resistance": 0.3, "field_resistance": 100, "field_inductance": 2.0,
                 "motor_constant": 0.9},
    "dc-series": {"voltage": 220, "armature_resistance": 0.3, "field_resistance": 0.2, "field_inductance": 0.1,
                  "motor_constant": 1.0},
    "constant-speed": {"speed": "500 rpm"},
    "synchronous": {"frequency": 50, "pole_pairs": 6},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", [k for k in DRIVES if k not in ("constant-speed", "synchronous")])
def test_with_every_drive_work_in_is_work_out(kind):
    asked = drive(drive={"kind": kind, **DRIVES[kind]}, loads=[{"kind": "viscous", "coefficient": 2.0}])
    result = wucht.run(wucht.CamPrediction(**BRIEF), asked)
    s = result.wucht.summary
    for name in ("original", "corrected"):
        speed = result.speed.sel(cam=name).values[:-1]
        assert s["power"][name]["mean"] == pytest.approx(np.mean(2.0 * speed**2), rel=1e-7)
        assert 0 < s["left_after_a_turn"][name] < 1
        assert (s if name == "original" else s["corrected"])["fluctuation"] > 0.04
    assert s["above"]["corrected"] < 1e-12


@pytest.mark.parametrize("kind", ["constant-speed", "synchronous"])
def test_a_drive_that_enforces_its_speed_needs_no_other_cam(kind):
    load = {"kind": "viscous", "coefficient": 2.0}
    result = wucht.run(wucht.CamPrediction(), drive(drive={"kind": kind, **DRIVES[kind]}, loads=[load]))
    s, law, tau = result.wucht.summary, LAW.make_motion_law("rad").function, result.tau.values
    assert s["corrected"]["mean_speed"] == pytest.approx(OMEGA)
    assert (s["fluctuation"], s["corrected"]["fluctuation"]) == (0, 0)
    assert result.position.values == pytest.approx(law(tau), abs=1e-14)
    expected = 6 * OMEGA**2 * law(tau, 1) * law(tau, 2) + 2 * OMEGA
    assert result.drive_torque.sel(cam="corrected").values == pytest.approx(expected, abs=1e-8 * expected.max())
    assert result.attrs["sentence"].startswith("the drive holds the shaft's speed")
    assert s["simulation"] is None
    assert wucht.draw(result).axes and wucht.report(result)


def test_a_motion_that_is_not_stable_is_said_to_be():
    """A drive whose torque rises through that of the load at 50 rad/s."""
    rising = {"kind": "table", "points": [[30, 80], [50, 100], [70, 120]]}
    loads = [{"kind": "coulomb", "torque": 100.0}]
    result = wucht.run(wucht.CamPrediction(**BRIEF), drive(drive=rising, loads=loads, mean_speed=50.0))
    assert result.wucht.summary["left_after_a_turn"]["corrected"] > 1
    assert "not stable" in result.attrs["warnings"]


def test_the_inertia_ratio_warns():
    ask = wucht.CamPrediction(cuts=3, simulate=0, points=16)
    heavy = wucht.run(ask, drive(mean_speed=OMEGA, output_inertia=30.0))
    assert heavy.wucht.summary["inertia_ratio"] == pytest.approx(0.567, abs=1e-3)
    again, rate = "cutting a cam and measuring again", 100 * heavy.wucht.summary["contraction"]
    assert f"{again} converges slowly, each cam leaves {rate:.3g} %" in heavy.wucht.warnings[0] and 40 < rate < 60
    per_inertia = heavy.wucht.summary["inertia_ratio"] / 30.0
    for ratio, words in ((0.499, []), (0.501, ["slowly; take"]), (0.999, ["slowly; take"]), (1.001, ["about 1 " + again])):
        found = wucht.run(wucht.CamPrediction(points=16, **BRIEF), drive(mean_speed=OMEGA, output_inertia=ratio / per_inertia))
        assert [any(word in said for word in words) for said in found.wucht.warnings] == [True] * len(words), ratio
    with failed("comes-to-rest", "2", "3", "1.29"):
        wucht.run(ask, drive(mean_speed=OMEGA, output_inertia=160.0))


@pytest.mark.parametrize(
    "shaft",
    [
        {}, {"loads": [COULOMB], "mean_speed": 50.0}, {"drive": LINEAR | {"slope": "-3 N m s"}},
        {"drive": LINEAR | {"on": "x"}}, {"drive": {"kind": "table", "speed": [1, 2]}},
        {"mean_speed": 50.0, "output_mass": 3.0},
        {"mean_speed": 50.0, "output_inertia": None}, {"drive": {"slope": 3}}, {"drive": {"kind": "lineer"}},
        {"drive": LINEAR | {"no_load_speed": -50.0}}, {"drive": {"kind": "constant-torque", "torque": 5.0}},
        {"drive": {"kind": "constant-speed", "speed": 5.0}, "mean_speed": 50.0},
        {"mean_speed": 50.0, "output_inertia": None, "output_mass": 3.0},
        {"mean_speed": 50.0, "elastic": {"output_stiffness": "3 N/m"}},
        {"mean_speed": 50.0, "elastic": {"output_frequency": 9, "output_damping": "1 N s/m"}},
        {"mean_speed": 50.0, "elastic": {"output_stiffness": 0}},
        {"mean_speed": 50.0, "output_inertia": 0.0, "elastic": {"output_frequency": 9}},
    ],
)  # fmt: skip
def test_what_is_wrong_is_located(shaft):
    check_refusal(f"cam-prediction: {shaft}", lambda: wucht.run(wucht.CamPrediction(), drive(**shaft)))


def test_the_shaft_is_needed_and_the_cam_is_a_part_of_it():
    with refused("shaft", given=None, code="missing"):
        wucht.run(wucht.CamPrediction(), wucht.CamDrive(LAW))
    with refused("shaft.inertia", given=20.0):
        drive(elastic={"shaft_stiffness": 1e6, "cam_inertia": 20.0})


# --- springs ---


def test_where_the_law_rests():
    (arc,) = dwells_of(LAW.make_motion_law("rad"))
    assert (arc.begin, arc.end, arc.value) == pytest.approx((-TURN / 3, TURN / 3, 0.0))
    rests = dwells_of(laws()["3-4-5"](stroke="10 mm", rise=("60 deg", "150 deg")).make_motion_law("m"))
    arcs = sorted((round(math.degrees(d.begin)) % 360, round(math.degrees(d.end)) % 360, d.value) for d in rests)
    assert arcs == [(150, 210, pytest.approx(0.01)), (300, 60, pytest.approx(0.0, abs=1e-12))]
    waves = HarmonicLawTable(coefficients={"cosine": ["3 deg"]})
    with refused("study.dwell", given=None):
        wucht.run(wucht.CamPrediction(), drive(waves, mean_speed=50.0, elastic={"output_frequency": 400.0}))
    asked = wucht.CamPrediction(dwell=("-3 deg", "3 deg"), speed_points=3, points=16, **BRIEF)
    stiff = wucht.run(asked, drive(waves, mean_speed=50.0, elastic={"output_frequency": "10 kHz"}))
    assert stiff.swept_speed.values[[0, -1]] == pytest.approx([25.0, 75.0]), "from half the mean speed to one and a half times"
    left = stiff.excited_deviation.sel(excited="corrected cam")
    assert float(left) == pytest.approx(math.radians(3) * (1 - math.cos(math.pi / 60)), rel=0.4), "about the mean in the dwell"


@pytest.fixture(scope="module")
def elastic():
    springs = {"output_frequency": "60 Hz", "shaft_stiffness": 4e6, "shaft_damping": 2000.0, "cam_inertia": 0.5}
    asked = wucht.CamPrediction(**BRIEF, speeds=("600 rpm", "1300 rpm"), speed_points=60)
    return wucht.run(asked, drive(mean_speed=OMEGA, elastic=springs))


def test_the_dwell_is_disturbed_most_where_an_order_meets_the_natural_frequency(elastic):
    """k omega = omega_0: 3600/5, 3600/4, 3600/3 rpm."""
    speeds = elastic.swept_speed.values * 30 / math.pi
    assert elastic.resonance_order.values.tolist() == [3, 4, 5]
    assert elastic.resonance_speed.values * 30 / math.pi == pytest.approx([1200, 900, 720])
    left = elastic.residual_acceleration.sel(lever="corrected cam").values
    peaks = speeds[1:-1][(left[1:-1] > left[:-2]) & (left[1:-1] > left[2:])]
    assert len(peaks) == 3
    assert peaks == pytest.approx([720, 900, 1200], rel=0.015)


def test_the_tuned_cam_leaves_the_law_at_its_speed(elastic):
    s = elastic.wucht.summary
    assert s["output"]["natural_frequency"] == pytest.approx(120 * math.pi)
    assert s["output"]["damping_ratio"] == pytest.approx(0.02)
    by_name = {e["name"]: e for e in s["output"]["excited"]}
    tolerance = math.radians(24) * 243 / 29525  # of the flattest dwell of five harmonics
    assert by_name["corrected and tuned cam"]["deviation"] == pytest.approx(tolerance, rel=1e-5)
    peak = OMEGA**2 * np.abs(LAW.make_motion_law("rad").function(np.linspace(0, TURN, 20001), 2)).max()
    assert by_name["corrected and tuned cam"]["peak"] == pytest.approx(peak, rel=1e-6)
    assert by_name["corrected cam"]["deviation"] > 3 * tolerance
    assert by_name["law 3-4-5"]["deviation"] > by_name["corrected cam"]["deviation"]
    deviations = [e["deviation"] for e in s["output"]["excited"]]
    assert deviations == sorted(deviations)


def test_the_response_per_order_is_that_of_one_mass(elastic):
    """The corrected cam's lever moves by the law: the peak of the output from |H_k|, added up with its phases here."""
    law, omega0 = LAW.make_motion_law("rad").function, 120 * math.pi
    k = np.arange(1, 6) * OMEGA
    response = (omega0**2 + 0.04j * omega0 * k) / (omega0**2 + 0.04j * omega0 * k - k**2)
    tau = np.linspace(0, TURN, 20001)
    moved = ((law.cosine - 1j * law.sine) * response * -(k**2)) @ np.exp(1j * np.outer(np.arange(1, 6), tau))
    found = elastic.excited_peak.sel(excited="corrected cam")
    assert float(found) == pytest.approx(np.abs(moved.real).max(), rel=1e-6)


def test_a_shaft_that_twists_asks_for_its_own_cam(elastic):
    twisted = elastic.twist_residual
    assert twisted.sel(twisted="corrected for the twist too") < 1e-9
    assert twisted.sel(twisted="corrected cam") > 0.05
    torque, twist = elastic.twist_torque.values, elastic.twist_angle.values
    assert twist == pytest.approx(torque / 4e6, rel=0.1)  # but for the damper
    assert "elastic shaft: " in elastic.attrs["warnings"]
    stiff = {"shaft_stiffness": 4e9, "shaft_damping": 2e5, "cam_inertia": 0.5}
    rigid = wucht.run(wucht.CamPrediction(**BRIEF), drive(mean_speed=OMEGA, elastic=stiff))
    assert rigid.twist_residual.sel(twisted="corrected cam") < 1e-3
    assert rigid.twist_residual.sel(twisted="original cam") == pytest.approx(rigid.wucht.summary["above"]["original"], rel=0.01)


# --- files, figure, sentences ---


@pytest.mark.slow
def test_resumed_it_is_the_uninterrupted_one(tmp_path):
    """Stopped before the springs: motions, the cut cam and the simulation are kept."""
    asked = wucht.CamPrediction(cuts=1, simulate=1, speed_points=2)
    subject = drive(mean_speed=OMEGA, elastic={"output_frequency": "60 Hz", "shaft_stiffness": 4e6, "cam_inertia": 0.5})
    with pytest.raises(KeyboardInterrupt):
        wucht.run(asked, subject, folder=tmp_path, progress=stop_at(1, "springs"))
    assert (tmp_path / "units").exists()
    assert_same(wucht.run(asked, subject, folder=tmp_path, resume=True), wucht.run(asked, subject))


def write(tmp_path, *changes):
    text = study_of("cam-prediction").template
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "cam.toml"
    path.write_text(text)
    return path


def test_the_template_runs_with_a_drive_from_a_file(tmp_path):
    (tmp_path / "motor.csv").write_text("speed [rpm], torque [N m]\n0, 900\n490, 300\n520, -100\n")
    path = write(
        tmp_path,
        ("mean_speed = ", "# mean_speed = "),
        ("# [shaft.drive] ", "[shaft.drive]\nkind = 'table'\nfile = 'motor.csv' #"),
    )
    result = run_file(path, {"study.cuts": 0, "study.simulate": 1, "study.speed_points": 5, "shaft.output_inertia": 5})
    assert result.wucht.summary["driven"] == "drive"
    assert result.wucht.summary["power"]["corrected"]["mean"] == pytest.approx(0.0, abs=1e-3)  # nothing is lost
    assert result.wucht.summary["corrected"]["mean_speed"] == pytest.approx(512.5 * math.pi / 30, rel=0.01)
    with refused("shaft.loads[0].torque", given="3 N", file="cam.toml"):
        run_file(write(tmp_path, ("mean_speed", "drive = { kind = 'linear', slope = 3, no_load_speed = 3 }\n"
                       "loads = [{ kind = 'coulomb', torque = '3 N' }]\nmean_speed")))  # fmt: skip


def test_a_slide_is_shown_in_millimetres():
    asked = wucht.CamPrediction(orders=12, speed_points=4, dwell=("160 deg", "200 deg"), **BRIEF)
    law = HarmonicLawTable(harmonics=3, restrictions=[{"at": "0 deg", "equals": "0 mm"}, {"at": "180 deg", "equals": "60 mm"}],
                        objective="least-mean-square-acceleration")  # fmt: skip
    slide = drive(
        law, output_inertia=None, output_mass=80.0, inertia=5.0, mean_speed=12.0, elastic={"output_stiffness": "4e6 N/m"}
    )
    result = wucht.run(asked, slide)
    assert result.wucht.summary["unit"] == "m"
    assert result.output_acceleration.attrs["units"] == "m/s^2"
    assert result.wucht.summary["output"]["natural_frequency"] == pytest.approx(math.sqrt(4e6 / 80))
    assert wucht.draw(result).axes and wucht.report(result)
