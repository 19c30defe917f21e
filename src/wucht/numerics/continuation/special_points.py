"""Special points of a curve: where a function of its points passes zero, and where two branches of F(X) = 0 cross.

Of branch points: W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, sections 6.1 (defining
equations) and 4.1 (the algebraic branching equation).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Curve
from wucht.numerics.continuation.equations import CurvePoint, EquilibriumEquations
from wucht.numerics.zeros_and_peaks import crossings

P = TypeVar("P")

SUM_ROUNDING = 1e-13  # a smaller sum of two eigenvalues, in terms of their sizes, is rounding

_NODES = 6
_JUMP = 0.1  # of the smaller value at the neighbours: a function that is larger at its change of sign jumps
_AROUND = (0.02, 0.05, 0.1, 0.2)  # of the way: nearer to a branch point rounding spoils what Newton's method finds
_ROUNDING = 1e-13  # of the larger value at the neighbours: a function that is smaller is zero
_ENDS = np.array([0.0, 1.0])
_APPROACH = 0.05  # of the bend of a parabola over a step: zeros up to sqrt(0.05) of the step off the real line count as near
_MOST_STEPS = 15
_TOLERANCE = 1e-12
_CORRECTION_ROUNDING = 1e-8  # corrections that small and no longer smaller are rounding
_TOUCHING = 1e-8  # in units of scale: branches that pass each other more closely cross
_STEP = 6e-6  # of a central difference, in units of scale: the cube root of rounding


class _Sample(NamedTuple, Generic[P]):
    """A point of the curve, its evaluation, and its test function."""

    point: CurvePoint
    evaluation: P
    value: float


def locate_zero(
    curve: Curve, a: CurvePoint, b: CurvePoint, evaluate: Callable[[CurvePoint], P], test: Callable[[P], float]
) -> P | None:
    """Locate the point between two neighbours where a test function of an evaluated point passes zero.

    None where it jumps instead (a pole), or where the curve cannot be computed there. So near to a branch point that Newton's
    method fails, test function and curve are interpolated between computed points.
    """
    samples: dict[float, _Sample[P]] = {}

    def values(shares: np.ndarray) -> np.ndarray:
        for share in shares.tolist():
            point = curve.point_between(a, b, share)
            there = evaluate(point)
            samples[share] = _Sample(point, there, test(there))
        numbers = np.array([samples[share].value for share in shares.tolist()])
        return np.where(np.abs(numbers) > _ROUNDING * max(_end_values(samples), default=0.0), numbers, 0.0)

    try:
        shares = crossings(values, _ENDS)
        best = samples[shares[0]] if len(shares) else None
    except RunError:
        near = _root(samples)
        for share in _AROUND:
            with suppress(RunError):
                values(np.clip(near + np.array([-share, share]), 0.0, 1.0))
        best = _interpolate_zero(curve, {s: p for s, p in samples.items() if abs(s - near) >= _AROUND[0]}, evaluate, test)
    return None if best is None or abs(best.value) > _JUMP * min(_end_values(samples)) else best.evaluation


def _end_values(samples: dict[float, _Sample[P]]) -> list[float]:
    return [abs(samples[end].value) for end in _ENDS.tolist() if end in samples]


def _interpolate_zero(
    curve: Curve, samples: dict[float, _Sample[P]], evaluate: Callable[[CurvePoint], P], test: Callable[[P], float]
) -> _Sample[P] | None:
    """Return the point where the polynomial through the test function's values passes zero, interpolated between points."""
    root, shares = _root(samples), _nearest(samples)
    if len(shares) < _NODES or not min(samples) <= root <= max(samples):
        return None
    parts = [math.prod((root - r) / (s - r) for r in shares if r != s) for s in shares]
    unknowns, tangent, length = (
        sum(part * getattr(samples[s].point, name) for part, s in zip(parts, shares, strict=True))
        for name in ("unknowns", "tangent", "length")
    )
    point = CurvePoint(unknowns, tangent / curve.size(tangent), curve.problem.residual(unknowns)[1], length, 0)
    there = evaluate(point)
    return _Sample(point, there, test(there))


def _nearest(samples: dict[float, _Sample[P]]) -> list[float]:
    return sorted(samples, key=lambda share: abs(samples[share].value))[:_NODES]


