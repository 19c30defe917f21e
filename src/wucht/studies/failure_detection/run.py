"""Plan -> findings: the run with the failure, what the averaged equations say of it, and the signal at other values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np

from wucht.dynamics.exciters.failing_machine import FailingRun
from wucht.dynamics.exciters.speed_readings import (
    AveragedSpeed,
    Detection,
    Readings,
    Windows,
    averaged_speed,
    detection_of,
    readings_of,
)
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.studies.failure_detection.prepare import Plan

_OWN, _CHECKED = 0.3, 0.35  # shares of the work where other values are looked at
_ROUNDS = 4  # of halving the steps to the values beside the best one
_SETTLE = 3.0  # times the part over which the mean is taken
_EVEN = 1e-4  # of the speed: readings that differ more are those of a motion that beats, or has not settled
_BEATS = (Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED, Outcome.UNIDENTIFIED)


@dataclass(frozen=True, eq=False)
class Seen:
    """A run, its windows, and the sensor's readings."""

    run: FailingRun
    windows: Windows
    readings: Readings


@dataclass(frozen=True)
class Place:
    """What was found at other values. speeds: before and after, signal: None where the specimen did not fail, or too late."""

    values: tuple[float, ...]
    before: float | None
    after: float | None
    signal: float | None
    outcome: str


@dataclass(frozen=True, eq=False)
class Findings:
    """own: the machine's own run. detection: of its failure. averaged: the speeds before and after by the averaged equations.
    places: at other values. undetected: why there is no chart, if there should be one."""

    own: Seen
    detection: Detection | None = None
    averaged: tuple[AveragedSpeed, AveragedSpeed] | None = None
    places: tuple[Place, ...] = field(default_factory=tuple)
    undetected: str = ""


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The findings, more and more complete."""
    shares = (_OWN, _CHECKED) if plan.along is not None else (0.9, 1.0)
    for failing in plan.failing(plan.case).run(work.part("own", 0.0, shares[0])):
        own = _seen(plan, failing)
        yield Findings(own)
    detection, undetected = _detection(plan, own)
    checked = work.part("averaged", *shares)
    averaged = None
    if own.readings.before is not None and own.readings.after is not None:
        before, after = (checked.unit(name, partial(_averaged, plan, own, name == "after")) for name in ("before", "after"))
        averaged = before, after
    checked.report(1.0, "averaged equations")
    found = Findings(own, detection, averaged, undetected=undetected)
    yield found
    for places in _places(plan, work.part("variant", shares[1], 1.0)):
        yield replace(found, places=places)


def _seen(plan: Plan, failing: FailingRun) -> Seen:
    windows = _windows(plan, failing)
    return Seen(failing, windows, readings_of(failing.course.time, failing.course.angle, plan.spec.sensor.interval, windows))


def _windows(plan: Plan, failing: FailingRun) -> Windows:
    """When the speed is taken, in a run so far."""
    spec, end = plan.spec, float(failing.course.time[-1])
    if plan.scheduled is not None:
        begin, over = plan.scheduled.begin, plan.scheduled.end
        failed = watched = begin if end > begin else None
    else:
        broken = failing.standing.broken
        gradual, learnt = plan.gradual, (spec.after or 0.0) + (spec.learning or 0.0)
        # What falls gradually may drive the exciter out of its resonance, and be spared from then on: it is seen all the same.
        over = broken if broken is not None else learnt if gradual else end
        begin, failed, watched = (learnt, broken, learnt) if gradual else (over, broken, broken)
    after = begin / 2 if spec.after is None else spec.after
    until = begin if spec.learning is None else after + spec.learning
    until = min(until, begin, end)
    normal = (after, until) if until > after else None
    changed = ((over + end) / 2, end) if watched is not None and end > over else None
    return Windows(normal, changed, watched, failed)


def _detection(plan: Plan, own: Seen) -> tuple[Detection | None, str]:
    """How soon it is seen; None, and why, where there is no chart."""
    sensor = plan.spec.sensor
    every = sensor.false_alarm_every / sensor.interval
    try:
        return detection_of(own.readings, own.windows, sensor.noise, every, sensor.change, not plan.gradual), ""
    except RunError as error:
        return None, str(error)


def _averaged(plan: Plan, own: Seen, failed: bool) -> AveragedSpeed:
    """Before the failure, or after it."""
    machine, model = plan.case.machine, plan.case.models[0]
    standing = own.run.standing
    verdict, mean = (
        (own.run.verdict, own.readings.after) if failed else (own.run.before or own.run.verdict, own.readings.before)
    )
    assert mean is not None
    if failed and plan.spec.failure is not None:
        falling = plan.failing(plan.case).falling
        assert falling is not None
        machine = machine.with_unchecked({falling.parameter: falling.value * float(own.run.course.stiffness[-1])})
    window = own.windows.changed if failed else own.windows.normal
    assert window is not None
    steady = machine.at(window[1] if failed else window[0]).changed(schedules=())
    # The averaged equations go on from the full motion, and have time to come to their own before the mean is taken.
    leg = standing.last if failed else standing.begun or standing.last
    start, part = leg.stored.end_state[: len(model.initial)], window[1] - window[0]
    spread = float(np.ptp(own.readings.speed[own.readings.changed if failed else own.readings.normal]))
    beats = verdict.outcome in _BEATS or spread > _EVEN * abs(mean)
    return averaged_speed(steady, mean, beats, start, (_SETTLE * part, part), plan.spec.tolerance, plan.spec.engine)


def _places(plan: Plan, work: Work) -> Iterator[tuple[Place, ...]]:
    """The signal at all values that are asked for; of one parameter also between the best one and its neighbours."""
    if plan.along is None:
        return
    axes = [v.values for v in (plan.along, plan.second) if v is not None]
    wanted, found = list(product(*axes)), dict[tuple[float, ...], Place]()
    total = len(wanted) + (2 * _ROUNDS if plan.second is None else 0)
    for _ in range(1 + (_ROUNDS if plan.second is None else 0)):
        for values in wanted:
            part = work.part("", len(found) / total, (len(found) + 1) / total)
            found[values] = part.unit(f"at {values}", partial(_place, plan, values, part.unkept))
            part.report(1.0, f"{len(found)} of {total} other values")
            yield tuple(found[v] for v in sorted(found))
        wanted = _between(sorted(found), found)


def _between(ordered: list[tuple[float, ...]], found: dict[tuple[float, ...], Place]) -> list[tuple[float, ...]]:
    """The values halfway between the one with the largest signal and its neighbours."""
    best = max(range(len(ordered)), key=lambda i: found[ordered[i]].signal or 0.0)
    neighbours = [ordered[i] for i in (best - 1, best + 1) if 0 <= i < len(ordered)]
    return [((ordered[best][0] + one[0]) / 2,) for one in neighbours] if found[ordered[best]].signal else []


def _place(plan: Plan, values: tuple[float, ...], work: Work) -> Place:
    paths = [v.parameter.path for v in (plan.along, plan.second) if v is not None]
    case = plan.case_at(dict(zip(paths, values, strict=True)))
    *_, failing = plan.failing(case).run(work)
    seen = _seen(plan, failing)
    signal = None if failing.failure else seen.readings.signal(plan.spec.sensor.noise)
    return Place(values, seen.readings.before, seen.readings.after, signal, str(failing.verdict.outcome))
