"""The figure of a run-up: panels, labels with units, legends; drawn from the Dataset alone."""

from __future__ import annotations

import io
import json
import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.lines import Line2D
from tests.refusals import refused

import figure_checks
from figure_checks import alike
from wucht import RunUp
from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.plots.page import JOURNAL, PRINT
from wucht.plots.sheet import save_figure
from wucht.plots.style import COLOURS, DASHES, MOST_LOOKS, line_style
from wucht.studies.runner import draw, run

Study = Callable[..., Path]
START = {"p1": 0.3, "p2": -0.5}


PANELS = ["speed (rad/s)", "amplitude of the axis (mm)", "phase to the rotor (\u00b0)", "motor power (W)"]


def _panels(figure: Figure) -> list[Axes]:
    """The axes from top to bottom, without the twins that share a panel."""
    seen: dict[float, Axes] = {}
    for axis in figure.axes:
        seen.setdefault(round(axis.get_position().y0, 6), axis)
    return [seen[y] for y in sorted(seen, reverse=True)]


def _labels(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


@pytest.fixture(scope="module")
def balanced() -> xr.Dataset:
    return run(RunUp(until=2.0, start=START), load_machine("drozdetskaya-2020/r1-u80"))


@pytest.fixture(scope="module")
def alone() -> xr.Dataset:
    return run(RunUp(until=200.0), load_machine("drozdetskaya-2020/table-3.1-laval"))


def test_panels_with_units(balanced: xr.Dataset) -> None:
    panels = _panels(draw(balanced))
    assert [p.get_ylabel() for p in panels] == PANELS
    assert [p.get_xlabel() for p in panels] == ["", "", "", "time (s)"]
    assert all(p.get_xlim() == (0.0, pytest.approx(2.0)) for p in panels)
    assert [p.get_yscale() for p in panels] == ["linear"] * 4, "no decades down to rounding"
    [rpm] = panels[0].child_axes
    assert rpm.get_ylabel() == "speed (rpm)"


def settled(result: xr.Dataset, **numbers: float | None) -> xr.Dataset:
    """The result with other numbers in its summary."""
    summary = json.loads(result.attrs["summary"]) | numbers
    return result.assign_attrs(summary=json.dumps(summary))


def test_a_run_is_drawn_until_it_has_settled_and_as_a_whole_in_a_strip(balanced: xr.Dataset) -> None:
    """1.5 times the settling time; the lines end there, so that the scales fit what is drawn."""
    figure = draw(settled(balanced, settling_time=0.4))
    *panels, strip = _panels(figure)
    assert [p.get_ylabel() for p in panels] == PANELS
    assert all(p.get_xlim() == (0.0, pytest.approx(0.6, abs=2e-3)) for p in panels)
    assert all(np.max(line.get_xdata()) <= 0.6 for p in panels for line in p.get_lines() if len(line.get_xdata()) > 2)
    assert [p.get_xlabel() for p in panels] == ["", "", "", "time (s)"]
    assert strip.get_xlabel() == "whole run, time (s)" and strip.get_ylabel().replace("\n", " ") == "amplitude (mm)"
    assert strip.get_xlim() == (0.0, pytest.approx(2.0)) and _labels(strip) == ["drawn above"]
    (mark,) = strip.patches
    assert (mark.get_x(), mark.get_width()) == (0.0, pytest.approx(0.6, abs=2e-3))
    assert strip.get_position().height < 0.5 * panels[0].get_position().height, "thin"
    (whole,) = strip.get_lines()
    assert whole.get_xdata()[-1] == pytest.approx(2.0)
    figure_checks.check(figure)


@pytest.mark.parametrize(
    "numbers", [{"settling_time": None}, {"settling_time": 1.2}, {"settling_time": 0.4, "modulation_period": 0.6}]
)
def test_what_has_not_settled_or_nearly_fills_the_run_is_drawn_as_a_whole(
    balanced: xr.Dataset, numbers: dict[str, float | None]
) -> None:
    panels = _panels(draw(settled(balanced, **numbers)))
    assert [p.get_ylabel() for p in panels] == PANELS
    assert panels[0].get_xlim() == (0.0, pytest.approx(2.0))


def test_every_panel_says_what_it_shows(balanced: xr.Dataset) -> None:
    speed, amplitude, phases, power = _panels(draw(balanced))
    assert _labels(speed) == ["drum", "p1", "p2", "no-load speed", "natural frequency"]
    assert _labels(amplitude) == ["distance from rest", "amplitude"]
    assert _labels(phases) == ["p1", "p2"]
    assert power.get_legend() is None, "the name of the scale says it"


def test_a_rotor_without_balancers_has_no_panel_of_phases(alone: xr.Dataset) -> None:
    panels = _panels(draw(settled(alone, settling_time=None)))
    assert [p.get_ylabel() for p in panels] == ["speed", "amplitude of the axis", "motor power"]
    assert panels[-1].get_xlabel() == "time $\\tau$"
    assert panels[0].child_axes == [], "a speed without a unit has no rpm"


def test_the_title_says_what_and_how_it_ended(balanced: xr.Dataset) -> None:
    title = draw(balanced).get_suptitle()
    assert balanced.attrs["title"] in title
    assert balanced.attrs["outcome"] in title
    assert balanced.attrs["sentence"] in title


def test_lines_show_the_data(balanced: xr.Dataset) -> None:
    speed, amplitude, phases, power = _panels(draw(balanced))
    line = {str(drawn.get_label()): drawn for drawn in speed.get_lines()}
    assert line["drum"].get_ydata()[-1] == pytest.approx(float(balanced.speed.sel(body="drum")[-1]))
    assert line["no-load speed"].get_ydata()[0] == pytest.approx(200.0)
    assert line["natural frequency"].get_ydata()[0] == pytest.approx(100.0)
    drawn = next(x for x in amplitude.get_lines() if x.get_label() == "amplitude").get_ydata()
    assert np.max(drawn) == pytest.approx(1e3 * float(balanced.amplitude.max()), rel=1e-4), "its middle is between two samples"
    shown = phases.get_lines()[0].get_ydata()
    assert shown[-1] == pytest.approx(math.degrees(float(balanced.phase.sel(body="p1")[-1])))
    assert phases.get_ylim() == (0.0, 360.0)
    drawn = power.get_lines()[0].get_ydata()
    assert np.max(drawn) == pytest.approx(float(balanced.motor_power.max()))


def test_lines_differ_in_colour_and_dash(balanced: xr.Dataset) -> None:
    speed = _panels(draw(balanced))[0]
    bodies = [x for x in speed.get_lines() if x.get_label() in ("drum", "p1", "p2")]
    assert len({x.get_color() for x in bodies}) == len({x.get_linestyle() for x in bodies}) == 3
    # a body has the colour in every panel
    phases = {x.get_label(): x.get_color() for x in _panels(draw(balanced))[2].get_lines()}
    assert {x.get_label(): x.get_color() for x in bodies if x.get_label() != "drum"} == phases
    for i in range(28):
        first, second = line_style(i), line_style(i + 1)
        assert first["color"] != second["color"]
        assert first["linestyle"] != second["linestyle"]
    assert len({(line_style(i)["color"], line_style(i)["linestyle"]) for i in range(28)}) == len(COLOURS) * len(DASHES)
    assert alike([Line2D([], [], label=str(i), **line_style(i)) for i in range(MOST_LOOKS)]) == [], "in grey too"


def test_a_rotor_that_turns_clockwise() -> None:
    machine = load_machine("drozdetskaya-2020/r1-u80", {"drive.no_load_speed": -200})
    speed = _panels(draw(run(RunUp(until=2.0, start=START), machine)))[0]
    line = {str(drawn.get_label()): drawn for drawn in speed.get_lines()}
    assert line["no-load speed"].get_ydata()[0] == pytest.approx(-200.0)
    assert line["natural frequency"].get_ydata()[0] == pytest.approx(-100.0)


def test_two_natural_frequencies(study: Study) -> None:
    machine = load_machine(str(study('"1e5 N/m"', '["1e5 N/m", "2e5 N/m"]')))
    speed = _panels(draw(run(RunUp(until=0.1), machine)))[0]
    assert _labels(speed).count("natural frequencies") == 1
    dotted = [float(x.get_ydata()[0]) for x in speed.get_lines() if x.get_linestyle() == ":"]
    assert sorted(dotted)[-2:] == pytest.approx([math.sqrt(1e5 / 10.25), math.sqrt(2e5 / 10.25)])


@pytest.mark.slow
def test_ten_balls_have_one_entry_in_each_legend(balanced: xr.Dataset) -> None:
    names = ["drum", *(f"b{k}" for k in range(1, 11))]
    rows = np.array([0, *(1 + k % 2 for k in range(10))])
    several = balanced.isel(body=rows).assign_coords(body=names)
    for name in ("angle", "speed", "phase"):
        several[name] = several[name] + (0.1 * np.arange(11))[:, None]
    for page in (PRINT, JOURNAL):
        figure = draw(several, page)
        speed, phases = (p for p in _panels(figure) if p.get_ylabel().startswith(("speed", "phase")))
        assert _labels(speed)[:2] == ["drum", "b1 to b10"] and _labels(phases)[0] == "b1 to b10"
        assert not {*names[1:]} & {*_labels(speed), *_labels(phases)}
        curves = [line for line in phases.get_lines() if len(line.get_xdata()) > 2]
        assert len(curves) == 10 and len({line.get_color() for line in curves}) == 1
        figure_checks.check(figure)


@pytest.mark.parametrize("ending", ["png", "svg", pytest.param("pdf", marks=pytest.mark.slow)])
@pytest.mark.filterwarnings("error")
def test_every_format(balanced: xr.Dataset, ending: str) -> None:
    file = io.BytesIO()
    draw(balanced).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 5000


def test_png_is_large_enough_to_print(balanced: xr.Dataset) -> None:
    figure = draw(balanced)
    width, height = (float(v) * figure.dpi for v in figure.get_size_inches())
    assert width >= 1000
    assert height >= 1000


TITLES = [
    "50 $ and 60 $",
    "$x_{",
    "$x_{$",
    "5 $^ and 6 $",
    "100 % \\frac",
    "two\nlines",
    "a_b^c & <d>",
    "\u6d17\u6fef\u6a5f",
    300 * "x",
]


# Quick is one of each: a formula, half a formula, two lines, letters of another script.
@pytest.mark.parametrize(
    "title",
    [t if t in ("$x_{", "\u6d17\u6fef\u6a5f") else pytest.param(t, marks=pytest.mark.slow) for t in TITLES],
)
@pytest.mark.filterwarnings("error")
def test_any_title_can_be_drawn(balanced: xr.Dataset, title: str, tmp_path: Path) -> None:
    """Letter by letter: no formula is read into it."""
    figure = draw(balanced.assign_attrs(title=title))
    sentence = f"{balanced.attrs['outcome']}: {balanced.attrs['sentence']}"
    first, *rest = figure.get_suptitle().split("\n")
    if "\n" in title:
        assert figure.get_suptitle() == title and figure.texts[1].get_text().startswith(f"{sentence}\nassumed")
    else:
        assert rest == [sentence]
        assert first == title or (
            first.endswith("\N{HORIZONTAL ELLIPSIS}") and title.startswith(first[:-1]) and len(first) > 80
        )
    assert not figure._suptitle.get_parse_math()
    image = imread(save_figure(figure, tmp_path / "figure.png"))
    assert image.shape[:2] == pytest.approx(tuple(float(v) * figure.dpi for v in figure.get_size_inches())[::-1], abs=1e-6)
    heading = image[: int(0.5 * figure.dpi), :, :3]
    assert heading.min() < 0.5, "the heading is written in black"
    drawn = save_figure(figure, tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert drawn.rstrip().endswith("</svg>")


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_the_shortest_runs_can_be_drawn(study: Study) -> None:
    machine = load_machine(str(study()))
    for question in (RunUp(turns=1e-9), RunUp(until=1e-30)):
        result = run(question, machine)
        figure = draw(result)
        figure.savefig(io.BytesIO(), format="png")
        assert figure.get_suptitle().endswith("\nunidentified: the run is too short for a verdict")
        speed, amplitude, phases, power = _panels(figure)
        assert _labels(speed) == ["drum", "p1", "p2", "no-load speed", "natural frequency"]
        assert amplitude.get_lines()[-1].get_label() == "amplitude"
        assert _labels(phases) == ["p1", "p2"]
        assert power.get_lines()
        for row, line in enumerate(speed.get_lines()[:3]):
            assert np.array_equal(line.get_xdata(), result.time.values)
            assert np.array_equal(line.get_ydata(), result.speed.values[row])
        for axis in figure.axes:
            left, right = axis.get_xlim()
            assert left <= 0.0 <= result.time.values[-1] <= right
            assert left < right, "the panel has a width even where the run has none"


def test_nothing_is_kept_open(balanced: xr.Dataset) -> None:
    from matplotlib import pyplot

    before = pyplot.get_fignums()
    for _ in range(3):
        draw(balanced)
    assert pyplot.get_fignums() == before


def test_a_dataset_that_is_no_result_is_refused(balanced: xr.Dataset) -> None:
    with refused("study", given="no-such-study"):
        draw(balanced.assign_attrs(study="no-such-study"))
    with pytest.raises(InputError):
        draw(balanced.drop_vars("speed"))
    with pytest.raises(InputError):
        draw(xr.Dataset(attrs={"study": "run-up"}))


# Curves with more in them than is seen


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("sperling-vibration/figure-2a", "phase to the vibration (°)"),
        ("sperling-vibration/self-synchronisation-soft", "phase to e1 (°)"),
    ],
)
def test_rotors_that_may_be_entrained_show_their_phase(name, label):
    from wucht.studies.study_file import read_study

    study = read_study(name, {"study.until": 100.0})
    result = run(study.spec, study.subject)
    drawn = draw(result)
    (panel,) = [axis for axis in drawn.axes if axis.get_ylabel() == label]
    (line,) = [line for line in panel.get_lines() if len(line.get_xdata())]
    (reported,) = result.wucht.summary["rotor_phases"].values()
    apart = np.degrees(reported) - float(line.get_ydata()[-1])
    assert abs((apart + 180) % 360 - 180) < 2.0  # the ripple within a turn


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


