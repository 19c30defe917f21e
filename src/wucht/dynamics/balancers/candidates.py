"""Evaluation of balancer candidates: many run-ups of each, from the same starts, with unbalances spread over their range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from wucht.analysis.vibration import unbalances
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes
from wucht.dynamics.sampling.searches import Variable, balancer_names, values_at
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES, RESONANCE_PASSED, Outcome
from wucht.dynamics.work import TaskReport, Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body, Drive, Load
from wucht.machines.parts.support import Support
from wucht.machines.parts.track import TrackBody
from wucht.machines.tracks import angular_width, balancing_capacity

_SAME = 1e-9


def with_bodies(machine: Machine, count: int) -> Machine:
    """Return the machine with another number of balancing bodies, each like its first one. Raises ``InputError``."""
    names = balancer_names(machine)
    if count == len(names):
        return machine
    if machine.schedules:
        raise InputError("study.bodies", count, "allowed only for a machine without schedules", code="schedules")
    bodies = [p for p in machine.parts if isinstance(p, Body)]
    first = next(b for b in bodies if b.name == names[0])
    _check_equal(machine, names, count)
    remaining_bodies = [b for b in bodies if b.name not in names]
    if any(b.reference in names for b in remaining_bodies):
        raise InputError(
            "study.bodies", count, "allowed only where nothing turns about the balancing bodies", code="turned-about"
        )
    used_names = {b.name for b in bodies}
    name_candidates = (f"{names[0]}_{i}" for i in range(2, count + len(used_names) + 2))
    new_names = [n for n in name_candidates if n not in used_names][: max(count - len(names), 0)]
    retained_bodies = [b for b in bodies if b.name in names[:count]]
    carrier = next(p for p in machine.parts if isinstance(p, Support))
    resized_machine = Machine(
        carrier,
        [
            *remaining_bodies,
            *map(_without_start, retained_bodies),
            *(_without_start(first.model_copy(update={"name": n})) for n in new_names),
        ],
        [p for p in machine.parts if isinstance(p, Drive)],
        [p for p in machine.parts if isinstance(p, Load)],
        tracks={t.name: {"contact_frequency": t.frequency} for t in machine.tracks if t.is_frequency_given},
        title=machine.title,
    )
    # Values may have been changed after the parts were built.
    known_values = {
        path: value for path, value in machine.values.items() if path in resized_machine.parameters and ".offset" not in path
    }
    known_values |= {f"{n}.{key}": machine.values[f"{names[0]}.{key}"] for n in new_names for key in _keys(machine, names[0])}
    return resized_machine.with_unchecked_values(known_values)


def _without_start(body: Body) -> Body:
    """Return the body without its start position, which depends on the number of bodies."""
    return body.model_copy(update={"start": None}) if isinstance(body, TrackBody) else body


def _keys(machine: Machine, body: str) -> list[str]:
    return [p.removeprefix(f"{body}.") for p in machine.values if p.startswith(f"{body}.")]


def _check_equal(machine: Machine, names: Sequence[str], count: int) -> None:
    """Raise ``InputError`` where the bodies differ: it would be undefined which of them to copy."""
    kinds = {b.name: b.kind for b in machine.bodies}
    for name in names[1:]:
        same = kinds[name] == kinds[names[0]] and _keys(machine, name) == _keys(machine, names[0])
        for key in _keys(machine, names[0]) if same else ():
            a, b = machine.values[f"{names[0]}.{key}"], machine.values[f"{name}.{key}"]
            same = same and abs(a - b) <= _SAME * max(abs(a), abs(b))
        if not same:
            raise InputError(
                "study.bodies",
                count,
                f"allowed only for equal bodies; {name!r} differs from {names[0]!r}",
                code="different-bodies",
            )


SETTLING, RESIDUAL, PEAK, CAPTURE = range(4)  # columns of objectives
_THROUGH, _OPEN = ([OUTCOMES.index(o) for o in outcomes] for outcomes in (RESONANCE_PASSED, OPEN_OUTCOMES))
_FAILURE = OUTCOMES.index(Outcome.FAILED)
_UNIT = 64  # runs: a unit of work, and at least one candidate


@dataclass(frozen=True)
class CandidateResults:
    """Results of P candidates. numbers: values of the variables (P, k). objectives (P, 4): settling time, residual, peak, share
    of captured runs; nan where there is none; runs without a verdict make the settling time a lower and that share an upper
    bound. error: the standard error of the settling time (P,). outcomes: shares of the runs with each of ``OUTCOMES`` (P, o).
    is_allowed (P,): True if the machine's parts allow the candidate. times (P, M): settling times of its runs from the same M
    starts, at least; inf where a run does not pass the resonance, in all runs of a candidate of which one has failed or that
    the parts do not allow. outcome (P, M): of its runs, indices of ``OUTCOMES``."""

    numbers: np.ndarray
    objectives: np.ndarray
    error: np.ndarray
    outcomes: np.ndarray
    is_allowed: np.ndarray
    times: np.ndarray
    outcome: np.ndarray

    @classmethod
    def unknown(cls, count: int, variables: int, samples: int) -> CandidateResults:
        """Return results of so many candidates that are not evaluated: nan."""
        numbers, objectives, outcomes = (np.full((count, n), np.nan) for n in (variables, 4, len(OUTCOMES)))
        error, is_allowed, times = np.full(count, np.nan), np.zeros(count, bool), np.full((count, samples), np.inf)
        return cls(numbers, objectives, error, outcomes, is_allowed, times, np.full((count, samples), _FAILURE, np.int8))

    @classmethod
    def join(cls, parts: Sequence[CandidateResults]) -> CandidateResults:
        """Join the results of several groups of candidates, in order."""
        return cls(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)})

    def pick(self, candidate: int) -> CandidateResults:
        """Return the results of one candidate."""
        return CandidateResults(**{f.name: getattr(self, f.name)[candidate : candidate + 1] for f in fields(self)})

    @property
    def captured_share(self) -> np.ndarray:
        """Share of the runs that certainly do not pass the resonance (P,)."""
        return np.asarray(np.clip(1 - self.outcomes[:, _THROUGH].sum(axis=1) - self.undecided_share, 0.0, 1.0))

    @property
    def undecided_share(self) -> np.ndarray:
        """Share of the runs without a verdict (P,)."""
        return np.asarray(self.outcomes[:, _OPEN].sum(axis=1))


@dataclass(frozen=True)
class BalancerTrials:
    """Evaluation of the candidates of a machine: the variables, the rotor's unbalance, the runs of each.

    unbalance: path of the parameter that is varied from run to run; ends: its least and greatest value. inertia: True if
    averaged equations keep the bodies' inertia. samples: number of runs. seed: of the bodies' phases. start: the rest of the
    start, as in a study file. until: the duration of each run, None until it has settled. order: of averaged equations. stream:
    of the random phases; runs of another one start from other phases.
    """

    machine: Machine
    variables: tuple[Variable, ...]
    unbalance: str
    ends: tuple[float, float]
    inertia: bool
    samples: int
    seed: int
    start: Mapping[str, Any]
    until: float | None
    order: Literal[1, 2]
    tolerance: float
    stream: int = 0

    @property
    def spread(self) -> np.ndarray:
        """Values of the unbalance's parameter (M,) in the runs of a candidate."""
        if self.ends[0] == self.ends[1]:
            return np.full(self.samples, self.ends[0])
        return np.linspace(*self.ends, self.samples)

    @property
    def phases(self) -> np.ndarray:
        """Phases (b, M) of the bodies about the main rotor in the runs of a candidate: the same for all candidates."""
        return phases(self.machine, self.samples, [self.seed, self.stream])

    def question(self, model: Literal["full", "slow"]) -> EnsembleQuestion:
        """Return the ensemble question: the machine, the varied parameters and the model of the runs."""
        paths = tuple(values_at(self.machine, self.variables, [v.low for v in self.variables]))
        varied_paths = tuple(dict.fromkeys((*paths, self.unbalance)))
        return EnsembleQuestion(
            self.machine, varied_paths, model, self.inertia, self.order, self.until, tolerance=self.tolerance
        )

    def starts(self, machine: Machine) -> np.ndarray:
        """Return the states (n, M) in which the runs of a candidate begin."""
        begin, at = initial_state(machine, self.start), self.phases
        starts = np.repeat(begin[:, None], at.shape[1], axis=1)
        rotor = begin[machine.row(machine.rotor.coordinate.position)]
        starts[[machine.row(b.coordinate.position) for b in machine.group(machine.rotor)[1:]]] = rotor + at
        return starts

    def candidate_machine(self, numbers: Sequence[float]) -> Machine:
        """Return the machine of a candidate. Raises ``InputError`` where its parts do not allow it."""
        candidate = self.machine.with_values(values_at(self.machine, self.variables, numbers))
        for track in candidate.tracks:
            if _widths(candidate, [b.name for b in track.bodies]).sum() > 2 * np.pi:
                raise InputError("study.vary", None, f"the bodies of the track {track.name!r} do not fit on it")
        return candidate

    def check_ends(self) -> None:
        """Refuse an end of a range that the parts do not allow, all else unchanged. Raises ``InputError``."""
        for v in self.variables:
            for end in (v.low, v.high):
                try:
                    replace(self, variables=(v,)).candidate_machine([end])
                except InputError as error:
                    raise InputError(f"study.vary.{v.name}", end, error.explanation) from None


