"""The figure of every study shows what its result has: each line, bar and point where the Dataset says, over its own axis.

What is drawn is compared with the variables of the result by name, in the units that the scales carry. The ranges of the
variables are unlike, so that one that is drawn for another, or at a place of another, is far off.
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial import cKDTree
from tests import figure_checks, stated

from wucht import JOURNAL, PRINT, draw, panel_names, report, write_report
from wucht.plots.sheet import sheet_of
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study, run_study

DEG, RPM = 180 / math.pi, 30 / math.pi


@dataclass(frozen=True)
class Line:
    """Of a panel. name: of the line, or which one it is. x, y: what of the Dataset is drawn. part: whether only some of it is
    drawn. off: by so much of the largest value, where it is interpolated."""

    panel: int
    name: str | int
    x: str
    y: str
    part: bool = False
    off: float = 1e-9


@dataclass(frozen=True)
class Bars:
    """Of a panel, with these heights."""

    panel: int
    heights: str


@dataclass(frozen=True)
class Figured:
    """settings: of the study's template. shown: what is drawn. Names of scales are in ``tests/stated``."""

    settings: Mapping[str, Any]
    shown: tuple[Line | Bars, ...]


DAMPINGS = ("50 N s/m", "166.7 N s/m", "283.3 N s/m", "400 N s/m", "nominal")
LAG = "lag[0] * DEG"
FROM_SLOWEST = (
    "(np.roll(orbit_turned[0, :-1], -orbit_speed[0, :-1].argmin()) - orbit_turned[0, orbit_speed[0, :-1].argmin()])"
    " % orbit_turned[0, -1]"
)

