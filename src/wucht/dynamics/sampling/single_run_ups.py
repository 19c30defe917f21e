"""Members that cannot be integrated in batches: each is run up by itself."""

from __future__ import annotations

import math

import numpy as np

from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import placed
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.dynamics.sampling.ensemble_equations import Variants
from wucht.dynamics.sampling.ensemble_question import EnsembleQuestion, Report
from wucht.dynamics.sampling.member_outcomes import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import Work


def run_up_each(question: EnsembleQuestion, starts: np.ndarray, variants: Variants, report: Report) -> MemberOutcomes:
    """What becomes of members that start in states (n, M) of the machine's System."""
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
