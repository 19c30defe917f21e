"""Question and machine -> plan: what is swept, within which limits, and from which start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.checking import read_quantity
from wucht.dynamics.parameters import range_of
from wucht.dynamics.run_ups.run_up import placed_at_start
from wucht.dynamics.verdicts.locking import is_locking
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.quantities import Unit, article
from wucht.studies.entrainment.spec import Entrainment
from wucht.studies.entrainment.swept_parameter import SweptParameter, swept_parameter


@dataclass(frozen=True)
class Plan:
    """What is to be done. machine: placed at its start; initial: its state (n,) there.

    limits: within which bands are looked for, the machine's own value included. range: that is looked at, None for the band of
    existence and a margin. resolution: of the edges, None for a share of the range.
    """

    spec: Entrainment
    machine: Machine
    initial: np.ndarray
    swept: SweptParameter
    limits: tuple[float, float]
    range: tuple[float, float] | None
    resolution: float | None

    @property
    def steady(self) -> Machine:
        """The machine as its schedules leave it."""
        return self.machine.at(self.machine.breakpoints[-1]).changed(schedules=())


def prepare(spec: Entrainment, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    _refuse_others(machine)
    swept = swept_parameter(machine, spec.along)
    unit = Unit(swept.unit, swept.what)
    range_ = None if spec.range is None else range_of(unit, spec.range)
    limits = range_ or swept.widest(machine)
    if limits is None:
        raise InputError("study.range", None, f"this key is missing; needed is a pair [low, high] of a {swept.what}")
    for i, value in enumerate(range_ or ()):
        swept.refuse(machine, value, f"study.range[{i}]")
    placed, initial = placed_at_start(machine, spec.start)
    resolution = None if spec.resolution is None else read_quantity(unit, spec.resolution, "study.resolution")
    if resolution is not None and resolution <= 0:
        raise InputError("study.resolution", spec.resolution, f"must be {article(unit.what)} greater than 0")
    limits = min(limits[0], swept.own), max(limits[1], swept.own)
    plan = Plan(spec, placed, initial, swept, limits, range_, resolution)
    if range_ is None:  # then the band of existence determines it
        try:
            averaged_machine(plan.steady)
        except InputError as error:
            reason = f"the averaged equations are left out: {error.allowed}"
            raise InputError("study.range", None, f"this key is missing, and cannot be chosen: {reason}") from None
    return plan


def _refuse_others(machine: Machine) -> None:
    """Raises ``InputError`` for machines in which nothing can be entrained."""
    if not is_locking(machine):
        needed = "a carrier.motion of amplitude and frequency, or two rotors or more whose speed no drive prescribes"
        raise InputError("machine", None, f"nothing can be entrained: needed is {needed}")
    prescribed = next((r.name for r in machine.rotors if r.coordinate.prescribed is not None), None)
    if prescribed is not None:
        raise InputError("machine.drive", None, f"the drive prescribes the speed of {prescribed!r}: it cannot be entrained")
