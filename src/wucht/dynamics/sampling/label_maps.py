"""Maps of labels: the cells that are run anew when they are halved, and the error of the share that a label has.

A cell is at a border where one of its eight neighbours has another label; along a periodic axis the first and the last are
neighbours. Halved are the cells at a border, on the coarsest map with a rim of one cell about them; the others hand down their
label. The centre of a halved cell is no longer that of a cell: all four that it becomes are run. When they are, a cell that was
handed down may lie at a border after all, where a tongue leaves the halved cells: then it is run too, and so on until every
cell at a border was run itself. So a tongue is followed from where it leaves the border as far as it is as wide as a fine cell;
a rim on every map would detect hardly more with twice the runs. What can be missed is narrower than a cell of the coarsest map
and does not reach a known border.

The share that a label has is counted by cells, each whole by the label of its centre. It errs only in cells that a border
crosses. Along a straight stretch of the border, k cells long between two steps of the staircase that the cells make of it, all
errors are of one kind: the border lies anywhere within half a cell of the cells' edge, so that what is off is uniform within +-
k/2 cells, of variance k^2/12. Stretches err independently of each other. ``uncertainty`` is twice the standard deviation of
their sum. A border along an axis is one long stretch, a slanted one many short ones: of a smooth border the uncertainty falls
as h^(3/2) with the size h of the cells, of one along an axis as h. ``error_bound`` is what no border that the map resolves can
exceed: half the area of all cells at a border. Neither covers what is narrower than a cell.
"""

from __future__ import annotations

import math

import numpy as np

Periodic = tuple[bool, bool]  # of the rows' axis, of the columns'
_NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]


def border_cells(labels: np.ndarray, periodic: Periodic) -> np.ndarray:
    """Mask of the cells (m, n) that have a neighbour with another label."""
    padded_map = _pad_map(labels, periodic)
    return np.asarray(np.logical_or.reduce([_shift_map(padded_map, i, j) != labels for i, j in _NEIGHBOURS]))


def widen_cells(cells: np.ndarray, periodic: Periodic) -> np.ndarray:
    """Widen a mask of cells (m, n) by all their neighbours."""
    padded_map = _pad_map(cells, periodic)
    return np.asarray(np.logical_or.reduce([cells, *(_shift_map(padded_map, i, j) for i, j in _NEIGHBOURS)]))


def halve_cells(map_: np.ndarray) -> np.ndarray:
    """Divide each cell of a map (m, n) into four (2 m, 2 n) that have its value."""
    return np.repeat(np.repeat(map_, 2, axis=0), 2, axis=1)


def cells_to_halve(labels: np.ndarray, periodic: Periodic, coarsest: bool) -> np.ndarray:
    """Mask of the cells (m, n) at a border; of the coarsest map with a rim of one cell about them."""
    border = border_cells(labels, periodic)
    return widen_cells(border, periodic) if coarsest else border


def border_cells_not_run(labels: np.ndarray, run: np.ndarray, periodic: Periodic) -> np.ndarray:
    """Mask of the cells (m, n) that lie at a border though they were not run themselves."""
    return np.asarray(border_cells(labels, periodic) & ~run)


def _pad_map(map_: np.ndarray, periodic: Periodic) -> np.ndarray:
    """Pad the map by a cell on each side: its periodic continuation, or a copy of the cell at the edge."""
    for axis, wraps in enumerate(periodic):
        width = [(1, 1) if k == axis else (0, 0) for k in range(2)]
        map_ = np.pad(map_, width, mode="wrap" if wraps else "edge")
    return map_


def _shift_map(padded_map: np.ndarray, i: int, j: int) -> np.ndarray:
    m, n = padded_map.shape[0] - 2, padded_map.shape[1] - 2
    return padded_map[1 + i : 1 + i + m, 1 + j : 1 + j + n]


def share(inside: np.ndarray) -> float:
    """The share of a label, by the mask (m, n) of the cells that have it."""
    return float(inside.mean())


def uncertainty(inside: np.ndarray, periodic: Periodic) -> float:
    """The uncertainty of that share: in 19 of 20 cases it is off by no more."""
    stretches = _squared_lengths(inside, periodic) + _squared_lengths(inside.T, periodic[::-1])
    return 2 * math.sqrt(stretches / 12) / inside.size


def random_error(inside: np.ndarray) -> float:
    """The uncertainty of a share of starts that are drawn at random, likewise."""
    return 2 * math.sqrt(share(inside) * (1 - share(inside)) / inside.size)


def error_bound(inside: np.ndarray, periodic: Periodic) -> float:
    """The bound of its error: half the area of the cells at the label's border."""
    return 0.5 * float(border_cells(inside, periodic).mean())


def _squared_lengths(inside: np.ndarray, periodic: tuple[bool, ...]) -> int:
    """The sum of the squared lengths, in cells, of the stretches of a border that lie between rows of cells (m, n)."""
    rows = np.vstack([inside, inside[:1]]) if periodic[0] else inside
    steps = np.diff(rows.astype(np.int8), axis=0)
    flat = np.pad(steps, ((0, 0), (1, 1))).ravel()
    changes = np.flatnonzero(np.diff(flat))
    begins, ends = changes[flat[changes + 1] != 0], changes[flat[changes] != 0]
    total = int(((ends - begins) ** 2).sum())
    if not periodic[1]:
        return total
    # A stretch that goes over the seam was counted as two.
    first = np.argmax(steps != steps[:, :1], axis=1)
    last = np.argmax(steps[:, ::-1] != steps[:, -1:], axis=1)
    crosses_seam = (steps[:, 0] != 0) & (steps[:, 0] == steps[:, -1])
    return total + int(2 * (first * last)[crosses_seam].sum())
