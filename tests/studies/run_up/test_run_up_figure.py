"""The figure of a run-up: panels, labels with units, legends; drawn from the Dataset alone."""

from __future__ import annotations

import io
import math
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
from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.plots.page import JOURNAL, PRINT
from wucht.plots.sheet import save_figure
from wucht.plots.style import COLOURS, DASHES, MOST_LOOKS, line_style
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import draw, run

Study = Callable[..., Path]
START = {"p1": 0.3, "p2": -0.5}


PANELS = [
    "speed (rad/s)", "amplitude of the axis (mm)", "amplitude (mm)", "phase to the rotor (\u00b0)", "motor power (W)",
    "energy\nresidual",
]  # fmt: skip


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
    figure = draw(balanced)
    panels = _panels(figure)
    assert [p.get_ylabel() for p in panels] == PANELS
    assert [p.get_xlabel() for p in panels] == ["", "", "", "", "", "time (s)"]
    assert all(p.get_xlim() == (0.0, pytest.approx(2.0)) for p in panels)
    assert [p.get_yscale() for p in panels] == ["linear", "linear", "log", "linear", "linear", "log"]
    heights = [p.get_position().height for p in panels]
    assert heights[-1] < 0.3 * heights[0], "the energy residual is a check"
    [rpm] = panels[0].child_axes
    assert rpm.get_ylabel() == "speed (rpm)"


def test_only_an_amplitude_that_falls_by_decades_is_drawn_in_decades(balanced: xr.Dataset) -> None:
    never_less = balanced.assign(amplitude=balanced.amplitude.clip(min=float(balanced.amplitude.max()) / 20))
    assert "log" not in [p.get_yscale() for p in _panels(draw(never_less))[:-1]]


def test_every_panel_says_what_it_shows(balanced: xr.Dataset) -> None:
    speed, amplitude, decades, phases, power, residual = _panels(draw(balanced))
    assert _labels(speed) == ["drum", "p1", "p2", "no-load speed", "natural frequency"]
    assert _labels(phases) == ["p1", "p2"]
    assert [p.get_legend() for p in (power, residual)] == [None, None], "the names of the scales say it"
    assert "amplitude" in [line.get_label() for line in amplitude.get_lines()]
    assert decades.get_lines()


def test_a_rotor_without_balancers_has_no_panel_of_phases(alone: xr.Dataset) -> None:
    panels = _panels(draw(alone))
    assert [p.get_ylabel() for p in panels] == ["speed", "amplitude of the axis", "motor power", "energy\nresidual"]
    assert panels[-1].get_xlabel() == "time $\\tau$"
    assert panels[0].child_axes == [], "a speed without a unit has no rpm"


def test_the_title_says_what_and_how_it_ended(balanced: xr.Dataset) -> None:
    title = draw(balanced).get_suptitle()
    assert balanced.attrs["title"] in title
    assert balanced.attrs["outcome"] in title
    assert balanced.attrs["sentence"] in title


def test_lines_show_the_data(balanced: xr.Dataset) -> None:
    speed, amplitude, _, phases, power, _ = _panels(draw(balanced))
    line = {str(drawn.get_label()): drawn for drawn in speed.get_lines()}
    assert line["drum"].get_ydata()[-1] == pytest.approx(float(balanced.speed.sel(body="drum")[-1]))
    assert line["no-load speed"].get_ydata()[0] == pytest.approx(200.0)
    assert line["natural frequency"].get_ydata()[0] == pytest.approx(100.0)
    drawn = next(x for x in amplitude.get_lines() if x.get_label() == "amplitude").get_ydata()
    assert np.max(drawn) == pytest.approx(1e3 * float(balanced.amplitude.max()))
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
    phases = {x.get_label(): x.get_color() for x in _panels(draw(balanced))[3].get_lines()}
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
def test_ten_bodies_stand_in_the_legend(balanced: xr.Dataset) -> None:
    names = ["drum", *(f"b{k}" for k in range(1, 11))]
    rows = np.arange(11) % 3
    several = balanced.isel(body=rows).assign_coords(body=names)
    for name in ("angle", "speed", "phase"):
        several[name] = several[name] + (0.1 * np.arange(11))[:, None]
    for page in (PRINT, JOURNAL):
        figure = draw(several, page)
        speed, phases = (p for p in _panels(figure) if p.get_ylabel().startswith(("speed", "phase")))
        assert _labels(speed)[:11] == names
        assert [n for n in _labels(phases) if n in names] == [n for k, n in zip(rows, names, strict=True) if k]
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
    assert figure.get_suptitle() == f"{title}\n{balanced.attrs['outcome']}: {balanced.attrs['sentence']}"
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
        speed, amplitude, phases, power, _ = _panels(figure)
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
    assert len(panel.get_lines()) == 1
    (reported,) = result.wucht.summary["rotor_phases"].values()
    apart = np.degrees(reported) - float(panel.get_lines()[0].get_ydata()[-1])
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
