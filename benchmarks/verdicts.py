"""Whether verdicts hold: random machines and starts, judged at a time T, at 4 T and at 16 T, and at the time that was advised.

``python -m benchmarks.verdicts [COUNT [FIRST]]``: so many machines, from a number on; the same number is the same machine.
"""

from __future__ import annotations

import math
import sys
import time as clock
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.numerics.flow.compiled import compile_system
from wucht.results.outcomes import Outcome
from wucht.studies.motion.verdict import Verdict, judge
from wucht.studies.motion.watched import Leg, Watched
from wucht.studies.run_up.horizon import SPEED_LIMIT
from wucht.studies.run_up.prepare import Case, prepare_case
from wucht.studies.run_up.spec import RunUp

Document = dict[str, Any]
_STRUCTURES = 120  # machines that differ in more than numbers: each has to be compiled
_TIMES = (1.0, 4.0, 16.0)
_LONGEST = 3000.0  # times T: advice beyond that is not followed
_MOST_TURNS = 200_000.0


def machine_of(number: int) -> tuple[Document, Document, float]:
    """A machine, a start and a time T."""
    kinds, draw = np.random.default_rng(number % _STRUCTURES), np.random.default_rng(10_000 + number)

    def between(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(math.log(low), math.log(high))))

    def one(*values: Any) -> Any:
        return values[int(kinds.integers(len(values)))]

    total, natural, ratio = between(1, 20), between(15, 150), between(0.004, 0.15)
    k, c = total * natural**2, 2 * ratio * total * natural
    share = draw.uniform(0.1, 0.7)
    carrier: Document = one(
        {"directions": "x"}, {"directions": "xy"}, {"directions": "xy"}, {"directions": "xy", "unequal": True}, {"directions": "xyr"},
        {"directions": "fixed"}, {"directions": "xy", "shaken": True}, {"directions": "r"},
    )  # fmt: skip
    carrier = dict(carrier)
    unequal, shaken = carrier.pop("unequal", False), carrier.pop("shaken", False)
    unbalance = total * between(2e-4, 5e-3)
    if carrier["directions"] == "r":
        carrier |= {"inertia": total * 0.1, "rotation_stiffness": 0.1 * k, "rotation_damping": 0.1 * c}
    elif carrier["directions"] != "fixed":
        stretch = between(1.1, 3) if unequal else 1.0
        carrier |= {"mass": total * (1 - share), "stiffness": [k, k * stretch] if unequal else k, "damping": c}
        if carrier["directions"] == "xyr":
            carrier |= {"inertia": total * 0.05, "rotation_stiffness": 0.05 * k * between(0.5, 4), "rotation_damping": 0.05 * c}
        if shaken:
            carrier["motion"] = {"direction": "x", "amplitude": unbalance / total * between(0.3, 5), "frequency": natural * between(0.3, 2)}
    carrier["gravity"] = one(0.0, 0.0, 9.81)

    peak = unbalance**2 * natural**3 / (2 * c)  # of the vibration torque
    free, stall = natural * between(0.6, 4), peak * between(0.1, 6)
    slope, inertia = stall / free, stall / natural**2 * between(3, 100)
    sense = one(1.0, 1.0, 1.0, -1.0)
    drum = {"kind": "rotor", "name": "drum", "mass": total * share, "unbalance": unbalance,
            "inertia": inertia + unbalance**2 / (total * share) * 1.001}  # fmt: skip
    if one(False, True):
        drum["bearing_damping"] = slope * between(1e-3, 0.3)
    if carrier["directions"] in ("r", "xyr"):
        drum["position"] = [0.1, 0.05]
    bodies, start = [drum], {"drum": {"angle": draw.uniform(-3, 3)}}
    for name in one((), (), ("p",), ("p", "q"), ("p", "q"), ("p", "q", "r")):
        arm, own = between(0.03, 0.15), unbalance * between(0.3, 2)
        body = one("pendulum", "pendulum", "roller", "slider")
        rate = natural * between(3e-3, 0.5)
        if body == "pendulum":
            bodies.append({"kind": body, "name": name, "about": "drum", "mass": own / arm, "length": arm, "damping": own * arm * rate})
        elif body == "roller":
            bodies.append({"kind": body, "name": name, "about": "drum", "mass": own / (0.8 * arm), "track_radius": arm, "radius": 0.2 * arm,
                           "damping": own * arm * rate * 0.04})  # fmt: skip
        else:
            m = own / arm
            bodies.append({"kind": body, "name": name, "about": "drum", "mass": m, "radius": arm, "angle": draw.uniform(-3, 3),
                           "stiffness": m * (3 * max(free, natural)) ** 2 * between(1, 9), "damping": m * natural * between(0.1, 2)})  # fmt: skip
        if body != "slider":
            start[name] = {"angle": draw.uniform(-3, 3)}
    drives: list[Document] = [_drive(one("linear", "linear", "linear", "constant-torque", "constant-speed", "dc-separate", "dc-shunt", "dc-series",
                              "induction", "table", "synchronous"), sense, slope, free, stall)]  # fmt: skip
    if drives[0]["kind"] == "constant-torque" and "bearing_damping" not in drum and one(True, False):
        drum["bearing_damping"] = slope
    if one(*(False,) * 6, True) and carrier["directions"] in ("x", "xy", "xyr"):
        second = {**drum, "name": "second", "unbalance": unbalance * between(0.5, 2), "inertia": 4 * drum["inertia"]}
        if "position" in drum:
            second["position"] = [-0.1, 0.05]
        bodies.append(second)
        drives.append(_drive("linear", one(1.0, -1.0), slope * between(0.7, 1.4), free * between(0.8, 1.2), stall))
        start["second"] = {"angle": draw.uniform(-3, 3)}
        drives[0]["on"], drives[1]["on"] = "drum", "second"
    if drives[0]["kind"] in ("constant-speed", "synchronous"):
        del start["drum"]
    loads: list[Document] = []
    if drives[0]["kind"] not in ("constant-speed", "synchronous"):
        load = one(None, None, "viscous", "quadratic", "coulomb")
        size = stall * between(0.01, 0.3)
        if load == "viscous":
            loads = [{"kind": load, "on": "drum", "coefficient": size / free}]
        elif load == "quadratic":
            loads = [{"kind": load, "on": "drum", "coefficient": size / free**2}]
        elif load == "coulomb":
            loads = [{"kind": load, "on": "drum", "torque": size}]
        if one(False, False, True):
            start["drum"]["speed"] = sense * free * draw.uniform(0.2, 1.5)
    until = between(20, 300) * 2 * math.pi / natural
    return {"carrier": carrier, "bodies": bodies, "drives": drives, "loads": loads}, start, until


