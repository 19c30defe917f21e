"""The study from the command line: its template, its refusals, and what one by one means."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
Refused = Callable[..., str]
Answered = Callable[..., dict[str, Any]]
pytestmark = pytest.mark.usefixtures("no_figures")
COARSE = ("--set", "study.axes.psi=[0, 6.283185307179586, 2]", "--set", "study.axes.delta=[0, 3.14, 2]")


@pytest.mark.slow
def test_its_template_runs_and_is_drawn_again(here: Path, wucht: Command, from_template: Answered) -> None:
    summary = from_template("basin", *COARSE)
    assert sum(summary["fractions"].values()) == pytest.approx(1.0)
    assert set(summary["uncertainty"]) == set(summary["fractions"])
    assert summary["runs"] == 4
    told = wucht("run", "basin.toml", "-o", "again", *COARSE, "--set", "study.until=0.3 s")
    assert told.code == 0, told.err
    assert "unidentified 100 %" in told.out
    assert "integrated until 0.3 s" in told.out
    assert "a longer study.until may identify them" in told.out + told.err


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("study.axes.psi=[0, 1]", ("study.axes.psi", "must be [lo, hi, cells]")),
        ("study.axes.p1=[0, 1, 4]", ("study.axes", "there must be two axes")),
        ("study.axes.delta=[3, 1, 4]", ("study.axes.delta", "low below high")),
        ('study.axes.delta=["1 mm", 1, 4]', ("study.axes.delta[0]", "this one is a length")),
        ("study.start.psi=1", ("study.axes.psi", "given by study.start too")),
        ("study.refine=11", ("study.refine", "from 0 to 10")),
        ("study.refin=1", ("study.refin", "did you mean 'refine'?")),
        ("study.model=both", ("study.model", "'full' or 'slow'")),
        ("study.until=-1 s", ("study.until", "greater than 0")),
        ("study.tolerance=1", ("study.tolerance", "between")),
    ],
)
def test_bad_input_is_one_sentence(setting: str, says: tuple[str, ...], here: Path, wucht: Command, refused: Refused) -> None:
    wucht("new", "basin")
    refused("run", "basin.toml", "--set", setting, says=says)


def test_axes_of_ones_own_on_a_file_of_another_study(refused: Refused) -> None:
    axes = 'study.axes={"drum.mass": [1, 2, 4], "drive.slop": [0, 1, 4]}'
    says = ("study.axes.drive.slop", "did you mean 'drive.slope'?")
    refused("run", "drozdetskaya-2020/r1", "--set", "study.kind=basin", "--set", axes, says=says)


def test_a_file_of_another_study_keeps_its_own_axes(here: Path, wucht: Command, refused: Refused) -> None:
    """``synchronous-states`` has a key of this name that means something else."""
    wucht("new", "basin")
    refused("run", "sperling-rollers/stability-map", "--set", "study.kind=basin", says=("study.axes", "this key is missing"))


def test_members_that_need_it_are_run_one_by_one_and_that_is_told(here: Path, wucht: Command) -> None:
    axes = 'study.axes={"b.speed": [0, 4, 2], "p.angle": [0, 3, 2]}'
    Path("released.toml").write_text(
        """
[machine.carrier]
mass = "1 kg"
directions = "x"
frequency = "3 Hz"
[[machine.bodies]]
kind = "rotor"
name = "b"
mass = "1 kg"
unbalance = "1e-2 kg m"
inertia = "1e-3 kg m^2"
[[machine.bodies]]
kind = "pendulum"
name = "p"
about = "b"
mass = "50 g"
length = "0.1 m"
damping = "1e-3 N m s"
release = { speed = "5 rad/s" }
[machine.drive]
kind = "linear"
slope = "1e-4 N m s"
no_load_speed = "5.5 rad/s"
[study]
kind = "basin"
until = "20 s"
""",
        encoding="utf-8",
    )
    done = wucht("run", "released.toml", "-o", "out", "--set", axes)
    assert done.code == 0, done.err
    assert "one by one" in done.out
    assert "bodies are released on the way" in done.out
