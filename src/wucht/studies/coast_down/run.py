"""Plan -> findings: the run integrated leg by leg, each reduced to what is recorded of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.numerics.flow.compiled import CompiledSystem, Integrator, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.studies.coast_down.leg import reduced
from wucht.studies.coast_down.prepare import Plan
from wucht.studies.coast_down.record import Leg, Record
from wucht.studies.work import Work

SAMPLES_A_LEG = 20_480
SLOW = 0.01  # of the speed at the start: without `until` the run ends there
_STILL = 1e-4  # likewise, after it has turned back
_ENOUGH_SWINGS = 20


@dataclass(frozen=True)
class Findings:
    """The record so far, and what was integrated."""

    record: Record
    compiled: CompiledSystem


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; what is recorded after each leg."""
    spec = plan.spec
    compiled = compile_system(plan.machine.system, spec.tolerance, plan.events, spec.engine)
    integrator = compiled.engine.integrator()
    start = integrate(compiled, plan.initial, plan.machine.values, np.zeros(1), integrator=integrator)
    record = Record(plan.start_speed, plan.stride, start)
    yield Findings(record.after(reduced(plan, compiled, record, start)), compiled)
    while not _ended(plan, record):
        record = record.after(work.unit(f"leg {record.legs + 1}", partial(_leg, plan, compiled, integrator, record, work)))
        yield Findings(record, compiled)


def _leg(plan: Plan, compiled: CompiledSystem, integrator: Integrator, before: Record, work: Work) -> Leg:
    """The leg that begins where the one before ended."""
    last = before.end
    count = max(1, min(SAMPLES_A_LEG, round((plan.limit - last.end_time) / plan.step)))
    grid = last.end_time + plan.step * np.arange(count + 1)

    def report(time: float) -> None:
        work.report(time / plan.limit)

    found = integrate(compiled, last.end_state, last.parameters, grid, report, plan.energy, integrator)
    if found.interrupted:
        raise KeyboardInterrupt
    return reduced(plan, compiled, before, found)


def _ended(plan: Plan, record: Record) -> bool:
    """Whether the time is over, the run failed, or, without a time, the rotor has stopped, swung enough, or is slow."""
    if record.end.ended or record.end.end_time >= plan.limit * (1 - 1e-9):
        return True
    if plan.spec.until is not None or not record.legs:
        return False
    start_speed = abs(record.start_speed)
    if record.reversal_time is not None:
        return record.swings >= _ENOUGH_SWINGS or abs(record.rows["max_speed"][-1]) < _STILL * start_speed
    return bool(record.turns.size) and abs(record.rows["speed"][-1]) < SLOW * start_speed
