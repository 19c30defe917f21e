"""Question and machine -> plan: through which values the parameter is led, how slowly, and where the machine starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.checking import read_quantity
from wucht.errors import InputError
from wucht.fields import Parameter
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.quantities import Unit
from wucht.studies.initial_state import initial_state, placed
from wucht.studies.parameters import parameter_of, range_of
from wucht.studies.sweep.pace import Pace, rate_unit
from wucht.studies.sweep.spec import Sweep

_WAYS = {"both": ("up", "down"), "up": ("up",), "down": ("down",)}


@dataclass(frozen=True)
class Plan:
    """What is to be done. machine: with the swept parameter at its first value. initial: the state (n,) to start from.

    low, high: values of the swept parameter. ways: ``"up"``, ``"down"``, in their order.
    """

    spec: Sweep
    machine: Machine
    initial: np.ndarray
    swept: Parameter
    low: float
    high: float
    ways: tuple[str, ...]
    pace: Pace

    def ends(self, way: str) -> tuple[float, float]:
        """The first and the last value of a ramp."""
        return (self.low, self.high) if way == "up" else (self.high, self.low)


def prepare(spec: Sweep, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    if not machine.units.time:
        spec.refuse_units()
    swept = parameter_of(machine, spec.along)
    low, high = range_of(Unit(swept.unit, swept.what), spec.range)
    rate = _rate(spec, machine, swept)
    if machine.schedules:
        raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
    reason = _not_swept(machine).get(swept.path)
    if reason is not None:
        raise InputError("study.along", swept.path, f"not allowed: {reason}")
    for i, value in enumerate((low, high)):
        check_values(machine.parts, {swept.path: value}, f"study.range[{i}]", machine.values)
    ways = _WAYS[spec.direction]
    machine = machine.with_unchecked({swept.path: low if ways[0] == "up" else high})
    initial = initial_state(machine, spec.start)
    machine = placed(machine, initial)
    return Plan(spec, machine, initial, swept, low, high, ways, Pace.of(machine, swept.path, (low, high), rate))


def _rate(spec: Sweep, machine: Machine, swept: Parameter) -> float | None:
    """The rate of the parameter, None if it is not given. Raises ``InputError``."""
    if spec.rate is None:
        return None
    time, what = machine.units.time, f"rate of the {swept.what}"
    rate = read_quantity(Unit(f"{swept.unit or '1'}/{time}" if time else swept.unit, what), spec.rate, "study.rate")
    if rate <= 0:
        unit = f", in {rate_unit(machine, swept.path)}" if time else ""
        raise InputError("study.rate", spec.rate, f"allowed is a {what} greater than 0{unit}")
    return rate


def _not_swept(machine: Machine) -> dict[str, str]:
    """Parameters that cannot be moved while the machine runs, and why."""
    phase = {} if machine.shaking is None else {machine.shaking[1].name: "the phase of the motion would run away"}
    keys = ("locked", "release.time", "release.speed")
    return phase | {f"{b.name}.{key}": "it says when a body is released" for b in machine.bodies for key in keys}