def _drive(kind: str, sense: float, slope: float, free: float, stall: float) -> Document:
    """A drive with about this slope and speed without load."""
    if kind == "linear":
        return {"kind": kind, "slope": slope, "no_load_speed": sense * free}
    if kind == "constant-torque":
        return {"kind": kind, "torque": sense * stall / 2}
    if kind == "constant-speed":
        return {"kind": kind, "speed": sense * free}
    if kind == "synchronous":
        return {"kind": kind, "frequency": free / (2 * math.pi), "pole_pairs": 1} if sense > 0 else {"kind": "constant-speed", "speed": -free}
    if kind == "dc-separate":
        flux = math.sqrt(slope)
        return {"kind": kind, "voltage": sense * flux * free, "armature_resistance": 1.0, "motor_constant": 1.0, "flux": flux}
    if kind == "dc-shunt":
        volts = math.sqrt(stall * free)
        return {"kind": kind, "voltage": volts, "armature_resistance": 1.0, "field_resistance": 1.0, "field_inductance": 1 / free,
                "motor_constant": 1.0}  # fmt: skip
    if kind == "dc-series":
        return {"kind": kind, "voltage": math.sqrt(stall * free), "armature_resistance": 0.7, "field_resistance": 0.3,
                "field_inductance": 1 / free, "motor_constant": 1.0}  # fmt: skip
    if kind == "induction":
        volts = math.sqrt(stall * free / 3)
        return {"kind": kind, "voltage": volts, "frequency": free / (2 * math.pi), "pole_pairs": 1, "stator_resistance": 0.2,
                "rotor_resistance": 0.3, "stator_reactance": 0.4, "rotor_reactance": 0.4}  # fmt: skip
    speeds = np.linspace(0, 1.5 * free, 7)
    return {"kind": "table", "points": [[float(w), float(stall * (1 - (w / free) ** 3))] for w in speeds]}


