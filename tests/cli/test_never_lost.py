"""A result that was computed is never lost by what shows it: a figure, table or report that fails is a warning."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wucht as package
from wucht.results.output_folder import load_result

Command = Callable[..., Any]
OWN_STUDY = Path(__file__).parents[2] / "examples" / "own_study.py"
POLES = ("practice/laundry-drum", "--set", "study.kind=poles", "-o", "out")
FIGURE, REPORT = 'raise LookupError("no such panel")', "return [str(1 / 0)]"
BOGDANOV_TAKENS = """
title = "A fold and a Hopf point in one"
[system]
states = { x = "y", y = "b + x^2 + x*y" }
parameters = { b = -0.5 }
[study]
kind = "speed-curve"
along = "b"
range = [-1.0, 1.0]
ranges = { x = [-2, 2], y = [-1, 1] }
"""


def own_study(figure: str = "", report: str = "") -> str:
    """The example of a study in a user's file, with other methods that show its result: their bodies."""
    text = OWN_STUDY.read_text(encoding="utf-8")
    for name, body in (("draw", figure), ("report", report)):
        if body:
            text = text.replace(f"def {name}(self, result", f"def unused_{name}(self, result")
            text += f"\n    def {name}(self, result):\n        {body}\n"
    Path("my_study.py").write_text(text, encoding="utf-8")
    return "my_study.py"


def outside(*words: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """The command line as a process of its own: a module that a file names is imported but once in a process."""
    source = str(Path(package.__file__).parent.parent)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([source, os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "wucht", *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120, **options)


@pytest.mark.slow
def test_a_figure_and_a_report_that_fail_are_warnings(here: Path) -> None:
    """Of a study in a user's file. What they would have shown is in the files, and a study without the fault adds them."""
    module = own_study(FIGURE, REPORT)
    ended = outside("run", *POLES, "--import", module, "--csv", "--json")
    assert ended.returncode == 0, ended.stderr
    document = json.loads(ended.stdout)
    figure, report = document["warnings"]
    assert re.fullmatch(r"not written: figure poles\.png \(LookupError in my_study\.py, line \d+: no such panel\); .*", figure)
    assert report.startswith("not written: report (ZeroDivisionError in my_study.py, line ")
    assert [line for line in ended.stderr.splitlines() if "not written" in line] == [f"warning: {w}" for w in (figure, report)]
    names = ["poles-numbers.csv", "poles-pole.csv", "poles-poles.csv", "result.nc", "summary.json"]
    assert sorted(path.name for path in Path("out").iterdir()) == names
    assert sorted(document["files"]) == [str(Path("out") / name) for name in names]
    assert json.loads(Path("out/summary.json").read_text(encoding="utf-8")) == document
    result = load_result(Path("out"))
    assert result.wucht.warnings == document["warnings"] and result.wucht.finished
    assert result.pole_rate.values == pytest.approx([-2.8404, -3.3138], rel=1e-4)

    in_words = outside("run", *POLES, "--import", module)
    assert in_words.returncode == 0
    assert in_words.stdout.startswith("verdict: 2 poles; the least damped has a damping ratio of 0.2035\n")
    plot = outside("plot", "out", "--import", module)
    assert (plot.returncode, plot.stderr.count("\n")) == (1, 1), plot.stderr
    assert "out/result.nc: its figure cannot be drawn: LookupError in my_study.py" in plot.stderr
    page = outside("report", "out", "--import", module, "-o", "page.html")
    assert page.returncode == 0, page.stderr
    assert "not written: figure (LookupError in my_study.py" in page.stderr
    assert "not written: figure" in (text := Path("page.html").read_text(encoding="utf-8")) and "damping ratio" in text

    mended = outside("run", *POLES, "--import", own_study(), "--resume", "--json")
    assert json.loads(mended.stdout)["warnings"] == load_result(Path("out")).wucht.warnings == []
    assert Path("out/poles.png").is_file()


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_process_that_ends_while_it_draws_has_its_result(here: Path, number: int) -> None:
    """The first Ctrl-C is kept for the next report of progress, the second ends the process at once; a kill cannot wait."""
    kill = f"import os; [os.kill(os.getpid(), {int(number)}) for _ in range(2)]; return self.unused_draw(result)"
    ended = outside("run", *POLES, "--import", own_study(figure=kill), "--csv")
    assert ended.returncode == (130 if number == signal.SIGINT else -number), ended.stderr
    result, summary = load_result(Path("out")), json.loads(Path("out/summary.json").read_text(encoding="utf-8"))
    assert result.wucht.finished and summary["summary"] == result.wucht.summary
    assert summary["files"] == ["out/result.nc", "out/summary.json"], "those that are there"
    assert outside("run", *POLES, "--import", own_study(), "--resume").returncode == 0
    assert sorted(path.name for path in Path("out").iterdir()) == ["poles.png", "result.nc", "summary.json"]


def test_points_of_a_branch_that_are_one_in_rounding_are_drawn(wucht: Command) -> None:
    """Of x'' = b + x^2 + x x' fold and Hopf point coincide at the origin; its equilibria are the parabola b = -x^2."""
    Path("bt.toml").write_text(BOGDANOV_TAKENS, encoding="utf-8")
    ended = wucht("run", "bt.toml", "-o", "out", "--json")
    assert ended.code == 0, ended.err
    assert not any("not written" in warning for warning in ended.document["warnings"])
    result = load_result(Path("out"))
    assert result.special_value.values == pytest.approx([0.0, 0.0], abs=1e-12)
    curves = [np.array(line.get_data()) for line in package.draw(result).axes[0].get_lines()]
    drawn = np.concatenate([c for c in curves if c.shape[1] > 20], axis=1)
    drawn = drawn[:, np.isfinite(drawn).all(axis=0)]
    assert np.ptp(drawn[1]) == pytest.approx(2.0, abs=1e-9)
    assert np.abs(drawn[0] + drawn[1] ** 2).max() < 2e-4, "Akima's cubics between the points"
