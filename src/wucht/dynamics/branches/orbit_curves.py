"""Curves in the plane on which a modulated motion turns, doubles, loses its stability, or becomes a saddle connection."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_branches import StoredOrbit, cycles_through
from wucht.dynamics.branches.orbit_endings import OrbitEnd, connections_at
from wucht.dynamics.branches.second_parameter import SecondParameter
from wucht.dynamics.branches.state_rows import OrbitRow
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_curves import CycleCurve
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.zeros import at_passages

_LONGEST = 8.0  # times the period of the orbit with which a curve begins
_POINTS = 401  # each way
_SAME = 1e-3  # of the range


@dataclass(frozen=True)
class OrbitCurve:
    """kind: of the special orbits. x, y (N,): both parameters."""

    kind: str
    x: np.ndarray
    y: np.ndarray

    def passes(self, x: float, y: float, near: float) -> bool:
        """Whether it passes a place, but for so much of the first parameter."""
        return bool((np.abs(at_passages(self.y, y, self.x)[1] - x) < near).any())

    def ends_before(self, x: float, y: float, near: tuple[float, float]) -> bool:
        """Whether one of its ends lies so near to a place, in both parameters, before it."""
        k = int(np.abs(self.y - y).argmin())
        return bool(k in (0, len(self.y) - 1) and 0 < abs(self.y[k] - y) < near[1] and abs(self.x[k] - x) < near[0])


def orbit_curve(motion: ModulatedMotion, second: SecondParameter, row: OrbitRow, special: StoredOrbit) -> OrbitCurve:
    """The curve through a special orbit of a row, both ways. motion: at the row. Raises ``WuchtError`` where there is none."""
    subject, seed = motion.whole, row.whole
    paths, bounds = (subject.path, second.path), (subject.bounds, second.bounds)
    widths = {p: b[1] - b[0] for p, b in zip(paths, bounds, strict=True)}
    sizes = dict(zip(subject.system.state_names, seed.scale[:-1].tolist(), strict=True)) | widths
    longest = _LONGEST * special.period
    at = _located(*cycles_through(subject, replace(seed, longest=longest)), special)
    of = CycleCurve.of(
        special.kind, subject.system, paths, subject.fixed_beside(*paths), bounds,
        winding=subject.turns(seed.winding), scale=sizes, periods=(0.0, longest),
    )  # fmt: skip
    return _both_ways(special.kind, of, of.start(at, row.second))


def _located(cycles: Cycles, start: Cycle, special: StoredOrbit) -> Cycle:
    """The special orbit, once more on the branch of another one. Raises ``RunError``."""
    for cycle in cycles.walk(start if special.value > start.parameter else cycles.backwards(start)):
        if cycle.kind == special.kind and abs(cycle.parameter - special.value) < _SAME * (cycles.bounds[1] - cycles.bounds[0]):
            return cycle
    raise RunError("the special orbit was not found again")


def _both_ways(kind: str, of: Any, start: Any) -> OrbitCurve:
    """The curve through a point of a ``CycleCurve``, or of ``Connections``."""
    back, onward = ([p.parameters[:2] for p in islice(of.walk(first), _POINTS)] for first in (of.backwards(start), start))
    x, y = np.array([*back[::-1], start.parameters[:2], *onward], float).T
    return OrbitCurve(kind, x, y)


def connection_curve(motion: ModulatedMotion, second: SecondParameter, row: OrbitRow, end: OrbitEnd) -> OrbitCurve:
    """The curve of saddle connections through the end of a row, both ways. Raises ``WuchtError`` where there is none."""
    return _both_ways(SADDLE_CONNECTION, *connections_at(motion, second.path, second.bounds, end, row.second))