def _root(samples: dict[float, _Sample[P]]) -> float:
    """Interpolate the share, as a polynomial of the test function's values, at zero: Lagrange's formula."""
    distinct = {samples[share].value: share for share in _nearest(samples)[::-1]}
    values = {share: value for value, share in distinct.items()}
    return sum(s * math.prod(values[r] / (values[r] - values[s]) for r in values if r != s) for s in values)


def critical_pairs(eigenvalues: np.ndarray) -> tuple[float, bool]:
    """Test function for sums of two of some eigenvalues (k,), and true if the smallest sum is of a complex pair.

    The number is the least sum of two, in terms of their sizes, with the sign of the product of all; it passes zero where a sum
    does. That is an imaginary pair if they are complex, else a neutral saddle.
    """
    k = len(eigenvalues)
    if k < 2:
        return 1.0, False
    if k == 2:  # by hand: ten times as fast as arrays
        first, second = eigenvalues.tolist()
        size = abs(first) + abs(second)
        return ((first + second).real / size if size > 0 else 0.0), first.imag != 0
    i, j = _pair_indices(k)
    sizes, sums = np.abs(eigenvalues), eigenvalues[i] + eigenvalues[j]
    size = sizes[i] + sizes[j]
    shares = np.abs(sums) / np.where(size > 0, size, 1.0)
    least = int(shares.argmin())
    negative = np.count_nonzero((sums.real < 0) & (sums.imag == 0))  # sums that are not real are conjugate to each other
    return float(shares[least]) * (-1) ** negative, bool(eigenvalues[i[least]].imag != 0)


def least_real(eigenvalues: np.ndarray, largest: float) -> float:
    """Test function for a zero eigenvalue among (k,): the least one in terms of the largest, with the sign of the product."""
    negative = np.count_nonzero((eigenvalues.real < 0) & (eigenvalues.imag == 0))
    return float(np.abs(eigenvalues).min()) / largest * (-1) ** negative if largest > 0 else 0.0


