"""Loads of rotors' bearings over a run-up: at its end, and over the revolutions of a part of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.analysis.bearing_forces import BearingForces, bearing_ratings
from wucht.analysis.throw import largest_of
from wucht.dynamics.verdicts.noise import Noise
from wucht.fatigue.bearing_life import HEAVY, BearingDuty, BearingRating, mean_over_time
from wucht.machines.machine import Machine
from wucht.numerics.flow.trajectory import Trajectory

Duties = Mapping[str, BearingDuty]
_FEWEST = 8  # samples in the window


@dataclass(frozen=True)
class BearingLoad:
    """The force of a rotor on its bearing, in N.

    steady: mean of its magnitude in the last window. vector: mean of its components in x and y there. largest: there. peak: of
    the whole run.
    """

    steady: float
    vector: tuple[float, float]
    largest: float
    peak: float

    def beyond(self, noise: Noise) -> BearingLoad:
        """The load, its numbers zero where they are noise beside the largest force of the run."""
        steady, mean, largest = (noise.without(f, self.peak) for f in (self.steady, math.hypot(*self.vector), self.largest))
        return BearingLoad(steady, self.vector if mean else (0.0, 0.0), largest, self.peak)


@dataclass(frozen=True)
class BearingLife:
    """The life of a rotor's bearing after ISO 281.

    load: the equivalent load in N, None of a bearing that does not turn. hours: None of one that does not turn, or without
    load. rating: C in N.
    """

    load: float | None
    hours: float | None
    rating: float

    @property
    def heavy(self) -> bool:
        """True if the load is beyond what ISO 281 covers without the manufacturer."""
        return self.load is not None and self.load > HEAVY * self.rating


def has_bearing_forces(machine: Machine) -> bool:
    """True for a machine with units whose rotors' forces lie in the plane of the model: none has a couple unbalance."""
    return not machine.dimensionless and machine.frame.tilt == 0


@dataclass(frozen=True)
class DutyObserver:
    """Observer of the duties of a machine's rated bearings between two times.

    ratings, shares: by rotor, the latter of its force that the bearing takes. forces: of these rotors.
    """

    ratings: Mapping[str, BearingRating]
    shares: Mapping[str, float]
    forces: BearingForces
    begin_time: float
    end_time: float

    @classmethod
    def of(cls, machine: Machine, begin: float, end: float = math.inf) -> DutyObserver | None:
        """Return the observer; None of a machine whose bearings have no rating."""
        if not (ratings := bearing_ratings(machine)):
            return None
        shares = {name: machine.values[f"{name}.bearing.share"] for name in ratings}
        return cls(ratings, shares, BearingForces.of(machine, tuple(ratings)), begin, end)

    def begin(self) -> dict[str, BearingDuty]:
        """Return the duties before the motion."""
        return {n: BearingDuty(rating.p, self.begin_time, self.end_time) for n, rating in self.ratings.items()}

    def update(self, previous: Duties, motion: Trajectory) -> dict[str, BearingDuty]:
        """Return the duties after a further part of the motion, which begins with the last sample of the one before."""
        forces, speeds = self.forces(motion)
        return {
            name: duty.update(motion.time, self.shares[name] * np.hypot(*forces[name]), speeds[name])
            for name, duty in previous.items()
        }


def lives_of(machine: Machine, duties: Duties) -> dict[str, BearingLife]:
    """Return the life of each rated bearing in a motion that is repeated over and over."""
    ratings = bearing_ratings(machine)
    return {n: BearingLife(duty.equivalent_load, duty.life(ratings[n]), ratings[n].C) for n, duty in duties.items()}


def lives_at_end(machine: Machine, motion: Trajectory, window: tuple[float, float]) -> dict[str, BearingLife]:
    """Return the life of each rated bearing if the machine runs on as in the last window of a run."""
    observer = DutyObserver.of(machine, *window)
    return {} if observer is None else lives_of(machine, observer.update(observer.begin(), motion))


def loads_at_end(machine: Machine, motion: Trajectory, window: tuple[float, float]) -> dict[str, BearingLoad]:
    """Return the load of each rotor's bearing at the end of a run. window: its last one, in which the mean is taken.

    Empty without forces in the plane, and for a window of few samples.
    """
    inside = (motion.time >= window[0]) & (motion.time <= window[1])
    if not has_bearing_forces(machine) or np.count_nonzero(inside) < _FEWEST:
        return {}
    forces, _ = BearingForces.of(machine)(motion)

    def mean(values: np.ndarray) -> float:
        return mean_over_time(motion.time, values, *window)

    return {
        name: BearingLoad(mean(np.hypot(*f)), (mean(f[0]), mean(f[1])), largest_of(f[:, inside]), largest_of(f))
        for name, f in forces.items()
    }


def bearing_warnings(lives: Mapping[str, BearingLife]) -> list[str]:
    """Return a warning of the bearings that make no turn, and for each whose load is beyond what ISO 281 covers."""
    still = [repr(name) for name, life in lives.items() if life.load is None]
    no_life = f"no bearing life of {', '.join(still)}: {'it makes' if len(still) == 1 else 'they make'} no full turn"
    return [
        *([no_life] if still else []),
        *heavy_load_warnings(lives),
    ]


def heavy_load_warnings(lives: Mapping[str, BearingLife]) -> list[str]:
    """Return a warning for each bearing whose load is beyond what ISO 281 covers."""
    return [
        f"the equivalent load of the bearing of {name!r}, {life.load:.4g} N, is more than half of its rating C = "
        f"{life.rating:.4g} N: ISO 281 does not cover it; choose a larger bearing or consult its manufacturer"
        for name, life in lives.items()
        if life.heavy
    ]
