"""Whether verdicts hold: random machines and starts, judged at a time T, at 4 T and at 16 T, and at the time that was advised.

``python -m benchmarks.verdicts [COUNT [FIRST]]``: so many machines, from a number on; the same number is the same machine.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from benchmarks.random_machines import drawn
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled import compile_system
from wucht.results.outcomes import Outcome
from wucht.studies.motion.verdict import Verdict, judge
from wucht.studies.motion.watched import Leg, Watched
from wucht.studies.run_up.horizon import SPEED_LIMIT
from wucht.studies.run_up.prepare import Case, prepare_case
from wucht.studies.run_up.spec import RunUp
from wucht.studies.spec import DEFAULT_TOLERANCE

_TIMES = (1.0, 4.0, 16.0)  # times T
_LONGEST, _MOST_TURNS = 3000.0, 200_000.0  # advice beyond that is not followed


@dataclass(frozen=True)
class Course:
    """The verdicts on one machine: times (in T) and outcomes in order. advised: the time first advised and the outcome then,
    which is empty where that is too long to be tried."""

    number: int
    verdicts: tuple[tuple[float, str], ...]
    advised: tuple[float, str] | None

    @property
    def changed(self) -> bool:
        """Whether a verdict changed that was one, between T and 16 T."""
        return len({o for time, o in self.verdicts if o != Outcome.UNIDENTIFIED and time <= _TIMES[-1]}) > 1

    @property
    def decided(self) -> bool:
        """Whether the advice, followed once, led to a verdict."""
        return self.advised is not None and self.advised[1] not in ("", Outcome.UNIDENTIFIED)


def course(number: int, tolerance: float = DEFAULT_TOLERANCE) -> Course:
    """Run a machine and judge it at T, 4 T, 16 T, and at the first advised time. tolerance: of the integration."""
    of, motion = drawn(number), motion_of(number, tolerance)
    found, advised, outcome, goals = list[tuple[float, str]](), None, "", [t * of.until for t in _TIMES]
    while goals:
        verdict = motion.until(goal := goals.pop(0))
        found.append((goal / of.until, str(verdict.outcome)))
        over = verdict.outcome in (Outcome.FAILED, Outcome.RUNAWAY)
        if advised is not None and not outcome and (goal >= advised or over):
            outcome = str(verdict.outcome)
        if over:
            break
        if advised is None and verdict.needed is not None:
            advised = verdict.needed
            if advised < _LONGEST * of.until and motion.turns * advised / goal < _MOST_TURNS:
                goals = sorted({*goals, advised})
    return Course(number, tuple(found), None if advised is None else (advised / of.until, outcome))


def motion_of(number: int, tolerance: float = DEFAULT_TOLERANCE) -> Motion:
    """The motion of a machine, before anything of it is integrated."""
    of = drawn(number)
    spec = RunUp(until=of.until, start=of.start, tolerance=tolerance)
    return Motion(prepare_case(spec, machine_from(of.machine), of.start))


class Motion:
    """A run that goes on."""

    def __init__(self, case: Case) -> None:
        self.case, (model,), horizon = case, case.models, case.horizon
        compiled = compile_system(model.system, horizon.tolerance, model.events(horizon.events))
        self.watched = Watched(case.watch, compiled, model.seen, horizon.vibration, horizon.energy)
        self.leg: Leg = self.watched.begin(model.initial, model.values)
        self.seen = self.watched.observation(self.leg)

    @property
    def turns(self) -> float:
        """Of the main rotor, since it last turned back."""
        return self.seen.rotors[self.case.machine.rotor.name].turns

    def until(self, time: float) -> Verdict:
        """The verdict at a time."""
        begin = self.leg.stored.end_time
        if not self.leg.stored.ended:
            self.leg = self.watched.leg(self.leg, np.linspace(begin, time, 1 + math.ceil(20 * (time - begin) / time)))
        last, machine, self.seen = self.leg.stored, self.case.machine, self.watched.observation(self.leg)
        free = free_speed(machine.at(last.end_time), machine.rotor, last.end_time)
        return judge(machine, self.seen, free, last.failure, last.stopped_by == SPEED_LIMIT)


def measure(count: int = 1200, first: int = 0) -> Iterator[tuple[str, str]]:
    """What came of so many machines; those that changed, or on which the advice did not decide, are printed."""
    with ProcessPoolExecutor(2) as pool:
        courses = list(pool.map(course, range(first, first + count), chunksize=2))
    undecided = [c for c in courses if c.advised is not None]
    decided = sum(c.decided for c in undecided)
    for c in courses:
        if c.changed or (c.advised is not None and not c.decided):
            yield f"machine {c.number}", ", ".join(f"{time:.3g} T {o}" for time, o in c.verdicts)
    yield "machines", f"{count}"
    yield "verdicts that changed between T and 16 T", f"{sum(c.changed for c in courses)}"
    yield "unidentified at T", f"{len(undecided)}"
    yield (
        "decided by the advice, followed once",
        f"{decided} of {len(undecided)}, {100 * decided / max(len(undecided), 1):.1f} %",
    )
    yield "unidentified at the advised time", f"{100 * (len(undecided) - decided) / count:.2f} %"
    for name, n in Counter(c.verdicts[-1][1] for c in courses).most_common():
        yield f"at the end {name}", f"{n}"


if __name__ == "__main__":
    for label, value in measure(*map(int, sys.argv[1:])):
        print(f"  {label:42} {value}")
