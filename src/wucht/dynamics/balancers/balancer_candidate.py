"""A candidate of a search for the best balancer: its evaluation by the search, and its check by the full equations."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    PEAK,
    RESIDUAL,
    SETTLING,
    BalancerTrials,
    CandidateResults,
    evaluate_batch,
)
from wucht.dynamics.balancers.damping_optimum import compensated_state
from wucht.dynamics.balancers.recommendation import BALANCED_SHARE, CHECK_SAMPLES, CHECK_STREAM, Design, failing_shares
from wucht.dynamics.sampling.ensembles import subprogress
from wucht.dynamics.work import TaskReport
from wucht.errors import InputError

_RUNS = 0.8  # of the progress of a check; the rest are steady states
_FAR = 0.1  # relative: times that differ by more are another objective, if chance does not explain it
_PEAK = 0.2  # likewise; the largest of few
_RESIDUAL = 0.01  # of the greatest unbalance
_CHANCE = 2.6  # standard deviations: a hundredth of what chance does


@dataclass(frozen=True)
class BalancerCandidate:
    """A candidate: number of bodies, values of the variables (k,), and its evaluation by the search. check: by the full
    equations, None as long as it is not checked. doubt: why that has no residual."""

    bodies: int
    numbers: np.ndarray
    evaluation: CandidateResults
    check: CandidateResults | None = None
    doubt: str = ""

    @property
    def results(self) -> CandidateResults:
        """By the check where there is one, else by the search."""
        return self.evaluation if self.check is None else self.check

    @property
    def objectives(self) -> np.ndarray:
        """Objectives (4,) by the check where there is one, else by the search."""
        return np.asarray(self.results.objectives[0])

    @property
    def checked_objectives(self) -> np.ndarray:
        """Objectives (4,) by the check, nan where there is none."""
        return np.full(4, np.nan) if self.check is None else np.asarray(self.check.objectives[0])

    @property
    def most_failing(self) -> float:
        """The share of the runs that do not end compensated, at most."""
        return failing_shares(self.results.outcomes[0])[1]

    @property
    def balances(self) -> bool:
        """True if more than half of the runs end compensated."""
        return 1 - self.most_failing > BALANCED_SHARE

    @property
    def design(self) -> Design:
        """The candidate, as it competes for the recommendation."""
        return Design.of(str(self.bodies), self.numbers.tolist())

    def deviations(self, unbalance: float, samples: int) -> np.ndarray:
        """Return the differences (4,) of the objectives between search and check, relative to those that chance explains: those
        beyond 1 are others; inf where one of the two has none. unbalance: the greatest of the rotor, in kg m.
        samples: number of runs by the search."""
        ours, theirs, tolerances = self.evaluation, self.results, np.empty(4)
        share = (ours.objectives[0, CAPTURE] + theirs.objectives[0, CAPTURE]) / 2
        tolerances[SETTLING] = _FAR * ours.objectives[0, SETTLING] + _CHANCE * np.hypot(ours.error[0], theirs.error[0])
        tolerances[RESIDUAL] = _RESIDUAL * unbalance
        tolerances[PEAK] = _PEAK * ours.objectives[0, PEAK]
        tolerances[CAPTURE] = 1 / samples + _CHANCE * np.sqrt((1 + 1 / CHECK_SAMPLES) * share * (1 - share) / samples)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.nan_to_num(abs(self.objectives - ours.objectives[0]) / tolerances, nan=np.inf))


def verify_candidate(trials: BalancerTrials, numbers: np.ndarray, report: TaskReport) -> tuple[CandidateResults, str]:
    """Check a candidate (k,) in the full equations, from other phases: the search has adapted it to those of its runs.

    Its residual is the least of a stable state, at the worse end of the unbalances; nan: there is none, or it cannot be
    computed, for the reason that is returned, too.
    """
    fresh = replace(trials, samples=CHECK_SAMPLES * trials.samples, stream=CHECK_STREAM)
    check = evaluate_batch(fresh, "full", numbers[None], subprogress(report, 0.0, _RUNS))
    check.objectives[0, RESIDUAL] = np.nan
    residuals, machine = list[float](), trials.candidate_machine(numbers.tolist())
    for end in dict.fromkeys(trials.ends):
        try:
            state = compensated_state(machine.with_values({trials.unbalance: end}), full=True)
        except InputError as error:
            return check, error.explanation
        residuals.append(np.nan if state is None or state.residual is None else state.residual)
    check.objectives[0, RESIDUAL] = np.max(residuals)
    return check, ""
