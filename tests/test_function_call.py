"""Python functions without formulas: called in runs, with the motion of their formulas, and their errors as sentences."""

from __future__ import annotations

import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

import wucht
from wucht import System, UserSystem, compile_system, integrate

pytestmark = pytest.mark.filterwarnings("ignore:.*without a Jacobian:RuntimeWarning")
GRID = np.linspace(0.0, 10.0, 101)


def one_sided(t: Any, x: Any, p: Any) -> Any:
    """A pendulum whose string meets a nail below its pivot, so that on one side it is a quarter as long."""
    angle, speed = x
    if angle > 0:
        return [speed, -math.sin(angle) - p[0] * speed]
    return [speed, -4 * math.sin(angle) - p[0] * speed]


def one_sided_traced(t: Any, x: Any, p: Any) -> Any:
    return [x[1], -np.where(x[0] > 0, 1, 4) * np.sin(x[0]) - p[0] * x[1]]


def motion(function: Any, start: list[float], grid: np.ndarray = GRID, parameters: tuple[float, ...] = ()) -> Any:
    system = System.from_function(function, [f"x{i}" for i in range(len(start))], [f"p{i}" for i in range(len(parameters))])
    return integrate(compile_system(system, 1e-10), start, parameters, grid)


def test_a_branch_moves_as_its_formulas() -> None:
    called, traced = (motion(f, [1.0, 0.0], parameters=(0.1,)) for f in (one_sided, one_sided_traced))
    assert called.failure is None
    assert called.states == pytest.approx(traced.states, abs=1e-8)


def test_a_table_is_interpolated_at_each_call() -> None:
    """dx/dt = 2 p (1 - |t - 1|) from a table of three points: the area of the triangle is p at t = 1, 2 p at t = 2."""
    result = motion(
        lambda t, x, p: [p[0] * np.interp(float(t), [0, 1, 2], [0, 2, 0])], [0.0], np.array([0.0, 1.0, 2.0]), (3.0,)
    )
    assert result.states[0] == pytest.approx([0.0, 3.0, 6.0], abs=1e-8)


def test_a_run_up_until_a_time_needs_no_formulas() -> None:
    pendulum = UserSystem.from_function(one_sided, ["angle", "speed"], {"damping": 0.1})
    result = wucht.run(wucht.RunUp(start={"angle": 1.0}, until=10.0), pendulum)
    expected = motion(one_sided_traced, [1.0, 0.0], parameters=(0.1,)).states[:, -1]
    assert result.states.isel(time=-1).values == pytest.approx(expected, abs=1e-8)
    assert result.wucht.summary["outcome"] == "unidentified" and "not told" in result.wucht.sentence
    with refused("study.until"):
        wucht.run(wucht.RunUp(start={"angle": 1.0}), pendulum)


def test_what_needs_formulas_is_refused_with_the_line() -> None:
    pendulum = UserSystem.from_function(one_sided, ["angle", "speed"], {"damping": 0.1})
    compiled_system = compile_system(pendulum.system)
    needs = (
        lambda: compile_system(pendulum.system, engine="radau"),
        lambda: wucht.averaged(pendulum.system),
        lambda: wucht.periodic_orbit(compiled_system, [0.1], [1.0, 0.0], 6.0, [0.0, 0.0], free_period=False),
        lambda: wucht.run(wucht.SpeedCurve(along="damping", range=[0.1, 1.0]), pendulum),
        lambda: wucht.run(wucht.PhasePortrait(), pendulum),
        lambda: wucht.run(wucht.Sweep(along="damping", range=[0.1, 0.2]), pendulum),
        lambda: wucht.run(wucht.RunUp(start={"angle": 1.0}, until=1.0, engine="radau"), pendulum),
    )
    for need in needs:
        with pytest.raises(wucht.WuchtError, match=r"if angle > 0:.*np\.where"):
            need()
    with pytest.raises(pickle.PicklingError, match="if angle > 0:"):
        pickle.dumps(pendulum)


def late_error(t: Any, x: Any, p: Any) -> Any:
    return [{}["torque"] if t > 5 else 1.0]


def falling(t: Any, x: Any, p: Any) -> Any:
    return [-0.5 / math.sqrt(x[0])]  # x^(3/2) = 1 - 3/4 t


def short(t: Any, x: Any, p: Any) -> Any:
    return [1.0] if x[0] < 0.5 else [1.0, 2.0]


@pytest.mark.parametrize(
    ("function", "start", "end", "named"),
    [
        (late_error, 0.0, 5.0, ("KeyError: 'torque'", '{}["torque"]')),
        (falling, 1.0, 4 / 3, ("ValueError", "math.sqrt(x[0])")),
        (short, 0.0, 0.5, ("a real number for each of 1 states",)),
    ],
)
def test_an_error_in_the_function_ends_the_run_with_its_sentence(
    function: Any, start: float, end: float, named: tuple[str, ...]
) -> None:
    result = motion(function, [start])
    assert all(word in (result.failure or "") for word in named)
    assert 0.0 < result.end_time <= end and end - result.end_time < 2.0 and np.isfinite(result.states).all()
    assert motion(lambda t, x, p: [float(t)], [0.0]).states[0, -1] == pytest.approx(50.0)  # of the next run nothing is left


def test_ctrl_c_interrupts_a_slow_function() -> None:
    def slow(t: Any, x: Any, p: Any) -> Any:
        time.sleep(1e-3)
        return [math.sin(50 * t)]

    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    result = motion(slow, [0.0], np.linspace(0.0, 1e4, 11))
    timer.join()
    assert result.is_interrupted and result.failure is None


def test_functions_of_one_name_stay_apart() -> None:
    def constant(value: float) -> Any:
        def rate(t: Any, x: Any, p: Any) -> Any:
            return [value if x[0] < 1e9 else 0.0]

        return rate

    ends = [motion(constant(value), [0.0]).states[0, -1] for value in (1.0, 2.0)]
    assert ends == pytest.approx([10.0, 20.0])
    first, second = (UserSystem.from_function(constant(value), ["x"]) for value in (1.0, 2.0))
    assert first != second


def test_nothing_of_it_is_kept_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path))
    compile_system(System.from_function(one_sided, ["angle", "speed"], ["damping"]))
    entries = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()]
    assert entries and not any(
        b"called_" in entry for entry in entries
    )  # those of its events and outputs, of which it has none


def constant_rate(t: Any, x: Any, p: Any) -> Any:
    return [1.0 if x[0] < 1e9 else 0.0]


def test_another_process_does_not_get_the_result_of_a_function_of_that_name(tmp_path: Path) -> None:
    system = UserSystem.from_function(constant_rate, ["x"])
    results = str(tmp_path / "results")
    first, again = (wucht.run(wucht.RunUp(until=2.0), system, folder=results, resume=resume) for resume in (False, True))
    assert first.states.isel(time=-1, state=0).item() == pytest.approx(2.0)
    assert again.attrs["created"] == first.attrs["created"]
    script = tmp_path / "run.py"
    script.write_text(
        "import wucht\n"
        "def constant_rate(t, x, p): return [3.0 if x[0] < 1e9 else 0.0]\n"
        "system = wucht.UserSystem.from_function(constant_rate, ['x'])\n"
        "wucht.run(wucht.RunUp(until=2.0), system, folder='results', resume=True)\n"
    )
    other_process = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "if x[0] < 1e9" in other_process.stderr
    assert other_process.returncode == 1 and "another" in other_process.stderr.splitlines()[-1]
