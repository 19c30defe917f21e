"""Motion laws: the motion of a follower or an output over the angle of the cam."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Law(Protocol):
    """A periodic motion over the cam angle phi, of period 2 pi.

    Any function ``law(phi, order=0)`` is one: it takes angles in rad of any shape, and returns the derivative by phi of an
    order from 0 (the motion itself, in rad or m) to 3. ``RiseAndReturn`` and a series of harmonics are laws.

    Parameters
    ----------
    phi : numpy.ndarray or float
    order : int, optional
    """

    def __call__(self, phi: np.ndarray | float, /, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 (the motion itself) to 3, at angles in rad of any shape."""
        ...
