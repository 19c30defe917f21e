"""Run-ups of the averaged equations, alone and beside the full ones."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal

from interrupting import assert_same
from wucht import RunUp
from wucht.dynamics.run_ups import observed_integration as watched
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.runner import run

START = {"p1": 0.3, "p2": -0.5}
PENDULUM = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "inertia": 1.69e-3, "damping": 0.169}


def drum(sense: int = 1, **changes: Any) -> Machine:
    """R2 with u = 80, its drive in either sense: it compensates."""
    rotor = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.0338}
    return machine_from(
        {
            "carrier": {"directions": "xy", "stiffness": 1e5, "damping": 200.0},
            "bodies": [rotor, PENDULUM | {"name": "p1"}, PENDULUM | {"name": "p2"}],
            "drive": {"kind": "linear", "slope": 0.078, "no_load_speed": sense * 200.0},
        }
        | changes
    )


def answer(machine: Machine, **keys: Any) -> tuple[xr.Dataset, dict[str, Any]]:
    result = run(RunUp.from_table({"kind": "run-up", **keys}), machine)
    return result, result.wucht.summary


@pytest.fixture(scope="module")
def both() -> xr.Dataset:
    return answer(drum(), until=12.0, start=START, model="both")[0]


def test_the_slow_run_ends_like_the_full_one(both: xr.Dataset) -> None:
    summary = both.wucht.summary
    slow = summary["slow"]
    assert summary["outcome"] == slow["outcome"] == "compensated"
    assert slow["final_speed"] == pytest.approx(summary["final_speed"], rel=1e-6)
    for short in (summary, slow):
        # The state with the unbalance compensated is exact for both: cos = -0.375, 002 (5.7), errata 5.5.
        assert [math.cos(p) for p in short["final_phases"].values()] == pytest.approx([-0.375, -0.375], abs=2e-4)
    assert both.slow_speed.dims == both.speed.dims and both.slow_phase.dims == both.phase.dims


def test_slow_alone_is_slow_beside_full(both: xr.Dataset) -> None:
    alone, summary = answer(drum(), until=12.0, start=START, model="slow")
    assert "slow_speed" not in alone
    beside = both.wucht.summary["slow"]
    assert summary["outcome"] == beside["outcome"]
    assert summary["final_speed"] == pytest.approx(beside["final_speed"], rel=1e-9)
    at = both.time.values[-1]
    assert float(alone.speed[0].interp(time=at)) == pytest.approx(float(both.slow_speed[0, -1]), rel=1e-7)


ENERGY = {
    "two pendulums": ("drozdetskaya-2020/r2", {}),
    "inertia kept": ("drozdetskaya-2020/r2", {"inertia": True}),
    "second order": ("drozdetskaya-2020/table-3.1-carrier", {"order": 2, "until": 800.0}),
    "dampers that are not reciprocal": ("drozdetskaya-2020/table-5.1", {"until": 500.0}),
    "exciters": ("practice/screen", {"start": {"e1": "-90 deg", "e2": "-90 deg"}}),
    "shaken": ("sperling-vibration/figure-2a", {"until": 20.0}),
    "prescribed speed": ("sperling-rollers/figure-8", {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ENERGY)
def test_the_energy_of_the_slow_motion_balances(case: str) -> None:
    name, keys = ENERGY[case]
    result, summary = answer(load_machine(name), **({"until": 3.0, "model": "slow"} | keys))
    assert not result.attrs["failure"]
    assert 0 <= summary["energy_residual"] < 1e-8
    assert float(np.abs(result.supplied_work).max() + np.abs(result.dissipated_work).max()) > 0


# Where it ends


@pytest.mark.slow
@pytest.mark.parametrize(("turns", "sense"), [(0.5, 1), (20.0, -1)])
def test_turns_end_exactly(turns: float, sense: int) -> None:
    result, _ = answer(drum(sense), turns=turns, start=START | {"drum": 1.0}, model="slow")
    # The state at the end is (phases, speed, angle of the main rotor in its own sense).
    angle = result.end_state[3]
    assert angle - sense * 1.0 == pytest.approx(2 * math.pi * turns, rel=1e-9)
    assert result.time.values[-1] <= result.attrs["end_time"]
    assert np.abs(result.angle.values[0] - 1.0).max() <= 2 * math.pi * turns * (1 + 1e-9)


def test_until_settled() -> None:
    result, summary = answer(drum(), start=START, model="slow")
    assert summary["outcome"] == "compensated"
    assert result.attrs["finished"] == 1
    assert 0 < summary["settling_time"] < result.attrs["end_time"] < 1000


@pytest.mark.parametrize("inertia", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_clockwise_is_the_mirror_image(inertia: bool) -> None:
    mirrored = {"p1": -0.3, "p2": 0.5}
    keys = {"until": 1.0, "model": "slow", "inertia": inertia}
    right, left = answer(drum(1), start=START, **keys)[0], answer(drum(-1), start=mirrored, **keys)[0]
    assert right.speed.values.max() > 100
    assert left.speed.values == pytest.approx(-right.speed.values, rel=1e-9, abs=1e-9)
    assert left.amplitude.values == pytest.approx(right.amplitude.values, rel=1e-7, abs=1e-12)
    assert left.motor_torque.values == pytest.approx(-right.motor_torque.values, rel=1e-9, abs=1e-12)
    assert left.motor_power.values == pytest.approx(right.motor_power.values, rel=1e-9, abs=1e-12)


# Machines of other kinds


@pytest.mark.slow
def test_a_voltage_ramp() -> None:
    """Both models see the schedule: the drive's voltage grows over 10 s, and the speed with it, within O(epsilon)."""
    ramp = [{"parameter": "drive.no_load_speed", "points": [[0.0, 0.0], [4.0, 60.0]]}]
    result, summary = answer(drum(schedules=ramp), until=6.0, start=START, model="both")
    full, slow = result.speed.values[0], result.slow_speed.values[0]
    middle = result.sizes["time"] // 3  # at 2 s the drive asks for 30 rad/s
    assert 15 < full[middle] < 29
    assert 50 < full[-1] < 60
    assert np.abs(full - slow).max() < 0.02 * 60
    assert summary["slow"]["energy_residual"] < 1e-8
    assert slow[middle] == pytest.approx(full[middle], abs=0.3)


