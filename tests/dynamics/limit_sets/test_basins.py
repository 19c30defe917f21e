"""Which starts lead to which attractor, where that is known."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.limit_sets.basins import DIVERGES, start_outcomes
from wucht.dynamics.limit_sets.limit_set import MotionKind
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.errors import WuchtError
from wucht.files.user_system import UserSystem, equations_from

SETTINGS = LongRunSettings(tolerance=1e-9)


def equations(states: dict[str, str], **more: object) -> UserSystem:
    return equations_from({"states": states, **more})


def test_both_wells_have_the_starts_on_their_side() -> None:
    x = np.linspace(-2, 2, 40)
    outcomes = start_outcomes(equations({"x": "x - x^3", "y": "-y"}), np.array([x, np.ones(40)]), SETTINGS)
    places = np.array([one.mean[0] for one in outcomes.attractors])
    assert places[outcomes.labels] == pytest.approx(np.sign(x))


def test_an_orbit_and_an_equilibrium_are_told_apart() -> None:
    """r' = r (r^2 - 1)(4 - r^2): the equilibrium attracts to r = 1, the circle r = 2 all beyond."""
    k = "(x^2 + y^2 - 1)*(4 - x^2 - y^2)"
    r = np.linspace(0.1, 2.9, 30)  # none of them within rounding of 1
    subject = equations({"x": f"x*{k} - y", "y": f"y*{k} + x"})
    outcomes = start_outcomes(subject, np.array([r, np.zeros(30)]), SETTINGS)
    kinds = [outcomes.attractors[k].kind for k in outcomes.labels.tolist()]
    assert kinds == [MotionKind.EQUILIBRIUM if one < 1 else MotionKind.PERIODIC for one in r]


def test_starts_that_lead_to_infinity_diverge() -> None:
    x = np.array([-0.5, 0.5, 0.99, 1.01, 2.0, 5.0, 0.0, 3.0])
    outcomes = start_outcomes(equations({"x": "-x + x^3"}), x[None], SETTINGS)
    assert (outcomes.labels == DIVERGES).tolist() == (x > 1).tolist()


def test_a_start_on_an_unstable_equilibrium_is_told_and_draws_no_others() -> None:
    x = np.array([0.0, 1e-5, -1e-5, 0.5, -0.5, 1.5, -1.5])
    outcomes = start_outcomes(equations({"x": "x - x^3"}), x[None], SETTINGS)
    assert [outcomes.attractors[k].attracts for k in outcomes.labels.tolist()] == [False, *[True] * 6]


def test_forced_motions_are_distinguished_by_their_phase() -> None:
    """x'' = -0.2 x' + x - x^3 + 0.1 cos t: an oscillation in each well."""
    x = np.linspace(-1.4, 1.4, 12)
    outcomes = start_outcomes(
        equations({"x": "v", "v": "-0.2*v + x - x^3 + 0.1*cos(t)"}), np.array([x, np.zeros(12)]), SETTINGS
    )
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
        start_outcomes(equations(states), starts, SETTINGS)
