"""Floquet multipliers as logarithms, right where they are tiny or huge: ln mu of -400 beside one that is 0.

The monodromy matrix is never multiplied out. The maps of parts of the period turn an orthogonal basis, whose stretches are
summed as logarithms; after some periods the basis is that of the invariant subspaces. L. Dieci, E. S. Van Vleck, "Lyapunov
spectral intervals", SIAM J. Numer. Anal. 40 (2002) 516-542; D. S. Watkins, SIAM Rev. 47 (2005) 3-40 (product eigenvalues).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.variational import variational
from wucht.system import System

_CONDITION = 1e4  # of products of maps: four digits less than rounding
_PERIODS = 25
_INTEGRATION = 1e-15  # tolerance


def logarithms(maps: np.ndarray, basis: np.ndarray | None = None, tolerance: float = 1e-12) -> tuple[np.ndarray, np.ndarray]:
    """ln mu of the product maps[-1] ... maps[0].

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
        return _of_block(np.ones((n, n)), maps) if n else np.empty(0, complex), np.eye(n)
    maps = _merged(maps)
    if basis is None:
        basis = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))[0]
    triangles = np.empty_like(maps)
    for _ in range(_PERIODS):
        first = basis
        for k, each in enumerate(maps):
            factors, reflectors, _, _ = dgeqrf(each @ basis)
            triangles[k] = factors
            basis = dorgqr(factors, reflectors)[0]
        turned = first.T @ basis
        # What is left below a block changes its multipliers by as much, relative to them.
        splits = [k for k in range(1, n) if np.abs(turned[k:, :k]).max() < tolerance]
        if len(splits) == n - 1:
            break
    triangles = np.triu(triangles)
    parts = [_of_block(turned[a:b, a:b], triangles[:, a:b, a:b]) for a, b in pairwise([0, *splits, n])]
    values = np.concatenate(parts)
    return np.asarray(values[np.lexsort((-values.imag, -np.round(values.real, 12)))]), basis


def across_flow(maps: np.ndarray, flow: np.ndarray) -> tuple[np.ndarray, float]:
    """The maps of what changes across the orbit, and ln mu of the change along it, which is 0 but for errors.

    maps (G, n, n): from one place of an orbit to the next. flow (G+1, n): dx/dt at these places, the last being the first.
    Returns maps (G, n-1, n-1): their product has the multipliers of the orbit without the trivial one.
    """
    basis = np.linalg.qr(flow[..., None], mode="complete")[0]
    turned = basis[1:].transpose(0, 2, 1) @ maps @ basis[:-1]
    with np.errstate(divide="ignore"):
        along = float(np.log(np.abs(turned[:, 0, 0])).sum())
    return turned[:, 1:, 1:], along


def _merged(maps: np.ndarray) -> np.ndarray:
    """Products of neighbouring maps, as long as each is of moderate condition."""
    while len(maps) > 1:
        even = len(maps) // 2 * 2
        products = np.concatenate([maps[1:even:2] @ maps[0:even:2], maps[even:]])
        if not np.linalg.cond(products).max() < _CONDITION:
            break
        maps = products
    return maps


def _of_block(turned: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """ln mu (b,) of a diagonal block (b, b): of the product of its triangles, turned."""
    with np.errstate(divide="ignore"):
        if len(turned) == 1:
            diagonal = triangles[:, 0, 0]
            negative = ((diagonal < 0).sum() + (turned[0, 0] < 0)) % 2
            return np.array([np.log(np.abs(diagonal)).sum() + 1j * np.pi * negative])
        product, grown = turned, 0.0
        for each in triangles[::-1]:
            product = product @ each
            size = np.abs(product).max()
            product, grown = product / (size or 1.0), grown + np.log(size)
        return np.asarray(np.log(np.linalg.eigvals(product).astype(complex)) + grown)


def integrated_maps(
    system: System, parameters: Mapping[str, float], times: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What small changes become from one place of an orbit to the next, by integrating the variational equations.

    times (K+1,), states (n, K+1): of the orbit, the last a period after the first. Between two of them there are more places
    where the changes grow and decay too differently. Returns maps (G, n, n) and dx/dt (G+1, n). Raises ``RunError``.
    """
    n = len(system.states)
    bare = replace(system, outputs=(), quadratures=())
    compiled = compile_system(variational(bare, n), _INTEGRATION)
    values = np.array(bare.values(parameters))
    maps, places = list[np.ndarray](), list[tuple[float, np.ndarray]]()

    def carry(begin: float, end: float, state: np.ndarray) -> np.ndarray:
        size = np.abs(state).max() or 1.0  # the engines' errors are relative to the largest state
        start = np.concatenate([state, (size * np.eye(n)).ravel()])
        run = integrate(compiled, start, values, np.array([begin, end])).uninterrupted()
        if run.failure is not None:
            raise RunError(f"the multipliers were not found: {run.failure}")
        change = run.states[n:, -1].reshape(n, n).T / size
        middle = (begin + end) / 2
        if np.linalg.cond(change) > _CONDITION and begin < middle < end:
            return carry(middle, end, carry(begin, middle, state))
        maps.append(change)
        places.append((begin, state))
        return np.asarray(run.states[:n, -1])

    for (begin, end), state in zip(pairwise(times), states.T, strict=False):
        carry(begin, end, state)
    places.append((times[-1], states[:, -1]))
    at, x = zip(*places, strict=True)
    return np.array(maps), Evaluator.of_rates(bare).array(np.array(at), np.array(x).T, values).T
