"""Question and machine -> plan: where each run starts, how far it goes, and which equations it integrates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import net_torque
from wucht.numerics.flow.program import Evaluator
from wucht.studies.initial_state import initial_state, placed
from wucht.studies.motion.noise import Noise
from wucht.studies.motion.observation import Watch
from wucht.studies.parameters import parameter_of, values_of
from wucht.studies.run_up.horizon import Horizon, numbers_a_sample
from wucht.studies.run_up.model import FullModel, slow_model
from wucht.studies.run_up.spec import RunUp
from wucht.studies.varied import start_states

_NO_ACCELERATION = 1e-12


@dataclass(frozen=True)
class Case:
    """One run. value: of the parameter ``along``, if there is one. models: the equations to integrate, the full ones first.

    deck: its inclination, if it is known.
    """

    label: str
    start: Mapping[str, Any]
    value: float | None
    machine: Machine
    horizon: Horizon
    models: tuple[FullModel, ...]
    deck: float | None = None

    @property
    def watch(self) -> Watch:
        """What watches the motion."""
        return Watch(self.machine, self.horizon.span, Noise.of(self.horizon.tolerance))


@dataclass(frozen=True)
class Plan:
    """What is to be done: the runs, at least one. machine: as it was given. several: whether many runs were asked for."""

    spec: RunUp
    machine: Machine
    cases: tuple[Case, ...]
    several: bool


def prepare(spec: RunUp, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    if spec.over == "psi" and not any(b.about == machine.rotor.name for b in machine.bodies):
        raise InputError("study.over", spec.over, "must be 'time' or 'phi': no body turns about the rotor")
    cases, starts = [], spec.starts or (spec.start,)
    values = (None,) if spec.along is None else values_of(machine, parameter_of(machine, spec.along), spec.values)
    for value in values:
        changed = machine if spec.along is None or value is None else machine.with_values({spec.along: value})
        cases += [prepare_case(spec, changed, start, value) for start in starts]
    return Plan(spec, machine, tuple(cases), bool(spec.starts or spec.values))


def numbers(plan: Plan) -> float:
    """At most how many numbers are stored."""
    return sum(case.horizon.samples * len(case.models) * numbers_a_sample(case.machine) for case in plan.cases)


def prepare_case(spec: RunUp, machine: Machine, start: Mapping[str, Any], value: float | None = None) -> Case:
    """One run of a question. Raises ``InputError``."""
    if spec.deck is not None and (machine.dimensionless or "y" not in machine.labels):
        raise InputError("study.deck", spec.deck, "allowed only for a machine with units whose carrier moves up and down (y)")
    machine, initial = placed_at_start(machine, start, spec.until or 0.0, spec.speed_limit)
    models = () if spec.model == "slow" else (FullModel(machine, initial),)
    if spec.model != "full":
        models = (*models, slow_model(machine, initial, spec.inertia, spec.order))
    label = _label(spec, machine, start, value)
    return Case(label, start, value, machine, Horizon.of(machine, spec, initial), models, spec.deck)


def _label(spec: RunUp, machine: Machine, start: Mapping[str, Any], value: float | None) -> str:
    """What distinguishes a run, for a legend: the value of the parameter, the start, or both."""
    parts = [] if value is None or spec.along is None else [machine.parameters[spec.along].at(value)]
    if spec.starts:
        units = {name: state.unit.si for name, state in start_states(machine).items()}
        parts.append(", ".join(f"{k} = {_shown(v, units.get(k, ''))}" for k, v in start.items()) or "at rest")
    return "; ".join(parts)


def _shown(value: Any, unit: str = "") -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} {_shown(v)}" for k, v in value.items()) + "}"
    return f"{value:.6g} {unit}".rstrip() if isinstance(value, int | float) else str(value)


def placed_at_start(
    machine: Machine, start: Mapping[str, Any], end: float = 0.0, speed_limit: float | None = None
) -> tuple[Machine, np.ndarray]:
    """The machine with the bodies of its tracks in the order of the start, and the state (n,) to start from.

    end: of the run. Raises ``InputError`` where the start does not fit the machine, or where nothing would turn.
    """
    initial = initial_state(machine, start)
    machine = placed(machine, initial)
    given, at = [b.coordinate for b in machine.bodies if b.coordinate.prescribed is not None], np.linspace(0.0, end, 100)
    fastest = max((float(np.abs(machine.prescribed_speed(c, at)).max()) for c in given), default=0.0)
    if speed_limit is not None and fastest > speed_limit:
        raise InputError("study.speed_limit", speed_limit, "must be more than the speed that the drive prescribes")
    if not fastest and machine.shaken is None and not machine.schedules and _at_rest(machine, initial):
        why = "the machine has neither a drive nor an initial speed: nothing would turn"
        raise InputError("machine.drive", None, f"{why}; needed is [machine.drive] or a speed in study.start")
    return machine, initial


def _at_rest(machine: Machine, initial: np.ndarray) -> bool:
    """Whether no body turns, and none begins to."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed is None]
    if initial[free].any() or any(net_torque(machine, r)(0.0) for r in machine.rotors if r.coordinate.prescribed is None):
        return False
    system, names = machine.system, machine.state_names
    accelerations = Evaluator.of(system, [system.derivatives[i] for i in free], [names[i] for i in free])
    with np.errstate(all="ignore"):
        rates = accelerations(np.zeros(1), initial[:, None], system.values(machine.values))
    return all(abs(float(a[0])) < _NO_ACCELERATION for a in rates.values())
