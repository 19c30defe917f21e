"""Which starts lead to which attractor, where that is known."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wucht.dynamics.limit_sets.basins import DIVERGES, FAILED, NEUTRAL, StartOutcomes, start_outcomes
from wucht.dynamics.limit_sets.limit_set import MotionKind
from wucht.errors import WuchtError
from wucht.files.user_system import UserSystem, equations_from


def equations(states: dict[str, str], **more: object) -> UserSystem:
    return equations_from({"states": states, **more})


def outcomes_from(subject: UserSystem, starts: np.ndarray) -> StartOutcomes:
    return start_outcomes(subject, starts, tolerance=1e-9)


def test_both_wells_have_the_starts_on_their_side() -> None:
    x = np.linspace(-2, 2, 40)
    outcomes = outcomes_from(equations({"x": "x - x^3", "y": "-y"}), np.array([x, np.ones(40)]))
    places = np.array([one.mean[0] for one in outcomes.attractors])
    assert places[outcomes.outcome] == pytest.approx(np.sign(x))


def test_an_orbit_and_an_equilibrium_are_told_apart() -> None:
    """r' = r (r^2 - 1)(4 - r^2): the equilibrium attracts to r = 1, the circle r = 2 all beyond."""
    k = "(x^2 + y^2 - 1)*(4 - x^2 - y^2)"
    r = np.linspace(0.1, 2.9, 30)  # none of them within rounding of 1
    subject = equations({"x": f"x*{k} - y", "y": f"y*{k} + x"})
    outcomes = outcomes_from(subject, np.array([r, np.zeros(30)]))
    kinds = [outcomes.attractors[k].kind for k in outcomes.outcome.tolist()]
    assert kinds == [MotionKind.EQUILIBRIUM if one < 1 else MotionKind.PERIODIC for one in r]


def test_starts_that_lead_to_infinity_diverge() -> None:
    x = np.array([-0.5, 0.5, 0.99, 1.01, 2.0, 5.0, 0.0, 3.0])
    outcomes = outcomes_from(equations({"x": "-x + x^3"}), x[None])
    assert (outcomes.outcome == DIVERGES).tolist() == (x > 1).tolist()


def test_a_start_on_an_unstable_equilibrium_is_told_and_draws_no_others() -> None:
    x = np.array([0.0, 1e-5, -1e-5, 0.5, -0.5, 1.5, -1.5])
    outcomes = outcomes_from(equations({"x": "x - x^3"}), x[None])
    assert [outcomes.attractors[k].attracts for k in outcomes.outcome.tolist()] == [False, *[True] * 6]


def test_forced_motions_are_distinguished_by_their_phase() -> None:
    """x'' = -0.2 x' + x - x^3 + 0.1 cos t: an oscillation in each well."""
    x = np.linspace(-1.4, 1.4, 12)
    outcomes = outcomes_from(equations({"x": "v", "v": "-0.2*v + x - x^3 + 0.1*cos(t)"}), np.array([x, np.zeros(12)]))
    assert sorted(np.sign(one.mean[0]) for one in outcomes.attractors) == [-1, 1]
    assert [one.period for one in outcomes.attractors] == pytest.approx([2 * np.pi] * 2)


@pytest.mark.parametrize(
    ("states", "sentence"),
    [
        ({"x": "u", "y": "v", "u": "-x - 2*x*y", "v": "-y - x^2 + y^2"}, "preserve volume"),  # Henon and Heiles
        ({"x": "x*(1 - y)", "y": "y*(x - 1)"}, "neither attracts nor repels"),  # Lotka and Volterra: it is not divergence-free
    ],
)
def test_conservative_equations_have_no_basins(states: dict[str, str], sentence: str) -> None:
    starts = np.full((len(states), 2), 0.3)
    with pytest.raises(WuchtError, match=sentence):
        outcomes_from(equations(states), starts)


def ends_of(outcomes: StartOutcomes) -> np.ndarray:
    """The equilibrium (M, n) at which each start ends."""
    assert (outcomes.outcome >= 0).all()
    return np.array([one.mean for one in outcomes.attractors])[outcomes.outcome]


@pytest.mark.parametrize("cells", [5, 6])
@pytest.mark.parametrize("dimensions", [1, 2])
def test_wells_of_equal_shape_have_equal_shares(dimensions: int, cells: int) -> None:
    """x_i' = x_i - x_i^3: the signs of the start are those of the end. Of 6 cells from -2 to 2 two centres lie on the
    equilibria -1 and 1 themselves, of 5 one on 0, between the wells: there the motion ends in a saddle, exactly.
    """
    names = "xyz"[:dimensions]
    places = -2 + 4 * (np.arange(cells) + 0.5) / cells
    places[np.abs(places) < 1e-12] = 0.0
    starts = np.array(list(itertools.product(places, repeat=dimensions))).T
    outcomes = outcomes_from(equations({n: f"{n} - {n}^3" for n in names}), starts)
    assert ends_of(outcomes) == pytest.approx(np.sign(starts).T, abs=1e-9)
    assert len(outcomes.attractors) == (3 if cells % 2 else 2) ** dimensions
    assert all(one.attracts == (one.mean != 0).all() for one in outcomes.attractors)
    assert outcomes.failures == ()


