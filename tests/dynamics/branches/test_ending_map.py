"""How a motion around a homoclinic leaf ends: at a saddle where mu < 0, at a saddle-node where mu > 0; the curve between."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import wucht
from known_connections import LOOP
from wucht.dynamics.branches.ending_curves import RETURNS
from wucht.dynamics.branches.ending_map import (
    EndingFindings,
    map_endings,
)
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_endings import NO_MOTION, OrbitEnd, OrbitEnding, ending_at
from wucht.dynamics.work import Work
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT

RANGES = {"x": (-0.6, 1.4), "y": (-1.0, 1.0)}
EQUATIONS = wucht.UserSystem(LOOP, {"p": 0.0, "mu": 0.0, "b": 0.0})
PATHS, PLANE_RANGES = ("p", "mu", "b"), ((-0.4, 0.4), (-0.06, 0.06), (-0.3, 0.3))


def case() -> EndingMapCase:
    return EndingMapCase.of(EQUATIONS, PATHS, PLANE_RANGES, 2, ranges_of_states=RANGES)


@cache
def mapped() -> EndingFindings:
    *_, last = map_endings(case(), Work())
    return last


def fold_of(mu: float, b: float) -> float:
    """c at the saddle-node near the origin: f = 0 and det f' = 0, by Newton's method from there."""
    x, y, c = (1 / 4 * -mu, 1 / 4 * -mu, 0.0)
    for _ in range(30):

        def f(u: np.ndarray) -> np.ndarray:
            x, y, c = u
            fx = np.array([[-2 + 4 * x, 2], [2 - 6 * x + 3 * y + b * (2 * x - 3 * x**2), -2 + mu + 3 * x - 2 * b * y]])
            leaf = x**2 * (1 - x) - y**2
            first = c - 2 * x + 2 * y + 2 * x**2
            return np.array([first, 2 * x + (-2 + mu) * y - 3 * x**2 + 3 * x * y + b * leaf, np.linalg.det(fx)])

        u = np.array([x, y, c])
        slopes = np.array([(f(u + h) - f(u - h)) / 2e-6 for h in 1e-6 * np.eye(3)]).T
        x, y, c = u - np.linalg.solve(slopes, f(u))
    return float(c)


def test_the_motions_end_at_a_saddle_or_at_a_saddle_node() -> None:
    """Row by row; begun at the one saddle-node, over p, and ended at the other or beyond it."""
    places = mapped().places
    assert [(round(p.x, 9), round(p.y, 9)) for p in places] == [(-0.03, -0.15), (0.03, -0.15), (-0.03, 0.15), (0.03, 0.15)]
    assert [p.kind for p in places] == [SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT] * 2
    for p in places:
        begin = (0.05 - fold_of(p.x, p.y)) ** 0.5
        assert p.begins == pytest.approx(-begin, abs=1e-9)
        assert p.end.last is not None
        if p.kind == SADDLE_NODE_ON_ORBIT:
            assert p.end.value == pytest.approx(begin, abs=1e-9)
            assert p.end.sentence == f"at p = {p.end.value:.7g} steady states appear on the orbit, a saddle-node"
        else:
            assert begin + 0.01 < p.end.value < begin + 0.015
            assert p.end.sentence == f"at p = {p.end.value:.7g} the orbit runs into a saddle"


def test_where_it_runs_into_a_saddle_by_shooting() -> None:
    """A little less or more of p: the orbit that leaves the saddle returns on the one side of it, or on the other."""
    from scipy.integrate import solve_ivp

    place = mapped().places[0]
    mu, b = place.x, place.y

    def rates(_: float, u: np.ndarray, c: float) -> tuple[float, float]:
        x, y = u
        leaf = x**2 * (1 - x) - y**2
        return c - 2 * x + 2 * y + 2 * x**2, 2 * x + (-2 + mu) * y - 3 * x**2 + 3 * x * y + b * leaf

    ways = []
    for p in (place.end.value - 1e-5, place.end.value + 1e-5):
        c, x = 0.05 - p**2, place.end.equilibrium
        for _ in range(20):
            fx = np.array([
                [-2 + 4 * x[0], 2],
                [2 - 6 * x[0] + 3 * x[1] + b * (2 * x[0] - 3 * x[0] ** 2), -2 + mu + 3 * x[0] - 2 * b * x[1]],
            ])  # fmt: skip
            x = x - np.linalg.solve(fx, np.array(rates(0.0, x, c)))
        values, vectors = np.linalg.eig(fx)
        assert values.min() < 0 < values.max()
        out = vectors[:, values.argmax()] * np.sign(vectors[0, values.argmax()])
        run = solve_ivp(rates, (0, 200), x + 1e-4 * out, args=(c,), rtol=1e-10, atol=1e-12)
        away = run.y[0] - x[0]
        k = int(away.argmax())
        ways.append(away[k:].min() < -0.02)  # past the saddle, down to the other side of it
    assert ways[0] != ways[1]


def test_the_curve_on_which_the_orbit_returns_to_the_saddle_node() -> None:
    """mu = 0, p^2 = 1/20 for each b, cut at the edges of the plane."""
    (curve,) = mapped().curves
    assert curve.kind == RETURNS and mapped().points == ()
    np.testing.assert_allclose(curve.x, 0.0, atol=1e-9)
    np.testing.assert_allclose(curve.value, 0.05**0.5, atol=1e-9)
    assert sorted(curve.y[[0, -1]]) == pytest.approx([-0.3, 0.3], abs=1e-12)
    assert (np.diff(curve.y) > 0).all() or (np.diff(curve.y) < 0).all()


def there(bounds: tuple[float, float]) -> ModulatedMotion:
    """At mu = 0.03, b = 0.15, with p within other bounds."""
    motion = case().motion.with_values({"mu": 0.03, "b": 0.15})
    return replace(motion, subject=replace(motion.subject, bounds=bounds))


def test_a_place_at_which_no_stable_state_is_lost() -> None:
    """Between the folds, at p = -0.2234 and 0.2234, there are none."""
    found = ending_at(there((-0.2, 0.2)), (0.03, 0.15), lambda: None)
    assert (found.x, found.y, found.kind) == (0.03, 0.15, NO_MOTION) and np.isnan(found.begins)
    assert found.end.sentence == "no stable state is lost in the range of p"


def test_a_motion_that_begins_as_the_parameter_falls_is_followed_down() -> None:
    found = ending_at(there((0.15, 0.4)), (0.03, 0.15), lambda: None)
    assert found.begins == pytest.approx((0.05 - fold_of(0.03, 0.15)) ** 0.5, abs=1e-9)
    assert (found.kind, found.end.value, found.end.sentence) == ("range", 0.15, "the range ends at p = 0.15")


def at(x: float, y: float, kind: str) -> OrbitEnding:
    return OrbitEnding(x, y, 0.0, OrbitEnd(kind, 0.0, ""))
