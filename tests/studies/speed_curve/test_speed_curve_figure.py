"""The figure and the report of a speed curve, from the Dataset alone; and the command."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht import SpeedCurve, System, UserSystem, draw, load_machine, report, run, run_file
from wucht.plots.style import COLOURS
from wucht.studies.registry import study_of

TABLE = "drozdetskaya-2020/table-5.1"


@cache
def result(**asked: Any) -> Any:
    return run(SpeedCurve(along="u", range=(0.5, 8.0), **asked), load_machine(TABLE))


def test_stable_is_solid_and_unstable_dashed() -> None:
    speed, amplitude = draw(result()).axes
    r = result()
    drawn = {
        (line.get_color(), line.get_linestyle() == "-") for line in speed.lines if line.get_linestyle() not in ("None", ":")
    }
    assert (COLOURS[2], True) in drawn and (COLOURS[2], False) not in drawn  # type I: stable everywhere
    assert (COLOURS[1], False) in drawn and (COLOURS[1], True) not in drawn  # type III: nowhere
    assert {(COLOURS[0], True), (COLOURS[0], False)} <= drawn  # type II
    solid = [line for line in speed.lines if line.get_color() == COLOURS[0] and line.get_linestyle() == "-"]
    assert max(x for line in solid for x in line.get_xdata()) == pytest.approx(1.8331080, abs=1e-6)
    texts = [t.get_text() for t in speed.get_legend().get_texts()]
    assert sorted(texts[:3]) == ["type I: compensating", "type II: together", "type III: opposed"]
    assert texts[3:] == ["stable", "unstable", "unstable, several\ndisturbances grow", "fold", "as it is:\n$u$ = 2.5"]
    assert {t.get_text() for t in speed.texts} <= {"I", "II", "III"} and "II" in {t.get_text() for t in speed.texts}
    assert amplitude.get_ylim()[0] == 0 and amplitude.get_xlabel().startswith("$u$: slope of the motor")
    assert sum(len(line.get_xdata()) for line in speed.lines if line.get_linestyle() == "None") == r.sizes["special"]


@pytest.mark.slow
def test_values_of_a_second_parameter_have_a_colour_each() -> None:
    drawn = draw(result(second="sigma", second_values=(0.06, 0.1), only=("together",), points=2))
    texts = [t.get_text() for t in drawn.axes[0].get_legend().get_texts()]
    assert texts[:2] == ["$\\sigma$ = 0.06", "$\\sigma$ = 0.1"]
    written = {t.get_text() for t in drawn.axes[0].texts}
    assert {"0.06", "0.1"} <= written  # at the folds, for a print without colours


@pytest.mark.slow
@pytest.mark.parametrize(
    ("along", "bounds", "more"),
    [
        ("drum.eccentricity", ("0.5 mm", "1.5 mm"), {}),
        ("drive.no_load_speed", ("180 rad/s", "220 rad/s"), {}),
        ("drive.slope", ("0.001 N m s", "0.002 N m s"), {"second": "carrier.damping", "second_values": ("300 N s/m",)}),
    ],
)
def test_the_legend_is_within_the_figure(along: str, bounds: tuple[str, str], more: dict[str, Any]) -> None:
    spec = SpeedCurve(along=along, range=bounds, points=1, only=("together",), **more)
    r = run(spec, load_machine("drozdetskaya-2020/r1"))
    drawn = draw(r)
    drawn.canvas.draw()
    legend = drawn.axes[0].get_legend()
    assert (legend is None) == (not r.sizes["branch"]), "what is not there has no name"
    extent = drawn.bbox if legend is None else legend.get_window_extent()
    assert extent.x1 <= drawn.bbox.x1 and extent.y0 >= drawn.bbox.y0


def test_over_a_speed_the_ratio_to_it_is_drawn() -> None:
    """The compensating state of a rotor without friction runs at the no-load speed."""
    spec = SpeedCurve(along="drive.no_load_speed", range=("100 rad/s", "300 rad/s"), points=1)
    axis = draw(run(spec, load_machine("drozdetskaya-2020/r1"))).axes[0]
    assert " ".join(axis.get_ylabel().split()) == "speed of the main rotor / no-load speed of the drive"
    (level,) = [line for line in axis.lines if line.get_color() == COLOURS[2] and line.get_linestyle() == "-"]
    assert np.asarray(level.get_ydata()) == pytest.approx(1.0, abs=1e-9)


def test_a_curve_is_smooth_at_its_fold() -> None:
    """Near the fold of x' = mu + x^2 the lines that are drawn lie on x^2 = -mu."""
    x, mu = sp.symbols("x mu", real=True)
    own = UserSystem(System((x,), (mu + x**2,), (mu,)), {"mu": -0.5})
    drawn = draw(run(SpeedCurve(along="mu", range=[-1, 1], ranges={"x": [-2, 2]}), own)).axes[0]
    lines = [line for line in drawn.lines if len(line.get_xdata()) > 20]
    for line in lines:
        assert np.asarray(line.get_ydata()) ** 2 == pytest.approx(-np.asarray(line.get_xdata()), abs=2e-4)
    assert len(lines) == 2


