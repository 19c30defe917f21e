"""The share of a map that a label has, counted by cells, and how far that is from the share of the plane.

Counted is each cell whole by the label of its centre. It errs only in cells that a border crosses. Along a straight stretch of
the border, k cells long between two steps of the staircase that the cells make of it, all errors are of one kind: the border
lies anywhere within half a cell of the cells' edge, so that what is off is uniform within +- k/2 cells, of variance k^2/12.
Stretches err independently of each other. ``uncertainty`` is twice the standard deviation of their sum. A border along an axis
is one long stretch, a slanted one many short ones: of a smooth border the uncertainty falls as h^(3/2) with the size h of the
cells, of one along an axis as h. ``bound`` is what no border that the map resolves can exceed: half the area of all cells at a
border. Neither knows of what is narrower than a cell.
"""

from __future__ import annotations

import math

import numpy as np

from wucht.dynamics.sampling.refinement import Periodic, at_border


def share(inside: np.ndarray) -> float:
    """Of a label, by the cells (m, n) that have it."""
    return float(inside.mean())


def uncertainty(inside: np.ndarray, periodic: Periodic) -> float:
    """Of that share: in 19 of 20 cases it is off by no more."""
    stretches = _squared_lengths(inside, periodic) + _squared_lengths(inside.T, periodic[::-1])
    return 2 * math.sqrt(stretches / 12) / inside.size


def bound(inside: np.ndarray, periodic: Periodic) -> float:
    """Of its error: half the area of the cells at the label's border."""
    return 0.5 * float(at_border(inside, periodic).mean())


def _squared_lengths(inside: np.ndarray, periodic: tuple[bool, ...]) -> int:
    """The sum of the squared lengths, in cells, of the stretches of a border that lie between rows of cells (m, n)."""
    rows = np.vstack([inside, inside[:1]]) if periodic[0] else inside
    steps = np.diff(rows.astype(np.int8), axis=0)
    flat = np.pad(steps, ((0, 0), (1, 1))).ravel()
    changed = np.flatnonzero(np.diff(flat))
    begins, ends = changed[flat[changed + 1] != 0], changed[flat[changed] != 0]
    total = int(((ends - begins) ** 2).sum())
    if not periodic[1]:
        return total
    # A stretch that goes over the seam was counted as two.
    first = np.argmax(steps != steps[:, :1], axis=1)
    last = np.argmax(steps[:, ::-1] != steps[:, -1:], axis=1)
    over = (steps[:, 0] != 0) & (steps[:, 0] == steps[:, -1])
    return total + int(2 * (first * last)[over].sum())
