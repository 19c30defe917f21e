"""The study ``activation``: against run-ups of machines written by hand, resumed, refused, reported and drawn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from interrupting import assert_same, stop_at, stopped_often
from wucht import Activation, RunUp, draw, load, load_machine, report
from wucht import run as ask
from wucht.files.building import machine_from

MACHINE = load_machine("drozdetskaya-2020/switchable-pendulums")
ALL = ("switchable", "balanced", "rigid", "none")
SHORT = {"until": "1.5 s", "orientations": [0.5], "phases": 1}
CARRIER = {"stiffness": 1e5, "damping": 200.0}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.078, "no_load_speed": 200.0}


def drum(mass: float) -> dict[str, Any]:
    return {"kind": "rotor", "name": "drum", "mass": mass, "unbalance": 9.75e-3, "inertia": 0.0338}


@pytest.mark.slow
def test_each_variant_is_the_run_up_of_its_machine() -> None:
    """Rigid: 0.75 kg with 0.013 kg m and 0.01 + 0.25 0.104^2 kg m^2 each, by hand; none: 10 kg. Peaks to the last digits."""
    given = SHORT | {"phases": 2, "activation_speeds": [120.0, 150.0]}
    s = ask(Activation(**given), MACHINE).wucht.summary
    rigid = [
        {
            "kind": "pendulum",
            "name": n,
            "about": "drum",
            "mass": 0.75,
            "length": 0.013 / 0.75,
            "inertia": 0.012704,
            "damping": 0.05,
        }
        for n in ("p1", "p2")
    ]
    starts = [{"p1": phase - 0.25, "p2": phase + 0.25} for phase in (0.0, math.pi)]
    hand = machine_from({"carrier": CARRIER, "bodies": [drum(8.5), *rigid], "drive": DRIVE})
    bare = machine_from({"carrier": CARRIER, "bodies": [drum(10.0)], "drive": DRIVE})
    early = MACHINE.with_values({f"{n}.preload": 0.25 * 0.052 * 120.0**2 for n in ("p1", "p2")})

    def peaks(machine: Any) -> list[float]:
        return [ask(RunUp(until="1.5 s", start=start), machine).wucht.summary["peak_amplitude"] for start in starts]

    assert s["none"]["peak_amplitude"] == pytest.approx(
        ask(RunUp(until="1.5 s"), bare).wucht.summary["peak_amplitude"], rel=1e-9
    )
    for group, machine in ((s["rigid"][0], hand), (s["switchable"][0], early), (s["switchable"][1], MACHINE)):
        assert group["peak_amplitude"] == pytest.approx(max(peaks(machine)), rel=1e-6)
    assert [g["activation_speed"] for g in s["switchable"]] == pytest.approx([120.0, 150.0])
    assert s["switchable"][0]["opened_at"] == pytest.approx(120.0, rel=0.03)
    assert s["energy_residual"] < 1e-10


@pytest.mark.slow
def test_an_interrupted_study_is_resumed(tmp_path: Path) -> None:
    question = Activation(until="0.2 s", orientations=[0.5, 1.0], phases=2)
    assert_same(ask(question, MACHINE), stopped_often(question, MACHINE, tmp_path, 2, 3))


def test_what_is_missing_is_told(tmp_path: Path) -> None:
    question = Activation(until="0.2 s", orientations=[0.5, 1.0], phases=2)
    part = ask(question, MACHINE, folder=tmp_path, progress=stop_at(6))
    assert not part.attrs["finished"]
    assert any("runs are missing" in w for w in part.wucht.warnings)
    assert np.isnan(part.peak.values).any()
    draw(part)
    report(part)


@pytest.mark.parametrize(
    "changed",
    [
        {"activation_speeds": [-3.0]},
        {"orientations": [1.0, 1.0]},
        {"orientations": []},
        {"orientations": "90 deg"},
        {"phases": 0},
        {"phases": 360, "activation_speeds": [float(w) for w in range(100, 120)]},
        {"variants": ["stiff"]},
        {"until": None},
    ],
)
def test_questions_that_make_no_sense_are_refused(changed: dict[str, Any]) -> None:
    keys = {key: value for key, value in (SHORT | changed).items() if value is not None}
    check_refusal(f"activation: {str(changed)[:80]}", lambda: ask(Activation(**keys), MACHINE))


def test_a_start_of_the_pendulums_and_a_machine_without_any_are_refused() -> None:
    for key in ("p1", "delta"):
        with refused(f"study.start.{key}", "study.orientations", "study.phases", given=0.3):
            ask(Activation(**SHORT, start={key: 0.3}), MACHINE)
    with refused("machine.bodies", given=["rotor", "pendulum", "pendulum"]):
        ask(Activation(**SHORT), load_machine("drozdetskaya-2020/r1"))


def test_pendulums_that_never_open_and_those_that_open_again_and_again_are_told() -> None:
    """180 rad/s is not reached in the time; at 105 rad/s they slow down to 88.2 and close below 92.3."""
    result = ask(
        Activation(**SHORT | {"until": "0.4 s", "variants": ["switchable"], "activation_speeds": [105.0, 180.0]}), MACHINE
    )
    s, warnings = result.wucht.summary, result.wucht.warnings
    assert s["switchable"][1]["peak_after"] is None
    assert s["switchable"][1]["orientations_at_activation"] == [None]
    assert s["pendulums"][0]["stays_open"] == [False, True]
    assert s["pendulums"][0]["after_opening"][0] == pytest.approx(105 * (0.01 + 0.25 * 0.052**2) / (0.01 + 0.25 * 0.104**2))
    assert sum("repeatedly" in w for w in warnings) == 2
    assert any("not all pendulums are open at the end" in w for w in warnings)


@pytest.mark.slow
def test_figure_and_report_tell_what_was_run(tmp_path: Path) -> None:
    question = Activation(
        until="1.5 s", orientations=["45 deg", "180 deg"], phases=2, variants=["switchable", "balanced", "rigid", "none"]
    )
    result = ask(question, MACHINE, folder=tmp_path)
    drawn = draw(load(tmp_path / "result.nc"))
    left, right = drawn.axes
    assert left.get_xlabel() == "speed of the rotor (rad/s)"
    assert left.get_ylabel() == "amplitude of the axis (mm)"
    assert right.get_xlabel() == "orientation at the start (°)"
    names = [t.get_text() for axis in drawn.axes for t in axis.get_legend().get_texts()]
    assert {"without pendulums", "switchable, 180°", "balanced, 45°", "rigid, 45°", "switchable", "rigid"} <= set(names)
    curve = next(line for line in left.get_lines() if line.get_label() == "rigid, 45°")
    assert 1e-3 * max(curve.get_ydata()) == pytest.approx(result.wucht.summary["rigid"][0]["peak_amplitude"], rel=0.05)
    lines = report(result)
    assert any(line.startswith("  p1, p2") and "opens at 150 rad/s" in line for line in lines)
    assert sum(line.startswith("  switchable") for line in lines) == 2
    speeds = ask(
        Activation(**SHORT | {"until": "0.2 s", "activation_speeds": [120.0, 150.0], "variants": ["switchable"]}), MACHINE
    )
    assert draw(speeds).axes[1].get_xlabel() == "activation speed (rad/s)"


def test_pendulums_start_at_their_orientations() -> None:
    """From each to the next the orientation, counter-clockwise, their mean at the phases, which divide a turn evenly."""
    question = Activation(until="1.5 s", orientations=[0.5, 2.0], phases=4, variants=["switchable"], start={"drum": 0.25})
    cases, _ = question.prepare(MACHINE)
    starts = {(case.orientation, case.phase): [case.start[name] for name in ("p1", "p2")] for case in cases}
    assert len(starts) == 8 and all(case.start["drum"] == 0.25 for case in cases)
    for (j, k), pair in starts.items():
        apart, mean = (0.5, 2.0)[j], k * math.pi / 2
        assert pair == pytest.approx([mean - apart / 2, mean + apart / 2])


def test_each_run_has_its_machine_and_its_indices() -> None:
    question = Activation(until="1 s", orientations=[0.5, 2.0, 3.0], phases=2, activation_speeds=[105.0, 180.0], variants=ALL)
    cases, switchings = question.prepare(MACHINE)
    runs = {of: [case for case in cases if case.of == of] for of in ALL}
    assert {of: len(of_variant) for of, of_variant in runs.items()} == {"switchable": 12, "balanced": 6, "rigid": 6, "none": 1}
    assert [case.speed for case in runs["switchable"]] == [0] * 6 + [1] * 6
    assert {case.speed for of in ALL[1:] for case in runs[of]} == {-1}
    assert [s[0].opening for s in switchings] == pytest.approx([105.0, 180.0])
    for case in runs["switchable"]:  # m r w^2
        assert case.machine.values["p2.preload"] == pytest.approx(0.25 * 0.052 * (105.0, 180.0)[case.speed] ** 2)
    for case in runs["balanced"]:
        assert case.machine.values["p1.permanent_unbalance"] == 0.0 == case.machine.values["p2.permanent_unbalance"]
        assert case.machine.values["p1.preload"] == MACHINE.values["p1.preload"]
    assert "p1" not in runs["none"][0].start and all(case.settings.until == 1.0 for case in cases)
    for of in ALL:
        (only,), _ = Activation(until="1 s", orientations=[0.5], phases=1, variants=[of]).prepare(MACHINE)
        assert only.of == of


@pytest.fixture(scope="module")
def every_variant() -> xr.Dataset:
    """Two activation speeds, of which the second is not reached, two orientations and phases, for a short time."""
    question = Activation(until="0.5 s", orientations=[0.5, 2.0], phases=2, activation_speeds=[60.0, 180.0], variants=ALL)
    return ask(question, MACHINE)


def test_groups_are_taken_over_the_phases(every_variant: xr.Dataset) -> None:
    s, peak = every_variant.wucht.summary, every_variant.peak
    assert peak.dims == ("activation_speed", "orientation", "phase")
    assert every_variant.phase.values == pytest.approx([0.0, math.pi])
    rows = [(g["activation_speed"], g["orientation"]) for g in s["switchable"]]
    assert rows == [(pytest.approx(w), angle) for w in (60.0, 180.0) for angle in (0.5, 2.0)]
    for group, values in zip(s["switchable"], peak.values.reshape(4, 2), strict=True):
        assert (group["peak_amplitude"], group["mean_peak"]) == (values.max(), pytest.approx(values.mean()))
        assert sum(group["outcomes"].values()) == 2
    for of in ("balanced", "rigid"):
        values = every_variant[f"{of}_peak"].values
        assert [g["peak_amplitude"] for g in s[of]] == values.max(axis=1).tolist()
    assert [g["activation_speed"] for g in s["balanced"]] == pytest.approx([150.0] * 2), "that of the machine as it is"
    assert [set(g) for g in s["rigid"]] == [{"orientation", "peak_amplitude", "mean_peak", "outcomes"}] * 2
    assert float(every_variant.none_peak) == s["none"]["peak_amplitude"] and s["runs"] == 17
    assert s["best"]["peak_amplitude"] == min(g["peak_amplitude"] for g in s["switchable"])
    assert len(s["best"]["neighbours"]) == 2
    assert s["energy_residual"] >= np.nanmax(every_variant.energy_residual)
    lines = report(every_variant)
    assert [sum(line.startswith(f"  {of} ") for line in lines) for of in ALL] == [4, 2, 2, 1]
    peaks = [g["peak_amplitude"] for g in s["switchable"]]
    assert lines[1].startswith(f"verdict: peak with switchable pendulums {1e3 * min(peaks):.4g} to {1e3 * max(peaks):.4g} mm, ")


def test_runs_that_do_not_open_count_for_what_they_have(every_variant: xr.Dataset) -> None:
    s = every_variant.wucht.summary
    early, late = s["switchable"][:2], s["switchable"][2:]
    assert all(g["opened_at"] == pytest.approx(60.0, rel=0.1) and g["peak_after"] <= g["peak_amplitude"] for g in early)
    assert [(g["opened_at"], g["peak_before"], g["peak_after"], g["all_open"]) for g in late] == [(None, None, None, 0)] * 2
    assert late[0]["orientations_at_activation"] == [None, None]
    opened = every_variant.opened_at.values
    assert np.isfinite(opened[0, 0]).all() and np.isnan(opened[1]).all()
    assert np.isnan(opened[0, 1, 1]) and math.isfinite(early[1]["opened_at"]), "of one pendulum of a run, and of other runs"
    assert early[0]["opened_at"] == pytest.approx(opened[0, 0].mean())
    largest = np.fmax(every_variant.peak_before.values, every_variant.peak_after.values)[0, 0]
    assert largest == pytest.approx(every_variant.peak.values[0, 0], rel=1e-2)
    closed = 8 - sum(g["all_open"] for g in early) + 4 - sum(g["all_open"] for g in s["balanced"])
    assert f"in {closed} runs not all pendulums are open at the end" in every_variant.wucht.warnings
    lines = report(every_variant)
    assert sum(line.startswith("  switchable ") and ", none opens; " in line for line in lines) == 2
    assert sum(line.startswith("  switchable ") and " from the opening on; " in line for line in lines) == 2


def test_the_pendulums_switch_as_in_closed_form(every_variant: xr.Dataset) -> None:
    first, second = every_variant.wucht.summary["pendulums"]
    v = {key: MACHINE.values[f"p1.{key}"] for key in ("moving_mass", "inner_stop", "outer_stop", "stiffness")}
    forces = [v["moving_mass"] * v["inner_stop"] * w**2 for w in (60.0, 180.0)]
    travel = v["stiffness"] * (v["outer_stop"] - v["inner_stop"])
    closing = [math.sqrt((f + travel) / (v["moving_mass"] * v["outer_stop"])) for f in forces]
    assert first["opening"] == pytest.approx([60.0, 180.0]) and first["closing"] == pytest.approx(closing)
    assert (first["name"], second["name"]) == ("p1", "p2")
    assert first["snaps"] == [w < o for w, o in zip(closing, (60.0, 180.0), strict=True)]
    lines = report(every_variant)
    assert lines[2].startswith("  p1, p2 ") and f"closes at {closing[0]:.5g} rad/s" in lines[2]
    assert lines[2].endswith("gradually in between") is not first["snaps"][0] and "gradually" not in lines[3]


def test_curves_are_those_of_the_first_phase_and_of_the_first_activation_speed(every_variant: xr.Dataset) -> None:
    names = [f"{of}, {angle}" for of in ("switchable", "balanced", "rigid") for angle in ("28.65°", "114.6°")]
    assert every_variant["curve"].values.tolist() == ["without pendulums", *names]
    amplitude = every_variant.curve_amplitude.values
    largest = [float(every_variant.none_peak), *every_variant.peak.values[0, :, 0], *every_variant.balanced_peak.values[:, 0]]
    assert np.nanmax(amplitude, axis=1)[:5] == pytest.approx(largest, rel=1e-2)
    assert np.nanmax(every_variant.curve_speed) > 100.0 and np.nanmin(every_variant.curve_speed) >= 0.0


def test_peaks_over_the_orientation(every_variant: xr.Dataset) -> None:
    """Their mean and their range over the phases; an orientation of which a run is missing is not drawn."""
    peaks = draw(every_variant).axes[1]
    labels = [str(line.get_label()) for line in peaks.get_lines()]
    assert labels == ["switchable, 60 rad/s", "switchable, 180 rad/s", "balanced", "rigid", "without pendulums"]
    values = 1e3 * every_variant.peak.values[0]
    assert peaks.get_lines()[0].get_xydata() == pytest.approx(np.column_stack([np.degrees([0.5, 2.0]), values.mean(axis=1)]))
    band = peaks.collections[0].get_paths()[0].get_extents()
    assert (band.y0, band.y1) == pytest.approx((values.min(), values.max()))
    part = every_variant.copy(deep=True)
    part.peak.values[0, 1, 1] = math.nan
    (line,) = (line for line in draw(part).axes[1].get_lines() if line.get_label() == "switchable, 60 rad/s")
    assert line.get_xydata() == pytest.approx(np.array([[np.degrees(0.5), values[0].mean()]]))


def test_one_orientation_and_one_speed_have_one_panel() -> None:
    result = ask(Activation(until="0.1 s", orientations=[0.5], phases=1, variants=("rigid", "none")), MACHINE)
    (curves,) = draw(result).axes
    assert [str(line.get_label()) for line in curves.get_lines()] == ["without pendulums", "rigid, 28.65°"], "nothing opens"
    assert result.wucht.summary["best"] is None and result.wucht.summary["switchable"] == []


def test_before_a_run_is_finished_there_is_an_answer() -> None:
    nothing = ask(Activation(until="0.2 s", orientations=[0.5], phases=1), MACHINE, progress=stop_at(1))
    assert nothing.attrs["sentence"] == "no run is finished" and nothing.sizes["curve"] == 0
    assert nothing.wucht.summary["best"] is None and nothing.wucht.summary["energy_residual"] is None
    assert "3 of 3 runs are missing" in nothing.wucht.warnings
    assert not any("energy balance" in warning for warning in nothing.wucht.warnings)


def test_an_energy_balance_that_does_not_close_is_told() -> None:
    coarse = {"until": "0.5 s", "orientations": [0.5], "phases": 1, "variants": ["none"]}
    for tolerance, is_told in ((1e-12, False), (1e-2, True)):
        result = ask(Activation(**coarse, tolerance=tolerance), MACHINE)
        assert (result.wucht.summary["energy_residual"] > 1e-6) is is_told
        assert any("energy balance closes only to" in warning for warning in result.wucht.warnings) is is_told


@pytest.mark.parametrize("k", [0, 1])
def test_a_pendulum_opens_where_its_mass_last_leaves_the_stop_before(every_variant: xr.Dataset, k: int) -> None:
    """Read from the run-up itself: it is open once the mass is beyond half of its stroke."""
    early = MACHINE.with_values({f"{n}.preload": 0.25 * 0.052 * 60.0**2 for n in ("p1", "p2")})
    start = {"p1": k * math.pi - 0.25, "p2": k * math.pi + 0.25}
    up = ask(RunUp(until="0.5 s", start=start), early)
    shares = up.slider_displacement / (early.values["p1.outer_stop"] - early.values["p1.inner_stop"])
    opened, is_open = dict[str, int](), list[bool]()
    for name in ("p1", "p2"):
        share = shares.sel(slider=name).values
        before = share[: int(np.argmax(share > 0.5))]
        opened[name] = int(np.flatnonzero(before <= 0.01)[-1])
        is_open.append(bool(share[-1] > 0.5))
    first, one = min(opened.values()), every_variant.isel(activation_speed=0, orientation=0, phase=k)
    speeds = [abs(float(up.speed.sel(body=name)[i])) for name, i in opened.items()]
    assert float(one.opened_at) == pytest.approx(np.mean(speeds), rel=1e-6)
    assert float(one.peak_before) == pytest.approx(float(up.amplitude[: first + 1].max()), rel=1e-6)
    assert float(one.peak_after) == pytest.approx(float(up.amplitude[first:].max()), rel=1e-6)
    apart = float(up.angle.sel(body="p2")[first] - up.angle.sel(body="p1")[first]) % (2 * math.pi)
    assert float(one.orientation_at_activation) == pytest.approx(apart, rel=1e-6)
    assert float(one.final_amplitude) == pytest.approx(float(up.amplitude[-1]), rel=1e-6)
    assert str(one.outcome.values) == up.attrs["outcome"] and all(is_open)
