"""The beat of a signal whose first harmonic over the rotor's angle is made by hand."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.exciters import slow_beats
from wucht.dynamics.exciters.slow_beats import Beat, _harmonic_beat, _interpolate, _settled_period, _unwound

PERIOD, PLACES, SPEED = 4.0, 240, 50.0


@dataclass(frozen=True)
class Motion:
    time: np.ndarray
    states: np.ndarray
    final_parameter_values: np.ndarray


def beat(monkeypatch: pytest.MonkeyPatch, depth: float, turns: int = 0, swing: float = 0.0) -> Beat:
    """A signal a(t) cos(angle + phase(t)) + 0.7 with the amplitude 3 + depth cos(2 pi t/T), and a second harmonic.

    Its phase loses whole turns a beat besides a swing.
    """
    time = np.concatenate([[0.0], PERIOD * (np.arange(PLACES) + 0.5) / PLACES])
    share = 2 * np.pi * time[1:] / PERIOD

    def signal(there: Motion) -> np.ndarray:
        angle, phase = there.states, turns * share + swing * np.sin(share)
        return (3 + depth * np.cos(share)) * np.cos(angle + phase) + 0.7 + 0.2 * np.cos(2 * angle)

    machine = SimpleNamespace(system=SimpleNamespace(values=lambda values: values), values=(1.0,))
    slow: Any = SimpleNamespace(
        machine=machine,
        system=SimpleNamespace(output=lambda name: SimpleNamespace(expression=name)),
        averaged_system=SimpleNamespace(bodies=SimpleNamespace(names=("main",))),
    )
    monkeypatch.setattr(slow_beats, "states_with_fast_parts", lambda _, at, states, angle: angle)
    speeds = SimpleNamespace(of=lambda *_: lambda at, states, parameters: {"speed": np.full(PLACES, SPEED)})
    monkeypatch.setattr(slow_beats, "Evaluator", speeds)
    motion: Any = Motion(time, np.zeros((1, PLACES + 1)), np.zeros(1))
    return _harmonic_beat(slow, signal, 7.0, PERIOD, motion)  # type: ignore[arg-type]


@pytest.mark.parametrize(("turns", "swing"), [(0, 0.0), (0, 0.5), (2, 0.3), (-3, 0.0)])
def test_amplitude_and_rate_of_a_beat(monkeypatch: pytest.MonkeyPatch, turns: int, swing: float) -> None:
    """The vibration has the frequency of the rotor's speed and of its own phase, at the ends of the beat too."""
    made = beat(monkeypatch, 1.0, turns, swing)
    share = 2 * np.pi * made.time / PERIOD
    assert (made.motion, made.begin, made.period, len(made.time)) == ("modulated", 7.0, PERIOD, 2400)
    assert made.time == pytest.approx(PERIOD * (np.arange(2400) + 0.5) / 2400)
    assert made.amplitude == pytest.approx(3 + np.cos(share), abs=1e-6)
    rate = (SPEED + (turns + swing * np.cos(share)) * 2 * np.pi / PERIOD) / (2 * np.pi)
    assert made.rate == pytest.approx(rate, rel=1e-5)
    assert made.cycles.total == pytest.approx(SPEED * PERIOD / (2 * np.pi) + turns)
    assert (made.upper, made.ratio) == (pytest.approx(4.0, abs=1e-4), pytest.approx(0.5, abs=1e-4))


def test_an_amplitude_that_stays_is_no_beat(monkeypatch: pytest.MonkeyPatch) -> None:
    """A millionth of the largest one."""
    assert beat(monkeypatch, 1.4e-6).motion == "steady" and beat(monkeypatch, 1.7e-6).motion == "modulated"


def test_fullness_is_the_mean_over_the_cycles_between_the_ends() -> None:
    made = Beat("modulated", 0.0, 1.0, np.arange(3.0), np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, 1.0]))
    assert made.fullness == pytest.approx((2.5 - 1) / 4) and made.ratio == 0.2
    assert made.cycles.counts == pytest.approx([1 / 3, 2 / 3, 1 / 3]) and made.cycles.ranges.tolist() == [2.0, 4.0, 10.0]
    assert all(np.isnan([Beat("steady").fullness, Beat("steady").ratio, Beat("steady").upper]))


def test_periodic_interpolation_goes_across_the_end() -> None:
    time = np.arange(40) * 0.1 + 0.05
    at = np.array([0.0, 3.99, 1.234])
    found = _interpolate(time, np.sin(np.pi * time / 2), at, 4.0)
    assert found == pytest.approx(np.sin(np.pi * at / 2), abs=1e-5)


def test_whole_turns_of_angles_are_taken_off() -> None:
    turning = np.array([True, False, True])
    assert _unwound(np.array([7.0, 7.0, -10.0]), turning) == pytest.approx([7.0 - 2 * np.pi, 7.0, -10.0 + 4 * np.pi])


@pytest.mark.parametrize(
    ("failed", "again", "settled"), [(False, (0,), True), (True, (0,), False), (False, (1,), False), (False, None, False)]
)
def test_a_period_that_has_settled_some_beats_later(
    monkeypatch: pytest.MonkeyPatch, failed: bool, again: tuple[int, ...] | None, settled: bool
) -> None:
    """Six beats of 600 samples; then the middles of 240 parts of one."""
    grids, starts = list[np.ndarray](), list[list[float]]()

    def integrate(_: Any, state: np.ndarray, parameters: Any, grid: np.ndarray) -> Any:
        grids.append(grid)
        starts.append(np.asarray(state).tolist())
        result = SimpleNamespace(failure="it burst" if failed else None, time=grid, states=np.array([[0.0, 7.0], [0.0, 5.0]]))
        return SimpleNamespace(reraise_interrupt=lambda: result)

    monkeypatch.setattr(slow_beats, "compile_system", lambda *_: None)
    monkeypatch.setattr(slow_beats, "integrate", integrate)
    found = None if again is None else SimpleNamespace(period=2.5, turns=np.array(again))
    monkeypatch.setattr(slow_beats, "recurrence", lambda *_: found)
    slow: Any = SimpleNamespace(system=None, values=lambda: None)
    before: Any = SimpleNamespace(period=2.0, turns=np.array([0]))
    result = _settled_period(slow, np.zeros(2), before, np.array([True, False]), 1e-9)
    assert (grids[0][0], grids[0][-1], len(grids[0])) == (0.0, 12.0, 3601)
    assert (result is not None) is settled
    if result is not None:
        assert result[0] == 2.5 and starts[1] == pytest.approx([7.0 - 2 * np.pi, 5.0])
        assert grids[1][:3] == pytest.approx([0.0, 2.5 / 480, 7.5 / 480]) and len(grids[1]) == 241