EXPECTED: dict[str, Figured] = {
    "coast-down": Figured(
        {}, (Line(0, "mean over a turn", "turn_time", "mean_speed"), Line(1, "amplitude", "time", "1e3 * amplitude"))
    ),
    "torque-balance": Figured({}, (Line(0, "drive", "speed", "drive_torque"),)),
    "response": Figured(
        {},
        (
            Line(0, "axis", "speed", "1e3 * amplitude"),
            Line(1, "x and y", "speed", LAG),
            Line(2, "centre of mass", "speed", "1e3 * centre_distance"),
            Line(3, "with losses", "speed", "vibration_torque + loss_torque"),
        ),
    ),
    "run-up": Figured(
        {"study.until": "1 s"},
        (
            Line(0, "drum", "time", "speed[0]"),
            Line(1, "amplitude", "time", "1e3 * amplitude"),
            Line(2, "p1", "time", "phase[1] * DEG", part=True),
            Line(3, "motor power", "time", "motor_power"),
        ),
    ),
    "sweep": Figured(
        {"study.range": ["95 rad/s", "101 rad/s"], "study.rate": "2 rad/s^2"},
        (Line(0, "rising", "value[0]", "speed[0]"), Line(1, "rising", "value[0]", "1e3 * amplitude[0]")),
    ),
    "activation": Figured(
        {"study.until": "2 s", "study.orientations": ["0 deg", "180 deg"], "study.phases": 2},
        (
            Line(0, "without pendulums", "curve_speed[0]", "1e3 * curve_amplitude[0]"),
            Line(1, "switchable", "orientation * DEG", "1e3 * peak[0].mean(axis=-1)"),
        ),
    ),
    "approximation": Figured(
        {},
        (
            *(Line(0, name, "angle", f"speed_over_angle[{k}]") for k, name in enumerate(DAMPINGS)),
            *(Line(1, name, "angle", f"1e3 * amplitude_over_angle[{k}]") for k, name in enumerate(DAMPINGS)),
            Line(2, 0, "value", "speed_deviation"),
            Line(3, "measured: order 0.90", "factor", "error"),
        ),
    ),
    "cam-contour": Figured(
        {},
        (
            Line(0, "contour", "1e3 * contour_x[0]", "1e3 * contour_y[0]"),
            Line(1, 0, "cam_angle * DEG", "1e3 / curvature[0]", part=True),
            Line(2, 0, "cam_angle * DEG", "pressure_angle[0] * DEG"),
            Line(3, 0, "cam_angle * DEG", "contact_force[0]"),
            Line(4, 0, "cam_angle * DEG", "1e-6 * contact_pressure[0]"),
            Line(5, 0, "cam_angle * DEG", "camshaft_torque"),
            Line(6, 0, "cam_angle * DEG", "output * DEG"),
        ),
    ),
    "cam-correction": Figured(
        {},
        (
            Line(0, "original cam", "1e3 * time", "acceleration[0]"),
            Bars(1, "amplitude"),
            Line(2, 0, "1e3 * time", "shaft_speed * RPM"),
            Bars(3, "speed_amplitude"),
            Line(4, 0, "1e3 * contour_x[0, 0]", "1e3 * contour_y[0, 0]"),
            Line(5, 1, "cam_angle * DEG", "1e3 * moved[0]"),
            Line(6, 0, "cam_angle * DEG", "pressure_angle[0, 0] * DEG"),
            Line(7, 0, "cam_angle * DEG", "1e3 / curvature[0, 0]", part=True),
        ),
    ),
    "cam-law": Figured(
        {},
        (
            Line(0, "motion law", "cam_angle * DEG", "position * DEG"),
            Line(1, "motion law", "cam_angle * DEG", "velocity * DEG"),
            Line(2, "motion law", "cam_angle * DEG", "acceleration * DEG"),
            Line(3, "motion law", "cam_angle * DEG", "jerk * DEG"),
            Bars(4, "amplitude * DEG"),
            Bars(5, "amplitude * order**2 * DEG"),
        ),
    ),
    "cam-prediction": Figured(
        {"study.cuts": 2, "study.simulate": 5, "study.orders": 10},
        (
            Line(0, "original cam", "tau * DEG", "speed[0] * RPM"),
            Bars(1, "output_acceleration"),
            Line(2, "at constant speed", "tau * DEG", "1e-3 * power_at_constant_speed"),
            Line(3, 0, "cut", "cut_residual"),
            Line(4, "original cam", "swept_speed * RPM", "residual_deviation[0] * DEG"),
        ),
    ),
    "capture-probability": Figured(
        {"study.points": 2, "study.samples": 64, "study.probability": None, "study.until": "20 s"},
        (Line(0, 0, "parameter", "estimate"),),
    ),
    "comparison": Figured(
        {},
        (
            Line(0, "0.0195 N m s: unidentified", "curve_1_x[0]", "curve_1_y[0]", part=True),
            Line(1, "0.0195 N m s: unidentified", "curve_2_x[0]", "1e3 * curve_2_y[0]", part=True),
            Line(2, 0, "result['drive.slope'].values", "final_speed"),
            Line(3, 0, "result['drive.slope'].values", "1e3 * final_amplitude"),
        ),
    ),
    "entrainment": Figured(
        {"study.points": 5, "study.resolution": "0.5 rad/s", "study.until": "3 s"},
        (
            Line(0, "averaged equations, stable", "value", "phase[0] * DEG", part=True),
            Line(1, "averaged equations, stable", "value", "speed", part=True),
        ),
    ),
    "exciter-design": Figured(
        {
            "study.reach": 16,
            "study.evaluations": 8,
            "study.population": 8,
            "study.candidates": 1,
            "study.polish": 2,
            "study.corrections": 0,
            "study.beats": 8,
            "study.samples": 4,
        },
        (
            Line(0, "target", "1e6 * share", "1e3 * amplitude_wanted"),
            Line(1, "averaged equations", "share", "1e3 * amplitude_slow"),
            Line(2, "amplitude, averaged equations", "beat_time", "1e3 * beat_amplitude"),
            Line(3, "target", "1e3 * wanted_upper", "wanted_ratio"),
        ),
    ),
    "failure-detection": Figured(
        {},
        (
            Line(0, "without noise", "reading_time", "speed"),
            Line(2, "alarm of the chart", "alarm_time", "seen"),
            Line(3, "stiffness, share of the initial one", "time", "stiffness"),
        ),
    ),
    "drive-failure": Figured(
        {"study.time": "1 s", "study.until": "2 s"},
        (
            Line(0, "e1", "time[0]", "rotor_speed[0, 0]"),
            Line(1, "e2", "time[1]", "-rotor_speed[1, 1]"),
            Line(2, "e2 fails", "time[1]", "1e3 * amplitude[1]"),
        ),
    ),
    "start-stop": Figured(
        {"study.until": "3 s"},
        (
            Line(0, "fan", "time", "rotor_speed[0]"),
            Line(1, "amplitude", "time", "1e3 * amplitude"),
            Line(2, "from the supply", "energy_time", "1e-3 * supplied_energy"),
            Line(3, "damage so far", "damage_time", "damage_course"),
        ),
    ),
    "load-spectrum": Figured(
        {"study.until": "6 s", "study.after": "1 s"},
        (Line(0, "counted", "np.repeat(cumulative, 2)[:-1]", "np.repeat(500 * range_, 2)[1:]", part=True, off=0.02),),
    ),
    "optimise-balancer": Figured(
        {"study.samples": 2, "study.population": 4, "study.evaluations": 8, "study.points": 2, "study.until": "5 s"},
        (
            Line(0, "candidates", "tried_objective[:, 0]", "1e6 * tried_objective[:, 1]"),
            Line(1, "candidates", "tried_objective[:, 0]", "1e3 * tried_objective[:, 2]"),
        ),
    ),
    "orbit-branch": Figured(
        {"study.range": ["0.015 N m s", "0.02 N m s"], "study.values": ["0.017 N m s"]},
        (
            Line(2, 0, "value", "period_phi"),
            Line(1, 0, FROM_SLOWEST, "np.roll(orbit_speed[0, :-1], -orbit_speed[0, :-1].argmin())", part=True, off=5e-3),
            Line(
                3, 0, FROM_SLOWEST, "1e3 * np.roll(orbit_amplitude[0, :-1], -orbit_speed[0, :-1].argmin())", part=True, off=5e-3
            ),
        ),
    ),
    "phase-portrait": Figured({}, (Line(0, 0, "trajectories[0, 0]", "trajectories[0, 1]"),)),
    "speed-curve": Figured(
        {"study.range": ["0.005 N m s", "0.02 N m s"], "study.points": 2},
        (Line(0, 0, "value", "speed", part=True, off=0.02), Line(1, 0, "value", "1e3 * amplitude", part=True, off=0.02)),
    ),
    "stability-map": Figured(
        {
            "study.cells": 2,
            "study.orbits": False,
            "study.range": ["0.005 N m s", "0.02 N m s"],
            "study.second_range": ["200 N s/m", "260 N s/m"],
        },
        (Line(0, 0, "boundary_x", "boundary_y", part=True),),
    ),
    "synchronous-states": Figured({"study.axes": {"speed": ["10 rad/s", "400 rad/s", 30], "ratio": [0, 3, 20]}}, ()),
    "voltage-dip": Figured(
        {"study.points": 2},
        (
            Line(0, 0, "time[0]", "speed[0, 0]"),
            Line(1, 0, "time[0]", "1e3 * amplitude[0]"),
            Line(2, "when the voltage returns", "dip_duration", "dip_speed_at_recovery"),
        ),
    ),
}


