"""From starts and parameters to outcomes: members are screened in batches, and the rest classified; or run up one by one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.dynamics.run_ups.run_variations import VariedQuantity
from wucht.dynamics.sampling.attractors import attractors_of
from wucht.dynamics.sampling.ensemble_equations import (
    Variants,
    batching_obstacle,
    is_screened,
    member_equations,
    needs_scalar_run,
)
from wucht.dynamics.sampling.ensembles import (
    EnsembleQuestion,
    MemberOutcomes,
    Start,
    initial_states,
    outcomes_of_rest,
    refused_members,
    run_possible,
    subprogress,
)
from wucht.dynamics.sampling.full_classification import begins_fast, classify_members
from wucht.dynamics.sampling.screening_observer import DoublingSchedule, ScreeningObserver
from wucht.dynamics.sampling.steady_certificate import parting_members
from wucht.dynamics.sampling.track_orders import members_by_order
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.work import TaskReport, Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Members, Status


def run_up_each(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: TaskReport) -> MemberOutcomes:
    """Run up members one by one that start in states (n, M) of the machine's System."""
    count = starts.shape[1]
    outcome, failures = np.zeros(count, np.int8), dict[int, str]()
    settling_time, peak_amplitude, end_time = np.full((3, count), math.nan)
    for i in range(count):
        for motion in _member_motions(question, variants.machines[variants.machine_index[i]], starts[:, i]):
            report((i + min(motion.last.trajectory.end_time / motion.case.horizon.expected_end, 1.0)) / count)
        verdict, last = motion.verdict, motion.last.trajectory
        outcome[i], peak_amplitude[i], end_time[i] = OUTCOMES.index(verdict.outcome), motion.observation.largest, last.end_time
        settling_time[i] = math.nan if verdict.settling_time is None else verdict.settling_time
        if last.failure:
            failures[i] = last.failure
    return MemberOutcomes(outcome, settling_time, peak_amplitude, end_time, tuple(failures.items()))


def _member_motions(question: EnsembleQuestion, machine: Machine, start: np.ndarray) -> Iterator[Motion]:
    """Yield the motion of a member that starts in a state (n,), after each leg."""
    machine = machine_in_state(machine, start)
    settings = RunSettings(question.until, model=question.model, tolerance=question.tolerance)
    if question.model == "full":
        model = FullModel(machine, start)
    else:
        model = slow_model(machine, start, question.inertia, question.order)
    for (motion,) in run_up(RunUpCase(machine, Horizon.of(machine, settings, start), (model,), settings), Work()):
        yield motion


def member_advice(
    question: EnsembleQuestion, start: np.ndarray, values: Mapping[str, float], report: TaskReport | None = None
) -> tuple[str | None, float | None]:
    """Return what a member without a verdict needs: a sentence, and the end time of a run that decides, None if there is none.

    It starts in a state (n,), with these values of varied parameters.
    """
    for motion in _member_motions(question, question.machine.with_values(dict(values)), start):
        if report is not None:
            report(min(motion.last.trajectory.end_time / motion.case.horizon.expected_end, 1.0))
    return motion.last.trajectory.failure or motion.verdict.advice, motion.verdict.needed_time


_MOST_DOUBLINGS = 8  # of the first chunk
_SCREENING_SHARE = 0.5  # of the progress


def integration_note(question: EnsembleQuestion) -> str:
    """Return a sentence on how members are integrated."""
    reason = batching_obstacle(question)
    if reason is not None:
        return f"members are run up one by one, which is slower: {reason}"
    return "members are integrated in batches"


def outcomes_of(
    question: EnsembleQuestion, starts: np.ndarray, values: Mapping[str, np.ndarray], report: TaskReport | None = None
) -> MemberOutcomes:
    """Return the outcomes of the members of an ensemble; that of one does not depend on the other ones.

    Parameters
    ----------
    question : EnsembleQuestion
    starts : numpy.ndarray, (n, M)
        States of the machine's System: ``initial_state`` of each member.
    values : mapping of str to numpy.ndarray, (M,)
        Of the parameters that are varied, by path.
    report : callable, optional
        Called with the share that is done, 0 to 1; may raise ``KeyboardInterrupt``.

    Returns
    -------
    MemberOutcomes

    Raises
    ------
    InputError
        For values that a part does not allow, and machines without averaged equations where these are requested.
    """
    machine, count, done = question.machine, starts.shape[1], 0
    parts, numbers = list[MemberOutcomes](), list[np.ndarray]()
    for members, of_members, variants in members_by_order(machine, Variants.from_values(machine, values, count), starts):
        if machine.tracks:  # what the members share, whichever they are: the machine with its bodies in this order
            question = replace(question, machine=variants.machines[0].with_unchecked_values(machine.values))
        progress = subprogress(report or (lambda _share: None), done / count, len(members) / count)
        parts.append(_outcomes_in_one_order(question, of_members, variants, progress))
        numbers.append(members)
        done += len(members)
    return MemberOutcomes.join_in_order(parts, numbers)


