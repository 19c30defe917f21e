"""From the command line: `import wucht` (asked: 0.3 s) and `wucht run` of R1 over 20 s, cold (4 s) and warm (2.5 s).

Cold: the caches of compiled code and derived equations empty. The ratio to the imports of four libraries alone tells what is
ours (asked: 1.5).
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

_RUN = ["-m", "wucht", "run", "drozdetskaya-2020/r1", "--set", "study.until=20 s"]


def measure() -> Iterator[tuple[str, str]]:
    interpreter = _time(["-c", "pass"])
    yield "import wucht, beyond starting Python", f"{_time(['-c', 'import wucht']) - interpreter:8.3f} s"
    peer = _time(["-c", "import numpy, sympy, matplotlib.figure, xarray"])
    yield "importing NumPy, SymPy, matplotlib and xarray alone", f"{peer:8.2f} s"
    with tempfile.TemporaryDirectory() as folder:
        environment = {"XDG_CACHE_HOME": folder, "WUCHT_CACHE_DIR": folder}
        yield "wucht run, cold", f"{_time([*_RUN, '-o', folder], 1, environment):8.2f} s"
        warm = _time([*_RUN, "-o", folder], 5, environment)
        yield f"wucht run, warm ({warm / peer:.2f} times those imports)", f"{warm:8.2f} s"


def _time(arguments: list[str], repetitions: int = 5, environment: dict[str, str] | None = None) -> float:
    times = []
    for _ in range(repetitions):
        begun = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=os.environ | (environment or {}))
        times.append(time.perf_counter() - begun)
    return min(times)
