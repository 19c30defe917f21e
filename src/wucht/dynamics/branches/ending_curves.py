"""Curves in the plane of two parameters at which the way changes in which the modulated motion ends as a third one grows.

Between an orbit that ends at a saddle-node on it and one that ends at a saddle connection the orbit returns to the saddle-node
along its strongly stable direction. This curve ends where a second pair of steady states vanishes at the same value, at a
connection of two saddle-nodes; there begin the curve at which both pairs vanish at once, and that at which the connection
leads from a saddle-node to a saddle of the other pair. O. Drozdetskaya's dissertation leaves this question open
(section 5.2); the unfolding of its first curve: S. Schecter, SIAM J. Math. Anal. 18 (1987) 1142-1156.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.branches.modulated_motion import ModulatedMotion, nearest_fold
from wucht.dynamics.branches.orbit_endings import OrbitEnding, connections_at, connections_of
from wucht.dynamics.branches.plane_regions import DOUBLE, CurvesAndPoints, PlaneCurve, PlanePoint
from wucht.errors import RunError
from wucht.numerics.continuation.fold_curves import FoldPairs
from wucht.numerics.periodic.connection import SADDLE_NODE, Connection
from wucht.numerics.periodic.connection_starts import beyond, longer, rest_of, saddle_node_of, waiting
from wucht.numerics.periodic.saddle_connections import Connections

RETURNS, BOTH, TO_SADDLE = "returns-to-saddle-node", "both-pairs-vanish", "saddle-node-to-saddle"
_LOOKED_EVERY, _LATER = 10, 1.5  # points; the factor until the next search for a second saddle-node
_TOO_LONG = 0.12  # of the time: the orbit waits so long where that will be
_LONGER, _MOST_LONGER, _SETTLED = 3.0, 8, 1e-7  # times as long; how often; share of the ranges by which it then changes
_SPARE = 8.0  # times as long: time of connections of saddle-nodes
_ROOM = 0.5  # of the ranges: how far beyond the plane curves are followed where that leads to the next one
_MOST = 600  # points of a curve, each way

Watch = Callable[[str], None]


@dataclass(frozen=True)
class Plane:
    """Paths and ranges of the eliminated parameter and of the two parameters of the plane."""

    paths: tuple[str, str, str]
    bounds: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]

    @property
    def wider(self) -> tuple[tuple[float, float], ...]:
        """Ranges with a margin, on the same side of zero."""

        def wide(low: float, high: float) -> tuple[float, float]:
            room = _ROOM * (high - low)
            return (max(low - room, low / 10) if low > 0 else low - room, high + room)

        return (self.bounds[0], wide(*self.bounds[1]), wide(*self.bounds[2]))

    def at(self, motion: ModulatedMotion, x: float, y: float) -> ModulatedMotion:
        """Return the motion at a place of the plane."""
        return motion.at(dict(zip(self.paths[1:], (x, y), strict=True)))

    def inside(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return a mask of the points that lie in the plane."""
        (x0, x1), (y0, y1) = self.bounds[1:]
        return np.asarray((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))


def curves_between(
    motion: ModulatedMotion, plane: Plane, connected: OrbitEnding, other: OrbitEnding, watch: Watch
) -> CurvesAndPoints:
    """Follow the curves between a place where the orbit ends at a connection and one where it ends at a saddle-node on it.

    The two places differ in one parameter only.
    """
    lost = list[str]()
    try:
        watch("the saddle-node limit of saddle connections")
        connections, first = _limit(motion, plane, connected, other)
    except RunError as error:
        return CurvesAndPoints(lost=(_where(plane, connected) + str(error),))
    halves, third = list[list[Connection]](), list[PlaneCurve]()
    point: PlanePoint | None = None
    joined = np.empty(0)
    for start in (connections.backwards(first), first):
        half, found, why = _returning(motion, plane, connections, start, watch, point is None)
        halves.append(half)
        lost += [why] if why else []
        if found is not None and point is None:
            point, third = _from_double(motion, plane, found, lost, watch)
            joined = found.parameters[:3]
    way = [*halves[0][::-1], first, *halves[1]]
    table = np.array([c.parameters[:3] for c in way]).T
    if point is not None:
        at_begin, at_end = (float(np.linalg.norm(_scaled(plane, table[:, i] - joined))) for i in (0, -1))
        table = np.insert(table, 0 if at_begin < at_end else table.shape[1], joined, axis=1)
    curve = _curve(plane, RETURNS, table)
    curves = [c for c in (curve, *third) if c is not None]
    return CurvesAndPoints(tuple(curves), () if point is None else (point,), tuple(lost))


