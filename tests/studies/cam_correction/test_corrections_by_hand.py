"""A correction whose findings are made by hand: every quantity of the Dataset, verdicts beside their limits, the report."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from known_cam import LAW, SHAFT
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from tests.hand_made import drawn, titled

from wucht.cams.correction import AccelerationComparison, Deviation, Residual
from wucht.cams.drive import cam_drive_from
from wucht.cams.shape import Extreme, Shape
from wucht.cams.undercut import RadiusAt
from wucht.measurements.order_checks import OmittedOrder
from wucht.measurements.order_fit import OrderFit
from wucht.numerics.fourier_series import FourierSeries
from wucht.plots.style import COLOURS
from wucht.studies.cam_correction import figure as figure_module
from wucht.studies.cam_correction import prepare as preparing
from wucht.studies.cam_correction import run as running
from wucht.studies.cam_correction.dataset import dataset, sentence
from wucht.studies.cam_correction.prepare import MeasuredAcceleration, Plan, prepare
from wucht.studies.cam_correction.report import _position_error_text, report
from wucht.studies.cam_correction.run import Contour, Findings, LeftOut, Proof
from wucht.studies.cam_correction.spec import CamCorrection

LAW_TABLE = {"kind": "harmonic", "coefficients": {"mean": LAW.mean, "cosine": [*LAW.cosine], "sine": [*LAW.sine]}}
SPEED = {"mean": SHAFT.mean, "cosine": [*SHAFT.speed.cosine], "sine": [*SHAFT.speed.sine]}
LEVER = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg",
         "counter": {"arm": 0.07, "roller_radius": 0.012, "angle": "110 deg"}}  # fmt: skip
W2 = SHAFT.mean**2
ANGLES = 2 * math.pi * np.arange(36) / 36
TAU = np.linspace(0.0, 2 * math.pi, 13)
NAMES = ("cam", "counter")


@pytest.fixture(scope="module")
def bare() -> Plan:
    """Without a record: N = 5, 15 orders."""
    return prepare(CamCorrection(points=36), cam_drive_from({"law": LAW_TABLE, "follower": LEVER, "speed": SPEED}, "Two", None))


FIT = OrderFit(
    "record", (2, 4), FourierSeries.of(SHAFT.mean, [0.0, 3.0, 0.0, 1.0], [0.0, 4.0, 0.0, 0.0]),
    np.diag(np.array([0.5, 0.1, 0.2, 0.3, 0.4]) ** 2), 0.25, 0.0, 7.5, 6000, "rad/s", 4.0, 0.05,
    (OmittedOrder(3, 0.75, 0.01, 0.5), OmittedOrder(6, 0.25, 0.02, 0.25)), (),
)  # fmt: skip
MEASURED = MeasuredAcceleration(
    SimpleNamespace(time=np.linspace(0.0, 1.0, 11), values=np.arange(11.0)),  # type: ignore[arg-type]
    AccelerationComparison(
        FourierSeries.of(5.0, [30.0, 0.0, 8.0], [40.0, 20.0, 6.0]), FourierSeries.of(0.0, [40.0, 10.0], [30.0, 0.0]), 0.8
    ),
    "corrected", 10.0, 6.5, (),
)  # fmt: skip


@pytest.fixture(scope="module")
def plan(bare: Plan) -> Plan:
    return replace(bare, fit=FIT, measurement=MEASURED, zero=0.125, delay=(0.05, 0.95))


def shape(k: int) -> Shape:
    return Shape(
        RadiusAt(0.010 + k / 1000, 1.0 + k), None if k == 2 else RadiusAt(0.080 + k / 1000, 2.0 + k),
        Extreme(0.5 + k / 100, 3.0 + k), Extreme(0.03 + k / 1000, 0.1), Extreme(0.07 + k / 1000, 0.2), (),
        ((1.0, 1.0 + 0.01 * k),) if k else (), 0.02 + k / 1000, RadiusAt(0.07 + k / 1000, 5.0), "roller",
    )  # fmt: skip


def contour(k: int) -> Contour:
    points = (0.04 + k / 100) * np.exp(1j * ANGLES)
    return Contour(
        points, np.exp(1j * (ANGLES + k)), 20.0 + k + np.cos(ANGLES), 0.1 * k + 0.1 * np.sin(ANGLES), k + ANGLES,
        1e-3 * (k - 4) * np.cos(ANGLES), 1e-6 * k, shape(k),
    )  # fmt: skip


def made(**other: Any) -> Findings:
    spectra = (
        FourierSeries.of(0.0, [0.3, 0.0, 0.0, 0.0, 0.0, 0.1], [0.4, 0.2]),
        FourierSeries.of(0.0, [0.5, 0.25, 0.0, 0.0, 0.125, 0.0]),
    )
    common = {
        "tau": TAU, "output": (1 + TAU, 2 + TAU), "acceleration": (100 * np.cos(TAU) - 300, 100 * np.sin(TAU) - 50),
        "spectrum": spectra, "deviation": (Deviation(0.56, 0.02), Deviation(3e-13, 4e-13)), "angles": ANGLES,
        "table": tuple(np.stack([10 * v + k + ANGLES for k in range(4)]) for v in range(2)),
        "lever": tuple(np.stack([100 + 10 * v + k + ANGLES for k in range(4)]) for v in range(2)),
        "contours": ({"cam": contour(0), "counter": contour(1)}, {"cam": contour(2), "counter": contour(3)}),
        "proofs": {
            "cam": Proof(FourierSeries.of(0.0, [0.5, 0, 0, 0, 0, 1e-12]), FourierSeries.of(0.0, [0.5, 0, 0, 0, 0, 5e-7]), ()),
            "counter": Proof(FourierSeries.of(0.0, [0.4, 0, 0, 0, 0, 2e-11]), None, ()),
        },
        "residuals": (Residual("order 2 left out of the correction", 0.5), Residual("off by 1°", 0.02)), "from_errors": 0.004,
        "left_out": (LeftOut(3, 0.75, 0.01, 0.003), LeftOut(6, 0.25, 0.02, 0.004)),
        "samples": (np.array([0.5, 1.5]), np.array([7.0, 8.0])), "notes": ("a note",),
    }  # fmt: skip
    return Findings(**common | other)


@pytest.fixture(scope="module")
def result(plan: Plan) -> xr.Dataset:
    return titled(dataset(plan, made()))


# --- the Dataset ---


def test_motions_of_both_cams(plan: Plan, result: xr.Dataset) -> None:
    assert result.version.values.tolist() == ["original", "corrected"] and result.cam.values.tolist() == list(NAMES)
    assert result.time.values == pytest.approx(TAU / SHAFT.mean)
    a, b, j = SHAFT.speed.cosine, SHAFT.speed.sine, np.arange(1, 6)
    x = np.outer(TAU, j)
    assert result.shaft_speed.values == pytest.approx(SHAFT.mean + np.cos(x) @ a + np.sin(x) @ b)
    assert result.shaft_angle.values == pytest.approx(TAU + (np.sin(x) * a - (np.cos(x) - 1) * b) @ (1 / (j * SHAFT.mean)))
    assert result.output_over_time.values == pytest.approx(np.stack([1 + TAU, 2 + TAU]))
    assert result.acceleration.values == pytest.approx(np.stack([100 * np.cos(TAU) - 300, 100 * np.sin(TAU) - 50]))
    for k, suffix in enumerate(("", "_velocity", "_acceleration", "_jerk")):
        assert result[f"output{suffix}"].values == pytest.approx(np.stack([k + ANGLES, 10 + k + ANGLES]))
        assert result[f"follower{suffix}"].values == pytest.approx(np.stack([100 + k + ANGLES, 110 + k + ANGLES]))
        assert result[f"output{suffix}"].attrs["units"] == "rad" + ("", "/rad", "/rad^2", "/rad^3")[k]


def test_orders_are_times_the_square_of_the_speed(result: xr.Dataset) -> None:
    assert result.order.values.tolist() == list(range(1, 25)), "to the last that is not negligible"
    cosine, sine, amplitude = (result[name].values / W2 for name in ("cosine", "sine", "amplitude"))
    assert cosine[:, :6] == pytest.approx(np.array([[0.3, 0, 0, 0, 0, 0.1], [0.5, 0.25, 0, 0, 0.125, 0]]))
    assert sine[:, :2] == pytest.approx(np.array([[0.4, 0.2], [0.0, 0.0]]))
    assert amplitude[:, :6] == pytest.approx(np.array([[0.5, 0.2, 0, 0, 0, 0.1], [0.5, 0.25, 0, 0, 0.125, 0]]))
    assert np.isnan(amplitude[:, 6:]).all()
    assert result.recovered.values[:, [0, 5]] / W2 == pytest.approx(np.array([[0.5, 1e-12], [0.4, 2e-11]]))
    assert result.rounded.values[0, [0, 5]] / W2 == pytest.approx([0.5, 5e-7]) and np.isnan(result.rounded.values[1]).all()
    s = result.wucht.summary
    assert s["orders_before"] == pytest.approx([W2 * x for x in (0.5, 0.2, 0, 0, 0, 0.1)])
    assert s["orders_after"] == pytest.approx([W2 * x for x in (0.5, 0.25, 0, 0, 0.125, 0)])


def test_orders_of_the_speed_with_their_errors(result: xr.Dataset) -> None:
    assert result.speed_order.values.tolist() == [1, 2, 3, 4, 5]
    assert result.speed_cosine.values.tolist() == SPEED["cosine"] and result.speed_sine.values.tolist() == SPEED["sine"]
    assert result.speed_amplitude.values == pytest.approx(np.hypot(SPEED["cosine"], SPEED["sine"]))
    nan = math.nan
    assert result.speed_cosine_error.values == pytest.approx([nan, 0.1, nan, 0.2, nan], nan_ok=True)
    assert result.speed_sine_error.values == pytest.approx([nan, 0.3, nan, 0.4, nan], nan_ok=True)
    assert result.speed_error.values == pytest.approx([nan, 0.3, nan, 0.4, nan], nan_ok=True), "the greatest in any phase"
    assert result.left_out_order.values.tolist() == [3, 6] and result.left_out_amplitude.values.tolist() == [0.75, 0.25]
    assert result.left_out_error.values.tolist() == [0.01, 0.02]


def test_contours_of_both_cams_and_versions(plan: Plan, result: xr.Dataset) -> None:
    for v in range(2):
        for c in range(2):
            of, k = contour(2 * v + c), 2 * v + c
            expected = {
                "contour_x": of.points.real, "contour_y": of.points.imag, "normal_x": of.normals.real,
                "normal_y": of.normals.imag,
                "curvature": of.curvature, "pressure_angle": of.pressure_angle, "uncut": of.uncut,
            }  # fmt: skip
            for name, values in expected.items():
                assert result[name].values[v, c] == pytest.approx(values), name
            sizes = [float(result[n].values[v, c]) for n in ("least_radius", "hollow_radius", "largest_roller", "base_radius")]
            hollow = math.nan if k == 2 else 0.080 + k / 1000
            assert sizes == pytest.approx([0.010 + k / 1000, hollow, 0.02 + k / 1000, 0.03 + k / 1000], nan_ok=True)
    assert result.moved.values == pytest.approx(1e-3 * np.stack([-2 * np.cos(ANGLES), -np.cos(ANGLES)]))
    assert result.roller_radius.values == pytest.approx([0.010, 0.012])
    assert float(result.common_pressure_angle) == pytest.approx(math.pi / 4)
    centres = result.follower_x.values + 1j * result.follower_y.values
    assert np.abs(centres - 0.12) == pytest.approx(0.07), "on the arms of the lever about its pivot"


def test_the_measured_acceleration(result: xr.Dataset) -> None:
    """About its mean; amplitudes of its orders beside the computed ones."""
    wave = 30 * np.cos(TAU) + 40 * np.sin(TAU) + 20 * np.sin(2 * TAU) + 8 * np.cos(3 * TAU) + 6 * np.sin(3 * TAU)
    assert result.measured_acceleration.values == pytest.approx(wave)
    assert result.measured_amplitude.values[:4] == pytest.approx([50.0, 20.0, 10.0, math.nan], nan_ok=True)
    assert result.computed_amplitude.values[:3] == pytest.approx([50.0, 10.0, math.nan], nan_ok=True)
    assert result.sample_tau.values.tolist() == [0.5, 1.5] and result.sample_acceleration.values.tolist() == [7.0, 8.0]
    m, power = result.wucht.summary["measured"], (2500 + 400 + 100) / 2
    assert m["rms"] == pytest.approx(math.sqrt(power + 100)) and m["noise_rms"] == 10.0
    assert m["explained"] == pytest.approx(0.8 * power / (power + 100)) and m["explained_orders"] == 0.8
    assert (m["cam"], m["turns"], m["orders"], m["zero"]) == ("corrected", 6.5, 3, 0.125)
    assert (m["delay"], m["explained_without_delay"]) == (0.05, 0.95)


def test_the_summary(plan: Plan, result: xr.Dataset) -> None:
    s = result.wucht.summary
    speed = SHAFT.speed(np.linspace(0, 2 * math.pi, 100_001))
    assert (s["unit"], s["harmonics"], s["reference_order"], s["points"], s["decimals"]) == ("rad", 5, 1, 36, 5)
    assert (s["before"], s["after"]) == (0.56, 3e-13)
    assert (s["position_error_before"], s["position_error_after"]) == (0.02, 4e-13)
    assert s["recovered"] == pytest.approx({"cam": 2e-12, "counter": 5e-11}) and s["rounded"] == pytest.approx({"cam": 1e-6})
    assert s["peak_before"] == pytest.approx(400.0) and s["peak_after"] == pytest.approx(150.0), "of either sign"
    assert s["mean_speed"] == pytest.approx(SHAFT.mean) and s["period"] == pytest.approx(2 * math.pi / SHAFT.mean)
    assert (s["min_speed"], s["max_speed"]) == pytest.approx((speed.min(), speed.max()), rel=1e-6)
    assert s["fluctuation"] == pytest.approx((speed.max() - speed.min()) / SHAFT.mean, rel=1e-6)
    assert s["min_curvature_radius"] == pytest.approx(0.012) and s["max_pressure_angle"] == pytest.approx(0.53)
    assert s["undercut"] is False and [r["share"] for r in s["residuals"]] == [0.5, 0.02]
    r = s["record"]
    assert (r["orders"], r["turns"], r["samples"], r["residual_rms"], r["unit"]) == ([2, 4], 7.5, 6000, 0.05, "rad/s")
    assert r["mean_error"] == 0.5 and r["zero"] == 0.25 and r["left_by_errors"] == 0.004
    assert r["left_by_left_out"] == pytest.approx(0.005), "the root of the sum of squares"
    assert r["left_out"][1] == {"order": 6, "amplitude": 0.25, "error": 0.02, "share": 0.004}
    assert r["explained"] == pytest.approx(FIT.explained_share)


def test_sizes_of_each_cam(result: xr.Dataset) -> None:
    for c, name in enumerate(NAMES):
        group = result.wucht.summary["contours"][name]
        for v, version in enumerate(("original", "corrected")):
            k = 2 * v + c
            assert group[version] == pytest.approx({
                "max_pressure_angle": 0.5 + k / 100, "max_pressure_angle_at": 3.0 + k, "largest_roller": 0.02 + k / 1000,
                "min_curvature_radius": 0.010 + k / 1000, "min_hollow_radius": None if k == 2 else 0.080 + k / 1000,
                "largest_wheel": 0.07 + k / 1000,
            })  # fmt: skip
        assert group["moved"] == pytest.approx((2e-3, 1e-3)[c]) and group["chord"] == pytest.approx((2e-6, 3e-6)[c])
        assert group["missing_before"] == pytest.approx((0.0, 0.01 / (2 * math.pi))[c])
        assert group["roller_radius"] == pytest.approx((0.010, 0.012)[c])


def test_without_records_and_cams_there_are_no_numbers(bare: Plan) -> None:
    some = dataset(bare, made(left_out=(), samples=(np.empty(0), np.empty(0))))
    s = some.wucht.summary
    assert (s["record"], s["measured"]) == (None, None) and np.isnan(some.speed_error.values).all()
    assert np.isnan(some.measured_acceleration.values).all() and np.isnan(some.measured_amplitude.values).all()
    law = dataset(replace(bare, before={}, after={}), made(contours=({}, {}), proofs={}))
    s = law.wucht.summary
    assert (s["undercut"], s["min_curvature_radius"], s["max_pressure_angle"], s["contours"]) == (None, None, None, {})
    assert law.contour_x.shape == (2, 0, 36) and law.recovered.shape == (0, 24)


# --- the verdict ---


@pytest.mark.parametrize(("after", "begin"), [
    (9e-13, "CLEAN: orders above 5 are below 1e-12 of order 1 (before: 0.56)"),
    (1.1e-12, "CLEAN: orders above 5 are 1.1e-12 of order 1 (before: 0.56)"),
    (9e-10, "CLEAN: orders above 5 are 9e-10 of order 1"), (1.1e-9, "NOT CLEAN: orders above 5 are 1.1e-09 of order 1"),
])  # fmt: skip
def test_what_is_clean(bare: Plan, after: float, begin: str) -> None:
    before, stroke = Deviation(0.56, 0.02), bare.purity.stroke
    assert sentence(bare, made(deviation=(before, Deviation(after, 0.9e-9 * stroke)))).startswith(begin)
    assert sentence(bare, made(deviation=(before, Deviation(after, 1.1e-9 * stroke)))).startswith("NOT CLEAN"), "over time"


def test_what_points_and_orders_that_are_left_out_leave(bare: Plan) -> None:
    exact = sentence(bare, made(left_out=(LeftOut(3, 1.0, 0.1, 0.006), LeftOut(6, 1.0, 0.1, 0.0079))))
    assert exact.endswith("; from 36 points of the contour 5e-11"), "the worse of both cams"
    coarse = {"cam": Proof(FourierSeries.of(0.0, [0.5, 0, 0, 0, 0, 1e-9]), None, ()), "counter": Proof(None, None, ("no",))}
    said = sentence(bare, made(proofs=coarse, left_out=(LeftOut(3, 1.0, 0.1, 0.006), LeftOut(6, 1.0, 0.1, 0.0081))))
    assert said.endswith(
        "; from 36 points of the contour 2e-09, which more points reduce; but orders of the record that are not corrected "
        "leave about 0.01"
    )
    assert "points" not in sentence(bare, made(proofs={"cam": Proof(None, None, ())}, left_out=()))
    endless = replace(bare, purity=replace(bare.purity, count=None, reference=2))
    text = sentence(endless, made(proofs={}, left_out=()))
    assert text == "CLEAN: orders differ from the law's by less than 1e-12 of order 2 (before: 0.56)"


# --- the report ---


def test_the_lines_of_the_report(result: xr.Dataset) -> None:
    s, d = result.wucht.summary, math.degrees
    rpm = 30 / math.pi
    told = report(result)[2:]
    explained, share = f"{100 * FIT.explained_share:.2f} %", f"{100 * 0.8 * 1500 / 1600:.1f} %"
    three, six = (f"{_rounded(100 * x / SHAFT.mean)} %" for x in (0.75, 0.25))
    assert told[0].endswith(f"a turn in 120 ms; it fluctuates by {100 * s['fluctuation']:.2f} % in orders 2, 3, 4, 5")
    assert told[1].startswith(
        f"  record       7.5 turns, 6000 samples, orders explain {explained}, {0.05 * rpm:.3g} rpm rms left"
    )
    assert told[1].endswith("; the noise leaves about 0.4 %, the orders left out about 0.5 %")
    assert told[2].startswith(f"  left out     order 3 ({0.75 * rpm:.3g} rpm, {three} of the speed), which leaves 0.3 %; ")
    assert told[2].endswith(f"; order 6 ({0.25 * rpm:.3g} rpm, {six} of the speed), which leaves 0.4 %")
    assert told[3:7] == [
        "  acceleration at most 150 rad/s^2; of the original cam 400 rad/s^2; off the law over time by at most 0°; "
        "with the original cam by 1.146°",
        "  from points  cam 2e-12, counter 5e-11 of order 1; rounded to 5 decimals of a mm 1e-06",
        "  left if          2 %  off by 1°",
        "  left if      an order of the speed is left out: 50 % (2)",
    ]
    least = ", least radius of curvature 12 mm (10 mm)"
    assert told[7] == f"  cam          pressure angle at most {d(0.52):.3g}° at {d(5):.4g}° (original {d(0.5):.3g}°){least}"
    assert told[8] == "               moved by 2 mm at most, not undercut, largest roller 22 mm, largest grinding wheel 72 mm"
    assert told[9].startswith(f"  counter cam  pressure angle at most {d(0.53):.3g}° at {d(6):.4g}° (original {d(0.51):.3g}°)")
    assert told[11].startswith(
        f"  measured     6.5 turns: {share} explained by the computed motion of the corrected cam (80.0 % of"
    )
    assert told[11].endswith("(80.0 % of its 3 orders; 10 of 40 rad/s^2 rms lie outside these)")
    late = f"it comes {d(0.05):.3g}° ({50 / SHAFT.mean:.3g} ms) later than computed"
    assert told[12].endswith(f"{late}; without it 95.0 % of its orders would be explained")


@pytest.mark.parametrize(("share", "printed"), [(0.9e-9, "0°"), (1.1e-9, f"{math.degrees(1.1e-9 * np.ptp(ANGLES)):.4g}°")])
def test_a_distance_that_is_rounding_is_none(plan: Plan, share: float, printed: str) -> None:
    """Below 1e-9 of the stroke, which here is that of the angles."""
    off = Deviation(3e-13, share * float(np.ptp(ANGLES)))
    lines = report(titled(dataset(plan, made(deviation=(Deviation(0.56, 0.02), off)))))
    (line,) = (line for line in lines if line.startswith("  acceleration "))
    assert line.endswith(f"off the law over time by at most {printed}; with the original cam by 1.146°")


def _rounded(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


# --- parts of the run ---


def test_a_displacement_is_positive_outside() -> None:
    circle = lambda phi, order=0: np.exp(1j * np.asarray(phi)) * (1j) ** order  # noqa: E731
    normals = np.exp(1j * ANGLES)
    for by in (0.02, -0.03):
        assert running._displacement(circle, (1 + by) * normals, normals) == pytest.approx(np.full(36, by), abs=1e-9)


def test_the_residual_of_errors_is_the_root_of_squares(plan: Plan, bare: Plan) -> None:
    """That of an order times its error over its amplitude: 0.5 times 0.3/5 and 0.2 times 0.4/1."""
    given = (Residual("order 2 left out", 0.5), Residual("order 4 left out", 0.2), Residual("off by 1°", 9.0))
    assert running._residual_of_errors(plan, given) == pytest.approx(math.hypot(0.5 * 0.3 / 5, 0.2 * 0.4))
    assert running._residual_of_errors(plan, given[:1]) == pytest.approx(0.5 * 0.3 / 5)
    assert running._residual_of_errors(bare, given) is None


def test_which_orders_of_a_record_are_examined(monkeypatch: pytest.MonkeyPatch, bare: Plan) -> None:
    """Six of the largest, if above three standard errors; those that leave a ten-thousandth or less do not matter."""
    orders = tuple(
        OmittedOrder(k, 0.1 * k, 0.0333 * k if k == 10 else 0.0334 * k if k == 11 else 0.01, 0.0) for k in range(3, 12)
    )
    asked: list[int] = []

    def share(law: Any, count: Any, shaft: Any, order: int, amplitude: float) -> float:
        asked.append(order)
        return 1e-4 if order == 8 else 1.1e-4

    monkeypatch.setattr(running, "residual_of_extra_order", share)
    found = running._left_out(replace(bare, fit=replace(FIT, omitted_orders=orders)))
    assert asked == [10, 9, 8, 7, 6, 5] and [one.order for one in found] == [10, 9, 7, 6, 5]
    assert found[0] == LeftOut(10, 1.0, pytest.approx(0.333), 1.1e-4)


def test_notes_on_contours(bare: Plan) -> None:
    cams = {"cam": contour(1), "counter": contour(3)}
    tight = replace(bare, spec=bare.spec.model_copy(update={"chord_tolerance": 2.9e-6}))
    cut, chords = running._notes(tight, {"cam": contour(0), "counter": contour(50)}, cams)
    share = 0.5 / (2 * math.pi)
    assert cut == f"The follower cuts {100 * share:.1f} % of the original contour (counter) away; the corrected one is intact."
    assert chords.startswith(
        "Chords between 36 points leave the contour by 3 um, more than the tolerance of 2.9 um: take points = 37"
    )
    loose = replace(bare, spec=bare.spec.model_copy(update={"chord_tolerance": 3e-6}))
    assert running._notes(loose, {"cam": contour(0)}, cams) == [] == running._notes(loose, {}, {})


def test_a_delay_counts_where_it_explains_more_and_most(bare: Plan) -> None:
    def record(share: float, best: float, noise: float = 0.0) -> Any:
        comparison = SimpleNamespace(share=share, best_delay=(0.1, best), measured_orders=FourierSeries.of(0.0, [2.0]))
        return SimpleNamespace(comparison=comparison, noise=noise)

    assert preparing._delay(record(0.6, 0.606)) == (0.1, 0.606) and preparing._delay(record(0.6, 0.604)) is None
    assert preparing._delay(record(0.2, 0.49)) is None and preparing._delay(record(0.2, 0.51)) == (0.1, 0.51)
    assert preparing._delay(record(0.2, 0.9, noise=math.sqrt(2))) is None, "of the whole record only 45 %"


@pytest.mark.parametrize(("by", "words"), [(0.05, "later"), (-0.05, "earlier")])
def test_what_removes_a_delay(by: float, words: str) -> None:
    record: Any = SimpleNamespace(cam="original")
    (note,) = preparing._delay_notes(record, (by, 0.95), 50.0, 0.2)
    assert note.startswith(
        f"The measured acceleration comes 2.86° (1 ms) {words} than that computed for the original cam; without "
    )
    assert note.endswith(f'study.acceleration.zero = "{0.2 + by / 50:.6g} s" removes it.')
    assert preparing._delay_notes(record, None, 50.0, 0.2) == []


@pytest.mark.parametrize(("share", "ratio", "begins"), [
    (0.5, 1.0, []), (0.49, 1.0, ["The motion computed for the original cam explains 49 %"]),
    (-0.2, 1.0, ["The motion computed for the original cam explains 0 %"]),
    (0.9, 1.0009, []), (0.9, 0.9989, ["The measured acceleration repeats at 0.9989 times"]),
])  # fmt: skip
def test_notes_on_a_measured_acceleration(share: float, ratio: float, begins: list[str]) -> None:
    comparison: Any = SimpleNamespace(share=share)
    notes = preparing._notes(comparison, "original", ratio)
    assert len(notes) == len(begins) and all(n.startswith(b) for n, b in zip(notes, begins, strict=True))


def test_orders_that_a_record_holds_are_warned_of_where_they_are_significant_and_matter() -> None:
    """Above three standard errors, and above a thousandth of the mean speed of 50 rad/s; of 1 and 2 the fit itself warns."""
    omitted = [(1, 9.0, 0.1), (3, 0.06, 0.019), (4, 0.06, 0.021), (5, 0.04, 0.001), (6, 0.5, 0.01)]
    drive: Any = SimpleNamespace(speed=SimpleNamespace(pulses_per_turn=None, index="mark"))
    fit: Any = SimpleNamespace(
        warnings=("a doubt",), unit="rad/s", origin=0.0, speed=SimpleNamespace(mean=50.0),
        notable=lambda: [OmittedOrder(*one, 0.0) for one in omitted],
    )  # fmt: skip
    assert preparing._record_notes(drive, fit) == (
        "a doubt",
        "Order 3 is left out, but the record holds 0.12 % of the speed in it.",
        "Order 6 is left out, but the record holds 1.00 % of the speed in it.",
    )


def test_the_contour_of_a_groove_is_hollow_outside_and_bulges_inside(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a cam that hardly moves its rod: circles, a roller's radius inside and outside of the distance."""
    monkeypatch.setattr(running, "shapes", lambda cams, allow_undercut: dict.fromkeys(cams))
    law = {"kind": "harmonic", "coefficients": {"cosine": ["1 um"]}}
    rod = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm", "groove": True}
    groove = prepare(CamCorrection(points=36), cam_drive_from({"law": law, "follower": rod, "speed": SPEED}, "Groove", None))
    for name, radius, material in (("cam", 0.048, 1), ("outer", 0.072, -1)):
        flank = running._contour(groove, name, groove.before[name], ANGLES)
        assert np.abs(flank.points) == pytest.approx(np.full(36, radius), rel=1e-4)
        assert flank.curvature == pytest.approx(np.full(36, material / radius), rel=1e-2)
        assert (flank.normals.conj() * flank.points).real == pytest.approx(np.full(36, radius), rel=1e-3), "outwards"