@pytest.mark.slow
def test_two_rollers_at_a_prescribed_speed() -> None:
    """000, Table 1 at 80 rad/s: the compensating phases 138.59 and 262.82 degrees, with both models."""
    machine = load_machine("sperling-rollers/figure-8")
    run, summary = answer(machine, until=70.0, model="both", start={"r1": "5 deg", "r2": "-5 deg"})
    for ended in (summary, summary["slow"]):
        assert ended["outcome"] == "compensated"
        degrees = {n: math.degrees(p) for n, p in ended["final_phases"].items()}
        assert degrees == {"r1": pytest.approx(138.59, abs=0.006), "r2": pytest.approx(262.82, abs=0.006)}
    rollers = ["r1", "r2"]  # the drive prescribes the rotor's speed
    apart = np.abs(run.speed.sel(body=rollers).values - run.slow_speed.sel(body=rollers).values).max()
    assert summary["deviations"]["at_equal_angle"]["speed"] == pytest.approx(apart, rel=1e-6)


def test_entrained_by_a_shaken_carrier() -> None:
    """001 (22): the averaged phase is -0.40799, that of the full equations -0.40856 (cases.md)."""
    result, summary = answer(load_machine("sperling-vibration/figure-2a"), until=40.0, model="both")
    assert summary["outcome"] == summary["slow"]["outcome"] == "entrained"
    phases = {model: (d["rotor_phases"]["vibration"] + math.pi) % (2 * math.pi) - math.pi for model, d in (
        ("full", summary), ("slow", summary["slow"]))}  # fmt: skip
    assert phases == {"full": pytest.approx(-0.40856, abs=2e-5), "slow": pytest.approx(-0.40799, abs=2e-5)}
    assert result.attrs["finished"] == 1


