"""Comparisons of both models that are made by hand: each number at its value, the curves over the angle, the figure."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import drawn, five_functions, titled

from wucht.dynamics.run_ups.deviations import ComparedMotion
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.studies.approximation import computation
from wucht.studies.approximation.computation import CURVE, Errors, Findings, ModelComparison, compare_models
from wucht.studies.approximation.dataset import dataset
from wucht.studies.approximation.spec import Approximation

STUDY = five_functions("approximation")
MEASURED = Errors(np.array([1.0, 0.5, 0.25, 0.125]), np.array([0.8, 0.3, 0.1, 0.025]), 1.5)
ENDS = (("captured", "captured"), ("captured", "passed"), ("unidentified", "passed"))


@pytest.fixture(scope="module")
def machine() -> Any:
    return load_machine("drozdetskaya-2020/r2")


@pytest.fixture(scope="module")
def plan(machine: Any) -> Any:
    asked = {"along": "drive.slope", "values": ["0.01 N m s", "0.02 N m s", "0.5 N m s"], "until_phi": 50.0}
    return STUDY.prepare(Approximation.from_table({"kind": "approximation"} | asked), machine)


def compared(k: int, value: float) -> ModelComparison:
    """The k-th, whose numbers are unlike those of others."""
    curves = np.stack([1e-3 * (k + 1) * np.linspace(1.0, 2.0, CURVE), 1e-6 * (k + 1) * np.linspace(2.0, 1.0, CURVE)])
    largest, relative = (1.0 + k, 1e-3 * (2.0 + k)), (0.01 + k / 100, 0.1 + k / 100)
    return ModelComparison(value, *ENDS[k % 3], largest, relative, curves)


@pytest.fixture(scope="module")
def result(plan: Any) -> xr.Dataset:
    comparisons = tuple(compared(k, value) for k, value in enumerate(plan.values))
    return titled(dataset(plan, Findings(comparisons, MEASURED)))


# --- the Dataset ---


def test_the_machine_itself_comes_last(result: xr.Dataset) -> None:
    k = np.array([1, 2, 3, 0])
    assert result.value.values == pytest.approx([0.01, 0.02, 0.5, math.nan], nan_ok=True)
    assert result.speed_deviation.values == pytest.approx(1.0 + k)
    assert result.amplitude_deviation.values == pytest.approx(1e-3 * (2.0 + k))
    assert result.relative_speed_deviation.values == pytest.approx(0.01 + k / 100)
    assert result.relative_amplitude_deviation.values == pytest.approx(0.1 + k / 100)
    assert result.outcome.values.tolist() == [ENDS[i % 3][0] for i in k]
    assert result.slow_outcome.values.tolist() == [ENDS[i % 3][1] for i in k]
    assert result.same_outcome.values.tolist() == [0, -1, 1, 1]
    assert result.speed_over_angle.values[:, -1] == pytest.approx(2e-3 * (k + 1))
    assert result.amplitude_over_angle.values[:, 0] == pytest.approx(2e-6 * (k + 1))
    assert result.angle.values == pytest.approx(np.linspace(0.0, 50.0, CURVE))
    assert result.factor.values.tolist() == [1.0, 0.5, 0.25, 0.125] and result.error.values.tolist() == [0.8, 0.3, 0.1, 0.025]


def test_the_summary(result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert s["own"] == {
        "speed": 1.0, "amplitude": 2e-3, "same_outcome": True, "outcome": "captured", "slow_outcome": "captured",
    }  # fmt: skip
    assert [d["drive.slope"] for d in s["deviations"]] == [0.01, 0.02, 0.5]
    assert [d["speed"] for d in s["deviations"]] == [2.0, 3.0, 4.0]
    assert [d["amplitude"] for d in s["deviations"]] == pytest.approx([3e-3, 4e-3, 5e-3])
    assert [d["same_outcome"] for d in s["deviations"]] == [False, None, True] and s["disagreement"] == [[0.01, 0.01]]
    assert s["sentence"].endswith("; the outcomes differ at slope of the torque-speed curve, drive = 0.01 N m s")
    assert s["errors"] == {"1.0": 0.8, "0.5": 0.3, "0.25": 0.1, "0.125": 0.025}
    assert s["order_of_error"] == pytest.approx(2.0) and s["nominal_order"] == 1.5  # a quarter at half of epsilon
    assert (s["along"], s["along_unit"], s["amplitude_unit"], s["until_phi"]) == ("drive.slope", "N m s", "m", 50.0)
    units = {name: result[name].attrs["units"] for name in ("value", "speed_over_angle", "amplitude_over_angle", "error")}
    assert units == {"value": "N m s", "speed_over_angle": "rad/s", "amplitude_over_angle": "m", "error": "rad/s"}


# --- a comparison of two runs ---


def both(monkeypatch: pytest.MonkeyPatch, plan: Any, *motions: ComparedMotion, failures: tuple[str, ...] = ("", "")) -> Any:
    runs = tuple(
        SimpleNamespace(
            compared=motion, trajectory=SimpleNamespace(failure=why), verdict=SimpleNamespace(outcome=f"outcome {k}")
        )
        for k, (motion, why) in enumerate(zip(motions, failures, strict=False))
    )
    monkeypatch.setattr(computation, "run_up", lambda case, work: iter([(), runs]))
    monkeypatch.setattr(computation, "compared_motion", lambda motion: motion.compared)
    return compare_models(plan, 2, Work())


def test_shares_are_of_the_largest_of_the_full_run_up_to_the_angle(monkeypatch: pytest.MonkeyPatch, plan: Any) -> None:
    """From 3 rad on, two bodies of which one turns clockwise and is the faster one; what comes after 50 rad does not count."""
    angle = 3.0 + np.linspace(0.0, 80.0, 801)
    late = angle > 53.0 + 1e-9
    speeds = np.stack([np.full(801, 2.0), np.where(late, -100.0, -8.0)])
    full = ComparedMotion(angle, speeds, np.where(late, 9.0, 0.5))
    slow = ComparedMotion(angle, speeds + np.array([[0.25], [-1.0]]), full.radius - np.where(late, 3.0, 0.125))
    made = both(monkeypatch, plan, full, slow)
    assert made.value == plan.values[2] and (made.outcome, made.slow_outcome) == ("outcome 0", "outcome 1")
    assert made.largest == pytest.approx((1.0, 0.125)) and made.relative == pytest.approx((0.125, 0.25))
    assert made.curves == pytest.approx(np.stack([np.ones(CURVE), np.full(CURVE, 0.125)])), "as sizes"


def test_a_run_that_ends_before_the_angle_has_no_curve_there(monkeypatch: pytest.MonkeyPatch, plan: Any) -> None:
    angle = np.linspace(0.0, 25.0, 501)
    full = ComparedMotion(angle, np.full((1, 501), 4.0), np.zeros(501))
    made = both(
        monkeypatch, plan, full, ComparedMotion(angle, np.full((1, 501), 3.0), np.zeros(501)), failures=("it burst", "")
    )
    assert np.isfinite(made.curves[0]).sum() == CURVE // 2 and made.failure == "it burst"
    assert made.relative == (0.25, 0.0), "nothing of nothing is nothing"
    made = both(monkeypatch, plan, full, ComparedMotion(angle, np.full((1, 501), 3.0), np.ones(501)), failures=("a", "b"))
    assert made.failure == "a; b" and math.isnan(made.relative[1])


def test_a_run_that_fails_at_once_has_nothing_to_compare(monkeypatch: pytest.MonkeyPatch, plan: Any) -> None:
    angle = np.linspace(0.0, 25.0, 501)
    full = ComparedMotion(angle, np.full((1, 501), 4.0), np.zeros(501))
    made = both(monkeypatch, plan, full, failures=("it burst",))
    assert (made.outcome, made.slow_outcome, made.failure, made.same_outcome) == ("outcome 0", "failed", "it burst", False)
    assert np.isnan([*made.largest, *made.relative]).all() and np.isnan(made.curves).all()
    apart = ComparedMotion(angle[:1], np.full((1, 1), 4.0), np.zeros(1))
    assert np.isnan(both(monkeypatch, plan, apart, apart).largest).all()


# --- the figure ---


def shown(result: xr.Dataset) -> Figure:
    return drawn("approximation", result)


def test_each_line_of_the_figure(result: xr.Dataset) -> None:
    speed, amplitude, along, order = shown(result).axes
    names = ["0.01 N m s", "0.02 N m s", "0.5 N m s", "nominal"]
    for axis, of, scale in ((speed, result.speed_over_angle, 1.0), (amplitude, result.amplitude_over_angle, 1e3)):
        lines = axis.get_lines()
        assert [str(x.get_label()) for x in lines[:4]] == names
        for line, values in zip(lines, of.values, strict=False):
            assert line.get_xdata() == pytest.approx(result.angle.values)
            assert line.get_ydata() == pytest.approx(scale * values)
        assert axis.get_ylim() == pytest.approx((scale * of.values.min() / 2, 2 * scale * of.values.max()))
    assert speed.get_lines()[4].get_ydata()[0] == pytest.approx(0.05 * 1.0 / 0.01)
    assert amplitude.get_lines()[4].get_ydata()[0] == pytest.approx(1e3 * 0.25 * 2e-3 / 0.1)
    points = {str(x.get_label()): x for x in along.get_lines()}
    assert along.get_lines()[0].get_xdata() == pytest.approx([0.01, 0.02, 0.5])
    assert along.get_lines()[0].get_ydata() == pytest.approx([2.0, 3.0, 4.0])
    for name, at, value in (("outcomes differ", 0.01, 2.0), ("no outcome yet", 0.02, 3.0), ("same outcome", 0.5, 4.0)):
        assert (list(points[name].get_xdata()), list(points[name].get_ydata())) == ([at], [value])
    assert points["5 % of the largest speed"].get_ydata() == pytest.approx([0.05 * 2 / 0.02, 0.05 * 3 / 0.03, 0.05 * 4 / 0.04])
    assert (along.get_xscale(), along.get_yscale()) == ("log", "log")
    assert along.get_xlabel().replace("\N{NO-BREAK SPACE}", " ").endswith("(N·m·s)")
    assert along.get_ylabel() == "largest difference of speeds (rad/s)"
    measured, nominal = order.get_lines()
    assert str(measured.get_label()) == "measured: order 2.00" and str(nominal.get_label()) == "order 1.5"
    assert measured.get_ydata() == pytest.approx([0.8, 0.3, 0.1, 0.025])
    assert nominal.get_ydata() == pytest.approx(0.025 * np.array([8.0, 4.0, 2.0, 1.0]) ** 1.5), "through the smallest"
    assert [t.get_text() for t in order.get_xticklabels()] == ["1", "0.5", "0.25", "0.125"]


def test_a_deviation_far_below_the_largest_is_cut(plan: Any) -> None:
    curves = np.stack([np.geomspace(1e-9, 1.0, CURVE), np.zeros(CURVE)])
    own = ModelComparison(math.nan, "captured", "captured", (1.0, 0.0), (0.01, 0.0), curves)
    speed, amplitude, *_ = shown(titled(dataset(plan, Findings((own,), MEASURED)))).axes
    assert speed.get_ylim() == pytest.approx((1e-6, 2.0)) and amplitude.get_yscale() == "linear"


def test_only_some_values_are_named(machine: Any) -> None:
    asked = {"along": "drive.slope", "range": ["0.01 N m s", "0.012 N m s"], "points": 12}
    plan = STUDY.prepare(Approximation.from_table({"kind": "approximation"} | asked), machine)
    comparisons = tuple(compared(k, value) for k, value in enumerate(plan.values))
    speed = shown(titled(dataset(plan, Findings(comparisons, MEASURED)))).axes[0]
    named = [str(x.get_label()) for x in speed.get_lines() if not str(x.get_label()).startswith("_")]
    assert len(named) == 11 and named[0] == "0.01 N m s" and named[9] == "nominal"
    assert speed.figure is not None and shown(titled(dataset(plan, Findings(comparisons)))).axes[2].get_xscale() == "linear"


def test_the_share_of_the_work_grows_with_the_length(monkeypatch: pytest.MonkeyPatch, plan: Any) -> None:
    """Of the order: runs over 1, 2, 4 and 8 times the angle."""
    shares: list[float] = []

    def error(model: Any, flows: Any, until: float, work: Work) -> float:
        work.report(0.0)
        return until

    monkeypatch.setattr(computation, "_largest_error", error)
    monkeypatch.setattr(computation, "compile_system", lambda *_: None)
    found = computation.errors(plan.spec, plan.machine, Work(reporter=lambda share, _: shares.append(share)))
    assert found.speed == pytest.approx([50.0, 100.0, 200.0, 400.0]) and found.factors.tolist() == [1.0, 0.5, 0.25, 0.125]
    assert [s for k, s in enumerate(shares) if s not in shares[:k]] == pytest.approx([0.0, 1 / 15, 3 / 15, 7 / 15], abs=1e-9)
