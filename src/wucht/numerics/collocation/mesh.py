"""Piecewise polynomials over [0, 1]: their nodes, their collocation points, and the mesh that suits them best.

U. M. Ascher, R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential
Equations", SIAM 1995, chapters 5 (collocation at Gauss points) and 9 (mesh selection).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from wucht.numerics.zeros_and_peaks import crossings

_PROBES = 3  # times the degree: places of an interval between which the sign of a derivative is compared
_FLOOR = 0.3  # share of the mean density that every place of a mesh keeps: C. de Boor's safeguard, SIAM 1995 (9.27)


@dataclass(frozen=True, eq=False)
class Basis:
    """Polynomials of degree m on [0, 1], by their values at m + 1 nodes, collocated at the m points of Gauss.

    nodes (m+1,): Chebyshev's, ends included. points, weights (m,): of Gauss' quadrature. values, slopes (m, m+1): from the
    nodes' values to the polynomial and its derivative at the points. node_slopes (m+1, m+1): to its derivative at the nodes.
    highest (m+1,): to its m-th derivative.
    """

    degree: int
    nodes: np.ndarray
    points: np.ndarray
    weights: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    node_slopes: np.ndarray
    highest: np.ndarray

    def interpolation_matrix(self, places: np.ndarray) -> np.ndarray:
        """Return the matrix (K, m+1) from the nodes' values to those at places (K,) of [0, 1], by the barycentric formula."""
        away = places[:, None] - self.nodes
        exact = away == 0
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = _barycentric(self.nodes) / away
            matrix = shares / shares.sum(axis=1, keepdims=True)
        hit = exact.any(axis=1)
        matrix[hit] = exact[hit]
        return np.asarray(matrix)


