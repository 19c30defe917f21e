"""What a search varies, what it keeps, and where it looks next."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht import OptimiseBalancer, load_machine
from wucht.dynamics.sampling.searches import (
    Variable,
    balancer_names,
    generations,
    is_pareto_optimal,
    spread_selection,
    values_at,
    variables_of,
)

CENTRIFUGE = load_machine("practice/laboratory-centrifuge")


def test_keys_groups_and_paths() -> None:
    vary = {"damping": [1e-5, 1e-3], "mass": {"of": ["b1", "b2"], "range": ["4 g", "5 g"]}, "drive": {"slope": [1e-3, 2e-3]}}
    damping, mass, slope = variables_of(CENTRIFUGE, OptimiseBalancer(vary=vary).vary, all_bodies=False)
    assert damping.paths == tuple(f"b{k}.damping" for k in range(1, 5))
    assert mass.paths == ("b1.mass", "b2.mass")
    assert (mass.low, mass.high) == (4e-3, 5e-3)
    assert slope.paths == ("drive.slope",)
    assert damping.value_at(np.array([0, 0.5, 1])) == pytest.approx([1e-5, 1e-4, 1e-3])
    assert mass.value_at(np.array([0.5])) == pytest.approx([4.5e-3])
    assert damping.share(1e-4) == pytest.approx(0.5)


def test_a_pendulums_inertia_keeps_its_ratio() -> None:
    machine = load_machine("practice/laundry-drum")
    names = balancer_names(machine)
    if f"{names[0]}.inertia" not in machine.values:
        machine = load_machine("drozdetskaya-2020/r1")
        names = balancer_names(machine)
    assert f"{names[0]}.inertia" in machine.values
    own = machine.values[f"{names[0]}.mass"]
    (mass,) = variables_of(machine, OptimiseBalancer(vary={"mass": [own / 2, 2 * own]}).vary, all_bodies=False)
    assert values_at(machine, [mass], [2 * own])[f"{names[0]}.inertia"] == pytest.approx(
        2 * machine.values[f"{names[0]}.inertia"]
    )


def test_not_dominated_is_what_pairs_say() -> None:
    points = np.round(np.random.default_rng(3).random((60, 3)), 1)
    better = [[bool((q <= p).all() and (q < p).any()) for q in points] for p in points]
    assert np.array_equal(is_pareto_optimal(points), ~np.any(better, axis=1))
    assert is_pareto_optimal(np.array([[1.0, 1.0], [1.0, 1.0]])).all(), "equal points do not dominate each other"


def test_spread_out_has_the_best_of_each_and_gaps_filled() -> None:
    t = np.linspace(0, 1, 101)
    chosen = spread_selection(np.stack([t, 1 - t], axis=1), 5)
    assert np.allclose(t[chosen], [0, 0.25, 0.5, 0.75, 1], atol=0.01)
    assert len(spread_selection(np.ones((7, 2)), 5)) == 1


def test_a_search_leaves_what_is_not_feasible() -> None:
    """The smallest of x^2 + y^2 and (x - 1)^2 + y^2 with x above 0.5: below there is none, or it is not a number."""
    pytest.importorskip("pymoo")
    rng, last = np.random.default_rng(1), list[np.ndarray]()

    def value(number: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert ((shares >= 0) & (shares <= 1)).all() and number == len(last)
        last.append(shares)
        x, y = shares.T
        objectives = np.column_stack([x**2 + y**2, (x - 1) ** 2 + y**2])
        objectives[(x < 0.5) & (y < 0.5)] = np.nan
        return objectives, (x >= 0.5) | (y < 0.5)

    assert list(generations(12, rng.random((20, 2)), 2, 3, value)) == list(range(12))
    assert np.mean(last[-1][:, 0] >= 0.5) > 0.85 > np.mean(last[0][:, 0] >= 0.5)
    assert last[-1][:, 1].mean() < 0.2


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
