"""Members that cannot be integrated in batches: each is run up by itself."""

from __future__ import annotations

import math

import numpy as np

from wucht.studies.ensembles.ensemble_equations import Variants
from wucht.studies.ensembles.ensemble_question import EnsembleQuestion, Report
from wucht.studies.ensembles.member_outcomes import OUTCOMES, MemberOutcomes
from wucht.studies.initial_state import placed
from wucht.studies.run_up.horizon import Horizon
from wucht.studies.run_up.model import FullModel, slow_model
from wucht.studies.run_up.prepare import Case
from wucht.studies.run_up.run import run_case
from wucht.studies.run_up.spec import RunUp
from wucht.studies.work import Work


def run_up_each(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
    """What becomes of members that start in states (n, M) of the machine's System."""
    count = starts.shape[1]
    spec = RunUp(model=question.model, tolerance=question.tolerance, **_end(question))
    outcome, failures = np.zeros(count, np.int8), dict[int, str]()
    settling, peak, end = np.full((3, count), math.nan)
    for i in range(count):
        machine = placed(variants.machines[variants.of[i]], starts[:, i])
        if question.model == "full":
            model = FullModel(machine, starts[:, i])
        else:
            model = slow_model(machine, starts[:, i], question.inertia, question.order)
        case = Case(str(i), {}, None, machine, Horizon.of(machine, spec, starts[:, i]), (model,))
        for (motion,) in run_case(spec, case, Work()):
            report((i + min(motion.last.stored.end_time / case.horizon.expected_end, 1.0)) / count)
        verdict, last = motion.verdict, motion.last.stored
        outcome[i], peak[i], end[i] = OUTCOMES.index(verdict.outcome), motion.observation.largest, last.end_time
        settling[i] = math.nan if verdict.settling_time is None else verdict.settling_time
        if last.failure:
            failures[i] = last.failure
    return MemberOutcomes(outcome, settling, peak, end, tuple(failures.items()))


def _end(question: EnsembleQuestion) -> dict[str, float | bool]:
    return {"settled": True} if question.until is None else {"until": question.until}