@dataclass(frozen=True)
class Course:
    """The verdicts on one machine: (time, outcome) in order; advised: the time first advised, and the outcome then."""

    number: int
    verdicts: tuple[tuple[float, str], ...]
    advised: tuple[float, str] | None
    turns: float
    seconds: float
    error: str = ""

    @property
    def contradictions(self) -> bool:
        """Whether a verdict changed that was one."""
        known = [o for _, o in self.verdicts if o != Outcome.UNIDENTIFIED]
        return len(set(known)) > 1


def course(number: int) -> Course:
    """Run a machine and judge it at T, 4 T, 16 T, and at the first advised time."""
    document, start, until = machine_of(number)
    begun = clock.perf_counter()
    try:
        machine = machine_from(document)
        case = prepare_case(RunUp(until=until, start=start), machine, start)
    except WuchtError as error:
        return Course(number, (), None, 0.0, clock.perf_counter() - begun, str(error))
    motion, found, advised, outcome = _Motion(case), [], None, None
    goals = [t * until for t in _TIMES]
    while goals:
        goal = goals.pop(0)
        verdict = motion.until(goal)
        found.append((goal / until, str(verdict.outcome)))
        if advised is not None and outcome is None and goal >= advised:
            outcome = str(verdict.outcome)
        if advised is None and verdict.needed is not None:
            advised = verdict.needed
            if advised < _LONGEST * until and motion.turns * advised / goal < _MOST_TURNS:
                goals = sorted({*goals, advised})
        if verdict.outcome in (Outcome.FAILED, Outcome.RUNAWAY):
            outcome = outcome or str(verdict.outcome)
            break
    at = None if advised is None else (advised / until, outcome or "")
    return Course(number, tuple(found), at, motion.turns, clock.perf_counter() - begun)


class _Motion:
    """A run that goes on."""

    def __init__(self, case: Case) -> None:
        self.case, (model,), horizon = case, case.models, case.horizon
        compiled = compile_system(model.system, RunUp().tolerance, model.events(horizon.events))
        self.watched = Watched(case.watch, compiled, model.seen, horizon.vibration, horizon.energy)
        self.leg: Leg = self.watched.begin(model.initial, model.values)

    @property
    def turns(self) -> float:
        """Of the main rotor, since it last turned back."""
        return self.leg.observation.rotors[self.case.machine.rotor.name].turns

    def until(self, time: float) -> Verdict:
        """The verdict at a time."""
        begin = self.leg.stored.end_time
        if not self.leg.stored.ended:
            self.leg = self.watched.leg(self.leg, np.linspace(begin, time, 1 + math.ceil(20 * (time - begin) / time)))
        last, machine = self.leg.stored, self.case.machine
        free = free_speed(machine.at(last.end_time), machine.rotor, last.end_time)
        return judge(machine, self.leg.observation, free, last.failure, last.stopped_by == SPEED_LIMIT)


def measure(count: int = 200, first: int = 0) -> Iterator[tuple[str, str]]:
    """What came of so many machines."""
    courses: list[Course] = []
    with ProcessPoolExecutor(2) as pool:
        for done in pool.map(course, range(first, first + count), chunksize=2):
            courses.append(done)
            if done.error or done.contradictions or (done.advised and done.advised[1] in ("", "unidentified")):
                print(done, flush=True)
    judged = [c for c in courses if c.verdicts]
    outcomes = Counter(c.verdicts[-1][1] for c in judged)
    undecided = [c for c in judged if c.advised is not None]
    decided = sum(c.advised is not None and c.advised[1] not in ("", Outcome.UNIDENTIFIED) for c in undecided)
    yield "machines", f"{len(judged)}, {sum(bool(c.error) for c in courses)} refused"
    yield "verdicts that changed", f"{sum(c.contradictions for c in judged)}"
    yield "unidentified at T", f"{len(undecided)}"
    yield "decided by the advice at once", f"{decided} of {len(undecided)}, {100 * decided / max(len(undecided), 1):.1f} %"
    yield "unidentified at the advised time", f"{100 * (len(undecided) - decided) / max(len(judged), 1):.2f} %"
    for name, n in outcomes.most_common():
        yield f"at the end {name}", f"{n}"


if __name__ == "__main__":
    for label, value in measure(*map(int, sys.argv[1:])):
        print(f"  {label:40} {value}")
