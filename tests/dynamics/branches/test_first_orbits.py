"""First orbits: within which limits the branch through one is followed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches import first_orbits
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.first_orbits import _times_of_change, cycles_of, orbit_of_run, orbits_of_hopf_points
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.system import System

X, PHI, P, Q = sp.symbols("x phi p q", real=True)


def test_orbits_are_followed_within_their_range_and_up_to_the_longest_period() -> None:
    """A state and an angle, which makes a turn in a period; both and the parameter have their sizes."""
    system = System((X, PHI), (P - X, 1 + Q * X**2), (P, Q), angles=frozenset({PHI}))
    problem = OrbitProblem.of(wucht.UserSystem(system, {"p": 0.5, "q": 0.25}), "p", (0.1, 0.9))
    cycles = cycles_of(problem, np.array([0, 1]), np.array([2.0, 3.0, 4.0]), 7.0)
    assert cycles.periods == (0.0, 7.0)
    assert cycles.bounds == (0.1, 0.9)
    assert cycles.winding.tolist() == [0, 1]
    assert np.delete(cycles.equations.scale, 2).tolist() == [2.0, 3.0, 4.0]


def test_the_time_of_a_change_is_that_of_the_fastest_state() -> None:
    """30 times its size, or 1, over its rate; where all are at rest 30."""
    span = _times_of_change(System((X, PHI), (-P * X, sp.S(3)), (P,)), [2.0])
    assert span(np.array([-10.0, 0.5])) == pytest.approx(30 / 3)  # 20/10 and 3/1
    assert span(np.array([-10.0, 5.0])) == pytest.approx(30 / 2)  # 20/10 and 3/5
    assert span(np.array([0.1, 50.0])) == pytest.approx(30 / 0.2)  # 0.2/1 and 3/50
    assert _times_of_change(System((X,), (-X,)), [])(np.zeros(1)) == 30.0


def test_a_run_lasts_as_long_as_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """In two parts, the second twice as long; otherwise as long as it takes."""
    calls = list[Any]()
    monkeypatch.setattr(first_orbits, "orbit_near", lambda *given, **more: calls.append((given, more)))
    subject: Any = SimpleNamespace(initial=lambda value: [value, 2.0])
    orbit_of_run(subject, 0.5, 12.0, 99.0, lambda: None)
    orbit_of_run(subject, 0.5, None, 99.0, lambda: None)
    (given, more), (bare, alone) = calls
    assert given[1] == 0.5 and given[2].tolist() == [0.5, 2.0] and given[4](None) == 4.0 and given[5] == 99.0
    assert more == {"runs": 2} and len(bare) == 4 and alone == {"longest": 99.0}


@pytest.mark.parametrize("longest", [None, 5.0])
def test_first_orbits_at_hopf_points(monkeypatch: pytest.MonkeyPatch, longest: float | None) -> None:
    """With the period of the pair nearest to the imaginary axis; the parameter changes much over a fifth of its range."""
    u = np.array([[1.0, 2.0, 3.0], [0.0, 0.1, 0.2]])
    exponents = np.array([[-1.0] * 3, [0.1 + 3j] * 3, [0.1 - 3j] * 3, [-0.2 + 7j] * 3, [-0.2 - 7j] * 3])
    branch = EquilibriumBranch(u, exponents, ("", "hopf", "fold"), ("", ""))
    made = list[Any]()

    def cycles(_: Any, winding: np.ndarray, scale: np.ndarray, upto: float) -> Any:
        made.append((winding.tolist(), scale.tolist(), upto))
        return SimpleNamespace(equations="equations")

    def start(x: np.ndarray, value: float) -> tuple[list[float], float]:
        return x.tolist(), value

    monkeypatch.setattr(first_orbits, "cycles_of", cycles)
    monkeypatch.setattr(first_orbits, "equilibria_of", lambda _: SimpleNamespace(start=start, evaluate=lambda p: p))
    monkeypatch.setattr(first_orbits, "cycle_at_hopf", lambda _, hopf: hopf)
    monkeypatch.setattr(first_orbits.SeedOrbit, "from_cycle", lambda _, cycle, place, both_ways: (cycle, place, both_ways))
    subject: Any = SimpleNamespace(bounds=(-2.0, 8.0), path="p")
    (found,) = orbits_of_hopf_points(subject, (branch,), np.array([4.0]), longest)
    assert found == (([2.0], 0.1), "the Hopf point at p = 0.1", True)
    assert made == [([0], [4.0, 2.0], pytest.approx(20 * 2 * np.pi / 3) if longest is None else 5.0)]


def test_values_widths_and_turns_of_a_problem() -> None:
    system = System((X, PHI), (P - X, 1 + Q * X**2), (P, Q), angles=frozenset({PHI}))
    subject = wucht.UserSystem(system, {"p": 0.5, "q": 0.25})
    problem = OrbitProblem.of(subject, "q", (-0.1, 0.9), start={"phi": 2})
    assert problem.width == 1.0 and problem.turning.tolist() == [False, True] and not problem.shows_rotor_speed
    assert problem.parameters_at(0.75) == (0.5, 0.75) and problem.fixed_values("q") == {"p": 0.5}
    assert problem.fixed_values() == {"p": 0.5, "q": 0.25} and problem.turns(np.array([0, -2])) == {"phi": -2}
    assert problem.initial(0.3).tolist() == [0.0, 2.0]
    ordinate, amplitude = problem.observables(np.array([[1.0, 2.0], [3.0, 4.0]]), 0.3)
    assert ordinate.tolist() == [1.0, 2.0] and np.isnan(amplitude).all()
    turned = OrbitProblem.of(subject, "q", (-0.1, 0.9), show="phi")
    assert turned.observables(np.array([[1.0, 2.0], [3.0, 4.0]]), 0.3)[0].tolist() == [3.0, 4.0]
