"""Question and machine -> plan: through which values the parameter is led, how slowly, and where the machine starts."""

from __future__ import annotations

from dataclasses import dataclass

from wucht.analysis.shaft import energy_scale
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.initial_state import initial_state, placed
from wucht.dynamics.sweeps.moving import MovedMachine
from wucht.dynamics.sweeps.pace import pace_of, rate_unit
from wucht.errors import InputError
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.schema import Parameter, Unit, read_quantity
from wucht.studies.sweep.spec import Sweep


@dataclass(frozen=True)
class Plan:
    """What is to be done. moved: the machine with the swept parameter at its first value.

    low, high: values of the swept parameter. ways: from which to which value it goes ``"up"`` or ``"down"``, in their order.
    """

    spec: Sweep
    moved: MovedMachine
    swept: Parameter
    low: float
    high: float
    ways: dict[str, tuple[float, float]]


def prepare(spec: Sweep, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    swept = parameter_of(machine, spec.along)
    low, high = range_of(Unit(swept.unit, swept.what), spec.range)
    rate = _rate(spec, machine, swept)
    if machine.schedules:
        raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
    if machine.shaking is not None and swept.path == machine.shaking[1].name:
        raise InputError("study.along", swept.path, "not allowed: the phase of the motion would run away")
    if swept.path in {f"{b.name}.{key}" for b in machine.bodies for key in ("locked", "release.time", "release.speed")}:
        raise InputError("study.along", swept.path, "not allowed: it says when a body is released")
    for i, value in enumerate((low, high)):
        check_values(machine.parts, {swept.path: value}, f"study.range[{i}]", machine.values)
    ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if spec.direction in (way, "both")}
    machine = machine.with_unchecked({swept.path: next(iter(ways.values()))[0]})
    initial = initial_state(machine, spec.start)
    machine = placed(machine, initial)
    moved = MovedMachine(machine, initial, swept.path, pace_of(machine, swept.path, low, high, rate), energy_scale(machine))
    return Plan(spec, moved, swept, low, high, ways)


def _rate(spec: Sweep, machine: Machine, swept: Parameter) -> float | None:
    """The rate of the parameter, None if it is not given. Raises ``InputError``."""
    if spec.rate is None:
        return None
    time, what = machine.units.time, f"rate of the {swept.what}"
    rate = read_quantity(Unit(f"{swept.unit or '1'}/{time}" if time else swept.unit, what), spec.rate, "study.rate")
    if rate <= 0:
        unit = f", in {rate_unit(machine, swept.path)}" if time else ""
        raise InputError("study.rate", spec.rate, f"must be a {what} greater than 0{unit}")
    return rate
