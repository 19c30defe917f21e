"""Which libraries a command loads: those of its answer, and none that would only take time."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Study = Callable[..., Path]
UNUSED = {"dask", "distributed", "heyoka", "rich", "clarabel", "pymoo", "SALib", "IPython", "fastapi"}
UNUSED_MODULES = {"matplotlib.pyplot", "scipy.integrate", "scipy.linalg", "scipy.optimize", "scipy.special", "scipy.stats"}
WITH_DASK = """
import numpy as np

from wucht.extending import Answer, Study, new_figure


class Blocks(Study):
    \"\"\"Count in blocks.\"\"\"

    kind = "blocks"

    def prepare(self, machine):
        return len(machine.bodies)

    def solve(self, machine, count, work):
        from dask import array

        a = Answer(machine.units)
        a.curve("total", array.ones(count).sum().compute(), "number of bodies", over="")
        a.sentence = f"{count} bodies"
        yield a

    def draw(self, result):
        return new_figure(1, "", result.attrs["sentence"], 2.0)[0]
"""
ENDING = """
import sys
from wucht.cli import main

try:
    main()
finally:
    print(*(name for name, module in sys.modules.items() if module is not None), file=sys.stderr)
"""


def _loaded_modules(*words: object) -> set[str]:
    """The modules that are loaded at the end of a command in a process of its own."""
    command = [sys.executable, "-c", ENDING, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return set(done.stderr.splitlines()[-1].split())


@pytest.mark.slow
def test_a_warm_run_loads_no_library_that_it_does_not_use(study: Study) -> None:
    file = study()
    _loaded_modules("run", file, "-o", "out")  # derives and compiles
    modules = _loaded_modules("run", file, "-o", "out")
    packages = {module.partition(".")[0] for module in modules}
    assert {"wucht", "numpy", "xarray", "matplotlib"} <= packages
    assert packages & UNUSED == set()
    assert modules & UNUSED_MODULES == set()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["plot", *(name for name in ("report", "export"))])
def test_what_shows_a_result_loads_neither_dask_nor_heyoka(command: str, study: Study) -> None:
    _loaded_modules("run", study(), "-o", "out")
    words = ["out", "--csv"] if command == "export" else ["out"]
    packages = {module.partition(".")[0] for module in _loaded_modules(command, *words)}
    assert "xarray" in packages
    assert packages & {"dask", "distributed", "heyoka"} == set()


def test_a_study_of_ones_own_may_compute_with_dask(study: Study) -> None:
    """It is hidden only where nobody can use it."""
    Path("blocks.py").write_text(WITH_DASK)
    modules = _loaded_modules("run", study(), "--import", "blocks.py", "--set", "study.kind=blocks", "-o", "out")
    assert "dask.array" in modules
