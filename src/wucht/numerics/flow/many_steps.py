"""Why so many steps: what is stiff asks for steps far shorter than its motion, what is only long asks for many of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

_STIFF = 20.0  # times as fast as the motion: what decays so fast keeps the steps short, though nothing of it is left
_DIFFERENCE = 1e-6  # of a state, or of 1
STIFF = (
    "The machine is stiff (something in it decays {times:.2g} times as fast as anything moves): try engine = 'scipy-radau', or "
    "look for a parameter that is off by a factor of thousands"
)
LONG = (
    "The machine is not stiff, the time between samples is long (a step is {radians:.2g} rad of the fastest motion): ask for "
    "more samples, or for a shorter run"
)
UNKNOWN = (
    "If a turn or a vibration takes much longer than such a step, the machine is stiff: try engine = 'scipy-radau', or look "
    "for a parameter that is off by a factor of thousands; else the run is long: ask for a shorter one"
)


def advice(rates: Callable[[np.ndarray], Sequence[float]], state: np.ndarray, angles: Sequence[int], step: float) -> str:
    """What to try where steps of a size ran out in a state (n,). rates: of the states. angles: which of them are angles.

    By the eigenvalues of the Jacobian there, and by how fast the angles change.
    """
    n = len(state)
    apart = _DIFFERENCE * np.maximum(np.abs(state), 1.0)
    pairs = [(rates(state + h * one), rates(state - h * one)) for h, one in zip(apart, np.eye(n), strict=True)]
    jacobian = np.array([(np.array(up) - down) / (2 * h) for (up, down), h in zip(pairs, apart, strict=True)]).T
    if not np.isfinite(jacobian).all():
        return UNKNOWN
    eigenvalues, turning = np.linalg.eigvals(jacobian), np.abs(np.array(rates(state))[list(angles)])
    decay = float((-eigenvalues.real).max(initial=0.0))
    motion = max(float(np.abs(eigenvalues.imag).max(initial=0.0)), float(turning.max(initial=0.0)), 1e-300)
    return STIFF.format(times=decay / motion) if decay > _STIFF * motion else LONG.format(radians=step * motion)
