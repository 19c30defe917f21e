"""Floquet multipliers as logarithms, accurate where they are tiny or huge: ln mu of -400 beside one of 0.

The monodromy matrix is never multiplied out. The maps of parts of the period turn an orthogonal basis, whose stretches are
summed as logarithms; after some periods the basis is that of the invariant subspaces. L. Dieci, E. S. Van Vleck, "Lyapunov
spectral intervals", SIAM J. Numer. Anal. 40 (2002) 516-542; D. S. Watkins, SIAM Rev. 47 (2005) 3-40 (product eigenvalues).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from wucht.errors import RunError
from wucht.numerics.collocation.boundary_values import BoundaryValueProblem
from wucht.numerics.collocation.condensation import CollocationJacobian
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.jacobian import variational_system
from wucht.numerics.flow.program import Evaluator
from wucht.system import System

_CONDITION = 1e4  # of products of maps: four digits less than rounding
_MOST_LEGS = 100_000  # of a period
_PERIODS = 25
_VOLUMES = 1e-6  # of ln of a map's determinant: tolerated error
_RESOLUTION, _MOST_PARTS, _REFINEMENTS = 4.0, 64, 2  # change of ln of a volume in an interval that resolves it; parts; times
_MOST_INTERVALS = 600  # decay by more than about e^-2000 in a period is not resolved
_ALIKE = 1e-5  # of ln mu: change on a finer mesh below which it is accurate
_INTEGRATION = 1e-15  # tolerance
# Largest states in the unit of changes, which may be as large as one likes: the integrator allows each state an error relative
# to itself, or to a hundredth, and would lose changes of states of 1e-6 beside those of 1.
_LARGE = 2.0**20


def logarithms(maps: np.ndarray, basis: np.ndarray | None = None, tolerance: float = 1e-12) -> tuple[np.ndarray, np.ndarray]:
    """Return ln mu of the product maps[-1] ... maps[0].

    Parameters
    ----------
    maps : ndarray, (G, n, n)
        Regular, each of moderate condition.
    basis : ndarray, (n, n), optional
        Orthogonal: where the iteration begins, as the basis of a neighbour.
    tolerance : float
        Relative, of mu.

    Returns
    -------
    values : ndarray of complex, (n,)
        The largest real part first, the imaginary parts from -pi to pi; -inf where mu is 0.
    basis : ndarray, (n, n)
        Its first k columns span the invariant subspace of the first k multipliers, where those are larger than the rest.
    """
    from scipy.linalg.lapack import dgeqrf, dorgqr

    n = maps.shape[1]
    if n <= 1:
        return _block_logarithms(np.ones((n, n)), maps) if n else np.empty(0, complex), np.eye(n)
    maps = _merge_maps(maps)
    if basis is None:
        basis = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))[0]
    triangles = np.empty_like(maps)
    for _ in range(_PERIODS):
        first = basis
        for k, step_map in enumerate(maps):
            factors, reflectors, _, _ = dgeqrf(step_map @ basis)
            triangles[k] = factors
            basis = dorgqr(factors, reflectors)[0]
        rotation = first.T @ basis
        # The remainder below a block changes its multipliers by as much, relative to them.
        splits = [k for k in range(1, n) if np.abs(rotation[k:, :k]).max() < tolerance]
        if len(splits) == n - 1:
            break
    triangles = np.triu(triangles)
    parts = [_block_logarithms(rotation[a:b, a:b], triangles[:, a:b, a:b]) for a, b in pairwise([0, *splits, n])]
    values = np.concatenate(parts)
    return np.asarray(values[np.lexsort((-values.imag, -np.round(values.real, 12)))]), basis


def transverse_maps(maps: np.ndarray, flow: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the maps of changes across the orbit, and ln mu of the change along it, which is 0 except for errors.

    maps (G, n, n): from one place of an orbit to the next. flow (G, n): dx/dt at these places.
    Returns maps (G, n-1, n-1): their product has the multipliers of the orbit without the trivial one.
    """
    basis = np.linalg.qr(flow[..., None], mode="complete")[0]
    # The period ends in the very basis in which it began: a recomputed one may be mirrored, where rounding decides on a sign.
    frame_maps = np.concatenate([basis[1:], basis[:1]]).transpose(0, 2, 1) @ maps @ basis
    with np.errstate(divide="ignore"):
        along = float(np.log(np.abs(frame_maps[:, 0, 0])).sum())
    return frame_maps[:, 1:, 1:], along


