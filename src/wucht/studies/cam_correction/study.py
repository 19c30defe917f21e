"""Correction of a cam for the motion of its shaft: its keys, what is checked before, and its computation."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from wucht.cams.corrected_contours import CheckedContour, Proof
from wucht.cams.correction import MotionOverTime, Purity, last_order_above, left_out_orders, orders, residuals
from wucht.cams.drive import CamDrive
from wucht.cams.drive_cams import DriveCams
from wucht.cams.measured_acceleration import MeasuredAcceleration
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import CAM_LABELS
from wucht.cams.tables.acceleration_record import MOST_ORDERS, Acceleration, Count
from wucht.cams.workshop.heading import CAM_VERSIONS
from wucht.cams.workshop.points import SPACING
from wucht.dynamics.work import Work
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import state_motion, warn_of_jumps
from wucht.studies.cam_correction import answer, record_answer
from wucht.studies.cam_correction.figure import draw_correction
from wucht.studies.cam_workshop import check_points, drive_of, file_lines, mill_points, write_files
from wucht.studies.key_types import Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TIMES = 721  # at which the motion over time is given, the first again at the end
_DEFAULT_ORDERS = 60  # orders shown of a law with infinitely many

Prepared = tuple[DriveCams, DriveCams, Purity, MeasuredAcceleration | None]


class CamCorrection(Study):
    """Cam that gives the output its motion law over time although the camshaft does not turn evenly."""

    kind = "cam-correction"
    next_questions = (NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),)
    solves = "rigid parts; the camshaft turns as its table [speed] says"
    subject = "wucht.studies.cam_drives:CAM_DRIVE"
    curves = (("cam_angle", "moved"), ("cam_angle", "pressure_angle"))

    points: Whole = Field(default=1440, ge=36, le=20_000, description=(
        "number of cam angles, evenly spaced over a turn, at which cam table and contours are given"
    ))  # fmt: skip
    orders: Count | None = Field(
        default=None,
        title="number of orders shown",
        description=(
            "number of orders shown; by default three times those of the law, and all that are not negligible with the "
            "original cam; the summary lists these in any case"
        ),
    )
    acceleration: Composite[Acceleration | None] = composite(
        default=None, description="record of the output's acceleration to compare with, a table `[study.acceleration]`"
    )
    chord_tolerance: SI[float] = si("m", "chord tolerance", default=1e-6, gt=0, help=(
        "chord tolerance of lists for the workshop: the residual with chords between their points is computed"
    ))  # fmt: skip
    decimals: Whole = Field(default=5, ge=0, le=12, description=(
        "number of decimals in mm of lists for the workshop: the residual with coordinates rounded so is computed"
    ))  # fmt: skip

    def table_for(self, subject: Any) -> dict[str, Any]:
        """Return the question, see ``Study``: a changed record of the acceleration is another one."""
        question = self.to_table()
        if self.acceleration is not None:
            question["acceleration"]["contents"] = subject.contents(self.acceleration.file)
        return question

    def prepare(self, drive: CamDrive) -> Prepared:
        """Return the original and the corrected cams, the measure of their motion, and the measured acceleration.

        Raises ``InputError``: there is no such law, the output stands still, the motion of the shaft is not given, it turns
        back, a record cannot be used, or the linkage or the follower cannot make the motion.
        """
        motion_law, shaft = drive.motion_law, drive.shaft_motion
        purity = Purity.from_law(motion_law.function, motion_law.count)
        original, corrected = (DriveCams.of(drive, shaft, is_corrected) for is_corrected in (False, True))
        if self.acceleration is None:
            return original, corrected, purity, None
        law = original.law if self.acceleration.cam == "original" else corrected.law
        return original, corrected, purity, self.acceleration.compare(drive, law, self._examined_orders(purity))

    def _examined_orders(self, purity: Purity) -> int:
        return self.orders or 3 * (purity.count or _DEFAULT_ORDERS // 3)

    def solve(self, drive: CamDrive, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute motions, contours, residuals and proofs. Raises ``InputError`` where the corrected cam is cut away."""
        original, corrected, purity, measurement = prepared
        a, cam_pair, law, shaft, fit = Answer(), (original, corrected), original.law, drive.shaft_motion, drive.speed_fit
        unit = drive.motion_law.unit
        work.report(0.0, "motion over time")
        motions = [MotionOverTime(cams.law, shaft) for cams in cam_pair]
        spectra = [orders(motion) for motion in motions]
        tau, angles = np.linspace(0, 2 * np.pi, TIMES), even_angles(self.points)
        shares = work.unit("what is left", partial(residuals, law, purity.count, shaft))
        of_conditions = {condition: share for condition, share in shares.items() if condition != "as measured"}
        left_out = work.unit("orders left out", lambda: left_out_orders(fit, law, purity.count, shaft))
        after = _contours(work.part("corrected", 0.1, 0.5), corrected, original, angles)
        before = _contours(work.part("original", 0.5, 0.8), original, original, angles)
        examined_count = self._examined_orders(purity)
        last_order = min(last_order_above(spectra[0].amplitudes), MOST_ORDERS)
        is_chosen = self.orders is not None or purity.count is None  # infinitely many do not fit a figure
        fitted_count = 0 if measurement is None else measurement.measured_orders.count
        shown_count = max(examined_count, fitted_count, 0 if is_chosen else last_order)
        proofs = dict[str, Proof]()
        for i, (name, corrected_cam) in enumerate(corrected.cams.items()):
            work.report(0.8 + 0.2 * i / len(after), f"motion from the points of the corrected {CAM_LABELS[name]}")
            count, points = max(shown_count, 3 * (purity.count or 0)), corrected_cam.contour(angles)
            prove = partial(Proof.of, corrected, shaft, name, points, self.decimals, count)
            proofs[name] = work.unit(f"proof of {name}", prove)
        a.curve("version", list(CAM_VERSIONS), "cam")
        a.curve("tau", tau, "time as an angle, omega t", "rad")
        a.curve("cam_angle", angles, "cam angle", "rad")
        a.curve("order", np.arange(1, shown_count + 1), "order")
        a.curve("cam", np.array(list(after), dtype=str), "cam")
        warn_of_jumps(a, drive.motion_law)
        answer.state_shaft(a, shaft, tau)
        accelerations = answer.state_motions_over_time(a, motions, law, tau, unit)
        a.curve("residual", list(of_conditions), "deviation from the assumptions of the cam")
        a.curve("share", list(of_conditions.values()), "residual as a share", "", "residual")
        record_answer.state_record(a, drive, left_out, of_conditions)
        cam = "" if self.acceleration is None else self.acceleration.cam
        record_answer.warn_of_measurement(a, measurement, cam, shaft)
        follower_unit = unit if drive.closure is None else "rad"
        for name, laws, of in (
            ("output", [cams.law for cams in cam_pair], unit),
            ("follower", [cams.follower_law for cams in cam_pair], follower_unit),
        ):
            derivatives = ([one(angles, order) for one in laws] for order in range(4))
            state_motion(a, name, derivatives, f"motion of the {name}", of, "version cam_angle")
        answer.state_orders(a, spectra, shaft, unit, shown_count, max(examined_count, purity.count or 0, last_order))
        deviations = [purity.deviation(motion) for motion in motions]
        answer.state_positions(a, drive, motions, accelerations, deviations, float(np.ptp(law(angles))))
        answer.state_camshaft_powers(a, drive, motions, tau)
        proof_shares = answer.state_proofs(
            a, purity, proofs, shaft.mean**2, unit, shown_count, examined_count, self.points, self.decimals
        )
        answer.state_purity(a, purity, deviations, proof_shares, left_out, self.points)
        answer.state_residuals(a, of_conditions)
        record_answer.state_speed_orders(a, shaft, fit)
        answer.state_contours(a, cam_pair, before, after, follower_unit, angles, self.chord_tolerance)
        record_answer.state_measurement(a, measurement, cam, shaft, tau, unit, shown_count)
        yield a

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the acceleration before and after, the speed of the shaft, the cams and their difference."""
        return draw_correction(result)

    def export(self, result: xr.Dataset, folder: Path) -> list[str]:
        """Write points to mill of the corrected cam, drawings and cam tables; without a follower the tables alone."""
        speed = FourierSeries.of(result.wucht.summary["mean_speed"], result.speed_cosine.values, result.speed_sine.values)
        cams, keys = DriveCams.of(drive_of(result), ShaftMotion(speed), True), result.wucht.question["study"]
        for name, cam in cams.cams.items():
            contour = result.sel(version=CAM_VERSIONS[True], cam=name)
            check_points(cam, result.cam_angle.values, contour.contour_x.values + 1j * contour.contour_y.values)
        points = mill_points(cams.cams, keys["chord_tolerance"], SPACING)
        return file_lines(write_files(cams, points, folder, keys["chord_tolerance"], SPACING, keys["decimals"]))


def _contours(work: Work, cams: DriveCams, original: DriveCams, angles: np.ndarray) -> dict[str, CheckedContour]:
    """Return the contours by name, each a unit of work."""
    contours: dict[str, CheckedContour] = {}
    for i, (name, cam) in enumerate(cams.cams.items()):
        work.report(i / len(cams.cams), f"{work.name.rstrip('/')} {CAM_LABELS[name]}")
        contours[name] = work.unit(name, partial(CheckedContour.of, name, cam, original.cams[name], angles))
    return contours
