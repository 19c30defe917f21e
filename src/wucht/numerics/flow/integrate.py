"""Run a compiled System: dense samples, exact events, progress, and a sentence when it fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from wucht.errors import RunError
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.events import LegError
from wucht.numerics.flow.legs import Integration
from wucht.numerics.flow.program import Numbers
from wucht.numerics.flow.trajectory import Trajectory

TimeCallback = Callable[[float], None]


def integrate(
    compiled: CompiledSystem,
    initial: Sequence[float] | np.ndarray,
    parameters: Numbers | Mapping[str, float],
    grid: np.ndarray,
    progress: TimeCallback | None = None,
    unit: float = 1.0,
) -> Trajectory:
    """Integrate from ``grid[0]`` and sample at the grid's points.

    Parameters
    ----------
    compiled : CompiledSystem
        With n states and m quadratures.
    initial : array_like, (n,) or (n + m,)
        The state; with the quadratures' values appended to continue a run.
    parameters : sequence of float, or mapping by name
        In the System's order, in the units of its equations (SI).
    grid : ndarray, (N,)
        Increasing times.
    progress : callable, optional
        Called with the time reached.
    unit : float
        The size that the quadratures have, for their accuracy.

    Returns
    -------
    Trajectory
        A run that fails, or is stopped by Ctrl-C, returns what it has, with ``failure`` or ``interrupted``. The same run gives
        the same numbers to the last bit.

    Raises
    ------
    RunError
        For an initial state that is not finite, or a grid that does not increase.
    """
    system = compiled.system
    pars = np.array(system.values(parameters) if isinstance(parameters, Mapping) else parameters, dtype=float)
    n, accumulated = len(system.states), len(system.quadratures)
    state = np.asarray(initial, dtype=float)
    if state.shape not in ((n,), (n + accumulated,)) or not np.isfinite(state).all():
        raise RunError(
            f"the initial state {state} has not {n} finite numbers, one for each of {', '.join(system.state_names)}",
            code="initial-state",
        )
    state = np.concatenate([state, np.zeros(n + accumulated - len(state))])
    grid = np.asarray(grid, dtype=float)
    if len(grid) < 1 or not (np.isfinite(grid).all() and (np.diff(grid) > 0).all()):
        raise RunError("the times at which to sample must increase, and be finite", code="not-increasing")
    # The unit is a power of two, so that a run which is continued has the same numbers to the last bit.
    run = Integration(compiled, compiled.engine.lend(), state, pars, grid, 2.0 ** round(math.log2(unit)))
    failure, interrupted = None, False
    try:
        run.start()
        more = True
        while more:
            more = run.advance()
            if progress:
                progress(run.time)
    except KeyboardInterrupt:
        interrupted = True
    except LegError as error:
        failure = run.failed(error)
    trajectory = run.trajectory(failure, interrupted)
    if failure is None and not interrupted:  # else it may have stopped anywhere
        compiled.engine.give_back(run.integrator)
    return trajectory