@lru_cache(maxsize=32)
def basis(degree: int) -> Basis:
    """Return the basis of a degree."""
    nodes = (1 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2
    points, weights = np.polynomial.legendre.leggauss(degree)
    points, weights = (points + 1) / 2, weights / 2
    lagrange = np.linalg.inv(np.vander(2 * nodes - 1, increasing=True))  # columns: coefficients of the node's polynomial
    powers = np.arange(degree + 1)

    def matrices(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = np.vander(2 * places - 1, degree + 1, increasing=True)
        derivative = np.zeros_like(at)
        derivative[:, 1:] = 2 * powers[1:] * at[:, :-1]
        return at @ lagrange, derivative @ lagrange

    highest = lagrange[-1] * math.factorial(degree) * 2.0**degree
    return Basis(degree, nodes, points, weights, *matrices(points), matrices(nodes)[1], highest)


def _barycentric(nodes: np.ndarray) -> np.ndarray:
    weights = np.where(np.arange(len(nodes)) % 2, -1.0, 1.0)
    weights[[0, -1]] /= 2
    return weights


@dataclass(frozen=True, eq=False)
class Mesh:
    """N intervals of [0, 1] with a polynomial of one degree m on each. edges: (N+1,), from 0 to 1."""

    edges: np.ndarray
    degree: int

    @classmethod
    def even(cls, intervals: int, degree: int) -> Mesh:
        """Return a mesh of equal intervals."""
        return cls(np.linspace(0.0, 1.0, intervals + 1), degree)

    def subdivide(self, parts: np.ndarray) -> Mesh:
        """Divide each interval into so many equal parts (N,)."""
        whole = np.repeat(np.arange(self.intervals), parts)
        within = np.arange(len(whole)) - np.repeat(np.cumsum(parts) - parts, parts)
        return Mesh(np.append(self.edges[whole] + self.lengths[whole] * within / parts[whole], 1.0), self.degree)

    @property
    def intervals(self) -> int:
        """Number N of intervals."""
        return len(self.edges) - 1

    def spread(self, count: int) -> np.ndarray:
        """Return places (count,) from 0 to 1 for drawing a curve: denser where intervals are short."""
        density = (self.edges + np.linspace(0.0, 1.0, len(self.edges))) / 2
        return np.asarray(np.interp(np.linspace(0.0, 1.0, count), density, self.edges))

    @property
    def basis(self) -> Basis:
        """Polynomial basis of each interval."""
        return basis(self.degree)

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths of the intervals (N,)."""
        return np.diff(self.edges)

    @cached_property
    def nodes(self) -> np.ndarray:
        """Places at which values are stored (N m + 1,); neighbouring intervals share one."""
        inner = self.edges[:-1, None] + self.lengths[:, None] * self.basis.nodes[:-1]
        return np.append(inner.ravel(), 1.0)

    @cached_property
    def shares(self) -> np.ndarray:
        """Weights of the nodes (N m + 1,) in an integral over [0, 1], all positive: the trapezoidal rule."""
        gaps = np.diff(self.nodes)
        return np.asarray((np.append(gaps, 0.0) + np.insert(gaps, 0, 0.0)) / 2)

    @cached_property
    def points(self) -> np.ndarray:
        """Collocation points of the equations (N m,)."""
        return np.asarray(self.edges[:-1, None] + self.lengths[:, None] * self.basis.points).ravel()

    @cached_property
    def weights(self) -> np.ndarray:
        """Weights of the collocation points in an integral over [0, 1] (N, m)."""
        return np.asarray(self.lengths[:, None] * self.basis.weights)

    @cached_property
    def _members(self) -> np.ndarray:
        return np.arange(self.intervals)[:, None] * self.degree + np.arange(self.degree + 1)

    def pieces(self, values: np.ndarray) -> np.ndarray:
        """Arrange the nodes' values (N m + 1, n) interval by interval (N, m+1, n)."""
        return np.asarray(values[self._members])

    def interpolate(self, values: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Interpolate the nodes' values (N m + 1, n) at places (K,) of [0, 1]: (K, n)."""
        return self._pieces_at(self.pieces(values), places)

    def _pieces_at(self, pieces: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Evaluate polynomials, by their values at the nodes of each interval (N, m+1, n), at places (K,): (K, n)."""
        index = np.clip(np.searchsorted(self.edges, places, side="right") - 1, 0, self.intervals - 1)
        matrix = self.basis.interpolation_matrix((places - self.edges[index]) / self.lengths[index])
        return np.asarray((matrix[:, None] @ pieces[index])[:, 0])

    def stationary_places(self, values: np.ndarray) -> np.ndarray:
        """Return the places (K,), in order, where the polynomials of the nodes' values (N m + 1,) have a zero derivative."""
        slopes = (self.basis.node_slopes @ self.pieces(values[:, None])) / self.lengths[:, None, None]
        count = _PROBES * self.degree
        probes = self.edges[:-1, None] + self.lengths[:, None] * (np.arange(count) + 0.5) / count
        return crossings(lambda places: self._pieces_at(slopes, places)[:, 0], probes.ravel())

    def slopes(self, values: np.ndarray) -> np.ndarray:
        """Differentiate the polynomials of values (N m + 1, n) at the nodes; on an edge from the right."""
        slopes = (self.basis.node_slopes @ self.pieces(values)) / self.lengths[:, None, None]
        return np.concatenate([slopes[:, :-1].reshape(-1, values.shape[1]), slopes[-1, -1:]])

    def error(self, values: np.ndarray, periodic: bool) -> np.ndarray:
        """Estimate the error of the polynomials (N m + 1, n) on each interval (N,), between mesh points."""
        return np.asarray(self._constant * self.lengths ** (self.degree + 1) * self._next_derivative(values, periodic))

    @property
    def _constant(self) -> float:
        """Error constant of interpolation at Chebyshev's points."""
        return 1 / (math.factorial(self.degree + 1) * 2.0 ** (2 * self.degree + 1))

    def required_intervals(self, values: np.ndarray, periodic: bool, accuracy: float) -> float:
        """Return how many intervals of the best mesh have an error as small as that."""
        total_density = float(self.density(values, periodic) @ self.lengths)
        return float(total_density * (self._constant / accuracy) ** (1 / (self.degree + 1)))

    def _next_derivative(self, values: np.ndarray, periodic: bool) -> np.ndarray:
        """Estimate the size of the derivative of order m + 1 on each interval (N,), from changes of that of order m: (9.25)."""
        m, h = self.degree, self.lengths
        derivative = np.einsum("i,jin->jn", self.basis.highest, self.pieces(values)) / h[:, None] ** m
        if periodic:
            derivative = np.concatenate([derivative[-1:], derivative, derivative[:1]])
            h = np.concatenate([h[-1:], h, h[:1]])
        change = np.linalg.norm(np.diff(derivative, axis=0), axis=1) / ((h[1:] + h[:-1]) / 2)
        if not periodic:
            change = np.concatenate([change[:1], change, change[-1:]])
        return np.asarray((change[1:] + change[:-1]) / 2)

    def density(self, values: np.ndarray, periodic: bool) -> np.ndarray:
        """Return the density (N,) of mesh points that the values (N m + 1, n) require."""
        density = np.maximum(self._next_derivative(values, periodic) ** (1 / (self.degree + 1)), 1e-300)
        return np.asarray(density + _FLOOR * float(density @ self.lengths))

    def unevenness(self, values: np.ndarray, periodic: bool) -> float:
        """Ratio of the largest to the mean demand for mesh points of an interval: 1 where the mesh suits the values."""
        demand = self.density(values, periodic) * self.lengths
        return float(demand.max() / demand.mean())

    def adapt(self, values: np.ndarray, periodic: bool, intervals: int | None = None) -> Mesh:
        """Return the mesh of as many intervals that distributes the error of these values (N m + 1, n) evenly."""
        cumulative_density = np.insert(np.cumsum(self.density(values, periodic) * self.lengths), 0, 0.0)
        edges = np.interp(
            np.linspace(0.0, cumulative_density[-1], (intervals or self.intervals) + 1), cumulative_density, self.edges
        )
        edges[[0, -1]] = 0.0, 1.0
        return Mesh(edges, self.degree)
