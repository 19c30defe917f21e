"""Motions on which members of an ensemble end without coming to rest: each is judged once, then recognised by its orbit.

A member whose motion stays near one of them at last has its outcome. G. Datseris, A. Wagemakers, "Effortless estimation of
basins of attraction", Chaos 32 (2022) 023104.

Attractors of equations (``limit_sets.basins``) are found by the same algorithm; how far the rounds of a motion are apart, and
how near another one must come, is one rule for both. The rest cannot be shared. Which attractors there are must not depend on
the members, whose outcomes do not depend on each other: they are those of a few run-ups of the machine. Members whose
parameters differ have none in common. Whether a member rests is told by its speed and unbalance, without its states, which are
sampled only where there are attractors; and its name is an outcome, which the turns of its motion decide.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from wucht.dynamics.limit_sets.limit_set import gap_of_halves, reach_of
from wucht.dynamics.run_ups.horizon import Horizon
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import Equations, Variants
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.full_classification import member_verdict, model_of, observe_members
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.machines.machine import Machine
from wucht.numerics.ensembles.ensemble import compile_ensemble
from wucht.numerics.ensembles.members import Chunk, Status
from wucht.numerics.flow.compiled_batch import CompiledBatch
from wucht.numerics.zeros_and_peaks import extremes

if TYPE_CHECKING:
    from scipy.spatial import KDTree

_POINTS = 16_384  # on a motion
_CYCLES, _TURNS = 6, 200  # of a modulation, or turns, over which they are spread
_RETURN_DISTANCE = 0.05  # share of the states' sizes: how near a motion must come to itself
_CELL = 1 / 16  # of the reach: of the points of an attractor that are as near to each other one is kept
_PLACES = 20  # of a member, at which it must be near
_ROUNDS = (0, 4, 2, 1, 3)  # in which every fifth place is checked, from this one on: most that are not near fail early
# Of the range of the speed, that a member must go through in less than a period, in more.
_SHORT_RUN_SHARE, _LONG_RUN_SHARE = 0.5, 0.9
_MODULATION_TOLERANCE = 1e-2  # of periods and ranges of speeds: smaller differences of modulations are none
_SPEED_MARGIN = 0.1  # of that range: by so much its speed may leave it
_SURVEY_SIZE = 16  # starts
_MOST_CACHED = 64  # questions
_CACHE: dict[Any, tuple[Attractor, ...]] = {}  # by what determines them in a question: machines are not hashable


@dataclass(frozen=True, eq=False)
class Attractor:
    """A motion that continues without coming to rest.

    Attributes
    ----------
    outcome : int
        Its place in ``tuple(Outcome)``.
    points : numpy.ndarray, (P, d)
        On it, in shares of sizes.
    sizes : numpy.ndarray, (d,)
    reach : float
        How near to its points others must stay.
    sense : int
        +1 or -1, in which the main rotor turns.
    low, high : float
        Of its speed in that sense.
    period : float
        Of its modulation, 0 without one.
    peak_distance_squared : float
        Of the largest distance of the rotor's axis.
    """

    outcome: int
    points: np.ndarray
    sizes: np.ndarray
    reach: float
    sense: int
    low: float
    high: float
    period: float
    peak_distance_squared: float

    @classmethod
    def of(
        cls,
        points: np.ndarray,
        outcome: int,
        sense: int,
        speeds: tuple[float, float],
        period: float,
        peak_distance_squared: float,
    ) -> Self | None:
        """Build the attractor of points (P, d) along a motion, whose least and largest speed in its sense are given.

        None if the halves of the points are far apart: the motion is not yet one that repeats, or has left it again.
        """
        sizes = np.maximum(np.abs(points).max(axis=0), 1e-300)
        gap = gap_of_halves(points / sizes)
        if gap > _RETURN_DISTANCE:
            return None
        reach = reach_of(gap)
        return cls(outcome, _sparse_points(points / sizes, reach), sizes, reach, sense, *speeds, period, peak_distance_squared)

    def resident_members(
        self,
        points_of: Callable[[np.ndarray], np.ndarray],
        samples: np.ndarray,
        speeds: np.ndarray,
        duration: float,
        candidates: np.ndarray,
    ) -> np.ndarray:
        """Return those of the candidates (m,), members by their numbers, that stay near it and move along it: by samples
        (K, v, M) over a duration, of which ``points_of`` makes points, and the least and the largest speed (2, M) in it.
        A member that merely rests near a point of it does not.
        """
        low, high = np.sort(self.sense * speeds[:, candidates], axis=0)
        speed_range, share = self.high - self.low, _LONG_RUN_SHARE if duration >= self.period else _SHORT_RUN_SHARE
        margin = _SPEED_MARGIN * speed_range
        has_same_speeds = (low >= self.low - margin) & (high <= self.high + margin) & (high - low >= share * speed_range)
        members: np.ndarray = candidates[has_same_speeds]
        places = np.linspace(0, len(samples) - 1, _PLACES).astype(int)
        for first in _ROUNDS:
            rows = places[first :: len(_ROUNDS)]
            if len(members):
                members = members[self.is_near(points_of(samples[rows][:, :, members]))]
        return members

    def has_modulation_of(self, candidate: Attractor) -> bool:
        """True if both have a modulation, of the same period and between the same speeds."""
        margin = _MODULATION_TOLERANCE * (self.high - self.low)
        return (
            (self.outcome, self.sense) == (candidate.outcome, candidate.sense)
            and self.period > 0
            and abs(self.period - candidate.period) <= _MODULATION_TOLERANCE * self.period
            and max(abs(self.low - candidate.low), abs(self.high - candidate.high)) <= margin
        )

    def merge(self, candidate: Attractor) -> Attractor:
        """Return the attractor with a candidate's points."""
        sizes = np.maximum(self.sizes, candidate.sizes)
        points = np.concatenate([self.points * self.sizes, candidate.points * candidate.sizes]) / sizes
        reach = max(self.reach, candidate.reach)
        return replace(
            self, points=_sparse_points(points, reach), sizes=sizes, reach=reach, low=min(self.low, candidate.low),
            high=max(self.high, candidate.high),
            peak_distance_squared=max(self.peak_distance_squared, candidate.peak_distance_squared),
        )  # fmt: skip

    @property
    def member_points(self) -> np.ndarray:
        """Its points, as those (P, 1, d) of one member."""
        return np.asarray((self.points * self.sizes)[:, None])

    def is_near(self, points: np.ndarray) -> np.ndarray:
        """Mask (M,) of the members that are near it in all of their points (K, M, d)."""
        distances, _ = self._tree.query(points / self.sizes, distance_upper_bound=self.reach)  # inf beyond
        return np.asarray(np.isfinite(distances).all(axis=0))

    @cached_property
    def _tree(self) -> KDTree:
        from scipy.spatial import KDTree

        return KDTree(self.points)


