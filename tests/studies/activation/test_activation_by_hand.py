"""Runs of an activation that are made by hand: every quantity, the sentence, warnings, report, figure, curves of a run."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import drawn, titled, warnings_of

from wucht.files.catalogue import load_machine
from wucht.numerics.observers.turns import LargestTurn
from wucht.studies.activation import computation
from wucht.studies.activation import figure as activation_figure
from wucht.studies.activation.computation import CURVE, ActivationRun, Findings, Plan, prepare
from wucht.studies.activation.dataset import dataset, report
from wucht.studies.activation.spec import Activation

MACHINE = load_machine("drozdetskaya-2020/switchable-pendulums")
NAMES = ("switchable", "balanced", "rigid", "none")
EARLY, LATE = 105.0, 180.0  # the first closes again as it opens
KIND = {"switchable": 1000, "balanced": 2000, "rigid": 3000, "none": 4000}


@pytest.fixture(scope="module")
def plan() -> Plan:
    asked = {"until": "1 s", "orientations": [0.5, 2.0, 3.0], "phases": 2, "activation_speeds": [EARLY, LATE]}
    return prepare(Activation(**asked, variants=NAMES), MACHINE)


def number(run: Any) -> int:
    """Of its variant, speed, orientation and phase, so that no two runs are alike."""
    return int(KIND[run.of] + 100 * max(run.speed, 0) + 10 * max(run.orientation, 0) + max(run.phase, 0))


def made(run: Any, **other: Any) -> ActivationRun:
    """Amplitudes in millimetres by the number of the run; open at the end; rigid pendulums and none never open."""
    n, opens = number(run), run.of in ("switchable", "balanced")
    peak = 1e-6 * n
    common: dict[str, Any] = {
        "outcome": "compensated" if run.phase <= 0 else "captured", "final_speed": 7.0, "final_amplitude": 0.1 * peak,
        "peak": peak, "peak_before": 0.5 * peak if opens else math.nan, "peak_after": 0.75 * peak if opens else math.nan,
        "peak_speed": 90.0 + n / 1000, "opened_at": (n + 1.0, n + 3.0) if opens else (),
        "open_at_end": (True, True) if opens else (), "orientation": n / 1000 if opens else math.nan,
        "energy_residual": n * 1e-11, "failure": None,
        "curve": np.stack([n + np.arange(CURVE), 1e-3 * n + 1e-6 * np.arange(CURVE)]),
    }  # fmt: skip
    return ActivationRun(**common | other)


def answered(plan: Plan, missing: Any = lambda run: False, change: Any = lambda run: {}) -> xr.Dataset:
    results = {run.name: made(run, **change(run)) for run in plan.runs if not missing(run)}
    return titled(dataset(plan, Findings(results)))


def summary(result: xr.Dataset) -> dict[str, Any]:
    held: dict[str, Any] = result.wucht.summary
    return held


# --- the plan ---


def test_each_run_has_its_machine_and_its_indices(plan: Plan) -> None:
    runs = {v: [r for r in plan.runs if r.of == v] for v in NAMES}
    assert {v: len(r) for v, r in runs.items()} == {"switchable": 12, "balanced": 6, "rigid": 6, "none": 1}
    assert {(r.speed, r.orientation, r.phase) for r in runs["switchable"]} == {
        (i, j, k) for i in range(2) for j in range(3) for k in range(2)
    }
    assert {r.speed for r in (*runs["balanced"], *runs["rigid"], *runs["none"])} == {-1}
    assert plan.speeds == pytest.approx((EARLY, LATE))
    moving, inner = (MACHINE.values[f"p1.{key}"] for key in ("moving_mass", "inner_stop"))
    for r in runs["switchable"]:  # m r w^2
        assert r.machine.values["p2.preload"] == pytest.approx(moving * inner * (EARLY, LATE)[r.speed] ** 2)
    for r in runs["balanced"]:
        assert r.machine.values["p1.permanent_unbalance"] == 0.0 == r.machine.values["p2.permanent_unbalance"]
        assert r.machine.values["p1.preload"] == MACHINE.values["p1.preload"]
    assert "p1" not in runs["none"][0].start and all(r.settings.until == 1.0 for r in plan.runs)


def test_variants_that_are_not_asked_for_are_not_run() -> None:
    for name in NAMES:
        few = prepare(Activation(until="1 s", orientations=[0.5], phases=1, variants=[name]), MACHINE)
        assert [r.of for r in few.runs] == [name]


# --- the Dataset ---


def test_runs_are_at_their_places(plan: Plan) -> None:
    result = answered(plan)
    speed, orientation, phase = np.meshgrid(range(2), range(3), range(2), indexing="ij")
    n = 100 * speed + 10 * orientation + phase + 1000.0
    expected = {
        "peak": 1e-6 * n, "peak_before": 5e-7 * n, "peak_after": 7.5e-7 * n, "final_amplitude": 1e-7 * n,
        "energy_residual": 1e-11 * n, "opened_at": n + 2.0, "orientation_at_activation": n / 1000,
    }  # fmt: skip
    for name, values in expected.items():
        assert result[name].values == pytest.approx(values), name
    assert result.outcome.values.tolist() == [[["compensated", "captured"]] * 3] * 2
    assert result.balanced_peak.values == pytest.approx(1e-6 * (n[0] + 1000)) and result.balanced_peak.dims[0] == "orientation"
    assert result.rigid_peak.values == pytest.approx(1e-6 * (n[0] + 2000))
    assert float(result.none_peak) == pytest.approx(4e-3)
    assert result.activation_speed.values == pytest.approx([EARLY, LATE])
    assert result.orientation.values.tolist() == [0.5, 2.0, 3.0] and result.phase.values == pytest.approx([0.0, math.pi])
    assert result.peak.dims == ("activation_speed", "orientation", "phase")


def test_groups_are_taken_over_the_phases(plan: Plan) -> None:
    s = summary(answered(plan))
    assert [g["peak_amplitude"] for g in s["switchable"]] == pytest.approx([1e-6 * (n + 1) for n in (
        1000, 1010, 1020, 1100, 1110, 1120,
    )])  # fmt: skip
    last = s["switchable"][-1]
    assert last == {
        "activation_speed": pytest.approx(LATE), "orientation": 3.0, "peak_amplitude": pytest.approx(1.121e-3),
        "mean_peak": pytest.approx(1.1205e-3), "peak_before": pytest.approx(0.5605e-3),
        "peak_after": pytest.approx(0.84075e-3), "opened_at": pytest.approx(1122.5), "all_open": 2,
        "orientations_at_activation": pytest.approx([1.12, 1.121]), "outcomes": {"compensated": 1, "captured": 1},
    }  # fmt: skip
    assert [g["peak_amplitude"] for g in s["balanced"]] == pytest.approx([2.001e-3, 2.011e-3, 2.021e-3])
    assert [g["activation_speed"] for g in s["balanced"]] == pytest.approx([150.0] * 3), "that of the machine as it is"
    assert [set(g) for g in s["rigid"]] == [{"orientation", "peak_amplitude", "mean_peak", "outcomes"}] * 3
    assert s["none"] == {"peak_amplitude": pytest.approx(4e-3), "peak_speed": pytest.approx(94.0), "outcome": "compensated"}
    best = s["best"]
    assert (best["activation_speed"], best["orientation"]) == (pytest.approx(EARLY), 0.5)
    assert all(g["peak_amplitude"] >= best["peak_amplitude"] for g in best["neighbours"]) and best["neighbours"]
    beside = [g["peak_amplitude"] for g in best["neighbours"] if g["peak_amplitude"] > 2 * best["peak_amplitude"]]
    assert (best["cliff"] is None) == (not beside)
    assert s["energy_residual"] == pytest.approx(4e-8) and s["runs"] == 25


def test_runs_that_do_not_open_count_for_what_they_have(plan: Plan) -> None:
    """The second phase stays closed, the first opens only one of two: there is no nan among the means."""
    closed = {"peak_before": math.nan, "peak_after": math.nan, "orientation": math.nan, "opened_at": (math.nan, math.nan),
              "open_at_end": (False, False)}  # fmt: skip
    half = {"opened_at": (100.0, math.nan), "open_at_end": (True, False)}
    result = answered(plan, change=lambda r: {} if r.of != "switchable" else closed if r.phase else half)
    group = summary(result)["switchable"][0]
    assert (group["opened_at"], group["all_open"]) == (100.0, 0)
    assert group["orientations_at_activation"] == [1.0, None]
    assert group["peak_after"] == pytest.approx(0.75e-3) and group["peak_amplitude"] == pytest.approx(1.001e-3)
    assert "in 12 runs not all pendulums are open at the end" in warnings_of(result)
    never = answered(plan, change=lambda r: closed if r.of in ("switchable", "balanced") else {})
    group = summary(never)["balanced"][0]
    assert (group["opened_at"], group["peak_before"], group["peak_after"]) == (None, None, None)
    assert "in 18 runs not all pendulums are open at the end" in warnings_of(never)
    assert any(line.startswith("  balanced") and "none opens" in line for line in report(never))


def test_the_pendulums_switch_as_in_closed_form(plan: Plan) -> None:
    result = answered(plan)
    first, second = summary(result)["pendulums"]
    v = {key: MACHINE.values[f"p1.{key}"] for key in ("moving_mass", "inner_stop", "outer_stop", "stiffness")}
    forces = [v["moving_mass"] * v["inner_stop"] * w**2 for w in (EARLY, LATE)]
    travel = v["stiffness"] * (v["outer_stop"] - v["inner_stop"])
    closing = [math.sqrt((f + travel) / (v["moving_mass"] * v["outer_stop"])) for f in forces]
    assert first["opening"] == pytest.approx([EARLY, LATE]) and first["closing"] == pytest.approx(closing)
    after = [w * (0.01 + 0.25 * 0.052**2) / (0.01 + 0.25 * 0.104**2) for w in (EARLY, LATE)]
    assert first["after_opening"] == pytest.approx(after)
    assert (first["snaps"], first["stays_open"]) == ([True, True], [False, True])
    assert (first["name"], second["name"]) == ("p1", "p2")
    told = [w for w in warnings_of(result) if "repeatedly" in w]
    slower = f"as its mass moves out the speed falls from 105 to {after[0]:.4g} rad/s"
    assert told == [
        f"'{name}' may open and close repeatedly: {slower}, and it closes below {closing[0]:.4g} rad/s; more frame inertia, "
        "less stiffness or a shorter stroke keep it open"
        for name in ("p1", "p2")
    ]


def test_the_sentence_and_what_is_missing(plan: Plan) -> None:
    whole = answered(plan)
    balanced = "balanced ones 2.001 to 2.021 mm, rigid ones 3.001 to 3.021 mm"
    assert whole.attrs["sentence"] == f"peak with switchable pendulums 1.001 to 1.121 mm, {balanced}, none 4 mm"
    assert not any("missing" in w or "energy" in w or "not all" in w for w in warnings_of(whole))
    part = answered(plan, missing=lambda r: r.of in ("rigid", "none") or r.orientation > 0)
    assert part.attrs["sentence"] == "peak with switchable pendulums 1.001 to 1.101 mm, balanced ones 2.001 mm"
    assert warnings_of(part)[-1] == "19 of 25 runs are missing"
    assert np.isnan(part.peak.values[:, 1:]).all() and np.isfinite(part.peak.values[:, 0]).all()
    assert np.isnan(float(part.none_peak)) and np.isnan(part.rigid_peak.values).all()
    assert set(part.outcome.values[:, 1:].ravel()) == {""}
    nothing = answered(plan, missing=lambda r: True)
    assert nothing.attrs["sentence"] == "no run is finished" and nothing.sizes["curve"] == 0
    assert summary(nothing)["best"] is None and summary(nothing)["energy_residual"] is None
    assert warnings_of(nothing)[-1] == "25 of 25 runs are missing"


@pytest.mark.parametrize(("residual", "warned"), [(1e-6, False), (1.1e-6, True), (math.nan, True)])
def test_an_energy_balance_that_does_not_close_is_told(plan: Plan, residual: float, warned: bool) -> None:
    result = answered(plan, change=lambda r: {"energy_residual": residual})
    assert any("energy balance closes only to" in w for w in warnings_of(result)) is warned
    nothing = answered(plan, missing=lambda r: True)
    assert not any("energy balance" in w for w in warnings_of(nothing))


def test_the_first_failure_is_that_of_the_study(plan: Plan) -> None:
    failures = {plan.runs[3].name: "it burst", plan.runs[5].name: "it melted"}
    assert answered(plan, change=lambda r: {"failure": failures.get(r.name)}).attrs["failure"] == "it burst"
    assert answered(plan).attrs["failure"] == ""


def test_curves_are_those_of_the_first_phase_and_of_the_first_activation_speed(plan: Plan) -> None:
    result = answered(plan)
    degrees = ("28.65°", "114.6°", "171.9°")
    expected = {"without pendulums": 4000} | {
        f"{v}, {angle}": KIND[v] + 10 * j for v in ("switchable", "balanced", "rigid") for j, angle in enumerate(degrees)
    }
    assert result["curve"].values.tolist() == list(expected)
    for k, n in enumerate(expected.values()):
        assert result.curve_speed.values[k] == pytest.approx(n + np.arange(CURVE))
        assert result.curve_amplitude.values[k] == pytest.approx(1e-3 * n + 1e-6 * np.arange(CURVE))


# --- the report and the figure ---


def test_the_lines_of_the_report(plan: Plan) -> None:
    lines = report(answered(plan))
    assert lines[1] == f"verdict: {answered(plan).attrs['sentence']}"
    closing = summary(answered(plan))["pendulums"][0]["closing"]
    assert "p1, p2" in lines[2] and "opens at 105 rad/s" in lines[2] and f"closes at {closing[0]:.5g} rad/s" in lines[2]
    assert "opens at 180 rad/s" in lines[3] and "gradually" not in "".join(lines)
    assert lines[4].startswith("  none") and "4 mm at 94 rad/s" in lines[4]
    rigid, balanced, switchable = ([x for x in lines if x.startswith(f"  {v} ")] for v in ("rigid", "balanced", "switchable"))
    assert [len(rigid), len(balanced), len(switchable)] == [3, 3, 6]
    assert rigid[0].endswith("28.65° apart: 3.001 mm at most; 1 compensated, 1 captured")
    assert balanced[2].endswith(
        "at 150 rad/s, 171.9° apart: 2.021 mm at most, 1.516 mm from the opening on; 1 compensated, 1 captured"
    )
    assert "at 105 rad/s, 171.9° apart: 1.021 mm" in switchable[2] and "at 180 rad/s, 28.65° apart: 1.101" in switchable[3]
    assert lines[-1].endswith("balance closed to 4.0e-08 in all runs")


def test_the_report_of_pendulums_that_open_gradually(plan: Plan) -> None:
    gradual = SimpleNamespace(opening=100.0, closing=120.0, open_speed=90.0, snaps=False, stays_open=False)
    snapping = SimpleNamespace(opening=100.0, closing=80.0, open_speed=90.0, snaps=True, stays_open=True)
    mixed: Any = replace(plan, switching=((gradual, snapping), (gradual, snapping)))
    result = answered(mixed)
    lines = report(result)
    assert lines[2].startswith("  p1, p1 ") and lines[2].endswith("gradually in between")
    assert lines[3].startswith("  p2, p2 ") and not lines[3].endswith("gradually in between")
    assert not any("repeatedly" in w for w in warnings_of(result))


def test_peaks_over_the_orientation(plan: Plan) -> None:
    curves, peaks = drawn("activation", answered(plan)).axes
    labels = [str(line.get_label()) for line in peaks.get_lines()]
    assert labels == ["switchable, 105 rad/s", "switchable, 180 rad/s", "balanced", "rigid", "without pendulums"]
    at = np.degrees([0.5, 2.0, 3.0])
    for line, first in zip(peaks.get_lines(), (1.0, 1.1, 2.0, 3.0), strict=False):
        assert line.get_xdata() == pytest.approx(at)
        assert line.get_ydata() == pytest.approx([first + 0.0005, first + 0.0105, first + 0.0205])
    bands = [band.get_paths()[0].get_extents() for band in peaks.collections]
    assert [(b.y0, b.y1) for b in bands] == [pytest.approx((first, first + 0.021)) for first in (1.0, 1.1, 2.0, 3.0)]
    assert [(b.x0, b.x1) for b in bands] == [pytest.approx((at[0], at[-1]))] * 4
    assert peaks.get_xticks() == pytest.approx(at)
    styles = {str(line.get_label()): (line.get_color(), line.get_linestyle()) for line in curves.get_lines()}
    of_angle = {angle: {styles[f"{v}, {angle}"] for v in ("switchable", "balanced", "rigid")} for angle in ("28.65°", "114.6°")}
    assert all(len(alike) == 1 for alike in of_angle.values()) and of_angle["28.65°"] != of_angle["114.6°"]
    assert float(next(x for x in curves.get_lines() if str(x.get_label()).startswith("activation")).get_xdata()[0]) == EARLY


def test_peaks_over_the_activation_speed() -> None:
    plan = prepare(
        Activation(until="1 s", orientations=[0.5], phases=2, activation_speeds=[EARLY, LATE], variants=NAMES), MACHINE
    )
    _, peaks = drawn("activation", answered(plan)).axes
    lines = {str(line.get_label()): (line.get_xdata(), line.get_ydata()) for line in peaks.get_lines()}
    assert list(lines) == ["switchable", "balanced", "rigid", "without pendulums"]
    assert lines["switchable"] == (pytest.approx([EARLY, LATE]), pytest.approx([1.0005, 1.1005]))
    assert lines["rigid"] == (pytest.approx([EARLY, LATE]), pytest.approx([3.0005, 3.0005]))
    assert peaks.get_xlabel() == "activation speed (rad/s)" and peaks.get_ylabel() == "largest amplitude (mm)"


def test_one_orientation_and_one_speed_have_one_panel() -> None:
    plan = prepare(Activation(until="1 s", orientations=[0.5], phases=2, variants=("rigid", "none")), MACHINE)
    result = answered(plan)
    assert all("at 150 rad/s" not in line for line in report(result) if line.startswith("  switchable"))
    (curves,) = drawn("activation", result).axes
    assert [str(x.get_label()) for x in curves.get_lines()] == ["without pendulums", "rigid, 28.65°"], "nothing opens"


# --- one run ---


def motion_of(shares: dict[str, list[float]], **rows: Any) -> tuple[Any, dict[str, Any]]:
    stroke = {n: MACHINE.values[f"{n}.outer_stop"] - MACHINE.values[f"{n}.inner_stop"] for n in shares}
    names = [b.name for b in MACHINE.bodies]
    count = len(shares["p1"])
    speed, angle = np.zeros((len(names), count)), np.zeros((len(names), count))
    speed[names.index("drum")] = -np.arange(10.0, 10.0 + count)  # clockwise
    speed[names.index("p1")], speed[names.index("p2")] = -np.arange(20.0, 20.0 + count), -np.arange(30.0, 30.0 + count)
    angle[names.index("p1")], angle[names.index("p2")] = 5.0, 5.0 - 0.25 * np.arange(count)
    data = {"body": names, "speed": speed, "angle": angle} | rows
    turns = {"drum": SimpleNamespace(largest_turn=LargestTurn(9.0, -12.0))}
    observation = SimpleNamespace(largest=9.0, rotors=turns)
    motion = SimpleNamespace(
        rows={s.coordinate.position.name: stroke[s.name] * np.array(shares[s.name]) for s in MACHINE.sliders},
        machine_motion=SimpleNamespace(time=np.arange(float(count))),
        last=SimpleNamespace(trajectory=SimpleNamespace(end_time=2.0)), observation=observation,
        verdict=SimpleNamespace(outcome="compensated", speed=-8.0), trajectory=SimpleNamespace(failure=None),
    )  # fmt: skip
    return motion, data


@pytest.mark.parametrize("of", ["switchable", "rigid"])
def test_the_numbers_of_a_clockwise_run(monkeypatch: pytest.MonkeyPatch, of: str) -> None:
    """p1 leaves the stop at 3 (after it was pushed off at 1 and came back), p2 at 4."""
    motion, data = motion_of(
        {"p1": [0.0, 0.4, 0.01, 0.005, 0.3, 0.6, 1.0, 1.0], "p2": [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.51, 0.4]},
        amplitude=np.array([1.0, 2.0, 6.0, 4.0, 3.0, 5.0, 2.5, 0.5]), energy_residual=np.array([0, 1, 4, 2, 0, 0, 0, 3]) * 1e-9,
    )  # fmt: skip
    monkeypatch.setattr(computation, "run_up", lambda *_: iter([(motion,)]))
    monkeypatch.setattr(
        computation, "motion_quantities", lambda *_: [SimpleNamespace(name=k, value=v) for k, v in data.items()]
    )
    shares: list[float] = []
    case = SimpleNamespace(machine=MACHINE, horizon=SimpleNamespace(expected_end=8.0))
    run: Any = SimpleNamespace(of=of, case=lambda: case)
    one = computation._compute_run(run, ("p1", "p2"), lambda share, _: shares.append(share))
    assert shares == [0.25]
    assert (one.peak, one.peak_speed, one.final_amplitude, one.final_speed, one.energy_residual) == (9.0, 12.0, 0.5, -8.0, 4e-9)
    if of == "switchable":
        assert (one.peak_before, one.peak_after) == (6.0, 5.0)
        assert one.opened_at == (23.0, 34.0) and one.open_at_end == (True, False)
        assert one.orientation == pytest.approx(2 * math.pi - 0.75), "from the first to the second, as p1 opens"
    else:
        assert math.isnan(one.peak_before) and math.isnan(one.orientation) and one.opened_at == one.open_at_end == ()


def test_a_pendulum_opens_where_it_leaves_the_stop_for_the_last_time_before() -> None:
    assert computation._opening(np.array([0.0, 0.0, 0.0101, 0.01, 0.02, 0.5, 0.51, 0.0])) == 3
    assert computation._opening(np.array([0.0, 0.2, 0.5])) is None
    assert computation._opening(np.array([0.3, 0.6])) == 0, "it is never at the stop"


def test_the_curve_keeps_the_largest_amplitude_of_each_part() -> None:
    """A speed that rises evenly: parts of ten samples each; where nothing changes, parts are even in time."""
    time = np.linspace(5.0, 9.0, 10 * CURVE + 1)
    speed = np.linspace(0.0, 40.0, len(time))
    amplitude = np.zeros(len(time))
    amplitude[3::10] = 1.0 + np.arange(CURVE)
    for shown in (speed, speed[::-1]):
        curve = computation._curve(time, shown, amplitude)
        assert curve[1] == pytest.approx(1.0 + np.arange(CURVE))
        assert curve[0] == pytest.approx(shown[3::10])
    still = computation._curve(time, np.full(len(time), 7.0), amplitude)
    assert still[1] == pytest.approx(1.0 + np.arange(CURVE)) and set(still[0]) == {7.0}
    short = computation._curve(time[:3], speed[:3], np.array([1.0, 2.0, 9.0]))
    assert np.isfinite(short[0]).sum() == 2 and np.isnan(short[:, 2:]).all()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_speed_counts_as_much_as_the_time(sense: float) -> None:
    """All of the speed's change, up and down again, in the first tenth of the time: half of the parts, and one twentieth."""
    time = np.linspace(0.0, 4.0, 100 * CURVE + 1)
    speed = sense * 40.0 * np.interp(time, [0.0, 0.2, 0.4, 4.0], [0.0, 1.0, 0.0, 0.0])
    curve = computation._curve(time, speed, time)
    assert int((curve[1] <= 0.4).sum()) == pytest.approx(0.55 * CURVE, abs=1)
    assert int((curve[1] <= 0.2).sum()) == pytest.approx(0.275 * CURVE, abs=1)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_pendulums_are_apart_by_the_orientation_about_their_mean_phase(count: int) -> None:
    spec = Activation(until="1 s", orientations=["30 deg", "90 deg"], phases=2, start={"drum": 0.25})
    names, machine = tuple(f"p{k}" for k in range(count)), MACHINE
    for j, apart in enumerate((30.0, 90.0)):
        for k, phase in enumerate((0.0, 180.0)):
            run = computation._plan_run(spec, "switchable", machine, names, (0, j, k), (0.0, math.pi))
            angles = np.degrees([run.start[name] for name in names])
            assert angles.mean() == pytest.approx(phase, abs=1e-9) and np.diff(angles) == pytest.approx([apart] * (count - 1))
            assert run.start["drum"] == 0.25 and (run.speed, run.orientation, run.phase) == (0, j, k)


def test_orientations_of_which_a_run_is_missing_are_not_drawn() -> None:
    """Their mean and range would be those of other phases."""
    axis = Figure().add_subplot()
    peaks = np.array([[1.0, 3.0], [5.0, math.nan], [math.nan, math.nan], [2.0, 4.0]])
    activation_figure._band(axis, np.array([10.0, 20.0, 30.0, 40.0]), peaks, "black", "-", "rigid")
    (line,) = axis.get_lines()
    assert np.asarray(line.get_xdata()).tolist() == [10.0, 40.0] and np.asarray(line.get_ydata()).tolist() == [2.0, 3.0]
    corners = np.concatenate([path.vertices for path in axis.collections[0].get_paths()])
    assert (corners[:, 1].min(), corners[:, 1].max()) == (1.0, 4.0)
