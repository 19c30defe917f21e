"""Runs of equations of a table ``[system]``: where each begins, and its answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from wucht.dynamics.limit_sets.conservation import CONSERVATIVE_MOTION, preserves_volume
from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import MotionKind
from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.system_states import refuse_singular_start, states_from
from wucht.machines.subject import Subject
from wucht.studies.answer import Answer
from wucht.studies.run_up.combined_runs import RunCase, stack_padded, state_cases

MOST_PLACES = 20_001  # of what motions tend to, of all runs together
_LONG_NAMES = {
    "stable": "whether nearby motions tend to it",
    "state": "states of the equilibrium",
    "eigenvalues": "eigenvalues of the equilibrium",
    "period": "period of the orbit",
    "turns": "turns of the angles in a period",
    "multipliers": "Floquet multipliers of the orbit, without that of its phase",
    "min": "least value of each state, of what the motion tends to",
    "max": "largest value of each state, of what the motion tends to",
    "mean": "mean value of each state, of what the motion tends to",
}
_EXPONENT = {
    "value": "largest Lyapunov exponent",
    "low": "lower end of its 95 % interval",
    "high": "upper end of its 95 % interval",
    "duration": "time over which it is a mean",
}
_CASE_WORDS = {
    "label": "label of the run", "start": "states at the start", "value": "value of the parameter",
    "sentence": "what the motion tends to",
}  # fmt: skip
_VARIABLES_OF_CASES = (("time", "sample"), ("states", "state sample"), ("limit_time", "place"), ("limit_states", "state place"))


def system_cases(
    subject: Subject, starts: Mapping[str, Mapping[str, Any]], is_named: bool, along: str | None, values: Sequence[Any]
) -> tuple[RunCase, ...]:
    """Return the runs: the equations and the start (n,) of each.

    starts: by their place in the file. is_named: a label names them. Raises ``InputError`` for a state that the equations lack.
    """
    states = {at: states_from(subject.system, values_by_name, at) for at, values_by_name in starts.items()}
    parameter = None if along is None else parameter_of(subject, along)
    cases = list[RunCase]()
    for value in (None,) if parameter is None else values_of(subject, parameter, values):
        variant = subject if parameter is None or value is None else subject.with_values({parameter.path: value})
        names = [] if parameter is None or value is None else [f"{parameter.path} = {value:.6g}"]
        for at, start in states.items():
            refuse_singular_start(variant, start, at)
            by_name = dict(zip(subject.system.state_names, start.tolist(), strict=True))
            place = ", ".join(f"{name} = {x:.6g}" for name, x in by_name.items() if x)
            label = "; ".join([*names, *([place or "all states 0"] if is_named else [])])
            cases.append(RunCase(label, by_name, value, (variant, start)))
    return tuple(cases)


def fill_system_run(subject: Subject, run: LongRun, most: int, most_places: int, tolerance: float, a: Answer) -> None:
    """State one run of equations. most, most_places: numbers of samples, over time and of what the motion tends to."""
    system, names, limit = subject.system, subject.system.state_names, run.limit_set
    a.sentence, a.failure = sentence_of(run.kind, limit, names), run.failure
    if limit is not None and limit.attracts is None and preserves_volume(subject):
        a.sentence += f"; {CONSERVATIVE_MOTION}"
    a.verdict = f"{str(run.kind).upper()}, {a.sentence}"
    a.attribute(outcome=str(run.kind), engine=run.engine, tolerance=tolerance, subject="system")
    if run.advised_time is not None:
        a.warn(
            f"the run until {run.end_time:.5g} is too short to tell what the motion tends to; study.until = "
            f"{run.advised_time:.4g} may tell"
        )
    a.warn(*_unstable_warnings(run))
    is_longer = run.kind is MotionKind.CHAOTIC  # examined beyond the stored states, for the time in the sentence
    a.number("outcome", str(run.kind), "outcome of the run")
    a.number("end_time", run.end_time, "time until which the motion was integrated")
    a.line("run", f"{'stored ' if is_longer else ''}until t = {{end_time:.6g}}")
    near = "time after which the motion is near to what it tends to"  # a chaotic one may end, and tends to nothing known
    a.number("settling_time", None if is_longer else run.settling_time, near, headline=True)
    a.line("settled", "after t = {settling_time:.4g}")
    a.number("advised_time", run.advised_time, "duration of a run that may tell")
    _state_limit(a, {} if limit is None else numbers_of(limit, names), is_at_rest=run.kind is MotionKind.EQUILIBRIUM)
    thin = max(1, -(-(len(run.time) - 1) // (most - 1)))
    a.curve("time", run.time[::thin], "time")
    a.curve("state", list(names), "state")
    a.curve("is_angle", [int(s in system.angles) for s in system.states], "1 of an angle", "", "state", coordinate=True)
    a.curve("states", run.states[:, ::thin], "value of the state", "", "state time")
    times, states = (np.empty(0), np.empty((len(names), 0))) if limit is None else limit.samples(most_places)
    a.curve("limit_time", times, "time on what the motion tends to", "", "place")
    a.curve("limit_states", states, "state on what the motion tends to", "", "state place")


def _state_limit(a: Answer, numbers: Mapping[str, Any], is_at_rest: bool) -> None:
    """State what a motion tends to."""
    for name, long_name in _LONG_NAMES.items():
        a.number(name, numbers.get(name), long_name, headline=name == "period")
    exponent = numbers.get("lyapunov_exponent") or dict.fromkeys(_EXPONENT)
    with a.group("lyapunov_exponent", "largest Lyapunov exponent with its 95 % interval, per unit of time"):
        for name, long_name in _EXPONENT.items():
            a.number(name, exponent[name], long_name)
    for name in ("eigenvalues", "multipliers"):
        if numbers.get(name):
            a.line(name, ", ".join(f"{re:.5g}" if not im else f"{re:.5g}{im:+.5g}i" for re, im in numbers[name]))
    if numbers.get("turns"):
        a.line("turns", ", ".join(f"{name} {turns:+d}" for name, turns in numbers["turns"].items()) + " a period")
    interval = "{low:.5g} to {high:.5g}, in 19 of 20 cases; mean over a time of {duration:.4g}"
    a.line("exponent", f"{{value:.5g}} ({interval})", at="lyapunov_exponent")
    for name, low in (numbers.get("min") or {}).items() if not is_at_rest else ():
        a.line("range", f"{name} {low:.6g} to {numbers['max'][name]:.6g}")


def _unstable_warnings(run: LongRun) -> list[str]:
    """Return warnings of a start on an unstable equilibrium, or of a motion that ends in one."""
    at = run.start_equilibrium
    if run.limit_set is not None and run.limit_set.attracts is False:
        if at is not None:
            return ["the start lies on an unstable equilibrium: any disturbance leads away from it"]
        return ["the motion ends in an unstable equilibrium, which is reached from few starts only: any disturbance leads away"]
    if at is not None and at.attracts is False:
        return [
            "the start lies on an unstable equilibrium: the motion leaves it by rounding alone, so that where it leads is not "
            "determined; start beside it"
        ]
    return []


def fill_system_runs(
    along: str | None, cases: Sequence[RunCase], most: int, tolerance: float, runs: Sequence[LongRun], a: Answer
) -> None:
    """State many runs of equations. most: samples of all together."""
    fills = [
        partial(fill_system_run, case.run[0], run, max(most // len(cases), 2), MOST_PLACES // len(cases), tolerance)
        for case, run in zip(cases, runs, strict=False)
    ]
    results = [Answer(fill=fill).fill() for fill in fills]
    a.attribute(**results[0].attributes)
    state_cases(a, along, cases, results, len(results), _CASE_WORDS)
    by_name = [{q.name: q for q in r.quantities} for r in results]
    for case, result in zip(cases, results, strict=False):
        a.line("run", "{label}: {sentence}", label=case.label, sentence=result.sentence)
    a.curve("case", [case.label for case, _ in zip(cases, results, strict=False)], "run")
    a.add([by_name[0]["state"], by_name[0]["is_angle"]])
    for name, inner in _VARIABLES_OF_CASES:
        values = stack_padded([quantities[name].value for quantities in by_name])
        a.curve(name, values, by_name[0][name].long_name, "", f"case {inner}")
