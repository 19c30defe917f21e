"""The figure of a run-up: what is drawn of it, until when, and of both models. What every figure must be is tested for all."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from tests.refusals import refused

import figure_checks
from wucht import RunUp, draw, load_machine, run
from wucht.errors import InputError
from wucht.plots.sheet import save_figure
from wucht.plots.style import SLOW
from wucht.studies.study_file import read_study

START = {"p1": 0.3, "p2": -0.5}
PANELS = ["speed (rad/s)", "amplitude of the axis (mm)", "phase to the rotor (\u00b0)", "motor power (W)"]


def panels_of(figure: Figure) -> list[Axes]:
    """The axes from top to bottom, without the twins that share a panel."""
    seen: dict[float, Axes] = {}
    for axis in figure.axes:
        seen.setdefault(round(axis.get_position().y0, 6), axis)
    return [seen[y] for y in sorted(seen, reverse=True)]


def labels_of(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


@cache
def balanced() -> xr.Dataset:
    return run(RunUp(until=2.0, start=START), load_machine("drozdetskaya-2020/r1-u80"))


def settled(result: xr.Dataset, **numbers: float | None) -> xr.Dataset:
    """The result with other numbers in its summary."""
    summary = json.loads(result.attrs["summary"]) | numbers
    return result.assign_attrs(summary=json.dumps(summary))


def test_a_run_is_drawn_until_it_has_settled_and_as_a_whole_in_a_strip() -> None:
    """1.5 times the settling time; the lines end there, so that the scales fit what is drawn."""
    figure = draw(settled(balanced(), settling_time=0.4))
    *panels, strip = panels_of(figure)
    assert [p.get_ylabel() for p in panels] == PANELS
    assert all(p.get_xlim() == (0.0, pytest.approx(0.6, abs=2e-3)) for p in panels)
    assert all(np.max(line.get_xdata()) <= 0.6 for p in panels for line in p.get_lines() if len(line.get_xdata()) > 2)
    (mark,) = strip.patches
    assert (mark.get_x(), mark.get_width()) == (0.0, pytest.approx(0.6, abs=2e-3))
    (whole,) = strip.get_lines()
    assert whole.get_xdata()[-1] == pytest.approx(2.0)
    figure_checks.check(figure)


@pytest.mark.parametrize(
    "numbers", [{"settling_time": None}, {"settling_time": 1.2}, {"settling_time": 0.4, "modulation_period": 0.6}]
)
def test_what_has_not_settled_or_nearly_fills_the_run_is_drawn_as_a_whole(numbers: dict[str, float | None]) -> None:
    panels = panels_of(draw(settled(balanced(), **numbers)))
    assert [p.get_ylabel() for p in panels] == PANELS
    assert panels[0].get_xlim() == (0.0, pytest.approx(2.0))


@pytest.mark.parametrize("title", ["$x_{\u6d17\u6fef\u6a5f", 20_000 * "word "])
@pytest.mark.filterwarnings("error")
def test_any_title_can_be_drawn(title: str, tmp_path: Path) -> None:
    """Letter by letter: no formula is read into it."""
    figure = draw(balanced().assign_attrs(title=title))
    first, *_ = figure.get_suptitle().split("\n")
    assert title.startswith(first.rstrip("\N{HORIZONTAL ELLIPSIS}")) and not figure._suptitle.get_parse_math()
    assert save_figure(figure, tmp_path / "figure.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")


def test_a_dataset_that_is_no_result_is_refused() -> None:
    with refused("study", given="no-such-study"):
        draw(balanced().assign_attrs(study="no-such-study"))
    with pytest.raises(InputError):
        draw(balanced().drop_vars("speed"))
    with pytest.raises(InputError):
        draw(xr.Dataset(attrs={"study": "run-up"}))


# --- curves with more in them than is seen ---


def test_limits_within_a_turn_are_drawn_where_they_hold() -> None:
    """Each from the end of the span before to the end of its own, and no further."""
    result = run(RunUp(until=0.5, start=START, stored_samples=40), load_machine("drozdetskaya-2020/r1-u80"))
    (band,) = [c for c in draw(result).axes[0].collections if c.get_label() == "limits within a turn"]
    (outline,) = band.get_paths()
    low, high = result.least_speed.values, result.greatest_speed.values
    ends = np.append(result.time.values[0], result.span_end.values)
    little = 1e-3 * float(np.ptp(high))
    assert np.abs(np.diff(high)).max() > 10 * little
    for at, below, above in zip((ends[:-1] + ends[1:]) / 2, low, high, strict=True):
        inside = outline.contains_points([(at, below - little), (at, (below + above) / 2), (at, above + little)])
        assert inside.tolist() == [False, above - below > 1e-9, False]


def asked(name: str, until: float) -> xr.Dataset:
    study = read_study(name, {"study.until": until})
    return run(study.spec, study.subject)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("sperling-vibration/figure-2a", "phase to the vibration (°)"),
        ("sperling-vibration/self-synchronisation-soft", "phase to e1 (°)"),
    ],
)
def test_rotors_that_may_be_entrained_show_their_phase(name: str, label: str) -> None:
    result = asked(name, 100.0)
    (panel,) = [axis for axis in draw(result).axes if axis.get_ylabel() == label]
    (line,) = [line for line in panel.get_lines() if len(line.get_xdata())]
    (reported,) = result.wucht.summary["rotor_phases"].values()
    apart = np.degrees(reported) - float(line.get_ydata()[-1])
    assert abs((apart + 180) % 360 - 180) < 2.0  # the ripple within a turn


def test_rotors_that_lose_each_other_are_drawn_by_their_slip() -> None:
    """No rectangle over a whole turn, and no rest of a phase; each motor has its power."""
    result = asked("sperling-vibration/self-synchronisation-lost", 60.0)
    panels = {p.get_ylabel(): p for p in draw(result).axes}
    assert not any(label.startswith("phase") for label in panels)
    (slip,) = [line for line in panels["slip to e1 (rad/s)"].get_lines() if len(line.get_xdata()) > 2]
    begin, end = np.searchsorted(result.time.values, [10.0, 20.0])
    apart = result.angle.values[1] - result.angle.values[0]
    mean = (apart[end] - apart[begin]) / (result.time.values[end] - result.time.values[begin])
    at, drawn = (np.asarray(v, float) for v in slip.get_data())
    assert drawn[(at > 10) & (at < 20)].mean() == pytest.approx(mean, rel=0.03)
    for k, name in enumerate(("e1", "e2")):
        (line,) = [x for x in panels["motor power (mW)"].get_lines() if x.get_label() == name]
        at, drawn = (np.asarray(v, float) for v in line.get_data())
        values = result.rotor_power.values[k]
        assert drawn[(at > 10) & (at < 20)].mean() == pytest.approx(1e3 * values[begin:end].mean(), abs=0.03)


def test_a_screen_shows_bearing_forces_and_the_orbit_of_its_deck() -> None:
    result = asked("practice/screen", 4.0)
    s = result.wucht.summary
    assert s["amplitude_settling_time"] > 5 * s["settling_time"]
    assert draw(result).axes[0].get_xlim()[1] >= min(1.5 * s["amplitude_settling_time"], 4.0), "the speed alone is no measure"
    *panels, forces, orbit, _ = draw(settled(result, amplitude_settling_time=1.0)).axes
    (amplitude,) = panels[1].get_lines()
    held, drawn = 1e3 * result.amplitude.values, np.asarray(amplitude.get_ydata(), float)
    assert (np.diff(held) == 0).mean() > 0.5 and (np.diff(drawn) == 0).mean() < 0.02, "no steps"
    assert held.min() <= drawn.min() and drawn.max() == pytest.approx(held.max(), rel=0.05)
    assert labels_of(forces) == ["e1", "least to greatest", "e2"]
    centre, left, right = orbit.get_lines()
    x, y = (np.asarray(v, float) for v in centre.get_data())
    assert np.hypot(np.ptp(x), np.ptp(y)) == pytest.approx(1e3 * s["stroke"], rel=0.02)
    assert np.degrees(np.arctan2(np.ptp(y), np.ptp(x))) == pytest.approx(np.degrees(s["throw_direction"]), abs=0.5)
    turns = np.abs(result.angle.values[0] - result.angle.values[0, -1]) / (2 * np.pi)
    late = turns < 1
    time, turn = result.time.values[late], result.sel(direction="r").displacement.values[late]
    begin = np.interp(-1.0, -turns, result.time.values)
    (_, ly), (_, ry) = ([np.asarray(v, float) for v in line.get_data()] for line in (left, right))
    rocking = np.interp(time, np.linspace(begin, time[-1], len(ry)), ry - ly)
    assert rocking - rocking[-1] == pytest.approx(1e3 * 1.8 * (turn - turn[-1]), abs=1e-3 * np.ptp(ry - ly))


# --- both models ---


def dimensionless(**keys: Any) -> xr.Dataset:
    question = RunUp.from_table({"model": "both", "start": {"psi": 0.0, "delta": 0.5}} | keys)
    return run(question, load_machine("drozdetskaya-2020/table-5.1"))


def slow_lines(axis: Axes) -> list[Line2D]:
    return [x for x in axis.get_lines() if (x.get_color(), x.get_linewidth()) == (SLOW["color"], SLOW["linewidth"])]


@pytest.mark.parametrize("over", ["time", "phi", "psi"])
def test_each_model_is_drawn_over_its_own_abscissa(over: str) -> None:
    """The slow rotor is elsewhere at the same time: its line must not be drawn over the angle of the full one."""
    result = dimensionless(until=1000.0, over=over)
    axes = draw(result).axes[:4]
    assert [len(slow_lines(axis)) for axis in axes] == [1, 1, 2, 0]
    angle = result.slow_angle.values
    at = {"time": result.time.values, "phi": angle[0], "psi": angle[1:].mean(axis=0) - angle[0]}[over]
    (line,) = slow_lines(axes[0])
    x, y = (np.asarray(v, float) for v in line.get_data())
    assert (x.min(), x.max()) == pytest.approx((at.min(), at.max()))
    if over == "phi":
        assert np.abs(result.angle.values[0] - at).max() > 1.0
        assert y == pytest.approx(np.interp(x, at, result.slow_speed.values[0]), abs=1e-9)


@pytest.mark.parametrize("over", ["time", "phi"])
def test_many_runs_of_both_models(over: str) -> None:
    result = dimensionless(until=300.0, along="u", values=[1.0, 7.0], over=over)
    speed, amplitude = draw(result).axes
    assert len(slow_lines(speed)) == len(slow_lines(amplitude)) == 2
    last = result.isel(case=1)
    line = slow_lines(speed)[1]
    at = last["slow_abscissa" if over == "phi" else "time"].values
    inside = np.isfinite(at)
    assert (line.get_xdata()[0], line.get_xdata()[-1]) == pytest.approx((at[inside][0], at[inside][-1]))
    assert line.get_ydata()[-1] == pytest.approx(last.slow_speed.values[0][inside][-1])
