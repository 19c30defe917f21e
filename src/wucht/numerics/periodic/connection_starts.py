"""First connections of curves: by integration from a saddle, from the last orbit of a branch, at a saddle-node, between two
saddle-nodes, and from a saddle-node to a saddle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.earlier_names import provide_earlier_names
from wucht.errors import RunError
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.periodic.connection import Connection
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.numerics.zeros_and_peaks import stretches

_SAMPLES = 20_001
_SLOW = 0.05  # of the largest speed
_AWAY = 0.05  # of an orbit's size: distance of another equilibrium
_OUTSIDE, _DECAY_TIMES = (
    2000,
    20.0,
)  # samples of the extensions at both ends of a connection; a deviation decays there by exp(-20)
_STARTS, _SPREAD = 40, 0.5  # of Newton's method, and their distance from a saddle-node, in units of scale
_SHIFTS = (1e-5, 1e-4, 1e-3)  # of a parameter's size: first steps beyond a codimension-two point
_CORRECTIONS, _ACCURATE, _SAME = 30, 1e-11, 1e-8
_BEGIN, _TOLERANCE = 1e-4, 1e-10  # in units of scale: start of an orbit, distance from its saddle; of its integration
_RETURN_RATIO = 0.25  # of its largest distance from the saddle so far: a nearer orbit has returned


def connection_from_excursion(
    connections: Connections, place: Sequence[float] | np.ndarray, values: Sequence[float], way: int = 1
) -> Connection:
    """Compute the connection near the orbit that leaves a saddle, up to where it first comes back next to it.

    Parameters
    ----------
    connections : Connections
        Of orbits that return to a saddle. Their time is that of the integration, at most.
    place : sequence of float, (n,)
        Near the saddle.
    values : sequence of float
        Of the parameters: near those of a connection. The last one is fixed where a curve is followed; if only one is varied,
        it is solved for.
    way : int
        1 or -1, side on which the saddle is left: 1 where the state with the largest component grows.

    Returns
    -------
    Connection

    Raises
    ------
    RunError
        Where there is no saddle, the orbit does not come back, or Newton's method does not converge to a connection.
    """
    from scipy.integrate import solve_ivp

    equations, n = connections.rates, connections.rates.n
    parameter_values, scale = _all_parameters(connections, values), connections.rates.scale[:n]
    saddle = _equilibrium_near(equations, np.asarray(place, float), parameter_values)
    matrix = equations.values(np.concatenate([saddle, parameter_values]))[1][:, :n] / scale[:, None] * scale
    rates, vectors = np.linalg.eig(matrix)
    if not ((rates.real > 0).sum() == 1 and (rates.real < 0).sum() == n - 1):
        raise RunError("the equilibrium is not a saddle with one unstable direction", code="no-saddle")
    leaving = vectors[:, int(rates.real.argmax())].real
    leaving = leaving * way * np.sign(leaving[np.abs(leaving).argmax()]) / np.linalg.norm(leaving)
    run = solve_ivp(
        lambda _, x: equations.values(np.concatenate([x, parameter_values]))[0],
        (0.0, connections.time), saddle + _BEGIN * leaving * scale, "DOP853",
        rtol=_TOLERANCE, atol=_TOLERANCE * _BEGIN * scale.min(), dense_output=True,
    )  # fmt: skip
    times = np.linspace(0.0, run.t[-1], _SAMPLES)
    states, advance = run.sol(times), 2 * np.pi * connections.winding
    last = _return(np.linalg.norm((states - (saddle + advance)[:, None]) / scale[:, None], axis=0))
    short = replace(connections, time=float(times[last]))
    connection = short.start(times[: last + 1], states[:, : last + 1], saddle[None], list(values))
    return connections.prolong(connection, fix_last=True)


def _return(away: np.ndarray) -> int:
    """Return the index at which distances (K,) from a saddle are least the first time that they are small again."""
    farthest = np.maximum.accumulate(away)
    back = np.flatnonzero(away < _RETURN_RATIO * farthest)
    if not len(back):
        raise RunError("the orbit that leaves the saddle does not come back to it in that time", code="no-return")
    begin = int(back[0])
    again = np.flatnonzero(away[begin:] >= _RETURN_RATIO * farthest[begin])
    return begin + int(away[begin : begin + int(again[0]) if len(again) else None].argmin())


def _all_parameters(connections: Connections, values: Sequence[float]) -> np.ndarray:
    """Return the values of all varied parameters, including a fixed one."""
    return np.array([*values, *[0.0] * (len(connections.bounds) - len(values))])


def _equilibrium_near(equations: EquilibriumEquations, x: np.ndarray, parameter_values: np.ndarray) -> np.ndarray:
    n, scale = equations.n, equations.scale[: equations.n]
    for _ in range(_CORRECTIONS):
        f, derivatives = equations.values(np.concatenate([x, parameter_values]))
        try:
            change = np.linalg.solve(derivatives[:, :n], f)
        except np.linalg.LinAlgError:
            break
        x = x - change
        if np.linalg.norm(change / scale) < _ACCURATE:
            return x
    raise RunError("no equilibrium was found near this place")


@dataclass(frozen=True, eq=False)
class Wait:
    """Slow stretch of a connection, far from its ends. share: of its time. tau: of the slowest place. state (n,): there."""

    share: float
    tau: float
    state: np.ndarray


def connection_from_cycle(connections: Connections, cycle: Cycle, saddle: np.ndarray, values: np.ndarray) -> Connection:
    """Compute the connection near the last orbit of a branch. Raises ``RunError``.

    saddle (n,): to which the orbit comes near. values: of the parameters. Where the connections' time is longer than that
    orbit's period, the orbit is extended by the linearised equations at the saddle.
    """
    tau, n = np.linspace(0.0, 1.0, _SAMPLES), connections.rates.n
    states = cycle.states_at(tau)
    advance = 2 * np.pi * connections.winding[:, None]
    scale = connections.rates.scale[:n, None]
    turning = connections.rates.turns[:n, None] > 0
    away = (states - saddle[:, None]) / scale
    away = np.where(turning, away - 2 * np.pi / scale * np.round(away * scale / (2 * np.pi)), away)
    k = int(np.linalg.norm(away, axis=0)[:-1].argmin())
    orbit_states = np.concatenate([states[:, k:], states[:, 1 : k + 1] + advance], axis=1)
    begin = orbit_states[:, 0] - away[:, k] * scale[:, 0]  # the saddle, as many whole turns on as the orbit is
    times, more = tau * cycle.period, connections.time - cycle.period
    if more > 0:
        point = np.append(begin, _all_parameters(connections, values.tolist()))
        rates = np.sort(np.linalg.eigvals(connections.rates.values(point)[1][:, :n]).real)[::-1]
        share = rates[1] / (rates[1] - rates[0])  # so that both ends come equally near
        outside = np.linspace(0.0, more, _OUTSIDE)[1:]
        before, after = outside[::-1] * share, outside * (1 - share)
        earlier = begin[:, None] + (orbit_states[:, 0] - begin)[:, None] * np.exp(-rates[0] * before)
        goal = begin[:, None] + advance
        later = goal + (orbit_states[:, -1:] - goal) * np.exp(rates[1] * after)
        orbit_states = np.concatenate([earlier, orbit_states, later], axis=1)
        times = np.concatenate([-before, times, times[-1] + after]) + before[0]
    return connections.start(times, orbit_states, begin[None], values.tolist())


def saddle_node_of(connections: Connections, connection: Connection, place: np.ndarray, values: np.ndarray) -> Connection:
    """Compute the connection of a saddle-node (n,) near one of a saddle with the same time. Raises ``RunError``."""
    tau = np.linspace(0.0, 1.0, _SAMPLES)
    return connections.start(tau * connections.time, connection.states_at(tau), place[None], values.tolist())


def longest_wait(connections: Connections, connection: Connection) -> Wait | None:
    """Return the longest wait of a connection between its ends, None where there is none."""
    tau = np.linspace(0.0, 1.0, _SAMPLES)
    states, n = connection.states_at(tau), connections.rates.n
    points = np.concatenate([states, np.repeat(connection.parameter_values[:, None], len(tau), axis=1)])
    speed = np.linalg.norm(connections.rates.values(points)[0] / connections.rates.scale[:n, None], axis=0)
    waits = [(a, b) for a, b in stretches(speed < _SLOW * speed.max()) if a > 0 and b < len(tau)]
    if not waits:
        return None
    a, b = max(waits, key=lambda wait: wait[1] - wait[0])
    k = a + int(speed[a:b].argmin())
    return Wait((b - a) / len(tau), float(tau[k]), states[:, k])


def rest_of(connection: Connection, tau: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times from 0 on, and states, of a connection from a share of its time on."""
    shares = np.linspace(tau, 1.0, _SAMPLES)
    return (shares - tau) * connection.time, connection.states_at(shares)


