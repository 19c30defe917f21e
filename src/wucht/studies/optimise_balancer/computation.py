"""Question and machine -> plan -> findings: the variables, the candidates, the front, and the curve over the damping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.averaged_equations import keeps_inertia
from wucht.dynamics.balancers.candidates import (
    CAPTURE,
    BalancerTrials,
    CandidateResults,
    TrialSettings,
    evaluate_batch,
    evaluate_candidates,
    power_of_two,
    units_of_work,
    with_bodies,
)
from wucht.dynamics.balancers.damping_optimum import DampingCurve, compensated_state, damping_curve, decay_rates
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle
from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.sampling.ensembles import Report, omission_warnings, subprogress
from wucht.dynamics.sampling.searches import (
    Variable,
    balancer_names,
    generations,
    is_pareto_optimal,
    require_pymoo,
    spread_selection,
    variables_of,
)
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.results.formatting import bodies_in_words
from wucht.studies.optimise_balancer.spec import OBJECTIVES, Objective, OptimiseBalancer
from wucht.system import TIME

_CURVE = 25  # dampings
_DECADES = 1.5  # on either side of the machine's damping, where the question does not vary it
_SLOW_PEAK = (
    "the peaks of the search are those of averaged equations, in which the vibration follows the speed at once: they are too "
    "high where a resonance is passed fast; the check has those of the full equations"
)


@dataclass(frozen=True)
class Plan:
    """The plan of a search for the best balancer.

    objectives: the requested ones. trials: by the number of bodies; ``as_it_is``: of the machine as given. numbers: its
    values of the variables (k,). generations: of each number of bodies. curve: trials of the damping alone, and the
    dampings. way: the integration of the runs, as a phrase; one_by_one: True if each run is integrated separately.
    """

    spec: OptimiseBalancer
    machine: Machine
    objectives: tuple[Objective, ...]
    trials: dict[int, BalancerTrials]
    as_it_is: BalancerTrials
    numbers: np.ndarray
    generations: int
    curve: tuple[BalancerTrials, np.ndarray] | None
    way: str
    one_by_one: bool
    warnings: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Return the variables of the machine as given."""
        return self.as_it_is.variables

    @property
    def objective_columns(self) -> list[int]:
        """Return the columns of the requested objectives."""
        return [k for k, o in enumerate(OBJECTIVES) if o in self.objectives]

    @property
    def runs(self) -> int:
        """Return the largest number of runs: of the machine as it is, the curve, the search, and the points of the front."""
        curve = 0 if self.curve is None else len(self.curve[1])
        candidates = len(self.trials) * self.generations * self.spec.population
        return self.spec.samples * (2 + curve + candidates + min(self.spec.points, candidates))