def attractors_of(question: EnsembleQuestion, equations: Equations, horizon: Horizon) -> tuple[Attractor, ...]:
    """Return the attractors on which run-ups from a few phases of the bodies end, once per question.

    Parameters
    ----------
    question : EnsembleQuestion
    equations : Equations
        Of its members: ``wucht.dynamics.sampling.ensemble_equations.member_equations``.
    horizon : Horizon
        Of a run-up of its machine: ``RunUpCase.of(...).horizon``.

    Returns
    -------
    tuple of Attractor
        Empty if parameters vary, also by schedules, if bodies touch each other, or if all these run-ups come to rest.
    """
    if question.varied_paths or question.machine.tracks or question.machine.schedules:
        return ()
    machine, model = question.machine, (question.model, question.inertia, question.order, question.tolerance, question.longest)
    key = machine.structure, tuple(sorted(machine.values.items())), model
    if key not in _CACHE:
        while len(_CACHE) >= _MOST_CACHED:
            _CACHE.pop(next(iter(_CACHE)))
        _CACHE[key] = _survey_attractors(replace(question, until=None), equations, horizon)
    return _CACHE[key]


def _survey_attractors(question: EnsembleQuestion, equations: Equations, horizon: Horizon) -> tuple[Attractor, ...]:
    attractors, starts = list[Attractor](), _starts(question.machine)
    variants = Variants.from_values(question.machine, {}, starts.shape[1])
    for ends in observe_members(question, starts, variants, horizon, lambda _share: None):
        for state, status, observation in zip(ends.states, ends.status, ends.record.observations, strict=True):
            candidate = (
                None if status == Status.FAILED else _reached_attractor(question, equations, starts[:, 0], state, observation)
            )
            if candidate is not None:
                attractors = _with_candidate(attractors, candidate)
    return tuple(attractors)


