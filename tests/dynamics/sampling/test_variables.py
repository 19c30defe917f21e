"""Ranges of variables, the inertia that follows them, and the residual unbalance of members, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sampling import searches
from wucht.dynamics.sampling.searches import Variable, values_at


def variable(low: float, high: float, *paths: str) -> Variable:
    return Variable("v", None, paths, low, high, "", "")


@pytest.mark.parametrize(
    ("low", "high", "middle"), [(1.0, 10.0, math.sqrt(10.0)), (1.0, 9.99, 5.495), (-10.0, 10.0, 0.0), (0.0, 100.0, 50.0)]
)
def test_ranges_of_a_decade_are_searched_by_their_logarithm(low: float, high: float, middle: float) -> None:
    of = variable(low, high)
    assert of.value_at(np.array([0.0, 0.5, 1.0])) == pytest.approx([low, middle, high])
    assert [of.share(x) for x in (low, middle, high)] == pytest.approx([0.0, 0.5, 1.0])


def test_what_has_no_logarithm_lies_below_the_range() -> None:
    assert variable(1.0, 100.0).share(0.0) == -1.0 and variable(1.0, 100.0).share(-3.0) == -1.0


def test_the_inertia_of_a_pendulum_follows_its_mass_and_the_square_of_its_length(monkeypatch: pytest.MonkeyPatch) -> None:
    values = {"p.mass": 2.0, "p.length": 0.5, "p.inertia": 0.4, "q.mass": 2.0, "q.length": 0.5, "q.inertia": 0.4}
    machine: Any = SimpleNamespace(values=values)
    monkeypatch.setattr(searches, "balancer_names", lambda _: ["p", "q"])

    def inertia(**numbers: float) -> dict[str, float]:
        variables = [variable(0.0, 1.0, path.replace("_", ".")) for path in numbers]
        return {k: v for k, v in values_at(machine, variables, list(numbers.values())).items() if k.endswith("inertia")}

    assert inertia(p_mass=6.0) == {"p.inertia": pytest.approx(1.2)}
    assert inertia(q_length=1.5) == {"q.inertia": pytest.approx(3.6)}
    assert inertia(p_mass=1.0, p_length=1.0) == {"p.inertia": pytest.approx(0.8)}
    assert inertia(p_mass=1.0, p_inertia=0.7) == {"p.inertia": 0.7}
