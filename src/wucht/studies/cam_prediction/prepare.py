"""Question and cam drive -> plan: the law, the shaft with what acts on it, its springs, and where the output is to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.drive import CamDrive
from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.elastic_shaft import ElasticShaft
from wucht.cams.prediction import CamShaft
from wucht.cams.tables.camshaft import Driving
from wucht.cams.tables.motion_law import MotionLaw
from wucht.errors import InputError
from wucht.numerics.harmonics import even_angles
from wucht.studies.cam_prediction.spec import CamPrediction

_STILL = 1e-9  # of the largest velocity
_LOOKED_AT, _SHORTEST = 3600, 36  # cam angles in which a law without restrictions is looked at, and those of a dwell, at least
_ABOUT = (0.5, 1.5)  # times the mean speed


@dataclass(frozen=True, eq=False)
class Plan:
    """count: N, above which orders are dirt. output, twisting: springs, None where there are none. speeds: of the output's
    vibration, rad/s."""

    motion: MotionLaw
    shaft: CamShaft
    driving: Driving | None
    count: int
    points: int
    cuts: int
    turns: int
    output: ElasticOutput | None
    twisting: ElasticShaft | None
    dwells: tuple[Dwell, ...]
    speeds: np.ndarray

    @property
    def enforced(self) -> bool:
        """Whether the drive holds the shaft's speed, whatever torque that takes."""
        return self.driving is not None and self.driving.enforced


def prepare(spec: CamPrediction, drive: CamDrive) -> Plan:
    """The plan. Raises ``InputError`` where the table [shaft] is missing or does not fit the law, drive or loads are wrong."""
    if drive.shaft is None:
        raise InputError(
            "shaft",
            None,
            "the table [shaft] is missing: the inertias of shaft and output, and what drives them",
            code="missing",
        )
    table, motion = drive.shaft, drive.motion
    moved = table.moved(motion.unit)
    driving = table.driving(drive.folder)
    shaft = table.camshaft(driving, motion.unit)
    output = None if table.elastic is None else table.elastic.output(moved, motion.unit)
    dwells = (_given(motion, spec.dwell),) if spec.dwell is not None else dwells_of(motion)
    low, high = spec.speeds or tuple(share * shaft.mean_speed for share in _ABOUT)
    if low <= 0:
        raise InputError("study.speeds", spec.speeds and list(spec.speeds), "must be above zero")
    if output is not None and not dwells:
        raise InputError("study.dwell", None, "the law says on no arc that the output rests: give begin and end of the dwell")
    speeds = np.linspace(low, high, spec.speed_points)
    count, turns = motion.count or spec.orders, 0 if driving is not None and driving.enforced else spec.simulate
    cuts = 0 if driving is not None and driving.enforced else spec.cuts
    return Plan(motion, shaft, driving, count, spec.points, cuts, turns, output, table.twisting(), dwells, speeds)


def dwells_of(motion: MotionLaw) -> tuple[Dwell, ...]:
    """Where a law is asked to rest; or, where nothing was asked, where it does."""
    return tuple(Dwell(b.begin, b.end, (b.low + b.high) / 2) for b in motion.dwells) or _where_it_rests(motion)


def _where_it_rests(motion: MotionLaw) -> tuple[Dwell, ...]:
    phi = even_angles(_LOOKED_AT)
    speed = np.abs(motion.law(phi, 1))
    still = speed <= _STILL * speed.max()
    if still.all() or not still.any():
        return ()
    first = int(np.flatnonzero(~still)[0])  # so that no dwell passes the end of the turn
    edges = np.flatnonzero(np.diff(np.append(np.roll(still, -first), False).astype(int))) + 1
    found = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin >= _SHORTEST:
            start, stop = (2 * math.pi * (first + at) / _LOOKED_AT for at in (begin, end - 1))
            found.append(Dwell(start, stop, float(motion.law((start + stop) / 2))))
    return tuple(found)


def _given(motion: MotionLaw, arc: tuple[float, float]) -> Dwell:
    """That of the question; the output rests there where the law is on the mean."""
    try:
        return Dwell(*arc, float(motion.law(np.linspace(*arc, 1000)).mean()))
    except InputError as error:
        raise error.within("study") from None