def prepare(spec: OptimiseBalancer, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the machine."""
    require_pymoo(spec.kind)
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied")
    balancing_bodies = balancer_names(machine)
    if not balancing_bodies:
        raise InputError("machine.bodies", None, f"there are no balancing bodies about {machine.rotor.name!r}")
    path, factor = _unbalance(machine)
    unbalance_range = spec.unbalance or (machine.values[path] / factor,) * 2
    if not unbalance_range[0] > 0:
        raise InputError(path, machine.values[path], "must be greater than 0, or study.unbalance = [low, high] must be given")
    inertia = keeps_inertia(machine, True if spec.inertia is None else spec.inertia)
    _check_start(spec, machine)

    settings = TrialSettings(spec.samples, spec.seed, spec.start, spec.until, spec.order, spec.tolerance)

    def trials(of: Machine) -> BalancerTrials:
        variables = variables_of(of, spec.vary, spec.bodies is not None)
        if path in {p for v in variables for p in v.paths}:
            raise InputError(f"study.vary.{path}", None, "not allowed: the unbalance is given by study.unbalance")
        if any(p == f"{machine.rotor.name}.mass" for v in variables for p in v.paths) and factor != 1.0:
            raise InputError(
                "study.vary", f"{machine.rotor.name}.mass", "allowed only where the rotor's unbalance itself is given"
            )
        return BalancerTrials(
            settings, of, variables, path, (unbalance_range[0] * factor, unbalance_range[1] * factor), inertia
        )

    as_it_is, objectives = trials(machine), _objectives(spec, machine)
    _check_ends(as_it_is)
    question = as_it_is.question(spec.model)
    warnings = omission_warnings(question, spec.start, (), ())
    counts = spec.bodies or (len(balancing_bodies),)
    by_count = {n: trials(with_bodies(machine, n)) for n in counts}
    for n in counts:
        initial_state(by_count[n].machine, spec.start)
    curve = _curve(as_it_is) if spec.damping_curve else None
    if spec.damping_curve and curve is None:
        warnings = (*warnings, "there is no damping curve: some balancing body has no damping that could be varied")
    if spec.model == "slow" and "peak" in objectives:
        warnings = (*warnings, _SLOW_PEAK)
    numbers = np.array([machine.values[v.paths[0]] for v in as_it_is.variables])
    generations, alone = spec.evaluations // (len(counts) * spec.population), batching_obstacle(question) is not None
    return Plan(
        spec, machine, objectives, by_count, as_it_is, numbers, generations, curve, integration_note(question), alone, warnings
    )  # fmt: skip


def _objectives(spec: OptimiseBalancer, machine: Machine) -> tuple[Objective, ...]:
    """Return the objectives. Raises ``InputError`` for the peak of a rotor that does not pass its resonance."""
    prescribed_motion = machine.rotor.coordinate.prescribed_velocity
    is_held = prescribed_motion is not None and TIME not in prescribed_motion.free_symbols and not machine.schedules
    if is_held and "peak" in (spec.objectives or ()):
        reason = "the drive holds the rotor's speed from the beginning, so that it passes no resonance on the way"
        raise InputError("study.objectives", "peak", f"not allowed: {reason}")
    return spec.objectives or tuple(o for o in OBJECTIVES if not (is_held and o == "peak"))


def _check_start(spec: OptimiseBalancer, machine: Machine) -> None:
    """Refuse a start with phases of balancing bodies, which are random. Raises ``InputError``."""
    for name, value in spec.start.items():
        speed_alone = isinstance(value, Mapping) and "angle" not in value
        if name in ("psi", "delta") or (name in balancer_names(machine) and not speed_alone):
            raise InputError(f"study.start.{name}", value, "not allowed: the phases of balancing bodies are random")


def _unbalance(machine: Machine) -> tuple[str, float]:
    """Return the path of the rotor's unbalance, and its value for 1 kg m. Raises ``InputError``."""
    name, values = machine.rotor.name, machine.values
    if f"{name}.unbalance" in values:
        return f"{name}.unbalance", 1.0
    if f"{name}.eccentricity" in values:
        return f"{name}.eccentricity", 1 / values[f"{name}.mass"]
    raise InputError("machine.bodies", name, "a main rotor with an unbalance or an eccentricity is required")


def _check_ends(trials: BalancerTrials) -> None:
    """Refuse an end of a range that the parts do not allow, all else unchanged. Raises ``InputError``."""
    for v in trials.variables:
        for end in (v.low, v.high):
            alone = replace(trials, variables=(v,))
            try:
                alone.candidate_machine([end])
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.explanation) from None


def _curve(trials: BalancerTrials) -> tuple[BalancerTrials, np.ndarray] | None:
    """Return trials with the damping of all bodies as the only variable, and the dampings (N,)."""
    machine, names = trials.machine, balancer_names(trials.machine)
    if any(f"{b}.damping" not in machine.values for b in names):
        return None
    damping_variable = next((v for v in trials.variables if v.key == "damping" and len(v.paths) == len(names)), None)
    damping = max(machine.values[f"{b}.damping"] for b in names)
    if damping_variable is None and not damping > 0:
        return None
    low, high = (
        (damping * 10**-_DECADES, damping * 10**_DECADES)
        if damping_variable is None
        else (damping_variable.low, damping_variable.high)
    )
    if not low > 0:
        low = high * 10 ** (-2 * _DECADES)
    parameter = machine.parameters[f"{names[0]}.damping"]
    only = Variable("damping", "damping", tuple(f"{b}.damping" for b in names), low, high, parameter.unit, parameter.long_name)
    return replace(trials, variables=(only,)), np.geomspace(low, high, _CURVE)


_RUNS = 0.8  # of the progress; the rest are steady states


