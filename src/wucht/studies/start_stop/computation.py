"""Question and machine -> plan -> findings: the run-up until the switch-off, and the coast-down from there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal
from wucht.dynamics.run_ups.observed_loads import LoadedRun, loaded_runs
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.start_stop_cases import start_case, stop_case
from wucht.dynamics.work import Work
from wucht.fatigue.damage import WoehlerLine
from wucht.machines.machine import Machine
from wucht.studies.shared_keys import woehler_line
from wucht.studies.start_stop.spec import StartStop

_UP_SHARE = 0.5  # of the time that both runs take


@dataclass(frozen=True)
class Plan:
    """The plan of a cycle. case: the run-up. signal, line: of the part; None without a Woehler line, or with a carrier that
    does not move."""

    spec: StartStop
    machine: Machine
    case: RunUpCase
    signal: MachineSignal | None
    line: WoehlerLine | None


def prepare(spec: StartStop, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    case = start_case(machine, spec.start, spec.start_settings)
    signal, line = None, None
    if spec.woehler is not None:
        signal = machine_signal(case.machine, spec.signal, spec.direction)
        line = woehler_line(spec.woehler, signal.unit, "study.woehler")
    return Plan(spec, machine, case, signal, line)


def numbers(plan: Plan) -> float:
    """Bound the count of stored numbers: time and value of two turning points a turn at the highest speed expected."""
    horizon = plan.case.horizon
    return 4 * horizon.first / (horizon.step * horizon.samples_per_turn)


@dataclass(frozen=True)
class Findings:
    """The run-up, and the coast-down: None before it, or where nothing turns at the switch-off."""

    up: LoadedRun
    down: LoadedRun | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate the cycle; yield the findings after each leg."""
    up = None
    for up in loaded_runs(plan.case, plan.signal, 0.0, work.part("up", 0.0, _UP_SHARE)):
        yield Findings(up)
    assert up is not None
    case = None if up.trajectory.failure else stop_case(plan.case.machine, up.trajectory, plan.spec.stop_settings)
    if case is not None:
        signal = plan.signal
        if signal is not None:
            signal = machine_signal(case.machine, plan.spec.signal, plan.spec.direction)
        for down in loaded_runs(case, signal, up.trajectory.end_time, work.part("down", _UP_SHARE, 1.0)):
            yield Findings(up, down)
