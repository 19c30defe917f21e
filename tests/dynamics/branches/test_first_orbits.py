"""First orbits: within which limits the branch through one is followed."""

from __future__ import annotations

import numpy as np
import sympy as sp

import wucht
from wucht.dynamics.branches.first_orbits import cycles_of
from wucht.dynamics.branches.orbit_problem import OrbitProblem, OrbitSettings
from wucht.system import System

X, PHI, P, Q = sp.symbols("x phi p q", real=True)


def test_orbits_are_followed_within_their_range_and_up_to_the_longest_period() -> None:
    """A state and an angle, which makes a turn in a period; both and the parameter have their sizes."""
    system = System((X, PHI), (P - X, 1 + Q * X**2), (P, Q), angles=frozenset({PHI}))
    problem = OrbitProblem.of(wucht.UserSystem(system, {"p": 0.5, "q": 0.25}), "p", (0.1, 0.9), OrbitSettings())
    cycles = cycles_of(problem, np.array([0, 1]), np.array([2.0, 3.0, 4.0]), 7.0)
    assert cycles.periods == (0.0, 7.0)
    assert cycles.bounds == (0.1, 0.9)
    assert cycles.winding.tolist() == [0, 1]
    assert np.delete(cycles.equations.scale, 2).tolist() == [2.0, 3.0, 4.0]
