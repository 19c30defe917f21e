"""The wheel in an empty environment: on each Python that is there, and with the lowest versions of what it depends on."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PYENV = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
MINORS = (11, 12, 13, 14)
THIS = sys.version_info.minor

pytestmark = pytest.mark.slow


def _python(minor: int) -> str:
    """A Python of this version: that of the tests, on the search path, or of pyenv."""
    if minor == THIS:
        return sys.executable
    found = shutil.which(f"python3.{minor}"), *map(str, sorted(PYENV.glob(f"3.{minor}.*/bin/python3.{minor}")))
    return next((path for path in found if path and not subprocess.run([path, "-c", ""], check=False).returncode), "")


def _pip(python: str | Path, *words: object) -> str:
    """What pip says; nothing where it succeeds."""
    command = [str(python), "-m", "pip", *map(str, words), "--quiet", "--disable-pip-version-check"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode else ""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    if _pip(sys.executable, "download", "--no-deps", "--dest", folder / "tried", "lazy-loader"):
        pytest.skip("pip reaches no registry")
    sources = folder / "sources"  # building replaces the page, which other tests show meanwhile
    shutil.copytree(ROOT / "src", sources / "src", ignore=shutil.ignore_patterns("__pycache__", "built"))
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    assert _pip(sys.executable, "wheel", "--no-deps", "--wheel-dir", folder, sources) == ""
    (built,) = folder.glob("wucht-*.whl")
    return built


def _first_run(python: str, folder: Path, *installed: object) -> dict[str, Any]:
    """The summary of the laundry drum, run by the command that pip puts into an environment of nothing else."""
    subprocess.run([python, "-m", "venv", folder / "venv"], check=True)
    programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    assert _pip(programs / "python", "install", *installed) == ""
    outside = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = [programs / "wucht", "run", "practice/laundry-drum", "-o", "out", "--json"]
    done = subprocess.run(words, cwd=folder, env=outside, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "out/run-up.png").stat().st_size > 10_000
    summary: dict[str, Any] = json.loads(done.stdout)["summary"]
    return summary


def _is_that_of_its_page(summary: dict[str, Any]) -> None:
    """As tests/test_practice_runs.py has it."""
    assert summary["outcome"] == "compensated"
    assert summary["final_speed"] == pytest.approx(126.14, rel=1e-4)
    assert summary["peak_amplitude"] == pytest.approx(0.01067, rel=1e-3)


@pytest.mark.parametrize("minor", MINORS)
def test_the_wheel_runs_in_an_empty_environment(minor: int, wheel: Path, tmp_path: Path) -> None:
    if not (python := _python(minor)):
        pytest.skip(f"there is no Python 3.{minor}")
    _is_that_of_its_page(_first_run(python, tmp_path, wheel))


def test_the_wheel_runs_with_the_lowest_versions_of_its_dependencies(wheel: Path, tmp_path: Path) -> None:
    needs = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    lowest = tmp_path / "lowest.txt"
    lowest.write_text("\n".join(re.sub(">=", "==", need) for need in needs), encoding="utf-8")
    _is_that_of_its_page(_first_run(sys.executable, tmp_path, wheel, "--only-binary", ":all:", "--constraint", lowest))
