"""Signals of a rotating machine as they are drawn: means over whole turns, ranges about them, phases, and until when."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots import time_courses as module
from wucht.plots.time_courses import Phases, TurnWindows

END, TURNS = 10.0, 250.0  # of a run at constant speed
PER_TURN = 23.7  # samples: no whole number, so that they meet the turn elsewhere each time


def run(turns: float = TURNS, per_turn: float = PER_TURN) -> tuple[np.ndarray, np.ndarray]:
    """Time and angle of a rotor."""
    x = np.linspace(0.0, END, int(turns * per_turn))
    return x, 2 * np.pi * turns * x / END


def inner(windows: TurnWindows) -> np.ndarray:
    """Points further from the start than a window is long."""
    return windows.at > END / 50


@pytest.mark.parametrize(
    ("settled", "period", "until"),
    [
        (2.0, None, 3.0),
        (2.0, 0.1, 3.0),
        (2.0, 1.0, 5.0),
        (5.3, None, 7.95),
        (5.4, None, 10.0),
        (None, 1.0, 10.0),
        (0.0, None, 10.0),
        (float("nan"), None, 10.0),
    ],
)
def test_a_run_is_drawn_until_it_has_settled(settled: float | None, period: float | None, until: float) -> None:
    """1.5 times the settling time and three periods of a modulation; as a whole where less than a fifth is left out."""
    assert module.shown_until([{"settling_time": settled, "modulation_period": period}], 10.0) == pytest.approx(until)


def test_a_held_maximum_is_drawn_through_the_middles_of_its_steps() -> None:
    """The amplitude of a decay, held over each of ten turns: its line is the decay at the middles, without a step."""
    x = np.arange(1000) / 1000
    turn = np.floor(10 * x)
    points, line = module.without_steps(x, np.exp(-turn))
    assert points == pytest.approx([0.0, *(np.arange(10) / 10 + 0.0495), 0.999])
    assert line == pytest.approx([1.0, *np.exp(-np.arange(10)), np.exp(-9)])
    drawn = np.interp(x, points, line)
    inside = (x > 0.05) & (x < 0.94)
    assert (np.diff(drawn)[inside[1:]] < 0).all(), "no part is level"
    assert np.abs(np.diff(drawn)).max() < 0.02 * np.abs(np.diff(np.exp(-turn))).max(), "and none jumps"
    assert module.without_steps(x, x)[1][1:-1] == pytest.approx(x), "what is not held remains"


def test_the_mean_over_whole_turns_is_without_the_ripple_within_a_turn() -> None:
    """To a thousandth of it."""
    x, angle = run()
    windows = TurnWindows.of(x, angle, END)
    mean = windows.means(3.0 + np.cos(angle + 0.3) + 0.5 * np.cos(2 * angle))
    assert np.abs(mean - 3.0)[inner(windows)].max() < 5e-3
    assert np.abs(windows.means(2.0 * x) - 2.0 * windows.at)[inner(windows) & (windows.at < 0.98 * END)].max() < 1e-5


def test_windows_are_whole_turns_of_at_least_a_hundredth_of_the_panel() -> None:
    """3 turns of 0.04 s are more than a hundredth of 10 s; of 0.4 s one is, and towards the start they are shorter."""
    for turns, width in ((250.0, 3 * 0.04), (25.0, 0.4)):
        windows = TurnWindows.of(*run(turns), END)
        later = windows.at > width
        assert (windows.end - windows.begin)[later] == pytest.approx(width)
        assert windows.end[0] == windows.begin[0] == 0.0
        assert (windows.end <= END).all() and windows.end[-1] == pytest.approx(END)
    few = TurnWindows.of(*run(4.0, 400.0), END)
    assert (few.end - few.begin).max() <= END / 8 + 1e-9, "a longer turn is resolved"


def test_even_windows_are_a_hundredth_of_the_panel_whatever_rounding_makes_of_it() -> None:
    """At irregular times, as of turning points, whose turns are a hundredth of the panel but for rounding."""
    x = np.append(0.0, np.cumsum(np.random.default_rng(0).uniform(0.05, 0.15, 1400)))
    windows = TurnWindows.even(x, float(x[-1]))
    inner = slice(100, -100)  # at the ends they are shorter
    widths = (windows.end - windows.begin)[inner]
    assert widths == pytest.approx(np.full(len(widths), x[-1] / 100), rel=1e-6)


@pytest.mark.parametrize("per_turn", [12.01, 23.98, 24.0, 31.3])
def test_the_range_does_not_show_how_the_samples_meet_the_swings(per_turn: float) -> None:
    x, angle = run(TURNS, per_turn)
    windows = TurnWindows.of(x, angle, END)
    y = 5.0 + 2.0 * np.cos(2 * angle)
    low, high = windows.extremes(module.with_peaks(y), windows.means(y))
    at = inner(windows)
    assert np.abs(high - 7.0)[at].max() < 0.06 and np.abs(low - 3.0)[at].max() < 0.06
    assert max(np.ptp(low[at]), np.ptp(high[at])) < 0.06, "no teeth"


def test_a_signal_that_only_rises_or_has_one_peak_does_not_swing() -> None:
    x, angle = run()
    windows = TurnWindows.of(x, angle, END)
    for y in (x**2, np.tanh(20 * (x - 5.0)), -np.abs(x - 5.0)):
        assert windows.swings(y).max() < 1e-9
    assert windows.swings(np.cos(angle))[inner(windows)].min() > 1.9


def drawn(y: np.ndarray, x: np.ndarray, angle: np.ndarray, band: str | None = "range") -> tuple[Any, list[Any]]:
    axis = Figure().subplots()
    module.draw_course(axis, TurnWindows.of(x, angle, END), y, band, color="#0072B2", label="power")
    (line,) = axis.get_lines()
    return line, list(axis.collections)


def test_swings_are_a_mean_and_a_band_with_its_name() -> None:
    x, angle = run()
    y = 10.0 * x + 8.0 * np.cos(2 * angle)
    line, (band,) = drawn(y, x, angle)
    at, mean = (np.asarray(v, float) for v in line.get_data())
    inside = (at > 0.5) & (at < 9.5)
    assert np.abs(mean - 10.0 * at)[inside].max() < 0.05
    corners = band.get_paths()[0].vertices
    off = corners[:, 1] - 10.0 * corners[:, 0]
    inside = (corners[:, 0] > 0.5) & (corners[:, 0] < 9.5)
    assert np.abs(np.abs(off[inside]) - 8.0).max() < 0.3, "8 to either side"
    assert band.get_label() == "range" and band.get_facecolor()[0][3] < 0.5
    assert drawn(y, x, angle, None)[1] == []
    (nameless,) = drawn(y, x, angle, "")[1]
    assert str(nameless.get_label()).startswith("_")


@pytest.mark.parametrize(("size", "visible"), [(0.0045, False), (0.006, True)])
def test_swings_of_less_than_a_hundredth_of_the_range_are_not_a_band(size: float, visible: bool) -> None:
    x, angle = run(30.0)
    assert bool(drawn(np.where(x < 5, 0.2 * x, 1.0) + size * np.cos(angle), x, angle)[1]) is visible


def test_the_greatest_value_in_a_turn_keeps_the_largest_of_all() -> None:
    x, angle = run()
    axis = Figure().subplots()
    module.draw_greatest(axis, TurnWindows.of(x, angle, END), np.abs(np.cos(angle)) * (1 + x), color="k", label="amplitude")
    (line,) = axis.get_lines()
    at, high = (np.asarray(v, float) for v in line.get_data())
    assert np.abs(high - (1 + at))[inner(TurnWindows.of(x, angle, END))].max() < 0.2


def test_the_range_of_a_distance_reaches_down_to_zero_on_a_straight_line() -> None:
    """12 samples a pass: without parabolas through them the least of each turn would wander up to 0.13."""
    x, angle = run(TURNS, 24.0)
    axis = Figure().subplots()
    module.draw_range(axis, TurnWindows.of(x, angle, END), np.abs(np.cos(angle + 1.3e-4 * angle)), "distance", "#0072B2")
    (band,) = axis.collections
    corners = band.get_paths()[0].vertices
    lower = corners[(corners[:, 0] > 1.0) & (corners[:, 1] < 0.5), 1]
    assert len(lower) and lower.max() < 0.03


def phases_of(phase: np.ndarray, turns: float = TURNS) -> Phases:
    x, angle = run(turns)
    return Phases.of(TurnWindows.of(x, angle, END), np.mod(np.atleast_2d(phase), 2 * np.pi))


def test_a_phase_is_its_mean_over_whole_turns_across_the_wrap_too() -> None:
    _, angle = run()
    phases = phases_of(np.radians(2.0) + 0.4 * np.cos(angle))
    later = phases.at > 0.2
    assert np.abs(phases.degrees[0] - 2.0)[later].max() < 0.2
    assert not phases.slip_mask.any() and not phases.all_slip


@pytest.mark.parametrize(("passes", "visible"), [(20, True), (30, False)])
def test_a_body_that_turns_past_too_fast_is_left_out_and_its_slip_is_known(passes: int, visible: bool) -> None:
    """A quarter of a turn in a hundredth of the panel is 25 turns in it; backwards."""
    x, _ = run()
    phases = phases_of(-2 * np.pi * passes * x / END)
    inside = (phases.at > 0.2) & (phases.at < 9.8)
    assert bool(np.isfinite(phases.degrees[0][inside]).all()) is visible
    assert bool(np.isfinite(phases.degrees[0][inside]).any()) is visible
    assert phases.slips[0][inside] == pytest.approx(-2 * np.pi * passes / END)
    assert phases.slip_mask[0] != visible and phases.all_slip != visible


def test_a_body_that_slips_first_and_then_locks_is_a_line_and_a_note_but_no_rectangle() -> None:
    x, _ = run()
    phases = phases_of(np.array([1.0 + 2 * np.pi * 20 * np.maximum(4.0 - x, 0.0), np.full(len(x), 2.0)]))
    axis = Figure().subplots()
    module.draw_phases(axis, phases, [{"label": "b1", "color": "k"}, {"label": "b2", "color": "r"}])
    assert axis.collections == [] or len(axis.collections) == 0
    first, second, note = axis.get_lines()
    drawn_at = np.asarray(first.get_xdata())[np.isfinite(first.get_ydata())]
    assert drawn_at.min() == pytest.approx(4.0, abs=0.15)
    assert np.asarray(second.get_ydata()) == pytest.approx(np.degrees(2.0))
    assert note.get_label() == "not drawn while turning past" and not len(note.get_xdata())
    assert not phases.all_slip, "one is synchronous"