def test_the_plane_of_two_parameters_is_a_panel_of_its_own() -> None:
    drawn = draw(result(second="sigma", second_range=(0.05, 0.15), only=("together",), points=2))
    assert len(drawn.axes) == 3 and drawn.axes[2].get_ylabel() == "$\\sigma$"
    texts = [t.get_text() for t in drawn.axes[2].get_legend().get_texts()]
    assert texts == ["folds, type II:\ntogether"]


def test_special_points_of_the_plane_are_where_both_parameters_have_them() -> None:
    """The cusp of x' = (a - 0.3) + (b - 0.6) x - x^3."""
    x, a, b = sp.symbols("x a b", real=True)
    own = UserSystem(System((x,), (a - 0.3 + (b - 0.6) * x - x**3,), (a, b)), {"a": 0.3, "b": 0.9})
    asked = {"along": "a", "range": [-1, 2], "ranges": {"x": [-2, 2]}, "second": "b", "second_range": [0, 2], "points": 1}
    plane = draw(run(SpeedCurve(**asked), own)).axes[-1]
    (cusp,) = [line for line in plane.lines if line.get_label() == "cusp"]
    assert (cusp.get_xdata(), cusp.get_ydata()) == (pytest.approx([0.3], abs=1e-6), pytest.approx([0.6], abs=1e-6))


def test_it_is_reported() -> None:
    lines = "\n".join(report(result()))
    assert "branch 1     type I: compensating" in lines and "stable at u from 0.5 to 1.8331 (0.6" in lines
    assert (
        "fold         u = 1.833108: speed 0.77588" in lines
        and "bodies of different mean speeds" in lines
        and "complete     yes at 7 values of u" in lines
    )


def test_the_command(wucht: Callable[..., Any]) -> None:
    asked = ("kind=speed-curve", "along=drive.slope", 'range=["0.001 N m s", "0.002 N m s"]', "points=1")
    sets = [x for setting in asked for x in ("--set", f"study.{setting}")]
    done = wucht("run", "drozdetskaya-2020/r1", *sets, "-o", "out", "--json")
    assert done.code == 0, done.err
    answer = json.loads(done.out)
    assert answer["summary"]["special_points"][0]["kind"] == "fold" and answer["summary"]["branches"]
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "speed-curve.png", "summary.json"]
    assert wucht("plot", "out/result.nc").code == 0


@pytest.mark.slow
def test_the_template_runs(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(study_of("speed-curve").template or "", encoding="utf-8")
    summary = run_file(file).wucht.summary
    assert [p["kind"] for p in summary["special_points"]].count("fold") == 4
