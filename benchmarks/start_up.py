"""From the command line, in processor time: `import wucht` (asked: 0.3 s) and `wucht run` of R1 over 20 s, cold and warm.

Cold: the caches of compiled code and derived equations empty. Both with the bytecode of wucht, as after an installation: where
``PYTHONDONTWRITEBYTECODE`` is set, to compile it each time takes a third of a warm run. The ratio to the imports of NumPy,
matplotlib (Agg) and xarray alone tells what is ours (asked: 2.3): the drawn figure and the written file are part of it, and
SymPy, in which machines are stated, also where nothing is derived.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from compileall import compile_dir
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import wucht

_RUN = ["-m", "wucht", "run", "drozdetskaya-2020/r1", "--set", "study.until=20 s"]
_LIBRARIES = ["-c", "import numpy, matplotlib.figure, matplotlib.backends.backend_agg, xarray"]
_TIMES = 7  # each, in turn: the least of them


def measure() -> Iterator[tuple[str, str]]:
    compile_dir(Path(wucht.__file__).parent, quiet=1)
    interpreter, ours = (min(_seconds(["-c", code]) for _ in range(_TIMES)) for code in ("pass", "import wucht"))
    yield "import wucht, beyond starting Python", f"{ours - interpreter:8.3f} s"
    with tempfile.TemporaryDirectory() as folder:
        environment = {"XDG_CACHE_HOME": folder, "WUCHT_CACHE_DIR": folder}
        run = [*_RUN, "-o", folder]
        yield "wucht run, cold", f"{_seconds(run, environment):8.2f} s"
        libraries, warm = zip(*((_seconds(_LIBRARIES), _seconds(run, environment)) for _ in range(_TIMES)), strict=True)
    yield "importing NumPy, matplotlib (Agg) and xarray alone", f"{min(libraries):8.2f} s"
    yield "wucht run, warm", f"{min(warm):8.2f} s"
    yield "the same, times those imports", f"{min(warm) / min(libraries):8.2f}"


def _seconds(arguments: list[str], environment: dict[str, str] | None = None) -> float:
    """Processor time of Python with these arguments, and of what it starts."""
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=os.environ | (environment or {}))
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
