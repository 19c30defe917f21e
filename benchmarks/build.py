"""Deriving and compiling a rotor with 2 to 16 pendulums, from the parts to a flow, nothing cached (asked: 8 in under 5 s)."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator

_SCRIPT = """
import sys, time
import sympy
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
n = int(sys.argv[1])
pendulum = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "damping": 0.1}
machine = machine_from({
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.03}]
    + [pendulum | {"name": f"p{i}"} for i in range(n)],
    "drive": {"on": "drum", "kind": "linear", "slope": 0.02, "no_load_speed": 200.0},
})
a = time.perf_counter(); machine.system
b = time.perf_counter(); compile_system(machine.system)
c = time.perf_counter(); print(b - a, c - b)
"""


def measure() -> Iterator[tuple[str, str]]:
    for n in (2, 4, 8, 16):
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {"XDG_CACHE_HOME": cache, "WUCHT_CACHE_DIR": cache}
            out = subprocess.run(
                [sys.executable, "-c", _SCRIPT, str(n)],
                capture_output=True, text=True, check=True, env=environment,
            )  # fmt: skip
        derive, compile_ = map(float, out.stdout.split())
        yield f"{n} pendulums: derive {derive:.2f} s, compile {compile_:.2f} s, together", f"{derive + compile_:8.2f} s"
