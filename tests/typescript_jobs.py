"""Jobs for the page's TypeScript, run by Node."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.node import run_in_node

import wucht

ENGINE, JOBS = Path(wucht.__file__).parent / "web", Path(__file__).parent / "dynamics" / "live_drawing_jobs.mjs"


def run_jobs(folder: Path, jobs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Any]:
    """Results of jobs, each of a machine's script, in one process."""
    entries, paths = [], dict[str, Path]()
    for script, job in jobs:
        path = paths.setdefault(script, folder / f"machine-{len(paths)}.mjs")
        path.write_text(script, encoding="utf-8")
        entries.append({"script": str(path), **job})
    (folder / "jobs.json").write_text(json.dumps(entries), encoding="utf-8")
    run_in_node(JOBS, ENGINE, folder / "jobs.json", folder / "results.json")
    results: list[Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return results
