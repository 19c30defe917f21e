"""The set that a motion tends to, and the distances by which another motion is recognised as being on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
import sympy as sp

from wucht.dynamics.verdicts.outcomes import LabelWithSentence
from wucht.errors import WuchtError
from wucht.machines.subject import Subject
from wucht.numerics.lyapunov import LyapunovExponent
from wucht.system import TIME, System, needed_definitions

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_WHOLE_MULTIPLES = 1e-9  # relative: frequencies that are multiples of one to this accuracy
_LARGEST_MULTIPLE = 64
_TIGHT = 1e-3  # of the states' sizes: an equilibrium or an orbit that is known to rounding is met as near as this
_SAME_POINT = 1e-6  # likewise: two equilibria that are nearer are one
_LOOSE = 2.0  # times the gap
_NEIGHBOURS = 0.95  # share of samples, of a set that is known by samples only


class MotionKind(LabelWithSentence):
    """What a motion tends to: its label as text, such as ``"periodic"``, with its ``sentence``."""

    EQUILIBRIUM = "equilibrium", "the motion tends to an equilibrium"
    PERIODIC = "periodic", "the motion tends to a periodic orbit"
    QUASI_PERIODIC = "quasi-periodic", "the motion covers a torus"
    CHAOTIC = "chaotic", "nearby motions separate exponentially"
    DIVERGES = "diverges", "the motion grows beyond all bounds"
    NOT_SETTLED = "unsettled", "the run is too short to tell what the motion tends to"
    UNKNOWN = "unidentified", "what the motion tends to is not told: its rates are those of a Python function without formulas"
    FAILED = "failed", "the run failed"


@dataclass(frozen=True)
class StateMetric:
    """Distances between states: relative to the size of each, angles on the circle, the time as a phase of the forcing.

    Attributes
    ----------
    sizes : ndarray, (n,)
        1 of an angle.
    turning : ndarray of bool, (n,)
        True for angles.
    frequency : float
        Of the forcing, 0 where the equations do not depend on time.
    """

    sizes: np.ndarray
    turning: np.ndarray
    frequency: float

    @classmethod
    def of(cls, subject: Subject, extents: np.ndarray) -> Self:
        """Build the metric of equations from the extent (n,) of the motion in each state."""
        turning = np.array(subject.system.is_angle)
        largest = float(np.where(turning, 0.0, extents).max(initial=0.0)) or 1.0
        sizes = np.where(turning, 1.0, np.where(extents > 0, extents, largest))
        period = forcing_period(subject.system, subject.values)
        return cls(sizes, turning, 2 * math.pi / period if period else 0.0)

    def points(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Embed states (n, ...) at times (...) as points (..., d)."""
        columns = [x / size for x, size, turns in zip(states, self.sizes, self.turning, strict=True) if not turns]
        columns += [f(x) for x, turns in zip(states, self.turning, strict=True) if turns for f in (np.cos, np.sin)]
        if self.frequency:
            columns += [f(self.frequency * np.broadcast_to(times, states.shape[1:])) for f in (np.cos, np.sin)]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True, eq=False)
