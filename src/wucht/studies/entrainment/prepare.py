"""Question and machine -> the case: its parameter, and the numbers in the unit of that."""

from __future__ import annotations

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, check_entrainable
from wucht.dynamics.entrainment.swept_parameter import swept_parameter
from wucht.dynamics.parameters import range_of
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.schema import Unit, article, read_quantity
from wucht.studies.entrainment.spec import Entrainment


def prepare(spec: Entrainment, machine: Machine) -> EntrainmentCase:
    """The case. Raises ``InputError`` where the question does not fit the machine."""
    check_entrainable(machine)
    swept = swept_parameter(machine, spec.along)
    unit = Unit(swept.unit, swept.what)
    range_ = None if spec.range is None else range_of(unit, spec.range)
    resolution = None if spec.resolution is None else read_quantity(unit, spec.resolution, "study.resolution")
    if resolution is not None and resolution <= 0:
        raise InputError("study.resolution", spec.resolution, f"must be {article(unit.what)} greater than 0")
    return EntrainmentCase.of(machine, swept, spec.start, spec.points, range_, resolution, spec.until)
