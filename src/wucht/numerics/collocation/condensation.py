"""The linear equations of collocation: inner values are eliminated interval by interval, then neighbouring intervals merged.

Merging is by orthogonal transformations, stable whatever grows or decays along the solution:
S. J. Wright, SIAM J. Sci. Stat. Comput. 13 (1992) 742-764.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError

_GROUP_SIZE = 4  # intervals merged into one
_DENSE = 99  # unknowns of the last equations: OpenBLAS begins threads at 100, which take longer than the equations


@dataclass(frozen=True, eq=False)
class CollocationJacobian:
    """The derivatives of all equations, N intervals of degree m, n states, q parameters, r conditions on integrals.

    first (N, m n, n), inner (N, m n, m n): of the collocated equations by the values at the first node of the interval, and
    at the others. by_parameters (N, m n, q): by the parameters. begin, end (b, n), ends_by_parameters (b, q): of the conditions
    at the ends. integrals (r, N, m+1, n), integrals_by_parameters (r, q): of the conditions on integrals.
    """

    first: np.ndarray
    inner: np.ndarray
    by_parameters: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    ends_by_parameters: np.ndarray
    integrals: np.ndarray
    integrals_by_parameters: np.ndarray

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Sizes N, m, n, q."""
        (intervals, rows, n), q = self.first.shape, self.by_parameters.shape[2]
        return intervals, rows // n, n, q

    def maps(self) -> np.ndarray:
        """Return the maps of small changes at the first node of each interval to its other nodes (N, m, n, n), P constant."""
        intervals, m, n, _ = self.shape
        return -np.linalg.solve(self.inner, self.first).reshape(intervals, m, n, n)

    def solve(self, row: np.ndarray, sides: np.ndarray) -> np.ndarray:
        """Solve [J; row] x = sides for x.

        row, x, sides: (N m n + n + q,) or with k columns: values at the nodes, node by node, then parameters; the equations'
        order is collocation, ends, integrals, the row. Raises ``RunError`` if singular.
        """
        intervals, m, n, _ = self.shape
        collocation_count = intervals * m * n
        try:
            return self._solve_by_blocks(
                row, sides[:collocation_count].reshape(intervals, m * n, -1), sides[collocation_count:]
            )
        except np.linalg.LinAlgError:
            raise RunError("the equations are singular here", code="singular") from None

    def _solve_by_blocks(self, row: np.ndarray, sides: np.ndarray, condition_sides: np.ndarray) -> np.ndarray:
        intervals, m, n, q = self.shape
        k = sides.shape[2]
        # inner values = elimination[..., n+q:] - elimination[..., :n+q] (first value, parameters)
        elimination = np.linalg.solve(self.inner, np.concatenate([self.first, self.by_parameters, sides], axis=2))
        rows, by_parameters, right = self._conditions(row, elimination, condition_sides)
        last = elimination[:, -n:]
        identity = np.broadcast_to(np.eye(n), (intervals, n, n))
        system = CondensedSystem(last[..., :n], identity, last[..., n : n + q], last[..., n + q :], rows, by_parameters, right)
        levels = []
        while (system.segments + 1) * n + q > _DENSE and system.segments >= 2 * _GROUP_SIZE:
            system, inner = system.merge_segments()
            levels.append(inner)
        z, parameters = system.solve(self.begin, self.end, self.ends_by_parameters, condition_sides[: len(self.begin)])
        for inner in reversed(levels):
            z = expand_values(inner, z, parameters)
        x = np.empty((intervals * m + 1, n, k))
        x[0] = z[0]
        inner_values = elimination[..., n + q :] - elimination[..., :n] @ z[:-1] - elimination[..., n : n + q] @ parameters
        x[1:] = inner_values.reshape(intervals * m, n, k)
        return np.concatenate([x.reshape(-1, k), parameters])

    def _conditions(
        self, row: np.ndarray, elimination: np.ndarray, condition_sides: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the conditions on integrals and the row, by mesh values (r+1, N+1, n), parameters (r+1, q), sides (r+1, k)."""
        intervals, m, n, q = self.shape
        count = len(self.integrals) + 1
        pieces = np.zeros((count, intervals, m + 1, n))
        pieces[:-1] = self.integrals
        values = row[: intervals * m * n + n].reshape(-1, n)
        pieces[-1, :, 1:] = values[1:].reshape(intervals, m, n)
        pieces[-1, 0, 0] = values[0]
        inner = pieces[:, :, 1:m].reshape(count, intervals, (m - 1) * n).transpose(1, 0, 2) @ elimination[:, : (m - 1) * n]
        rows = np.zeros((count, intervals + 1, n))
        rows[:, :-1] = pieces[:, :, 0] - inner[..., :n].transpose(1, 0, 2)
        rows[:, 1:] += pieces[:, :, m]
        inner = inner.sum(axis=0)
        by_parameters = np.concatenate([self.integrals_by_parameters, row[None, -q:]]) - inner[:, n : n + q]
        return rows, by_parameters, condition_sides[-count:] - inner[:, n + q :]


@dataclass(frozen=True, eq=False)
class CondensedSystem:
    """Equations of M segments: left z_l + right z_r + by_parameters P = sides, rows z + row_parameters P = row_sides.

    left_blocks, right_blocks (M, n, n), by_parameters (M, n, q), sides (M, n, k); rows (c, M+1, n), row_parameters (c, q),
    row_sides (c, k).
    """

    left_blocks: np.ndarray
    right_blocks: np.ndarray
    by_parameters: np.ndarray
    sides: np.ndarray
    rows: np.ndarray
    row_parameters: np.ndarray
    row_sides: np.ndarray

    @property
    def segments(self) -> int:
        """Number M of segments."""
        return len(self.left_blocks)

    def merge_segments(self) -> tuple[CondensedSystem, np.ndarray]:
        """Merge each group of segments into one; return also the elimination of the values within groups."""
        n, q, k, g = self.left_blocks.shape[1], self.by_parameters.shape[2], self.sides.shape[2], _GROUP_SIZE
        groups = self.segments // g
        grouped_count = groups * g
        shape = (groups, g, n)
        matrix, right_sides = np.zeros((*shape, (g - 1) * n)), np.zeros((*shape, 2 * n + q + k))
        left_blocks, right_blocks = (
            self.left_blocks[:grouped_count].reshape(*shape, n),
            self.right_blocks[:grouped_count].reshape(*shape, n),
        )
        for i in range(g):
            if i:
                matrix[:, i, :, (i - 1) * n : i * n] = left_blocks[:, i]
            if i < g - 1:
                matrix[:, i, :, i * n : (i + 1) * n] = right_blocks[:, i]
        right_sides[:, 0, :, :n], right_sides[:, -1, :, n : 2 * n] = left_blocks[:, 0], right_blocks[:, -1]
        right_sides[..., 2 * n : 2 * n + q] = self.by_parameters[:grouped_count].reshape(*shape, q)
        right_sides[..., 2 * n + q :] = self.sides[:grouped_count].reshape(*shape, k)
        turn, triangle = np.linalg.qr(matrix.reshape(groups, g * n, -1), mode="complete")
        rotated_sides = turn.transpose(0, 2, 1) @ right_sides.reshape(groups, g * n, -1)
        size = (g - 1) * n
        elimination = np.linalg.solve(triangle[:, :size], rotated_sides[:, :size])
        merged_blocks = [np.concatenate([rotated_sides[:, size:, a:b], rest[grouped_count:]]) for a, b, rest in (
            (0, n, self.left_blocks), (n, 2 * n, self.right_blocks), (2 * n, 2 * n + q, self.by_parameters),
            (2 * n + q, None, self.sides)
        )]  # fmt: skip
        count = len(self.rows)
        heads = self.rows[:, :grouped_count].reshape(count, groups, g, n)
        inner = heads[:, :, 1:].reshape(count, groups, size).transpose(1, 0, 2) @ elimination
        rows = np.concatenate([heads[:, :, 0], self.rows[:, grouped_count:]], axis=1)
        rows[:, :groups] -= inner[..., :n].transpose(1, 0, 2)
        rows[:, 1 : groups + 1] -= inner[..., n : 2 * n].transpose(1, 0, 2)
        inner = inner.sum(axis=0)
        row_parameters, row_sides = self.row_parameters - inner[:, 2 * n : 2 * n + q], self.row_sides - inner[:, 2 * n + q :]
        lefts, rights, merged_parameters, merged_sides = merged_blocks
        merged_system = CondensedSystem(lefts, rights, merged_parameters, merged_sides, rows, row_parameters, row_sides)
        return merged_system, elimination

    def solve(
        self, begin: np.ndarray, end: np.ndarray, by_parameters: np.ndarray, sides: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Solve for z (M+1, n, k) and parameters (q, k), with begin z_0 + end z_M + by_parameters P = sides (b, k) as well."""
        m, n, q = self.segments, self.left_blocks.shape[1], self.by_parameters.shape[2]
        size, b, k = (m + 1) * n, len(begin), self.sides.shape[2]
        matrix, right = np.zeros((size + q, size + q)), np.empty((size + q, k))
        chain = matrix[: m * n, :size].reshape(m, n, m + 1, n)
        index = np.arange(m)
        chain[index, :, index], chain[index, :, index + 1] = self.left_blocks, self.right_blocks
        matrix[: m * n, size:], right[: m * n] = self.by_parameters.reshape(m * n, q), self.sides.reshape(m * n, k)
        ends = slice(m * n, m * n + b)
        matrix[ends, :n], matrix[ends, size - n : size], matrix[ends, size:], right[ends] = begin, end, by_parameters, sides
        rest = slice(m * n + b, None)
        matrix[rest, :size], matrix[rest, size:] = self.rows.reshape(-1, size), self.row_parameters
        right[rest] = self.row_sides
        x = np.linalg.solve(matrix, right)
        return x[:size].reshape(m + 1, n, k), x[size:]


def expand_values(elimination: np.ndarray, z: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """Recover the values (M+1, n, k) of all segments from those (M'+1, n, k) at the ends of groups and single segments.

    Within groups z = elimination[..., 2n+q:] - elimination[..., :2n+q] (z_left, z_right, parameters). parameters (q, k).
    """
    groups, n, k = len(elimination), z.shape[1], z.shape[2]
    outer_values = np.concatenate(
        [z[:groups], z[1 : groups + 1], np.broadcast_to(parameters, (groups, *parameters.shape))], axis=1
    )
    size = outer_values.shape[1]
    inner = elimination[..., size:] - elimination[..., :size] @ outer_values
    block = np.concatenate([z[:groups, None], inner.reshape(groups, -1, n, k)], axis=1)
    return np.concatenate([block.reshape(-1, n, k), z[groups:]])
