"""Of a motion as much is stored as its own speed asks, whatever speed the drive would reach; and no more than there is room."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht import RunUp
from wucht.dynamics.run_ups.horizon import Horizon, numbers_per_sample
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.studies.runner import run

DOWN = {"r": -math.pi / 2}


def captured_rotor(bearing_damping: float) -> Machine:
    """Its torque does not depend on its speed; without vibration the loss in the bearing alone would hold it."""
    rotor = {"kind": "rotor", "name": "r", "mass": 0.096, "eccentricity": 0.0592, "inertia": 5.5394e-4}
    return machine_from({
        "carrier": {"mass": 1.3608, "directions": "x", "stiffness": 186.3, "damping": 0.659},
        "bodies": [rotor | {"bearing_damping": bearing_damping}],
        "drive": {"kind": "constant-torque", "torque": 6.4e-3},
    })  # fmt: skip


def fewest_a_turn(result: xr.Dataset) -> float:
    speed, time = np.abs(result.speed.values[0]), result.time.values
    return 2 * math.pi / float((np.diff(time) * np.maximum(speed[1:], speed[:-1])).max())


@pytest.mark.parametrize("bearing_damping", [1e-6, 1e-8, 1e-9])
def test_a_speed_that_is_never_reached_does_not_matter(bearing_damping: float) -> None:
    """It would be 6.4 million rad/s, and the rotor is held at 10.9; without the loss at 10.8833."""
    result = run(RunUp(start=DOWN), captured_rotor(bearing_damping))
    summary = result.wucht.summary
    assert summary["free_speed"] == pytest.approx(6.4e-3 / bearing_damping)
    assert summary["outcome"] == "captured"
    assert summary["final_speed"] == pytest.approx(10.8833, abs=1e-3)
    assert result.sizes["time"] < 100_000
    assert fewest_a_turn(result) > 12
    assert not any("samples a turn" in w for w in result.wucht.warnings)


def fast(no_load_speed: float) -> Machine:
    rotor = {"kind": "rotor", "name": "r", "mass": 0.1, "unbalance": 1e-7, "inertia": 1e-6}
    return machine_from({
        "carrier": {"stiffness": 1e4, "damping": 20.0, "mass": 1.0},
        "bodies": [rotor],
        "drive": {"kind": "linear", "slope": 1e-5, "no_load_speed": no_load_speed},
    })  # fmt: skip


def test_a_speed_beyond_what_is_expected_is_stored_as_densely() -> None:
    """30,000 rad/s are more than twenty times any frequency of the machine."""
    result = run(RunUp(until=0.5), fast(3e4))
    assert result.wucht.summary["final_speed"] == pytest.approx(3e4, rel=0.01)
    assert fewest_a_turn(result) > 12


def horizon(machine: Machine, **asked: Any) -> Horizon:
    return Horizon.of(machine, RunUp(**asked).settings, initial_state(machine, {}))


def test_what_is_stored_is_bounded_whatever_is_asked() -> None:
    machine = fast(200.0)
    most, starts = horizon(machine, until=1e9).most, [{"r": 0.1 * k} for k in range(100)]
    assert 2e7 < 8 * most * numbers_per_sample(machine) < 5e7  # bytes of a run that is not stored whole
    assert horizon(machine, until=1e9, starts=starts).most == 5 * most // 100
    for asked in ({"until": 1e9}, {"settled": True}):
        bounds = horizon(machine, **asked)
        legs, done = list(bounds.legs(lambda: 1e9)), 0
        for leg in legs:
            assert len(leg.samples) <= max(2049, done // 16 + 2)
            done += len(leg.samples) - 1
            assert leg.closest >= leg.samples[-1] / bounds.most * (1 - 1e-9)


def test_a_given_speed_is_stored_and_seen_as_densely_as_one_that_is_reached() -> None:
    """On a carrier so soft that nothing but the rotor is fast."""
    soft = {"mass": 1e5, "stiffness": 1e5, "damping": 10.0}
    body = {"kind": "rotor", "name": "r", "mass": 2.0, "unbalance": 0.03, "inertia": 0.05}
    machine = machine_from({"carrier": soft, "bodies": [body], "drive": {"kind": "constant-speed", "speed": 60.0}})
    assert fewest_a_turn(run(RunUp(until=1.0), machine)) > 12


def test_a_motion_that_is_stored_coarsely_has_its_limits() -> None:
    """Of the same motion once all samples and once 300: the limits hold for all of it, and are those that it reaches."""
    fine, coarse = (run(RunUp(until=60.0, start=DOWN, stored_samples=count), captured_rotor(1e-6)) for count in (None, 300))
    assert "least_speed" not in fine
    assert coarse.sizes["time"] <= 301 < fine.sizes["time"]
    assert coarse.wucht.summary["final_speed"] == pytest.approx(fine.wucht.summary["final_speed"], rel=1e-6)
    for name in ("min_speed", "max_speed", "final_amplitude", "min_amplitude", "max_amplitude"):
        assert coarse.wucht.summary[name] == pytest.approx(fine.wucht.summary[name], rel=1e-2)
    (warning,) = (w for w in coarse.wucht.warnings if "samples a turn" in w)
    assert "least_radius" in warning
    assert "study.stored_samples" in warning
    span = np.minimum(np.searchsorted(coarse.span_end.values, fine.time.values), coarse.sizes["span"] - 1)
    for name, whole in (("speed", fine.speed.values[0]), ("radius", fine.radius.values)):
        low, high = coarse[f"least_{name}"].values, coarse[f"greatest_{name}"].values
        room = 2e-2 * np.ptp(whole)  # twelve samples of a span are observed, here two turns
        assert (low[span] <= whole + room).all()
        assert (whole <= high[span] + room).all()
        assert low.min() == pytest.approx(whole.min(), abs=room)
        assert high.max() == pytest.approx(whole.max(), abs=room)