def test_a_title_of_any_length_is_drawn_at_once(balanced: xr.Dataset) -> None:
    """100,000 letters, in one word and in many: not more than two lines of them."""
    taken = []
    for title in ("x", "x", 100_000 * "x", 20_000 * "word "):
        begin = time.process_time()
        figure = draw(balanced.assign_attrs(title=title))
        figure.savefig(io.BytesIO(), format="png")
        taken.append(time.process_time() - begin)
        assert len(figure.get_suptitle().split("\n")) <= 2
        figure_checks.check(figure)
    assert max(taken[2:]) < taken[1] + 1.0, "a second more than for a title of one letter is far too much"


def test_rotors_that_lose_each_other_are_drawn_by_their_slip() -> None:
    """No rectangle over a whole turn, and no rest of a phase."""
    from wucht.studies.study_file import read_study

    study = read_study("sperling-vibration/self-synchronisation-lost", {"study.until": 60.0})
    result = run(study.spec, study.subject)
    panels = {p.get_ylabel(): p for p in draw(result).axes}
    slip = panels["slip to e1 (rad/s)"]
    assert not any(label.startswith("phase") for label in panels) and not slip.collections
    (line,) = [line for line in slip.get_lines() if len(line.get_xdata()) > 2]
    first, second = (result.angle.values[k] for k in (0, 1))
    begin, end = np.searchsorted(result.time.values, [10.0, 20.0])
    mean = ((second - first)[end] - (second - first)[begin]) / (result.time.values[end] - result.time.values[begin])
    at, drawn = (np.asarray(v, float) for v in line.get_data())
    assert drawn[(at > 10) & (at < 20)].mean() == pytest.approx(mean, rel=0.03)
    power = panels["motor power (mW)"]
    assert _labels(power) == ["e1", "least to greatest", "e2"], "each motor"
    for k, name in enumerate(("e1", "e2")):
        (line,) = [x for x in power.get_lines() if x.get_label() == name]
        at, drawn = (np.asarray(v, float) for v in line.get_data())
        values = result.rotor_power.values[k]
        assert drawn[(at > 10) & (at < 20)].mean() == pytest.approx(1e3 * values[begin:end].mean(), abs=0.03)
    assert result.rotor_power.values.sum(axis=0) == pytest.approx(result.motor_power.values)


