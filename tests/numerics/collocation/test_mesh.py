from __future__ import annotations

import numpy as np
import pytest

from wucht.numerics.collocation.mesh import Mesh, basis
from wucht.numerics.collocation.solutions import mesh_from_samples

RNG = np.random.default_rng(3)
EDGES = np.concatenate([[0.0], np.sort(RNG.uniform(0, 1, 6)), [1.0]])


@pytest.mark.parametrize("degree", [1, 4, 8])
def test_polynomials_of_the_degree_are_exact(degree: int) -> None:
    """Interpolation, derivatives, the highest derivative, and integrals of twice the degree less one."""
    mesh = Mesh(EDGES, degree)
    p = np.polynomial.Polynomial(RNG.normal(size=degree + 1))
    values = p(mesh.nodes)[:, None]
    where = np.append(RNG.uniform(0, 1, 50), mesh.nodes)
    np.testing.assert_allclose(mesh.interpolate(values, where)[:, 0], p(where), atol=1e-12)
    np.testing.assert_allclose(mesh.slopes(values)[:, 0], p.deriv()(mesh.nodes), atol=1e-9)
    pieces, b = mesh.pieces(values), mesh.basis
    np.testing.assert_allclose((b.values @ pieces)[..., 0].ravel(), p(mesh.points), atol=1e-12)
    slopes = (b.slopes @ pieces)[..., 0] / mesh.lengths[:, None]
    np.testing.assert_allclose(slopes.ravel(), p.deriv()(mesh.points), atol=1e-9)
    on_unit = basis(degree).highest @ p(basis(degree).nodes)
    assert on_unit == pytest.approx(p.deriv(degree)(0.0), rel=1e-9)
    square = np.polynomial.Polynomial(RNG.normal(size=2 * degree))
    assert (mesh.weights.ravel() * square(mesh.points)).sum() == pytest.approx(
        square.integ()(1.0) - square.integ()(0.0), rel=1e-10
    )


def layer(t: np.ndarray) -> np.ndarray:
    """Smooth, periodic, and steep at t = 0.6."""
    return np.stack([np.exp(-12 * (1 - np.cos(2 * np.pi * (t - 0.6)))), np.sin(2 * np.pi * t)], axis=1)


@pytest.mark.parametrize("degree", [2, 6])
def test_an_adapted_mesh_spreads_the_error_evenly(degree: int) -> None:
    mesh = Mesh.even(40, degree)
    before = mesh.error(layer(mesh.nodes), True)
    for _ in range(4):
        mesh = mesh.adapt(layer(mesh.nodes), True)
    after = mesh.error(layer(mesh.nodes), True)
    assert mesh.unevenness(layer(mesh.nodes), True) < 1.1
    assert after.max() < before.max() / 3
    assert mesh.edges[0] == 0 and mesh.edges[-1] == 1 and (mesh.lengths > 0).all()


@pytest.mark.parametrize("degree", [2, 4])
def test_the_error_is_estimated_and_so_is_what_an_accuracy_needs(degree: int) -> None:
    """Within a factor of three of the true one, of functions and of how many intervals halve it often enough."""
    mesh = Mesh.even(30, degree)
    for _ in range(3):
        mesh = mesh.adapt(layer(mesh.nodes), True, 50)
    where = np.linspace(0, 1, 5001)
    true = np.linalg.norm(mesh.interpolate(layer(mesh.nodes), where) - layer(where), axis=1).max()
    estimate = mesh.error(layer(mesh.nodes), True).max()
    assert 1 / 3 < estimate / true < 3
    accuracy = true / 4
    wanted = mesh.required_intervals(layer(mesh.nodes), True, accuracy)
    better = mesh.adapt(layer(mesh.nodes), True, round(wanted))
    reached = np.linalg.norm(better.interpolate(layer(better.nodes), where) - layer(where), axis=1).max()
    assert 1 / 4 < reached / accuracy < 4


def test_the_error_of_a_function_that_does_not_return_is_large_where_it_is_steep() -> None:
    """At its begin and not at its end, or the other way; of one that returns the end is beside the begin."""
    mesh = Mesh.even(40, 4)
    falls = np.exp(-20 * mesh.nodes)[:, None]
    error = mesh.error(falls, False)
    true = np.array([
        np.abs(mesh.interpolate(falls, at)[:, 0] - np.exp(-20 * at)).max()
        for at in np.linspace(mesh.edges[:-1], mesh.edges[1:], 101).T
    ])  # fmt: skip
    assert (np.diff(error) <= 0).all() and error / true == pytest.approx(np.ones(40), rel=0.75)
    assert mesh.error(falls[::-1], False) == pytest.approx(error[::-1], rel=1e-6)
    assert mesh.error(falls, True)[-1] > 1e3 * error[-1]


def test_a_mesh_of_samples_is_finer_where_they_change_faster() -> None:
    """In units of the sizes: where a small state of a small size is steep, not where its size is large; values by splines."""
    times = np.linspace(2.0, 6.0, 401)
    steep = np.tanh(40 * (times - 3.0) / 4)
    for size, share in ((1e-3, True), (1e3, False)):
        mesh, values = mesh_from_samples(times, np.array([1e-3 * steep, 0.5 * times]), np.array([size, 1.0]), 4)
        inside = float(((mesh.edges > 0.2) & (mesh.edges < 0.3)).mean())
        assert (inside > 0.3) is share and (mesh.edges[0], mesh.edges[-1]) == (0.0, 1.0)
        assert values[:, 1] == pytest.approx(0.5 * (2 + 4 * mesh.nodes)) and values.shape == (len(mesh.nodes), 2)
        assert values[:, 0] == pytest.approx(1e-3 * np.tanh(40 * (4 * mesh.nodes - 1) / 4), abs=1e-8)
    still, _ = mesh_from_samples(times, np.ones((1, 401)), np.ones(1), 4)
    assert np.diff(still.edges) == pytest.approx(np.full(still.intervals, 1 / still.intervals))


@pytest.mark.parametrize("degree", [2, 6])
def test_stationary_places_of_piecewise_polynomials(degree: int) -> None:
    """Of sin(6 pi t): (k + 1/2)/6; of a peak of width 1e-4, which the mesh resolves: its top, however narrow it is."""
    mesh = Mesh.even(60, degree)
    places = mesh.stationary_places(np.sin(6 * np.pi * mesh.nodes))
    assert places == pytest.approx((np.arange(6) + 0.5) / 6, abs=10.0 ** -(degree + 1))
    top, width = 0.123456789, 1e-4
    narrow = Mesh(np.concatenate([[0.0], top + width * np.linspace(-5, 5, 60), [1.0]]), degree)
    places = narrow.stationary_places(np.exp(-(((narrow.nodes - top) / width) ** 2)))
    assert places[np.abs(places - top) < width] == pytest.approx([top], abs=1e-2 * width)
    assert len(mesh.stationary_places(3.0 * mesh.nodes)) == 0
    assert len(mesh.stationary_places(np.full(len(mesh.nodes), np.nan))) == 0
