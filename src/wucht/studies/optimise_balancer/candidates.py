"""What candidates are worth: many run-ups of each, from the same starts, with unbalances spread over their range."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wucht.analysis.vibration import unbalances
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.tracks import angular_width
from wucht.results.outcomes import Outcome
from wucht.studies.ensembles.ensemble_question import EnsembleQuestion
from wucht.studies.ensembles.ensemble_run import outcomes_of
from wucht.studies.ensembles.member_outcomes import OUTCOMES
from wucht.studies.initial_state import initial_state
from wucht.studies.optimise_balancer.balancer_variables import Variable, balancing, values_at

WELL = (Outcome.COMPENSATED, Outcome.PASSED)
CAPTURED = (Outcome.CAPTURED, Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED)


@dataclass(frozen=True)
class Evaluated:
    """P candidates. numbers: the values of the variables (P, k). objectives (P, 4), in the order of ``spec.OBJECTIVES``, nan
    where there is none. outcomes: shares of the runs with each of ``OUTCOMES`` (P, o). allowed (P,): whether the machine's
    parts allow it."""

    numbers: np.ndarray
    objectives: np.ndarray
    outcomes: np.ndarray
    allowed: np.ndarray

    @property
    def captured(self) -> np.ndarray:
        """The share of the runs that are captured (P,)."""
        return np.asarray(self.outcomes[:, [OUTCOMES.index(o) for o in CAPTURED]].sum(axis=1))

    @property
    def undecided(self) -> np.ndarray:
        """The share of the runs that end neither well nor captured (P,)."""
        return np.asarray(np.clip(1 - self.outcomes[:, [OUTCOMES.index(o) for o in (*WELL, *CAPTURED)]].sum(axis=1), 0.0, 1.0))


@dataclass(frozen=True)
class Trials:
    """How candidates of a machine are tried: the variables, the rotor's unbalance, the runs of each.

    unbalance: path of the parameter that is varied from run to run; ends: its least and greatest value.
    """

    machine: Machine
    variables: tuple[Variable, ...]
    unbalance: str
    ends: tuple[float, float]
    samples: int
    seed: int
    inertia: bool
    order: Literal[1, 2]
    until: float | None
    tolerance: float

    @property
    def spread(self) -> np.ndarray:
        """The values of the unbalance's parameter (M,) in the runs of a candidate."""
        if self.ends[0] == self.ends[1]:
            return np.full(self.samples, self.ends[0])
        return np.linspace(*self.ends, self.samples)

    def question(self, model: Literal["full", "slow"]) -> EnsembleQuestion:
        """What is asked of each run."""
        paths = tuple(values_at(self.machine, self.variables, [v.low for v in self.variables]))
        varied = tuple(dict.fromkeys((*paths, self.unbalance)))
        return EnsembleQuestion(self.machine, varied, model, self.inertia, self.order, self.until, tolerance=self.tolerance)

    def of(self, numbers: Sequence[float]) -> Machine:
        """The machine of a candidate. Raises ``InputError`` where its parts do not allow it."""
        made = self.machine.with_values(values_at(self.machine, self.variables, numbers))
        for track in made.tracks:
            if _widths(made, [b.name for b in track.bodies]).sum() > 2 * np.pi:
                raise InputError("study.vary", None, f"the bodies of the track {track.name!r} do not fit on it")
        return made


def phases(machine: Machine, samples: int, seed: int) -> np.ndarray:
    """Random phases (b, M) of the bodies about the main rotor, scrambled Sobol' points; on a track without overlapping."""
    from scipy.stats import qmc

    names = balancing(machine)
    at = qmc.Sobol(len(names), scramble=True, rng=np.random.default_rng(seed)).random(_power_of_two(samples))[:samples].T
    found = 2 * np.pi * at
    for track in machine.tracks:
        own = [b.name for b in track.bodies]
        rows, widths = [names.index(n) for n in own], _widths(machine, own)
        # Where the first one is, and how the room that they leave is shared by the gaps.
        gaps = np.sort(at[rows[1:]], axis=0) * (2 * np.pi - widths.sum())
        found[rows[1:]] = found[rows[0]] + np.cumsum(widths[:-1])[:, None] + gaps
    return np.asarray(found)


def _power_of_two(count: int) -> int:
    return 1 << (count - 1).bit_length()


def _widths(machine: Machine, names: Sequence[str]) -> np.ndarray:
    """The angles (n,) that bodies of a track and their next ones need, in rad."""
    parts = {b.name: b for t in machine.tracks for b in t.bodies}
    bodies = []
    for n in names:
        own = {p.path: p for p in parts[n].parameters()}
        changed = {path.removeprefix(f"{n}."): machine.values[path] for path in own if machine.values[path] != own[path].value}
        bodies.append(parts[n].model_copy(update=changed))
    return np.array([angular_width(a, b) for a, b in zip(bodies, [*bodies[1:], bodies[0]], strict=True)])


def least_residual(machine: Machine) -> float:
    """The least unbalance that the bodies can leave: the chain of their unbalances and the rotor's closes as far as it can."""
    own = np.abs(unbalances(machine)[[machine.bodies.index(b) for b in machine.group(machine.rotor)]])
    left = float(2 * own.max() - own.sum())
    return left if left > 1e-9 * own.sum() else 0.0


def evaluated(
    trials: Trials, model: Literal["full", "slow"], numbers: np.ndarray, report: Callable[[float], None]
) -> Evaluated:
    """Candidates (P, k) of the variables."""
    count, m = len(numbers), trials.samples
    machines = list[Machine | None]()
    for row in numbers.tolist():
        try:
            machines.append(trials.of(row))
        except InputError:
            machines.append(None)
    allowed = np.array([made is not None for made in machines])
    objectives, outcomes = np.full((count, 4), np.nan), np.zeros((count, len(OUTCOMES)))
    tried = [(i, made) for i, made in enumerate(machines) if made is not None]
    if tried:
        starts = np.concatenate([_starts(trials, made) for _, made in tried], axis=1)
        question = trials.question(model)
        each = [made.values for _, made in tried]
        values = {p: np.repeat([v[p] for v in each], m) for p in question.varied if p != trials.unbalance}
        values[trials.unbalance] = np.tile(trials.spread, len(tried))
        seen = outcomes_of(question, starts, values, report)
        for k, (i, made) in enumerate(tried):
            runs = slice(k * m, (k + 1) * m)
            of = np.bincount(seen.outcome[runs], minlength=len(OUTCOMES)) / m
            well = np.isin(seen.outcome[runs], [OUTCOMES.index(o) for o in WELL])
            settling = float(seen.settling_time[runs][well].mean()) if well.any() else np.nan
            peak = seen.peak_amplitude[runs]
            residual = max(least_residual(made.with_values({trials.unbalance: end})) for end in trials.ends)
            highest = float(np.nanmax(peak)) if np.isfinite(peak).any() else np.nan
            objectives[i] = settling, residual, highest, 1 - well.mean()
            outcomes[i] = of
    return Evaluated(numbers, objectives, outcomes, allowed)


def _starts(trials: Trials, machine: Machine) -> np.ndarray:
    """The states (n, M) in which the runs of a candidate begin."""
    begin = initial_state(machine, {})
    starts = np.repeat(begin[:, None], trials.samples, axis=1)
    rotor = begin[machine.row(machine.rotor.coordinate.position)]
    rows = [machine.row(b.coordinate.position) for b in machine.group(machine.rotor)[1:]]
    starts[rows] = rotor + phases(machine, trials.samples, trials.seed)
    return starts