def test_points_are_rounded_to_decimals_of_a_millimetre(bare: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 0.0123456789 m, 12.3456789 mm, in either coordinate."""
    monkeypatch.setattr(running, "_recovered_acceleration", lambda plan, cam, points: points)
    exact = np.array([0.0123456789 - 0.0987654321j, 0.0])
    for decimals, rounded in ((5, 0.01234568 - 0.09876543j), (3, 0.012346 - 0.098765j), (0, 0.012 - 0.099j)):
        plan = replace(bare, spec=bare.spec.model_copy(update={"decimals": decimals}))
        proof: Any = running._proof(plan, "cam", exact)
        assert proof.recovered is exact and proof.rounded == pytest.approx(np.array([rounded, 0.0]), abs=1e-14)


def test_positions_in_the_dwell_of_both_cams() -> None:
    turning: dict[str, Any] = {
        "unit": "rad", "dwell_error_before": 0.02, "dwell_error_after": 0.001, "dwell_travel_before": 1.4e-3,
        "dwell_travel_after": 7e-5,
    }  # fmt: skip
    assert _position_error_text(turning, "before") == f"{math.degrees(0.02):.4g}° (1.4 mm)"
    assert _position_error_text(turning, "after", " at the end") == f"{math.degrees(0.001):.4g}° (0.07 mm at the end)"
    assert _position_error_text(turning | {"dwell_travel_before": None}, "before") == f"{math.degrees(0.02):.4g}°"
    sliding = turning | {"unit": "m", "dwell_error_before": 2e-3}
    assert _position_error_text(sliding, "before") == "2 mm"


# --- the figure ---


def test_the_lines_of_the_figure(result: xr.Dataset, axes: list[Any]) -> None:
    history, spectrum, speed, orders, contours, moved, pressure, radius, measured, beside = axes
    ms = 1e3 * TAU / SHAFT.mean
    for k, line in enumerate(history.get_lines()[:2]):
        assert line.get_xdata() == pytest.approx(ms) and line.get_ydata() == pytest.approx(result.acceleration.values[k])
    dots = next(x for x in spectrum.get_lines() if str(x.get_label()) == "corrected, from its points")
    assert dots.get_ydata()[:6] == pytest.approx(W2 * np.array([0.5, *[5e-7] * 5])), "the larger of both cams"
    assert speed.get_lines()[0].get_ydata() == pytest.approx(30 / math.pi * result.shaft_speed.values)
    bars = [(b.get_x() + b.get_width() / 2, b.get_height()) for b in orders.patches]
    assert bars[:5] == [pytest.approx((k + 1, a)) for k, a in enumerate(result.speed_amplitude.values)]
    assert bars[5:] == [pytest.approx((3.0, 0.75)), pytest.approx((6.0, 0.25))]
    shown = [x for x in contours.get_lines() if len(x.get_xdata()) == 37]
    assert [x.get_xdata()[0] for x in shown] == pytest.approx([40.0, 60.0, 50.0, 70.0]), "original and corrected, cam by cam"
    for line, row in zip(moved.get_lines()[1:], result.moved.values, strict=True):
        assert line.get_xdata() == pytest.approx(np.degrees(ANGLES)) and line.get_ydata() == pytest.approx(1e3 * row)
    for axis, values in ((pressure, np.degrees(result.pressure_angle.values)), (radius, 1e3 / result.curvature.values)):
        for line, (c, v) in zip(axis.get_lines(), ((0, 0), (0, 1), (1, 0), (1, 1)), strict=False):
            assert line.get_ydata() == pytest.approx(values[v, c]) and line.get_xdata() == pytest.approx(np.degrees(ANGLES))
    limits = [x.get_ydata()[0] for x in pressure.get_lines() if x.get_linestyle() == ":"]
    assert limits == pytest.approx([45.0, -45.0])
    computed = next(x for x in measured.get_lines() if x.get_linewidth() == 2.6)
    assert computed.get_ydata() == pytest.approx(result.acceleration.values[1]), "of the cam that was measured"
    samples = measured.get_lines()[0]
    assert samples.get_xdata() == pytest.approx(np.array([0.5, 1.5]) / SHAFT.mean * 1e3)
    tops = [(b.get_x() + b.get_width() / 2, b.get_y() + b.get_height()) for b in beside.patches if np.isfinite(b.get_height())]
    assert tops[:2] == [pytest.approx((k - 0.2, a)) for k, a in ((1, 50.0), (2, 10.0))], "computed"
    assert tops[2:] == [pytest.approx((k + 0.2, a)) for k, a in ((1, 50.0), (2, 20.0), (3, 10.0))], "measured"


@pytest.fixture(scope="module")
def axes(result: xr.Dataset) -> list[Any]:
    return list(drawn("cam-correction", result).axes)


def panel(draw: Any, result: xr.Dataset) -> Any:
    """One panel alone."""
    axis = Figure().subplots()
    draw(axis, result)
    return axis


def named(axis: Any) -> dict[str, Any]:
    return {str(line.get_label()): line for line in axis.get_lines()}


def test_the_versions_of_each_cam_have_its_colour_and_the_original_is_dashed(axes: list[Any]) -> None:
    looks = [("original", COLOURS[1]), ("corrected", COLOURS[0])]
    assert [(line.get_label(), line.get_color()) for line in axes[0].get_lines()] == [(f"{v} cam", c) for v, c in looks]
    cams = [COLOURS[1], COLOURS[0], COLOURS[2], COLOURS[2]]
    contours = [line for line in axes[4].get_lines() if len(line.get_xdata()) == 37]
    for lines in (contours, axes[6].get_lines()[:4], axes[7].get_lines()[:4]):
        assert [line.get_color() for line in lines] == cams
        assert [line.get_linestyle() for line in lines] == ["--", "-"] * 2
    assert [line.get_color() for line in axes[5].get_lines()[1:]] == [COLOURS[0], COLOURS[2]]


def test_measured_orders_have_the_colours_of_the_lines_over_time(result: xr.Dataset) -> None:
    """Left of each order the computed bar, of the corrected cam; right of it the measured one."""
    bars = panel(figure_module._measured_orders, result).patches
    colours = {(b.get_x() + b.get_width() / 2 > round(b.get_x() + b.get_width() / 2), to_hex(b.get_facecolor())) for b in bars}
    assert colours == {(False, to_hex(COLOURS[0])), (True, to_hex(COLOURS[6]))}
    lines = {line.get_linewidth(): line.get_color() for line in panel(figure_module._measured_history, result).get_lines()}
    assert (lines[2.6], lines[0.9]) == (COLOURS[0], COLOURS[6])


def test_the_rollers_and_the_base_circle_are_those_of_the_corrected_cam(result: xr.Dataset, axes: list[Any]) -> None:
    contours = axes[4]

    def circle(line: Any) -> tuple[float, float, float]:
        x, y = line.get_data()
        return (max(x) + min(x)) / 2, (max(y) + min(y)) / 2, (max(x) - min(x)) / 2

    circles = [circle(line) for line in contours.get_lines() if len(line.get_xdata()) == 181]
    base = 1e3 * float(result.base_radius[1, 0])
    rollers = [(1e3 * float(result.follower_x[k]), 1e3 * float(result.follower_y[k]), r) for k, r in enumerate((10.0, 12.0))]
    for actual, expected in zip(circles, ((0.0, 0.0, base), *rollers), strict=True):
        assert actual == pytest.approx(expected, rel=1e-3, abs=1e-2)


def test_a_flat_face_is_drawn_over_the_height_of_the_contour(result: xr.Dataset) -> None:
    flat = result.copy(deep=True)
    flat.roller_radius.values[:] = np.nan
    faces = [line for line in panel(figure_module._contour, flat).get_lines() if line.get_label() == "face"]
    for face, x, radius in zip(faces, flat.follower_x.values, (60.0, 70.0), strict=True):
        assert list(face.get_xdata()) == pytest.approx([1e3 * x] * 2)
        assert list(face.get_ydata()) == pytest.approx([-radius, radius], rel=0.01), "of the corrected contour"
    axes = Figure().subplots(4)
    figure_module._draw_contours(list(axes), flat)
    for k, line in enumerate(axes[2].get_lines()[:2]):
        assert line.get_ydata() == pytest.approx(np.degrees(flat.output.values[k]))
        assert line.get_xdata() == pytest.approx(np.degrees(ANGLES))
    assert axes[2].get_ylabel() == "motion in the cam (°)"


def test_the_orders_of_both_versions_stand_side_by_side_above_a_floor(axes: list[Any]) -> None:
    """A millionth of order 1 of the corrected cam, 0.5; up to one order beyond the last above it."""
    spectrum = axes[1]
    floor = 0.5e-6 * W2
    bars = [
        (b.get_x() + b.get_width() / 2, b.get_y(), b.get_y() + b.get_height(), to_hex(b.get_facecolor()))
        for b in spectrum.patches
    ]
    known = [bar for bar in bars if np.isfinite(bar[2])]
    amplitudes = [0.5, 0.2, 5e-7, 5e-7, 5e-7, 0.1], [0.5, 0.25, 5e-7, 5e-7, 0.125, 5e-7]
    for k, (side, colour) in enumerate(((-0.2, COLOURS[1]), (0.2, COLOURS[0]))):
        mine = [bar for bar in known if (bar[0] % 1 > 0.5) == (side < 0)]
        assert [bar[0] for bar in mine] == pytest.approx([j + side for j in range(1, 7)])
        assert [bar[2] / W2 for bar in mine] == pytest.approx(amplitudes[k])
        assert {bar[3] for bar in mine} == {to_hex(colour)} and [bar[1] for bar in mine] == pytest.approx([floor / 2] * 6)
    line = next(x for x in spectrum.get_lines() if x.get_linestyle() == "-.")
    assert line.get_ydata()[0] == pytest.approx(floor) and line.get_label() == "10⁻⁶ of order 1, or less"
    assert spectrum.get_ylim() == pytest.approx((floor / 2, 1.5 * W2)) and spectrum.get_xlim() == (0.3, 7.7)
    ticks = spectrum.get_yticks()
    assert ticks[1] / ticks[0] == pytest.approx(1e3) and floor <= ticks[0] < 10 * floor
    assert spectrum.get_xticks().tolist() == list(range(1, 8))


def test_orders_of_the_speed_have_their_errors_and_the_mean_its_line(result: xr.Dataset, axes: list[Any]) -> None:
    _, _, speed, orders, *_ = axes
    assert named(speed)["mean speed"].get_ydata()[0] == pytest.approx(30 / math.pi * SHAFT.mean)
    assert speed.get_lines()[0].get_xdata() == pytest.approx(1e3 * TAU / SHAFT.mean)
    assert speed.get_xlim() == pytest.approx((0.0, 2e3 * math.pi / SHAFT.mean))
    (segments,) = [c.get_segments() for c in orders.collections]
    spans = {round(float(s[0, 0])): float(s[1, 1] - s[0, 1]) / 2 for s in segments if len(s) and np.isfinite(s).all()}
    assert spans == pytest.approx({2: float(result.speed_error[1]), 4: float(result.speed_error[3])})
    assert orders.get_xlim() == (0.3, 6.7) and orders.get_xticks().tolist() == [1, 2, 3, 4, 5, 6]


def test_few_and_many_orders_have_ticks_that_can_be_read() -> None:
    for count, ticks in ((3, [1, 2, 3]), (15, [*range(1, 16)]), (16, [*range(2, 17, 2)]), (31, [*range(3, 31, 3)])):
        axis = Figure().subplots()
        figure_module._order_axis(axis, count)
        assert axis.get_xticks().tolist() == ticks, count


def test_displacements_of_less_than_a_tenth_of_a_millimetre_are_in_micrometres(result: xr.Dataset) -> None:
    largest = float(np.abs(result.moved.values).max())
    for size, unit, scale in ((1e-4, "mm", 1e3), (0.99e-4, "µm", 1e6)):
        made = result.assign(moved=result.moved * (size / largest))
        made.moved.attrs.update(result.moved.attrs)
        axis = panel(figure_module._displacement, made)
        assert axis.get_ylabel() == f"moved outwards ({unit})"
        assert np.abs(axis.get_lines()[1].get_ydata()).max() <= size * scale * 1.0001
        assert max(np.abs(line.get_ydata()).max() for line in axis.get_lines()[1:]) == pytest.approx(size * scale)


def test_hollow_stretches_are_named(result: xr.Dataset) -> None:
    assert [t.get_text() for t in panel(figure_module._curvature_radius, result).texts] == []
    hollow = result.copy(deep=True)
    hollow.curvature.values[1, 0, 3] *= -1
    assert [t.get_text() for t in panel(figure_module._curvature_radius, hollow).texts] == ["hollow"]


@pytest.mark.parametrize(
    ("least", "floor"),
    [(1.0, 0.5), (1e-9, 1e-3), (99.0, 1.0), (4e-3, 2e-3)],
)
def test_the_scale_of_measured_orders_begins_below_the_least_one_within_limits(
    result: xr.Dataset, least: float, floor: float
) -> None:
    """Half of the least, but a hundred thousandth to a hundredth of the largest, 100."""
    made = result.copy(deep=True)
    made.measured_amplitude.values[:3], made.computed_amplitude.values[:2] = (100.0, 99.0, least), 100.0
    axis = panel(figure_module._measured_orders, made)
    assert axis.get_ylim() == pytest.approx((floor / 2, 300.0))
    ticks = axis.get_yticks()
    assert ticks[1] / ticks[0] == pytest.approx(10.0) and 1.0 <= ticks[0] / floor * 1.0001 < 10.1


def test_a_law_alone_has_its_motion_and_acceleration_in_degrees(bare: Plan) -> None:
    alone = cam_drive_from({"law": LAW_TABLE, "speed": SPEED}, "One", None)
    law = titled(dataset(prepare(CamCorrection(points=36), alone), made(contours=({}, {}), proofs={})))
    motion, acceleration = drawn("cam-correction", law).axes[4:6]
    for axis, name in ((motion, "output"), (acceleration, "output_acceleration")):
        for k, line in enumerate(axis.get_lines()):
            assert line.get_ydata() == pytest.approx(np.degrees(law[name].values[k]))
    assert " ".join(acceleration.get_ylabel().split()) == "acceleration in the cam (°/rad²)"
