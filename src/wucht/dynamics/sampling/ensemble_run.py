"""From starts and parameters to outcomes: members are screened in batches, and the rest classified; or run up one by one."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, placed
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.dynamics.sampling.attractors import attractors_of
from wucht.dynamics.sampling.closer_look import begins_fast, looked_at
from wucht.dynamics.sampling.ensemble_equations import (
    Numbered,
    Variants,
    equations_of,
    parameters_of,
    turns_otherwise,
    why_one_by_one,
)
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes, Report, part_of
from wucht.dynamics.sampling.first_look import DoublingPace, FirstLook
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.work import Work
from wucht.numerics.ensembles.ensemble import compile_ensemble, tiles
from wucht.numerics.ensembles.members import Status
from wucht.numerics.flow.compiled import available_engine


def run_up_each(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
    """Run up members one by one that start in states (n, M) of the machine's System."""
    count = starts.shape[1]
    settings = RunSettings(question.until, model=question.model, tolerance=question.tolerance)
    outcome, failures = np.zeros(count, np.int8), dict[int, str]()
    settling, peak, end = np.full((3, count), math.nan)
    for i in range(count):
        machine = placed(variants.machines[variants.of[i]], starts[:, i])
        if question.model == "full":
            model = FullModel(machine, starts[:, i])
        else:
            model = slow_model(machine, starts[:, i], question.inertia, question.order)
        case = RunUpCase(machine, Horizon.of(machine, settings, starts[:, i]), (model,), settings)
        for (motion,) in run_up(case, Work()):
            report((i + min(motion.last.stored.end_time / case.horizon.expected_end, 1.0)) / count)
        verdict, last = motion.verdict, motion.last.stored
        outcome[i], peak[i], end[i] = OUTCOMES.index(verdict.outcome), motion.observation.largest, last.end_time
        settling[i] = math.nan if verdict.settling_time is None else verdict.settling_time
        if last.failure:
            failures[i] = last.failure
    return MemberOutcomes(outcome, settling, peak, end, tuple(failures.items()))


_MOST_DOUBLINGS = 8  # of the first chunk
_FIRST_LOOK = 0.5  # of the progress


def way_of(question: EnsembleQuestion) -> str:
    """Return a sentence on how members are integrated."""
    why = why_one_by_one(question)
    if why is not None:
        return f"members are run up one by one, which is slower: {why}"
    if (engine := available_engine()) != "heyoka":
        return f"members are integrated one by one, which is slower: the engine {engine} has no batches"
    return "members are integrated in batches"


def outcomes_of(
    question: EnsembleQuestion, starts: np.ndarray, values: Mapping[str, np.ndarray], report: Report | None = None
) -> MemberOutcomes:
    """Return the outcomes of members.

    Parameters
    ----------
    question : EnsembleQuestion
    starts : ndarray, (n, M)
        States of the machine's System.
    values : mapping of str to ndarray, (M,)
        Of the parameters that are varied, by path.
    report : callable, optional
        Called with the share that is done, 0 to 1; may raise ``KeyboardInterrupt``.

    Notes
    -----
    The outcome of a member does not depend on the other members.

    Raises
    ------
    InputError
        For values that a part does not allow, and machines without averaged equations where these are requested.
    """
    told = report or (lambda _share: None)
    variants = Variants.among(question.machine, values, starts.shape[1])
    alone = np.ones(starts.shape[1], bool) if why_one_by_one(question) is not None else turns_otherwise(question, variants)
    one_by_one, together = np.flatnonzero(alone), np.flatnonzero(~alone)
    parts, share = list[MemberOutcomes](), len(one_by_one) / len(alone)
    if len(one_by_one):
        mine = variants.taken(one_by_one)
        parts.append(run_up_each(question, starts[:, one_by_one], mine, part_of(told, 0.0, share)))
    if len(together):
        mine = variants.taken(together).compact
        parts.append(_in_batches(question, starts[:, together], mine, part_of(told, share, 1 - share)))
    return MemberOutcomes.joined(parts).taken(np.argsort(np.concatenate([one_by_one, together])))


def _in_batches(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
    """Return the outcomes of members that are integrated in batches."""
    machine = question.machine
    horizon = Horizon.of(machine, RunSettings(), initial_state(machine, {}))
    outcomes, closer = _first_looked_at(question, starts, variants, horizon, part_of(report, 0.0, _FIRST_LOOK))
    closer = np.union1d(closer, np.flatnonzero(begins_fast(starts, machine, horizon)))
    if not len(closer):
        return outcomes
    rest = part_of(report, _FIRST_LOOK, 1 - _FIRST_LOOK)
    seen = looked_at(question, starts[:, closer], variants.taken(closer).compact, horizon, rest)
    return outcomes.replaced(closer, seen)


def _first_looked_at(
    question: EnsembleQuestion, starts: np.ndarray, variants: Variants, horizon: Horizon, report: Report
) -> tuple[MemberOutcomes, np.ndarray]:
    """Return the outcomes of the members that the screening decides, and the numbers of the other ones."""
    equations = equations_of(question, starts[:, 0])
    first, until = horizon.first, question.until
    pace = DoublingPace(first, 1 + _MOST_DOUBLINGS) if until is None else DoublingPace.until(until, first)
    attractors = attractors_of(question, equations, horizon)
    look = FirstLook(equations, variants, attractors, pace, until is not None, Noise.of(question.tolerance))
    members = Numbered(
        np.ascontiguousarray(equations.starts(starts, variants).T),
        parameters_of(equations.system, variants),
        np.arange(starts.shape[1]),
    )
    compiled = compile_ensemble(equations.system, question.tolerance)
    parts, numbers, failures = [], [np.zeros(0, int)], dict[int, str]()
    for tile in tiles(compiled, members, look, pace, report=report):
        record, ends = tile.ends.record, tile.ends
        failed = ends.status == Status.FAILED
        outcome = np.where(failed, OUTCOMES.index(Outcome.FAILED), record.outcome).astype(np.int8)
        parts.append(MemberOutcomes(outcome, record.settling, np.sqrt(record.square), ends.times))
        numbers.append(record.number[record.closer & ~failed])
        failures |= {int(record.number[i]): why for i, why in ends.sentences.items()}
    joined = MemberOutcomes.joined(parts)
    return joined.with_failures(failures), np.concatenate(numbers)
