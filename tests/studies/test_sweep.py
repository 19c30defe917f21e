"""The study ``sweep``: jumps that do not depend on the rate, and sweeps that end early or do not jump."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht.errors import InputError
from wucht.machines.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import compile_system
from wucht.results.store import load, save
from wucht.studies.sweep import Sweep, sweep
from wucht.studies.sweep.flow import Mover, moving_system, with_value

OMEGA_1 = "drive.no_load_speed"
FIGURE_5 = "sperling-vibration/figure-5"


@pytest.fixture(scope="module")
def machine() -> Machine:
    return load_machine(FIGURE_5, {"rotor.inertia": 1e-5})  # a light rotor, which ripples most


def summary(result: xr.Dataset) -> dict[str, Any]:
    found = json.loads(result.attrs["summary"])
    assert isinstance(found, dict)
    return found


def warnings(result: xr.Dataset) -> list[str]:
    found: list[str] = json.loads(result.attrs["warnings"])
    return found


@pytest.fixture(scope="module")
def both(machine: Machine) -> xr.Dataset:
    return sweep(machine, Sweep(OMEGA_1, (5.0, 12.0)))


def test_both_ways_are_stored(both: xr.Dataset) -> None:
    assert list(both.direction.values) == ["up", "down"]
    up, down = both.sel(direction="up"), both.sel(direction="down")
    assert (np.diff(up.value) > 0).all()
    assert (np.diff(down.value) < 0).all()
    assert both.sizes["sample"] == 400
    for name in ("value", "speed", "amplitude", "energy_residual"):
        assert np.isfinite(both[name]).all(), name
        assert both[name].attrs["long_name"]
    assert both.attrs["finished"] == 1


def test_the_branches_part_only_between_the_jumps(both: xr.Dataset) -> None:
    low, high = summary(both)["hysteresis"]
    up, down = both.sel(direction="up"), both.sel(direction="down")
    apart = np.abs(up.speed.values - np.interp(up.value, down.value[::-1], down.speed[::-1]))
    inside = (up.value.values > low) & (up.value.values < high)
    assert apart[inside].min() > 1.0
    outside = (up.value.values < low - 0.15) | (up.value.values > high + 0.15)
    assert apart[outside].max() < 0.01


@pytest.mark.parametrize("rate", [0.5, 0.05])
def test_the_jump_does_not_depend_on_the_rate(machine: Machine, both: xr.Dataset, rate: float) -> None:
    """The ramp itself jumps late: at 0.05 (rad/s)/s by more than 0.2 rad/s. What is found is the fold all the same."""
    expected, found = summary(both)["jumps"][0], sweep(machine, Sweep(OMEGA_1, (5.0, 12.0), rate, "up"))
    (jump,) = summary(found)["jumps"]
    assert jump[OMEGA_1] == pytest.approx(expected[OMEGA_1], rel=1e-4)
    for key in ("from_speed", "to_speed"):  # next to the fold the speed changes with the root of the distance
        assert jump[key] == pytest.approx(expected[key], rel=1e-3)
    one = found.isel(direction=0)
    late = one.value.values[int(np.flatnonzero(one.speed.values > 7.8)[0])]
    assert late > expected[OMEGA_1] + 0.2


def test_the_bracket_is_as_narrow_as_asked(machine: Machine) -> None:
    (jump,) = summary(sweep(machine, Sweep(OMEGA_1, (9.0, 10.5), 0.01, "up", jump_tolerance=1e-5)))["jumps"]
    low, high = jump["bracket"]
    assert 0 < high - low <= 1.001e-5 * high
    assert low - (high - low) <= jump[OMEGA_1] <= high + (high - low)
    assert jump["fold"]
    assert jump[OMEGA_1] == pytest.approx(9.82982, rel=3e-6)  # 9.829820 at a tolerance of 1e-6


def test_down_alone_begins_at_the_upper_end(machine: Machine) -> None:
    found = sweep(machine, Sweep(OMEGA_1, (8.0, 12.0), 0.02, "down"))
    assert float(found.value[0, 0]) > 11.9
    (jump,) = summary(found)["jumps"]
    assert jump["direction"] == "down"
    assert jump[OMEGA_1] == pytest.approx(8.8997, rel=1e-4)
    assert summary(found)["hysteresis"] is None


def test_a_strong_drive_does_not_jump(machine: Machine) -> None:
    found = sweep(with_value(machine, "drive.slope", 2e-4), Sweep(OMEGA_1, (5.0, 8.0), 0.02))
    assert summary(found)["jumps"] == []
    assert "no jump" in found.attrs["sentence"]


def test_steep_is_no_jump(machine: Machine) -> None:
    """Just beyond the cusp the curve is nearly vertical, but both ways agree."""
    found = sweep(with_value(machine, "carrier.damping", 2.2), Sweep(OMEGA_1, (6.0, 11.0), 0.01))
    assert summary(found)["jumps"] == []


def test_another_parameter_of_a_dimensionless_machine() -> None:
    """002, Table 3.1: the folds of the Laval rotor are at twice the u of the carrier with one direction (cases.md)."""
    found = sweep(load_machine("drozdetskaya-2020/table-3.1-laval"), Sweep("u", (1.0, 7.0), 2e-4))
    assert summary(found)["rate_unit"] == "a unit of time"
    up, down = summary(found)["jumps"]
    assert up["u"] == pytest.approx(2 * 2.6053860, rel=1e-4)
    assert up["from_speed"] == pytest.approx(1.0213376, rel=2e-4)
    assert down["u"] == pytest.approx(2 * 0.8937191, rel=1e-4)
    assert down["from_speed"] == pytest.approx(1.4239669, rel=1e-3)


def test_a_sweep_that_is_too_fast_says_so(machine: Machine) -> None:
    found = sweep(machine, Sweep(OMEGA_1, (5.0, 12.0), 1.0, "up"))
    (said,) = [w for w in warnings(found) if "too fast" in w]
    assert said.endswith("give a rate below 1 rad/s per s")


@pytest.mark.parametrize("start", [{}, {"rotor": {"speed": "8 rad/s"}}])
def test_a_standstill_is_settled(machine: Machine, start: dict[str, Any]) -> None:
    """What is left of a speed that dies away is small beside the speeds of the sweep, not beside itself."""
    found = sweep(machine, Sweep(OMEGA_1, (0.0, 12.0), start=start))
    assert float(found.speed.sel(direction="down")[-1]) < 0.25  # averaged before the end of the ramp
    assert warnings(found) == []


@pytest.mark.parametrize("count", [1, 60])
def test_an_interrupted_sweep_is_a_valid_result(machine: Machine, count: int) -> None:
    calls = iter(range(1, 10**9))

    def progress(_done: float, _goal: float) -> None:
        if next(calls) == count:
            raise KeyboardInterrupt

    found = sweep(machine, Sweep(OMEGA_1, (5.0, 12.0)), progress)
    assert found.attrs["finished"] == 0
    assert any("interrupted" in w for w in warnings(found))
    assert found.sizes["direction"] == (0 if count == 1 else 1)


@pytest.mark.parametrize("question", [Sweep(OMEGA_1, (9.0, 10.5), 0.02, "up"), Sweep(OMEGA_1, (9.0, 10.5), 0.02)])
def test_an_interrupted_search_for_jumps_is_a_valid_result(machine: Machine, question: Sweep) -> None:
    calls = iter(range(1, 10**9))

    def progress(done: float, _goal: float) -> None:
        if done >= 1 and next(calls) == 20:
            raise KeyboardInterrupt

    found = sweep(machine, question, progress)
    assert found.attrs["finished"] == 0
    assert summary(found)["jumps"] == []
    assert list(found.direction.values) == ["up"]
    assert np.isfinite(found.speed).all()


@pytest.fixture(scope="module")
def there_and_back(machine: Machine) -> tuple[Sweep, xr.Dataset, int]:
    """A quick sweep, what comes of it, and how often it asks whether to stop."""
    asked, question = 0, Sweep(OMEGA_1, (8.0, 10.5), 0.02)

    def count(_done: float, _goal: float) -> None:
        nonlocal asked
        asked += 1

    return question, sweep(machine, question, count), asked


@pytest.mark.parametrize("share", [0.0, 0.02, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 0.999])
def test_resumed_it_is_the_uninterrupted_one(
    machine: Machine, there_and_back: tuple[Sweep, xr.Dataset, int], tmp_path: Path, share: float
) -> None:
    """From the file, to the last bit: stopped while settling, on either way, or while jumps are looked for."""
    question, whole, asked = there_and_back
    assert len(summary(whole)["jumps"]) == 2
    calls = iter(range(10**9))

    def stop(_done: float, _goal: float) -> None:
        if next(calls) == int(share * asked):
            raise KeyboardInterrupt

    broken = sweep(machine, question, stop)
    assert broken.attrs["finished"] == 0
    save(broken, tmp_path / "result.nc")
    again = sweep(machine, question, resume=load(tmp_path / "result.nc"))
    for name in whole.variables:
        assert again[name].equals(whole[name]), name
    assert again.attrs["summary"] == whole.attrs["summary"]
    assert warnings(again) == warnings(whole)
    assert again.attrs["finished"] == 1


def test_broken_off_again_and_again(machine: Machine, there_and_back: tuple[Sweep, xr.Dataset, int], tmp_path: Path) -> None:
    """Also within the search for jumps, which is then begun again and must leave no trace."""
    question, whole, asked = there_and_back
    found: xr.Dataset | None = None
    for share in (0.3, 0.15, 0.1, 0.2, 0.05):
        calls = iter(range(10**9))

        def stop(_done: float, _goal: float, calls: Iterator[int] = calls, after: int = int(share * asked)) -> None:
            if next(calls) == after:
                raise KeyboardInterrupt

        found = sweep(machine, question, stop, resume=found)
        save(found, tmp_path / "result.nc")
        found = load(tmp_path / "result.nc")
    again = sweep(machine, question, resume=found)
    assert again.attrs["jumps_found"] == whole.attrs["jumps_found"]
    assert again.attrs["energies"] == whole.attrs["energies"]
    assert all(again[name].equals(whole[name]) for name in whole.variables)


def test_legs_that_were_made_are_not_made_again(machine: Machine, there_and_back: tuple[Sweep, xr.Dataset, int]) -> None:
    question, whole, _ = there_and_back
    seen: list[float] = []
    again = sweep(machine, question, lambda done, _: seen.append(done), resume=whole)
    assert set(seen) == {2.0}, "it settles at the end once more"
    assert again.attrs["summary"] == whole.attrs["summary"]


def test_only_the_same_sweep_is_resumed(machine: Machine, there_and_back: tuple[Sweep, xr.Dataset, int]) -> None:
    question, whole, _ = there_and_back
    with pytest.raises(InputError, match="--resume: the result in the output folder is of another machine or sweep"):
        sweep(machine, replace(question, rate=0.03), resume=whole)


def test_a_long_leg_asks_often_whether_to_stop(machine: Machine) -> None:
    flow, asked = compile_system(moving_system(machine, OMEGA_1)), list[float]()
    mover = Mover(machine, OMEGA_1, flow, 10.0, asked.append)
    place, _ = mover.leg(mover.begin(5.0, np.zeros(len(flow.system.states))), 5000.0)
    assert place.time == asked[-1] == 5000.0
    assert max(np.diff([0.0, *asked])) * 10.0 <= 201 * 2 * math.pi


def test_progress_grows(machine: Machine) -> None:
    seen: list[float] = []
    sweep(machine, Sweep(OMEGA_1, (5.0, 6.0), 0.05), lambda done, goal: seen.append(done / goal))
    assert seen[0] == 0
    assert (np.diff(seen) >= 0).all()
    assert seen[-1] == 1.0


def test_scipy_finds_the_same(machine: Machine) -> None:
    found = sweep(machine, Sweep(OMEGA_1, (9.0, 10.6), 0.02, "up", jump_tolerance=1e-3, tolerance=1e-8, engine="scipy"))
    (jump,) = summary(found)["jumps"]
    assert jump[OMEGA_1] == pytest.approx(9.8298, rel=1e-3)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ({"range": [5, 12]}, "along"),
        ({"along": "drive.no_load_spede", "range": [5, 12]}, "drive.no_load_speed"),
        ({"along": OMEGA_1}, "range"),
        ({"along": OMEGA_1, "range": [12, 5]}, "low below high"),
        ({"along": OMEGA_1, "range": ["5 kg", "12 kg"]}, "rad/s"),
        (
            {"along": OMEGA_1, "range": [5, 12], "rate": -1},
            "allowed is a rate of the no-load speed greater than 0, in rad/s per s",
        ),
        ({"along": OMEGA_1, "range": [5, 12], "rate": 1e-30}, "study.rate: .*allowed is a rate from .* turns a ramp"),
        ({"along": OMEGA_1, "range": [5, 12], "rate": 1e30}, "study.rate: .* to 44 rad/s per s: .* a tenth of the time"),
        ({"along": OMEGA_1, "range": [5, 12], "direction": "sideways"}, "both"),
        ({"along": OMEGA_1, "range": [5, 12], "engine": "magic"}, "heyoka"),
        ({"along": OMEGA_1, "range": [5, 12], "jump_tolerance": 1}, "between"),
        ({"along": OMEGA_1, "range": [5, 12], "untill": 1}, "unknown key"),
        ({"along": "rotor.mass", "range": [-1, 1]}, "greater than 0"),
        ({"along": "rotor.inertia", "range": [1e-9, 1]}, "m e^2"),
        ({"along": OMEGA_1, "range": [5, 12], "start": {"roter": 1}}, "rotor"),
    ],
)
def test_bad_questions(machine: Machine, table: dict[str, Any], says: str) -> None:
    def ask() -> None:
        question = Sweep.read({"kind": "sweep"} | table, machine)
        question.check(machine)

    refused: Callable[[], None] = ask
    with pytest.raises(InputError, match=says.replace("^", r"\^")):
        refused()


def test_the_rate_may_have_a_unit(machine: Machine) -> None:
    asked = Sweep.read({"along": OMEGA_1, "range": ["5 rad/s", "12 rad/s"], "rate": "0.1 rad/s^2"}, machine)
    assert asked.rate == pytest.approx(0.1)
    slope = Sweep.read({"along": "drive.slope", "range": [1e-5, 1e-4], "rate": "1e-6 N m"}, machine)
    assert slope.rate == pytest.approx(1e-6)