class OrbitMultipliers(NamedTuple):
    """Multipliers of an orbit. logarithms (n-1,): ln mu without the trivial one. along: that one's, 0 except for errors.
    product_error: sum of all minus the integral of the divergence over a period. basis (n-1, n-1): see ``logarithms``."""

    logarithms: np.ndarray
    along: float
    product_error: float
    basis: np.ndarray


def collocated_multipliers(
    problem: BoundaryValueProblem,
    unknowns: np.ndarray,
    jacobian: CollocationJacobian,
    near: np.ndarray | None,
    tolerance: float,
) -> OrbitMultipliers:
    """Return the multipliers of an orbit by collocation, their product checked by Liouville's formula.

    Where that is violated the changes decay or grow too fast for the mesh, and it is refined there. The orbit is less
    accurate between the points of its mesh than on them: multipliers that hardly change by the refinement are kept. For two
    states the only one is the integral itself.

    Parameters
    ----------
    problem : BoundaryValueProblem
        Of the orbit.
    unknowns : ndarray
        Its unknowns.
    jacobian : CollocationJacobian
        At these unknowns.
    near : ndarray, (n-1, n-1), optional
        The basis of a neighbour.
    tolerance : float
        Relative, of mu.
    """
    maps, volumes = jacobian.maps()[:, -1], problem.divergences(unknowns)
    across, along = transverse_maps(maps, problem.rates_at_edges(unknowns)[:-1])
    values, basis = logarithms(across, near, tolerance)
    product = float(volumes.sum())
    if len(values) == 1:
        return OrbitMultipliers(np.array([product + 0j]), along, 0.0, basis)
    wrong = _wrong_volumes(maps, volumes)
    for _ in range(_REFINEMENTS if wrong.any() else 0):
        parts = np.clip(np.ceil(np.abs(volumes) / _RESOLUTION), 2, _MOST_PARTS).astype(int)
        if (mesh := problem.mesh.subdivide(np.where(wrong, parts, 1))).intervals > _MOST_INTERVALS:
            break
        unknowns, problem = problem.to_mesh(unknowns, mesh), replace(problem, mesh=mesh)
        problem = replace(problem, reference=problem.reference_from(unknowns))
        maps, volumes = problem.residual(unknowns)[1].maps()[:, -1], problem.divergences(unknowns)
        if not (wrong := _wrong_volumes(maps, volumes)).any():
            break
    if problem.mesh.intervals > len(jacobian.first):
        finer = logarithms(transverse_maps(maps, problem.rates_at_edges(unknowns)[:-1])[0], basis, tolerance)[0]
        values = np.where(np.abs(finer - values) < _ALIKE, values, finer)
    return OrbitMultipliers(values, along, float(values.real.sum()) + along - product, basis)


def _wrong_volumes(maps: np.ndarray, volumes: np.ndarray) -> np.ndarray:
    """Return a mask of the maps (G, n, n) whose determinants differ from the growth of volumes, given its logarithm (G,)."""
    return np.asarray(~(np.abs(np.linalg.slogdet(maps)[1] - volumes) < _VOLUMES))


def _merge_maps(maps: np.ndarray) -> np.ndarray:
    """Multiply neighbouring maps, as long as each product is of moderate condition."""
    while len(maps) > 1:
        even = len(maps) // 2 * 2
        products = np.concatenate([maps[1:even:2] @ maps[0:even:2], maps[even:]])
        if not np.linalg.cond(products).max() < _CONDITION:
            break
        maps = products
    return maps


