"""The gate of answers sees one bit, one word, one line."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.answering import ANSWER, DRAWN
from tests.same_answers import differences

pytestmark = pytest.mark.slow  # of the comparison of source trees
_SOURCE = Path(__file__).parents[1] / "src"
_CASE = {"kind": "catalogue", "file": "sperling-vibration/figure-2a", "words": ["--set", "study.kind=torque-balance"]}


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two answers to one question, from processes of their own."""
    folders = tuple(tmp_path_factory.mktemp("answer") for _ in range(2))
    for folder in folders:
        words = [sys.executable, str(Path(__file__).with_name("answering.py")), json.dumps(_CASE | {"is_interrupted": True})]
        subprocess.run(words, cwd=folder, env=os.environ | {"PYTHONPATH": str(_SOURCE)}, check=True)
    return folders[0], folders[1]


def test_the_same_source_gives_the_same_answer(answers: tuple[Path, Path]) -> None:
    assert list(differences(*answers)) == []
    assert (answers[0] / "resumed" / "result.nc").exists()
    sources = json.loads((answers[0] / ANSWER).read_text())["sources"]
    assert "src/wucht/studies/torque_balance.py" in sources
    assert "src/wucht/machines/catalogue/sperling-vibration/figure-2a.toml" in sources


def _change_number(folder: Path) -> None:
    with h5py.File(folder / "out" / "result.nc", "r+") as file:
        file["speed"][3] = np.nextafter(file["speed"][3], np.inf)


def _change_unit(folder: Path) -> None:
    with h5py.File(folder / "resumed" / "result.nc", "r+") as file:
        file["speed"].attrs["units"] = "rpm"


def _change_figure(folder: Path) -> None:
    with np.load(folder / DRAWN) as drawn:
        changed = dict(drawn)
    name = next(key for key in changed if key.endswith("line 0"))
    changed[name].flat[0] = np.nextafter(changed[name].flat[0], np.inf)
    np.savez(folder / DRAWN, **changed)


def _change_line(folder: Path) -> None:
    file = folder / ANSWER
    file.write_text(file.read_text().replace("working point", "operating point", 1))


def _change_summary(folder: Path) -> None:
    file = folder / "out" / "summary.json"
    summary = json.loads(file.read_text())
    summary["summary"]["free_speed"] = float(np.nextafter(summary["summary"]["free_speed"], np.inf))
    file.write_text(json.dumps(summary))


def _lose_file(folder: Path) -> None:
    (folder / "resumed" / "result.nc").unlink()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (_change_number, "out/result.nc: variable speed"),
        (_change_unit, "resumed/result.nc: variable speed/units: "),
        (_change_figure, "figure 0/0/line 0"),
        (_change_line, "text: "),
        (_change_summary, "summary/summary/free_speed: "),
        (_lose_file, "resumed/result.nc: exists once"),
    ],
)
def test_the_least_change_is_named(
    answers: tuple[Path, Path], change: Callable[[Path], None], named: str, tmp_path: Path
) -> None:
    changed = tmp_path / "changed"
    shutil.copytree(answers[1], changed)
    change(changed)
    (difference,) = differences(answers[0], changed)
    assert difference.startswith(named)