def eigenvalues_of(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvalues of a matrix (k, k)."""
    from scipy.linalg.lapack import dgeev

    real, imaginary, _, _, _ = dgeev(matrix, compute_vl=0, compute_vr=0)
    return np.asarray(real + 1j * imaginary)


def may_cross(before: np.ndarray, matrix: np.ndarray, after: np.ndarray, rounding: float) -> bool:
    """True if eigenvalues may pass the imaginary axis within a step in ways that cancel: some pass, and as many come back.

    From eigenvalues at both ends (k,), and the matrix (k, k) half way: true if real parts are parabolas that pass zero, or
    nearly. Complex ones are matched to the nearest, real ones in their order, with their product; where pairs become real, or
    cannot be distinguished, all in the order of real parts. rounding: in terms of the largest, smaller values have no sign.
    """
    a, b = before.tolist(), after.tolist()
    largest = max(map(abs, (*a, *b)))
    on_axis = rounding * largest
    if len(a) == 1:  # few by hand: this is evaluated at each step
        return _dips(a[0].real, float(matrix[0, 0]), b[0].real, on_axis)
    if len(a) == 2:
        (p, q), (r, s) = matrix.tolist()
        determinants = (a[0] * a[1]).real, p * s - q * r, (b[0] * b[1]).real
        imaginary = determinants[1] > 0
        return _dips(*determinants, on_axis * largest) or (
            imaginary and _dips((a[0] + a[1]).real, p + s, (b[0] + b[1]).real, on_axis)
        )
    stages = a, eigenvalues_of(matrix).tolist(), b
    reals = [sorted(z.real for z in e if z.imag == 0) for e in stages]
    pairs = _match_eigenvalues(*([z for z in e if z.imag > 0] for e in stages))
    if pairs is None or not len(reals[0]) == len(reals[1]) == len(reals[2]):
        return any(_dips(x, y, z, on_axis) for x, y, z in zip(*(sorted(z.real for z in e) for e in stages), strict=True))
    has_rounding = any(min(abs(x), abs(z)) <= on_axis for x, z in zip(reals[0], reals[2], strict=True))
    if not has_rounding and _dips(math.prod(reals[0]), math.prod(reals[1]), math.prod(reals[2]), 0.0):
        return True
    triples = [*zip(*reals, strict=True), *((x.real, y.real, z.real) for x, y, z in pairs)]
    return any(_dips(x, y, z, on_axis) or min(max(x, z), -min(x, z)) > on_axis for x, y, z in triples)


def _match_eigenvalues(a: list[complex], m: list[complex], b: list[complex]) -> list[tuple[complex, complex, complex]] | None:
    """Match numbers at one end to the closest half way, and to those at the other end closest to the extrapolation of both.

    None if two are matched to the same.
    """
    if not len(a) == len(m) == len(b):
        return None
    middle = [_closest(m, x) for x in a]
    triples = [(x, y, _closest(b, 2 * y - x)) for x, y in zip(a, middle, strict=True)]
    return triples if all(len(set(column)) == len(a) for column in zip(*triples, strict=True)) else None


def _closest(numbers: list[complex], z: complex) -> complex:
    return min(numbers, key=lambda number: abs(number - z))


def _dips(a: float, m: float, b: float, rounding: float) -> bool:
    """True if the parabola through values of one sign at both ends of a step, and one half way, passes zero, or nearly."""
    a, b = (a if abs(a) > rounding else 0.0), (b if abs(b) > rounding else 0.0)
    if a * b < 0 or (a == b == 0 and abs(m) <= rounding):
        return False
    if a + b < 0:
        a, m, b = -a, -m, -b
    bend, slope = 2 * (a - 2 * m + b), 4 * m - 3 * a - b
    return m < -rounding or (0 < -slope < 2 * bend and a - slope**2 / (4 * bend) < _APPROACH * bend)


@lru_cache(maxsize=64)
def _pair_indices(k: int) -> tuple[np.ndarray, np.ndarray]:
    return np.triu_indices(k, 1)


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """A point at which two branches cross.

    unknowns (n+1,). jacobian (n, n+1). tangents (2, n+1): of the followed branch, and of the other. share: of the step.
    """

    unknowns: np.ndarray
    jacobian: np.ndarray
    tangents: np.ndarray
    share: float = 0.0

    @classmethod
    def from_point(cls, equations: EquilibriumEquations, unknowns: np.ndarray, along: np.ndarray | None = None) -> BranchPoint:
        """Compute the branches through a branch point; the first is nearest to a direction (n+1,), by default the parameter.

        Raises ``RunError`` where two branches do not cross there.
        """
        scale = equations.scale
        jacobian = equations.values(unknowns)[1]
        weights = _equation_weights(equations, unknowns)
        left_vectors, _, right_vectors = np.linalg.svd(jacobian * scale * weights[:, None])
        w, null_basis = left_vectors[:, -1] * weights, right_vectors[-2:] * scale
        second = np.array([w @ _derivative_along(equations, unknowns, v) @ null_basis.T for v in null_basis])
        a, b, c = second[0, 0], (second[0, 1] + second[1, 0]) / 2, second[1, 1]
        inside = b * b - a * c
        if not inside > 1e-8 * (b * b + abs(a * c)):
            raise RunError("no two branches cross here: this is not a simple branch point")
        # a x^2 + 2 b x y + c y^2 = 0, each root by the formula that does not cancel.
        q = -(b + math.copysign(math.sqrt(inside), b))
        roots = np.array([(q, a), (c, q)])
        tangents = roots @ null_basis
        tangents /= np.linalg.norm(tangents / scale, axis=1)[:, None]
        reference = np.eye(len(unknowns))[-1] * scale if along is None else along
        near = np.abs(tangents / scale @ (reference / scale))
        tangents = tangents[np.argsort(-near)]
        tangents *= np.where(tangents / scale @ (reference / scale) < 0, -1.0, 1.0)[:, None]
        return cls(unknowns, jacobian, tangents)


def _derivative_along(equations: EquilibriumEquations, unknowns: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Differentiate dF/dX (n, n+m) along a direction (n+m,) by a central difference: accurate to about ten digits."""
    length = float(np.linalg.norm(direction / equations.scale))
    h = _STEP / length if length else 1.0
    _, jacobians = equations.values(np.stack([unknowns + h * direction, unknowns - h * direction], axis=-1))
    return np.asarray((jacobians[..., 0] - jacobians[..., 1]) / (2 * h))


def branch_point(equations: EquilibriumEquations, a: CurvePoint, b: CurvePoint) -> BranchPoint:
    """Solve for the branch point between two neighbouring points of a branch.

    Raises ``RunError`` where none lies there.
    """
    way = (b.unknowns - a.unknowns) / equations.scale
    unknowns = _singular_solution(equations, (a.unknowns + b.unknowns) / 2)
    share = float((unknowns - a.unknowns) / equations.scale @ way / (way @ way))
    if not -0.5 <= share <= 1.5:
        raise RunError("no branch point was found between the two points")
    return replace(BranchPoint.from_point(equations, unknowns, b.unknowns - a.unknowns), share=share)


def branch_point_near(equations: EquilibriumEquations, unknowns: np.ndarray) -> BranchPoint:
    """Solve for the branch point near given unknowns (n+1,), its branches in the order of ``BranchPoint.from_point``.

    Raises ``RunError`` where Newton's method does not converge.
    """
    return BranchPoint.from_point(equations, _singular_solution(equations, unknowns))


def _singular_solution(equations: EquilibriumEquations, unknowns: np.ndarray) -> np.ndarray:
    """Solve for the unknowns X where F_X (n, n+1) lacks full rank: a regular solution of F + b w = 0, F_X^T w = 0, w^T w = 1.

    The unknowns are X, b, w. Raises ``RunError`` where Newton's method does not converge from the given X (n+1,).
    """
    n, scale, slack = equations.n, equations.scale, 0.0
    weights = _equation_weights(equations, unknowns)[:, None]
    if not np.isfinite(weights).all():
        raise RunError("Newton's method for a branch point fails: the equations cannot be evaluated there")
    w = np.linalg.svd(equations.values(unknowns)[1] * scale * weights)[0][:, -1]
    before = math.inf
    for _ in range(_MOST_STEPS):
        off, jacobian = equations.values(unknowns)
        off, scaled_jacobian = off * weights[:, 0], jacobian * scale * weights
        hessian = np.einsum("i,ijk->jk", w * weights[:, 0], _second_derivatives(equations, unknowns))
        matrix = np.zeros((2 * n + 2, 2 * n + 2))
        matrix[:n, : n + 1], matrix[:n, n + 1], matrix[:n, n + 2 :] = scaled_jacobian, w, slack * np.eye(n)
        matrix[n : 2 * n + 1, : n + 1], matrix[n : 2 * n + 1, n + 2 :] = hessian, scaled_jacobian.T
        matrix[-1, n + 2 :] = 2 * w
        residual = np.concatenate([off + slack * w, scaled_jacobian.T @ w, [w @ w - 1]])
        try:
            step = np.linalg.solve(matrix, -residual)
        except np.linalg.LinAlgError:
            break
        unknowns, slack, w = unknowns + step[: n + 1] * scale, slack + step[n + 1], w + step[n + 2 :]
        change = float(np.abs(step[: n + 2]).max())
        if not math.isfinite(change):
            break
        if change <= _TOLERANCE * max(1.0, float(np.abs(unknowns / scale).max())) or before / 2 < change < _CORRECTION_ROUNDING:
            if abs(slack) < _TOUCHING:
                return unknowns
            break
        before = change
    raise RunError("Newton's method does not converge to a branch point")


def _equation_weights(equations: EquilibriumEquations, unknowns: np.ndarray) -> np.ndarray:
    """Return the weights (n,) by which equations of very different rates become of one size.

    At a branch point first derivatives alone may vanish, so that the second ones count, too.
    """
    first, second = equations.values(unknowns)[1] * equations.scale, _second_derivatives(equations, unknowns)
    rates = np.abs(np.concatenate([first, *np.moveaxis(second, 1, 0)], axis=1)).max(axis=1)
    return np.asarray(1 / np.where(rates > 0, rates, 1.0))


def _second_derivatives(equations: EquilibriumEquations, unknowns: np.ndarray) -> np.ndarray:
    """Return d^2 F / du^2 (n, n+1, n+1) in units of scale, by central differences."""
    n, basis = equations.n, _STEP * np.diag(equations.scale)
    jacobians = equations.values(unknowns[:, None] + np.concatenate([basis, -basis], axis=1))[1]
    return np.asarray((jacobians[..., : n + 1] - jacobians[..., n + 1 :]) * equations.scale[:, None] / (2 * _STEP))
