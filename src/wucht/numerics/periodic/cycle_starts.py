"""First orbits of a branch: from samples of a run, from a Hopf point, at a period doubling, at a branch point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from wucht.earlier_names import provide_earlier_names
from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import mesh_from_samples, solve_near, tangent_near, with_exact_tolerance
from wucht.numerics.continuation.equilibria import Equilibrium
from wucht.numerics.continuation.special_points import locate_zero
from wucht.numerics.periodic.cycle import Cycle, Orbit
from wucht.numerics.periodic.cycles import Cycles

_FIRST = 30  # intervals
_TRIED_INTERVALS = (40, 400)  # on few Newton's method converges from a motion that is no orbit yet, on many from a steep one
_FEWEST = 4  # samples
_AT_REST = 1e-3  # of the samples' extent: a smaller motion is an equilibrium


def cycle_near(cycles: Cycles, times: np.ndarray, states: np.ndarray, value: float) -> Cycle:
    """Compute the periodic orbit near samples of one.

    Parameters
    ----------
    cycles : Cycles
    times : ndarray, (K,)
        From the begin of a period to its end.
    states : ndarray, (n, K)
        Angles as they turn, not wrapped.
    value : float
        Of the parameter.

    Returns
    -------
    Cycle

    Raises
    ------
    WuchtError
        Where these are not samples of a period.
    RunError
        Where Newton's method does not converge to an orbit near them.
    """
    e, period = cycles.equations, _checked_period(cycles, times, states, value)
    for intervals in _TRIED_INTERVALS:
        mesh, y = mesh_from_samples(times, states, e.scale[: e.n], cycles.degree, intervals)
        try:
            cycle = cycle_from_nodes(cycles, mesh, y, period, value)
            break
        except RunError as error:
            reason = str(error)
    else:
        raise RunError(f"no periodic orbit was found near these samples: {reason}", code="no-convergence")
    if not _extent(cycle.states, e.scale) > _AT_REST * _extent(np.asarray(states), e.scale):
        raise RunError("no periodic orbit was found near these samples, only an equilibrium")
    return cycle


def _extent(states: np.ndarray, scale: np.ndarray) -> float:
    return float((np.ptp(states, axis=1) / scale[: len(states)]).max())


def _checked_period(cycles: Cycles, times: np.ndarray, states: np.ndarray, value: float) -> float:
    """Return the period that samples cover. Raises ``WuchtError`` where they cannot be those of an orbit."""
    e, (low, high) = cycles.equations, cycles.bounds
    if not low <= value <= high:
        raise WuchtError(
            f"{e.parameter_names[-1]} = {value:g} lies outside its bounds, {low:g} to {high:g}", code="out-of-range"
        )
    if np.shape(states) != (e.n, len(times)):
        raise WuchtError(
            f"samples of {e.n} states at {len(times)} times form an array {(e.n, len(times))}, not {np.shape(states)}",
            code="shape",
        )
    if len(times) < _FEWEST:
        raise WuchtError(f"an orbit needs at least {_FEWEST} samples of a period, not {len(times)}", code="too-few")
    if not (np.isfinite(states).all() and np.isfinite(times).all() and (np.diff(times) > 0).all()):
        raise WuchtError("samples of an orbit must be finite, and their times must increase", code="not-increasing")
    if not _extent(np.asarray(states), e.scale) > 0:
        raise WuchtError("these samples are at rest: no state changes, as it must along an orbit", code="at-rest")
    turns_made = (np.asarray(states)[:, -1] - np.asarray(states)[:, 0]) / (2 * np.pi)
    for name, turns, winding, turn in zip(e.state_names, turns_made, cycles.winding, e.turns, strict=False):
        if turn and round(turns) != winding:
            raise WuchtError(
                f"{name} turns {turns:.3g} times in these samples, but its winding number is {winding}", code="winding"
            )
    return float(times[-1] - times[0])


def cycle_at(cycles: Cycles, orbit: Orbit, value: float) -> Cycle:
    """Compute the first orbit of a branch from a known orbit, also where the branch turns, as at a fold.

    Parameters
    ----------
    cycles : Cycles
    orbit : Orbit
        Special or not, of the same System: of a branch in this or another parameter (``Cycle``), or of a curve in two
        parameters (``CurveCycle``).
    value : float
        Of the parameter, approximate: the computed orbit may have another value where ``orbit`` is not exactly one.

    Returns
    -------
    Cycle

    Raises
    ------
    WuchtError
        Where the value is out of bounds, or the orbit has other states.
    RunError
        Where Newton's method does not converge to an orbit.
    """
    e, mesh = cycles.equations, orbit.problem.mesh
    if not cycles.bounds[0] <= value <= cycles.bounds[1]:
        raise WuchtError(
            f"{e.parameter_names[-1]} = {value:g} lies outside its bounds, {cycles.bounds[0]:g} to {cycles.bounds[1]:g}",
            code="out-of-range",
        )
    if len(orbit.states) != e.n:
        raise WuchtError(f"an orbit of {e.n} states begins this branch, not one of {len(orbit.states)}", code="shape")
    unknowns = np.concatenate([orbit.states.T.ravel(), [orbit.period, value]])
    problem = cycles.problem(mesh, orbit.period)
    problem = replace(problem, reference=problem.reference_from(unknowns))
    curve, point = solve_near(with_exact_tolerance(cycles.curve(problem)), unknowns, tangent_near(problem, unknowns))
    return cycles.cycle_from_point(replace(curve, steps=cycles.steps), point)


def cycles_with(cycles: Cycles, branch: Sequence[Cycle], value: float) -> tuple[Cycle, ...]:
    """Compute the orbits of a branch with a value of the parameter: one between each two neighbours that enclose it.

    Parameters
    ----------
    cycles : Cycles
    branch : sequence of Cycle
        In order, as from ``Cycles.walk``.
    value : float
        Of the parameter.

    Returns
    -------
    tuple of Cycle

    Raises
    ------
    RunError
        Where the branch cannot be computed between two neighbours.
    """
    crossings = list[Cycle]()
    for here, there in pairwise(branch):
        if here.parameter == value or (here.parameter - value) * (there.parameter - value) < 0:
            crossings.append(here if here.parameter == value else _cycle_between(cycles, here, there, value))
    return (*crossings, *(c for c in branch[-1:] if c.parameter == value))


def _cycle_between(cycles: Cycles, here: Cycle, there: Cycle, value: float) -> Cycle:
    exact = with_exact_tolerance(there.curve)
    make_cycle = partial(cycles.cycle_from_point, exact, near=here.basis)
    at = locate_zero(exact, here.point_on(there.problem.mesh), there.point, make_cycle, lambda c: c.parameter - value)
    if at is None:
        raise RunError(
            f"no orbit with {cycles.equations.parameter_names[-1]} = {value:g} was located between two that enclose this value"
        )
    return at


def cycle_from_nodes(cycles: Cycles, mesh: Mesh, y: np.ndarray, period: float, value: float) -> Cycle:
    """Compute the orbit at a value of the parameter near values at nodes (K, n), on an adapted mesh. Raises ``RunError``."""
    exact = with_exact_tolerance(cycles.curve(cycles.problem(mesh, period)))
    curve, point = solve_near(exact, np.concatenate([y.ravel(), [period, value]]))
    return cycles.cycle_from_point(replace(curve, steps=cycles.steps), point)


def cycle_at_hopf(cycles: Cycles, hopf: Equilibrium, amplitude: float = 0.01) -> Cycle:
    """Compute the first orbit of the branch that begins at a Hopf point.

    Parameters
    ----------
    cycles : Cycles
    hopf : Equilibrium
        The Hopf point, on a branch of equilibria in the same parameter.
    amplitude : float
        Root mean square of the states along the orbit, in units of scale.

    Returns
    -------
    Cycle

    Raises
    ------
    RunError
        Where Newton's method does not converge.
    """
    e, n = cycles.equations, cycles.equations.n
    values, vectors = np.linalg.eig(hopf.point.jacobian[:, :n])
    k = int(np.abs(values - 1j * hopf.frequency).argmin())
    vector = vectors[:, k] / np.linalg.norm(vectors[:, k] / e.scale[:n])
    period, mesh = 2 * np.pi / hopf.frequency, Mesh.even(_FIRST, cycles.degree)
    wave = np.sqrt(2) * (np.exp(2j * np.pi * mesh.nodes)[:, None] * vector).real
    base = np.concatenate([np.tile(hopf.x, len(mesh.nodes)), [period, hopf.parameter]])
    problem = cycles.problem(mesh, period)
    direction = np.concatenate([wave.ravel(), [0.0, 0.0]])
    guess = base + amplitude * direction
    problem = replace(problem, reference=problem.reference_from(guess))
    curve = cycles.curve(problem)
    return cycles.cycle_from_point(curve, with_exact_tolerance(curve).start(guess, direction))


def doubled_branch(cycles: Cycles, at: Cycle, amplitude: float = 0.01) -> tuple[Cycles, Cycle]:
    """Compute the branch of twice the period that begins at a period doubling, and its first orbit.

    Parameters
    ----------
    cycles : Cycles
        The branch that was followed.
    at : Cycle
        Its orbit of kind ``"period-doubling"``.
    amplitude : float
        Distance of the first orbit from the period doubling, in units of scale.

    Returns
    -------
    doubled : Cycles
    first : Cycle

    Raises
    ------
    RunError
        Where Newton's method does not converge.
    """
    mesh, n = at.problem.mesh, at.problem.n
    twice = Mesh(np.concatenate([mesh.edges / 2, (1 + mesh.edges[1:]) / 2]), mesh.degree)
    y = at.states.T
    change = propagated_change(at, -1.0).real
    advance = at.problem.winding
    assert advance is not None
    two_periods = np.concatenate([y, y[1:] + advance])
    direction = np.concatenate([change, -change[1:]])
    more = replace(cycles, winding=2 * cycles.winding, periods=(2 * cycles.periods[0], 2 * cycles.periods[1]))
    problem = more.problem(twice, 2 * at.period)
    size = np.sqrt(twice.shares @ ((direction / problem.sizes[:n]) ** 2).sum(axis=1))
    way = np.concatenate([(direction / size).ravel(), [0.0, 0.0]])
    guess = np.concatenate([two_periods.ravel(), [2 * at.period, at.parameter]]) + amplitude * way
    problem = replace(problem, reference=problem.reference_from(guess))
    curve = more.curve(problem)
    return more, more.cycle_from_point(curve, with_exact_tolerance(curve).start(guess, way))


def crossing_branch(cycles: Cycles, at: Cycle, amplitude: float = 0.01) -> tuple[Cycle, Cycle]:
    """Compute first orbits of the other branch through a branch point, one on either side.

    Parameters
    ----------
    cycles : Cycles
        The branch that was followed; the other one belongs to the same problem.
    at : Cycle
        Its orbit of kind ``"branch-point"``.
    amplitude : float
        Distance of both orbits from the branch point, in units of scale.

    Returns
    -------
    tuple of two Cycle

    Raises
    ------
    RunError
        Where Newton's method does not converge.
    """
    curve, direction = at.curve, at.crossing_direction
    first, second = (
        with_exact_tolerance(curve).start(at.point.unknowns + s * amplitude * direction, s * direction) for s in (1.0, -1.0)
    )
    return cycles.cycle_from_point(curve, first), cycles.cycle_from_point(curve, second)


def propagated_change(at: Cycle, multiplier: complex) -> np.ndarray:
    """Return the complex change (K, n) along an orbit that a period multiplies by a multiplier."""
    maps = at.point.jacobian.maps()
    values, vectors = np.linalg.eig(np.linalg.multi_dot(maps[::-1, -1]))
    here = vectors[:, np.abs(values - multiplier).argmin()]
    changes = [here[None]]
    for step_map in maps:
        changes.append(step_map @ here)
        here = changes[-1][-1]
    return np.concatenate(changes)


provide_earlier_names(__name__)
