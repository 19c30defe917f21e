"""A prediction whose findings are made by hand: every quantity of the Dataset, the lines of the report, and of the figure."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

import wucht
from wucht.cams.correction import Deviation
from wucht.cams.elastic_output import Dwell, ElasticOutput, VibrationOverSpeed
from wucht.cams.laws.standard_laws import RiseAndReturn, standard_law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.numerics.fourier_series import FourierSeries
from wucht.plots.style import COLOURS
from wucht.studies.cam_prediction import computation, confirmation, summary_of_prediction
from wucht.studies.cam_prediction.computation import Eigenmotion, Findings, Plan, ShaftPrediction, prepare
from wucht.studies.cam_prediction.confirmation import Confirmation
from wucht.studies.cam_prediction.dataset import dataset, report
from wucht.studies.cam_prediction.elasticity import Excitation, Twist, Twists, Vibrations, vibrations

LAW = HarmonicLawTable(coefficients={"mean": "0.5 rad", "cosine": ["-0.4 rad", "0.1 rad"]})
J0, J1, OMEGA = 20.0, 6.0, 50.0
SPRINGS = {"output_frequency": "20 Hz", "shaft_stiffness": 4e6, "shaft_damping": 2000.0, "cam_inertia": 0.5}
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
TAU = np.linspace(0.0, 2 * math.pi, 9)
RPM = 30 / math.pi


def planned(**shaft: Any) -> Plan:
    table = {"inertia": J0, "output_inertia": J1} | ({} if "drive" in shaft else {"mean_speed": OMEGA}) | shaft
    asked = wucht.CamPrediction(points=16, speed_points=3, dwell=("-10 deg", "10 deg"), simulate=7)
    return prepare(asked, wucht.CamDrive(LAW, shaft=ShaftTable(**table)))


@pytest.fixture(scope="module")
def plan() -> Plan:
    return planned(elastic=SPRINGS)


@pytest.fixture(scope="module")
def driven() -> Plan:
    return planned(drive=LINEAR)


def orders(cosine: list[float], sine: list[float] | None = None) -> FourierSeries:
    """As many as a result shows."""
    padded = [np.pad(values, (0, 15 - len(values))) for values in (cosine, sine or [])]
    return FourierSeries(0.0, *padded)


ORIGINAL = ShaftPrediction(
    ShaftMotion(FourierSeries.of(50.0, [3.0], [4.0])), orders([30.0, 0.0, 6.0], [40.0, 20.0, 8.0]), Deviation(0.2, 0.03), 0.75,
    np.linspace(100.0, 180.0, 9), Eigenmotion(50.0, 0.125, 900.0, 0.25),
)  # fmt: skip
CORRECTED = ShaftPrediction(
    ShaftMotion(FourierSeries.of(52.0, [0.0, 2.0])), orders([50.0, 10.0]), Deviation(1e-14, 2e-14), 0.5, np.full(9, -20.0), None
)
CONFIRMED = (
    Confirmation(1e-7, orders([0.02, 0.008, 0.0, 0.004]), "", FourierSeries.of(50.0, [3.0], [4.0])),
    Confirmation(2e-7, orders([0.0185, 0.0037, 1e-9]), "", FourierSeries.of(52.0, [0.0, 2.0])),
)
SPEEDS = np.array([40.0, 50.0, 60.0])
SWEEPS = tuple(
    VibrationOverSpeed(
        SPEEDS, 1e-3 * (k + np.arange(3.0)), 2.0 * k + np.arange(3.0), np.array([2, 3]) + k, 0.5 * np.array([100.0, 84.0]) + k
    )
    for k in (1, 2)
)
EXCITATIONS = (
    Excitation("law 3-4-5", 1e-4, 3.0, 5.0), Excitation("corrected cam", 2e-4, 1.0, 7.0), Excitation("law x", 3e-4, 2.0, 6.0),
    Excitation("law y", 4e-4, 4.0, 8.0), Excitation("original cam", 5e-4, 9.0, 4.0),
)  # fmt: skip
TWISTS = Twists((Twist("original cam", 0.3, 700.0, 2e-3), Twist("corrected cam", 0.002, 500.0, 1e-3)), ("no third",))


def made(**other: Any) -> Findings:
    common = {
        "tau": TAU, "original_cam": ORIGINAL, "corrected_cam": CORRECTED, "cam": np.stack([k + TAU for k in range(4)]),
        "constant_speed_power": np.array([0.0, 3e3, 1e3, -1e3, 0.0, -2e3, 2e3, 1e3, 0.0]),
        "cuts": np.array([0.2, 0.05, 0.01]), "failure": "", "confirmations": CONFIRMED,
        "vibrations": Vibrations(("original cam", "corrected cam"), SWEEPS, EXCITATIONS, ("not tuned",)), "twists": TWISTS,
    }  # fmt: skip
    return Findings(**common | other)


@pytest.fixture(scope="module")
def result(plan: Plan) -> xr.Dataset:
    return titled(dataset(plan, made()))


# --- the Dataset ---


def test_both_motions_of_the_shaft(result: xr.Dataset) -> None:
    speed = np.stack([50 + 3 * np.cos(TAU) + 4 * np.sin(TAU), 52 + 2 * np.cos(2 * TAU)])
    assert result.speed.values == pytest.approx(speed)
    torque = np.stack([np.linspace(100.0, 180.0, 9), np.full(9, -20.0)])
    assert result.drive_torque.values == pytest.approx(torque) and result.drive_power.values == pytest.approx(torque * speed)
    assert result.power_at_constant_speed.values.tolist() == made().constant_speed_power.tolist()
    for k, name in enumerate(("position", "velocity", "acceleration", "jerk")):
        assert result[name].values == pytest.approx(k + TAU)
        assert result[name].attrs["units"] == "rad" + ("", "/rad", "/rad^2", "/rad^3")[k]
    assert result.output_acceleration.values[:, :3] == pytest.approx(np.array([[50.0, 20.0, 10.0], [50.0, 10.0, 0.0]]))
    assert not result.output_acceleration.values[:, 3:].any()
    assert result.cut.values.tolist() == [1, 2, 3] and result.cut_residual.values.tolist() == [0.2, 0.05, 0.01]


def test_what_was_simulated(result: xr.Dataset) -> None:
    """Spectra over omega squared: times 2500 and 2704; above N = 2 the largest over order 1."""
    tau = 2 * math.pi * np.arange(36) / 36
    assert result.simulated_tau.values == pytest.approx(tau)
    assert result.simulated_speed.values == pytest.approx(
        np.stack([50 + 3 * np.cos(tau) + 4 * np.sin(tau), 52 + 2 * np.cos(2 * tau)])
    )
    assert result.simulated_deviation.values.tolist() == [1e-7, 2e-7]
    assert result.simulated_acceleration.values[0, :3] == pytest.approx(2500 * np.array([0.02, 0.008, 0.0]))
    assert result.simulated_acceleration.values[1, :3] == pytest.approx(2704 * np.array([0.0185, 0.0037, 1e-9]))
    assert result.simulated_residual.values == pytest.approx([0.2, 1e-9 / 0.0185])
    s = result.wucht.summary["simulation"]
    assert s["turns"] == 7 and s["original"] == {"deviation": 1e-7, "above": pytest.approx(0.2), "failure": ""}
    assert s["corrected"]["above"] == pytest.approx(1e-9 / 0.0185)


def test_a_simulation_that_fails_has_no_speed(plan: Plan) -> None:
    fails = Confirmation(math.nan, FourierSeries.of(0.0), "fails in turn 1 of 7: it burst", FourierSeries.of(0.0))
    some = titled(dataset(plan, made(confirmations=(CONFIRMED[0], fails))))
    assert np.isnan(some.simulated_speed.values[1]).all() and np.isfinite(some.simulated_speed.values[0]).all()
    assert some.wucht.summary["simulation"]["corrected"] == {
        "deviation": None, "above": None, "failure": "fails in turn 1 of 7: it burst",
    }  # fmt: skip
    assert any("7 turns with the corrected cam: it fails" in line for line in report(some))
    assert "simulated_tau" not in dataset(plan, made(confirmations=()))


def test_springs_of_output_and_shaft(result: xr.Dataset) -> None:
    assert result.lever.values.tolist() == ["original cam", "corrected cam"]
    assert result.swept_speed.values.tolist() == [
        40,
        50,
        60,
    ]
    assert result.residual_deviation.values == pytest.approx(1e-3 * np.array([[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]]))
    assert result.residual_acceleration.values == pytest.approx(np.array([[2.0, 3.0, 4.0], [4.0, 5.0, 6.0]]))
    assert result.resonance_order.values.tolist() == [4, 5], "those of the corrected cam"
    assert result.resonance_speed.values.tolist() == [52.0, 44.0]
    for name in ("name", "deviation", "acceleration", "peak"):
        values = result["excited" if name == "name" else f"excited_{name}"].values.tolist()
        assert values == [getattr(e, name) for e in EXCITATIONS]
    assert result.twisted.values.tolist() == ["original cam", "corrected cam"]
    assert result.twist_residual.values.tolist() == [
        0.3,
        0.002,
    ]
    assert result.twist_torque.values.tolist() == [700.0, 500.0] and result.twist_angle.values.tolist() == [2e-3, 1e-3]
    s = result.wucht.summary
    assert s["output"]["natural_frequency"] == pytest.approx(40 * math.pi)
    assert s["output"]["damping_ratio"] == pytest.approx(0.02)
    assert s["output"]["excited"][1] == {"name": "corrected cam", "deviation": 2e-4, "acceleration": 1.0, "peak": 7.0}
    assert s["shaft"][0] == {"name": "original cam", "above": 0.3, "torque": 700.0, "twist": 2e-3}
    assert {"not tuned", "no third"} <= set(warnings_of(result))


def test_the_summary(result: xr.Dataset) -> None:
    s, phi = result.wucht.summary, np.linspace(0.0, 2 * math.pi, 100_001)
    slope = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi)
    assert s["inertia_ratio"] == pytest.approx(J1 * (slope**2).max() / J0, rel=1e-5)
    assert (s["unit"], s["harmonics"], s["driven"]) == ("rad", 2, "eigenmotion")
    assert (s["mean_speed"], s["corrected"]["mean_speed"]) == (50.0, 52.0)
    assert s["fluctuation"] == pytest.approx(10 / 50) and s["corrected"]["fluctuation"] == pytest.approx(4 / 52)
    assert s["speed_orders"] == pytest.approx([5.0]) and s["corrected"]["speed_orders"] == pytest.approx([0.0, 2.0])
    assert s["corrected"]["speed"] == {"mean": 52.0, "cosine": [0.0, 2.0], "sine": [0.0, 0.0]}
    assert s["eigenmotion"] == {"mean_speed": 50.0, "period": 0.125, "energy": 900.0, "fluctuation": 0.25}
    assert s["corrected"]["eigenmotion"] is None
    assert s["above"] == {
        "orders": 2, "reference_order": 1, "law": pytest.approx(0.0, abs=1e-15), "original": 0.2, "corrected": 1e-14,
    }  # fmt: skip
    assert s["position_error"] == {"original": 0.03, "corrected": 2e-14} and s["record"] is None
    assert s["left_after_a_turn"] == {"original": 0.75, "corrected": 0.5}
    assert s["power"]["constant_speed"] == pytest.approx({"peak": 3e3, "mean": 500.0, "mean_positive": 875.0})
    speed = 52 + 2 * np.cos(2 * TAU[:-1])
    corrected = s["power"]["corrected"]
    assert corrected == pytest.approx({"peak": -20 * 50.0, "mean": -20 * speed.mean(), "mean_positive": 0.0})
    original = (np.linspace(100.0, 180.0, 9) * result.speed.values[0])[:-1]
    assert s["mean_power"] == pytest.approx(original.mean()) == s["power"]["original"]["mean"]
    assert s["power_saved"] == pytest.approx({"peak": 4e3, "mean_positive": 875.0})
    assert s["cut_residuals"] == [0.2, 0.05, 0.01] and s["contraction"] == pytest.approx(0.2)


@pytest.mark.parametrize(("cuts", "contraction"), [([0.2], None), ([], None), ([0.2, 0.1, 1e-10], 0.5), ([0.1, 0.3], 3.0)])
def test_a_contraction_leaves_out_what_is_rounding(cuts: list[float], contraction: float | None) -> None:
    found = summary_of_prediction._contraction(np.array(cuts))
    assert found == (None if contraction is None else pytest.approx(contraction))


def test_as_many_orders_as_three_times_those_of_the_law_but_fifteen_at_least_and_a_hundred_at_most(plan: Plan) -> None:
    long = FourierSeries.of(0.0, np.arange(1.0, 201.0))
    shaft = ShaftTable(inertia=J0, output_inertia=J1, mean_speed=OMEGA)
    for count, shown in ((2, 15), (5, 15), (6, 18), (33, 99), (34, 100)):
        law = HarmonicLawTable(coefficients={"mean": 0.5, "cosine": [0.4] + (count - 2) * [0.0] + [0.1]})
        drive = wucht.CamDrive(law, shaft=shaft)
        assert prepare(wucht.CamPrediction(), drive).shown_orders == shown
    prediction = replace(ORIGINAL, acceleration=long), replace(CORRECTED, acceleration=long)
    findings = made(original_cam=prediction[0], corrected_cam=prediction[1], confirmations=())
    assert dataset(replace(plan, shown_orders=18), findings).order.values.tolist() == list(range(1, 19))


def test_assumptions_name_springs_and_drive(plan: Plan) -> None:
    rigid = replace(plan, output=None, twisting=None)
    even = made(vibrations=None, twists=None)
    moved = "the camshaft as inertia and drive move it"
    assert dataset(plan, made()).wucht.assumed == ["elastic parts where stiffnesses are given", moved]
    assert dataset(rigid, even).wucht.assumed == ["rigid parts", moved]
    one = dataset(replace(plan, output=None), made(vibrations=None)).wucht.assumed
    assert one == ["elastic parts where stiffnesses are given", moved]
    held = planned(drive={"kind": "constant-speed", "speed": "500 rpm"})
    assert dataset(held, even).wucht.assumed == ["rigid parts", "the camshaft held at its drive's speed"]


# --- the report ---


def test_the_lines_of_the_report(result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert report(result)[2:] == [
        f"  inertia      of the output at most {s['inertia_ratio']:.3g} of the shaft's; without a drive there is a corrected "
        f"cam up to {s['inertia_ratio_limit']:.3g}",
        "  original     50 rad/s (477 rpm), fluctuating by 20 %; orders above 2: 20 % of order 1",
        "  corrected    52 rad/s (497 rpm), fluctuating by 7.69 %; orders above 2: 1e-14 of order 1",
        "  position     off the law by at most 1.15e-12°; with the original cam by 1.72°",
        "  even speed   would need 3 kW at most, 875 W on average without power flowing back",
        "  drive        none: the eigenmotion saves all of this power",
        "  instead      cutting, measuring and cutting again leaves 20 %, 5 %, 1 %",
        "  simulated    7 turns with the corrected cam: the speed deviates by 2.0e-07; orders above 2: 5.4e-08 of order 1",
        "  elastic      output at 20 Hz, damping ratio 0.02; in the dwell at most",
        "               0.00573°: law 3-4-5",
        "               0.0115°: corrected cam",
        "               0.0172°: law x",
        "               0.0286°: original cam",
        "  shaft        twists by 0.115°, 700 N m, orders above 2: 30 % of order 1: original cam",
        "  shaft        twists by 0.0573°, 500 N m, orders above 2: 0.2 % of order 1: corrected cam",
        "  springs      of output and shaft: each is computed with the other rigid",
    ]


def test_the_lines_of_a_drive(driven: Plan) -> None:
    some = titled(dataset(driven, made(vibrations=None, twists=None, confirmations=(), cuts=np.empty(0))))
    s, lines = some.wucht.summary, report(some)
    assert s["driven"] == "drive" and [line[2:12].strip() for line in lines[2:]] == [
        "inertia", "original", "corrected", "position", "even speed", "drive",
    ]  # fmt: skip
    assert lines[-1] == "  drive        -1 kW at most, 0 W on average; saved 4 kW and 875 W"
    held = planned(drive={"kind": "constant-speed", "speed": "500 rpm"})
    lines = report(titled(dataset(held, made(vibrations=None, twists=None, confirmations=(), cuts=np.empty(0)))))
    assert "without a drive" not in lines[2] and not any(line.startswith("  drive") for line in lines)


# --- the figure ---


def lines_of(axis: Any) -> dict[str, Any]:
    return {str(x.get_label()): x for x in axis.get_lines()}


def test_each_panel(result: xr.Dataset) -> None:
    speed, spectrum, power, cuts, sweep, excited, twist, law = drawn("cam-prediction", result).axes
    deg = np.degrees(TAU)
    for k, name in enumerate(("original", "corrected")):
        line = lines_of(speed)[f"{name} cam"]
        assert line.get_xdata() == pytest.approx(deg) and line.get_ydata() == pytest.approx(RPM * result.speed.values[k])
    for k, name in enumerate(("original", "corrected")):
        line = lines_of(speed)[f"simulated, {name} cam"]
        assert line.get_xdata() == pytest.approx(np.arange(36) * 10.0)
        assert line.get_ydata() == pytest.approx(RPM * result.simulated_speed.values[k])
    mean = [x.get_ydata()[0] for x in speed.get_lines() if len(set(x.get_ydata())) == 1]
    assert mean == [pytest.approx(RPM * 52.0)], "the mean speed with the corrected cam"
    bars = [(b.get_x() + b.get_width() / 2, b.get_y() + b.get_height()) for b in spectrum.patches]
    assert bars[:3] == [pytest.approx((k - 0.2, a)) for k, a in ((1, 50.0), (2, 20.0), (3, 10.0))]
    assert bars[15:17] == [pytest.approx((k + 0.2, a)) for k, a in ((1, 50.0), (2, 10.0))]
    assert spectrum.get_ylim() == pytest.approx((5e-7, 150.0))
    assert [x.get_xdata()[0] for x in spectrum.get_lines() if len(x.get_xdata()) == 2] == [2.5], "the law ends at order 2"
    assert lines_of(power)["at constant speed"].get_ydata() == pytest.approx(1e-3 * result.power_at_constant_speed.values)
    assert lines_of(power)["eigenmotion"].get_ydata()[0] == 0.0
    assert list(cuts.get_lines()[0].get_xdata()) == [1, 2, 3] and list(cuts.get_lines()[0].get_ydata()) == [0.2, 0.05, 0.01]
    assert len(cuts.get_lines()) == 1 and cuts.get_ylabel().replace("\n", " ") == "above order 2, over order 1"
    for k, name in enumerate(("original cam", "corrected cam")):
        assert lines_of(sweep)[name].get_xdata() == pytest.approx(RPM * SPEEDS)
        assert lines_of(sweep)[name].get_ydata() == pytest.approx(np.degrees(result.residual_deviation.values[k]))
    assert lines_of(sweep)["mean speed"].get_xdata()[0] == pytest.approx(RPM * 52.0)
    assert [(t.get_text(), t.xy[0]) for t in sweep.texts] == [
        ("k = 4", pytest.approx(RPM * 52)),
        ("k = 5", pytest.approx(RPM * 44)),
    ]
    tops = [b.get_x() + b.get_width() for b in excited.patches]
    assert tops == pytest.approx([math.degrees(e.deviation) for e in EXCITATIONS])
    assert [t.get_text() for t in excited.texts] == [e.name for e in EXCITATIONS], "the smallest on top"
    assert [t.xy[1] for t in excited.texts] == pytest.approx([4.2, 3.2, 2.2, 1.2, 0.2])
    own = [b.get_facecolor() == excited.patches[1].get_facecolor() for b in excited.patches]
    assert own == [False, True, False, False, True], "cams have another colour than laws"
    assert [t.get_text() for t in twist.texts] == ["original cam: 30 %", "corrected cam: 0.2 %"]
    assert [b.get_x() + b.get_width() for b in twist.patches] == pytest.approx([0.3, 0.002])
    assert law.get_lines()[0].get_xdata() == pytest.approx(deg)
    assert law.get_lines()[0].get_ydata() == pytest.approx(np.degrees(2 + TAU)), "the acceleration"


def test_panels_of_a_drive(driven: Plan) -> None:
    """All power in one unit; without cuts the law; the law's order in the figure of the cuts where it has one."""
    small = replace(CORRECTED, drive=np.full(9, 2.0)), replace(ORIGINAL, drive=np.full(9, 1.0))
    findings = made(
        corrected_cam=small[0], original_cam=small[1], cuts=np.empty(0), confirmations=(), vibrations=None, twists=None
    )
    some = titled(dataset(driven, findings))
    axes = drawn("cam-prediction", some).axes
    labels = [" ".join(a.get_ylabel().split()) for a in axes]
    assert labels[2:] == [
        "power (W)", "power of the drive alone (W)", "acceleration of the cam's law (°/rad²)", "law of the corrected cam (°)",
    ]  # fmt: skip
    assert lines_of(axes[2])["drive, corrected cam"].get_ydata() == pytest.approx(some.drive_power.values[1])
    for k, name in enumerate(("original", "corrected")):
        assert lines_of(axes[3])[f"{name} cam"].get_ydata() == pytest.approx(some.drive_power.values[k])
        assert lines_of(axes[3])[f"{name} cam"].get_color() == (COLOURS[1], COLOURS[0])[k]
    assert axes[5].get_lines()[0].get_ydata() == pytest.approx(np.degrees(TAU))