def test_a_moved_carrier_is_left_out_with_a_warning() -> None:
    machine = drum()
    quiet, _ = answer(machine, until=0.2, start=START, model="slow")
    moved, _ = answer(machine, until=0.2, start=START | {"carrier": {"x": 1e-3}}, model="slow")
    says = "the averaged equations have no free vibration of the carrier: its start is left out"
    assert says in moved.wucht.warnings
    assert says not in quiet.wucht.warnings
    assert moved.speed.values == pytest.approx(quiet.speed.values, rel=1e-12)


def test_order_2_is_nearer() -> None:
    """Table 3.1 at u = 1: away from the start's free vibration the next order is better by more than half."""
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 1.0})
    left = []
    for order in (1, 2):
        result, _ = answer(machine, until=2500.0, model="both", order=order)
        late = result.time.values > 1500
        mean = (result.speed.values[0] - result.slow_speed.values[0])[late].mean()
        left.append(abs(float(mean)))
    assert left[0] > 1e-5
    assert left[1] < 0.1 * left[0]


REFUSED: dict[str, tuple[str, dict[str, Any]]] = {
    "release": ("sperling-vibration/figure-4", {}),
    "slider": ("sperling-vibration/figure-7", {"start": {"disc": {"speed": 9.0}}}),
    "second order at rest": ("drozdetskaya-2020/r1-u40", {"order": 2}),
    "not damped": ("r2", {"inertia": False}),
}


@pytest.mark.parametrize("case", REFUSED)
def test_machines_that_are_refused(case: str) -> None:
    name, keys = REFUSED[case]
    machine = drum().with_values({"p1.damping": 0.0}) if name == "r2" else load_machine(name)
    check_refusal(f"run-up, averaged: {case}", lambda: answer(machine, **({"until": 1.0, "model": "slow"} | keys)))


def test_without_damping_the_inertia_is_kept() -> None:
    result, summary = answer(drum().with_values({"p1.damping": 0.0}), until=0.5, start=START, model="slow")
    assert result.end_state.size >= 5 + 2, "two phases, three speeds, the angle, and works"
    assert summary["energy_residual"] < 1e-8


# Many runs


# Interruption


def test_a_slow_run_that_fails_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    genuine = watched.integrate

    def failing(compiled: Any, *words: Any) -> Any:
        averaged = len(compiled.system.states) < len(drum().system.states)
        return replace(genuine(compiled, *words), failure="the step became too small" if averaged else None)

    monkeypatch.setattr(watched, "integrate", failing)
    result, summary = answer(drum(), until=0.2, start=START, model="both")
    assert "averaged equations: the step became too small" in result.wucht.warnings
    assert not result.attrs["failure"], "the full run did not fail"
    assert summary["slow"]["outcome"] == "failed"


@pytest.mark.parametrize("model", ["slow", "both"])
def test_a_run_that_is_stopped_is_continued(model: str, tmp_path: Path) -> None:
    """Of both models while the full one is under way, and while the slow one is: then the full one is there."""
    asked = {"until": 2.0, "start": START, "model": model}
    whole = answer(drum(), **asked)[0]
    for share in (0.3, 0.91):  # the full run is nine tenths of the work

        def stop(done: float, _what: str, share: float = share) -> None:
            if done > share:
                raise KeyboardInterrupt

        part = run(RunUp.from_table(asked), drum(), folder=tmp_path, resume=True, progress=stop)
        assert part.attrs["finished"] == 0 and ("slow_speed" in part) is (model == "both" and share > 0.9)
        assert any("interrupted" in w for w in part.wucht.warnings)
    assert_same(run(RunUp.from_table(asked), drum(), folder=tmp_path, resume=True), whole)
