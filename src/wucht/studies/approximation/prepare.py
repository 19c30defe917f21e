"""Question and machine -> plan: the values of the parameter, and a run-up of both models at each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.errors import InputError
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.schema import Unit, read_quantity
from wucht.studies.approximation.spec import Approximation

OWN = math.nan  # in place of a value of the parameter: the machine as it is
_DECADE = 10.0


@dataclass(frozen=True)
class Plan:
    """What is to be compared. values: of the parameter, or the factor of several; the first is ``OWN``. cases: a run-up of both
    models at each of them."""

    spec: Approximation
    machine: Machine
    values: tuple[float, ...]
    cases: tuple[RunUpCase, ...]


def prepare(spec: Approximation, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine, or it has no averaged equations."""
    values = (OWN, *_values(spec, machine))
    where = "study.values" if spec.values else "study.range"
    changes = [changes_at(machine, spec.along, value) for value in values]
    for change in changes:
        check_values(machine.parts, change, where, machine.values)
    cases = tuple(RunUpCase.of(machine.with_unchecked(change), spec.start, spec.settings) for change in changes)
    return Plan(spec, machine, values, cases)


def changes_at(machine: Machine, along: Sequence[str], value: float) -> Mapping[str, float]:
    """The parameters that are other than the machine's own, by path: one has the value, of several it is a factor."""
    if math.isnan(value):
        return {}
    return {path: value if len(along) == 1 else value * machine.values[path] for path in along}


def _values(spec: Approximation, machine: Machine) -> tuple[float, ...]:
    """In increasing order."""
    along = [parameter_of(machine, path) for path in spec.along]
    unit = Unit(along[0].unit, along[0].what) if len(along) == 1 else Unit("", "factor")
    if spec.values:
        return tuple(sorted({read_quantity(unit, given, f"study.values[{i}]") for i, given in enumerate(spec.values)}))
    if spec.range is None:
        return ()
    low, high = range_of(unit, spec.range)
    spacing = spec.spacing or ("log" if low > 0 and high / low >= _DECADE else "linear")
    if spacing == "log" and low <= 0:
        raise InputError("study.spacing", spacing, "must be 'linear' for a range that does not begin above 0")
    between = np.geomspace if spacing == "log" else np.linspace
    return tuple(map(float, between(low, high, spec.points)))