def _block_logarithms(rotation: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return ln mu (b,) of a diagonal block (b, b): of the product of its triangles and its rotation."""
    with np.errstate(divide="ignore"):
        if len(rotation) == 1:
            diagonal = triangles[:, 0, 0]
            negative = ((diagonal < 0).sum() + (rotation[0, 0] < 0)) % 2
            return np.array([np.log(np.abs(diagonal)).sum() + 1j * np.pi * negative])
        product, grown = rotation, 0.0
        for triangle in triangles[::-1]:
            product = product @ triangle
            size = np.abs(product).max()
            product, grown = product / (size or 1.0), grown + np.log(size)
        return np.asarray(np.log(np.linalg.eigvals(product).astype(complex)) + grown)


def integrated_maps(
    system: System, parameter_values: Mapping[str, float], times: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the maps of small changes from one place of an orbit to the next, by integrating the variational equations.

    times (K+1,), states (n, K+1): of the orbit, the last a period after the first. Between two of them there are more places
    where the changes grow and decay too differently. Returns maps (G, n, n) and dx/dt (G, n). Raises ``RunError``.
    """
    bare = replace(system, outputs=(), quadratures=())
    linear, values = (
        compile_system(variational_system(bare, len(states)), _INTEGRATION),
        np.array(bare.values(parameter_values)),
    )
    maps = integrated_legs(linear, values, times[:-1], times[1:], states[:, :-1])[1]
    times, x, maps = halve_legs(linear, values, times, states[:, :-1], maps, np.ones(len(states)))
    return maps, Evaluator.of_rates(bare).array(times[:-1], x, values).T


def halve_legs(
    linear: CompiledSystem,
    parameter_values: np.ndarray,
    times: np.ndarray,
    states: np.ndarray,
    maps: np.ndarray,
    sizes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Halve legs of a motion until changes do not grow and decay too differently: longer maps lose the fastest decay.

    linear: the variational equations. times (G+1,). states (n, G): at the legs' beginnings. maps (G, n, n): in units of the
    states' sizes (n,). Returns times, states and maps. Raises ``RunError``.
    """
    while len(long := np.flatnonzero(np.linalg.cond(maps) > _CONDITION)):
        if len(maps) + len(long) > _MOST_LEGS:
            raise RunError(
                f"changes of the motion grow and decay too differently to be resolved on {_MOST_LEGS} legs",
                code="too-different",
            )
        begin, end = times[long], times[long + 1]
        middle = (begin + end) / 2
        there, first = integrated_legs(linear, parameter_values, begin, middle, states[:, long])
        _, second = integrated_legs(linear, parameter_values, middle, end, there)
        maps = np.insert(maps, long + 1, second * sizes / sizes[:, None], axis=0)
        maps[long + np.arange(len(long))] = first * sizes / sizes[:, None]
        times, states = np.insert(times, long + 1, middle), np.insert(states, long + 1, there, axis=1)
    return times, states, maps


def integrated_legs(
    linear: CompiledSystem, parameter_values: np.ndarray, begin: np.ndarray, end: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the states (n, G) at the ends of legs of a motion, and the maps of small changes to there (G, n, n).

    linear: the variational equations. begin, end (G,): times. states (n, G): at the beginnings. Raises ``RunError``.
    """
    n, legs = states.shape
    ends, maps = np.empty_like(states), np.empty((legs, n, n))
    for j, state in enumerate(states.T):
        size = _LARGE * (float(np.abs(state).max()) or 1.0)
        start = np.concatenate([state, (size * np.eye(n)).ravel()])
        run = integrate(linear, start, parameter_values, np.array([begin[j], end[j]])).reraise_interrupt()
        if run.failure is not None:
            raise RunError(f"the linearised equations could not be integrated: {run.failure}")
        ends[:, j], maps[j] = run.states[:n, -1], run.states[n:, -1].reshape(n, n).T / size
    return ends, maps
