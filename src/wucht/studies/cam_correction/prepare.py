"""Question and cam drive -> plan: the law, the shaft, the cams before and after, and what can be wrong with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.correction import CorrectedLaw, Purity
from wucht.cams.drive import CamDrive
from wucht.cams.laws.law import Law
from wucht.cams.linkages.closure import Linkage
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.undercut import CutAway, check_face, check_roller, cut_away
from wucht.measurements.order_fit import OrderFit
from wucht.studies.cam_correction.measured_acceleration import Measured, measured
from wucht.studies.cam_correction.spec import CamCorrection

_ENDLESS = 60  # orders shown of a law that has no end of them
_MATTERS, _ERRORS = 1e-3, 3.0  # of the mean speed, and standard errors: an order left out that is told
_TOLD = (1, 2)  # orders that the fit itself tells of

Cams = Mapping[str, RollerCam | FlatFacedCam]


@dataclass(frozen=True, eq=False)
class Plan:
    """law, corrected: of the output over the cam angle, in ``unit``; levers: what moves the follower for both. purity: of the
    acceleration. closure: the linkage. before, after: the cams of both by name, none without a follower. cut: what is cut away
    of those after, of rollers: nothing. fit: of the record of the speed. measured: of that of the acceleration."""

    spec: CamCorrection
    law: Law
    corrected: CorrectedLaw
    levers: tuple[Law, Law]
    unit: str
    lever_unit: str
    purity: Purity
    orders: int
    shaft: ShaftMotion
    closure: Linkage | None
    before: Cams
    after: Cams
    cut: Mapping[str, CutAway]
    fit: OrderFit | None
    measured: Measured | None
    notes: tuple[str, ...]


def prepare(spec: CamCorrection, drive: CamDrive) -> Plan:
    """The plan.

    Raises ``InputError``: there is no such law, the output stands still, nothing says how the shaft turns, it turns back, a
    record cannot be used, the linkage or the follower cannot make the motion, or a roller would cut the new contour away.
    """
    motion, shaft, fit = drive.motion, drive.turning, drive.measured
    purity = Purity.of(motion.law, motion.count)
    orders = spec.orders or 3 * (purity.count or _ENDLESS // 3)
    corrected = CorrectedLaw(motion.law, shaft)
    before, after = ({}, {}) if drive.follower is None else (drive.cams(motion.law), drive.cams(corrected))
    record = None
    if spec.acceleration is not None:
        law = motion.law if spec.acceleration.cam == "original" else corrected
        zero = 0.0 if fit is None else fit.origin
        record = measured(spec.acceleration, drive.folder, motion.unit, orders, law, shaft, zero)
    return Plan(
        spec=spec,
        law=motion.law,
        corrected=corrected,
        levers=(drive.lever(motion.law), drive.lever(corrected)),
        unit=motion.unit,
        lever_unit=motion.unit if drive.closure is None else "rad",
        purity=purity,
        orders=orders,
        shaft=shaft,
        closure=drive.closure,
        before=before,
        after=after,
        cut=_whole(after),
        fit=fit,
        measured=record,
        notes=(*_of_record(drive, fit), *(() if record is None else record.notes)),
    )


def _whole(cams: Cams) -> dict[str, CutAway]:
    """What is cut away of the new cams: nothing. Raises ``InputError`` where something is."""
    cut: dict[str, CutAway] = {}
    for name, cam in cams.items():
        if isinstance(cam, FlatFacedCam):
            check_face(cam)
        else:
            cut[name] = cut_away(cam)
            if cut[name].largest_roller <= cam.follower.roller_radius:
                check_roller(cam)
    return cut


def _of_record(drive: CamDrive, fit: OrderFit | None) -> tuple[str, ...]:
    """What to check of the record of the speed, in sentences."""
    if fit is None or drive.speed is None:
        return ()
    notes = list(fit.warnings)
    by_itself = fit.unit == "rad" and drive.speed.pulses_per_turn is None  # an angle has a zero of its own
    if drive.speed.index is None and not by_itself:
        notes.append(
            f"The record has no index pulse: cam angle zero is taken to be at {fit.origin:.6g} s. The phase of the speed "
            "against the cam is not free; the line 'left if' says what a degree does."
        )
    for left in fit.notable():
        if left.order not in _TOLD and left.amplitude > max(_ERRORS * left.error, _MATTERS * fit.speed.mean):
            share = left.amplitude / fit.speed.mean
            notes.append(f"Order {left.order} is left out, but the record holds {share:.2%} of the speed in it.")
    return tuple(notes)


def left_by_errors(plan: Plan, shares: Mapping[int, float]) -> float | None:
    """What the standard errors of the record's orders leave, as the residuals do. shares: what each order left out leaves.

    What an order leaves is proportional to it, and the errors of different orders are independent: the root of the squares.
    """
    if plan.fit is None:
        return None
    amplitudes = plan.fit.speed.amplitudes
    parts = [
        shares[j] * error / amplitudes[j - 1]
        for j, error in zip(plan.fit.orders, plan.fit.amplitude_errors, strict=True)
        if j in shares
    ]
    return float(np.linalg.norm(parts))