# --- torques and dwells ---


def test_the_power_at_constant_speed_is_that_of_output_and_loads() -> None:
    """J1 omega^3 psi' psi'' and omega times the loads; over the angle, the last as the first."""
    plan = planned(drive=LINEAR, loads=[{"kind": "viscous", "coefficient": 2.0}, {"kind": "coulomb", "torque": "7 N m"}])
    phi = 2 * math.pi * np.arange(16) / 16
    slope, bend = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)
    expected = J1 * 30.0**3 * slope * bend + 30.0 * (60.0 + 7.0)
    assert computation._constant_speed_power(plan, 30.0) == pytest.approx(np.append(expected, expected[0]), rel=1e-6)
    bare = computation._constant_speed_power(planned(), 30.0)
    assert bare[:-1] == pytest.approx(expected - 30.0 * 67.0, abs=1e-6 * expected.max())


def test_the_torque_of_the_drive_is_its_own() -> None:
    """200 (53.4 - v), whatever the loads; none without a drive; where it enforces the speed, loads and output."""
    shaft, law = ShaftMotion(FourierSeries.of(50.0, [3.0])), LAW.make_motion_law("rad").function
    loads = [{"kind": "viscous", "coefficient": 2.0}]
    drive = computation._drive_torque(planned(drive=LINEAR, loads=loads), law, shaft, TAU)
    assert drive == pytest.approx(200 * (51 * math.pi / 3 - 50 - 3 * np.cos(TAU)))
    assert computation._drive_torque(planned(), law, shaft, TAU).tolist() == [0.0] * 9
    held = planned(drive={"kind": "constant-speed", "speed": 50.0}, loads=loads)
    even = ShaftMotion(FourierSeries.of(50.0))
    slope, bend = 0.4 * np.sin(TAU) - 0.2 * np.sin(2 * TAU), 0.4 * np.cos(TAU) - 0.4 * np.cos(2 * TAU)
    assert computation._drive_torque(held, law, even, TAU) == pytest.approx(100.0 + J1 * 2500 * slope * bend)


