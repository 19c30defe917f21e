"""Where periodic orbits are not isolated: the directions of a family, and those in which it cannot be closed.

An orbit near x(0), T is closed by (M - 1) dx + (dx(T)/dT) dT = -gap. Where this matrix has not full rank, x(T) = x(0) + advance
becomes x(T) = x(0) + advance + sum_i s_i l_i, l_i spanning what its columns do not reach, and the change has no part along the
w_j that it maps to zero: those lead along the family. Such a bordered matrix is regular. The s_i are found with the orbit:
zero on a true family, and the gap of a member of one that something small has broken.
W. Govaerts, "Numerical Methods for Bifurcations of Dynamical Equilibria", SIAM 2000, chapter 3.

The monodromy matrix M is not multiplied out: with places on the way, the changes at all of them are the unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError

_SINGULAR = 1e-9  # share of the largest singular value below which a direction leads along a family
_LARGE = 10.0  # the largest one of which that is a share: what grows by more in a period is no measure
_CONDITION = 1e3  # of products of maps: places are where it would become larger


@dataclass(frozen=True, eq=False)
class Borders:
    """What makes the equations of an orbit regular, in units of the states' sizes and of the period.

    open (n, k): l_i, orthonormal. rows (k + 1, n + 1): conditions on the changes of x(0) and T, the first the one that is met
    exactly (the held period, or a held state).
    """

    open: np.ndarray
    rows: np.ndarray


@dataclass(frozen=True, eq=False)
class Places:
    """An orbit's linearisation, in units of the states' sizes and of the period.

    maps (G, n, n): what changes at a place become at the next one. by_period (G, n): what a change of the period adds there.
    """

    maps: np.ndarray
    by_period: np.ndarray

    @property
    def matrix(self) -> np.ndarray:
        """Of the changes at the places and of the period (G n + 1) to what is missed at the next places (G n)."""
        count, n, _ = self.maps.shape
        matrix = np.zeros((count, n, count * n + 1))
        for j, (each, late) in enumerate(zip(self.maps, self.by_period, strict=True)):
            matrix[j, :, j * n : (j + 1) * n] += each
            after = (j + 1) % count * n
            matrix[j, :, after : after + n] -= np.eye(n)
            matrix[j, :, -1] = late
        return matrix.reshape(count * n, -1)

    def borders(self, held: tuple[int, ...], free_period: bool, left_open: int, error: float = 0.0) -> Borders:
        """What is added to the equations.

        held: states that keep their first value. free_period: whether T is unknown. left_open: at least so many directions of a
        family. error: of the maps; what is smaller counts as zero. Raises ``RunError`` where more directions are singular than
        there are states.
        """
        count, n, _ = self.maps.shape
        kept = [i for i in range(count * n + free_period) if i not in held]
        try:
            left, values, right = np.linalg.svd(self.matrix[:, kept])
        except np.linalg.LinAlgError:  # they are not finite
            raise RunError("the equations are singular here") from None
        smallest = max(_SINGULAR * min(max(values[0], 1.0), _LARGE), error)
        rank = min(int((values > smallest).sum()), len(values) - left_open)
        if count * n - rank > n:
            raise RunError("the equations are singular here", code="singular")
        along = np.zeros((len(right) - rank, count * n + 1))
        along[:, kept] = right[rank:]
        family = np.linalg.qr(along[:, [*range(n), count * n]].T)[0].T
        fixed = np.eye(n + 1)[[*(() if free_period else (n,)), *held]]
        return Borders(np.linalg.qr(left[-n:, rank:])[0], np.concatenate([fixed, family]))

    def correction(self, missed: np.ndarray, borders: Borders) -> tuple[np.ndarray, float, np.ndarray]:
        """What closes an orbit: changes (G, n) at the places and of the period, none along a family, and the s_i (k,).

        missed (G, n): by how much each place's motion misses the next place. Raises ``RunError`` where that is singular.
        """
        count, n, _ = self.maps.shape
        k = borders.open.shape[1]
        matrix = np.zeros((count * n + k + 1, count * n + 1 + k))
        matrix[: count * n, : count * n + 1] = self.matrix
        matrix[(count - 1) * n : count * n, count * n + 1 :] = -borders.open
        matrix[count * n :, :n], matrix[count * n :, count * n] = borders.rows[:, :n], borders.rows[:, n]
        try:
            x = np.linalg.solve(matrix, -np.append(missed.ravel(), np.zeros(k + 1)))
        except np.linalg.LinAlgError:
            raise RunError("the equations are singular here") from None
        return x[: count * n].reshape(count, n), float(x[count * n]), x[count * n + 1 :]


def places(maps: np.ndarray, by_period: np.ndarray) -> tuple[Places, np.ndarray]:
    """The fewest places between which changes grow and decay moderately, of all where the linearisation is known.

    maps (N, n, n), by_period (N, n): of neighbouring ones. Returns also the index of the first of each (G,).
    """
    firsts = [0]
    merged, late = [maps[0]], [by_period[0]]
    for k in range(1, len(maps)):
        product = maps[k] @ merged[-1]
        if np.linalg.cond(product) < _CONDITION:
            merged[-1], late[-1] = product, maps[k] @ late[-1] + by_period[k]
        else:
            firsts.append(k)
            merged.append(maps[k])
            late.append(by_period[k])
    return Places(np.array(merged), np.array(late)), np.array(firsts)
