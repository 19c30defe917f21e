"""A motion that slides along a jump of the equations, which drives it back from either side: time stands still there."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import PiecewiseCubic, step
from wucht.system import System

x, v = sp.symbols("x v", real=True)
SIGN = step("sign", 0.0, -1.0, 1.0)
SWITCHES = 300  # sliding has no end of them


@pytest.mark.parametrize(
    ("system", "start", "meeting", "place"),
    [
        # x' = 1/2 - sign(x) from -3.
        (System((x,), (sp.Rational(1, 2) - PiecewiseCubic(x, SIGN),)), [-3.0], 2.0, [0.0]),
        # A spring and dry friction, from 1: after two half swings the spring holds less than friction.
        (System((x, v), (v, -x - sp.Rational(3, 10) * PiecewiseCubic(v, SIGN))), [1.0, 0.0], 2 * np.pi, [-0.2, 0.0]),
    ],
    ids=["drift", "dry friction"],
)
def test_it_stays_at_the_jump(system: System, start: list[float], meeting: float, place: list[float]) -> None:
    times: list[float] = []

    def stop(time: float) -> None:
        times.append(time)
        if len(times) > SWITCHES:
            raise KeyboardInterrupt

    run = integrate(compile_system(system), start, {}, np.linspace(0.0, 20.0, 20_001), stop)
    assert run.is_interrupted, "it left the jump"
    assert times[-1] == pytest.approx(meeting, abs=1e-7)
    assert run.states[:, -1] == pytest.approx(place, abs=2e-3)  # at the last sample before
