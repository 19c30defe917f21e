"""The answer of a sweep: its ways, the jumps on them, and where the state depends on the direction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

from wucht.dynamics.sweeps.course import Ends, SweepCourse
from wucht.schema import Parameter
from wucht.studies.answer import Answer
from wucht.studies.sweep.figure import SENSE

_KEYS = {"before": "from", "after": "to"}  # of a jump, by the names that Python does not allow


@dataclass(frozen=True)
class Observables:
    """What is read of the subject of a sweep: speed and amplitude of a machine, or the states of equations.

    follower: what follows the parameter, in words. pace: how it is moved, in the report. jump_parts: numbers of a jump beside
    the value of the parameter, each with words and unit. jump_columns: variables of the Dataset, whose names begin with
    ``jump_``, by the numbers that they have. jump_lines: of the report. accuracy: of jumps, in the report. last_line: its
    heading and text. state_ways: states what is recorded on each way.
    """

    follower: str
    pace: str
    jump_parts: Mapping[str, tuple[str, str]]
    jump_columns: Mapping[str, str]
    jump_lines: Sequence[str]
    accuracy: str
    last_line: tuple[str, str] | None
    state_ways: Callable[[Answer, Parameter, SweepCourse], None]


@dataclass(frozen=True)
class SweepQuestion:
    """A swept parameter.

    ends: its lowest and highest value. ways: its first and last value on each way, in their order. is_rate_chosen: true where
    its rate is the program's choice.
    """

    parameter: Parameter
    ends: Ends
    ways: Mapping[str, Ends]
    rate_unit: str
    is_rate_chosen: bool

    @property
    def first_value(self) -> float:
        """Where the sweep begins."""
        return next(iter(self.ways.values()))[0]


def state_sweep(question: SweepQuestion, observables: Observables, course: SweepCourse, a: Answer) -> None:
    """State the answer as far as the sweep has come."""
    parameter, (low, high), between = question.parameter, question.ends, course.hysteresis
    unit_after = f" {parameter.unit}" if parameter.unit else ""
    a.failure = course.failure
    a.attribute(along=parameter.path, along_unit=parameter.unit, **({} if course.rate is None else {"rate": course.rate}))
    a.warn(*course.doubts)
    _state_jumps(a, parameter, observables, course)
    a.number("along", parameter.path, "swept parameter")
    a.number("along_unit", parameter.unit, "unit of the swept parameter")
    a.number("range", [low, high], "lowest and highest value of the parameter", parameter.unit)
    a.number("rate", course.rate, "rate of the parameter", question.rate_unit)
    a.number("rate_unit", question.rate_unit, "unit of the rate")
    a.number("rate_chosen", question.is_rate_chosen, "whether the rate is the program's choice")
    a.number("span", course.span, "time for each value of the parameter", "time")
    a.line("sweep", f"{{along}} from {low:.5g} to {high:.5g}{unit_after} {observables.pace}")
    observables.state_ways(a, parameter, course)
    for k, jump in enumerate(course.jumps):
        a.line("jump", f"{SENSE[jump.direction]}, at {parameter.path} = {jump.value:.6g}{unit_after}:")
        for line in observables.jump_lines:
            a.line("", line, at=f"jumps[{k}]")
    a.number("hysteresis", between, "range in which the state depends on the direction", parameter.unit)
    dependence = ""
    if between:
        ends = f"between {between[0]:.6g} and {between[1]:.6g}{unit_after}"
        dependence = f"{ends} the state depends on the direction of the sweep"
        a.line("hysteresis", dependence)
    if course.jumps:
        a.line("accuracy", observables.accuracy)
    if observables.last_line:
        a.line(*observables.last_line)
    if course.failure or not course.is_complete:
        a.sentence = "the sweep failed" if course.failure else "the sweep was interrupted"
        a.warn(course.failure or "the sweep is not finished: jumps may be missing")
        return
    changes = [f"at {parameter.value_text(j.value)} {SENSE[j.direction]} {j.change}" for j in course.jumps]
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(changes), f"{len(changes)} JUMPS")
    if not changes:
        follows = f"the {observables.follower} follows {parameter.sentence_name} between {low:.5g} and {high:.5g}"
        changes = [follows]
    if len({j.direction for j in course.jumps}) < 2 and dependence:  # which two jumps tell by themselves
        changes.append(dependence)
    text = "; ".join(changes)
    a.sentence, a.verdict = text if course.jumps else f"no jump: {text}", f"{count}: {text}"


def _state_jumps(a: Answer, parameter: Parameter, observables: Observables, course: SweepCourse) -> None:
    """State the jumps, in the summary with the value of the parameter under its path."""
    words = (parameter.full_name, parameter.unit)
    parts = {parameter.path: words, "value": words}
    parts |= {name: (what, a.unit(unit)) for name, (what, unit) in observables.jump_parts.items()}
    parts |= {
        "direction": ("direction in which the parameter moves", ""),
        "bracket": ("values between which the branch ends", parameter.unit),
    }
    rows = [
        {parameter.path: jump.value, **{_KEYS.get(key, key): x for key, x in asdict(jump).items()}} for jump in course.jumps
    ]
    a.number("jumps", rows, "jumps, in the order in which they occur", parts=parts)
    for name, part in observables.jump_columns.items():
        a.curve(f"jump_{name}", [row[part] for row in rows], *parts[part], "jump")
    a.curve("jump_upward", [int(jump.direction == "up") for jump in course.jumps], "1 where the parameter rises", "", "jump")