def outcomes_at(
    question: EnsembleQuestion,
    start: Start,
    quantities: Sequence[VariedQuantity],
    places: np.ndarray,
    location: str,
    report: TaskReport,
) -> MemberOutcomes:
    """Return the outcomes of the members at places (q, M) of the varied quantities; those that cannot be run have failed.

    start: the rest of the start. location: of the quantities, for messages.
    """
    try:
        starts, values = initial_states(question.machine, start, quantities, places, location)
    except InputError:
        reasons = refused_members(question.machine, start, quantities, places, location)

        def run_some(members: np.ndarray) -> MemberOutcomes:
            return outcomes_at(question, start, quantities, places[:, members], location, report)

        return outcomes_of_rest(places.shape[1], reasons, run_some)
    return run_possible(partial(outcomes_of, question, report=report), question.machine, starts, values)


def _outcomes_in_one_order(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: TaskReport
) -> MemberOutcomes:
    """Return the outcomes of members whose bodies are in one order."""
    needs_single_run = (
        np.ones(starts.shape[1], bool) if batching_obstacle(question) is not None else needs_scalar_run(question, variants)
    )
    single_members, batch_members = np.flatnonzero(needs_single_run), np.flatnonzero(~needs_single_run)
    parts, share = list[MemberOutcomes](), len(single_members) / len(needs_single_run)
    if len(single_members):
        subset = variants.select(single_members)
        parts.append(run_up_each(question, starts[:, single_members], subset, subprogress(report, 0.0, share)))
    if len(batch_members):
        subset = variants.select(batch_members).compact
        parts.append(_run_batches(question, starts[:, batch_members], subset, subprogress(report, share, 1 - share)))
    return MemberOutcomes.join_in_order(parts, [single_members, batch_members])


def _run_batches(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: TaskReport) -> MemberOutcomes:
    """Return the outcomes of members that are integrated in batches."""
    machine = question.machine
    horizon = Horizon.of(machine, RunSettings(), initial_state(machine, {}))
    if not is_screened(machine):
        return classify_members(question, starts, variants, horizon, report)
    outcomes, open_members = _screen_members(question, starts, variants, horizon, subprogress(report, 0.0, _SCREENING_SHARE))
    open_members = np.union1d(open_members, np.flatnonzero(begins_fast(starts, machine, horizon)))
    if not len(open_members):
        return outcomes
    classification_report = subprogress(report, _SCREENING_SHARE, 1 - _SCREENING_SHARE)
    full_outcomes = classify_members(
        question, starts[:, open_members], variants.select(open_members).compact, horizon, classification_report
    )
    return outcomes.with_outcomes(open_members, full_outcomes)


def _screen_members(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: TaskReport
) -> tuple[MemberOutcomes, np.ndarray]:
    """Return the outcomes of the members that the screening decides, and the numbers of the other ones."""
    equations = member_equations(question, starts[:, 0])
    first, until = horizon.first, question.until
    pace = DoublingSchedule(first, 1 + _MOST_DOUBLINGS) if until is None else DoublingSchedule.from_end(until, first)
    attractors = attractors_of(question, equations, horizon)
    quantities = equations.quantities(variants, with_states=bool(attractors))
    noise = Noise.of(question.tolerance)
    observer = ScreeningObserver(quantities, variants, attractors, pace, until is not None, noise)
    initial = np.ascontiguousarray(equations.starts(starts, variants).T)
    members = Members.of(initial, quantities.parameter_values[variants.machine_index])
    ensemble = compile_ensemble(quantities.system, question.tolerance, quantities=quantities.expressions)
    parts, numbers, failures = [], [np.zeros(0, int)], dict[int, str]()
    for ends in tiles(ensemble, members, observer, pace, report=report):
        record = ends.record
        has_failed = ends.status == Status.FAILED
        outcome = np.where(has_failed, OUTCOMES.index(Outcome.FAILED), record.outcome).astype(np.int8)
        parts.append(MemberOutcomes(outcome, record.settling_time, np.sqrt(record.peak_distance_squared), ends.times))
        numbers.append(record.number[record.needs_classification & ~has_failed])
        leaving = parting_members(variants.select(record.number), quantities, outcome, ends)
        numbers.append(record.number[leaving])
        failures |= {int(record.number[i]): reason for i, reason in ends.sentences.items()}
    outcomes = MemberOutcomes.join(parts)
    return outcomes.with_failures(failures), np.concatenate(numbers)
