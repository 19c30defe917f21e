"""A machine in which rotors may be entrained: what is swept, within which limits, and from which start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.dynamics.entrainment.swept_parameter import SweptParameter
from wucht.dynamics.run_ups.run_up import placed_at_start
from wucht.dynamics.verdicts.locking import is_locking
from wucht.errors import InputError
from wucht.machines.machine import Machine


@dataclass(frozen=True)
class EntrainmentCase:
    """machine: placed at its start; initial: its state (n,) there; start: as it is stated.

    limits: within which bands are looked for, the machine's own value included. range: that is looked at, None for the band of
    existence and a margin. points: runs from the start, evenly over it. resolution: of the edges, None for a share of it.
    until: how long a run lasts at least, None for as long as the averaged equations ask.
    """

    machine: Machine
    initial: np.ndarray
    start: Mapping[str, Any]
    swept: SweptParameter
    limits: tuple[float, float]
    range: tuple[float, float] | None
    resolution: float | None
    points: int
    until: float | None

    @classmethod
    def of(
        cls,
        machine: Machine,
        swept: SweptParameter,
        start: Mapping[str, Any],
        points: int,
        range: tuple[float, float] | None = None,  # noqa: A002 - the key of a study file
        resolution: float | None = None,
        until: float | None = None,
    ) -> EntrainmentCase:
        """The case of a machine. Raises ``InputError`` where nothing can be entrained, or where a value is not allowed."""
        check_entrainable(machine)
        limits = range or swept.widest(machine)
        if limits is None:
            raise InputError(
                "study.range", None, f"this key is missing; needed is a pair [low, high] of a {swept.what}", code="missing"
            )
        for i, value in enumerate(range or ()):
            swept.refuse(machine, value, f"study.range[{i}]")
        placed, initial = placed_at_start(machine, start)
        limits = min(limits[0], swept.own), max(limits[1], swept.own)
        case = cls(placed, initial, start, swept, limits, range, resolution, points, until)
        if range is None:  # then the band of existence determines it
            try:
                averaged_machine(case.steady)
            except InputError as error:
                reason = f"the averaged equations are left out: {error.allowed}"
                raise InputError(
                    "study.range", None, f"this key is missing, and cannot be chosen: {reason}", code="not-chosen"
                ) from None
        return case

    @property
    def steady(self) -> Machine:
        """The machine as its schedules leave it."""
        return self.machine.at(self.machine.breakpoints[-1]).changed(schedules=())


def check_entrainable(machine: Machine) -> None:
    """Raises ``InputError`` for machines in which nothing can be entrained."""
    if not is_locking(machine):
        needed = "a carrier.motion of amplitude and frequency, or two rotors or more whose speed no drive prescribes"
        raise InputError("machine", None, f"nothing can be entrained: needed is {needed}")
    prescribed = next((r.name for r in machine.rotors if r.coordinate.prescribed is not None), None)
    if prescribed is not None:
        raise InputError("machine.drive", None, f"the drive prescribes the speed of {prescribed!r}: it cannot be entrained")