def unbalance_parameter(machine: Machine) -> tuple[str, float, float]:
    """Return the path of the parameter of the rotor's unbalance, its value for 1 kg m, and the unbalance in kg m. Raises
    ``InputError``."""
    name, values = machine.rotor.name, machine.values
    if f"{name}.unbalance" in values:
        return f"{name}.unbalance", 1.0, values[f"{name}.unbalance"]
    if f"{name}.eccentricity" in values:
        mass, eccentricity = values[f"{name}.mass"], values[f"{name}.eccentricity"]
        return f"{name}.eccentricity", 1 / mass, eccentricity * mass
    raise InputError("machine.bodies", name, "a main rotor with an unbalance or an eccentricity is required")


def phases(machine: Machine, samples: int, seed: Sequence[int]) -> np.ndarray:
    """Return random phases (b, M) of the bodies about the main rotor, scrambled Sobol' points; without overlap on a track."""
    from scipy.stats import qmc

    names = balancer_names(machine)
    samples_in_cube = (
        qmc.Sobol(len(names), scramble=True, rng=np.random.default_rng(seed)).random(power_of_two(samples))[:samples].T
    )
    angles = 2 * np.pi * samples_in_cube
    for track in machine.tracks:
        track_names = [b.name for b in track.bodies]
        rows, widths = [names.index(n) for n in track_names], _widths(machine, track_names)
        # The place of the first one, and how the remaining space is divided among the gaps.
        gaps = np.sort(samples_in_cube[rows[1:]], axis=0) * (2 * np.pi - widths.sum())
        angles[rows[1:]] = angles[rows[0]] + np.cumsum(widths[:-1])[:, None] + gaps
    return np.asarray(angles)


