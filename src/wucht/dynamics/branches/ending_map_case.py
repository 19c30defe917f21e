"""Plane of two parameters in which the end of the modulated motion is mapped as a third one changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.plane_regions import Bounds, Range, cell_centres
from wucht.dynamics.branches.steady_states import Labels
from wucht.machines.subject import Subject

_ROOM = 0.5  # of the ranges: how far beyond the plane curves are followed where that leads to the next one


@dataclass(frozen=True, eq=False)
class EndingMapCase:
    """Plane in which the end of the modulated motion is mapped as a third parameter changes.

    paths, ranges: of that third parameter, which is eliminated, and of both parameters of the plane. motion: along the third
    one. cells: per side, examined at their centres. labels: of the steady states.
    """

    paths: tuple[str, str, str]
    ranges: tuple[Range, Range, Range]
    motion: ModulatedMotion
    cells: int
    labels: Labels

    @classmethod
    def of(
        cls, subject: Subject, paths: tuple[str, str, str], ranges: tuple[Range, Range, Range], cells: int,
        together: bool = False, ranges_of_states: Mapping[str, Range] | None = None, inertia: bool | None = None,
    ) -> EndingMapCase:  # fmt: skip
        """Set up the plane of a machine, or of user equations. together, ranges_of_states, inertia: see ``ModulatedMotion.of``.

        Raises ``InputError`` where one of them does not fit the subject, or it has no averaged equations.
        """
        third, along, second = paths
        middle = subject.with_values({second: sum(ranges[2]) / 2})
        steady_states = BranchCase.of(middle, along, ranges[1], ranges=ranges_of_states, inertia=inertia).steady_states
        motion = ModulatedMotion.of(subject, third, ranges[0], steady_states, together, ranges_of_states, inertia)
        motion.refuse_idle({"along": along, "second": second, "eliminate": third})
        return cls(paths, ranges, motion, cells, steady_states.labels)

    @property
    def bounds(self) -> Bounds:
        """Bounds of both parameters of the plane."""
        return self.ranges[1], self.ranges[2]

    @property
    def centres(self) -> list[tuple[float, float]]:
        """Centres of all cells, row by row."""
        across, up = (cell_centres(bounds, self.cells).tolist() for bounds in self.bounds)
        return [(x, y) for y in up for x in across]

    @property
    def wider_ranges(self) -> tuple[Range, Range, Range]:
        """Ranges, those of the plane with a margin, on the same side of zero."""

        def wide(low: float, high: float) -> Range:
            room = _ROOM * (high - low)
            return (max(low - room, low / 10) if low > 0 else low - room, high + room)

        return (self.ranges[0], wide(*self.ranges[1]), wide(*self.ranges[2]))

    def motion_at(self, x: float, y: float) -> ModulatedMotion:
        """Return the motion at a place of the plane."""
        return self.motion.with_values(dict(zip(self.paths[1:], (x, y), strict=True)))

    def contains(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return a mask of the points that lie in the plane."""
        (x0, x1), (y0, y1) = self.bounds
        return np.asarray((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
