"""Question and machine -> plan: the wanted spectrum in the signal's unit, the variables, how candidates are tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.dynamics.exciters.design_trials import METRICS, Trials
from wucht.dynamics.exciters.slow_beats import Rig
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.run_up import placed_at_start
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.sampling.pareto_search import needed
from wucht.dynamics.sampling.search_variables import balancing, variables_of
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import Cycles
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.studies.exciter_design.exciter_subject import MachineInFolder
from wucht.studies.exciter_design.spec import ExciterDesign
from wucht.studies.exciter_design.wanted_spectrum import wanted


@dataclass(frozen=True)
class Plan:
    """numbers: the machine's own values of the variables (k,). target: cycles that are wanted. signal, unit: what is counted.
    generations: of the search. warnings: what is doubtful about the question."""

    spec: ExciterDesign
    machine: Machine
    trials: Trials
    numbers: np.ndarray
    target: Cycles
    signal: str
    unit: str
    generations: int
    warnings: tuple[str, ...]


def prepare(spec: ExciterDesign, subject: MachineInFolder | Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    machine, folder = (subject.machine, subject.folder) if isinstance(subject, MachineInFolder) else (subject, None)
    needed(spec.kind)
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: needed are bodies, [[machine.bodies]], whose numbers are varied")
    if not balancing(machine):
        raise InputError("machine.bodies", None, f"needed is a pendulum about {machine.rotor.name!r}: without it nothing beats")
    if machine.schedules:
        raise InputError("machine.schedules", None, "allowed only for a machine without schedules: the beating is to last")
    signal = machine_signal(machine, spec.signal, spec.direction)
    target = wanted(spec.target, signal.unit, folder)
    rig = Rig(spec.signal, spec.direction, spec.start, spec.inertia, spec.tolerance)
    trials = Trials(machine, variables_of(machine, spec.vary, False), rig, METRICS.index(spec.metric), spec.slope)
    numbers = np.array([machine.values[v.paths[0]] for v in trials.variables])
    _check_ends(trials, numbers)
    placed, start = placed_at_start(machine, spec.start, 0.0)
    warnings = slow_model(placed, start, spec.inertia, 1).warnings
    return Plan(
        spec, machine, trials, numbers, target, signal.name, signal.unit, spec.evaluations // spec.population, tuple(warnings)
    )


def _check_ends(trials: Trials, numbers: np.ndarray) -> None:
    """Raises ``InputError`` for an end of a range that the parts do not allow, the rest being as it is."""
    for k, v in enumerate(trials.variables):
        for end in (v.low, v.high):
            try:
                trials.of(np.where(np.arange(len(numbers)) == k, end, numbers))
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.allowed) from None
