"""The directions in which a saddle is left and reached, as conditions on the ends of an orbit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError


@dataclass(frozen=True, eq=False)
class Directions:
    """Of an equilibrium that is left in one direction.

    leaving (n,): its left eigenvector, normal to where the equilibrium is reached. others (n-1, n): a basis of the span of the
    other left eigenvectors, normal to where it is left. by_right, by_left: the states by which the right and the left
    eigenvector of the leaving direction are measured, largest where they were chosen.
    """

    leaving: np.ndarray
    others: np.ndarray
    by_right: int
    by_left: int

    @classmethod
    def of(cls, jacobian: np.ndarray, scale: np.ndarray, by: tuple[int, int] | None = None) -> Directions:
        """Of the Jacobian (n, n), measured by sizes (n,).

        by: the states by which both eigenvectors are measured, where they are compared with those at another place: measured
        each by its own largest part they would jump. Raises ``RunError`` where the leaving eigenvalue is complex.
        """
        matrix = jacobian / scale[:, None] * scale
        right, left = _leaving(matrix), _leaving(matrix.T)
        by_right, by_left = by or (int(np.abs(right).argmax()), int(np.abs(left).argmax()))
        others = np.delete(np.eye(len(scale)), by_right, axis=0)
        others[:, by_right] = -np.delete(right, by_right) / right[by_right]
        return cls(left / left[by_left] / scale, others / scale, by_right, by_left)


def _leaving(matrix: np.ndarray) -> np.ndarray:
    """The eigenvector (n,) of the largest eigenvalue: that is a simple one, and the vector known, whatever the others are."""
    values, vectors = np.linalg.eig(matrix)
    k = int(values.real.argmax())
    if values[k].imag != 0:
        raise RunError("the equilibrium is left in more than one direction")
    return np.asarray(vectors[:, k].real)
