"""The torques over the speed, and where they balance: 002 (3.51), figure 3.2b."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.analysis.working_points import WorkingPoint
from wucht.studies.torque_balance.prepare import Plan
from wucht.studies.work import Work


@dataclass(frozen=True)
class Findings:
    """Torques over speeds (N,), signed: of the drive, of loads and bearings, of the vibration. slope: of what the drive leaves.

    breakdown: slip, speed and torque, of an induction motor. runaway: the drive's torque exceeds the load at every speed,
    without vibration.
    """

    speeds: np.ndarray
    drive: np.ndarray
    load: np.ndarray
    vibration: np.ndarray
    slope: np.ndarray
    working_points: tuple[WorkingPoint, ...]
    breakdown: tuple[float, float, float] | None
    runaway: bool


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The torques and the working points; they take milliseconds, and come at once."""
    work.report(0.0, "working points")
    c = plan.curves
    drive, load, vibration = (torque(c.grid)[0] for torque in (c.shaft.drive, c.shaft.losses, c.vibration))
    slope = c.surplus(c.grid)[1]
    yield Findings(c.grid, drive, load, vibration, slope, tuple(c.working_points), c.breakdown, c.runaway)
