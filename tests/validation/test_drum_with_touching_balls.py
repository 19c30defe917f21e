"""A drum with 3 kg of laundry on one side and a ring of balls that touch, against a program written for it alone in C++.

The program has the same machine (planar carrier, gravity, inverter with limits of torque and power, n balls on one track) in
equations derived by hand, Dormand and Prince's method of order 5, and springs with dampers between the balls whose opening and
closing it locates on the dense output: 8,445 changes of contact in 30 s with twelve balls at 339 rad/s, 24,956 at 2513 rad/s.
Largest amplitude of the axis in the run-up to 1200 rpm, in the passage of the resonance at 2.3 and 2.7 Hz; both at 1e-11. The
motion amplifies differences while the balls touch: eleven of the twelve agree to 5e-5, one to 4.4e-4; at 1e-9 to 1e-3.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from benchmarks.real_machines import drum

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

DISTANCE = 10.1  # degrees between the centres of balls side by side; they touch at 10.08
# Balls, frequency of the contacts in rad/s, where the balls start -> largest amplitude in mm by the program in C++.
AMPLITUDES = {
    (12, 339.3, "even"): 38.6376, (12, 339.3, "side by side"): 38.8421, (12, 2513.0, "even"): 38.8959,
    (12, 2513.0, "side by side"): 39.1365, (14, 339.3, "even"): 36.8510, (14, 339.3, "side by side"): 33.3756,
    (14, 2513.0, "even"): 37.9003, (14, 2513.0, "side by side"): 32.7080, (6, 339.3, "even"): 46.2228,
    (6, 339.3, "side by side"): 39.1292, (6, 2513.0, "even"): 46.2061, (6, 2513.0, "side by side"): 39.1331,
}  # fmt: skip


@pytest.mark.parametrize(
    ("balls", "frequency", "places"),
    [case if case[:2] == (12, 339.3) else pytest.param(*case, marks=pytest.mark.slow) for case in AMPLITUDES],
)
def test_largest_amplitude(balls: int, frequency: float, places: str) -> None:
    machine = drum(frequency, balls)
    apart = 360 / balls if places == "even" else DISTANCE
    start = initial_state(machine, {"drum": 0.0} | {f"b{k + 1}": math.radians(k * apart) for k in range(balls)})
    run = integrate(compile_system(machine.system, 1e-11), start, machine.values, np.linspace(0.0, 30.0, 30_001))
    assert run.failure is None
    amplitude = 1e3 * float(np.hypot(run.states[0] - start[0], run.states[1] - start[1]).max())
    assert amplitude == pytest.approx(AMPLITUDES[balls, frequency, places], rel=6e-4)
