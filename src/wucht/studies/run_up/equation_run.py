"""A run of equations of a table ``[system]``, and its answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from wucht.dynamics.limit_sets.conservation import CONSERVATIVE_MOTION, preserves_volume
from wucht.dynamics.limit_sets.descriptions import sentence_of
from wucht.dynamics.limit_sets.limit_set import MotionKind
from wucht.dynamics.limit_sets.long_run import INTERVALS, LongRun, long_run
from wucht.dynamics.work import Work
from wucht.machines.subject import Subject
from wucht.studies.answer import Answer
from wucht.studies.limit_set_variables import state_limit_set
from wucht.studies.run_up.combined_runs import state_cases, variables_of_cases

_CASE_WORDS = {
    "label": "label of the run", "start": "states at the start", "value": "value of the parameter",
    "sentence": "what the motion tends to",
}  # fmt: skip
_VARIABLES_OF_CASES = ("time", "states", "limit_time", "limit_states")


@dataclass(frozen=True)
class EquationRun:
    """A run of equations. start: the state by name. value: of the parameter ``along``.

    until, tolerance, engine: as of ``long_run``. most_samples, most_places: numbers that are stored at most, over time and of
    what the motion tends to.
    """

    label: str
    start: Mapping[str, Any]
    value: float | None
    subject: Subject
    until: float | None
    tolerance: float
    engine: str | None
    most_samples: int
    most_places: int

    @property
    def stored_numbers(self) -> float:
        """A bound of the numbers that it stores."""
        return float(2 * (2 * INTERVALS + 1) * len(self.subject.system.states))

    def answers(self, work: Work) -> Iterator[Answer]:
        """Integrate it, and yield its answer."""
        report, state = partial(_tell_time, work.open_ended, self.until), np.array(list(self.start.values()))
        follow = partial(long_run, self.subject, state, self.until, self.tolerance, self.engine, report=report)
        yield Answer(self.subject.units, partial(_fill_run, self, work.unit("run", follow)))

    def state_many(
        self, along: str | None, runs: Sequence[Any], answers: Sequence[Answer], finished_count: int, a: Answer
    ) -> None:
        """State many runs over time and what they tend to, and a line for each; see ``MachineRun``."""
        results = [answer.fill() for answer in answers]
        a.attribute(**results[0].attributes)
        state_cases(a, along, runs, results, finished_count, **_CASE_WORDS)
        labels, by_name = [run.label for run in runs[: len(results)]], [{q.name: q for q in r.quantities} for r in results]
        for label, result in zip(labels, results, strict=True):
            a.line("run", "{label}: {sentence}", label=label, sentence=result.sentence)
        a.curve("case", labels, "run")
        a.add([by_name[0]["state"], by_name[0]["is_angle"]])
        a.add(variables_of_cases(by_name, _VARIABLES_OF_CASES, self.most_samples))


def _fill_run(question: EquationRun, run: LongRun, a: Answer) -> None:
    """State one run of equations."""
    system, limit, most = question.subject.system, run.limit_set, question.most_samples
    names = system.state_names
    a.sentence, a.failure = sentence_of(run.kind, limit, names), run.failure
    if limit is not None and limit.attracts is None and preserves_volume(question.subject):
        a.sentence += f"; {CONSERVATIVE_MOTION}"
    a.verdict = f"{str(run.kind).upper()}, {a.sentence}"
    a.attribute(outcome=str(run.kind), engine=run.engine, tolerance=question.tolerance, subject="system")
    if run.advised_time is not None:
        remedy = f"study.until = {run.advised_time:.4g} may tell"
        a.warn(f"the run until {run.end_time:.5g} is too short to tell what the motion tends to; {remedy}")
    a.warn(*_unstable_warnings(run))
    is_longer = run.kind is MotionKind.CHAOTIC  # examined beyond the stored states, for the time in the sentence
    a.number("outcome", str(run.kind), "outcome of the run")
    a.number("end_time", run.end_time, "time until which the motion was integrated")
    a.line("run", f"{'stored ' if is_longer else ''}until t = {{end_time:.6g}}")
    near = "time after which the motion is near to what it tends to"  # a chaotic one may end, and tends to nothing known
    a.number("settling_time", None if is_longer else run.settling_time, near, headline=True)
    a.line("settled", "after t = {settling_time:.4g}")
    a.number("advised_time", run.advised_time, "duration of a run that may tell")
    state_limit_set(a, run, names)
    thin = max(1, -(-(len(run.time) - 1) // (most - 1)))
    a.curve("time", run.time[::thin], "time")
    a.curve("state", list(names), "state")
    a.curve("is_angle", list(map(int, system.is_angle)), "1 of an angle", "", "state", coordinate=True)
    a.curve("states", run.states[:, ::thin], "value of the state", "", "state time")
    times, states = (np.empty(0), np.empty((len(names), 0))) if limit is None else limit.samples(question.most_places)
    a.curve("limit_time", times, "time on what the motion tends to", "", "place")
    a.curve("limit_states", states, "state on what the motion tends to", "", "state place")


def _unstable_warnings(run: LongRun) -> list[str]:
    """Return warnings of a start on an unstable equilibrium, or of a motion that ends in one or on an unstable orbit."""
    at = run.start_equilibrium
    if run.limit_set is not None and run.limit_set.attracts is False:
        if at is not None:
            return ["the start lies on an unstable equilibrium: any disturbance leads away from it"]
        end = "in an unstable equilibrium" if run.kind is MotionKind.EQUILIBRIUM else "on an unstable orbit"
        return [f"the motion ends {end}, which is reached from few starts only: any disturbance leads away"]
    if at is not None and at.attracts is False:
        return [
            "the start lies on an unstable equilibrium: the motion leaves it by rounding alone, so that where it leads is not "
            "determined; start beside it"
        ]
    return []


def _tell_time(work: Work, until: float | None, time: float) -> None:
    work.report(time / until if until else 0.0, f"t = {time:.4g}")