def test_a_disturbance_decays_by_the_slope_of_the_torque(plan: Plan) -> None:
    """Of a rigid output that hardly moves: exp(-(200 + 2) T/J0)."""
    still = SimpleNamespace(inertia=J0, output_inertia=0.0, torque=lambda v: (0 * v, np.full(np.shape(v), -202.0)))
    some: Any = SimpleNamespace(shaft=still, is_enforced=False)
    law, shaft = LAW.make_motion_law("rad").function, ShaftMotion(FourierSeries.of(50.0))
    assert computation._energy_multiplier(some, law, shaft) == pytest.approx(math.exp(-202 * 2 * math.pi / 50 / J0))
    assert computation._energy_multiplier(plan, law, shaft) == 1.0
    held: Any = SimpleNamespace(shaft=SimpleNamespace(torque=None), is_enforced=True)
    assert math.isnan(computation._energy_multiplier(held, law, shaft))


def test_speeds_of_the_sweep_are_about_the_mean_speed() -> None:
    plan = planned()
    assert plan.speeds == pytest.approx([25.0, 50.0, 75.0]) and plan.turns == 7 and plan.purity.count == 2
    held = planned(drive={"kind": "constant-speed", "speed": 50.0})
    assert (held.turns, held.cuts) == (0, 0)
    (dwell,) = plan.dwells
    phi = np.linspace(-math.pi / 18, math.pi / 18, 20_001)
    mean = (0.5 - 0.4 * np.cos(phi) + 0.1 * np.cos(2 * phi)).mean()
    assert (dwell.begin, dwell.end) == pytest.approx((-math.pi / 18, math.pi / 18))
    assert dwell.value == pytest.approx(mean, rel=1e-4)


