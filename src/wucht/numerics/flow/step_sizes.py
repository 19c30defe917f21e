"""Step sizes: narrow transitions that limit the steps of Taylor's method, and advice where too many steps were needed.

A Taylor step knows the motion ahead only by the coefficients at its beginning. Those of tanh(u) decay with
exp(-2 abs(u)): many widths away from u = 0 it is flat to the last bit, and a step may pass the whole transition without a
trace. The logarithm of 1 + u^2 is steep nowhere, but singular at u = +-i, and its coefficients of order p decay with
abs(u -+ i)^-p alone. heyoka's steps are accurate for the states and for all event functions, relative to
the largest of them. So for each tanh an event function without zeros is added: it limits a step to a part of the distance
from the transition.

A stiff machine needs steps far shorter than its motion; a long run only needs many of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp

from wucht.numerics.flow.events import LegError
from wucht.numerics.flow.program import Program

MAX_STEPS = 500_000  # a leg: a hundred times what a leg of an ordinary machine takes

# The function stays below the states' size up to abs(u) of 1e6, so that it does not lower their accuracy; at any tolerance in
# use it is large enough to have an effect.
_WEIGHT = 1 / 32
_STIFF = 20.0  # times as fast as the motion: so fast a decay keeps the steps short even after it has vanished
_DIFFERENCE = 1e-6  # of a state, or of 1
STIFF = (
    "The machine is stiff (something in it decays {times:.2g} times as fast as anything moves): try engine = 'scipy-radau', or "
    "look for a parameter that is off by a factor of thousands"
)
LONG = (
    "The machine is not stiff, but the time between samples is long (a step is {radians:.2g} rad of the fastest motion): ask "
    "for more samples, or for a shorter run"
)
UNKNOWN = (
    "If a turn or a vibration takes much longer than such a step, the machine is stiff: try engine = 'scipy-radau', or look "
    "for a parameter that is off by a factor of thousands; otherwise the run is long: ask for a shorter one"
)


def step_limit_error(samples: np.ndarray, begin: float, time: float) -> LegError:
    """Return the error of a leg that exhausted its steps between two times."""
    step = (time - begin) / MAX_STEPS
    return LegError(f"{MAX_STEPS} steps were not enough for one leg (of {step:.2g} on average)", UNKNOWN, samples, step)


def tanh_arguments(program: Program) -> tuple[sp.Expr, ...]:
    """Return the arguments of tanh in the program, in its lines' and states' symbols and constants."""
    expressions = [*(e for _, e in program.lines), *program.results]
    results = set[sp.Expr]().union(*({t.args[0] for t in e.atoms(sp.tanh)} for e in expressions))
    return tuple(sorted(results, key=sp.default_sort_key))


def sentinels(program: Program, variables: Sequence[Any], translate: Callable[[sp.Expr], Any]) -> list[Any]:
    """Return the additional event functions, as heyoka's expressions. translate: has already translated the lines."""
    import heyoka as hy

    size = hy.sqrt(1.0 + hy.sum([s * s for s in variables]))
    transition_arguments = [translate(u) for u in tanh_arguments(program)]
    return [_WEIGHT * size * (1.0 + hy.log(1.0 + u * u)) for u in transition_arguments]


def ignore_event(*_: Any) -> None:
    """Do nothing: the callback of an event function that has no zeros."""


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
    motion = max(float(np.abs(eigenvalues.imag).max(initial=0.0)), float(turning.max(initial=0.0)), 1e-300)
    return STIFF.format(times=decay / motion) if decay > _STIFF * motion else LONG.format(radians=step * motion)
