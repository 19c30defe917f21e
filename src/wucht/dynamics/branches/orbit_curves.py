"""Curves in the plane on which a modulated motion turns, doubles, loses its stability, or becomes a saddle connection."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.branches.first_orbits import cycles_of
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_branches import StoredOrbit, first_cycle
from wucht.dynamics.branches.orbit_endings import connections_of, enough
from wucht.dynamics.branches.state_rows import OrbitRow, OrbitSide
from wucht.errors import RunError, WuchtError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION
from wucht.numerics.periodic.connection_starts import of_cycle
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_curves import CycleCurve
from wucht.numerics.periodic.cycles import Cycles

_LONGEST = 8.0  # times the period of the orbit with which a curve begins
_POINTS = 400
_SAME = 1e-3  # of the range

Bounds = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class OrbitCurve:
    """kind: of the special orbits. x, y (N,): both parameters. ends: why it ends."""

    kind: str
    x: np.ndarray
    y: np.ndarray
    ends: tuple[str, str]


def orbit_curve(
    motion: ModulatedMotion, paths: tuple[str, str], bounds: Bounds, row: OrbitRow, special: StoredOrbit
) -> OrbitCurve | str:
    """The curve through a special orbit of a row, both ways; or why there is none. motion: at the row."""
    subject = motion.whole or motion.subject
    s, seed = subject.system, row.whole
    cycles = cycles_of(replace(subject, path=paths[0]), bounds[0], seed.winding, seed.scale, _LONGEST * special.period)
    widths = {p: b[1] - b[0] for p, b in zip(paths, bounds, strict=True)}
    sizes = dict(zip(s.state_names, seed.scale[:-1].tolist(), strict=True)) | widths
    fixed = {n: subject.values[n] for n in s.parameter_names if n not in paths}
    winding = {n: int(w) for n, w in zip(s.state_names, seed.winding, strict=True) if w}
    try:
        at = _located(cycles, row, special)
        of = CycleCurve.of(
            special.kind, s, paths, fixed, bounds, winding=winding, scale=sizes, periods=(0.0, _LONGEST * special.period)
        )
        start = of.start(at, row.second)
        return _both_ways(special.kind, of, start)
    except WuchtError as error:
        return str(error)


def _located(cycles: Cycles, row: OrbitRow, special: StoredOrbit) -> Cycle:
    """The special orbit, found again on its branch. Raises ``RunError``."""
    seed = row.whole
    start = first_cycle(cycles, seed)
    for cycle in cycles.walk(start if special.value > row.whole.value else cycles.backwards(start)):
        if cycle.kind == special.kind and abs(cycle.parameter - special.value) < _SAME * (cycles.bounds[1] - cycles.bounds[0]):
            return cycle
    raise RunError("the special orbit was not found again")


def _both_ways(kind: str, of: object, start: object) -> OrbitCurve:
    ways, ends = list[list[tuple[float, float]]](), list[str]()
    for first in (of.backwards(start), start):  # type: ignore[attr-defined]
        walk = of.walk(first)  # type: ignore[attr-defined]
        points = list[tuple[float, float]]()
        for point in walk:
            points.append((float(point.parameters[0]), float(point.parameters[1])))
            if len(points) > _POINTS:
                break
        ways.append(points)
        ends.append(walk.end or "it has as many points as are followed")
    first_point = (float(start.parameters[0]), float(start.parameters[1]))  # type: ignore[attr-defined]
    x, y = np.array([*ways[0][::-1], first_point, *ways[1]]).T
    return OrbitCurve(kind, x, y, (ends[0], ends[1]))


def connection_curve(
    motion: ModulatedMotion, paths: tuple[str, str], bounds: Bounds, row: OrbitRow, side: OrbitSide
) -> OrbitCurve | str:
    """The curve of saddle connections through the end of a row, both ways; or why there is none."""
    seed = side.last
    cycles = cycles_of(replace(motion.subject, path=paths[0]), bounds[0], seed.winding, seed.scale, seed.longest)
    try:
        cycle = first_cycle(cycles, seed)
        problem = motion.equilibria(paths[0], bounds[0])
        rates = problem.seen(problem.start(side.equilibrium, side.value)).eigenvalues
        of = connections_of(motion, paths, bounds, enough(cycle.period, rates), seed.winding)
        start = of_cycle(of, cycle, side.equilibrium, np.array([cycle.parameter, row.second]))
        return _both_ways(SADDLE_CONNECTION, of, start)
    except WuchtError as error:
        return str(error)
