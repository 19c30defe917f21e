from __future__ import annotations

import math

import numpy as np
import pytest
from tests.refusals import failed, rejected

from auto_demos import PEN
from known_orbits import ISOLA, PLANE, X, Y, placed
from wucht.numerics.periodic.cycle_starts import cycle_from_nodes, cycle_near
from wucht.numerics.periodic.cycles import Cycles

TAU = np.linspace(0, 1, 41)
SAMPLES = placed(PLANE, {X: math.sqrt(1.3) * np.cos(2 * np.pi * TAU), Y: math.sqrt(1.3) * np.sin(2 * np.pi * TAU)})
CYCLES = Cycles.of(ISOLA, "p", {"speed": 1.0}, (-1.0, 1.0))


@pytest.mark.parametrize("count", [8, 400])
def test_few_or_many_samples_rough_ones_too(count: int) -> None:
    tau = np.linspace(0, 1, count)
    wave = {X: np.cos(2 * np.pi * tau), Y: np.sin(2 * np.pi * tau)}
    samples = placed(PLANE, {s: math.sqrt(1.3) * v for s, v in wave.items()})
    rough = samples + 0.02 * np.random.default_rng(0).normal(size=samples.shape)
    found = cycle_near(CYCLES, 5.0 + 6.2 * tau, rough if count > 8 else samples, 0.0)
    assert found.period == pytest.approx(2 * math.pi, abs=1e-8) and found.parameter == 0.0
    x, y = found.states
    y = y - x**2 / 10
    np.testing.assert_allclose(np.hypot(x - y**2 / 5, y), math.sqrt(1.3), atol=2e-7)


def test_at_another_value_of_the_parameter() -> None:
    """(r^2 - 1)^2 + p^2 = 0.09."""
    first = cycle_near(CYCLES, 2 * np.pi * TAU, SAMPLES, 0.0)
    other = cycle_from_nodes(CYCLES, first.problem.mesh, first.states.T, first.period, 0.1)
    x, y = other.states
    y = y - x**2 / 10
    np.testing.assert_allclose(np.hypot(x - y**2 / 5, y) ** 2, 1 + math.sqrt(0.08), atol=2e-7)


def test_bad_samples_are_told() -> None:
    times = 2 * np.pi * TAU
    with rejected("out-of-range", "p = 3", "-1", "1"):
        cycle_near(CYCLES, times, SAMPLES, 3.0)
    with rejected("too-few", "4", "3"):
        cycle_near(CYCLES, times[:3], SAMPLES[:, :3], 0.0)
    with rejected("shape", "2", "41", "40"):
        cycle_near(CYCLES, times, SAMPLES[:, :-1], 0.0)
    with rejected("not-increasing"):
        cycle_near(CYCLES, times[::-1], SAMPLES, 0.0)
    with rejected("not-increasing"):
        cycle_near(CYCLES, times, np.where(SAMPLES > 1, np.nan, SAMPLES), 0.0)
    with failed("no-convergence"):
        cycle_near(CYCLES, times, 40 * np.random.default_rng(1).normal(size=SAMPLES.shape), 0.0)


def test_an_equilibrium_is_no_orbit() -> None:
    with rejected("at-rest"):
        cycle_near(CYCLES, 2 * np.pi * TAU, 0 * SAMPLES, 0.0)
    with failed("no-convergence"):
        cycle_near(CYCLES, 2 * np.pi * TAU, 0.01 * SAMPLES, 0.0)


def test_samples_that_turn_otherwise_than_the_winding_number_says() -> None:
    cycles = Cycles.of(PEN, "current", {"gamma": 0.175, "eps": 0.1}, (0, 1), winding={"phi1": 1, "phi2": 2})
    samples = np.stack([4 * TAU * np.pi / 2, 4 * TAU * np.pi / 2, 4 + 0 * TAU, 4 + 0 * TAU])
    with rejected("winding", "1", "2"):
        cycle_near(cycles, TAU, samples, 0.4)
    forwards = Cycles.of(PEN, "current", {"gamma": 0.175, "eps": 0.1}, (0, 1), winding={"phi1": 1, "phi2": 1})
    with rejected("winding", "-1", "1"):
        cycle_near(forwards, TAU, -samples, 0.4)