class LimitSet:
    """The set that a motion tends to.

    Attributes
    ----------
    kind : MotionKind
        EQUILIBRIUM, PERIODIC, QUASI_PERIODIC or CHAOTIC.
    times : ndarray, (P,)
    states : ndarray, (n, P)
        Samples of the motion on it; angles are not wrapped.
    attracts : bool or None
        Whether nearby motions tend to it, None where a disturbance neither grows nor decays, or where it is not known, as of
        chaotic sets and tori.
    period : float
        Of a periodic orbit, else 0.
    turns : ndarray of int, (n,)
        Of angles in a period.
    multipliers : ndarray of complex, (k,)
        Of a periodic orbit, without that of its phase; empty where they are not known.
    eigenvalues : ndarray of complex, (k,)
        Of an equilibrium; empty where the equations depend on time.
    exponent : LyapunovExponent, optional
        The largest one, of a motion that is neither at rest nor periodic.
    gap : float
        How far the samples are from each other, relative to the sizes of the states: of an orbit half the largest distance of
        neighbours, of a set that is known by samples only the distance of its halves.
    """

    kind: MotionKind
    times: np.ndarray
    states: np.ndarray
    metric: StateMetric
    attracts: bool | None
    period: float = 0.0
    turns: np.ndarray | None = None
    multipliers: np.ndarray | None = None
    eigenvalues: np.ndarray | None = None
    exponent: LyapunovExponent | None = None
    gap: float = 0.0

    @property
    def has_eigenvalues(self) -> bool:
        """True of an equilibrium of equations that do not depend on time: its state is exact."""
        return self.eigenvalues is not None and len(self.eigenvalues) > 0

    @property
    def has_basin(self) -> bool:
        """True if motions from a volume of starts come near to it and stay, or nothing contradicts that."""
        rest_of_forced_equations = self.kind is MotionKind.EQUILIBRIUM and not self.has_eigenvalues
        return bool(self.attracts) or self.exponent is not None or rest_of_forced_equations

    @property
    def low(self) -> np.ndarray:
        """The least value of each state (n,)."""
        return np.asarray(self.states.min(axis=1))

    @property
    def high(self) -> np.ndarray:
        """The largest value of each state (n,)."""
        return np.asarray(self.states.max(axis=1))

    @property
    def mean(self) -> np.ndarray:
        """The mean value of each state (n,)."""
        return np.asarray(self.states.mean(axis=1))

    def samples(self, most: int) -> tuple[np.ndarray, np.ndarray]:
        """Return times (K,) and states (n, K) of so many samples at most.

        Of an orbit they are spread over its period; of a chaotic set or a torus they are those of the first stretch, so that
        the motion can be followed from one to the next.
        """
        if self.exponent is not None:
            return self.times[:most], self.states[:, :most]
        stride = max(1, -(-len(self.times) // most))
        return self.times[::stride], self.states[:, ::stride]

    @cached_property
    def reach(self) -> float:
        """How near to its samples another motion must be."""
        return reach_of(self.gap)

    @cached_property
    def _tree(self) -> KDTree:
        from scipy.spatial import KDTree

        return KDTree(self.metric.points(self.times, self.states))

    def distances(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the distances (...) of states (n, ...) at times (...) from its nearest samples, relative to the sizes."""
        nearby = self.metric.points(times, states)
        return np.asarray(self._tree.query(nearby)[0])

    def holds(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """True (L,) for motions with states (n, K, L) at times (K,) that are on it: near to it at nearly all of them, and,
        where it has an extent, with half of that extent.
        """
        near = self.distances(times[:, None], states) <= self.reach
        share = 1.0 if self.kind in (MotionKind.EQUILIBRIUM, MotionKind.PERIODIC) else _NEIGHBOURS
        extent = np.ptp(self.states, axis=1) / self.metric.sizes
        widest = int(extent.argmax())
        moves = np.ptp(states[widest], axis=0) / self.metric.sizes[widest] >= extent[widest] / 2
        return np.asarray((near.mean(axis=0) >= share) & (moves if extent[widest] > self.reach else True))

    def is_same(self, second: LimitSet) -> bool:
        """True if another limit set is this one."""
        if self.kind != second.kind:
            return False
        if self.has_eigenvalues and second.has_eigenvalues:
            return bool(self.distances(second.times, second.states).max() <= _SAME_POINT)
        reach = max(self.reach, second.reach)
        pairs = ((self, second), (second, self))
        return all((a.distances(b.times, b.states) <= reach).mean() >= _NEIGHBOURS for a, b in pairs)


def gap_of_halves(points: np.ndarray, share: float = 1.0) -> float:
    """Return by how much the halves of points (P, d) along a motion are apart: such a share of each are as near."""
    from scipy.spatial import KDTree

    first, second = np.array_split(points, 2)
    return max(float(np.quantile(KDTree(a).query(b)[0], share)) for a, b in ((first, second), (second, first)))


def reach_of(gap: float) -> float:
    """Return how near to samples of a motion another one must be to be on the same set, by how far these are apart."""
    return max(_TIGHT, _LOOSE * gap)


def forcing_period(system: System, values: dict[str, float] | object) -> float | None:
    """Return the period with which the equations depend on time; None if they do not, or not by sines of multiples of it.

    Parameters
    ----------
    system : System
    values : mapping of str to float
        Of its parameters.
    """
    if not system.depends_on_time:
        return None
    numbers = dict(zip(system.parameters, system.values(values), strict=True))  # type: ignore[arg-type]
    rates = [sp.sympify(d) for d in system.derivatives]
    expressions = [*rates, *(e for _, e in needed_definitions(system.definitions, rates))]
    frequencies = set[float]()
    for expression in map(system.explicit, expressions):
        arguments = {f for f in expression.atoms(sp.sin, sp.cos) if TIME in f.free_symbols}
        frozen = expression.xreplace({f: sp.Dummy() for f in arguments})
        if TIME in frozen.free_symbols:
            return None
        for argument in (f.args[0] for f in arguments):
            slope = sp.sympify(sp.diff(argument, TIME).xreplace(numbers))
            if not slope.is_number:
                return None
            frequencies.add(abs(float(slope)))
    frequencies -= {0.0}
    return 2 * math.pi / _common_divisor(sorted(frequencies)) if frequencies else None


def whole_periods(subject: Subject, duration: float) -> float:
    """Return the least number of whole periods of the forcing that lasts at least this long; the duration without one."""
    period = forcing_period(subject.system, subject.values)
    return math.ceil(duration / period) * period if period else duration


def _common_divisor(frequencies: list[float]) -> float:
    """Return the largest frequency of which all others are multiples. Raises ``WuchtError`` if there is none."""
    for parts in range(1, _LARGEST_MULTIPLE + 1):
        base = frequencies[0] / parts
        if all(abs(f / base - round(f / base)) <= _WHOLE_MULTIPLES * f / base for f in frequencies):
            return base
    raise WuchtError("the equations depend on time with several frequencies that have no common period", code="frequencies")