def test_starts_on_a_separatrix_end_in_its_saddle() -> None:
    """A genetic toggle switch is symmetric about x = y; there x (1 + x^2) = 3 at rest (Gardner, Cantor, Collins 2000)."""
    x, y = map(np.ravel, np.meshgrid(*[0.2 * np.arange(20) + 0.1] * 2))
    outcomes = outcomes_from(equations({"x": "3/(1 + y^2) - x", "y": "3/(1 + x^2) - y"}), np.array([x, y]))
    ends = ends_of(outcomes)
    assert np.sign(ends[:, 0] - ends[:, 1])[x != y] == pytest.approx(np.sign(x - y)[x != y])
    assert ends[x == y] == pytest.approx(1.2134116627622296, abs=1e-9)
    assert [one.attracts for one in outcomes.attractors].count(False) == 1


def test_a_rest_that_rounding_ends_is_none() -> None:
    """x' = (x - x^3)/100 from 1e-15: for 3000 units the motion rests at 0, but for rounding, and leaves."""
    x = np.array([0.0, 1e-15, -1e-15, 1e-3, -1e-3, 0.5, 1.5])
    outcomes = outcomes_from(equations({"x": "0.01*(x - x^3)", "y": "-y"}), np.array([x, np.ones(7)]))
    assert ends_of(outcomes)[:, 0] == pytest.approx(np.sign(x), abs=1e-9)


def test_starts_from_far_away_do_not_widen_the_reach_of_an_equilibrium() -> None:
    x = np.array([5000.0, 0.3, -0.3, 1.5, -1.5, 5000.0, -0.01, -5000.0])
    outcomes = outcomes_from(equations({"x": "(x - x^3)/(1 + x^2)"}), x[None])
    assert ends_of(outcomes)[:, 0] == pytest.approx(np.sign(x), abs=1e-9)


GAUSSIANS = {
    **{f"e{k}": f"a{k}*exp(-((x - p{k})^2 + (y - q{k})^2)/(2*s{k}^2))/s{k}^2" for k in range(4)},
}  # fmt: skip
PULLS = {c: f"-0.1*{c} - " + " - ".join(f"e{k}*({c} - {p}{k})" for k in range(4)) for c, p in (("x", "p"), ("y", "q"))}


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 20))])
def test_random_gradient_systems_end_where_an_integration_ends(seed: int) -> None:
    """(x, y)' = -grad V with V = (x^2 + y^2)/20 less four Gaussians at random; against SciPy's DOP853 at 1e-10."""
    random = np.random.default_rng(seed)
    a, s = random.uniform(0.5, 2.0, 4), random.uniform(0.3, 0.8, 4)
    p, q = random.uniform(-2, 2, (2, 4))
    numbers = {f"{n}{k}": float(v[k]) for n, v in (("a", a), ("s", s), ("p", p), ("q", q)) for k in range(4)}
    starts = random.uniform(-2.5, 2.5, (2, 64))
    subject = equations(PULLS, definitions=GAUSSIANS, parameters=numbers)
    outcomes = outcomes_from(subject, starts)

    def rates(_: float, flat: np.ndarray) -> np.ndarray:
        x, y = flat.reshape(2, -1)
        dx, dy = x - p[:, None], y - q[:, None]
        pull = a[:, None] * np.exp(-(dx**2 + dy**2) / (2 * s[:, None] ** 2)) / s[:, None] ** 2
        return np.concatenate([-0.1 * x - (pull * dx).sum(axis=0), -0.1 * y - (pull * dy).sum(axis=0)])

    ends = solve_ivp(rates, (0.0, 300.0), starts.ravel(), "DOP853", rtol=1e-10, atol=1e-10).y[:, -1].reshape(2, -1)
    assert ends_of(outcomes) == pytest.approx(ends.T, abs=1e-6)


def test_a_start_without_a_result_has_a_reason_and_ends_nothing() -> None:
    """For y > 0 x slides along the jump of its rate at 0, for y < 0 it tends to 3."""
    y = np.linspace(-1.5, 1.5, 8)
    states = {"x": "-sign(x)*(1 + sign(y)) - (1 - sign(y))*(x - 3)", "y": "y - y^3"}
    outcomes = outcomes_from(equations(states), np.array([np.ones(8), y]))
    assert (outcomes.outcome == FAILED).tolist() == (y > 0).tolist()
    assert [outcomes.attractors[k].mean.tolist() for k in outcomes.outcome[y < 0]] == [pytest.approx([3.0, -1.0])] * 4
    assert [member for member, _ in outcomes.failures] == np.flatnonzero(y > 0).tolist()
    assert all("slides along a jump" in reason for _, reason in outcomes.failures)


def test_a_part_without_attractors_leaves_the_basins_of_the_rest() -> None:
    """r' = r (r^2 - 1)(4 - r^2) beyond r = 1, within it circles about the origin: nothing attracts there."""
    m = "max(0, x^2 + y^2 - 1)*(4 - x^2 - y^2)"
    r = np.array([1.5, 0.3, 0.6, 0.8, 1.2, 1.9, 2.5, 0.9])
    outcomes = outcomes_from(equations({"x": f"{m}*x - y", "y": f"{m}*y + x"}), np.array([r, np.zeros(8)]))
    assert (outcomes.outcome == NEUTRAL).tolist() == (r < 1).tolist()
    assert [str(outcomes.attractors[k].kind) for k in outcomes.outcome[r > 1]] == ["periodic"] * 4
    assert all("family" in reason for _, reason in outcomes.failures)


def test_rest_of_equations_that_depend_on_time_has_a_basin() -> None:
    """x' = -x (1 + sin(t)/2), y' = y - y^3: all start at rest or come to it."""
    y = np.array([-1.5, -0.2, 0.3, 1.7])
    states = {"x": "-x*(1 + sin(t)/2)", "y": "y - y^3"}
    assert ends_of(outcomes_from(equations(states), np.array([y, y]))) == pytest.approx(
        np.array([0 * y, np.sign(y)]).T, abs=1e-5
    )
