"""Curves in the plane of two parameters at which the way changes in which the modulated motion ends as a third one grows.

Between an orbit that ends at a saddle-node on it and one that ends at a saddle connection the orbit returns to the saddle-node
along its strongly stable direction. This curve ends where a second pair of steady states vanishes at the same value, at a
connection of two saddle-nodes; there begin the curve at which both pairs vanish at once, and that at which the connection
leads from a saddle-node to a saddle of the other pair. O. Drozdetskaya's dissertation leaves this question open
(section 5.2); the unfolding of its first curve: S. Schecter, SIAM J. Math. Anal. 18 (1987) 1142-1156.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.modulated_motion import nearest_fold
from wucht.dynamics.branches.orbit_endings import OrbitEnding, connections_at, connections_of
from wucht.dynamics.branches.plane_regions import DOUBLE, PlaneCurve, PlanePoint
from wucht.errors import RunError
from wucht.numerics.continuation.fold_curves import FoldPairs
from wucht.numerics.periodic.connection import SADDLE_NODE, Connection
from wucht.numerics.periodic.connection_starts import (
    longest_wait,
    prolong_at_saddle_node,
    rest_of,
    saddle_node_of,
    saddle_node_to_saddle,
)
from wucht.numerics.periodic.saddle_connections import Connections

RETURNS, BOTH_VANISH, TO_SADDLE = "returns-to-saddle-node", "both-pairs-vanish", "saddle-node-to-saddle"
_CHECK_EVERY, _LATER = 10, 1.5  # points; the factor until the next search for a second saddle-node
_TOO_LONG = 0.12  # of the time: the orbit waits so long where that will be
_LONGER, _MOST_LONGER, _CONVERGENCE = 3.0, 8, 1e-7  # times as long; how often; share of the ranges by which it then changes
_SPARE = 8.0  # times as long: time of connections of saddle-nodes
_MOST = 600  # points of a curve, each way

StageReport = Callable[[str], None]


def curves_between(
    case: EndingMapCase, connection_ending: OrbitEnding, saddle_node_ending: OrbitEnding, report: StageReport
) -> tuple[PlaneCurve | PlanePoint | str, ...]:
    """Follow the curves between a place where the orbit ends at a connection and one where it ends at a saddle-node on it.

    The two places differ in one parameter only. Returned are the curves, the point where they meet, and sentences on what
    could not be followed.
    """
    omissions = list[str]()
    try:
        report("the saddle-node limit of saddle connections")
        connections, first = _limit(case, connection_ending, saddle_node_ending)
    except RunError as error:
        (_, along, second), (x, y) = case.paths, (connection_ending.x, connection_ending.y)
        return (f"near {along} = {x:.5g}, {second} = {y:.5g}: {error}",)
    halves, third = list[list[Connection]](), list[PlaneCurve]()
    point: PlanePoint | None = None
    double_point = np.empty(0)
    for start in (connections.backwards(first), first):
        half, double, reason = _returning_curve(case, connections, start, report, point is None)
        halves.append(half)
        omissions += [reason] if reason else []
        if double is not None and point is None:
            point, third = _from_double(case, double, omissions, report)
            double_point = double.parameter_values[:3]
    way = [*halves[0][::-1], first, *halves[1]]
    table = np.array([c.parameter_values[:3] for c in way]).T
    if point is not None:
        at_begin, at_end = (float(np.linalg.norm(_scale_change(case, table[:, i] - double_point))) for i in (0, -1))
        table = np.insert(table, 0 if at_begin < at_end else table.shape[1], double_point, axis=1)
    curve = _curve(case, RETURNS, table)
    return (*(part for part in (curve, *third, point) if part is not None), *omissions)


def _scale_change(case: EndingMapCase, change: np.ndarray) -> np.ndarray:
    return np.asarray(change[1:] / np.array([b[1] - b[0] for b in case.bounds]))


def _curve(case: EndingMapCase, kind: str, table: np.ndarray) -> PlaneCurve | None:
    """Return the part of a curve that lies in the plane, cut at its edge."""
    inside = case.contains(table[1], table[2])
    if not inside.any():
        return None
    first, last = int(inside.argmax()), len(inside) - 1 - int(inside[::-1].argmax())
    columns = [_cut_at_edge(case, table[:, first], table[:, first - 1])] if first else []
    columns += list(table[:, first : last + 1].T)
    columns += [_cut_at_edge(case, table[:, last], table[:, last + 1])] if last + 1 < table.shape[1] else []
    value, x, y = np.array(columns).T
    return PlaneCurve(kind, x, y, value)


def _cut_at_edge(case: EndingMapCase, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Return the point at which the line from a point of the plane to one outside crosses its edge."""
    shares = [1.0]
    for k, (low, high) in enumerate(case.bounds, 1):
        for edge in (low, high):
            if (inside[k] - edge) * (outside[k] - edge) < 0:
                shares.append((edge - inside[k]) / (outside[k] - inside[k]))
    return np.asarray(inside + min(shares) * (outside - inside))


