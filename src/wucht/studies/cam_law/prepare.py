"""Question and cam drive -> plan: the law."""

from __future__ import annotations

from dataclasses import dataclass

from wucht.cams.drive import CamDrive
from wucht.cams.tables.motion_law import MotionLaw
from wucht.studies.cam_law.spec import CamLaw


@dataclass(frozen=True, eq=False)
class Plan:
    """The law, at how many cam angles it is given, and how many of its harmonics."""

    motion: MotionLaw
    points: int
    orders: int


def prepare(spec: CamLaw, drive: CamDrive) -> Plan:
    """The plan. Raises ``InputError`` where there is no such law: what must give way, and by how much."""
    return Plan(drive.motion, spec.points, drive.motion.count or spec.orders)
