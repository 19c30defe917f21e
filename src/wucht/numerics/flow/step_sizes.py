"""The limit of steps, and advice where they ran out.

A stiff machine needs steps far shorter than its motion; a long run only needs many of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from wucht.numerics.flow.events import LegError

MAX_STEPS = 500_000  # a leg: a hundred times what a leg of an ordinary machine takes

_STIFF = 20.0  # times as fast as the motion: so fast a decay keeps the steps short even after it has vanished
_SHORTEST_OF_MOTION = 1e-3  # rad of the fastest motion: a shorter step has another reason
_DIFFERENCE = 1e-6  # of a state, or of 1
STIFF = (
    "The machine is stiff (something in it decays {times:.2g} times as fast as anything moves): try engine = 'radau', which "
    "studies of single runs such as run-up have, or look for a parameter that is off by a factor of thousands"
)
STIFF_AT_REST = (
    "The equations are stiff (something in them decays within {time:.2g}, and nothing turns or vibrates): try "
    "engine = 'radau', which studies of single runs such as run-up have, or look for a parameter that is off by a factor of "
    "thousands"
)
LONG = (
    "The machine is not stiff, but the time between samples is long (a step is {radians:.2g} rad of the fastest motion): ask "
    "for more samples, or for a shorter run"
)
UNKNOWN = (
    "If a turn or a vibration takes much longer than such a step, the machine is stiff: try engine = 'radau', which "
    "studies of single runs such as run-up have, or look for a parameter that is off by a factor of thousands; otherwise the "
    "run is long: ask for a shorter one"
)


def step_limit_error(samples: np.ndarray, begin: float, time: float) -> LegError:
    """Return the error of a leg that exhausted its steps between two times."""
    step = (time - begin) / MAX_STEPS
    return LegError(f"{MAX_STEPS} steps were not enough for one leg (of {step:.2g} on average)", UNKNOWN, samples, step)


def advice(rates: Callable[[np.ndarray], Sequence[float]], state: np.ndarray, angles: Sequence[int], step: float) -> str:
    """Return advice where steps of a size ran out in a state (n,). rates: of the states. angles: which of them are angles.

    It is based on the eigenvalues of the Jacobian there, and on the rates of the angles.
    """
    n = len(state)
    apart = _DIFFERENCE * np.maximum(np.abs(state), 1.0)
    pairs = [(rates(state + h * one), rates(state - h * one)) for h, one in zip(apart, np.eye(n), strict=True)]
    jacobian = np.array([(np.array(up) - down) / (2 * h) for (up, down), h in zip(pairs, apart, strict=True)]).T
    if not np.isfinite(jacobian).all():
        return UNKNOWN
    eigenvalues, turning = np.linalg.eigvals(jacobian), np.abs(np.array(rates(state))[list(angles)])
    decay = float((-eigenvalues.real).max(initial=0.0))
    motion = max(float(np.abs(eigenvalues.imag).max(initial=0.0)), float(turning.max(initial=0.0)))
    if decay > _STIFF * motion:
        return STIFF.format(times=decay / motion) if motion > 0 else STIFF_AT_REST.format(time=1 / decay)
    return LONG.format(radians=step * motion) if step * motion > _SHORTEST_OF_MOTION else UNKNOWN