def _limit(
    case: EndingMapCase, connection_ending: OrbitEnding, saddle_node_ending: OrbitEnding
) -> tuple[Connections, Connection]:
    """Return the connection of a saddle-node at which the saddle connections between two places end."""
    along = 1 if connection_ending.x != saddle_node_ending.x else 2
    place = connection_ending.x, connection_ending.y
    here, start = case.motion_at(*place), place[along - 1]
    connections, first = connections_at(here, case.paths[along], case.wider_ranges[along], connection_ending.end, start)
    towards = (saddle_node_ending.x, saddle_node_ending.y)[along - 1] - start
    grows = first.point.tangent[-1] * towards > 0
    walk = connections.walk(first if grows else connections.backwards(first))
    last = first
    for last in walk:  # noqa: B007
        pass
    if walk.end != SADDLE_NODE:
        raise RunError(f"the saddle connection does not lead to a saddle-node: {walk.end}")
    value, limit_value = last.parameter_values[:2].tolist()
    fold = nearest_fold(here.with_values({case.paths[along]: limit_value}), last.equilibria[0], value)
    winding = connections.winding
    whole = connections_of(here, case.paths, case.wider_ranges, connections.time, winding, (True,))
    values = np.array([fold.parameter, *place])
    values[along] = limit_value
    short = saddle_node_of(whole, last, fold.x, values)
    # Towards the end of the curve the orbit waits longer and longer elsewhere: its time must allow for that.
    whole = connections_of(here, case.paths, case.wider_ranges, _SPARE * connections.time, winding, (True,))
    return whole, prolong_at_saddle_node(whole, short)


def _returning_curve(
    case: EndingMapCase,
    connections: Connections,
    start: Connection,
    report: StageReport,
    finds_double: bool,
) -> tuple[list[Connection], Connection | None, str]:
    """Follow the curve one way; return also the connection of two saddle-nodes at its end, or why it ends elsewhere."""
    half, double, next_check, walk = list[Connection](), None, _CHECK_EVERY, connections.walk(start)
    for k, c in enumerate(walk):
        report("the curve on which the orbit returns to the saddle-node")
        if double is not None and not _comes_nearer(case, double, half[-1], c):
            return half, double, ""
        half.append(c)
        x, y = c.parameter_values[1:3]
        if not case.contains(np.array([x]), np.array([y]))[0] or k > _MOST:
            return half, double, ""
        if not finds_double or k < next_check:
            continue
        waits, next_check = (
            longest_wait(connections, c),
            k + _CHECK_EVERY if double is not None else max(int(_LATER * k), _CHECK_EVERY),
        )
        if waits is None:
            continue
        if double is None:
            double = _double_connection(case, connections, c)
        if double is not None and waits.share > _TOO_LONG:
            return half, double, ""
    return half, double, "" if "range" in walk.end else f"the curve ends: {walk.end}"


def _comes_nearer(case: EndingMapCase, double: Connection, before: Connection, after: Connection) -> bool:
    """True if a curve still approaches its end in both parameters: so near to the end, other solutions are near too."""
    a, b = (np.abs(_scale_change(case, c.parameter_values[:3] - double.parameter_values[:3])) for c in (before, after))
    return bool((b < a).all())


def _double_connection(case: EndingMapCase, connections: Connections, at: Connection) -> Connection | None:
    """Return the connection of two saddle-nodes near one that waits long where the first of them will be."""
    waits = longest_wait(connections, at)
    if waits is None:
        return None
    end = at.equilibria[0] + 2 * np.pi * connections.winding
    try:
        unknowns = FoldPairs(connections.rates, case.wider_ranges).nearest_pair(waits.state, end, at.parameter_values)
        times, states = rest_of(at, waits.tau)
        n = connections.rates.n
        double_connections = _connections(case, float(times[-1]), (True, True))
        double = double_connections.start(times, states, unknowns[: 2 * n].reshape(2, n), unknowns[2 * n :].tolist())
    except (RunError, np.linalg.LinAlgError):
        return None
    for _ in range(_MOST_LONGER):
        before, later = double, _connections(case, _LONGER * double.time, (True, True))
        try:
            double = prolong_at_saddle_node(later, double)
        except RunError:
            return None
        if np.linalg.norm(_scale_change(case, double.parameter_values[:3] - before.parameter_values[:3])) < _CONVERGENCE:
            return double
    return None


def _connections(case: EndingMapCase, time: float, folds: tuple[bool, bool]) -> Connections:
    """Connections of two different steady states: whole turns of an orbit are part of the states themselves."""
    no_winding = np.zeros(len(case.motion.subject.system.states), int)
    return connections_of(case.motion, case.paths, case.wider_ranges, time, no_winding, folds)


def _from_double(
    case: EndingMapCase, double: Connection, omissions: list[str], report: StageReport
) -> tuple[PlanePoint, list[PlaneCurve]]:
    """Return the point of the plane at a connection of two saddle-nodes, and the curves that begin there."""
    value, x, y = double.parameter_values[:3].tolist()
    point = PlanePoint(DOUBLE, x, y, value)
    curves = list[PlaneCurve | None]()
    report("the curve from a saddle-node to a saddle")
    third = _connections(case, double.time, (True, False))
    try:
        first = saddle_node_to_saddle(third, double)
        ways = []
        for start in (first, third.backwards(first)):
            ways.append([c.parameter_values[:3] for c in third.walk(start)])
        ways.sort(key=lambda way: np.linalg.norm(_scale_change(case, way[-1] - double.parameter_values[:3])) if way else 0.0)
        table = np.array([double.parameter_values[:3], *ways[0][::-1], first.parameter_values[:3], *ways[1]]).T
        curves.append(_curve(case, TO_SADDLE, table))
    except RunError as error:
        omissions.append(str(error))
    report("the curve at which both pairs of steady states vanish at once")
    equations = case.motion.equations(case.paths, case.ranges)
    pairs, n = FoldPairs(equations, case.wider_ranges), equations.n
    unknowns = np.concatenate([double.equilibria.ravel(), double.parameter_values[:3]])
    for way in (1, -1):
        try:
            table = np.array([unknowns[2 * n :], *(p.unknowns[2 * n :] for _, p in pairs.walk(unknowns, way))]).T
            curves.append(_curve(case, BOTH_VANISH, table))
        except RunError as error:
            omissions.append(f"the curve at which both pairs vanish at once is not followed: {error}")
    return point, [c for c in curves if c is not None]