def test_the_cam_that_is_simulated_is_tabulated_by_quintics(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 24 intervals of an uneven shaft the error is tiny; psi'' is the derivative of psi', also past a turn."""
    monkeypatch.setattr(confirmation, "_TABLE", 24)
    law = LAW.make_motion_law("rad").function
    table = confirmation._Table.of(law, ShaftMotion(FourierSeries.of(50.0, [3.0], [4.0])))
    for phi in np.linspace(0.01, 6.2, 57):
        for turn in (0.0, 2 * math.pi, -2 * math.pi):
            p, q = table(float(phi) + turn)
            assert p == pytest.approx(float(law(phi, 1)), abs=5e-7) and q == pytest.approx(float(law(phi, 2)), abs=1e-5)
        step = 1e-5
        slope = (table(float(phi) + step)[0] - table(float(phi) - step)[0]) / (2 * step)
        assert table(float(phi))[1] == pytest.approx(slope, abs=1e-8)


def test_the_acceleration_of_the_shaft_that_is_simulated() -> None:
    """(T - J1 psi' psi'' v^2)/(J0 + J1 psi'^2), with scalars as with arrays."""
    shaft: Any = SimpleNamespace(inertia=J0, output_inertia=J1, torque=lambda v: (30.0 - 2.0 * v, -2.0 + 0 * v))
    free: Any = SimpleNamespace(inertia=J0, output_inertia=J1, torque=None)
    p, q, v = 0.5, -0.25, 10.0
    for one, torque in ((shaft, 10.0), (free, 0.0)):
        expected = (torque + J1 * 0.125 * 100.0) / (J0 + J1 * 0.25)
        assert confirmation._acceleration(one, np.array([p]), np.array([q]), np.array([v])) == pytest.approx([expected])
        table: Any = lambda phi: (p, q)  # noqa: E731
        slope = confirmation._slope(one, table, lambda _, torque=torque: torque)
        assert slope(0.0, np.array([0.3, v])) == pytest.approx([v, expected])


def test_a_simulation_shows_the_last_turn_and_the_deviation_in_all() -> None:
    """A shaft that begins off its steady speed: v = v0 + (v1 - v0) exp(-s t/J0), of an output without inertia."""
    v0, v1, s, turns = 60.0, 50.0, 40.0, 4
    camshaft: Any = SimpleNamespace(inertia=J0, output_inertia=0.0, torque=lambda v: (s * (v0 - v), -s + 0 * v))
    law = LAW.make_motion_law("rad").function
    made_of = confirmation.confirmation(camshaft, law, ShaftMotion(FourierSeries.of(v1)), turns, lambda share: None)
    period = 2 * math.pi / v1
    time = period * (turns - 1 + np.arange(2048) / 2048)
    v, phi = v0 + (v1 - v0) * np.exp(-s * time / J0), v0 * time - (v0 - v1) * J0 / s * (1 - np.exp(-s * time / J0))
    expected = FourierSeries.from_samples(v)
    assert made_of.speed.mean == pytest.approx(expected.mean, rel=1e-10)
    assert made_of.speed.amplitudes == pytest.approx(expected.amplitudes, abs=1e-9)
    assert made_of.deviation == pytest.approx((v0 - v1) * (1 - math.exp(-s * period * turns / J0)) / v1, rel=1e-9)
    slope, bend = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi), 0.4 * np.cos(phi) - 0.4 * np.cos(2 * phi)
    expected = FourierSeries.from_samples((bend * v**2 + slope * s * (v0 - v) / J0) / v1**2)
    assert made_of.acceleration.amplitudes[:20] == pytest.approx(expected.amplitudes[:20], rel=1e-8)


def test_behind_a_stiff_spring_each_cam_rests_in_its_dwell() -> None:
    """The original cam rests while the shaft turns through its dwell, which an uneven shaft reaches later than an even one."""
    rise = RiseAndReturn(standard_law("4-5-6-7"), 0.4, (math.pi / 2, math.pi), (math.pi, 3 * math.pi / 2))
    law: Any = SimpleNamespace(function=rise, series=None)
    uneven, dwell = ShaftMotion(FourierSeries.of(50.0, [5.0], [12.0])), Dwell(-math.pi / 2, math.pi / 2)
    stiff, speeds = ElasticOutput(6.0, 6.0 * 5e4**2), np.array([40.0, 50.0])
    springs = vibrations(stiff, law, uneven, uneven, (dwell,), speeds)
    assert springs.names[:2] == ("original cam", "corrected cam")
    for sweep in springs.sweeps[:2]:
        assert sweep.deviation.max() < 2e-4 * 0.4
    assert max(e.deviation for e in springs.excitations) < 2e-4 * 0.4
    assert float(uneven.time(math.pi / 2)) < math.pi / 2 - 0.1, "the dwells differ"