def power_of_two(count: int) -> int:
    """Return the least power of two that is not below a number: as many Sobol' points fill the space evenly."""
    return 1 << (count - 1).bit_length()


def _widths(machine: Machine, names: Sequence[str]) -> np.ndarray:
    """Return the least angles (n,) between bodies of a track and their successors, in rad."""
    bodies = _track_bodies(machine, names)
    return np.array([angular_width(a, b) for a, b in zip(bodies, [*bodies[1:], bodies[0]], strict=True)])


def _track_bodies(machine: Machine, names: Sequence[str]) -> list[TrackBody]:
    """Return those of the named bodies that are on tracks, with the machine's values."""
    parts = {b.name: b for t in machine.tracks for b in t.bodies}
    bodies = []
    for n in (n for n in names if n in parts):
        parameters = {p.path: p for p in parts[n].parameters()}
        changed_values = {
            path.removeprefix(f"{n}."): machine.values[path]
            for path in parameters
            if machine.values[path] != parameters[path].value
        }
        bodies.append(parts[n].model_copy(update=changed_values))
    return bodies


def least_residual(machine: Machine) -> float:
    """Return the least unbalance that the bodies can leave: the force polygon with the rotor's is closed as far as possible.

    Bodies of a track lie side by side at the closest.
    """
    names = [b.name for b in machine.group(machine.rotor)]
    magnitudes = np.abs(unbalances(machine)[[machine.bodies.index(machine.body(n)) for n in names]])
    moments = dict(zip(names[1:], magnitudes[1:].tolist(), strict=True))
    capacity = balancing_capacity(moments, _track_bodies(machine, names[1:]))
    remainder = max(float(2 * magnitudes.max() - magnitudes.sum()), float(magnitudes[0]) - capacity)
    return remainder if remainder > 1e-9 * magnitudes.sum() else 0.0


