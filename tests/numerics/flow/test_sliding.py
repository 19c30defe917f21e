"""A motion that slides along a jump of the equations, which drives it back from either side: time stands still there."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_batch import compile_batch
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import PiecewiseCubic, step
from wucht.system import TIME, System

x, v = sp.symbols("x v", real=True)
SIGN = step("sign", 0.0, -1.0, 1.0)


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
@pytest.mark.parametrize("engine", ["compiled", "radau"])
def test_it_ends_at_the_jump(system: System, start: list[float], meeting: float, place: list[float], engine: str) -> None:
    run = integrate(compile_system(system, 1e-9, engine=engine), start, {}, np.linspace(0.0, 20.0, 20_001))
    assert "slides along a jump" in str(run.failure)
    assert run.time[-1] == pytest.approx(meeting, abs=1e-3)  # the last sample before
    assert run.states[:, -1] == pytest.approx(place, abs=2e-3)


def test_a_fast_rotor_that_runs_down_before_a_long_rest_does_not_slide() -> None:
    """x' = 10^4 exp(-t / 2) passes 6366 jumps of the sign of its sine in seconds, and stays at 2 10^4 rad, where that is 1."""
    system = System((x, v), (10_000 * sp.exp(-TIME / 2), PiecewiseCubic(sp.sin(x), SIGN)))
    run = integrate(compile_system(system, 1e-9), [0.0, 0.0], {}, np.linspace(0.0, 1e6, 2))
    assert run.failure is None
    assert run.states[0, -1] == pytest.approx(2e4, rel=1e-9)


@pytest.mark.parametrize("share", [0.001, 0.999])
def test_friction_that_is_hardly_larger_than_its_force_slides(share: float) -> None:
    """A spring holds a share of the friction: the motion stays where it starts."""
    system = System((x, v), (v, -x - PiecewiseCubic(v, SIGN)))
    run = integrate(compile_system(system, 1e-9), [share, 0.0], {}, np.linspace(0.0, 40.0, 161))
    assert run.is_sliding
    assert run.end_time == 0.0


def test_a_lane_that_slides_ends_alone() -> None:
    """Friction of 0.3 beside a spring from 1 to 20, and none: after two half swings only the weak springs hold less."""
    stiffness, friction = sp.symbols("k f", real=True)
    system = System((x, v), (v, -stiffness * x - friction * PiecewiseCubic(v, SIGN)), (stiffness, friction))
    parameters = np.array([[k, f] for k in (1.0, 4.0, 20.0) for f in (0.3, 0.0)] * 4)
    batch = compile_batch(system, 1e-9)
    constants = np.array([batch.constant_values(p) for p in parameters]).T
    starts, times = np.tile([[1.0], [0.0]], len(parameters)), np.linspace(0.0, 40.0, 401)
    result = batch.acquire().advance(starts, constants, times)
    assert sorted(result.failures) == [i for i, (_, f) in enumerate(parameters) if f]
    for lane, error in result.failures.items():
        alone = integrate(compile_system(system, 1e-9), [1.0, 0.0], parameters[lane], times)
        assert str(error) == str(alone.failure).split(": ", 1)[1].split(" (largest")[0]
        assert result.times[lane] == pytest.approx(alone.end_time, abs=0.1 + 1e-6)
    for lane in np.flatnonzero(parameters[:, 1] == 0):
        assert result.states[0, lane] == pytest.approx(np.cos(np.sqrt(parameters[lane, 0]) * 40.0), abs=1e-6)
