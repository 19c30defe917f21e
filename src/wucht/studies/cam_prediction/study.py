"""Prediction of the motion of a camshaft: its keys, what is checked before, and its computation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from wucht.cams.confirmation import Confirmation, confirmation
from wucht.cams.correction import CorrectedLaw, Purity
from wucht.cams.drive import CamDrive
from wucht.cams.driven_camshaft import DrivenCamshaft
from wucht.cams.dwells import dwells_of
from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.elastic_shaft import ElasticShaft
from wucht.cams.elasticity import Vibrations, cam_twists, vibrations
from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.schema import SI, si
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import power_numbers, state_law
from wucht.studies.cam_prediction import answer
from wucht.studies.cam_prediction import prediction_verdict as verdict
from wucht.studies.cam_prediction.figure import draw_prediction
from wucht.studies.key_types import Interval, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_SPEED_RANGE = (0.5, 1.5)  # times the mean speed
_FEWEST, _MOST = 15, 100  # orders in the result
_CUTS_END, _SIMULATIONS_END = 0.35, 0.95  # of the work, of which the simulations are most

Prepared = tuple[DrivenCamshaft, ElasticOutput | None, ElasticShaft | None, tuple[Dwell, ...], np.ndarray, ShaftMotion | None]


class CamPrediction(Study):
    """Motion of a camshaft with its output, drive and loads, and the cam that is clean on it, without a measurement."""

    kind = "cam-prediction"
    next_questions = (NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),)
    subject = "wucht.studies.cam_drives:CAM_DRIVE"
    curves = (("tau", "speed"), ("tau", "drive_torque"))

    points: Whole = Field(
        default=720, ge=16, le=100_000, description="number of points over the time and the cam angle of a turn"
    )
    orders: Whole = Field(default=20, ge=1, le=200, description=(
        "of a law with infinitely many orders, a third of those that the result has; all of them are compared with the law's"
    ))  # fmt: skip
    cuts: Whole = Field(default=5, ge=0, le=50, description=(
        "number of cams cut one after the other for comparison, each for the speed measured with the one before"
    ))  # fmt: skip
    simulate: Whole = Field(
        default=20, ge=0, le=1000, description="number of turns of the confirming simulation in time, 0 for none"
    )
    speeds: SI[Interval | None] = si("rad/s", "mean speed", default=None, help=(
        "range of the mean speed over which the vibration in the dwell of an elastic output is shown, by default from half the "
        "mean speed to one and a half times it"
    ))  # fmt: skip
    speed_points: Whole = Field(default=160, ge=2, le=10_000, description="number of speeds in the range `speeds`")
    dwell: SI[Interval | None] = si("rad", "start and end of the dwell", default=None, help=(
        "start and end of the arc on which an elastic output is to rest; by default the dwells of the law"
    ))  # fmt: skip

    def prepare(self, drive: CamDrive) -> Prepared:
        """Return the driven shaft, elastic output and shaft if they are not rigid, dwells, speeds, and the record of the speed.

        Raises ``InputError``: table [shaft] is missing or does not fit the law, drive or loads are wrong.
        """
        if drive.shaft is None:
            requirement = "the table [shaft] is missing: the inertias of shaft and output, and what drives them"
            raise InputError("shaft", None, requirement, code="missing")
        table, motion_law = drive.shaft, drive.motion_law
        output_inertia = table.moving_inertia(motion_law.unit)
        driving = table.camshaft_drive(drive.folder)
        shaft = table.camshaft(driving, motion_law.unit)
        output = None if table.elastic is None else table.elastic.output(output_inertia, motion_law.unit)
        dwells = dwells_of(motion_law) if self.dwell is None else (_dwell_on_arc(motion_law, self.dwell),)
        low, high = self.speeds or tuple(share * shaft.mean_speed for share in _SPEED_RANGE)
        if low <= 0:
            raise InputError("study.speeds", self.speeds and list(self.speeds), "must be above zero")
        if output is not None and not dwells:
            raise InputError("study.dwell", None, "the law has no dwell: give the start and end of the dwell")
        purity = Purity.from_law(motion_law.function, motion_law.count)
        record = None if drive.speed_fit is None else drive.shaft_motion
        camshaft = DrivenCamshaft(motion_law.function, shaft, driving, purity)
        return camshaft, output, table.twisting(), dwells, np.linspace(low, high, self.speed_points), record

    def solve(self, drive: CamDrive, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute both motions of the shaft, cuts, simulations, springs. Raises ``RunError`` where there is no motion."""
        camshaft, output, twisting, dwells, speeds, record = prepared
        motion_law, law, tau = drive.motion_law, camshaft.law, np.linspace(0, 2 * math.pi, self.points + 1)
        turns = 0 if camshaft.is_enforced else self.simulate
        work.report(0.0, "motion of the shaft")
        original = work.unit("original cam", lambda: camshaft.prediction(law, camshaft.motion(False), tau, False))
        work.report(0.02, "motion of the shaft with the corrected cam")
        motion = work.unit("corrected cam", lambda: camshaft.motion(True))
        cam = CorrectedLaw(law, motion)
        corrected = work.unit("turning with the corrected cam", lambda: camshaft.prediction(cam, motion, tau, True))
        count = 0 if camshaft.is_enforced else self.cuts
        part = work.part("cuts", 0.05, _CUTS_END if turns else _SIMULATIONS_END)
        cuts, failure = _cut_residuals(camshaft, count, part)
        confirmations = _confirmations(camshaft.shaft, ((law, original.shaft), (cam, motion)), turns, work)
        work.report(_SIMULATIONS_END, "springs")
        output_vibrations: Vibrations | None = None
        twists, twist_notes = None, tuple[str, ...]()
        if output is not None:
            vibrate = partial(vibrations, output, motion_law, original.shaft, motion, dwells, speeds)
            output_vibrations = work.unit("output", vibrate)
        if twisting is not None:
            twist = partial(cam_twists, twisting, camshaft.shaft.output_inertia, camshaft.purity, original.shaft, motion)
            twists, twist_notes = work.unit("twist", twist)
        a, purity, unit = Answer(), camshaft.purity, motion_law.unit
        predictions = {"original": original, "corrected": corrected}
        shown_count = min(max(3 * (motion_law.count or self.orders), _FEWEST), _MOST)
        constant_power = camshaft.constant_speed_power(motion.mean, self.points)
        constant = power_numbers(constant_power)
        powers = {name: power_numbers(one.drive * one.shaft.speed(tau)) for name, one in predictions.items()}
        answer.state_motions(a, predictions, tau, constant_power, unit, shown_count)
        state_law(a, cam, tau, "law of the corrected cam", unit)
        a.number("unit", unit, "unit of the output")
        a.number("harmonics", motion_law.count, "number N of harmonics of the law")
        answer.state_shafts(a, camshaft, predictions, powers)
        answer.state_output_motions(a, predictions, (law, cam), tau, unit, purity.stroke)
        shares = answer.state_speed_record(a, record, predictions, tau)
        answer.state_powers(a, camshaft, constant, powers)
        contraction = answer.state_cuts(a, purity, cuts)
        answer.state_simulation(a, purity, self.simulate, confirmations, predictions, unit, shown_count)
        answer.state_output(a, output, output_vibrations, unit)
        answer.state_twists(a, purity, twists, output is not None)
        verdict.state_prediction_verdict(a, camshaft, predictions, confirmations, twists, powers["corrected"]["peak"])
        verdict.warn_of_cutting(a, camshaft, contraction, failure)
        verdict.warn_of_motions(a, predictions, confirmations)
        a.warn(*(output_vibrations.notes if output_vibrations is not None else ()))
        verdict.warn_of_record(a, record, shares, predictions)
        verdict.warn_of_twists(a, purity, twists or (), twist_notes)
        is_rigid = output is None and twisting is None
        a.assume(
            "rigid parts" if is_rigid else "elastic parts where stiffnesses are given",
            "the camshaft held at its drive's speed" if camshaft.is_enforced else "the camshaft as inertia and drive move it",
        )
        yield a

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw speeds, orders and powers of both cams, and cuts or springs if there are any."""
        return draw_prediction(result)


def _dwell_on_arc(motion_law: MotionLaw, arc: tuple[float, float]) -> Dwell:
    """Return the dwell on the arc of the key, with the mean of the law as its value."""
    try:
        return Dwell(*arc, float(motion_law.function(np.linspace(*arc, 1000)).mean()))
    except InputError as error:
        raise error.with_prefix("study") from None


def _confirmations(
    camshaft: CamShaft, motions: Sequence[tuple[Law, ShaftMotion]], turns: int, work: Work
) -> list[Confirmation]:
    """Return the simulation of each predicted motion with its cam; none without turns."""
    confirmations, middle = list[Confirmation](), (_CUTS_END + _SIMULATIONS_END) / 2
    for n, (cam, motion) in enumerate(motions if turns else ()):
        part = work.part("simulation", *((_CUTS_END, middle), (middle, _SIMULATIONS_END))[n])
        report_share = partial(part.report, label="simulation in time")
        confirmations.append(part.unit(f"{n}", partial(confirmation, camshaft, cam, motion, turns, report_share)))
    return confirmations


def _cut_residuals(camshaft: DrivenCamshaft, count: int, work: Work) -> tuple[np.ndarray, str]:
    """Return the residuals of cams cut one after the other, and the reason why there are no more of them."""
    residuals, cam = list[float](), camshaft.law
    for n in range(count):
        work.report(n / count, f"cut and measured: cam {n + 1}")
        outcome = work.unit(f"cam {n + 1}", partial(_cut_trial, camshaft, cam))
        if isinstance(outcome, str):
            return np.array(residuals), f"with cam {n + 1}, cut for the speed measured with the one before: {outcome}"
        residuals.append(outcome[0])
        cam = CorrectedLaw(camshaft.law, outcome[1])
    return np.array(residuals), ""


def _cut_trial(camshaft: DrivenCamshaft, cam: Law) -> tuple[float, ShaftMotion] | str:
    """Return what a cam leaves and the motion of the shaft that is measured with it, or why there is no such motion."""
    try:
        return camshaft.shaft.residual_with_cam(cam, camshaft.purity)
    except RunError as error:
        return str(error)