def test_a_screen_shows_bearing_forces_and_the_orbit_of_its_deck() -> None:
    from wucht.studies.study_file import read_study

    study = read_study("practice/screen", {"study.until": 4.0})
    result = run(study.spec, study.subject)
    amplitude_settled = result.wucht.summary["amplitude_settling_time"]
    assert amplitude_settled > 5 * result.wucht.summary["settling_time"]
    assert draw(result).axes[0].get_xlim()[1] >= min(1.5 * amplitude_settled, 4.0), "the speed alone is no measure of a screen"
    figure = draw(settled(result, amplitude_settling_time=1.0))
    *panels, forces, orbit, strip = figure.axes
    (amplitude,) = panels[1].get_lines()
    held, drawn = 1e3 * result.amplitude.values, np.asarray(amplitude.get_ydata(), float)
    assert (np.diff(held) == 0).mean() > 0.5 and (np.diff(drawn) == 0).mean() < 0.02, "no steps"
    assert held.min() <= drawn.min() and drawn.max() == pytest.approx(held.max(), rel=0.05)
    names = [p.get_ylabel().replace("\n", " ").split(" (")[0] for p in panels]
    assert names == ["speed", "amplitude of the axis", "phase to e1", "motor power"]
    assert forces.get_ylabel() == "bearing force (kN)" and _labels(forces) == ["e1", "least to greatest", "e2"]
    centre, left, right = orbit.get_lines()
    assert _labels(orbit) == ["centre of mass", "at (-0.9, -0.2) m", "at (0.9, -0.2) m"]
    x, y = (np.asarray(v, float) for v in centre.get_data())
    assert np.hypot(np.ptp(x), np.ptp(y)) == pytest.approx(1e3 * result.wucht.summary["stroke"], rel=0.02)
    assert np.degrees(np.arctan2(np.ptp(y), np.ptp(x))) == pytest.approx(
        np.degrees(result.wucht.summary["throw_direction"]), abs=0.5
    )
    turns = np.abs(result.angle.values[0] - result.angle.values[0, -1]) / (2 * np.pi)
    late = turns < 1
    time, turn = result.time.values[late], result.sel(direction="r").displacement.values[late]
    begin = np.interp(-1.0, -turns, result.time.values)
    (lx, ly), (rx, ry) = ([np.asarray(v, float) for v in line.get_data()] for line in (left, right))
    between = np.hypot(rx - lx, ry - ly)
    rocking = np.interp(time, np.linspace(begin, time[-1], len(ry)), ry - ly)
    assert rocking - rocking[-1] == pytest.approx(1e3 * 1.8 * (turn - turn[-1]), abs=1e-3 * np.ptp(ry - ly))
    assert between.max() < 5.0
    assert strip.get_xlabel() == "whole run, time (s)"
    figure_checks.check(figure)
