"""Plan -> findings: the run integrated leg by leg, each reduced to what is recorded of it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.descent_record import Descent, Record, reduced
from wucht.dynamics.work import Work
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.studies.coast_down.prepare import Plan

SAMPLES_A_LEG = 20_480
SLOW = 0.01  # of the speed at the start: without `until` the run ends there
_STILL = 1e-4  # likewise, after it has turned back
_ENOUGH_SWINGS = 20

Findings = tuple[Record, CompiledSystem]  # the record so far, and what was integrated


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; what is recorded after each leg."""
    compiled = compile_system(plan.machine.system, plan.spec.tolerance, plan.events, plan.spec.engine)
    start = integrate(compiled, plan.initial, plan.machine.values, np.zeros(1))
    record = Record(start_speed=plan.start_speed, stride=plan.stride, end=start)
    yield record.after(reduced(plan.machine, plan.at_rest, compiled, record, start)), compiled
    while not _ended(plan, record):
        record = record.after(work.unit(f"leg {record.legs + 1}", partial(_leg, plan, compiled, record, work)))
        yield record, compiled


def _leg(plan: Plan, compiled: CompiledSystem, before: Record, work: Work) -> Descent:
    """The leg that begins where the one before ended."""
    last = before.end
    count = max(1, min(SAMPLES_A_LEG, round((plan.limit - last.end_time) / plan.step)))
    grid = last.end_time + plan.step * np.arange(count + 1)
    t = integrate(compiled, last.end_state, last.parameters, grid, lambda time: work.report(time / plan.limit), plan.energy)
    return reduced(plan.machine, plan.at_rest, compiled, before, t.uninterrupted())


def _ended(plan: Plan, record: Record) -> bool:
    """Whether the time is over, the run failed, or, without a time, the rotor has stopped, swung enough, or is slow."""
    if record.end.ended or record.end.end_time >= plan.limit * (1 - 1e-9):
        return True
    if plan.spec.until is not None:
        return False
    rows, start_speed = record.rows, abs(record.start_speed)
    if record.reversals:
        return len(record.reversals) >= _ENOUGH_SWINGS or abs(rows["max_speed"][-1]) < _STILL * start_speed
    return bool(record.turns.size) and abs(rows["speed"][-1]) < SLOW * start_speed
