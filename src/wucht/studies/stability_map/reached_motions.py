"""What runs of the averaged equations come to from several starts, at places of the plane: as a user would seek motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.numerics.flow.program import Evaluator
from wucht.studies.orbit_branch.first_orbits import SeedOrbit, orbit_near, times_of_change
from wucht.studies.orbit_branch.orbit_subject import OrbitSubject
from wucht.studies.stability_map.mapped_motion import MappedMotion

_STARTS = 6  # at each place: that of the study, and others spread evenly over the states' ranges
_BESIDE = 1e-3  # of the ranges of the starts
_SAME = 1e-3  # relative: periods of one orbit


@dataclass(frozen=True)
class ReachedMotions:
    """Of the runs at a place (x, y): how many there were, and how many came to rest in a steady state.

    orbits: those on which others settled, each once. unsettled: how many did neither.
    """

    x: float
    y: float
    runs: int
    steady: int
    orbits: tuple[SeedOrbit, ...]
    unsettled: int


def reached_motions(
    motion: MappedMotion,
    path: str,
    bounds: tuple[float, float],
    values: Sequence[float],
    second: float,
    watch: Callable[[], None],
) -> tuple[ReachedMotions, ...]:
    """What runs come to at values of the first parameter (``path``, with bounds). motion: at the value of the second one."""
    subject = motion.whole or motion.subject
    return tuple(_at(subject, motion.starts(_STARTS - 1), bounds, value, second, watch) for value in values)


def _at(
    subject: OrbitSubject, spread: np.ndarray, bounds: tuple[float, float], value: float, second: float,
    watch: Callable[[], None],
) -> ReachedMotions:  # fmt: skip
    rates, parameters = Evaluator.of_rates(subject.system), subject.system.values({**subject.values, subject.path: value})
    span = times_of_change(rates, parameters)
    beside = _BESIDE * np.ptp(spread, axis=0)  # the start of the study may be an unstable steady state
    starts = [np.asarray(subject.initial(value), float) + beside, *spread]
    steady, unsettled, orbits = 0, 0, list[SeedOrbit]()
    for start in starts:
        tried = orbit_near(subject, bounds, value, start, span, watch)
        steady, unsettled = steady + tried.rests, unsettled + (tried.orbit is None and not tried.rests)
        if tried.orbit is not None and not any(alike(tried.orbit, other) for other in orbits):
            orbits.append(tried.orbit)
    return ReachedMotions(value, second, len(starts), steady, tuple(orbits), unsettled)


def alike(a: SeedOrbit, b: SeedOrbit) -> bool:
    """Whether two orbits at one place are one: of the same winding and period."""
    return bool((a.winding == b.winding).all()) and abs(a.period - b.period) <= _SAME * b.period
