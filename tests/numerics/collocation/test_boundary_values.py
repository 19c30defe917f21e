from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from known_orbits import PLANE, SPEED, P, X, Y, placed, planar
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem, Reference
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import with_exact_tolerance
from wucht.numerics.periodic.cycle_starts import cycle_from_nodes
from wucht.numerics.periodic.cycles import Cycles

UNEVEN = planar(P - X**2 - Y**2, P, turning=SPEED * (1 + X / 2))
"""r^2 = p; at p = 1 phi' = speed (1 + cos(phi)/2): T = 2 pi/(speed sqrt(3/4)), tan(phi/2) = sqrt 3 tan(pi t/T)."""
PERIOD = 2 * math.pi / math.sqrt(0.75)


def known(tau: np.ndarray) -> np.ndarray:
    """The orbit at p = speed = 1 (K, 2): continuous in its phase, where tau is from -1/2 to 1/2."""
    phi = 2 * np.arctan2(math.sqrt(3) * np.sin(np.pi * tau), np.cos(np.pi * tau))
    return placed(PLANE, {X: np.cos(phi), Y: np.sin(phi)}).T


def cycles(degree: int) -> Cycles:
    return Cycles.of(UNEVEN, "p", {"speed": 1.0}, (0.5, 2.0), degree=degree)


def problem(intervals: int, degree: int) -> tuple[BoundaryValueProblem, np.ndarray]:
    mesh = Mesh.even(intervals, degree)
    unknowns = np.append(known(mesh.nodes), [PERIOD, 1.0])
    made = cycles(degree).problem(mesh, PERIOD)
    return replace(made, reference=made.reference_from(unknowns)), unknowns


def square_and_product(y: np.ndarray, parameters: np.ndarray, _: Reference) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A condition on an integral with both states and both parameters: of y_0^2 + y_1 P_0 P_1."""
    (a, b), ones = parameters, np.ones(y.shape[1])
    by_parameters = np.array([[b * y[1], a * y[1]]])
    return (y[0] ** 2 + a * b * y[1])[None], np.array([[2 * y[0], a * b * ones]]), by_parameters


@pytest.mark.parametrize("integrand", [None, square_and_product])
def test_the_jacobian_is_that_of_differences(integrand: Any) -> None:
    p, unknowns = problem(3, 2)
    p = p if integrand is None else replace(p, integrand=integrand)
    unknowns = unknowns + 0.1 * np.random.default_rng(0).normal(size=len(unknowns))
    row = np.random.default_rng(1).normal(size=len(unknowns))
    _, jacobian = p.residual(unknowns)
    for seed in range(5):
        direction = np.random.default_rng(seed).normal(size=len(unknowns))
        step = 1e-6
        off = (p.residual(unknowns + step * direction)[0] - p.residual(unknowns - step * direction)[0]) / (2 * step)
        # What solves [J; row] x = (J d, row d) is d.
        np.testing.assert_allclose(jacobian.solve(row, np.append(off, row @ direction)[:, None])[:, 0], direction, atol=1e-6)


def errors(intervals: int, degree: int) -> tuple[float, float, float]:
    """Of the period, at mesh points, and within intervals: distances from the orbit at the same place, the phase being free."""
    p, unknowns = problem(intervals, degree)
    plane = np.zeros(len(unknowns))
    plane[-1] = 1.0
    found = with_exact_tolerance(cycles(degree).curve(p)).start(unknowns, plane)
    y, parameters = p.split(found.unknowns)

    def away(tau: np.ndarray, states: np.ndarray) -> float:
        # The phase condition shifts the orbit a little: by the first mesh point's distance along it.
        exact = known(tau - shift)
        return float(np.abs(states - exact).max())

    speed = (known(np.array([1e-6])) - known(np.array([-1e-6])))[0] / 2e-6
    shift = -float((y[0] - known(np.array([0.0]))[0]) @ speed / (speed @ speed))
    fine = np.linspace(0, 1, 2001)
    return abs(parameters[0] - PERIOD), away(p.mesh.edges, y[:: p.mesh.degree]), away(fine, p.mesh.interpolate(y, fine))


@pytest.mark.parametrize(("degree", "coarse", "fine"), [(2, 40, 80), (4, 20, 40)])
def test_order_of_convergence(degree: int, coarse: int, fine: int) -> None:
    """2 m at mesh points and in the period, m + 1 within: C. de Boor, B. Swartz, SIAM J. Numer. Anal. 10 (1973) 582-606."""
    one, other = errors(coarse, degree), errors(fine, degree)
    orders = [math.log(a / b) / math.log(fine / coarse) for a, b in zip(one, other, strict=True)]
    assert orders[0] == pytest.approx(2 * degree, abs=0.5)
    assert orders[1] == pytest.approx(2 * degree, abs=0.5)
    assert orders[2] == pytest.approx(degree + 1, abs=0.4)


@pytest.mark.parametrize("degree", [3, 6])
def test_a_mesh_is_as_fine_as_the_accuracy_asks(degree: int) -> None:
    for accuracy in (1e-5, 1e-8):
        asked = replace(cycles(degree), accuracy=accuracy)
        mesh = Mesh.even(20, degree)
        found = cycle_from_nodes(asked, mesh, known(mesh.nodes), PERIOD, 1.0)
        x, y = found.states_at(np.linspace(0, 1, 2001))
        y = y - x**2 / 10
        off = float(np.abs(np.hypot(x - y**2 / 5, y) - 1).max())
        assert off < 5 * accuracy and found.error < 5 * accuracy
        assert found.problem.mesh.intervals < 400
        assert found.period == pytest.approx(PERIOD, abs=5 * accuracy)