def prolong_at_saddle_node(connections: Connections, connection: Connection) -> Connection:
    """Extend a connection that leaves a saddle-node to the longer time of other connections. Raises ``RunError``.

    Near it, d' = a d^2 along the direction in which it is left: the orbit comes from d/(1 + a d t), a time t before. It reaches
    its end as exp(l t), with l the slowest of the eigenvalues except for the leaving one.
    """
    n, more = connections.rates.n, connections.time - connection.time
    if more <= 0:
        raise RunError(f"the time {connections.time:.6g} must be longer than that of the connection, {connection.time:.6g}")
    begin, end = connection.equilibria[0], connection.equilibria[-1] + 2 * np.pi * connections.winding
    times, states = rest_of(connection, 0.0)
    away, scale = states[:, 0] - begin, connections.rates.scale[:n]
    speed = connections.rates.values(np.concatenate([states[:, 0], connection.parameter_values]))[0]
    rate = float(np.linalg.norm(speed / scale) / np.linalg.norm(away / scale))
    decay = float(connection.eigenvalues[-1, 1].real)
    after = np.linspace(0.0, min(more / 2, _DECAY_TIMES / -decay), _OUTSIDE)[1:]
    more -= after[-1]
    before = np.geomspace(1.0, 1 + rate * more, _OUTSIDE)[:0:-1]
    earlier = begin[:, None] + away[:, None] / before
    later = end[:, None] + (states[:, -1] - end)[:, None] * np.exp(decay * after)
    whole = np.concatenate([earlier, states, later], axis=1)
    at = np.concatenate([more - (before - 1) / rate, more + times, more + times[-1] + after])
    values = connection.parameter_values[: len(connections.bounds)]
    return connections.start(at, whole, connection.equilibria, values.tolist())