def units_of_work(candidates: int, samples: int) -> int:
    """Return the number of units of work in which candidates with so many runs each are evaluated."""
    return -(-candidates // candidates_a_unit(samples))


def candidates_a_unit(samples: int) -> int:
    """Return the number of candidates, with so many runs each, of a unit of work."""
    return max(1, _UNIT // samples)


def evaluate_candidates(
    trials: BalancerTrials, model: Literal["full", "slow"], numbers: np.ndarray, work: Work, label: str
) -> CandidateResults:
    """Evaluate candidates (P, k) of the variables, several as one unit of work. label: of the candidates, for the progress."""
    size = candidates_a_unit(trials.samples)
    parts = {f"candidate {first}": numbers[first : first + size] for first in range(0, len(numbers), size)}
    results = dict(work.units({name: partial(evaluate_batch, trials, model, rows) for name, rows in parts.items()}, label))
    return CandidateResults.join([results[name] for name in parts])


def evaluate_batch(
    trials: BalancerTrials, model: Literal["full", "slow"], numbers: np.ndarray, report: TaskReport
) -> CandidateResults:
    """Evaluate candidates (P, k) of the variables in one ensemble of runs."""
    unknown = CandidateResults.unknown(len(numbers), numbers.shape[1], trials.samples)
    results = replace(unknown, numbers=numbers, outcomes=np.zeros_like(unknown.outcomes))
    for i, machine, runs in _runs_of_candidates(trials, model, numbers, report):
        results.is_allowed[i], results.outcome[i] = True, runs.outcome
        residual = max(least_residual(machine.with_values({trials.unbalance: end})) for end in trials.ends)
        shares = results.outcomes[i] = np.bincount(runs.outcome, minlength=len(OUTCOMES)) / trials.samples
        settling, results.error[i] = _median_settling(runs)
        has_failed = bool((runs.outcome == _FAILURE).any())
        results.times[i] = np.inf if has_failed else _settling_times(runs)
        peak = np.nan if has_failed else float(runs.peak_amplitude.max())
        results.objectives[i] = settling, residual, peak, 1 - shares[_THROUGH].sum()
    return results


def _runs_of_candidates(
    trials: BalancerTrials, model: Literal["full", "slow"], numbers: np.ndarray, report: TaskReport
) -> list[tuple[int, Machine, MemberOutcomes]]:
    """Return index, machine and runs of each candidate (P, k) that the machine's parts allow."""
    m = trials.samples
    feasible = list[tuple[int, Machine]]()
    for i, row in enumerate(numbers.tolist()):
        with suppress(InputError):
            feasible.append((i, trials.candidate_machine(row)))
    if not feasible:
        return []
    starts = np.concatenate([trials.starts(machine) for _, machine in feasible], axis=1)
    question = trials.question(model)
    machine_values = [machine.values for _, machine in feasible]
    values = {p: np.repeat([v[p] for v in machine_values], m) for p in question.varied_paths if p != trials.unbalance}
    values[trials.unbalance] = np.tile(trials.spread, len(feasible))
    ensemble = outcomes_of(question, starts, values, report)
    return [(i, machine, ensemble.select(np.arange(k * m, (k + 1) * m))) for k, (i, machine) in enumerate(feasible)]


def _median_settling(runs: MemberOutcomes) -> tuple[float, float]:
    """Return the median settling time and its standard error; nan where fewer than half of the runs settle, or one has failed.

    The mean over the runs that pass would favour a candidate of which one quick run passes and all others are captured. A run
    without a verdict takes at least as long as it was followed.
    """
    if (runs.outcome == _FAILURE).any():
        return np.nan, np.nan
    times = _settling_times(runs)
    half, relevant = float(np.median(times)), np.isfinite(times)
    if not np.isin(runs.outcome, _THROUGH).any() or np.isinf(half):
        return np.nan, np.nan
    return half, float(np.sqrt(np.pi / 2) * times[relevant].std() / np.sqrt(relevant.sum()))  # of the median of a normal sample


def _settling_times(runs: MemberOutcomes) -> np.ndarray:
    """Return the settling time of each run, that of its end without a verdict; inf where it does not pass the resonance."""
    times = np.where(np.isnan(runs.settling_time), runs.end_time, runs.settling_time)
    return np.where(np.isin(runs.outcome, _THROUGH + _OPEN), times, np.inf)
