"""Plan -> findings: the turning points of the signal, leg by leg of a run-up, or of a record at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.horizon import SPEED_LIMIT
from wucht.dynamics.run_ups.observed_integration import Leg, Watched
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.verdicts.verdict import Verdict, judge
from wucht.dynamics.work import Work
from wucht.fatigue.turning_points import TurningPoints
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled import compile_system
from wucht.studies.load_spectrum.load_signals import MachineSignal, RecordSignal, Seen, SignalWatch
from wucht.studies.load_spectrum.prepare import Plan

# The parabola through an extreme's neighbours is right to h^4/32 with the step h of a vibration's angle: 1e-5.
_PER_TURN = 48


@dataclass(frozen=True, eq=False)
class Findings:
    """time, values (m,): the turning points of the signal so far, from the begin on. end_time: how far. verdict: on the run-up,
    None of a record. failure: why it ended early."""

    time: np.ndarray
    values: np.ndarray
    end_time: float
    verdict: Verdict | None = None
    failure: str | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The findings after each leg."""
    if isinstance(plan.signal, RecordSignal):
        channel = plan.signal.channel
        time, values = TurningPoints().after(channel.time, channel.values).closed()
        yield Findings(time, values, float(channel.time[-1]))
    elif plan.case is not None:
        yield from _of_run_up(plan, plan.case, plan.signal, work)


def _of_run_up(plan: Plan, case: RunUpCase, signal: MachineSignal, work: Work) -> Iterator[Findings]:
    """The machine is run as the study run-up does, but of its motion only the turning points of the signal are kept."""
    [model], spec = case.models, plan.spec
    compiled = compile_system(model.system, spec.tolerance, model.events(case.horizon.events), spec.engine)
    horizon, watch = case.horizon, SignalWatch(case.watch, signal)
    watched = Watched(watch, compiled, model.seen, horizon.vibration, horizon.energy, _PER_TURN)
    last = watched.begin(model.initial, model.values)
    found: list[tuple[np.ndarray, np.ndarray]] = []
    yield _findings(watched, found, last, case)
    for number, grid in enumerate(horizon.legs(), 1):
        if last.stored.ended:
            break
        # Its ends alone are stored; in between it is looked at as densely as it asks.
        ends, begun = grid.samples[[0, -1]], replace(last, seen=replace(last.seen, points=last.seen.points.forgotten()))
        last = work.unit(f"leg {number}", partial(watched.leg, begun, ends, partial(_report, work, grid.end)))
        found.append((last.seen.points.time, last.seen.points.values))
        findings = _findings(watched, found, last, case)
        yield findings
        if grid.judged and findings.verdict is not None and horizon.decided(findings.verdict):
            break


def _report(work: Work, end: float, time: float) -> None:
    work.report(time / end)


def _findings(watched: Watched[Seen], found: list[tuple[np.ndarray, np.ndarray]], last: Leg[Seen], case: RunUpCase) -> Findings:
    """What has been found, with the part of the motion that has not been looked at yet."""
    seen = watched.observation(last)
    earlier = found[:-1] if found else []
    parts = [*earlier, seen.points.closed()]
    stored, machine = last.stored, case.machine
    free = free_speed(machine.at(stored.end_time), machine.rotor, stored.end_time)
    verdict = judge(machine, seen.observation, free, stored.failure, stored.stopped_by == SPEED_LIMIT)
    time, values = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return Findings(time, values, stored.end_time, verdict, stored.failure)
