"""The study ``activation``: against run-ups of machines written by hand, resumed, refused, reported and drawn."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from interrupting import assert_same, stop_at, stopped_often
from wucht import Activation, Machine, RunUp, draw, load_machine, report
from wucht import run as ask
from wucht.files.building import machine_from

ALL = ("switchable", "balanced", "rigid", "none")
SHORT = {"until": "1.5 s", "orientations": [0.5], "phases": 1}
CARRIER = {"stiffness": 1e5, "damping": 200.0}
DRIVE = {"kind": "linear", "on": "drum", "slope": 0.078, "no_load_speed": 200.0}


START = {"drum": 0.25}


@cache
def machine() -> Machine:
    return load_machine("drozdetskaya-2020/switchable-pendulums")


@cache
def every_variant() -> xr.Dataset:
    """Two activation speeds, of which the second is not reached, two orientations and phases, for a short time."""
    keys = {"orientations": [0.5, 2.0], "phases": 2, "activation_speeds": [60.0, 180.0], "variants": ALL}
    return ask(Activation(until="0.5 s", start=START, **keys), machine())


def start(apart: float, k: int) -> dict[str, float]:
    """From each pendulum to the next the orientation, counter-clockwise, their mean at the phase."""
    return START | {"p1": k * math.pi - apart / 2, "p2": k * math.pi + apart / 2}


def opening_at(speed: float) -> Machine:
    return machine().with_values({f"{n}.preload": 0.25 * 0.052 * speed**2 for n in ("p1", "p2")})  # m r w^2


def test_each_variant_is_the_run_up_of_its_machine() -> None:
    """Rigid: 0.75 kg with 0.013 kg m and 0.01 + 0.25 0.104^2 kg m^2 each, by hand; none: 10 kg."""
    shape = {"mass": 0.75, "length": 0.013 / 0.75, "inertia": 0.012704, "damping": 0.05}
    pendulums = [{"kind": "pendulum", "name": n, "about": "drum"} | shape for n in ("p1", "p2")]
    drum = {"kind": "rotor", "name": "drum", "unbalance": 9.75e-3, "inertia": 0.0338}
    rigid = machine_from({"carrier": CARRIER, "bodies": [drum | {"mass": 8.5}, *pendulums], "drive": DRIVE})
    bare = machine_from({"carrier": CARRIER, "bodies": [drum | {"mass": 10.0}], "drive": DRIVE})
    balanced = machine().with_values({f"{n}.permanent_unbalance": 0.0 for n in ("p1", "p2")})

    def peak(built: Machine, start: dict[str, float]) -> float:
        return float(ask(RunUp(until="0.5 s", start=start), built).wucht.summary["peak_amplitude"])

    result = every_variant()
    assert float(result.none_peak) == pytest.approx(peak(bare, START), rel=1e-6)
    for name, built in (("rigid_peak", rigid), ("balanced_peak", balanced)):
        assert result[name].values[1] == pytest.approx([peak(built, start(2.0, k)) for k in (0, 1)], rel=1e-6)
    late = opening_at(180.0)
    assert result.peak.values[1, 0] == pytest.approx([peak(late, start(0.5, k)) for k in (0, 1)], rel=1e-6)


def test_groups_are_taken_over_the_phases() -> None:
    result = every_variant()
    s, peak = result.wucht.summary, result.peak
    assert peak.dims == ("activation_speed", "orientation", "phase")
    assert result.phase.values == pytest.approx([0.0, math.pi])
    rows = [(g["activation_speed"], g["orientation"]) for g in s["switchable"]]
    assert rows == [(pytest.approx(w), angle) for w in (60.0, 180.0) for angle in (0.5, 2.0)]
    for group, values in zip(s["switchable"], peak.values.reshape(4, 2), strict=True):
        assert (group["peak_amplitude"], group["mean_peak"]) == (values.max(), pytest.approx(values.mean()))
        assert sum(group["outcomes"].values()) == 2
    for of in ("balanced", "rigid"):
        assert [g["peak_amplitude"] for g in s[of]] == result[f"{of}_peak"].values.max(axis=1).tolist()
    assert [g["activation_speed"] for g in s["balanced"]] == pytest.approx([150.0] * 2), "that of the machine as it is"
    assert float(result.none_peak) == s["none"]["peak_amplitude"] and s["runs"] == 17
    assert s["best"]["peak_amplitude"] == min(g["peak_amplitude"] for g in s["switchable"])
    assert s["energy_residual"] >= np.nanmax(result.energy_residual)


def test_runs_that_do_not_open_count_for_what_they_have() -> None:
    result = every_variant()
    s, opened = result.wucht.summary, result.opened_at.values
    early, late = s["switchable"][:2], s["switchable"][2:]
    assert all(g["peak_after"] <= g["peak_amplitude"] for g in early)
    assert [(g["opened_at"], g["peak_before"], g["peak_after"], g["all_open"]) for g in late] == [(None, None, None, 0)] * 2
    assert late[0]["orientations_at_activation"] == [None, None]
    assert np.isfinite(opened[0, 0]).all() and np.isnan(opened[1]).all()
    assert np.isnan(opened[0, 1, 1]) and math.isfinite(early[1]["opened_at"]), "of one pendulum of a run, and of other runs"
    assert early[0]["opened_at"] == pytest.approx(opened[0, 0].mean())
    closed = 8 - sum(g["all_open"] for g in early) + 4 - sum(g["all_open"] for g in s["balanced"])
    assert f"in {closed} runs not all pendulums are open at the end" in result.wucht.warnings


def test_the_pendulums_switch_as_in_closed_form() -> None:
    first, second = every_variant().wucht.summary["pendulums"]
    v = {key: machine().values[f"p1.{key}"] for key in ("moving_mass", "inner_stop", "outer_stop", "stiffness")}
    forces = [v["moving_mass"] * v["inner_stop"] * w**2 for w in (60.0, 180.0)]
    travel = v["stiffness"] * (v["outer_stop"] - v["inner_stop"])
    closing = [math.sqrt((f + travel) / (v["moving_mass"] * v["outer_stop"])) for f in forces]
    assert first["opening"] == pytest.approx([60.0, 180.0]) and first["closing"] == pytest.approx(closing)
    assert (first["name"], second["name"]) == ("p1", "p2")
    assert first["snaps"] == [w < o for w, o in zip(closing, (60.0, 180.0), strict=True)]


def test_of_an_interrupted_study_what_there_is() -> None:
    question = Activation(until="0.1 s", orientations=[0.5], phases=1)
    nothing, part = (ask(question, machine(), progress=stop_at(call)) for call in (1, 3))
    assert nothing.attrs["sentence"] == "no run is finished" and nothing.sizes["curve"] == 0
    assert nothing.wucht.summary["best"] is None and nothing.wucht.summary["energy_residual"] is None
    assert "3 of 3 runs are missing" in nothing.wucht.warnings and not part.attrs["finished"]
    assert draw(part).axes and report(part)


def test_an_interrupted_study_is_resumed(tmp_path: Path) -> None:
    question = Activation(until="0.1 s", orientations=[0.5, 1.0], phases=1)
    assert_same(ask(question, machine()), stopped_often(question, machine(), tmp_path, 2, 3))


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
    check_refusal(f"activation: {str(changed)[:80]}", lambda: ask(Activation(**keys), machine()))


def test_a_start_of_the_pendulums_and_a_machine_without_any_are_refused() -> None:
    for key in ("p1", "delta"):
        with refused(f"study.start.{key}", "study.orientations", "study.phases", given=0.3):
            ask(Activation(**SHORT, start={key: 0.3}), machine())
    with refused("machine.bodies", given=["rotor", "pendulum", "pendulum"]):
        ask(Activation(**SHORT), load_machine("drozdetskaya-2020/r1"))


def test_pendulums_that_never_open_and_those_that_open_again_and_again_are_told() -> None:
    """180 rad/s is not reached in the time; at 105 rad/s they slow down to 88.2 and close below 92.3."""
    result = ask(
        Activation(**SHORT | {"until": "0.4 s", "variants": ["switchable"], "activation_speeds": [105.0, 180.0]}), machine()
    )
    s, warnings = result.wucht.summary, result.wucht.warnings
    assert s["switchable"][1]["peak_after"] is None
    assert s["switchable"][1]["orientations_at_activation"] == [None]
    assert s["pendulums"][0]["stays_open"] == [False, True]
    assert s["pendulums"][0]["after_opening"][0] == pytest.approx(105 * (0.01 + 0.25 * 0.052**2) / (0.01 + 0.25 * 0.104**2))
    assert sum("repeatedly" in w for w in warnings) == 2
    assert any("not all pendulums are open at the end" in w for w in warnings)


def test_an_energy_balance_that_does_not_close_is_told() -> None:
    coarse = {"until": "0.5 s", "orientations": [0.5], "phases": 1, "variants": ["none"]}
    for tolerance, is_told in ((1e-12, False), (1e-2, True)):
        result = ask(Activation(**coarse, tolerance=tolerance), machine())
        assert (result.wucht.summary["energy_residual"] > 1e-6) is is_told
        assert any("energy balance closes only to" in warning for warning in result.wucht.warnings) is is_told


@pytest.mark.parametrize("k", [0, 1])
def test_a_pendulum_opens_where_its_mass_last_leaves_the_stop_before(k: int) -> None:
    """Read from the run-up itself: it is open once the mass is beyond half of its stroke."""
    early = opening_at(60.0)
    up = ask(RunUp(until="0.5 s", start=start(0.5, k)), early)
    shares = up.slider_displacement / (early.values["p1.outer_stop"] - early.values["p1.inner_stop"])
    opened, is_open = dict[str, int](), list[bool]()
    for name in ("p1", "p2"):
        share = shares.sel(slider=name).values
        before = share[: int(np.argmax(share > 0.5))]
        opened[name] = int(np.flatnonzero(before <= 0.01)[-1])
        is_open.append(bool(share[-1] > 0.5))
    first, one = min(opened.values()), every_variant().isel(activation_speed=0, orientation=0, phase=k)
    speeds = [abs(float(up.speed.sel(body=name)[i])) for name, i in opened.items()]
    assert float(one.opened_at) == pytest.approx(np.mean(speeds), rel=1e-6)
    assert float(one.peak_before) == pytest.approx(float(up.amplitude[: first + 1].max()), rel=1e-6)
    assert float(one.peak_after) == pytest.approx(float(up.amplitude[first:].max()), rel=1e-6)
    apart = float(up.angle.sel(body="p2")[first] - up.angle.sel(body="p1")[first]) % (2 * math.pi)
    assert float(one.orientation_at_activation) == pytest.approx(apart, rel=1e-6)
    assert float(one.final_amplitude) == pytest.approx(float(up.amplitude[-1]), rel=1e-6)
    assert str(one.outcome.values) == up.attrs["outcome"] and all(is_open)