def _with_candidate(attractors: list[Attractor], candidate: Attractor) -> list[Attractor]:
    """Add an attractor, or its points to those of the same modulation: from another run they lie between them."""
    for k, attractor in enumerate(attractors):
        if attractor.has_modulation_of(candidate):
            return [*attractors[:k], attractor.merge(candidate), *attractors[k + 1 :]]
        if attractor.outcome == candidate.outcome and attractor.is_near(candidate.member_points).all():
            return attractors
    return [*attractors, candidate]


def _reached_attractor(
    question: EnsembleQuestion, equations: Equations, start: np.ndarray, state: np.ndarray, observation: Observation
) -> Attractor | None:
    """Return the attractor of a member from its final state and observation; None if it is at rest, or on none."""
    machine = question.machine
    verdict = member_verdict(model_of(question, machine, start), observation, state)
    continues = verdict.evidence.is_modulated or verdict.evidence.asynchronous
    if verdict.outcome is Outcome.UNIDENTIFIED or not continues or verdict.assessment is None:
        return None
    cycle, sense, variants = verdict.modulation, verdict.assessment.sense, Variants.from_values(machine, {}, 1)
    period = 0.0 if cycle is None else cycle.period
    duration = _CYCLES * period or _TURNS * 2 * math.pi / verdict.speed
    initial = (
        equations.starts(state[: len(machine.state_names), None], variants)[:, 0] if question.model == "full" else state[:-1]
    )
    quantities = equations.quantities(variants, with_states=True)
    ensemble = compile_ensemble(quantities.system, question.tolerance, quantities=quantities.expressions)
    motion = _motion(ensemble, initial, quantities.parameter_values[0], duration)
    if motion is None:
        return None
    points, speeds = quantities.points(motion.samples)[:, 0], extremes(sense * quantities.speed(motion.samples)[:, 0])
    return Attractor.of(points, OUTCOMES.index(verdict.outcome), sense, speeds, period, float(motion.peaks[0, 0]))


def _starts(machine: Machine) -> np.ndarray:
    """Return states (n, M) with the bodies about the main rotor at evenly spread phases: L. Kronecker's sequence with the
    powers of the largest root of x^(b+1) = x + 1, b being their number."""
    state = initial_state(machine, {})
    body_rows = [machine.row(b.coordinate.position) for b in machine.group(machine.rotor)[1:]]
    if not body_rows:
        return state[:, None]
    b = len(body_rows)
    root = float(np.roots([1.0, *(0.0,) * (b - 1), -1.0, -1.0]).real.max())
    shares = np.outer(np.arange(_SURVEY_SIZE) + 0.5, root ** -np.arange(1.0, b + 1)) % 1
    starts = np.repeat(state[:, None], _SURVEY_SIZE, axis=1)
    starts[body_rows] = state[machine.row(machine.rotor.coordinate.position)] + 2 * math.pi * shares.T
    return starts


def _motion(ensemble: CompiledBatch, state: np.ndarray, parameter_values: np.ndarray, duration: float) -> Chunk | None:
    """Return what is observed from a state (k,) on; None if it cannot be continued."""
    times, (constants, _) = np.linspace(0.0, duration, _POINTS + 1), ensemble.lane_constants(parameter_values[None])
    integrator = ensemble.acquire()
    result = integrator.advance(state[:, None], constants, times)
    ensemble.release(integrator)
    return None if result.failures else Chunk(times[1:], result.values, result.peaks)


def _sparse_points(points: np.ndarray, reach: float) -> np.ndarray:
    """Return one of the points (P, d) in each cell: the nearest of few points is determined several times faster."""
    _, first = np.unique(np.round(points / (_CELL * reach)), axis=0, return_index=True)
    return np.asarray(points[np.sort(first)])