@pytest.fixture(scope="module")
def drawn(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, coarse_angles: None
) -> tuple[xr.Dataset, Figure]:
    kind = request.param
    file = tmp_path_factory.mktemp(kind) / f"{kind}.toml"
    file.write_text(str(studies()[kind].template), encoding="utf-8")
    result = run_study(read_study(str(file), EXPECTED[kind].settings))
    return result, draw(result)


def value(result: xr.Dataset, expression: str) -> np.ndarray:
    """Numbers (N,) of a Dataset by the names of its variables."""
    names = {str(name): variable.values for name, variable in result.variables.items()}
    names |= {"range_": names.get("range"), "result": result, "np": np, "DEG": DEG, "RPM": RPM}
    return np.atleast_1d(np.asarray(eval(expression, {}, names), float)).ravel()


def assert_shown(axis: Axes, line: Line, result: xr.Dataset) -> None:
    """All points of a line are those of the Dataset, from the first to the last."""
    every = axis.get_lines()
    named = [every[line.name]] if isinstance(line.name, int) else [x for x in every if x.get_label() == line.name]
    assert named, f"{line.name!r} is none of {[x.get_label() for x in every]}"
    data = [np.concatenate([np.asarray(x.get_data()[k], float).ravel() for x in named]) for k in (0, 1)]
    expected = [value(result, text) for text in (line.x, line.y)]
    points, known = np.column_stack(data), np.column_stack(expected)
    points, known = (p[np.isfinite(p).all(axis=1)] for p in (points, known))
    assert len(points)
    scale = np.maximum(np.abs(known).max(axis=0), 1e-300)
    distance, _ = cKDTree(known / scale).query(points / scale)
    assert distance.max() < line.off, f"{line}: off by {distance.max()} of the largest"
    if not line.part:
        assert points.min(axis=0) == pytest.approx(known.min(axis=0), rel=1e-9, abs=1e-12 * scale.max())
        assert points.max(axis=0) == pytest.approx(known.max(axis=0), rel=1e-9, abs=1e-12 * scale.max())


PAGES = {"sweep", "torque-balance", "start-stop"}  # of which a report is written, too
LONG = {"exciter-design", "capture-probability", "optimise-balancer", "entrainment"}  # searches, or hundreds of runs
KINDS = [pytest.param(kind, marks=pytest.mark.slow) if kind in LONG else kind for kind in EXPECTED]


