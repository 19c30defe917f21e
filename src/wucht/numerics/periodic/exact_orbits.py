"""Periodic orbit to the integrator's accuracy, including breakpoints of piecewise functions, with the exact linearisation.

Multiple shooting: Newton's method on the motions from place to place, alone from a near guess, else after
collocation.
U. M. Ascher, R. M. M. Mattheij, R. D. Russell, "Numerical Solution of Boundary Value Problems for Ordinary Differential
Equations", SIAM 1995, section 4.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.jacobian import variational_system
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.periodic.closing import ClosedOrbit, Closing, Places
from wucht.numerics.periodic.floquet import halve_legs, integrated_legs

_LEAST = 2.0**-5  # share of a step


@dataclass(frozen=True, eq=False)
class ExactOrbit:
    """Orbit by multiple shooting.

    states (n, G): at its places. times (G + 1,): of these in periods, from 0 to 1. linearisation: between them. flow (n, G):
    dx/dt there. gap (n,): between its end and its begin in the open directions. residual: the largest gap elsewhere, by the
    states' sizes.
    """

    states: np.ndarray
    times: np.ndarray
    period: float
    linearisation: Places
    flow: np.ndarray
    gap: np.ndarray
    residual: float


def exact_orbit(
    compiled_system: CompiledSystem,
    parameter_values: np.ndarray,
    time: float,
    near: ClosedOrbit,
    closing: Closing,
    tolerance: float,
    most_steps: int,
) -> ExactOrbit:
    """Compute the orbit near one by collocation.

    Parameters
    ----------
    compiled_system : CompiledSystem
        Without outputs and quadratures.
    parameter_values : ndarray
        In the System's order.
    time : float
        At its beginning.
    near : ClosedOrbit
    closing : Closing
    tolerance : float
        Of the gaps, by the states' sizes, before the last correction.
    most_steps : int

    Raises
    ------
    RunError
        Where an integration fails. An orbit whose residual is too large is returned.
    """
    n = len(closing.sizes)
    linear = compile_system(
        variational_system(compiled_system.system, n), compiled_system.tolerance, (), compiled_system.engine_name
    )
    rates, held_rows = Evaluator.of_rates(compiled_system.system), list(closing.held_states)
    x, period, before, count, share = near.states[:n, :-1].copy(), near.period, math.inf, -1, 1.0
    for step in range(1, most_steps + 1):
        grid = time + period * near.times
        ends, maps = integrated_legs(linear, parameter_values, grid[:-1], grid[1:], x)
        flow = rates.array(np.append(grid[:-1], grid[1:]), np.concatenate([x, ends], axis=1), parameter_values)
        here, there = np.split(flow, 2, axis=1)
        late = (there * np.diff(near.times)).T * closing.period / closing.sizes
        linearisation = Places(maps * closing.sizes / closing.sizes[:, None], late)
        gaps = ends - np.roll(x, -1, axis=1)
        gaps[:, -1] -= closing.advance
        borders = closing.borders(linearisation)
        scaled_gaps = gaps.T / closing.sizes
        by, longer, s = linearisation.correction(scaled_gaps, borders)
        scaled_gaps[-1] -= borders.open @ (borders.open.T @ scaled_gaps[-1])
        size, gap, new = float(np.abs(scaled_gaps).max()), closing.sizes * (borders.open @ s), len(s) != count
        # A direction that is singular far from the orbit need not be so near it.
        done = size <= tolerance and (closing.gap_size(gap) <= tolerance or not new)
        if step == most_steps and not done:
            break
        if done or new or size < before:
            last, change, before, count, share = (x, period), (by, longer), size, len(s), 1.0
        elif share > _LEAST:
            share /= 2
        else:
            break
        x = last[0] + share * change[0].T * closing.sizes[:, None]
        x[held_rows, 0] = closing.reference[held_rows]  # equal already except for rounding
        period = last[1] + share * change[1] * closing.period
        if done:
            break
        if not (period > 0 and np.isfinite(x).all()):
            raise RunError("its period becomes negative")
    return ExactOrbit(x, near.times, period, linearisation, here, gap, size)


def finer_linearisation(
    compiled_system: CompiledSystem, parameter_values: np.ndarray, time: float, orbit: ExactOrbit, sizes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the orbit's maps (G', n, n) and flow (G', n), in units of the states' sizes (n,), at places close enough.

    Arguments as of ``exact_orbit``. Raises ``RunError`` where an integration fails.
    """
    linear = compile_system(
        variational_system(compiled_system.system, len(sizes)), compiled_system.tolerance, (), compiled_system.engine_name
    )
    times = time + orbit.period * orbit.times
    times, x, maps = halve_legs(linear, parameter_values, times, orbit.states, orbit.linearisation.maps, sizes)
    return maps, Evaluator.of_rates(compiled_system.system).array(times[:-1], x, parameter_values).T / sizes
