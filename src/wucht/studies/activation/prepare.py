"""Question and machine -> plan: the machines, and the runs of each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from wucht.analysis.switching import (
    Switching,
    preload_for,
    switchable,
    switching,
    with_rigid_pendulums,
    without_pendulums,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.studies.activation.spec import Activation

SWITCHABLE, BALANCED, RIGID, NONE = "switchable", "balanced", "rigid", "none"


@dataclass(frozen=True)
class Planned:
    """One run. speed, orientation, phase: which of those of the plan it has, -1 where it has none."""

    name: str
    of: str
    machine: Machine
    start: Mapping[str, Any]
    settings: RunSettings
    speed: int = -1
    orientation: int = -1
    phase: int = -1

    def case(self) -> RunUpCase:
        """The run, ready to be integrated. Raises ``InputError`` where the start does not fit the machine."""
        return RunUpCase.of(self.machine, self.start, self.settings)


@dataclass(frozen=True)
class Plan:
    """What is to be done. pendulums: by name. switching: of each, at each activation speed. speeds: of the first pendulum."""

    spec: Activation
    machine: Machine
    pendulums: tuple[str, ...]
    switching: tuple[tuple[Switching, ...], ...]
    phases: tuple[float, ...]
    runs: tuple[Planned, ...]

    @property
    def speeds(self) -> tuple[float, ...]:
        """The activation speeds, those of the first pendulum."""
        return tuple(s[0].opening for s in self.switching)


def prepare(spec: Activation, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    pendulums = switchable(machine)
    if not pendulums:
        allowed = "this study needs a body of kind 'switchable-pendulum'"
        raise InputError("machine.bodies", [b.kind for b in machine.bodies], allowed)
    names = tuple(p.name for p in pendulums)
    for key in (*names, "psi", "delta"):
        if key in spec.start:
            given_by = "study.orientations and study.phases say where the switchable pendulums start"
            raise InputError(f"study.start.{key}", spec.start[key], f"not allowed: {given_by}")
    machines = [machine] if not spec.activation_speeds else [_opening_at(machine, w) for w in spec.activation_speeds]
    phases = tuple(2 * math.pi * k / spec.phases for k in range(spec.phases))
    runs = [_planned(spec, SWITCHABLE, m, names, at, phases) for m, *at in _each(spec, machines)]
    runs = runs if SWITCHABLE in spec.variants else []
    others = {BALANCED: _balanced(machine), RIGID: with_rigid_pendulums(machine)}
    for of in (BALANCED, RIGID):
        if of in spec.variants:
            runs += [_planned(spec, of, m, names, (-1, *at[1:]), phases) for m, *at in _each(spec, [others[of]])]
    if NONE in spec.variants:
        runs.append(Planned(NONE, NONE, without_pendulums(machine), spec.start, _settings(spec)))
    for run in runs[:: spec.phases]:  # what does not fit is refused before anything is computed
        run.case()
    every = tuple(tuple(switching(m, p) for p in pendulums) for m in machines)
    return Plan(spec, machine, names, every, phases, tuple(runs))


def _each(spec: Activation, machines: list[Machine]) -> list[tuple[Machine, int, int, int]]:
    numbers = product(range(len(machines)), range(len(spec.orientations)), range(spec.phases))
    return [(machines[i], i, j, k) for i, j, k in numbers]


def _opening_at(machine: Machine, speed: float) -> Machine:
    return machine.with_values({f"{p.path}.preload": preload_for(machine, p, speed) for p in switchable(machine)})


def _balanced(machine: Machine) -> Machine:
    return machine.with_values({f"{p.path}.permanent_unbalance": 0.0 for p in switchable(machine)})


def _settings(spec: Activation) -> RunSettings:
    return RunSettings(until=spec.until, tolerance=spec.tolerance, engine=spec.engine)


def _planned(
    spec: Activation, of: str, machine: Machine, names: tuple[str, ...], at: Sequence[int], phases: tuple[float, ...]
) -> Planned:
    """The run number ``at``: of the activation speed, the orientation, the phase."""
    _, j, k = at
    apart, middle = spec.orientations[j], (len(names) - 1) / 2
    angles = {name: phases[k] + (i - middle) * apart for i, name in enumerate(names)}
    return Planned(f"{of} {' '.join(map(str, at))}", of, machine, dict(spec.start) | angles, _settings(spec), *at)
