"""The figure and the report of a speed curve, from the Dataset alone; and the command."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from wucht.files.catalogue import load_machine
from wucht.results.style import COLOURS
from wucht.studies.registry import study_of
from wucht.studies.runner import draw, report, run
from wucht.studies.speed_curve.spec import SpeedCurve
from wucht.studies.study_file import run_file

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
    assert texts[3:] == ["stable", "unstable", "unstable, several\ndisturbances grow", "fold", "as it is:\nu = 2.5"]
    assert amplitude.get_ylim()[0] == 0 and amplitude.get_xlabel().startswith("u: slope of the motor")
    assert sum(len(line.get_xdata()) for line in speed.lines if line.get_linestyle() == "None") == r.sizes["special"]


def test_values_of_a_second_parameter_have_a_colour_each() -> None:
    drawn = draw(result(second="sigma", second_values=(0.06, 0.1), only=("together",), points=2))
    texts = [t.get_text() for t in drawn.axes[0].get_legend().get_texts()]
    assert texts[:2] == ["sigma = 0.06", "sigma = 0.1"]


def test_the_plane_of_two_parameters_is_a_panel_of_its_own() -> None:
    drawn = draw(result(second="sigma", second_range=(0.05, 0.15), only=("together",), points=2))
    assert len(drawn.axes) == 3 and drawn.axes[2].get_ylabel() == "sigma"
    texts = [t.get_text() for t in drawn.axes[2].get_legend().get_texts()]
    assert texts == ["folds, type II: together"]


def test_it_is_reported() -> None:
    lines = "\n".join(report(result()))
    assert "branch 1  type I: compensating" in lines and "stable at u from 0.5 to 1.8331" in lines
    assert "fold         u = 1.833108: 0.77588" in lines and "complete     yes at 7 values of u" in lines


def test_the_command(wucht: Callable[..., Any]) -> None:
    asked = ("kind=speed-curve", "along=drive.slope", 'range=["0.001 N m s", "0.002 N m s"]', "points=1")
    sets = [x for setting in asked for x in ("--set", f"study.{setting}")]
    done = wucht("run", "drozdetskaya-2020/r1", *sets, "-o", "out", "--json")
    assert done.code == 0, done.err
    answer = json.loads(done.out)
    assert answer["summary"]["special_points"][0]["kind"] == "fold" and answer["summary"]["branches"]
    assert sorted(p.name for p in Path("out").iterdir()) == ["result.nc", "speed-curve.png", "summary.json"]
    assert wucht("plot", "out/result.nc").code == 0


def test_the_template_runs(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(study_of("speed-curve").template or "", encoding="utf-8")
    summary = run_file(file).wucht.summary
    assert [p["kind"] for p in summary["special_points"]].count("fold") == 4