def _scaled(plane: Plane, change: np.ndarray) -> np.ndarray:
    return np.asarray(change[1:] / np.array([b[1] - b[0] for b in plane.bounds[1:]]))


def _where(plane: Plane, at: OrbitEnding) -> str:
    return f"near {plane.paths[1]} = {at.x:.5g}, {plane.paths[2]} = {at.y:.5g}: "


def _curve(plane: Plane, kind: str, table: np.ndarray) -> PlaneCurve | None:
    """Return the part of a curve that lies in the plane, cut at its edge."""
    inside = plane.inside(table[1], table[2])
    if not inside.any():
        return None
    first, last = int(inside.argmax()), len(inside) - 1 - int(inside[::-1].argmax())
    columns = [_cut(plane, table[:, first], table[:, first - 1])] if first else []
    columns += list(table[:, first : last + 1].T)
    columns += [_cut(plane, table[:, last], table[:, last + 1])] if last + 1 < table.shape[1] else []
    value, x, y = np.array(columns).T
    return PlaneCurve(kind, x, y, value)


def _cut(plane: Plane, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Return the point at which the line from a point of the plane to one outside crosses its edge."""
    shares = [1.0]
    for k, (low, high) in enumerate(plane.bounds[1:], 1):
        for edge in (low, high):
            if (inside[k] - edge) * (outside[k] - edge) < 0:
                shares.append((edge - inside[k]) / (outside[k] - inside[k]))
    return np.asarray(inside + min(shares) * (outside - inside))


def _limit(motion: ModulatedMotion, plane: Plane, connected: OrbitEnding, other: OrbitEnding) -> tuple[Connections, Connection]:
    """Return the connection of a saddle-node at which the saddle connections between two places end."""
    along = 1 if connected.x != other.x else 2
    here, start = plane.at(motion, connected.x, connected.y), (connected.x, connected.y)[along - 1]
    connections, first = connections_at(here, plane.paths[along], plane.wider[along], connected.end, start)
    towards = (other.x, other.y)[along - 1] - start
    grows = first.point.tangent[-1] * towards > 0
    walk = connections.walk(first if grows else connections.backwards(first))
    last = first
    for last in walk:  # noqa: B007
        pass
    if walk.end != SADDLE_NODE:
        raise RunError(f"the saddle connection does not lead to a saddle-node: {walk.end}")
    value, moved = last.parameters[:2].tolist()
    fold = nearest_fold(here.at({plane.paths[along]: moved}), last.equilibria[0], value)
    winding = connections.winding
    whole = connections_of(here, plane.paths, plane.wider, connections.time, winding, (True,))
    values = np.array([fold.value, connected.x, connected.y])
    values[along] = moved
    short = saddle_node_of(whole, last, fold.state, values)
    # Towards the end of the curve the orbit waits longer and longer elsewhere: its time must allow for that.
    whole = connections_of(here, plane.paths, plane.wider, _SPARE * connections.time, winding, (True,))
    return whole, longer(whole, short)


def _returning(
    motion: ModulatedMotion, plane: Plane, connections: Connections, start: Connection, watch: Watch, looks: bool
) -> tuple[list[Connection], Connection | None, str]:
    """Follow the curve one way; return also the connection of two saddle-nodes at its end, or why it ends elsewhere."""
    half, double, look, walk = list[Connection](), None, _LOOKED_EVERY, connections.walk(start)
    for k, c in enumerate(walk):
        watch("the curve on which the orbit returns to the saddle-node")
        if double is not None and not _nearer(plane, double, half[-1], c):
            return half, double, ""
        half.append(c)
        x, y = c.parameters[1:3]
        if not plane.inside(np.array([x]), np.array([y]))[0] or k > _MOST:
            return half, double, ""
        if not looks or k < look:
            continue
        waits, look = waiting(connections, c), k + _LOOKED_EVERY if double is not None else max(int(_LATER * k), _LOOKED_EVERY)
        if waits is None:
            continue
        if double is None:
            double = _double(motion, plane, connections, c)
        if double is not None and waits.share > _TOO_LONG:
            return half, double, ""
    return half, double, "" if "range" in walk.end else f"the curve ends: {walk.end}"


def _nearer(plane: Plane, double: Connection, before: Connection, after: Connection) -> bool:
    """True if a curve still approaches its end in both parameters: so near to the end, other solutions are near too."""
    a, b = (np.abs(_scaled(plane, c.parameters[:3] - double.parameters[:3])) for c in (before, after))
    return bool((b < a).all())


def _double(motion: ModulatedMotion, plane: Plane, connections: Connections, at: Connection) -> Connection | None:
    """Return the connection of two saddle-nodes near one that waits long where the first of them will be."""
    waits = waiting(connections, at)
    if waits is None:
        return None
    end = at.equilibria[0] + 2 * np.pi * connections.winding
    try:
        u = FoldPairs(connections.rates, plane.wider).near(waits.state, end, at.parameters)
        times, states = rest_of(at, waits.tau)
        n = connections.rates.n
        both = _connections(motion, plane, float(times[-1]), (True, True))
        found = both.start(times, states, u[: 2 * n].reshape(2, n), u[2 * n :].tolist())
    except (RunError, np.linalg.LinAlgError):
        return None
    for _ in range(_MOST_LONGER):
        before, later = found, _connections(motion, plane, _LONGER * found.time, (True, True))
        try:
            found = longer(later, found)
        except RunError:
            return None
        if np.linalg.norm(_scaled(plane, found.parameters[:3] - before.parameters[:3])) < _SETTLED:
            return found
    return None


def _connections(motion: ModulatedMotion, plane: Plane, time: float, folds: tuple[bool, bool]) -> Connections:
    """Connections of two different steady states: whole turns of an orbit are part of the states themselves."""
    none = np.zeros(len(motion.subject.system.states), int)
    return connections_of(motion, plane.paths, plane.wider, time, none, folds)


def _from_double(
    motion: ModulatedMotion, plane: Plane, double: Connection, lost: list[str], watch: Watch
) -> tuple[PlanePoint, list[PlaneCurve]]:
    """Return the point of the plane at a connection of two saddle-nodes, and the curves that begin there."""
    value, x, y = double.parameters[:3].tolist()
    point = PlanePoint(DOUBLE, x, y, value)
    curves = list[PlaneCurve | None]()
    watch("the curve from a saddle-node to a saddle")
    third = _connections(motion, plane, double.time, (True, False))
    try:
        first = beyond(third, double)
        ways = []
        for start in (first, third.backwards(first)):
            ways.append([c.parameters[:3] for c in third.walk(start)])
        ways.sort(key=lambda way: np.linalg.norm(_scaled(plane, way[-1] - double.parameters[:3])) if way else 0.0)
        table = np.array([double.parameters[:3], *ways[0][::-1], first.parameters[:3], *ways[1]]).T
        curves.append(_curve(plane, TO_SADDLE, table))
    except RunError as error:
        lost.append(str(error))
    watch("the curve at which both pairs of steady states vanish at once")
    equations = motion.equations(plane.paths, plane.bounds)
    pairs, n = FoldPairs(equations, plane.wider), equations.n
    u = np.concatenate([double.equilibria.ravel(), double.parameters[:3]])
    for way in (1, -1):
        try:
            table = np.array([u[2 * n :], *(p.u[2 * n :] for _, p in pairs.walk(u, way))]).T
            curves.append(_curve(plane, BOTH, table))
        except RunError as error:
            lost.append(f"the curve at which both pairs vanish at once is not followed: {error}")
    return point, [c for c in curves if c is not None]
