"""A periodic orbit to the integrator's accuracy, breakpoints of piecewise functions included, with the exact linearisation.

Newton's method on the motions from place to place, multiple shooting: alone from nearby, else after
collocation.
U. M. Ascher, R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential
Equations", SIAM 1995, section 4.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.periodic.closing import Closed, Closing
from wucht.numerics.periodic.families import Places
from wucht.numerics.variational import variational

_CONDITION = 1e4  # of the maps of legs, so that multipliers have four digits less than the integration
_MOST_ROUNDS, _MOST_PARTS = 6, 16
_LEAST = 2.0**-5  # share of a step


@dataclass(frozen=True, eq=False)
class ExactOrbit:
    """An orbit.

    states (n, G): at its places. times (G + 1,): of these in periods, from 0 to 1. at: its linearisation. flow (n, G): dx/dt
    there. gap (n,): by which it misses its beginning in directions that are left open. residual: the most that is missed
    elsewhere, by the states' sizes.
    """

    states: np.ndarray
    times: np.ndarray
    period: float
    at: Places
    flow: np.ndarray
    gap: np.ndarray
    residual: float


def exact(
    compiled: CompiledSystem,
    parameters: np.ndarray,
    time: float,
    near: Closed,
    closing: Closing,
    tolerance: float,
    most_steps: int,
) -> ExactOrbit:
    """The orbit near one by collocation.

    Parameters
    ----------
    compiled : CompiledSystem
        Without outputs and quadratures.
    parameters : ndarray
        In the System's order.
    time : float
        At its beginning.
    near : Closed
    closing : Closing
    tolerance : float
        Of what is missed, by the states' sizes, before the last correction.
    most_steps : int

    Raises
    ------
    RunError
        Where an integration fails. An orbit whose residual is too large is returned.
    """
    n = len(closing.sizes)
    linear = compile_system(variational(compiled.system, n), compiled.tolerance, (), compiled.engine_name)
    rates, held = Evaluator.of_rates(compiled.system), list(closing.held)
    x, period, before, count, share = near.states[:n, :-1].copy(), near.period, math.inf, -1, 1.0
    for step in range(1, most_steps + 1):
        grid = time + period * near.times
        ends, maps = _carried(linear, parameters, grid, x)
        flow = rates.array(np.append(grid[:-1], grid[1:]), np.concatenate([x, ends], axis=1), parameters)
        here, there = np.split(flow, 2, axis=1)
        late = (there * np.diff(near.times)).T * closing.period / closing.sizes
        at = Places(maps * closing.sizes / closing.sizes[:, None], late)
        missed = ends - np.roll(x, -1, axis=1)
        missed[:, -1] -= closing.advance
        borders = closing.borders(at)
        scaled = missed.T / closing.sizes
        by, longer, s = at.correction(scaled, borders)
        scaled[-1] -= borders.open @ (borders.open.T @ scaled[-1])
        size, gap, new = float(np.abs(scaled).max()), closing.sizes * (borders.open @ s), len(s) != count
        # What is singular from far away need not be so nearer by.
        done = size <= tolerance and (closing.missed(gap) <= tolerance or not new)
        if step == most_steps and not done:
            break
        if done or new or size < before:
            last, change, before, count, share = (x, period), (by, longer), size, len(s), 1.0
        elif share > _LEAST:
            share /= 2
        else:
            break
        x = last[0] + share * change[0].T * closing.sizes[:, None]
        x[held, 0] = closing.reference[held]  # but for rounding it is that
        period = last[1] + share * change[1] * closing.period
        if done:
            break
        if not (period > 0 and np.isfinite(x).all()):
            raise RunError("its period becomes negative")
    return ExactOrbit(x, near.times, period, at, here, gap, size)


def finer(
    compiled: CompiledSystem, parameters: np.ndarray, time: float, orbit: ExactOrbit, closing: Closing
) -> tuple[np.ndarray, np.ndarray]:
    """The orbit's maps (G', n, n) and flow (G', n), in units of the states' sizes, between so many places that all are exact.

    The multipliers of what decays much faster than something else are lost in maps of longer legs. Arguments as of ``exact``.
    Raises ``RunError`` where an integration fails.
    """
    n, sizes = len(closing.sizes), closing.sizes
    linear = compile_system(variational(compiled.system, n), compiled.tolerance, (), compiled.engine_name)
    maps, shares, x = orbit.at.maps, orbit.times, orbit.states
    for _ in range(_MOST_ROUNDS):
        parts = np.ceil(np.log(np.linalg.cond(maps)) / math.log(_CONDITION)).clip(1, _MOST_PARTS).astype(int)
        if parts.max() == 1:
            break
        legs = []
        for j in range(len(parts)):
            inside = np.linspace(shares[j], shares[j + 1], parts[j] + 1)
            if parts[j] == 1:
                legs.append((inside[:-1], x[:, j : j + 1]))
                continue
            run = integrate(compiled, x[:, j], parameters, time + orbit.period * inside).uninterrupted()
            if run.failure is not None:
                raise RunError(run.failure)
            legs.append((inside[:-1], run.states[:, :-1]))
        shares, x = np.append(np.concatenate([a for a, _ in legs]), 1.0), np.concatenate([b for _, b in legs], axis=1)
        maps = _carried(linear, parameters, time + orbit.period * shares, x)[1] * sizes / sizes[:, None]
    flow = Evaluator.of_rates(compiled.system).array(time + orbit.period * shares[:-1], x, parameters)
    return maps, flow.T / sizes


def _carried(
    linear: CompiledSystem, parameters: np.ndarray, grid: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The states (n, G) at the end of each leg that begins at states (n, G), and what small changes become (G, n, n)."""
    n, legs = states.shape
    ends, maps = np.empty_like(states), np.empty((legs, n, n))
    for j, state in enumerate(states.T):
        size = float(np.abs(state).max()) or 1.0  # the engines' errors are relative to the largest state
        start = np.concatenate([state, (size * np.eye(n)).ravel()])
        run = integrate(linear, start, parameters, grid[j : j + 2]).uninterrupted()
        if run.failure is not None:
            raise RunError(run.failure)
        ends[:, j], maps[j] = run.states[:n, -1], run.states[n:, -1].reshape(n, n).T / size
    return ends, maps
