"""Torque balance and response with balancing bodies in their steady phases: what the machine does, and not what it cannot."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from wucht import Response, RunUp, SynchronousStates, TorqueBalance, draw, report, run
from wucht.files.catalogue import load_machine


@pytest.fixture(scope="module")
def drum() -> xr.Dataset:
    return run(TorqueBalance(), load_machine("practice/laundry-drum"))


@pytest.fixture(scope="module")
def r1() -> xr.Dataset:
    return run(TorqueBalance(), load_machine("drozdetskaya-2020/r1"))


def stable_speeds(balance: xr.Dataset) -> list[float]:
    return [p["speed"] for p in balance.wucht.summary["working_points"] if p["stable"] and not p["overlapping"]]


@pytest.mark.slow
def test_the_laundry_drum_runs_where_it_runs_up_to(drum: xr.Dataset) -> None:
    """126.1 rad/s, and not the 115.8 rad/s of balls that are all in the place where they add up."""
    assert stable_speeds(drum) == pytest.approx([126.1687], rel=1e-6)
    assert drum.wucht.summary["sentence"].startswith("one working point, stable: compensating")


@pytest.mark.slow
def test_the_run_up_of_the_laundry_drum_settles_there(drum: xr.Dataset) -> None:
    machine = load_machine("practice/laundry-drum")
    start = {f"b{i + 1}": angle for i, angle in enumerate(np.radians([0, 60, 120, 180, 240, 300]))}
    final = run(RunUp(settled=True, start=start), machine).wucht.summary
    assert final["outcome"] == "compensated"
    assert stable_speeds(drum) == pytest.approx([final["final_speed"]], rel=1e-3)


def test_the_run_up_of_r1_settles_there(r1: xr.Dataset) -> None:
    machine = load_machine("drozdetskaya-2020/r1-u80")
    final = run(RunUp(until=10.0, start={"p1": 2.5, "p2": -2.3}), machine).wucht.summary
    assert final["outcome"] == "compensated"
    assert stable_speeds(r1) == pytest.approx([final["final_speed"]], rel=1e-4)


def test_working_points_are_the_synchronous_states(r1: xr.Dataset) -> None:
    states = run(SynchronousStates(full=False), load_machine("drozdetskaya-2020/r1")).wucht.summary["states"]
    points = r1.wucht.summary["working_points"]
    assert [p["speed"] for p in points] == pytest.approx(sorted(s["speed"] for s in states), rel=1e-12)
    by_speed = sorted(states, key=lambda s: s["speed"])
    assert [p["stable"] for p in points] == [s["stable_slow"] for s in by_speed]
    for point, state in zip(points, by_speed, strict=True):
        assert point["phases"] == pytest.approx(state["phases"], abs=1e-9)
    assert [p["configuration"] for p in points] == ["together, heavy side", "together, light side", "opposed", "compensating"]


def test_each_point_lies_on_the_curve_of_its_configuration(r1: xr.Dataset) -> None:
    for p in r1.wucht.summary["working_points"]:
        on = r1.surplus_torque.values[r1.configuration_name.values == p["configuration"]]
        change = [np.diff(np.sign(curve)) for curve in on]
        crossing = [r1.speed.values[np.flatnonzero(np.nan_to_num(c))] for c in change]
        nearest = np.abs(np.concatenate(crossing) - p["speed"]).min()
        assert nearest < 0.5, p["configuration"]


def test_the_response_of_stable_bodies() -> None:
    result = run(Response(), load_machine("drozdetskaya-2020/r1"))
    s = result.wucht.summary
    assert s["amplitude_at_free_speed"] == 0.0
    assert s["configurations_at_free_speed"] == ["compensating"]
    assert "bodies stable there: compensating" in s["sentence"]
    stable = np.where(result.stable.values, result.amplitude.values, 0.0)
    assert s["peak_amplitude"] == np.nanmax(stable)
    at = np.unravel_index(np.nanargmax(stable), stable.shape)[1]
    assert (s["peak_speed"], s["peak_speed"]) == (result.speed.values[at], pytest.approx(77.345, abs=1e-2))
    held = run(Response(bodies="held"), load_machine("drozdetskaya-2020/r1")).wucht.summary
    assert held["peak_amplitude"] > 2 * s["peak_amplitude"]
    assert len(draw(result).axes) == 4
    assert " in stable steady phases" in "\n".join(report(result))


def test_the_torque_on_bodies_in_steady_phases_is_zero() -> None:
    """It is what makes them stay: the rotor alone feels the vibration."""
    machine = load_machine("practice/exciter")
    result = run(Response(), machine)
    exists = np.isfinite(result.vibration_torque.values)
    on = dict(zip(map(str, result.body.values), np.moveaxis(result.torque_on_body.values, 1, 0), strict=True))
    whole = np.nanmax(result.vibration_torque.values)
    assert on["pendulum" if "pendulum" in on else list(on)[1]][exists] == pytest.approx(0, abs=1e-9 * whole)
    assert on[machine.rotor.name][exists] == pytest.approx(result.vibration_torque.values[exists], abs=1e-9 * whole)


def test_machines_without_known_phases_are_held_and_it_is_said() -> None:
    switchable = load_machine("practice/laundry-drum-switchable")
    result = run(TorqueBalance(), switchable)
    assert result.wucht.summary["bodies"] == "held"
    assert "balancing bodies are held, as their steady phases are not computed" in result.attrs["warnings"]
    with refused("study.bodies", "held", given="steady", code="slider"):
        run(TorqueBalance(bodies="steady"), switchable)
