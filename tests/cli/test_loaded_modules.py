"""Which libraries a command loads: those of its answer, and none that would only take time."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

Study = Callable[..., Path]
UNUSED = {"dask", "distributed", "heyoka", "rich", "clarabel", "pymoo", "SALib", "IPython", "fastapi"}
UNUSED_MODULES = {"matplotlib.pyplot", "scipy.integrate", "scipy.linalg", "scipy.optimize", "scipy.special", "scipy.stats"}
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


def test_a_warm_run_loads_no_library_that_it_does_not_use(study: Study) -> None:
    file = study()
    _loaded_modules("run", file, "-o", "out")  # derives and compiles
    modules = _loaded_modules("run", file, "-o", "out")
    packages = {module.partition(".")[0] for module in modules}
    assert {"wucht", "numpy", "xarray", "matplotlib"} <= packages
    assert packages & UNUSED == set()
    assert modules & UNUSED_MODULES == set()
