"""A record of any length in bounded memory: the last blocks as they are, and ever longer ones the further back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

KEPT = 4096  # blocks of each length
LAST, LOW, HIGH, MEAN = range(4)  # what of two neighbouring blocks is that of both


@dataclass(frozen=True)
class Pyramid:
    """kinds: of each row of a block. count: of blocks so far. levels: the last ``KEPT`` blocks of 1, 2, 4, ... as one, each a
    column; the last level reaches back to the beginning. Two records of the same blocks are the same to the last bit, whatever
    the parts in which they came."""

    kinds: tuple[int, ...]
    count: int = 0
    levels: tuple[np.ndarray, ...] = ()

    def after(self, blocks: np.ndarray) -> Pyramid:
        """The record with more blocks (rows, K)."""
        if not blocks.shape[1]:
            return self
        return Pyramid(self.kinds, self.count + blocks.shape[1], _levels(self.levels, blocks, self.count, self.kinds))

    def last(self, share: float) -> tuple[np.ndarray, int]:
        """The last share of it in the finest blocks that reach back so far; and of how many a block is made."""
        if not self.levels:
            return np.empty((len(self.kinds), 0)), 1
        wanted, top = share * self.count, len(self.levels) - 1
        k = next((k for k, known in enumerate(self.levels) if known.shape[1] * 2**k >= wanted), top)
        return self.levels[k][:, -max(1, round(wanted / 2**k)) :], 2**k


def _levels(before: tuple[np.ndarray, ...], blocks: np.ndarray, count: int, kinds: Sequence[int]) -> tuple[np.ndarray, ...]:
    """The levels with more blocks of the first one, of which there had been ``count``."""
    known = np.concatenate([before[0], blocks], axis=1) if before else blocks
    total = count + blocks.shape[1]
    if total <= KEPT:
        return (known,)
    # Of the next level there is nothing yet as long as this one has all of them.
    paired = count // 2 if len(before) > 1 else 0
    new = known[:, 2 * paired - total + known.shape[1] : known.shape[1] - total % 2]
    return known[:, -KEPT:], *_levels(before[1:], _paired(new, kinds), paired, kinds)


def _paired(blocks: np.ndarray, kinds: Sequence[int]) -> np.ndarray:
    """Each two neighbouring blocks as one."""
    first, second, merged = blocks[:, ::2], blocks[:, 1::2], blocks[:, 1::2].copy()
    for kind, merge in ((LOW, np.minimum), (HIGH, np.maximum), (MEAN, _mean)):
        rows = [row for row, k in enumerate(kinds) if k == kind]
        merged[rows] = merge(first[rows], second[rows])
    return merged


def _mean(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.asarray((first + second) / 2)
