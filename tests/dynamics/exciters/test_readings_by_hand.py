"""Readings of a speed that beats, the signal of a failure, the stiffness over the damage, and the cycles of a beat, by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.exciters import speed_readings as module
from wucht.dynamics.exciters.failing_machine import FallingStiffness
from wucht.dynamics.exciters.slow_beats import Beat, _interpolate, _unwound
from wucht.dynamics.exciters.speed_readings import (
    BEATING,
    AveragedSpeed,
    Detection,
    Readings,
    Windows,
    averaged_speed,
    detection_of,
    readings_of,
)
from wucht.errors import RunError

INTERVAL, BEAT, DEPTH = 0.5, 4.0, 3.0


def readings(sense: float = 1.0) -> Readings:
    """The speed is 100 + 3 cos(2 pi t/4) until 80 s, and by 20 less from then on."""
    time = np.linspace(0.0, 160.0, 1601)
    rate = 2 * math.pi / BEAT
    angle = 100 * time + DEPTH / rate * np.sin(rate * time) - 20 * np.maximum(time - 80.0, 0.0)
    return readings_of(time, sense * angle, INTERVAL, Windows((0.0, 80.0), (80.0, 160.0), 80.0, 80.0))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_means_and_beating_of_readings(sense: float) -> None:
    """A mean over a time T of a wave of the period B has the amplitude sin(pi T/B)/(pi T/B) of it."""
    found = readings(sense)
    x = math.pi * INTERVAL / BEAT
    assert (found.before, found.after) == (pytest.approx(sense * 100.0, abs=0.02), pytest.approx(sense * 80.0, abs=0.02))
    assert found.beating == pytest.approx(DEPTH * math.sin(x) / x / math.sqrt(2), rel=5e-3)
    assert found.time == pytest.approx(INTERVAL * np.arange(1, 321))
    middle = found.time - INTERVAL / 2
    expected = 100 + DEPTH * math.sin(x) / x * np.cos(2 * math.pi * middle / BEAT) - 20 * (middle > 80.0)
    assert found.speed == pytest.approx(sense * expected, abs=1e-8)
    assert found.normal.tolist() == [True] * 160 + [False] * 160 and found.abnormal.tolist() == [False] * 160 + [True] * 160
    deviation = math.sqrt(0.4**2 + found.beating**2)
    assert found.deviation(0.4) == pytest.approx(deviation)
    assert found.signal(0.4) == pytest.approx(20.0 / deviation, rel=1e-3)


@pytest.mark.parametrize(("normal", "abnormal"), [((0.0, 4.9), (10.0, 20.0)), ((0.0, 10.0), (15.1, 20.0)), (None, None)])
def test_fewer_than_ten_readings_are_no_speed(normal: tuple[float, float] | None, abnormal: tuple[float, float] | None) -> None:
    time = np.linspace(0.0, 20.0, 201)
    found = readings_of(time, 100 * time, INTERVAL, Windows(normal, abnormal, None, None))
    before, after = normal == (0.0, 10.0), abnormal == (10.0, 20.0)
    assert (found.before is not None, found.after is not None) == (before, after)
    assert found.signal(1.0) is None
    exact = readings_of(time, 100 * time, INTERVAL, Windows((0.0, 5.0), (15.0, 20.0), None, None))
    assert (exact.before, exact.after) == pytest.approx((100.0, 100.0)), "ten are enough"


class Chart:
    """A chart that keeps what it is given."""

    def alarms(self, *given: Any) -> Any:
        self.given = given
        return "alarms"


@pytest.mark.parametrize(("change", "noise", "level"), [(5.0, 0.5, 2.5), (None, 0.5, None), (5.0, 1e5, 2.5)])
@pytest.mark.parametrize("steady", [True, False])
def test_what_a_chart_is_given(
    monkeypatch: pytest.MonkeyPatch, steady: bool, change: float | None, noise: float, level: float | None
) -> None:
    """Half the change is its reference, by default half the deviation of the readings; its readings count from their mean."""
    of, chart = readings(), Chart()
    designed = []

    def design(*given: Any) -> Chart:
        designed.append(given)
        return chart

    monkeypatch.setattr(module, "design_chart", design)
    windows = Windows((0.0, 80.0), (120.0, 160.0), 80.0, 82.0)
    of = replace(of, abnormal=of.time > 120.0, windows=windows)
    found = detection_of(of, noise, 1000.0, change, steady)
    assert found is not None and found.alarms == "alarms"  # type: ignore[comparison-overlap]
    reference, of_noise, every, normal = designed[0]
    assert reference == pytest.approx(level if level is not None else math.hypot(noise, of.beating) / 2)
    assert (of_noise, every) == (noise, 1000.0)
    before = of.speed[:160]
    expected = np.zeros(1) if noise > 1e3 else before - before.mean()
    assert normal == pytest.approx(expected)
    at_start, later, again, _ = chart.given
    assert (at_start is None) is not steady
    if steady:
        assert at_start == pytest.approx(expected)
    assert later == pytest.approx(of.speed[160:] - before.mean()) and again == pytest.approx(of.speed[240:] - before.mean())
    assert (found.learnt, found.begins, found.interval) == pytest.approx((before.mean(), 80.5 - 82.0, 0.5))


def test_of_many_readings_the_last_ones_are_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(1.0, 301.0)
    speed, windows = np.where(time <= 40.0, 50.0, 60.0) + time % 2, Windows(None, None, 299.0, None)
    of = Readings(time, speed, time <= 299.0, time > 299.0, 55.0, 60.0, 1.0, windows)
    monkeypatch.setattr(module, "design_chart", lambda *given: SimpleNamespace(alarms=lambda *_: given[3]))
    found = detection_of(of, 0.1, 1e3, None, True)
    assert found is not None and found.learnt == pytest.approx(60.5) and len(found.alarms) == 256  # type: ignore[arg-type]


def test_without_a_speed_or_a_later_reading_there_is_no_chart() -> None:
    for start in (None, 160.0):
        of = replace(readings(), windows=Windows(None, None, start, None))
        assert detection_of(of, 1.0, 1e3, None, True) is None
    few = replace(readings(), before=None, beating=0.0, windows=Windows(None, None, 80.0, None))
    assert detection_of(few, 1.0, 1e3, None, True) is None


@pytest.mark.parametrize(("certain", "last", "known"), [(True, 0.5, True), (False, 0.5, False), (False, 0.99995, True)])
def test_times_of_an_alarm(certain: bool, last: float, known: bool) -> None:
    """The first reading comes 0.2 s after the failure, and then one each half second."""
    alarms: Any = SimpleNamespace(
        is_certain=certain, first=np.array([0.25, last]), mean=lambda: 3.0,
        curve=lambda probability, points: (np.array([0.0, 1.0, 8.0]), np.array([0.25, 0.5, 0.75])),
        quantile=lambda p: 2.0 if p < 0.9 else None,
    )  # fmt: skip
    found = Detection(None, 90.0, alarms, 0.2, 0.5)  # type: ignore[arg-type]
    assert (found.readings, found.horizon) == (9, pytest.approx(0.2 + 8 * 0.5))
    assert found.mean == (pytest.approx(1.7) if known else None)
    assert found.quantile(0.5) == pytest.approx(1.2) and found.quantile(0.95) is None
    assert found.curve()[0] == pytest.approx([0.2, 0.7, 4.2])


@pytest.mark.parametrize(("sense", "part"), [(1.0, 3.0), (-1.0, 10.0)])
def test_the_mean_of_a_beat_is_signed_and_leaves_the_way_there_out(
    monkeypatch: pytest.MonkeyPatch, sense: float, part: float
) -> None:
    """The averaged speed falls from 900 at first to 60 in the window of which the mean is taken."""
    begin, grids = np.arange(3.0), []

    def slow_model(machine: Any, start: np.ndarray, inertia: bool | None, order: int) -> Any:
        assert start is begin and order == 1
        system = SimpleNamespace(output=lambda name: SimpleNamespace(expression=name))
        return SimpleNamespace(
            system="system",
            initial="initial",
            parameter_values="values",
            averaged_equations=SimpleNamespace(system=system, senses={"drum": sense}),
        )

    def integrate(flow: Any, initial: Any, values: Any, grid: np.ndarray) -> Any:
        grids.append(grid)
        motion = SimpleNamespace(failure=None, time=grid, states=None, final_parameter_values=None)
        return SimpleNamespace(reraise_interrupt=lambda: motion)

    evaluate = SimpleNamespace(
        of=lambda system, outputs, names: lambda time, *_: {names[0]: np.where((time == 0.0) & (part < 10.0), 900.0, 60.0)}
    )
    monkeypatch.setattr(module, "machine_at_speed", lambda machine, speed: machine)
    monkeypatch.setattr(module, "slow_model", slow_model)
    monkeypatch.setattr(module, "compile_system", lambda *_: None)
    monkeypatch.setattr(module, "integrate", integrate)
    monkeypatch.setattr(module, "Evaluator", evaluate)
    machine: Any = SimpleNamespace(rotor=SimpleNamespace(name="drum"))
    found = averaged_speed(machine, 1.0, True, begin, (10.0, part), 1e-10, None)
    assert found == AveragedSpeed(pytest.approx(sense * 60.0), BEATING)
    (grid,) = grids
    assert (grid[0], grid[-1]) == (0.0, 10.0) and grid[1] == pytest.approx(7.0 if part < 10.0 else 0.0, abs=0.01)


@pytest.mark.parametrize(
    ("at_once", "damage", "stiffness"),
    [
        (True, 0.0, 5.0), (True, 0.999, 5.0), (True, 1.0, 2.0), (True, 3.0, 2.0),
        (False, 0.0, 5.0), (False, 0.5, 3.5), (False, 1.0, 2.0), (False, 2.0, 2.0),
    ],
)  # fmt: skip
def test_the_stiffness_over_the_damage(at_once: bool, damage: float, stiffness: float) -> None:
    assert FallingStiffness("k", 5.0, 0.4, at_once).stiffness_at(damage) == pytest.approx(stiffness)


def test_the_cycles_of_a_beat() -> None:
    """Three parts of a beat of 6 s, 2 s each, with 10, 20 and 10 cycles a second: 20, 40 and 20 cycles."""
    beat = Beat("modulated", 0.0, 6.0, np.arange(1.0, 7.0, 2.0), np.array([1.0, 2.0, 5.0]), np.array([10.0, 20.0, 10.0]))
    assert beat.cycles.ranges.tolist() == [2.0, 4.0, 10.0] and beat.cycles.means.tolist() == [0.0, 0.0, 0.0]
    assert beat.cycles.counts == pytest.approx([20.0, 40.0, 20.0])
    assert (beat.upper, beat.ratio) == (5.0, pytest.approx(0.2))
    assert beat.fullness == pytest.approx(((20 * 1 + 40 * 2 + 20 * 5) / 80 - 1) / 4)
    steady = Beat("steady")
    assert np.isnan([steady.upper, steady.ratio, steady.fullness]).all() and not steady.cycles.total


def test_a_periodic_function_between_its_places() -> None:
    time = 0.1 + 2.0 * (np.arange(60) + 0.5) / 60
    at = np.array([0.0, 0.05, 0.7, 1.99, 2.0])
    assert _interpolate(time, np.sin(math.pi * time), at, 2.0) == pytest.approx(np.sin(math.pi * at), abs=1e-6)


def test_angles_lose_whole_turns_and_speeds_none() -> None:
    state = np.array([7.0, 7.0, -20.0])
    assert _unwound(state, np.array([True, False, True])) == pytest.approx([7 - 2 * math.pi, 7.0, -20 + 6 * math.pi])


def test_too_much_noise_has_no_chart(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: Any) -> None:
        raise RunError("too much noise")

    monkeypatch.setattr(module, "design_chart", none)
    with pytest.raises(RunError, match="too much noise"):
        detection_of(readings(), 1.0, 1e3, None, True)
