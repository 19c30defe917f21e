"""The page on averaging: its blocks run and print what it says, and that is right by integration of the whole equations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from page_blocks import PAGES, blocks, run_python
from scipy.integrate import solve_ivp


@pytest.fixture(scope="module")
def names() -> Mapping[str, Any]:
    """What the page's blocks define, run in order."""
    known: dict[str, Any] = {}
    for block in blocks(PAGES["docs/averaging.md"]):
        if block.language == "python":
            assert run_python(block, known) == block.said, block.text
    return known


def integrated(rates: Any, start: list[float], end: float, **more: Any) -> Any:
    return solve_ivp(rates, (0.0, end), start, rtol=1e-8, atol=1e-10, **more)


def test_amplitude_and_frequency_of_the_limit_cycle(names: Mapping[str, Any]) -> None:
    """SciPy: the amplitude is 2, the period 2 pi (1 + mu^2/16), both up to higher orders."""
    mu = 0.1

    def rates(_: float, s: np.ndarray) -> list[float]:
        return [s[1], mu * (1 - s[0] ** 2) * s[1] - s[0]]

    def upward(_: float, s: np.ndarray) -> float:
        return float(s[0])

    upward.direction = 1.0  # type: ignore[attr-defined]
    run = integrated(rates, [2.0, 0.0], 200.0, events=upward, max_step=0.1)
    period = np.diff(run.t_events[0])[-1]
    drift = float(names["second"].system.derivatives[1].subs({names["r"]: 2, names["mu"]: mu}))
    assert 2 * math.pi / period == pytest.approx(1 + drift, abs=1e-5)
    assert np.abs(run.y[0, -2000:]).max() == pytest.approx(2.0, abs=2e-3)


def test_the_errors_fall_with_their_order(names: Mapping[str, Any]) -> None:
    for averaging, power in ((names["first"], 1), (names["second"], 2)):
        coarse, fine = (names["largest_error"](averaging, value) for value in (0.05, 0.025))
        assert math.log2(coarse / fine) == pytest.approx(power, abs=0.2)


def test_the_reduced_equation_by_integration_of_both_states(names: Mapping[str, Any]) -> None:
    epsilon, k, start = 0.01, 1.5, 3.0

    def rates(t: float, s: np.ndarray) -> list[float]:
        return [epsilon * (s[1] ** 2 - s[0]), -k * s[1] + s[0] * math.cos(t)]

    symbols = {names["epsilon"]: epsilon, names["k"]: k}
    a, y = names["a"], names["reduction"].manifold[0]
    slow = names["reduction"].averaging.system.derivatives[0]
    reduced = integrated(lambda _, s: [float(slow.subs({**symbols, a: s[0]}))], [start], 1 / epsilon)
    whole = integrated(rates, [start, float(y.subs({**symbols, a: start, names["TIME"]: 0}))], 1 / epsilon)
    assert whole.y[0, -1] == pytest.approx(reduced.y[0, -1], abs=3 * epsilon)
    assert abs(start - whole.y[0, -1]) > 30 * epsilon


@pytest.mark.parametrize(("share", "stays"), [(0.8, False), (1.2, True)])
def test_upright_on_either_side_of_the_limit(names: Mapping[str, Any], share: float, stays: bool) -> None:
    """(amplitude fast)^2 is a share of 2 g L: the pendulum falls, or librates about the upright position."""
    g, length, damping, fast = 9.81, 1.0, 0.5, 400.0
    amplitude = math.sqrt(share * 2 * g * length) / fast

    def rates(t: float, s: np.ndarray) -> list[float]:
        return [s[1], -(g - amplitude * fast**2 * math.cos(fast * t)) / length * math.sin(s[0]) - damping * s[1]]

    # At rest in the mean: X = pi + 0.05, X' = 0, and the fast motion with its rate.
    theta = math.pi + 0.05
    fast_rate = -amplitude / length * fast * math.sin(theta) * -math.sin(0.0)
    run = integrated(rates, [theta - amplitude / length * math.sin(theta), fast_rate], 4.0)
    assert (np.abs(run.y[0] - math.pi).max() < 0.2) == stays
