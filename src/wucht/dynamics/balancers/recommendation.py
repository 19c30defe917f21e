"""The balancer to be recommended, by a comparison on fresh runs, and whether it or the motor sets the settling time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from wucht.analysis.time_constants import run_up_time
from wucht.dynamics.balancers.candidates import BalancerTrials, CandidateResults, candidates_a_unit, evaluate_batch
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.choice import Cliff, Contest, Scores, nearest_cliff
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES, Outcome
from wucht.dynamics.work import Work
from wucht.machines.changes import last_change
from wucht.machines.machine import Machine

BALANCED_SHARE = 0.5  # of the runs: a candidate balances if more of them end compensated, as then the median run does
MOTOR_SHARE = 0.8  # of the median settling time: a motor that needs at least as long without vibration sets it
_COMPENSATED_INDEX, _OPEN_INDICES = OUTCOMES.index(Outcome.COMPENSATED), [OUTCOMES.index(o) for o in OPEN_OUTCOMES]
CHECK_STREAM, _RACE_STREAM, _DUEL_STREAM = 1, 2, 3  # of the random phases; the search has 0
CHECK_SAMPLES, _RACE_SAMPLES, _DUEL_SAMPLES = 4, 2, 16  # times the samples of the search
_STEPS = (1 / 8, 1 / 16)  # of the ranges, of the search among neighbours; the last one is that of the neighbours in the result
_LINE = (1 / 8, 1 / 4, 1 / 2)  # of the ranges, at which cliffs are sought
_DIGITS = 4  # of a value, as in the lines to paste; a step up and a step down lead back
_RIVALS = 2  # of the checked candidates that enter the race, and of the race that are checked


@dataclass(frozen=True)
class Design:
    """A candidate. group: which of several trials evaluate it, by name. numbers: its values of their variables."""

    group: str
    numbers: tuple[float, ...]

    @classmethod
    def of(cls, group: str, numbers: Sequence[float]) -> Design:
        """Return a candidate whose values have four digits."""
        return cls(group, tuple(float(f"{x:.{_DIGITS}g}") for x in numbers))


def failing_shares(outcomes: np.ndarray) -> tuple[float, float]:
    """Return the shares of the runs of a candidate that do not end compensated, for certain and at most.

    outcomes (o,): the share of its runs with each of ``OUTCOMES``.
    """
    most = 1 - float(outcomes[_COMPENSATED_INDEX])
    return max(most - float(outcomes[_OPEN_INDICES].sum()), 0.0), most


@dataclass(frozen=True, eq=False)
class Recommendation:
    """The recommended candidate, and all that it was compared with on the same fresh runs.

    chosen: it. is_kept: True if it is the machine as it is. final: the comparison. outcomes (o,): shares of its runs.
    neighbours: those of the best one. cliff: the nearest one. line: the values at which one was sought, with fewer runs.
    beside: the comparison with the best damping of the machine as it is, the last one, where damping is not varied.
    duel: of the best one and the machine as it is, with more runs, where the comparison leaves it open which is better.
    """

    chosen: Design
    is_kept: bool
    final: Contest[Design]
    outcomes: np.ndarray
    neighbours: tuple[Design, ...]
    cliff: Cliff | None
    line: Contest[Design]
    beside: Contest[Design] | None = None
    duel: Contest[Design] | None = None

    @property
    def score(self) -> int:
        """Index of the recommended candidate in the final comparison."""
        return self.final.candidates.index(self.chosen)

    @property
    def settling_time(self) -> float:
        """Median settling time of the recommended candidate; inf where half of its runs do not settle."""
        return float(self.final.scores.medians[self.score])

    @property
    def failing_shares(self) -> tuple[float, float]:
        """Shares of its runs that do not end compensated, for certain and at most."""
        return failing_shares(self.outcomes)

    @property
    def balances(self) -> bool:
        """True if more than half of its runs end compensated."""
        return 1 - self.failing_shares[1] > BALANCED_SHARE


def _evaluation(
    trials: Mapping[str, BalancerTrials],
    samples: int,
    stream: int,
    work: Work,
    results_by_design: dict[Design, CandidateResults],
) -> Callable[[Sequence[Design]], Scores]:
    """Return a function that evaluates candidates on the same runs. results_by_design: of such runs, to which it adds."""
    fresh = {group: replace(t, samples=samples, stream=stream) for group, t in trials.items()}
    calls = 0

    def evaluate(designs: Sequence[Design]) -> Scores:
        nonlocal calls
        calls += 1
        part = work.part(f"{samples} runs ", 1 - 0.5 ** (calls - 1), 1 - 0.5**calls)
        batches = {
            f"{b[0].group} {b[0].numbers}": b for b in _batches([d for d in designs if d not in results_by_design], samples)
        }
        tasks = {
            name: partial(evaluate_batch, fresh[b[0].group], "full", np.array([d.numbers for d in b]).reshape(len(b), -1))
            for name, b in batches.items()
        }
        for name, results in part.units(tasks, "comparison on fresh runs"):
            results_by_design.update((design, results.pick(k)) for k, design in enumerate(batches[name]))
        outcome = np.concatenate([results_by_design[d].outcome for d in designs])
        return Scores(np.concatenate([results_by_design[d].times for d in designs]), outcome != _COMPENSATED_INDEX)

    return evaluate


def _batches(designs: Sequence[Design], samples: int) -> list[list[Design]]:
    """Return the candidates in groups that are evaluated in one ensemble."""
    size, batches = candidates_a_unit(samples), list[list[Design]]()
    for design in sorted(designs, key=lambda d: d.group):
        if batches and batches[-1][0].group == design.group and len(batches[-1]) < size:
            batches[-1].append(design)
        else:
            batches.append([design])
    return batches


def recommend(
    trials: Mapping[str, BalancerTrials],
    checks: Mapping[Design, CandidateResults],
    entrants: Sequence[Design],
    curve_optima: Sequence[Design],
    present: Design,
    beside: Design | None,
    samples: int,
    work: Work,
) -> Recommendation:
    """Return the best of some candidates and their neighbours, or the machine as it is, by fresh runs of the full equations.

    Parameters
    ----------
    trials : mapping of BalancerTrials
        By the groups of the candidates.
    checks : mapping of Design to CandidateResults
        Candidates that are checked, the machine as it is among them, with the results.
    entrants : sequence of Design
        Further candidates: the best of the search.
    curve_optima : sequence of Design
        The best of the damping curve, which are candidates, too, and the first of which is checked in any case.
    present : Design
        The machine as it is.
    beside : Design, optional
        A candidate that is not to be recommended, since what makes it is not varied.
    samples : int
        Number of runs of a candidate in the search: the first round has twice as many, the check four times as many.
    work : Work
    """

    def neighbours(design: Design, step: float) -> list[Design]:
        return [d for _, designs in _lines(trials[design.group], design, (step,)) for d in designs]

    race = _evaluation(trials, _RACE_SAMPLES * samples, _RACE_STREAM, work.part("race ", 0.0, 0.4), {})
    results_by_design = dict(checks)
    check = _evaluation(trials, CHECK_SAMPLES * samples, CHECK_STREAM, work.part("check ", 0.4, 0.8), results_by_design)
    ranking = Contest.of(list(checks), check).ranking
    first = Contest.of([*ranking[:_RIVALS], *entrants, *curve_optima, present], race)
    summit = first.climb(neighbours, _STEPS, race)
    finalists = [*checks, summit.best, *first.ranking[:_RIVALS], *curve_optima[:1]]
    final = Contest.of(finalists, check).climb(neighbours, _STEPS[-1:], check)
    chosen, duel = final.choice(present), None
    if chosen != final.best:
        more = _evaluation(trials, _DUEL_SAMPLES * samples, _DUEL_STREAM, work.part("duel ", 0.8, 0.9), {})
        duel = Contest.of([final.best, present], more)
        chosen = duel.choice(present)
    scan = _evaluation(trials, samples, CHECK_STREAM, work.part("line ", 0.9, 1.0), {})
    sides = _lines(trials[chosen.group], chosen, _LINE)
    line = Contest.of([chosen, *(d for _, designs in sides for d in designs)], scan)
    against = None if beside is None else final.with_candidates([beside], check)
    work.report(1.0)
    return Recommendation(
        chosen, chosen == present, final, results_by_design[chosen].outcomes[0], tuple(neighbours(final.best, _STEPS[-1])),
        _cliff(trials[chosen.group], chosen, sides, line), line, against, duel,
    )  # fmt: skip


def _lines(trials: BalancerTrials, design: Design, steps: Sequence[float]) -> list[tuple[int, list[Design]]]:
    """Return the candidates at steps (shares of the ranges) to either side of one, variable by variable, within the ranges."""
    lines = list[tuple[int, list[Design]]]()
    for k, variable in enumerate(trials.variables):
        share = variable.share(design.numbers[k])
        for sign in (-1.0, 1.0):
            shares = np.clip(share + sign * np.array(steps), 0.0, 1.0)
            values = [float(f"{x:.{_DIGITS}g}") for x in variable.value_at(shares)]
            values = list(dict.fromkeys(min(max(x, variable.low), variable.high) for x in values))
            farther = [x for x in values if sign * (x - design.numbers[k]) > 0]
            lines.append((k, [replace(design, numbers=(*design.numbers[:k], x, *design.numbers[k + 1 :])) for x in farther]))
    return lines


def _cliff(
    trials: BalancerTrials, chosen: Design, sides: Sequence[tuple[int, list[Design]]], line: Contest[Design]
) -> Cliff | None:
    names, values, place = [v.name for v in trials.variables], [d.numbers for d in line.candidates], line.candidates.index
    return nearest_cliff(line.scores, place(chosen), names, values, [(k, list(map(place, designs))) for k, designs in sides])


def motor_time(machine: Machine, start: Mapping[str, Any]) -> float:
    """Return the time that the main rotor takes from a start to within 0.5 % of its free speed, without vibration.

    It is at least that of the last change by a schedule; 0 where the speed is prescribed from the beginning.
    """
    changes, rotor = last_change(machine), machine.rotor
    if rotor.coordinate.prescribed_velocity is not None:
        return changes
    speed = float(initial_state(machine, start)[machine.row(rotor.coordinate.velocity)])
    return max(changes, run_up_time(machine.at(changes), speed))


def motor_sets(time: float, settling_time: float | None) -> bool:
    """True if a motor that takes this time sets a settling time."""
    return settling_time is not None and bool(time > 0) and time >= MOTOR_SHARE * settling_time
