"""Memory for vectors."""

from __future__ import annotations

import numpy as np


def vectors(count: int, width: int) -> np.ndarray:
    """Return memory for so many vectors of so many numbers, zero, aligned as the processor reads them."""
    room = np.zeros((count + 1) * width)
    first = -(room.ctypes.data // room.itemsize) % width
    return room[first : first + count * width]
