"""From starts and parameters to outcomes: members are screened in batches, and the rest classified; or run up one by one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.dynamics.sampling.attractors import attractors_of
from wucht.dynamics.sampling.ensemble_equations import (
    NumberedMembers,
    Variants,
    batching_obstacle,
    is_screened,
    member_equations,
    needs_scalar_run,
)
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes, Report, subprogress
from wucht.dynamics.sampling.full_classification import begins_fast, classify_members
from wucht.dynamics.sampling.screening_observer import DoublingSchedule, ScreeningObserver
from wucht.dynamics.sampling.steady_certificate import parting_members
from wucht.dynamics.sampling.track_orders import Arrangement, arrangements
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.work import Work
from wucht.machines.machine import Machine
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Status


def run_up_each(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
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


@dataclass(frozen=True)
class RunAdvice:
    """What a member without a verdict needs: a sentence, and the end time of a run that decides, None if there is none."""

    sentence: str | None
    needed_time: float | None


def member_advice(
    question: EnsembleQuestion, start: np.ndarray, values: Mapping[str, float], report: Report | None = None
) -> RunAdvice:
    """Return the advice of the verdict on a member that starts in a state (n,), with these values of varied parameters."""
    for motion in _member_motions(question, question.machine.with_values(dict(values)), start):
        if report is not None:
            report(min(motion.last.trajectory.end_time / motion.case.horizon.expected_end, 1.0))
    return RunAdvice(motion.last.trajectory.failure or motion.verdict.advice, motion.verdict.needed_time)


_MOST_DOUBLINGS = 8  # of the first chunk
_SCREENING_SHARE = 0.5  # of the progress


def integration_note(question: EnsembleQuestion) -> str:
    """Return a sentence on how members are integrated."""
    reason = batching_obstacle(question)
    if reason is not None:
        return f"members are run up one by one, which is slower: {reason}"
    return "members are integrated in batches"


def outcomes_of(
    question: EnsembleQuestion, starts: np.ndarray, values: Mapping[str, np.ndarray], report: Report | None = None
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
    progress = report or (lambda _share: None)
    count, done = starts.shape[1], 0
    parts, members = list[MemberOutcomes](), list[np.ndarray]()
    for group in arrangements(question.machine, Variants.from_values(question.machine, values, count), starts):
        of_group = replace(question, machine=group.reference(question.machine))
        share = len(group.members) / count
        parts.append(_outcomes_in_one_order(of_group, group, subprogress(progress, done / count, share)))
        members.append(group.members)
        done += len(group.members)
    return MemberOutcomes.join(parts).select(np.argsort(np.concatenate(members)))


def _outcomes_in_one_order(question: EnsembleQuestion, group: Arrangement, report: Report) -> MemberOutcomes:
    """Return the outcomes of members whose bodies are in one order."""
    starts, variants = group.starts, group.variants
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
    return MemberOutcomes.join(parts).select(np.argsort(np.concatenate([single_members, batch_members])))


def _run_batches(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
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
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: Report
) -> tuple[MemberOutcomes, np.ndarray]:
    """Return the outcomes of the members that the screening decides, and the numbers of the other ones."""
    equations = member_equations(question, starts[:, 0])
    first, until = horizon.first, question.until
    pace = DoublingSchedule(first, 1 + _MOST_DOUBLINGS) if until is None else DoublingSchedule.from_end(until, first)
    attractors = attractors_of(question, equations, horizon)
    quantities = equations.quantities(variants, with_states=bool(attractors))
    noise = Noise.of(question.tolerance)
    observer = ScreeningObserver(equations, quantities, variants, attractors, pace, until is not None, noise)
    members = NumberedMembers(
        np.ascontiguousarray(equations.starts(starts, variants).T),
        quantities.parameter_values[variants.machine_index],
        np.arange(starts.shape[1]),
    )
    ensemble = compile_ensemble(quantities.system, question.tolerance, quantities=quantities.expressions)
    parts, numbers, failures = [], [np.zeros(0, int)], dict[int, str]()
    for ends in tiles(ensemble, members, observer, pace, report=report):
        record = ends.record
        has_failed = ends.status == Status.FAILED
        outcome = np.where(has_failed, OUTCOMES.index(Outcome.FAILED), record.outcome).astype(np.int8)
        parts.append(MemberOutcomes(outcome, record.settling_time, np.sqrt(record.peak_distance_squared), ends.times))
        numbers.append(record.number[record.needs_classification & ~has_failed])
        of_tile = variants.select(record.number)
        leaving = parting_members(of_tile, quantities.system, quantities.parameter_values, outcome, ends.states, ends.times)
        numbers.append(record.number[leaving])
        failures |= {int(record.number[i]): reason for i, reason in ends.sentences.items()}
    outcomes = MemberOutcomes.join(parts)
    return outcomes.with_failures(failures), np.concatenate(numbers)