def _shares(plan: Plan) -> tuple[float, float, float]:
    """Return the completed share of the work after the machine as it is, the damping curve, and the search.

    Each unit of work counts as much: a few runs take nearly as long as those that fill the batches.
    """
    generation = units_of_work(plan.spec.population, plan.spec.samples)
    search, curve = len(plan.trials) * plan.generations * generation, 0
    if plan.curve is not None:
        curve = units_of_work(len(plan.curve[1]), plan.spec.samples)
    candidates = len(plan.trials) * plan.generations * plan.spec.population
    sizes = np.cumsum([2, curve, search, min(plan.spec.points, candidates)])
    first, second, third, _ = (sizes / sizes[-1]).tolist()
    return first, second, third


@dataclass(frozen=True)
class FullCheck:
    """A candidate in the full equations. residual: the least of a stable state, at the worse end of the unbalances,
    nan: there is none, or it cannot be computed, for the ``reason``."""

    evaluation: CandidateResults
    residual: float
    reason: str = ""


@dataclass(frozen=True)
class Baseline:
    """The machine as it is, by the equations of the search and by the full ones."""

    evaluation: CandidateResults
    check: FullCheck


@dataclass(frozen=True)
class FrontPoint:
    """A point of the front: number of bodies, and the candidate as evaluated by the search."""

    bodies: int
    evaluation: CandidateResults
    check: FullCheck | None = None

    @property
    def numbers(self) -> np.ndarray:
        """Return the values of the variables (k,)."""
        return np.asarray(self.evaluation.numbers[0])


@dataclass(frozen=True)
class Findings:
    """The findings of a search.

    evaluated_generations: with their number of bodies. front: empty until the search is finished.
    """

    baseline: Baseline
    curve: DampingCurve | None = None
    evaluated_generations: tuple[tuple[int, CandidateResults], ...] = ()
    front: tuple[FrontPoint, ...] = ()
    front_size: int = 0


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings after each generation and each point of the front."""
    baseline, curve, search = _shares(plan)
    findings = Findings(_evaluate_baseline(plan, work.part("as it is", 0.0, baseline)))
    yield findings
    if plan.curve is not None:
        findings = replace(findings, curve=_follow_curve(plan, *plan.curve, work.part("curve", baseline, curve)))
        yield findings
    for evaluated_generations in _search_generations(plan, findings.baseline, work.part("search", curve, search)):
        findings = replace(findings, evaluated_generations=evaluated_generations)
        yield findings
    front, front_size = front_of(plan, findings)
    findings = replace(findings, front=front, front_size=front_size)
    yield findings
    checks = {f"{k}": partial(verify_candidate, plan.trials[p.bodies], p.numbers) for k, p in enumerate(front)}
    for name, check in work.part("front", search, 1.0).units(checks, "check with the full equations"):
        points = list(findings.front)
        points[int(name)] = replace(points[int(name)], check=check)
        findings = replace(findings, front=tuple(points))
        yield findings
    work.report(1.0)
    yield findings


def _evaluate_baseline(plan: Plan, work: Work) -> Baseline:
    # Bodies that are not equal stay as they are: nothing is varied.
    as_it_is, no_values, activity = replace(plan.as_it_is, variables=()), np.zeros(0), "the machine as it is"
    if plan.one_by_one:
        activity = f"{plan.runs} run-ups at most, integrated one by one, which takes long"
    evaluation = evaluate_candidates(as_it_is, plan.spec.model, no_values[None], work.part("", 0.0, 0.5), activity)
    ((_, check),) = work.part("", 0.5, 1.0).units({"full": partial(verify_candidate, as_it_is, no_values)}, activity)
    return Baseline(evaluation, check)


def _follow_curve(plan: Plan, trials: BalancerTrials, dampings: np.ndarray, work: Work) -> DampingCurve:
    evaluation = evaluate_candidates(trials, plan.spec.model, dampings[:, None], work.part("", 0.0, _RUNS), "damping curve")
    return damping_curve(dampings, evaluation, work.unit("rates", partial(decay_rates, trials, dampings)))


def verify_candidate(trials: BalancerTrials, numbers: np.ndarray, report: Report) -> FullCheck:
    """Check a candidate (k,) in the full equations, from other phases: the search has adapted it to those of its runs."""
    evaluation = evaluate_batch(replace(trials, fresh_phases=True), "full", numbers[None], subprogress(report, 0.0, _RUNS))
    residuals, machine = list[float](), trials.candidate_machine(numbers.tolist())
    for end in dict.fromkeys(trials.ends):
        try:
            state = compensated_state(machine.with_values({trials.unbalance: end}), full=True)
        except InputError as error:
            return FullCheck(evaluation, np.nan, error.explanation)
        residuals.append(np.nan if state is None or state.residual is None else state.residual)
    return FullCheck(evaluation, float(np.max(residuals)))


def _search_generations(plan: Plan, baseline: Baseline, work: Work) -> Iterator[tuple[tuple[int, CandidateResults], ...]]:
    """Yield the generations so far, of one number of bodies after the other."""
    evaluated_generations: tuple[tuple[int, CandidateResults], ...] = ()
    for place, (count, trials) in enumerate(plan.trials.items()):
        part = work.part(f"{count} bodies", place / len(plan.trials), (place + 1) / len(plan.trials))
        latest: list[CandidateResults] = []

        def value(
            number: int,
            shares: np.ndarray,
            trials: BalancerTrials = trials,
            part: Work = part,
            latest: list[CandidateResults] = latest,
        ) -> tuple[np.ndarray, np.ndarray]:
            here = part.part(f"generation {number}", number / plan.generations, (number + 1) / plan.generations)
            numbers = np.stack([v.value_at(shares[:, k]) for k, v in enumerate(trials.variables)], axis=1)
            activity = f"{bodies_in_words(len(balancer_names(trials.machine)))}, generation {number + 1} of {plan.generations}"
            evaluation = evaluate_candidates(trials, plan.spec.model, numbers, here, activity)
            latest.append(evaluation)
            return evaluation.objectives[:, plan.objective_columns], eligible_candidates(plan, evaluation, baseline)

        for _ in generations(
            plan.generations, _first_generation(plan, count, trials), len(plan.objective_columns), plan.spec.seed, value
        ):
            evaluated_generations = (*evaluated_generations, (count, latest[-1]))
            yield evaluated_generations


def _first_generation(plan: Plan, count: int, trials: BalancerTrials) -> np.ndarray:
    """Return the first generation (P, k): scrambled Sobol' points, and the machine as it is, where it lies in the ranges."""
    from scipy.stats import qmc

    size = plan.spec.population
    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, count]))
    shares = sobol.random(power_of_two(size))[:size]
    machine_shares = np.array([v.share(x) for v, x in zip(trials.variables, plan.numbers, strict=True)])
    if ((machine_shares >= 0) & (machine_shares <= 1)).all():
        shares[0] = machine_shares
    return np.asarray(shares)


