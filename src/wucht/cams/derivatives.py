"""Derivatives up to the third of functions of functions, and of what a rod of constant length makes two points do.

The derivatives of a function, orders 0 to 3, are one array (4, ...).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def composed(outer: np.ndarray, inner: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """The highest derivative of y(x(t)), of an order from 0 to 3: Faa di Bruno's formula.

    outer: of y by x (4, ...). inner: of x by t, up to the order that is wanted.
    """
    y, (_, *x) = outer, inner
    if not x:
        return np.asarray(y[0])
    if len(x) == 1:
        return np.asarray(y[1] * x[0])
    if len(x) == 2:
        return np.asarray(y[2] * x[0] ** 2 + y[1] * x[1])
    return np.asarray(y[3] * x[0] ** 3 + 3 * y[2] * x[0] * x[1] + y[1] * x[2])


def at_constant_distance(given: np.ndarray, follower: np.ndarray) -> np.ndarray:
    """The derivatives y', y'', y''' (3, ...) by x for which |P(x) - Q(y(x))| stays the same.

    given: of the point P by x, complex (4, ...). follower: of the point Q by y, complex (4, ...), not square to the rod.

    With D = P - Q it is D . D' = 0, D' . D' + D . D'' = 0 and 3 D' . D'' + D . D''' = 0; each is linear in the highest
    derivative of y.
    """
    P, Q = given, follower
    D, grip = P[0] - Q[0], _dot(P[0] - Q[0], Q[1])
    y1 = _dot(D, P[1]) / grip
    D1 = P[1] - Q[1] * y1
    y2 = (_dot(D1, D1) + _dot(D, P[2] - Q[2] * y1**2)) / grip
    D2 = P[2] - Q[2] * y1**2 - Q[1] * y2
    y3 = (3 * _dot(D1, D2) + _dot(D, P[3] - Q[3] * y1**3 - 3 * Q[2] * y1 * y2)) / grip
    return np.stack([y1, y2, y3])


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product of vectors in the complex plane."""
    return np.asarray((np.conj(a) * b).real)