def saddles_near(equations: EquilibriumEquations, place: np.ndarray, parameter_values: np.ndarray) -> list[np.ndarray]:
    """Return the saddles (n,), left in one direction, near a saddle-node that has split in two."""
    n, scale = equations.n, equations.scale[: equations.n]
    matrix = equations.values(np.concatenate([place, parameter_values]))[1][:, :n] * scale / scale[:, None]
    along = np.linalg.svd(matrix)[2][-1] * scale
    saddles = list[np.ndarray]()
    shares = np.geomspace(1e-4, _SPREAD, _STARTS)
    for share in np.concatenate([shares, -shares]).tolist():
        x = place + share * along
        for _ in range(_CORRECTIONS):
            f, derivatives = equations.values(np.concatenate([x, parameter_values]))
            try:
                change = np.linalg.solve(derivatives[:, :n], f)
            except np.linalg.LinAlgError:
                break
            x = x - change
            if np.linalg.norm(change / scale) < _ACCURATE:
                break
        f_x = equations.values(np.concatenate([x, parameter_values]))[1][:, :n]
        rates = np.linalg.eigvals(f_x).real if np.isfinite(f_x).all() else np.zeros(n)
        one = np.linalg.norm(change / scale) < _SAME and (rates > 0).sum() == 1 and (rates < 0).sum() == n - 1
        near = np.linalg.norm((x - place) / scale) < _SPREAD
        if one and near and not any(np.linalg.norm((x - y) / scale) < _SAME for y in saddles):
            saddles.append(x)
    return sorted(saddles, key=lambda x: float(np.linalg.norm((x - place) / scale)))


def saddle_node_to_saddle(connections: Connections, at: Connection) -> Connection:
    """Compute the connection from a saddle-node to the saddle of another pair, next to one from saddle-node to saddle-node.

    connections: with folds (True, False), three parameters and the time of ``at``. Raises ``RunError`` where there is none on
    either side of that point.
    """
    equations, m = connections.rates, len(connections.bounds)
    values = at.parameter_values[:m]
    times, states = rest_of(at, 0.0)
    for shift in _SHIFTS:
        for sign in (-1.0, 1.0):
            shifted_values = values.copy()
            shifted_values[-1] += sign * shift * equations.scale[-1]
            try:
                fold, shifted_values = fold_at(equations, at.equilibria[0], shifted_values)
            except RunError:
                continue
            for saddle in saddles_near(equations, at.equilibria[1], shifted_values):
                try:
                    return connections.start(times, states, np.array([fold, saddle]), shifted_values.tolist())
                except RunError:
                    continue
    raise RunError("no connection of the saddle-node with a saddle of the other pair was found next to it")


def fold_at(equations: EquilibriumEquations, x: np.ndarray, parameter_values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve for the saddle-node near x and the first parameter, the others fixed. Raises ``RunError``."""
    n = equations.n
    unknowns = np.append(x, parameter_values[0])

    def conditions(unknowns: np.ndarray) -> np.ndarray:
        f, derivatives = equations.values(np.concatenate([unknowns, parameter_values[1:]]))
        return np.append(f, np.linalg.det(derivatives[:, :n]))

    sizes = np.append(equations.scale[:n], equations.scale[n])
    for _ in range(_CORRECTIONS):
        steps = np.diag(6e-6 * sizes)
        slopes = np.array([(conditions(unknowns + h) - conditions(unknowns - h)) / (2 * h.max()) for h in steps]).T
        try:
            change = np.linalg.solve(slopes, conditions(unknowns))
        except np.linalg.LinAlgError:
            break
        unknowns = unknowns - change
        if not np.isfinite(unknowns).all():
            break
        if np.linalg.norm(change / sizes) < _SAME:
            return unknowns[:-1], np.append(unknowns[-1], parameter_values[1:])
    raise RunError("Newton's method does not converge to the saddle-node")


provide_earlier_names(__name__)