def eligible_candidates(plan: Plan, evaluation: CandidateResults, baseline: Baseline) -> np.ndarray:
    """True for eligible candidates (P,): where capture is no objective, they are not captured more often than the machine is,
    neither for certain nor with the runs without a verdict."""
    if CAPTURE in plan.objective_columns:
        return evaluation.is_allowed
    more = (evaluation.captured_share > baseline.evaluation.captured_share[0]) | (
        evaluation.objectives[:, CAPTURE] > baseline.evaluation.objectives[0, CAPTURE]
    )
    return np.asarray(evaluation.is_allowed & ~more)


def front_of(plan: Plan, findings: Findings) -> tuple[tuple[FrontPoint, ...], int]:
    """Return the front of all candidates, thinned evenly to the points to be checked, and its number of points."""
    points = [
        FrontPoint(count, evaluation.pick(int(i)))
        for count, evaluation in findings.evaluated_generations
        for i in np.flatnonzero(
            eligible_candidates(plan, evaluation, findings.baseline)
            & np.isfinite(evaluation.objectives[:, plan.objective_columns]).all(axis=1)
        )
    ]
    if not points:
        return (), 0
    objectives = np.array([p.evaluation.objectives[0, plan.objective_columns] for p in points])
    _, once = np.unique(objectives, axis=0, return_index=True)  # the first of those with equal objectives
    best = np.sort(once)[is_pareto_optimal(objectives[np.sort(once)])]
    front_indices = best[spread_selection(objectives[best], plan.spec.points)]
    order = sorted(front_indices.tolist(), key=lambda k: tuple(objectives[k]))
    return tuple(points[k] for k in order), len(best)
