"""What a search varies: keys of bodies, groups of them, single paths."""

from __future__ import annotations

import numpy as np
import pytest

from wucht import OptimiseBalancer, load_machine
from wucht.dynamics.sampling.distributions import REPLICATES, points
from wucht.dynamics.sampling.probability_bands import interval
from wucht.dynamics.sampling.searches import (
    ProbabilityBounds,
    balancer_names,
    certain_fall,
    is_pareto_optimal,
    next_sample_value,
    smallest_value,
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


def seen(*lows: float, width: float = 0.1) -> list[ProbabilityBounds]:
    return [ProbabilityBounds(float(k), low, low + width) for k, low in enumerate(lows)]


@pytest.mark.parametrize(
    ("lows", "wanted", "found"),
    [
        ((0.1, 0.5, 0.7, 0.9), 0.6, 2.0),
        ((0.1, 0.5, 0.6, 0.9), 0.6, 2.0),
        ((0.7, 0.8, 0.8, 0.9), 0.6, 0.0),
        ((0.1, 0.2, 0.3, 0.4), 0.6, None),
        ((0.1, 0.65, 0.58, 0.9), 0.6, 3.0),  # falls within its confidence: from 3 on it stays
        ((0.1, 0.62, 0.65, 0.58), 0.6, None),
        ((0.9, 0.8, 0.7, 0.95), 0.6, None),  # falls beyond its confidence
    ],
)
def test_from_where_on_it_is_reached(lows: tuple[float, ...], wanted: float, found: float | None) -> None:
    assert smallest_value(seen(*lows), wanted) == found


def test_nothing_is_reached_by_nothing() -> None:
    assert smallest_value([], 0.5) is None
    assert next_sample_value([], 0.5) is None


def test_the_deepest_fall() -> None:
    fall = certain_fall(seen(0.2, 0.9, 0.75, 0.5, 0.95))
    assert fall is not None
    assert (fall.before.value, fall.after.value) == (1.0, 3.0)
    assert certain_fall(seen(0.5, 0.45, 0.42)) is None


def found_by_search(of: np.ndarray, wanted: float) -> tuple[float, int]:
    """The smallest value x with wanted probability of points (R, n) below x, looked for from five values on; and its looks."""
    looks = [float(x) for x in np.linspace(0.3, 1.0, 5)]
    known: list[ProbabilityBounds] = []
    begun = len(looks)
    while looks:
        x = looks.pop(0)
        known = sorted(
            [*known, ProbabilityBounds(x, *interval((of < x).sum(axis=1), of.shape[1], 0.95))], key=lambda b: b.value
        )
        if not looks and (more := next_sample_value(known, wanted)) is not None:
            looks.append(more)
    found = smallest_value(known, wanted)
    assert found is not None
    return found, len(known) - begun


@pytest.mark.slow
def test_it_errs_no_more_often_than_one_bound_does() -> None:
    """P(u1 + u2 < 2 x) is known; of 100 values found 2.5 may be too small, and they are near."""
    wanted = 0.8
    true = 1 - np.sqrt((1 - wanted) / 2)  # of P = 1 - 2 (1 - x)^2 for x > 1/2
    found, looks = zip(*(found_by_search(points(128, 2, seed=k).mean(axis=2), wanted) for k in range(100)), strict=True)
    early = (np.array(found) < true).sum()
    assert early <= 6
    assert np.median(found) == pytest.approx(true, abs=0.05)
    assert max(looks) <= 9  # 2^-9 of a step of 0.175
    assert points(128, 2, seed=0).shape[0] == REPLICATES


def test_the_search_ends_at_a_thousandth_of_the_range() -> None:
    known = [ProbabilityBounds(x, x, x + 0.01) for x in (0.0, 0.5, 1.0)]
    while (x := next_sample_value(known, 0.7)) is not None:
        known = sorted([*known, ProbabilityBounds(x, x, x + 0.01)], key=lambda b: b.value)
    found = smallest_value(known, 0.7)
    assert found is not None
    assert 0 <= found - 0.7 <= 1e-3
    assert len(known) == 3 + 9
    assert next_sample_value(seen(0.7, 0.8), 0.6) is None, "below the first value nothing is looked at"


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