@pytest.mark.parametrize("drawn", KINDS, indirect=True)
def test_lines_are_where_the_data_are(drawn: tuple[xr.Dataset, Figure], request: pytest.FixtureRequest) -> None:
    result, figure = drawn
    for shown in EXPECTED[request.node.callspec.params["drawn"]].shown:
        axis = figure.axes[shown.panel]
        if isinstance(shown, Bars):
            heights = sorted(bar.get_height() for bar in axis.patches if np.isfinite(bar.get_height()))
            known = sorted(np.abs(value(result, shown.heights)))[-len(heights) :]
            assert heights == pytest.approx(known, rel=1e-9, abs=1e-6 * known[-1])
            assert len(heights) > 2
        else:
            assert_shown(axis, shown, result)


@pytest.mark.parametrize("drawn", KINDS, indirect=True)
def test_every_panel_is_drawn_alone_as_in_the_whole(drawn: tuple[xr.Dataset, Figure]) -> None:
    result, figure = drawn
    panels = [axis for axis in figure.axes if axis in {one for row in sheet_of(figure).rows for one in row}]
    alone = Figure().subplots(1, len(panels), squeeze=False)[0]
    draw(result, axes=alone)
    names = panel_names(result)
    for axis, panel in zip(alone, panels, strict=True):
        assert (len(axis.lines), len(axis.patches), len(axis.collections)) == tuple(
            map(len, (panel.lines, panel.patches, panel.collections))
        )
        assert axis.get_ylabel().split() == panel.get_ylabel().split()
    figure_checks.check(draw(result, panels=names[-1]))


@pytest.mark.parametrize("drawn", KINDS, indirect=True)
def test_all_of_a_result_is_as_stated(drawn: tuple[xr.Dataset, Figure], request: pytest.FixtureRequest) -> None:
    stated.check(f"template-{request.node.callspec.params['drawn']}", *drawn)


@pytest.mark.parametrize("drawn", KINDS, indirect=True)
def test_the_answer_is_one_sentence_in_report_figure_and_page(drawn: tuple[xr.Dataset, Figure], tmp_path: Path) -> None:
    result, figure = drawn
    page = None
    if result.wucht.study in PAGES:
        result.to_netcdf(tmp_path / "result.nc")
        page = write_report([tmp_path / "result.nc"], tmp_path / "page.html").read_text(encoding="utf-8")
    (answer,) = [line.removeprefix("verdict: ") for line in report(result) if line.startswith("verdict: ")]
    figure.savefig(tmp_path / "figure.png", dpi=40)
    heading = " ".join(text.get_text() for text in figure.texts).replace("\N{NO-BREAK SPACE}", " ")
    begin, ellipsis, _ = " ".join(heading.split()).removeprefix(result.title).strip().partition("\N{HORIZONTAL ELLIPSIS}")
    assert answer.startswith(begin) if ellipsis and len(begin) < len(answer) else begin.startswith(answer), (answer, begin)
    assert len(begin) > 20, begin
    assert page is None or answer in html.unescape(page)


def test_every_study_is_expected() -> None:
    assert {kind for kind, study in studies().items() if study.template} == {*EXPECTED, "basin"}


def test_a_basin_has_its_starts_along_its_axes(tmp_path: Path) -> None:
    """As many cells in one direction as in the other would hide that they were changed."""
    (tmp_path / "basin.toml").write_text(str(studies()["basin"].template), encoding="utf-8")
    axes = {"psi": ["0 deg", "360 deg", 5], "delta": ["0 deg", "180 deg", 3]}
    result = run_study(read_study(str(tmp_path / "basin.toml"), {"study.axes": axes}))
    assert (result.sizes["psi"], result.sizes["delta"]) == (5, 3)
    axis = draw(result).axes[0]
    assert axis.get_xlabel().startswith("psi: mean phase")
    assert axis.get_ylabel().startswith("delta: phase difference")
    (image,) = axis.images
    assert image.get_extent() == pytest.approx([0.0, 2 * math.pi, 0.0, math.pi])
    cells, outcomes = np.asarray(image.get_array()).ravel(), result.outcome.transpose("delta", "psi").values.ravel()
    pairs = set(zip(cells, outcomes, strict=True))
    assert len(pairs) == len(set(outcomes)) == len(set(cells))
    assert len(pairs) > 1


@pytest.mark.parametrize("page", [PRINT, JOURNAL])
def test_a_style_is_honoured(page: Any, tmp_path: Path) -> None:
    file = tmp_path / "law.toml"
    file.write_text(str(studies()["cam-law"].template), encoding="utf-8")
    figure = draw(run_study(read_study(str(file))), page)
    assert figure.get_size_inches()[0] == pytest.approx(page.width) or page is JOURNAL
    assert bool(figure.get_suptitle()) == (page is PRINT)
