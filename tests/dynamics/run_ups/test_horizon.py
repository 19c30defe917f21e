"""How far a run goes and how densely it is sampled, by what may happen in it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.horizon import (
    SAMPLES_PER_TURN,
    Horizon,
    RunSettings,
)
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from


def driven(speed: float, **more: Any) -> Any:
    return machine_from(
        {
            "carrier": {"directions": "x", "stiffness": 4e4, "damping": 10.0},
            "bodies": [{"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": 0.01, "inertia": 0.1}],
            "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": speed},
        }
        | more
    )


def horizon(machine: Any, start: dict[str, Any] | None = None, **settings: Any) -> Horizon:
    return Horizon.of(machine, RunSettings(**settings), initial_state(machine, start or {}))


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("turns", "short"), [(9.9, True), (10.1, False)])
def test_less_than_ten_turns_are_no_verdict(sense: int, turns: float, short: bool) -> None:
    """The warning states the time of ten turns."""
    warnings = horizon(driven(sense * 200.0), until=turns * 2 * math.pi / 200.0).warnings
    assert len(warnings) == short and (not short or f"({20 * math.pi / 200:.3g} s)" in warnings[0])


def test_a_run_that_cannot_be_stored_whole_has_a_fifth_of_the_samples() -> None:
    """Its limits are stored apart; just below that it is stored whole. Several runs share what there is, as before."""
    machine = driven(200.0)
    most = horizon(machine, turns=1.0).most
    turns = most / SAMPLES_PER_TURN
    assert horizon(machine, turns=0.99 * turns).most == most
    long = horizon(machine, turns=1.01 * turns)
    assert long.most == most // 5 and long.first / long.step == pytest.approx(most / 5, rel=1e-3)
    assert horizon(machine, turns=turns, runs=10).most == most // 10
    assert horizon(machine, turns=2 * turns, stored_samples=most).most == most


@pytest.mark.parametrize("points", [3, 2001])
def test_many_points_of_a_schedule_count_by_their_greatest_value(points: int) -> None:
    """Also where only one point of many has it."""
    times, speeds = np.linspace(0.0, 1.0, points), np.full(points, 200.0)
    speeds[1] = 300.0
    schedule = {"parameter": "drive.no_load_speed", "points": np.stack([times, speeds], axis=1).tolist()}
    turn = 2 * math.pi / 300.0
    assert horizon(driven(200.0, schedules=[schedule]), until=100 * turn).step == pytest.approx(
        turn / SAMPLES_PER_TURN, rel=1e-3
    )


def test_a_run_without_end_doubles_until_25000_turns() -> None:
    """Eight doublings of 100 turns; and each keeps half as many samples again as fit, where fewer do."""
    machine = driven(200.0)
    open_ended, ended = horizon(machine), horizon(machine, until=1.0)
    assert open_ended.samples == pytest.approx(open_ended.first / open_ended.step * 2 ** math.log2(250), rel=1e-9)
    assert ended.samples == pytest.approx(1.0 / ended.step)
    few = horizon(machine, stored_samples=1000)
    assert few.samples == pytest.approx(1000 * (1 + math.log2(250) / 2))


@pytest.mark.parametrize(("slower", "doublings"), [(9.7, 8), (9.8, 7), (15.0, 7), (700.0, 1), (2000.0, 1)])
def test_a_slow_machine_is_doubled_less_often(slower: float, doublings: int) -> None:
    """The first leg is 20 turns of the slowest motion, at most 20,000 of the fastest: 25,000 of these are not far exceeded.

    195.3 is 25,000 over 2^7: a first leg of 20 x 9.77 turns has one doubling less.
    """
    of = horizon(driven(100.0 / slower))
    fast = min(slower, 1000.0)
    assert of.first / of.turn == pytest.approx(max(100.0, 20 * fast), rel=1e-3)
    assert of.longest == pytest.approx(of.first * 2**doublings)
    assert 25_000 <= of.longest / of.turn < 50_000
    *_, last = of.legs()
    assert last.samples[-1] == last.end == pytest.approx(of.longest)


@pytest.mark.parametrize("speed", [50.0, -50.0, 500.0])
def test_time_scales_of_a_run(speed: float) -> None:
    """The natural frequency is 100 rad/s: the faster of both sets the step and the span, the slower one the first leg."""
    of, fast, slow = horizon(driven(speed)), max(100.0, abs(speed)), min(100.0, abs(speed))
    assert of.vibration == pytest.approx(100.0)
    assert of.span == pytest.approx(2 * math.pi / fast)
    assert of.first == pytest.approx(max(100 * 2 * math.pi / fast, 40 * math.pi / slow))
    assert of.step == pytest.approx(2 * math.pi / fast / SAMPLES_PER_TURN, rel=1e-2)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_prescribed_speed_that_rises_later_is_expected(sense: float) -> None:
    held = {"on": "d", "kind": "constant-speed", "speed": sense * 150.0}
    ramp = {"parameter": "drive.speed", "points": [[0.0, sense * 150.0], [1.0, sense * 400.0]]}
    machine = driven(0.0, drive=held, schedules=[ramp])
    assert horizon(machine).step == pytest.approx(2 * math.pi / 400.0 / SAMPLES_PER_TURN, rel=1e-2)


def test_the_limit_of_a_run_until_settled_is_told() -> None:
    """Only of a run that has come to its limit, and has not settled."""
    of, ended = horizon(driven(200.0)), horizon(driven(200.0), until=10.0)
    end = 25_600 * 2 * math.pi / 200.0
    verdicts: list[Any] = [
        SimpleNamespace(settled_within=lambda _width, known=known: known, never_parts=False) for known in (False, True)
    ]
    (sentence,) = of.limit_warnings(end, verdicts[0], "s")
    assert f"ended at {end:.4g} s, after 2.56e+04 turns or vibrations" in sentence and "study.until" in sentence
    assert of.limit_warnings(0.999 * end, verdicts[0], "s") == of.limit_warnings(end, verdicts[1], "s") == ()
    assert ended.limit_warnings(10.0, verdicts[0], "s") == ()
