"""What motions tend to, stated by studies of equations and of machines: limit sets with their numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind
from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer

LIMIT_SET_NUMBERS = {
    "stable": ("whether nearby motions tend to it", ""),
    "state": ("states of the equilibrium", ""),
    "eigenvalues": ("eigenvalues of the equilibrium", "1/time"),
    "period": ("period of the orbit", "time"),
    "turns": ("turns of the angles in a period", ""),
    "multipliers": ("Floquet multipliers of the orbit, without that of its phase", ""),
}
EXPONENT = "largest Lyapunov exponent with its 95 % interval, per unit of time"
STATE_RANGES = {
    "min": ("least value of each state, of what the motion tends to", ""),
    "max": ("largest value of each state, of what the motion tends to", ""),
    "mean": ("mean value of each state, of what the motion tends to", ""),
}
_EXPONENT_PARTS = {
    "value": ("largest Lyapunov exponent", "1/time"),
    "low": ("lower end of its 95 % interval", "1/time"),
    "high": ("upper end of its 95 % interval", "1/time"),
    "duration": ("time over which it is a mean", "time"),
}
_INTERVAL = "{low:.5g} to {high:.5g}, in 19 of 20 cases; mean over a time of {duration:.4g}"


def state_limit_set(a: Answer, run: LongRun, names: tuple[str, ...]) -> None:
    """State what a run of equations tends to. names: of the states."""
    numbers: Mapping[str, Any] = {} if run.limit_set is None else numbers_of(run.limit_set, names)
    _state_numbers(a, numbers)
    for name, (long_name, unit) in STATE_RANGES.items():
        a.number(name, numbers.get(name), long_name, unit)
    _state_exponent(a, numbers)
    for name in ("eigenvalues", "multipliers"):
        if numbers.get(name):
            a.line(name, ", ".join(f"{re:.5g}" if not im else f"{re:.5g}{im:+.5g}i" for re, im in numbers[name]))
    if numbers.get("turns"):
        a.line("turns", ", ".join(f"{name} {turns:+d}" for name, turns in numbers["turns"].items()) + " a period")
    a.line("exponent", f"{{value:.5g}} ({_INTERVAL})", at="lyapunov_exponent")
    for name, low in (numbers.get("min") or {}).items() if run.kind is not MotionKind.EQUILIBRIUM else ():
        a.line("range", f"{name} {low:.6g} to {numbers['max'][name]:.6g}")


def state_machine_limit_set(a: Answer, run: LongRun, machine: Machine) -> None:
    """State what the motion of a machine tends to, and how fast the slowest disturbance decays there."""
    limit, names = run.limit_set, machine.state_names
    numbers: Mapping[str, Any] = {} if limit is None else numbers_of(limit, names)
    with a.group("limit_set", "what the motion tends to, followed from the end of the run"):
        a.number("kind", str(run.kind), "what it is")
        a.number("followed", run.end_time, "time for which the motion was followed", "time")
        _state_numbers(a, numbers)
        a.number("decay_time", _decay_time(limit), "time in which the slowest disturbance decays to 1/e", "time")
        _state_exponent(a, numbers)
        a.line("tends to", "{sentence}", sentence=sentence_of(run.kind, limit, names))
        a.line("decay", "the slowest disturbance decays to 1/e in {decay_time:.4g}")
        a.line("exponent", f"{{value:.5g}} ({_INTERVAL})", at="lyapunov_exponent")
    if run.kind is MotionKind.NOT_SETTLED:
        a.warn(
            f"limit_set: what the motion tends to is not known after {run.end_time:.4g} {a.unit('time')}".rstrip()
            + "; of an orbit on which contacts open and close no multipliers are computed"
        )
    a.warn(*([f"limit_set: {run.failure}"] if run.failure else []))


def _state_numbers(a: Answer, numbers: Mapping[str, Any]) -> None:
    for name, (long_name, unit) in LIMIT_SET_NUMBERS.items():
        a.number(name, numbers.get(name), long_name, unit, headline=name == "period")


def _state_exponent(a: Answer, numbers: Mapping[str, Any]) -> None:
    exponent = numbers.get("lyapunov_exponent") or dict.fromkeys(_EXPONENT_PARTS)
    with a.group("lyapunov_exponent", EXPONENT):
        for name, (long_name, unit) in _EXPONENT_PARTS.items():
            a.number(name, exponent[name], long_name, unit)


def _decay_time(limit: LimitSet | None) -> float | None:
    """Return the time in which the slowest disturbance decays to 1/e; None where one does not decay, or nothing is known."""
    if limit is None or not limit.attracts:
        return None
    if limit.multipliers is not None and len(limit.multipliers):
        return limit.period / -math.log(float(np.abs(limit.multipliers).max()))
    if limit.eigenvalues is not None and len(limit.eigenvalues):
        return -1 / float(limit.eigenvalues.real.max())
    return None
