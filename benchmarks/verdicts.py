"""Whether verdicts hold: random machines and starts, judged at a time T, at 4 T and at 16 T, and at the time that was advised.

``python -m benchmarks.verdicts [COUNT [FIRST]]``: so many machines, from a number on; the same number is the same machine.
``python -m benchmarks.verdicts advice``: what is advised over what is needed, on twelve machines. Needed is the shortest run
whose verdict holds for all longer ones.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

import wucht
from benchmarks.random_machines import drawn
from wucht.dynamics.run_ups.horizon import SPEED_LIMIT, RunSettings
from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.verdicts.judging import judge
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.studies.key_types import DEFAULT_TOLERANCE

_TIMES = (1.0, 4.0, 16.0)  # times T
_STEPS = 5  # so often advice is followed
_FIRST, _CLOSER, _NEAR = 20.0, 1.06, 0.01  # turns; from look to look; of the time that is needed, by bisection
_LONGEST, _MOST_TURNS = 3000.0, 200_000.0  # advice beyond that is not followed


@dataclass(frozen=True)
class Course:
    """The verdicts on one machine: times (in T) and outcomes in order. advised: likewise of runs that follow the advice, from
    the first undecided one on; empty where there is none, or it is too long to be tried."""

    number: int
    verdicts: tuple[tuple[float, str], ...]
    advised: tuple[tuple[float, str], ...]

    @property
    def changed(self) -> bool:
        """Whether a verdict changed that was one, between T and 16 T."""
        return len({o for time, o in self.verdicts if o != Outcome.UNIDENTIFIED and time <= _TIMES[-1]}) > 1

    @property
    def steps(self) -> int | None:
        """How often the advice was followed until there was a verdict; None where there was none."""
        return len(self.advised) if self.advised and self.advised[-1][1] != Outcome.UNIDENTIFIED else None


def course(number: int, tolerance: float = DEFAULT_TOLERANCE) -> Course:
    """Run a machine and judge it at T, 4 T, 16 T, and at the advised times. tolerance: of the integration."""
    of, motion = drawn(number), motion_of(number, tolerance)
    verdicts, advised, goals = list[tuple[float, str]](), list[tuple[float, str]](), [t * of.until for t in _TIMES]
    follows: float | None = of.until
    while goals:
        verdict = motion.until(goal := goals.pop(0))
        verdicts.append((goal / of.until, str(verdict.outcome)))
        over = verdict.outcome in (Outcome.FAILED, Outcome.RUNAWAY)
        if follows is not None and (goal == follows or over):
            advised += verdicts[-1:] if follows > of.until else []
            follows = verdict.needed_time if len(advised) < _STEPS else None
            if follows is not None and follows < _LONGEST * of.until and motion.turns * follows / goal < _MOST_TURNS:
                goals = sorted({*goals, follows})
        if over:
            break
    return Course(number, tuple(verdicts), tuple(advised))


def motion_of(number: int, tolerance: float = DEFAULT_TOLERANCE) -> Motion:
    """The motion of a machine, before anything of it is integrated."""
    of = drawn(number)
    return Motion(RunUpCase.of(machine_from(of.machine), of.start, RunSettings(of.until, tolerance=tolerance)))


class Motion:
    """A run that goes on."""

    def __init__(self, case: RunUpCase) -> None:
        self.case, (model,), horizon = case, case.models, case.horizon
        compiled = compile_system(model.system, horizon.tolerance, model.events(horizon.events))
        self.watched = ObservedIntegration(case.observer, compiled, model.machine_motion, horizon.vibration, horizon.energy)
        self.leg: Leg = self.watched.begin(model.initial, model.parameter_values)
        self.seen = self.watched.observation(self.leg)

    @property
    def turns(self) -> float:
        """Of the main rotor, since it last turned back."""
        return self.seen.rotors[self.case.machine.rotor.name].turns

    def until(self, time: float) -> Verdict:
        """The verdict at a time."""
        begin = self.leg.trajectory.end_time
        if not self.leg.trajectory.has_ended:
            self.leg = self.watched.leg(self.leg, np.linspace(begin, time, 1 + math.ceil(20 * (time - begin) / time)))
        last, machine, self.seen = self.leg.trajectory, self.case.machine, self.watched.observation(self.leg)
        free = free_speed(machine.at(last.end_time), machine.rotor, last.end_time)
        return judge(machine, self.seen, free, last.failure, last.stopped_by == SPEED_LIMIT)


def measure(count: int = 1200, first: int = 0) -> Iterator[tuple[str, str]]:
    """What came of so many machines; those that changed, or on which the advice did not decide, are printed."""
    with ProcessPoolExecutor(2) as pool:
        courses = list(pool.map(course, range(first, first + count), chunksize=2))
    undecided = [c for c in courses if c.verdicts[0][1] == Outcome.UNIDENTIFIED]
    for c in courses:
        if c.changed or (c in undecided and c.steps is None):
            yield f"machine {c.number}", ", ".join(f"{time:.3g} T {o}" for time, o in c.verdicts)
    yield "machines", f"{count}"
    yield "verdicts that changed between T and 16 T", f"{sum(c.changed for c in courses)}"
    yield "unidentified at T", f"{len(undecided)}"
    for steps in range(1, _STEPS + 1):
        decided = sum(c.steps is not None and c.steps <= steps for c in undecided)
        yield f"decided by the advice, followed {steps} times", f"{100 * decided / max(len(undecided), 1):.1f} %"
    for name, n in Counter(c.verdicts[-1][1] for c in courses).most_common():
        yield f"at the end {name}", f"{n}"


@dataclass(frozen=True)
class Tried:
    """A machine on which advice is tried. table: of it, or what is changed in one of the catalogue's (``of``). until: how long
    it is followed, many times what is needed."""

    name: str
    table: Mapping[str, Any]
    start: Mapping[str, Any]
    until: float
    of: str = ""

    def machine(self) -> Machine:
        """It."""
        return wucht.load_machine(self.of, dict(self.table)) if self.of else machine_from(dict(self.table))


@dataclass(frozen=True)
class Judged:
    """outcome: at the end, and at all times from ``needed`` on. advised: times of undecided runs, with what they advise."""

    outcome: str
    needed: float
    advised: tuple[tuple[float, float], ...]

    @property
    def worst(self) -> float:
        """The longest advice over what is needed."""
        return max((until / self.needed for _, until in self.advised), default=0.0)

    @property
    def steps(self) -> int:
        """How often the advice must be followed from the first run on."""
        count, time = 0, self.advised[0][0] if self.advised else math.inf
        while time < self.needed:
            count, time = count + 1, next(until for at, until in reversed(self.advised) if at <= time)
        return count


_CARRIER = {"mass": 12.0, "stiffness": [2.4e4, 4.1e4], "damping": [70.0, 95.0]}
_ROTOR = {"kind": "rotor", "name": "r", "mass": 3.0, "unbalance": 0.011, "inertia": 0.05, "bearing_damping": 3e-4}
_PENDULUMS = (
    {"kind": "pendulum", "name": "p1", "about": "r", "mass": 0.09, "length": 0.1, "damping": 0.003},
    {"kind": "pendulum", "name": "p2", "about": "r", "mass": 0.06, "length": 0.11, "inertia": 0.0009, "damping": 0.005},
)


def _two_pendulums(drive: Mapping[str, Any], load: float = 2.2e-4) -> dict[str, Any]:
    loads = [{"kind": "quadratic", "on": "r", "coefficient": load}] if load else []
    return {"carrier": _CARRIER, "bodies": [_ROTOR, *_PENDULUMS], "drives": [dict(drive, on="r")], "loads": loads}


_FIELD = {"armature_resistance": 1.5, "motor_constant": 1.0}
_SERIES = _FIELD | {"kind": "dc-series", "voltage": 42.0, "field_resistance": 1.0, "field_inductance": 0.05}
_SHUNT = _FIELD | {"kind": "dc-shunt", "voltage": 60.0, "field_resistance": 60.0, "field_inductance": 0.5}
_TABLE = {"kind": "table", "points": [[0.0, 6.0], [60.0, 5.0], [90.0, 3.0], [110.0, 0.0], [150.0, -4.0]]}
_TORQUE = _two_pendulums({"kind": "constant-torque", "torque": 2.0}) | {"bodies": [_ROTOR]}
_MAINS = {"kind": "synchronous", "frequency": 15.0, "pole_pairs": 1}
_AT, _R1 = {"p1": 1.0, "p2": 2.5}, {"p1": 0.3, "p2": -0.5}
MACHINES = (
    Tried("series motor, two pendulums", _two_pendulums(_SERIES), _AT, 200.0),
    Tried("shunt motor, two pendulums", _two_pendulums(_SHUNT), _AT, 200.0),
    Tried("torque table, two pendulums", _two_pendulums(_TABLE), _AT, 200.0),
    Tried("synchronous motor, two pendulums", _two_pendulums(_MAINS, 0.0), _AT, 200.0),
    Tried("constant torque, no balancer", _TORQUE, {}, 200.0),
    Tried("linear drive, two pendulums, compensated", {"drive.slope": 0.039}, _R1, 100.0, "drozdetskaya-2020/r1"),
    Tried("linear drive, two pendulums, modulated", {"drive.slope": 0.00585}, _R1, 250.0, "drozdetskaya-2020/r1"),
    Tried("table 5.1, modulated", {"u": 2.5}, {"psi": 0.0, "delta": 0.5}, 50_000.0, "drozdetskaya-2020/table-5.1"),
    Tried("induction motor and belt, no balancer", {}, {}, 100.0, "practice/fan-on-belt"),
    Tried("inverter, no balancer", {}, {}, 200.0, "practice/fan-on-inverter"),
    Tried("separately excited motor, ten balls", {}, {}, 60.0, "practice/fan-ball-ring"),
    Tried("constant speed, two rollers", {}, {}, 100.0, "sperling-rollers/table-1"),
)


def advice_on(of: Tried) -> Judged:
    """Run a machine up, judge it again and again, and find the shortest run whose verdict holds for all longer ones."""
    machine = of.machine()
    motion = Motion(RunUpCase.of(machine, of.start, RunSettings(of.until)))
    time = _FIRST * 2 * math.pi / abs(free_speed(machine, machine.rotor) or 2 * math.pi / 0.05)
    looks = list[tuple[float, str, float | None, Leg[Any]]]()
    while time < of.until:
        before = motion.leg
        verdict = motion.until(time)
        looks.append((time, str(verdict.outcome), verdict.needed_time, before))
        time *= _CLOSER
    final = looks[-1][1]
    last = max((i for i, (_, outcome, _, _) in enumerate(looks) if outcome != final), default=-1)
    low, high, begin = looks[last][0] if last >= 0 else 0.0, looks[last + 1][0], looks[last + 1][3]
    while high - low > _NEAR * high:
        motion.leg = begin
        middle = (low + high) / 2
        low, high = (low, middle) if str(motion.until(middle).outcome) == final else (middle, high)
    undecided = looks[: last + 1]
    advised = tuple((t, until) for t, outcome, until, _ in undecided if outcome == Outcome.UNIDENTIFIED and until is not None)
    return Judged(final, high, advised)


def measure_advice() -> Iterator[tuple[str, str]]:
    """Of each machine the outcome, what is needed, the longest advice over that, and how often it must be followed."""
    for of in MACHINES:
        j = advice_on(of)
        yield of.name, f"{j.outcome}, needed {j.needed:.3g}, advised at most {j.worst:.2f} times that, {j.steps} steps"


if __name__ == "__main__":
    asked = sys.argv[1:]
    for label, value in measure_advice() if asked == ["advice"] else measure(*map(int, asked)):
        print(f"  {label:42} {value}")
