"""Orbits by collocation: their multipliers, test functions and integrals, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.periodic import branch_ends
from wucht.numerics.periodic.branch_ends import _AROUND, _NEAR, _agree, _is_near, _rates, _time_near
from wucht.numerics.periodic.cycle import TESTS, Cycle, _product, _relative_size, critical_pair, has_pair_on_circle
from wucht.numerics.periodic.period_laws import PeriodLaw, better_law

MESH = Mesh(np.array([0.0, 0.3, 0.45, 1.0]), 4)


class ByHand(Cycle):
    """Its period and its sizes are what they are said to be."""

    @property
    def problem(self) -> Any:
        return self.curve.problem


def cycle(
    multipliers: list[complex], kind: str = "", along: float = 0.0, tangent: tuple[float, float] = (1.0, 1.0), *,
    period: float = 1.0,
) -> Cycle:  # fmt: skip
    problem: Any = SimpleNamespace(mesh=MESH, split=lambda u: (None, [period]), sizes=np.array([1.0, 1.0, period, 5.0]))
    point: Any = SimpleNamespace(unknowns=np.array([period, 0.5]), tangent=np.array(tangent))
    curve: Any = SimpleNamespace(problem=problem)
    logarithms = np.log(np.array(multipliers, complex))
    return ByHand(curve, point, logarithms, along, 0.0, np.eye(len(multipliers)), kind)


def test_the_product_of_bounded_differences_from_one() -> None:
    """(mu - 1)/(1 + |mu|) of each, of a pair |mu - 1|^2/(1 + |mu|)^2; huge and tiny ones are 1 and -1."""
    log = lambda *mu: np.log(np.array(mu, complex))  # noqa: E731
    assert _product(log(2.0)) == pytest.approx(1 / 3) and _product(log(0.5)) == pytest.approx(-1 / 3)
    assert _product(log(2.0, 0.5, -0.5)) == pytest.approx(1 / 3 * -1 / 3 * -1)
    assert _product(log(-3.0)) == pytest.approx(-1.0)
    assert _product(log(1j, -1j)) == pytest.approx(0.5)
    assert _product(log(2j, -2j)) == pytest.approx(abs(2j - 1) ** 2 / 9)
    assert _product(np.array([900.0 + 0j, -900.0])) == pytest.approx(-1.0)


def test_test_functions_pass_zero_at_their_points() -> None:
    """Each from one side of its point to the other; a fold is the slope of the parameter."""
    assert TESTS["fold"](cycle([0.5], tangent=(3.0, -0.25))) == -0.25
    for kind, before, after in (
        ("period-doubling", [-0.9, 0.5], [-1.1, 0.5]),
        ("torus", [0.9 * np.exp(2j), 0.9 * np.exp(-2j)], [1.1 * np.exp(2j), 1.1 * np.exp(-2j)]),
        ("branch-point", [0.9, 0.5], [1.1, 0.5]),
    ):
        a, b = TESTS[kind](cycle(before)), TESTS[kind](cycle(after))
        assert a * b < 0, kind
    assert TESTS["torus"](cycle([2.0, 0.5])) == pytest.approx(0.0, abs=1e-15)
    assert TESTS["branch-point"](cycle([0.5], tangent=(1.0, -2.0))) == pytest.approx(2 / 3)


def test_the_pair_whose_product_is_nearest_to_one() -> None:
    """A pair of real numbers 3 and 1/3 is no pair on the circle, nor are two negative ones."""
    logs = np.log(np.array([5.0, np.exp(2j), 0.3, np.exp(-2j)]))
    assert critical_pair(logs) == [1, 3]
    assert has_pair_on_circle(cycle([5.0, np.exp(2j), 0.3, np.exp(-2j)]))
    assert not has_pair_on_circle(cycle([3.0, 1 / 3, 0.1])) and not has_pair_on_circle(cycle([-3.0, -1 / 3, 0.1]))


@pytest.mark.parametrize(
    ("multipliers", "kind", "unstable"),
    [
        ([1.5, 0.5], "", 1), ([1.5, 2.5, -3.0], "", 3), ([0.9, -0.9], "", 0), ([1.0 + 1e-9, 2.0], "fold", 1),
        ([-1.0 - 1e-9, 2.0], "period-doubling", 1), ([1.01 * np.exp(2j), 1.01 * np.exp(-2j), 0.5], "torus", 0),
        ([1.01 * np.exp(2j), 1.01 * np.exp(-2j), 0.5], "", 2), ([1 + 1e-9, 0.5], "branch-point", 0),
    ],
)  # fmt: skip
def test_multipliers_outside_the_unit_circle(multipliers: list[complex], kind: str, unstable: int) -> None:
    assert cycle(multipliers, kind).unstable == unstable


def test_multipliers_are_trusted_where_the_trivial_one_is_one() -> None:
    """Of a plane the only one always is."""
    assert cycle([0.5, 0.2], along=-0.0099).is_trusted and not cycle([0.5, 0.2], along=0.0101).is_trusted
    assert cycle([0.5], along=3.0).is_trusted


@pytest.mark.parametrize(
    ("tangent", "lengthens"),
    [((2.0, 0.19), True), ((2.0, 0.21), False), ((2.0, -0.19), True), ((2.0, -0.21), False), ((-2.0, 0.0), False)],
)
def test_a_period_that_grows_while_the_parameter_stays(tangent: tuple[float, float], lengthens: bool) -> None:
    """A period of 1 that grows by 2, e-fold for each half of it; of a parameter of size 5 a fiftieth of twice that."""
    assert cycle([0.5], tangent=tangent).lengthens is lengthens
    assert cycle([0.5], tangent=tangent, period=3.0).lengthens is (lengthens and abs(tangent[1]) < 0.19 / 2)


def test_an_integral_over_a_period_is_exact_for_polynomials() -> None:
    """Of degree 4 on three uneven intervals: 7 times the integral of tau^4, and of a column of ones."""
    assert cycle([0.5], period=7.0).integral(MESH.nodes**4) == pytest.approx(7 / 5, rel=1e-13)
    assert cycle([0.5], period=7.0).integral(np.ones(len(MESH.nodes))) == pytest.approx(7.0, rel=1e-13)


def test_the_size_of_an_orbit_in_terms_of_another() -> None:
    """Twice as large, mirrored, of another mean; each state by its size; orbits that wind have none."""
    turn = 2 * math.pi * MESH.nodes
    a = np.array([np.cos(turn), 10 * np.sin(turn)])
    problem: Any = SimpleNamespace(mesh=MESH, winding=np.zeros(2, int), sizes=np.array([1.0, 10.0, 1.0, 1.0]))
    assert _relative_size(problem, a, 2 * a + [[5.0], [-3.0]]) == pytest.approx(2.0)
    assert _relative_size(problem, a + 7, -0.25 * a) == pytest.approx(-0.25)
    parts = ((a - (a @ MESH.shares)[:, None]) ** 2 @ MESH.shares) / [1.0, 100.0]
    assert _relative_size(problem, a, a * [[3.0], [1.0]]) == pytest.approx((3 * parts[0] + parts[1]) / parts.sum())
    problem.winding = np.array([0, 1])
    assert _relative_size(problem, a, 2 * a) == 1.0


def test_rates_of_the_period_past_saddles() -> None:
    """Past one saddle those of its growing and of its decaying disturbance; past two each may break, or both."""
    one = _rates([SimpleNamespace(growing=2.0, decaying=3.0)])  # type: ignore[list-item]
    assert one == pytest.approx([2.0, 2.0, 3.0, 3.0])
    pair: Any = [SimpleNamespace(growing=2.0, decaying=3.0), SimpleNamespace(growing=4.0, decaying=5.0)]
    forwards = [1 / (1 / 2 + 1 / 4), 1 / (1 / 2 + 3 / 2 / 4), 1 / (1 / 4 + 5 / 4 / 2)]
    backwards = [1 / (1 / 5 + 1 / 3), 1 / (1 / 5 + 4 / 5 / 3), 1 / (1 / 3 + 2 / 3 / 5)]
    assert _rates(pair) == pytest.approx([*forwards, *backwards])


def test_a_law_agrees_with_an_equilibrium() -> None:
    """Within ten times its error, or a share of the distance of the last orbit from its end."""
    law = PeriodLaw("saddle-node", 1.0, 0.01, 1.0, 0.0)
    assert _agree(1.099, law, 1.0) and _agree(0.901, law, 1.0) and not _agree(1.101, law, 1.0) and not _agree(0.899, law, 1.0)
    assert better_law((law, PeriodLaw("connection", 1.0, 0.0, 1.0, 0.1))) is law
    assert better_law((law, PeriodLaw("connection", 1.0, 0.0, 1.0, -0.1))).name == "connection"


def test_the_time_near_a_state() -> None:
    """On an even way of length 8, its size, in a time of 4: a tenth of it on either side is near."""

    def along(tau: np.ndarray) -> np.ndarray:
        return np.array([8 * tau, 0 * tau])

    made: Any = SimpleNamespace(problem=SimpleNamespace(mesh=MESH), period=4.0, states_at=along)
    sizes, expected = np.array([8.0, 1.0]), 2 * _AROUND * 4.0
    assert _time_near(made, np.array([4.0, 0.0]), sizes) == pytest.approx(expected, rel=2e-2)
    assert _time_near(made, np.array([0.0, 0.0]), sizes) == pytest.approx(expected / 2, rel=2e-2)
    assert _time_near(made, np.array([4.0, 2 * _AROUND]), sizes) == 0.0


def test_near_is_a_share_of_the_extent_of_an_orbit() -> None:
    """Of 4 in the first state; the second is at rest, where a hundredth of its size of 3 counts."""
    sizes = SimpleNamespace(sizes=np.array([9.0, 3.0, 1.0, 1.0]))
    here: Any = SimpleNamespace(states=np.array([[0.0, 4.0], [0.0, 0.0]]), problem=sizes)
    for away, near in (([3.99, 0.0], True), ([4.01, 0.0], False), ([0.0, 0.0299], True), ([0.0, 0.0301], False)):
        assert _is_near(here, np.array([1.0, 1.0]), 1 + _NEAR * np.array(away)) is near


STAYS, GROWS = [0.5 + 1e-9] * 6 + [0.5], [8.0] * 6 + [9.0]


@pytest.mark.parametrize(
    ("values", "periods", "saddles", "rate", "gained", "ends"),
    [
        (STAYS, GROWS, 2, 2.0, 1.0, True), (STAYS, GROWS, 0, 2.0, 1.0, False), (STAYS, GROWS, 2, 0.6, 1.0, False),
        (STAYS, GROWS, 2, 2.0, 0.97, False), (STAYS, GROWS, 2, 2.0, 1.03, False), (STAYS, GROWS, 2, 2.0, 0.99, True),
        ([0.5 + 3e-8] * 6 + [0.5], GROWS, 2, 2.0, 1.0, False), (STAYS, [9.0] * 7, 2, 2.0, 1.0, False),
        (STAYS, [8.0, 8.0, 6.9, 6.9, 8.0, 8.0, 9.0], 2, 2.0, 1.0, False),
    ],
)  # fmt: skip
def test_a_connection_so_near_that_the_parameter_stays(
    monkeypatch: pytest.MonkeyPatch, values: list[float], periods: list[float], saddles: int, rate: float, gained: float,
    ends: bool,
) -> None:  # fmt: skip
    """All that the period still gains is time at saddles, to which the orbit comes nearer by three e-folds."""
    first, last = SimpleNamespace(period=periods[0]), SimpleNamespace(period=9.0, parameter=0.5)
    point = SimpleNamespace(x=np.array([1.0, 2.0]), eigenvalues=np.array([1.0, -2.0]))
    there = [SimpleNamespace(point=point, growing=rate, decaying=rate)] * saddles
    monkeypatch.setattr(branch_ends, "_saddles", lambda _c, _h, _p, value: there if value == 0.5 else [])
    monkeypatch.setattr(branch_ends, "_slow_places", lambda *_: [])
    monkeypatch.setattr(branch_ends, "_sizes", lambda *_: np.ones(2))
    monkeypatch.setattr(branch_ends, "_time_near", lambda orbit, *_: 4.0 + (gained / 2 if orbit is last else 0.0))
    cycles: Any = SimpleNamespace(equations=SimpleNamespace(parameter_names=("T", "p")), bounds=(0.0, 1.0))
    orbits: Any = [first, last]
    end = branch_ends._unresolved_connection(cycles, np.array(values), np.array(periods), orbits)
    assert (end is not None) is ends
    if end is not None:
        assert (end.kind, end.parameter, end.period) == ("saddle-connection", 0.5, 9.0) and end.error == pytest.approx(5e-9)
        assert end.equilibrium.tolist() == [1.0, 2.0] and end.eigenvalues.tolist() == [1.0, -2.0]
        assert end.sentence.startswith("at p = 0.5 ") and end.sentence.endswith("2 saddles")
