"""Growth of the difference between two like parts of a motion that move together.

Parts that are alike may move as one: such motions fill an invariant manifold, on which a computation stays even where a real
system does not. Across it a small difference obeys linear equations of its own, with as many states as a part has, whatever
the rest does: L. M. Pecora, T. L. Carroll, Phys. Rev. Lett. 80 (1998) 2109-2112; P. Ashwin, J. Buescu, I. Stewart,
Nonlinearity 9 (1996) 703-737. Here two motions that are displaced to opposite sides stand for these equations: the rest of the
motion, even in them, changes only by the square of the displacement. So they need no further equations to be compiled, and
hold across events and where the parts are nearly alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.flow.integration import integrate
from wucht.numerics.observers.records import smooth_weights
from wucht.system import System

_DISPLACEMENT = 1e-6  # of the sizes: its square is rounding
_LARGEST = 1e-2  # of the sizes: larger differences do not grow in proportion any more
_ODD = 1.0  # of the difference: where the rest changes by more, it is no difference alone that grows: the parts are not alike
_STRONG = 1.0  # logarithm of a growth that shows in half of the time as well
_PLACES = 512  # of the motion, at which differences are compared
_DECAY, _LEAST = -3.0, -30.0  # logarithms: of a difference that has decayed for certain, and of one that is rounding
_AT_REST = 1e-12  # a state that never exceeds it has no size


@dataclass(frozen=True)
class TransverseGrowth:
    """Growth of a difference.

    Attributes
    ----------
    logarithm : float
        Of its growth over the duration, at its mean rate; of a motion that repeats itself, of the largest multiplier.
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
    *,
    repeats: bool = False,
    as_one: bool = True,
) -> TransverseGrowth | None:
    """Compute the growth of the difference between two parts of a system that move together, on the motion as one beside it.

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
    repeats : bool
        True: the motion repeats itself exactly after this time, or is at rest. Then the growth has no transients, as of the
        speed of a weakly damped part that is displaced.
    as_one : bool
        False: of changes of their difference, on the motion from the state as it is.

    Returns
    -------
    TransverseGrowth or None
        None where the rest of the motion changes with the difference, so that the parts are not alike; and where an
        integration ends early.
    """
    begin, end = span
    times = np.linspace(begin, end, _PLACES)
    first_state = _even_state(compiled_system.system, state, parts) if as_one else state
    changes = _changes(compiled_system, parameter_values, first_state, times, parts)
    if changes is None:
        return None
    shorter, (first, second) = (begin, (begin + end) / 2), (changes[:, rows] for rows in parts)
    if np.abs([first[-1], second[-1]]).max() > _LARGEST:
        return transverse_growth(compiled_system, parameter_values, state, shorter, parts, repeats=repeats, as_one=as_one)
    maps = (first - second) / (2 * _DISPLACEMENT)
    with np.errstate(divide="ignore"):
        logarithms = np.log(np.linalg.norm(maps, ord=2, axis=(1, 2)))
        multiplier = float(np.log(np.abs(np.linalg.eigvals(maps[-1])).max()))
    if logarithms[-1] < _DECAY:
        return TransverseGrowth(float(max(logarithms[-1], _LEAST)), float(end - begin))
    even = np.hstack([np.delete(changes[-1], np.concatenate(parts), axis=0).T, ((first + second) / 2)[-1].T])
    if as_one and logarithms[-1] > 0 and np.abs(even).max() > _ODD * np.abs((first - second)[-1]).max():
        if logarithms[-1] < _STRONG:
            return None
        # Parts that are nearly alike may part within the time.
        return transverse_growth(compiled_system, parameter_values, state, shorter, parts, repeats=repeats, as_one=as_one)
    mean = float(np.average(np.diff(logarithms), weights=smooth_weights(len(times) - 1))) * (len(times) - 1)
    return TransverseGrowth(multiplier if repeats else mean, float(end - begin))


def _even_state(system: System, state: np.ndarray, parts: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return a state (n + m,) in which two parts are in the middle of their states."""
    (first, second), middle = parts, np.array(state, float)
    is_angle = np.array([system.states[i] in system.angles for i in first])
    difference = state[first] - state[second]
    half = np.where(is_angle, wrap_to_pi(difference), difference) / 2
    middle[first], middle[second] = middle[first] - half, middle[second] + half
    return middle


def _changes(
    compiled_system: CompiledSystem,
    parameter_values: np.ndarray,
    state: np.ndarray,
    times: np.ndarray,
    parts: tuple[np.ndarray, np.ndarray],
) -> np.ndarray | None:
    """Return the changes (K, n, k) at times (K,) by displacements of each of the k states of the parts, in shares of the
    states' sizes, which are 1 for angles; None where a motion ends early."""
    motion = integrate(compiled_system, state, parameter_values, times).reraise_interrupt()
    if motion.has_ended:
        return None
    is_angle = np.array(compiled_system.system.is_angle)
    sizes = np.where(is_angle, 1.0, np.maximum(np.abs(motion.states).max(axis=1), _AT_REST))
    changes = []
    for i, j in zip(*parts, strict=True):
        start = np.array(state, float)
        start[i] += _DISPLACEMENT * sizes[i]
        start[j] -= _DISPLACEMENT * sizes[i]
        neighbour = integrate(compiled_system, start, parameter_values, times).reraise_interrupt()
        if neighbour.has_ended:
            return None
        changes.append((neighbour.states - motion.states).T / sizes)
    return np.stack(changes, axis=-1)
