"""The study from the command line: its template, and its refusals."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Command = Callable[..., Any]
Refused = Callable[..., str]
Answered = Callable[..., dict[str, Any]]
pytestmark = pytest.mark.usefixtures("no_figures")


def test_its_template_runs_and_is_drawn_again(from_template: Answered) -> None:
    summary = from_template("capture-probability", "--set", "study.points=2", "--set", "study.range=[0.05, 0.06]")
    assert len(summary["probability"]) == 2
    assert {"drive.slope", "estimate", "low", "high"} <= set(summary["probability"][0])
    assert summary["smallest"] == 0.05


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("study.samples=100", ("study.samples", "multiple of 16")),
        ("study.sample=128", ("study.sample", "did you mean 'samples'?")),
        ("study.along=drive.slop", ("study.along", "did you mean 'drive.slope'?")),
        ("study.range=[0.06, 0.01]", ("study.range", "low below high")),
        ('study.random.psi={"uniform": ["1 mm", 1]}', ("study.random.psi.uniform[0]", "this one is a length")),
        ('study.random.psi={"uniform": [2, 1]}', ("study.random.psi.uniform", "low below high")),
        ('study.random.p3={"uniform": [0, 1]}', ("study.random.p3", "did you mean")),
        ("study.outcome=passd", ("study.outcome", "did you mean 'passed'?")),
        ("study.probability=1.5", ("study.probability", "given 1.5")),
        ("study.sensitivity=true", ("study.at", "this key is missing")),
        ("study.start.psi=1", ("study.random.psi", "given by study.start too")),
    ],
)
def test_bad_input_is_one_sentence(setting: str, says: tuple[str, ...], here: Path, wucht: Command, refused: Refused) -> None:
    wucht("new", "capture-probability")
    refused("run", "capture-probability.toml", "--set", setting, says=says)
