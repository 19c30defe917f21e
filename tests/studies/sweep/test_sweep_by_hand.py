"""A sweep whose legs and jumps are made by hand: each number of its Dataset and summary, and what is said of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht.dynamics.sweeps.jumps import Jump
from wucht.dynamics.sweeps.moving import SweepLeg
from wucht.files.catalogue import load_machine
from wucht.studies.sweep import computation
from wucht.studies.sweep import figure as figure_module
from wucht.studies.sweep.computation import Findings, Plan, prepare
from wucht.studies.sweep.dataset import dataset
from wucht.studies.sweep.spec import Sweep

ALONG = "drive.no_load_speed"
UP = Jump(10.5, 7.0, 9.0, "up", 3e-3, 1e-3, True, False, (10.4, 10.6))
DOWN = Jump(9.5, -8.0, -6.0, "down", 2e-3, 4e-3, False, True, (9.4, 9.6))


def leg(value: float, speed: float, amplitude: float, residual: float) -> SweepLeg:
    place: Any = None
    return SweepLeg(place, value, speed, speed - 0.5, speed + 0.25, amplitude, residual)


RAMPS = {
    "up": (leg(8.5, 5.0, 1e-3, 1e-9), leg(9.5, 6.0, 5e-3, 3e-9)),
    "down": (leg(10.5, 9.0, 2e-3, 2e-9),),
}


@pytest.fixture(scope="module")
def plan() -> Plan:
    made = prepare(
        Sweep(along=ALONG, range=(8.0, 11.0), rate=0.01, jump_tolerance=1e-3), load_machine("sperling-vibration/figure-5")
    )
    moved = made.moved_machine
    return replace(made, moved_machine=replace(moved, pace=replace(moved.pace, samples=3)))


@pytest.fixture(scope="module")
def result(plan: Plan) -> xr.Dataset:
    return dataset(plan, Findings("compiled", ("a doubt",), RAMPS, (UP, DOWN), None, True))


def test_readings_of_each_ramp_stand_beside_each_other(result: xr.Dataset) -> None:
    nan = float("nan")
    expected = {
        "value": [[8.5, 9.5, nan], [10.5, nan, nan]],
        "speed": [[5.0, 6.0, nan], [9.0, nan, nan]],
        "min_speed": [[4.5, 5.5, nan], [8.5, nan, nan]],
        "max_speed": [[5.25, 6.25, nan], [9.25, nan, nan]],
        "amplitude": [[1e-3, 5e-3, nan], [2e-3, nan, nan]],
        "energy_residual": [[1e-9, 3e-9, nan], [2e-9, nan, nan]],
    }
    for name, rows in expected.items():
        assert result[name].dims == ("direction", "sample")
        assert result[name].values == pytest.approx(np.array(rows), nan_ok=True), name
    assert result.direction.values.tolist() == ["up", "down"]


def test_the_numbers_of_the_summary(result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert (s["peak_amplitude"], s["energy_residual"], s["hysteresis"]) == (5e-3, 3e-9, [9.5, 10.5])
    assert s["ends"] == {"up": {"from_speed": 5.0, "to_speed": 6.0}, "down": {"from_speed": 9.0, "to_speed": 9.0}}
    assert s["range"] == [8.0, 11.0] and (s["rate"], s["rate_chosen"], s["jump_tolerance"]) == (0.01, False, 1e-3)
    assert s["jumps"][0] == {
        ALONG: 10.5, "from_speed": 7.0, "to_speed": 9.0, "direction": "up", "from_amplitude": 3e-3, "to_amplitude": 1e-3,
        "fold": True, "only_seen": False, "bracket": [10.4, 10.6],
    }  # fmt: skip


def test_jumps_are_variables_too(result: xr.Dataset) -> None:
    columns = ("value", "from", "to", "from_amplitude", "to_amplitude", "upward")
    assert {n: result[f"jump_{n}"].values.tolist() for n in columns} == {
        "value": [10.5, 9.5], "from": [7.0, -8.0], "to": [9.0, -6.0], "from_amplitude": [3e-3, 2e-3],
        "to_amplitude": [1e-3, 4e-3], "upward": [1, 0],
    }  # fmt: skip


def test_the_free_speed_over_the_range_is_that_of_the_drive(result: xr.Dataset) -> None:
    """A machine without bearings and load: where the no-load speed is swept, it is the speed without vibration."""
    assert result.grid.values == pytest.approx(np.linspace(8.0, 11.0, 21))
    assert result.free_speed.values == pytest.approx(result.grid.values, rel=1e-2)
    assert np.diff(result.free_speed.values) == pytest.approx(np.full(20, 0.15), rel=2e-2)


def test_sentences_and_warnings_by_what_came_of_it(plan: Plan, result: xr.Dataset) -> None:
    def told(**other: Any) -> tuple[str, list[str]]:
        made = dataset(plan, replace(Findings("compiled", (), RAMPS, (UP,), None, True), **other))
        return made.wucht.summary["sentence"], made.wucht.warnings

    jumps = result.wucht.summary["sentence"].split("; ")
    assert [("10.5" in jumps[0], "rising the speed jumps from 7 to 9" in jumps[0])] == [(True, True)]
    assert "9.5" in jumps[1] and jumps[1].endswith("falling the speed jumps from -8 to -6")
    assert result.wucht.warnings[0] == "a doubt" and len(result.wucht.warnings) == 2
    assert "the jump near 9.5 is only known to lie between 9.4 and 9.6" in result.wucht.warnings[1]
    level = replace(UP, to_speed=7.0 * (1 + 5e-5))
    assert told(jumps=(level,))[0].endswith("the amplitude jumps from 0.003 to 0.001")
    assert told(jumps=(replace(UP, to_speed=7.0 * (1 + 2e-4)),))[0].endswith("the speed jumps from 7 to 7.0014")
    assert told() == (told()[0], [])
    calm, none = told(jumps=())
    assert calm.startswith("no jump: the machine follows") and calm.endswith("between 8 and 11") and none == []
    assert told(failure="it burst", complete=False) == ("the sweep failed", ["it burst"])
    assert told(complete=False) == ("the sweep was interrupted", ["the sweep is not finished: jumps may be missing"])


def test_before_the_first_leg_there_are_no_readings(plan: Plan) -> None:
    made = dataset(plan, Findings("compiled", ()))
    s = made.wucht.summary
    assert made.speed.shape == (0, 3) and made.direction.shape == (0,)
    assert (s["peak_amplitude"], s["energy_residual"], s["hysteresis"], s["ends"], s["jumps"]) == (None, None, None, {}, [])


@pytest.mark.parametrize(
    ("way", "ends", "first"),
    [
        ("both", {"up": (8.0, 11.0), "down": (11.0, 8.0)}, 8.0),
        ("up", {"up": (8.0, 11.0)}, 8.0),
        ("down", {"down": (11.0, 8.0)}, 11.0),
    ],
)
def test_a_ramp_goes_from_its_first_value_to_its_last(way: Any, ends: dict[str, tuple[float, float]], first: float) -> None:
    made = prepare(Sweep(along=ALONG, range=(8.0, 11.0), rate=0.01, direction=way), load_machine("sperling-vibration/figure-5"))
    assert made.ways == ends and list(made.ways) == list(ends)
    assert made.moved_machine.machine.values[ALONG] == first


def test_a_doubt_names_the_time_and_the_speed(plan: Plan) -> None:
    still = leg(8.0, 5.0, 1e-3, 0.0)
    (unsettled,) = computation._doubts(plan, still, False, "before the sweep")
    assert unsettled == "the machine did not settle before the sweep: its speed was still changing at 5 rad/s"
    before = replace(still, speed=5.06, low=5.06, high=5.06)
    (fast,) = computation._doubts(plan, still, True, "after the ramp up", [before])
    assert "the speed still changed from 5.06 to 5 rad/s" in fast and "below 0.01 rad/s per s" in fast
    assert computation._doubts(plan, still, True, "", [replace(before, speed=5.04)]) == ()
    modulated = replace(before, low=5.0, high=5.2)
    assert computation._doubts(plan, still, True, "", [modulated]) == (), "what swings is at no time at its mean"
    fastest = replace(still, speed=-600.0)
    assert computation._doubts(plan, still, True, "", [fastest, before]) == (), "small beside the largest speed"


def test_legs_up_to_the_one_that_fails_are_kept() -> None:
    class Walker:
        def leg(self, place: Any, step: float, value: float) -> SweepLeg:
            if value > 2.5:
                raise computation.IntegrationError("burst")
            return SweepLeg((place or 0) + 1, value, step, 0.0, 0.0, 0.0, 0.0)  # type: ignore[arg-type]

    walker: Any = Walker()
    legs, failure = computation._legs(walker, None, 0.5, [1.0, 2.0, 3.0, 4.0])  # type: ignore[arg-type]
    assert ([x.value for x in legs], [x.place for x in legs], failure) == ([1.0, 2.0], [1, 2], "burst")
    assert computation._legs(walker, None, 0.5, [1.0])[1] is None  # type: ignore[arg-type]


def test_the_subtitle_names_two_jumps_at_most(result: xr.Dataset) -> None:
    made = result.assign_attrs(finished=1)
    words = figure_module._parameter_words(made)
    assert figure_module._subtitle(made) == f"it jumps at {words} = 10.5 rad/s (rising) and 9.5 rad/s (falling)"
    assert figure_module._subtitle(result.assign_attrs(finished=0)) == result.attrs["sentence"]
