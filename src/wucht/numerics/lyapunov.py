"""The largest Lyapunov exponent of a motion: the mean rate at which nearby motions separate, with its 95 % interval.

A change v of the motion obeys the variational equations v' = A(t) v. Here it is scaled to its length at every instant, so that
it neither overflows nor decays: v' = A v - s v with s = (v . A v) / |v|^2, whose mean over time is the exponent. G. Benettin,
L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9-20, rescale at intervals instead.

The exponent is the mean over a finite time. Means over equal blocks of it, each long in comparison with the motion's memory,
scatter as independent numbers do: Student's interval of their mean is that of the exponent (batch means: A. M. Law, "Simulation
Modeling and Analysis", McGraw-Hill 2015, section 9.5.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import RunError, WuchtError
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.jacobian import variational_system
from wucht.numerics.flow.program import Numbers
from wucht.piecewise import PiecewiseCubic
from wucht.system import Output, System

CONFIDENCE = 0.95
BLOCKS = 20  # into which a record is split
_SAMPLES_A_BLOCK = 1000
_ORDERS, _SAME_RATE = 99, 0.01  # of the blocks at random; of the largest rate
_GROWTH = "growth"  # the logarithm of the growth of a change since the beginning
_ALIGNMENT = 0.1  # of the duration: a change turns into the direction that grows fastest before its growth counts


@dataclass(frozen=True)
class LyapunovExponent:
    """The largest Lyapunov exponent.

    Attributes
    ----------
    value : float
        Per unit of the System's time.
    low, high : float
        Its 95 % interval.
    duration : float
        The time over which it is the mean.
    swing : float
        By how much the growth (e-folds) varies, of its means over blocks of that time: bounded however long that is where
        changes do not grow exponentially; nan where it is not known.
    is_steady : bool
        False where the rate of growth changes during that time beyond its scatter, as of a chaotic motion that ends at rest.
    """

    value: float
    low: float
    high: float
    duration: float
    swing: float = math.nan
    is_steady: bool = True


def largest_lyapunov_exponent(
    system: System,
    parameters: Numbers,
    state: np.ndarray,
    duration: float,
    *,
    time: float = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
    engine: str | None = None,
) -> tuple[LyapunovExponent, np.ndarray, np.ndarray]:
    """Compute the largest Lyapunov exponent of the motion from a state.

    Parameters
    ----------
    system : System
        With n states; its outputs and quadratures are left out.
    parameters : sequence of float
        In the System's order.
    state : ndarray, (n,)
        On the motion after its transients.
    duration : float
        The time over which the exponent is a mean, beside a tenth of it before, in which the change aligns.
    time : float
        At which the state holds.
    tolerance : float
        Of the integration.
    engine : str, optional
        As in ``compile_system``.

    Returns
    -------
    exponent : LyapunovExponent
    times : ndarray, (K,)
        Evenly spaced, over that duration.
    states : ndarray, (n, K)
        The motion at these times.

    Raises
    ------
    RunError
        Where the integration fails.
    WuchtError
        Where the equations jump: the variational equations do not hold across a jump.

    Examples
    --------
    A linear focus: all changes decay at the rate of the real part of its eigenvalues.

    >>> import numpy as np
    >>> import sympy as sp
    >>> from wucht.numerics.lyapunov import largest_lyapunov_exponent
    >>> from wucht.system import System
    >>> x, y = sp.symbols("x y", real=True)
    >>> focus = System((x, y), (-x / 4 + y, -x - y / 4))
    >>> exponent, _, _ = largest_lyapunov_exponent(focus, (), np.array([1.0, 0.0]), 50.0)
    >>> round(exponent.value, 6)
    -0.25
    """
    if equations_jump(system):
        raise WuchtError("the equations jump: across a jump changes of a motion are not described by them", code="jump")
    compiled_system, n = compile_system(_growth_system(system), tolerance, (), engine), len(system.states)
    start = np.concatenate([np.asarray(state, float), np.full(n, n**-0.5)])
    begin = time + _ALIGNMENT * duration
    alignment = integrate(compiled_system, start, parameters, np.array([time, begin])).reraise_interrupt()
    if alignment.failure is not None:
        raise RunError(alignment.failure)
    grid = np.linspace(begin, begin + duration, BLOCKS * _SAMPLES_A_BLOCK + 1)
    run = integrate(compiled_system, alignment.states[:, -1], parameters, grid, unit=1.0).reraise_interrupt()
    if run.failure is not None:
        raise RunError(run.failure)
    growth = run.quadratures[_GROWTH]
    rates = np.diff(growth[::_SAMPLES_A_BLOCK]) / (duration / BLOCKS)
    exponent = replace(exponent_from_blocks(rates, duration), is_steady=_is_steady(rates))
    swing = float(np.ptp(growth[1:].reshape(BLOCKS, _SAMPLES_A_BLOCK).mean(axis=1)))
    return replace(exponent, swing=swing), run.time, run.states[:n]


def exponent_from_blocks(rates: np.ndarray, duration: float) -> LyapunovExponent:
    """Return the exponent and its interval from the mean growth rates (B,) over equal blocks of a duration."""
    from scipy.special import stdtrit

    mean, scatter = float(rates.mean()), float(rates.std(ddof=1)) / len(rates) ** 0.5
    half = float(stdtrit(len(rates) - 1, (1 + CONFIDENCE) / 2)) * scatter
    return LyapunovExponent(mean, mean - half, mean + half, duration)


def _is_steady(rates: np.ndarray) -> bool:
    """True if rates (B,) of successive blocks do not change beyond their scatter.

    The cumulative sum of their deviations from the mean comes as far as in another order, at the level of one in a hundred
    (W. A. Taylor, "Change-Point Analysis", 2000). Differences of less than a hundredth are none.
    """
    deviations, random = rates - rates.mean(), np.random.default_rng(0)
    if (np.abs(deviations) <= _SAME_RATE * np.abs(rates).max()).all():
        return True
    farthest = np.abs(np.cumsum(deviations)).max()
    return any(np.abs(np.cumsum(random.permutation(deviations))).max() >= farthest for _ in range(_ORDERS))


def equations_jump(system: System) -> bool:
    """True if a piecewise function in the equations of motion jumps."""
    every = (*system.derivatives, *(e for _, e in system.definitions))
    return any(p.args[1].jumps() for e in every for p in sp.sympify(e).atoms(PiecewiseCubic))


@lru_cache(maxsize=16)
def _growth_system(system: System) -> System:
    """Return the System with a change of constant length as further states, and its growth as a quadrature."""
    bare = System(system.states, system.derivatives, system.parameters, system.definitions, angles=system.angles)
    variational, n = variational_system(bare), len(system.states)
    change, rates = variational.states[n:], variational.derivatives[n:]
    names = {s.name for s in (*variational.states, *variational.parameters, *(s for s, _ in variational.definitions))}
    rate_symbols = tuple(_fresh_symbol(f"rate[{s.name}]", names) for s in change)
    stretch = _fresh_symbol("stretch", names)
    ratio = sp.Add(*(v * r for v, r in zip(change, rate_symbols, strict=True))) / sp.Add(*(v**2 for v in change))
    definitions = (*variational.definitions, *zip(rate_symbols, rates, strict=True), (stretch, ratio))
    scaled_rates = tuple(r - stretch * v for v, r in zip(change, rate_symbols, strict=True))
    return replace(
        variational,
        derivatives=(*variational.derivatives[:n], *scaled_rates),
        definitions=definitions,
        quadratures=(Output(_GROWTH, stretch),),
    )


def _fresh_symbol(name: str, names: set[str]) -> sp.Symbol:
    """Return a symbol whose name is none of the given ones."""
    while name in names:
        name = f"_{name}"
    return sp.Symbol(name, real=True)
