"""Spec and machine -> plan -> findings: the machine in operation, the motion at the low voltage, and dips of many durations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from wucht.analysis.time_constants import highest_speed
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.operating_state import machine_after_schedules
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.settled_operation import NO_OPERATION, SettledOperation, operation_of
from wucht.dynamics.run_ups.voltage_dips import (
    CriticalDip,
    Dip,
    DippingSupply,
    LastingDip,
    critical_dip,
    one_dip,
    voltages_of_drives,
)
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import operating_speed
from wucht.studies.voltage_dip.spec import VoltageDip

_STORED_SAMPLES = 60_000  # of a run
_TURNS_BEFORE = 12  # of the main rotor, drawn before the dip
_MOST_TURNS = 1_000_000  # of a dip


@dataclass(frozen=True)
class Plan:
    """Plan of a voltage dip. voltages: those that dip, by path, as they are in operation."""

    spec: VoltageDip
    machine: Machine
    voltages: Mapping[str, float]
    settings: RunSettings

    def supply(self, operation: SettledOperation) -> DippingSupply:
        """Return the machine in operation, with its supply."""
        machine = machine_after_schedules(self.machine, operation.locks)
        return DippingSupply(machine, operation, self.voltages, self.spec.depth, self.settings)


def prepare(spec: VoltageDip, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the study does not fit the machine."""
    voltages = voltages_of_drives(machine, spec.on)
    if machine.shaken_coordinate is not None:
        reason = "the carrier moves as prescribed, and a dip would begin at any phase of that motion"
        raise InputError("machine.carrier.motion", None, f"not allowed: {reason}", code="prescribed")
    settings = RunSettings(tolerance=spec.tolerance, engine=spec.engine, stored_samples=_STORED_SAMPLES)
    RunUpCase.of(machine, spec.start, settings)  # the start fits the machine
    longest = (spec.limits or (0.0, spec.single_duration or 0.0))[1]
    steady = machine.at(machine.breakpoints[-1])
    turns = longest * min(operating_speed(steady), highest_speed(steady)) / (2 * math.pi)
    if turns > _MOST_TURNS:
        allowed = f"{longest * _MOST_TURNS / turns:.3g} {machine.units.time}"
        raise InputError(
            "study.duration",
            spec.duration,
            f"must be at most {allowed}: these are {turns:.3g} turns or vibrations",
            code="limits",
        )
    return Plan(spec, machine, voltages, settings)


@dataclass(frozen=True, eq=False)
class Findings:
    """Findings so far.

    lasting: None as long as the machine is not in operation. single: the dip of the duration in question. critical: the dips
    that were tried to determine the critical duration. is_complete: that is determined.
    """

    operation: SettledOperation
    lasting: LastingDip | None = None
    single: Dip | None = None
    critical: CriticalDip = field(default_factory=CriticalDip)
    is_complete: bool = False


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings, more and more complete."""
    spec, part = plan.spec, work.part("operation", 0.0, 0.2)
    part.report(0.0, "operation")
    findings = Findings(operation_of(plan.machine, spec.start, plan.settings, _TURNS_BEFORE, part))
    yield findings
    if findings.operation.end.outcome in NO_OPERATION:
        return
    supply, limits = plan.supply(findings.operation), spec.limits
    lasting = supply.lasting_dip(limits and limits[1], spec.points, work.part("lasting", 0.2, 0.3))
    findings = replace(findings, lasting=lasting)
    yield findings
    earlier = CriticalDip()
    if spec.single_duration is not None:
        single = one_dip(supply.dip, spec.single_duration, work.part("", 0.3, 0.35))
        earlier = earlier.with_dip(single)
        findings = replace(findings, single=single, critical=earlier)
        yield findings
    shortest, durations = 0.0, lasting.levels.tolist()
    if limits is not None:
        shortest = limits[0]
        durations = [*limits, *(t for t in durations if limits[0] < t < limits[1])]
    for trial in critical_dip(supply.dip, sorted(durations), shortest, earlier, work.part("", 0.35, 1.0)):
        findings = replace(findings, critical=trial)
        yield findings
    yield replace(findings, is_complete=True)
