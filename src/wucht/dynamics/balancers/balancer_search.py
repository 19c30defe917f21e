"""The search for the best balancers of a machine: generations of candidates, their front, its check by the full equations, and
what competes to be recommended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate, verify_candidate
from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    SETTLING,
    BalancerTrials,
    CandidateResults,
    evaluate_candidates,
    power_of_two,
    units_of_work,
)
from wucht.dynamics.balancers.damping_optimum import DampingCurve, damping_curve, decay_rates
from wucht.dynamics.balancers.recommendation import CHECK_SAMPLES, Design, Recommendation, recommend
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle
from wucht.dynamics.sampling.searches import Variable, balancer_names, generations, is_pareto_optimal, spread_selection
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine

Evaluations = Sequence[tuple[int, CandidateResults]]  # of generations, with their numbers of bodies
AS_IT_IS, CURVE = "as it is", "damping"  # groups of candidates beside those of each number of bodies
_RECOMMENDATION = 0.7  # the share of the work after which candidates are compared for the recommendation
_ENTRANTS = 3  # of the front, of the search, and of the damping curve, that compete for the recommendation
_SAME = 1e-9  # relative
_RUNS = 0.8  # of the progress of the curve; the rest are steady states


@dataclass(frozen=True)
class BalancerSearch:
    """A search for the best balancers.

    as_it_is: trials of the machine as given; trials: by the number of bodies. curve: trials of the damping alone, and the
    dampings (N,). objectives: their columns. model: equations of the search. generations: of each number of bodies. points: of
    the front that are checked, at most.
    """

    as_it_is: BalancerTrials
    trials: Mapping[int, BalancerTrials]
    curve: tuple[BalancerTrials, np.ndarray] | None
    objectives: tuple[int, ...]
    model: Literal["full", "slow"]
    generations: int
    population: int
    points: int

    @property
    def machine(self) -> Machine:
        """The machine as given."""
        return self.as_it_is.machine

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The variables of the machine as given."""
        return self.as_it_is.variables

    @property
    def numbers(self) -> np.ndarray:
        """Values of the variables (k,) of the machine as given."""
        return np.array([self.machine.values[v.paths[0]] for v in self.variables])

    @property
    def candidates(self) -> int:
        """Number of candidates."""
        return len(self.trials) * self.generations * self.population

    @property
    def runs(self) -> int:
        """Number of runs before the recommendation, at most: of the machine as it is, the curve, the search, and the points of
        the front."""
        curve = 0 if self.curve is None else len(self.curve[1])
        check_count = CHECK_SAMPLES * (1 + min(self.points, self.candidates))
        return self.as_it_is.samples * (1 + curve + self.candidates + check_count)

    @property
    def shares(self) -> tuple[float, float, float, float]:
        """The completed share of the work after the machine as it is, the damping curve, the search, and the check.

        Each unit of work counts as much: a few runs take nearly as long as those that fill the batches.
        """
        samples = self.as_it_is.samples
        search = len(self.trials) * self.generations * units_of_work(self.population, samples)
        curve = 0 if self.curve is None else units_of_work(len(self.curve[1]), samples)
        sizes = np.cumsum([2, curve, search, min(self.points, self.candidates)])
        first, second, third, _ = (_RECOMMENDATION * sizes / sizes[-1]).tolist()
        return first, second, third, _RECOMMENDATION

    @property
    def groups(self) -> dict[str, BalancerTrials]:
        """Trials by the groups of the candidates of a recommendation."""
        curve = {} if self.curve is None else {CURVE: self.curve[0]}
        return {AS_IT_IS: replace(self.as_it_is, variables=()), **curve} | {str(n): t for n, t in self.trials.items()}

    @property
    def present(self) -> Design:
        """The machine as it is as a candidate, one of the search where its bodies are equal."""
        count = len(balancer_names(self.machine))
        if count not in self.trials or not all(_have_same_values(self.machine, v) for v in self.variables):
            return Design(AS_IT_IS, ())
        return Design(str(count), tuple(self.numbers.tolist()))

    def evaluate_machine(self, work: Work) -> BalancerCandidate:
        """Evaluate and check the machine as it is; bodies that are not equal stay so, as nothing is varied."""
        trials, no_values, activity = self.groups[AS_IT_IS], np.zeros(0), "the machine as it is"
        if batching_obstacle(self.as_it_is.question(self.model)) is not None:
            activity = f"{self.runs} run-ups at most before the recommendation, integrated one by one, which takes long"
        evaluation = evaluate_candidates(trials, self.model, no_values[None], work.part("", 0.0, 0.5), activity)
        ((_, check),) = work.part("", 0.5, 1.0).units({"full": partial(verify_candidate, trials, no_values)}, activity)
        return BalancerCandidate(len(balancer_names(self.machine)), self.numbers, evaluation, *check)

    def follow_curve(self, work: Work) -> DampingCurve | None:
        """Return the settling time over the damping of all bodies; None where it is not asked for."""
        if self.curve is None:
            return None
        trials, dampings = self.curve
        evaluation = evaluate_candidates(trials, self.model, dampings[:, None], work.part("", 0.0, _RUNS), "damping curve")
        return damping_curve(dampings, evaluation, work.unit("rates", partial(decay_rates, trials, dampings)))

    def evaluate_generations(self, as_it_is: BalancerCandidate, work: Work) -> Iterator[tuple[int, CandidateResults]]:
        """Yield the generations of one number of bodies after the other, with that number."""
        for place, count in enumerate(self.trials):
            part = work.part(f"{count} bodies", place / len(self.trials), (place + 1) / len(self.trials))
            for evaluation in self._generations_of(count, as_it_is, part):
                yield count, evaluation

    def _generations_of(self, count: int, as_it_is: BalancerCandidate, work: Work) -> Iterator[CandidateResults]:
        trials, columns, results = self.trials[count], list(self.objectives), list[CandidateResults]()

        def value(number: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            here = work.part(f"generation {number}", number / self.generations, (number + 1) / self.generations)
            numbers = np.stack([v.value_at(shares[:, k]) for k, v in enumerate(trials.variables)], axis=1)
            bodies = "1 body" if count == 1 else f"{count} bodies"
            activity = f"{bodies}, generation {number + 1} of {self.generations}"
            evaluation = evaluate_candidates(trials, self.model, numbers, here, activity)
            results.append(evaluation)
            return evaluation.objectives[:, columns], self.eligible(evaluation, as_it_is)

        first = self._first_generation(count)
        for number in generations(self.generations, first, len(columns), self.as_it_is.seed, value):
            yield results[number]

    def _first_generation(self, count: int) -> np.ndarray:
        """Return the first generation (P, k): scrambled Sobol' points, and the machine as it is where the ranges have it."""
        from scipy.stats import qmc

        variables, random = self.trials[count].variables, np.random.default_rng([self.as_it_is.seed, count])
        shares = qmc.Sobol(len(variables), scramble=True, rng=random).random(power_of_two(self.population))[: self.population]
        machine_shares = np.array([v.share(x) for v, x in zip(variables, self.numbers, strict=True)])
        if ((machine_shares >= 0) & (machine_shares <= 1)).all():
            shares[0] = machine_shares
        return np.asarray(shares)

    def eligible(self, evaluation: CandidateResults, as_it_is: BalancerCandidate) -> np.ndarray:
        """True for eligible candidates (P,): where capture is no objective, they are not captured more often than the machine
        is, neither for certain nor with the runs without a verdict."""
        if CAPTURE in self.objectives:
            return evaluation.is_allowed
        machine = as_it_is.evaluation
        more = (evaluation.captured_share > machine.captured_share[0]) | (
            evaluation.objectives[:, CAPTURE] > machine.objectives[0, CAPTURE]
        )
        return np.asarray(evaluation.is_allowed & ~more)

    def _eligible_candidates(self, evaluations: Evaluations, as_it_is: BalancerCandidate) -> list[BalancerCandidate]:
        return [
            BalancerCandidate(count, evaluation.numbers[k], evaluation.pick(k))
            for count, evaluation in evaluations
            for k in np.flatnonzero(self.eligible(evaluation, as_it_is)).tolist()
        ]

    def front(self, evaluations: Evaluations, as_it_is: BalancerCandidate) -> tuple[list[BalancerCandidate], int]:
        """Return the front of all candidates, thinned evenly to the points to be checked, and its number of points."""
        columns, candidates = list(self.objectives), self._eligible_candidates(evaluations, as_it_is)
        points = [c for c in candidates if np.isfinite(c.objectives[columns]).all()]
        if not points:
            return [], 0
        objectives = np.array([p.objectives[columns] for p in points])
        _, once = np.unique(objectives, axis=0, return_index=True)  # the first of those with equal objectives
        best = np.sort(once)[is_pareto_optimal(objectives[np.sort(once)])]
        front_indices = best[spread_selection(objectives[best], self.points)]
        order = sorted(front_indices.tolist(), key=lambda k: tuple(objectives[k]))
        return [points[k] for k in order], len(best)

    def check_front(self, front: list[BalancerCandidate], work: Work) -> Iterator[None]:
        """Check the points of the front in their places, one after the other as they come."""
        checks = {f"{k}": partial(verify_candidate, self.trials[p.bodies], p.numbers) for k, p in enumerate(front)}
        for name, (check, doubt) in work.units(checks, "check with the full equations"):
            front[int(name)] = replace(front[int(name)], check=check, doubt=doubt)
            yield

    def is_confirmed(self, front: Sequence[BalancerCandidate]) -> np.ndarray:
        """Return a mask (N,) of the points that no other checked point dominates by the check."""
        checked_objectives = np.array([p.checked_objectives for p in front]).reshape(len(front), 4)[:, list(self.objectives)]
        is_known, mask = np.isfinite(checked_objectives).all(axis=1), np.zeros(len(front), bool)
        mask[is_known] = is_pareto_optimal(checked_objectives[is_known])
        return mask

    def best_point(self, front: Sequence[BalancerCandidate], column: int) -> int | None:
        """Return the point that is best in an objective, of those that no checked one dominates: of equals the one that is
        captured less often, and one that balances, if any does."""
        holds = self.is_confirmed(front)

        def order(k: int) -> tuple[bool, float, float]:
            objectives = front[k].objectives
            return not front[k].balances, float(objectives[column]), float(np.nan_to_num(objectives[CAPTURE]))

        places = [k for k, p in enumerate(front) if (p.check is None or holds[k]) and np.isfinite(p.objectives[column])]
        return min(places, key=order, default=None)

    def best_dampings(self, curve: DampingCurve | None) -> tuple[list[Design], Design | None]:
        """Return the dampings that settle fastest, the machine otherwise as it is, as candidates of the search; where damping
        is not varied, the fastest one alone, that is not."""
        if self.curve is None or curve is None or not np.isfinite(curve.optimum):
            return [], None
        times = np.where(curve.share_through >= curve.share_through.max(), curve.settling_time, np.nan)
        best = [float(curve.damping[k]) for k in np.argsort(times)[:_ENTRANTS] if np.isfinite(times[k])]
        paths, present = set(self.curve[0].variables[0].paths), self.present
        column = next((k for k, v in enumerate(self.variables) if set(v.paths) == paths), None)
        if column is None:
            return [], Design(CURVE, (best[0],))
        if present.group == AS_IT_IS:
            return [], None
        numbers = self.numbers.tolist()
        return [Design.of(present.group, (*numbers[:column], b, *numbers[column + 1 :])) for b in best], None

    def _luckiest(self, evaluations: Evaluations, as_it_is: BalancerCandidate) -> list[Design]:
        """Return the best candidates by the search: the fewest failing runs, then the settling time, then the number of
        bodies."""

        def order(candidate: BalancerCandidate) -> tuple[float, float, int]:
            settling_time = float(candidate.objectives[SETTLING])
            return candidate.most_failing, settling_time if np.isfinite(settling_time) else np.inf, candidate.bodies

        candidates = sorted(self._eligible_candidates(evaluations, as_it_is), key=order)
        return [candidate.design for candidate in candidates[:_ENTRANTS]]

    def recommend(
        self,
        as_it_is: BalancerCandidate,
        curve: DampingCurve | None,
        evaluations: Evaluations,
        front: Sequence[BalancerCandidate],
        work: Work,
    ) -> Recommendation:
        """Choose among the machine as it is, the checked points, the best of the search, those of the curve, and neighbours."""
        (dampings, beside), present = self.best_dampings(curve), self.present
        checks = {present: as_it_is.check} | {p.design: p.check for p in front}
        results = {design: check for design, check in checks.items() if check is not None}
        entrants, samples = self._luckiest(evaluations, as_it_is), self.as_it_is.samples
        return recommend(self.groups, results, entrants, dampings, present, beside, samples, work)

    def evaluate_recommended(
        self, recommendation: Recommendation, front: Sequence[BalancerCandidate], work: Work
    ) -> BalancerCandidate | None:
        """Evaluate and check the recommended candidate; None where it is a point of the front, or the machine as it is."""
        chosen = recommendation.chosen
        if recommendation.is_kept or any(point.design == chosen for point in front):
            return None
        bodies, numbers = int(chosen.group), np.array(chosen.numbers)
        trials, label = self.trials[bodies], "the recommended one"
        evaluation = evaluate_candidates(trials, self.model, numbers[None], work.part("", 0.0, 0.5), label)
        ((_, check),) = work.part("", 0.5, 1.0).units({"check": partial(verify_candidate, trials, numbers)}, label)
        return BalancerCandidate(bodies, numbers, evaluation, *check)


def _have_same_values(machine: Machine, variable: Variable) -> bool:
    values = np.array([machine.values[path] for path in variable.paths])
    return bool(np.ptp(values) <= _SAME * np.abs(values).max())
