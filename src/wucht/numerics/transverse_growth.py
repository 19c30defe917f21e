"""Growth of the difference between two like parts of a motion that move together.

Parts that are alike may move as one: such motions fill an invariant manifold, on which a computation stays even where a real
system does not. Across it a small difference obeys linear equations of its own, with as many states as a part has, whatever
the rest does: L. M. Pecora, T. L. Carroll, Phys. Rev. Lett. 80 (1998) 2109-2112; P. Ashwin, J. Buescu, I. Stewart,
Nonlinearity 9 (1996) 703-737. Here two motions that are displaced to opposite sides stand for these equations: the rest of the
motion, even in them, changes only by the square of the displacement. So they need no further equations to be compiled, and
hold across events and where the parts are nearly alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate

_DISPLACEMENT = 1e-6  # of the sizes: its square is rounding
_LARGEST = 1e-2  # of the sizes: larger differences do not grow in proportion any more
_ODD = 0.2  # of the difference: a rest that changes by more is not even in it, and the parts are not alike
_PLACES = 16  # of the motion, at which its sizes are taken
_AT_REST = 1e-12  # a state that never exceeds it has no size


@dataclass(frozen=True)
class TransverseGrowth:
    """Growth of a difference.

    Attributes
    ----------
    logarithm : float
        Of its largest multiplier over the duration.
    duration : float
    """

    logarithm: float
    duration: float

    @property
    def rate(self) -> float:
        """The mean rate of growth, per unit of the System's time."""
        return self.logarithm / self.duration


def transverse_growth(
    compiled_system: CompiledSystem,
    parameter_values: np.ndarray,
    state: np.ndarray,
    span: tuple[float, float],
    parts: tuple[np.ndarray, np.ndarray],
) -> TransverseGrowth | None:
    """Compute the growth of the difference between two parts of a system that move together.

    Parameters
    ----------
    compiled_system : CompiledSystem
        With n states and m quadratures.
    parameter_values : ndarray, (p,)
        In the System's order.
    state : ndarray, (n + m,)
        At the beginning.
    span : (float, float)
        The begin and the end of the time; of a motion that repeats, a whole number of its periods.
    parts : (ndarray of int, ndarray of int), (k,) each
        The places of the states of each part, in the same order.

    Returns
    -------
    TransverseGrowth or None
        None where the rest of the motion changes with the difference, so that the parts are not alike; and where an
        integration ends early.
    """
    begin, end = span
    changes = _changes(compiled_system, parameter_values, state, np.linspace(begin, end, _PLACES), parts)
    if changes is None:
        return None
    if np.abs(changes).max() > _LARGEST:
        return transverse_growth(compiled_system, parameter_values, state, (begin, (begin + end) / 2), parts)
    first, second = (changes[rows] for rows in parts)
    multiplier = float(np.abs(np.linalg.eigvals((first - second) / (2 * _DISPLACEMENT))).max())
    even = np.vstack([np.delete(changes, np.concatenate(parts), axis=0), (first + second) / 2])
    if multiplier > 1 and np.abs(even).max() > _ODD * np.abs(first - second).max():
        return None
    return TransverseGrowth(math.log(max(multiplier, _AT_REST)), end - begin)


def _changes(
    compiled_system: CompiledSystem,
    parameter_values: np.ndarray,
    state: np.ndarray,
    times: np.ndarray,
    parts: tuple[np.ndarray, np.ndarray],
) -> np.ndarray | None:
    """Return the changes (n, k) at the last of some times by displacements of each of the k states of the parts, in shares of
    the states' sizes, which are 1 for angles; None where a motion ends early."""
    motion = integrate(compiled_system, state, parameter_values, times).reraise_interrupt()
    if motion.has_ended:
        return None
    is_angle = np.array([s in compiled_system.system.angles for s in compiled_system.system.states])
    sizes = np.where(is_angle, 1.0, np.maximum(np.abs(motion.states).max(axis=1), _AT_REST))
    changes = []
    for i, j in zip(*parts, strict=True):
        start = np.array(state, float)
        start[i] += _DISPLACEMENT * sizes[i]
        start[j] -= _DISPLACEMENT * sizes[i]
        neighbour = integrate(compiled_system, start, parameter_values, times).reraise_interrupt()
        if neighbour.has_ended:
            return None
        changes.append((neighbour.states[:, -1] - motion.states[:, -1]) / sizes)
    return np.array(changes).T
