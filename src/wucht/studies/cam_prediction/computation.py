"""Spec and cam drive -> plan -> findings: law, shaft and springs, and the motion of the shaft with either cam."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.cams.correction import CorrectedLaw, Deviation, MotionOverTime, Purity, orders
from wucht.cams.drive import CamDrive
from wucht.cams.dwells import dwells_of
from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.elastic_shaft import ElasticShaft
from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import CamshaftDrive
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.studies.cam_prediction.confirmation import Confirmation, confirmation
from wucht.studies.cam_prediction.elasticity import Twists, Vibrations, twists, vibrations
from wucht.studies.cam_prediction.spec import CamPrediction

_ABOUT = (0.5, 1.5)  # times the mean speed
_FEWEST, _MOST = 15, 100  # orders in the result


@dataclass(frozen=True, eq=False)
class Plan:
    """Law, shaft and springs of a prediction.

    purity: how the output is judged against its law. shown_orders: in the result. record: of the shaft's speed, None without.
    output, twisting: elastic output and shaft, None where rigid. speeds: for the
    vibration of the output, rad/s.
    """

    motion_law: MotionLaw
    shaft: CamShaft
    driving: CamshaftDrive | None
    purity: Purity
    shown_orders: int
    record: ShaftMotion | None
    points: int
    cuts: int
    turns: int
    output: ElasticOutput | None
    twisting: ElasticShaft | None
    dwells: tuple[Dwell, ...]
    speeds: np.ndarray

    @property
    def is_enforced(self) -> bool:
        """True if the drive holds the shaft's speed, whatever torque that takes."""
        return self.driving is not None and self.driving.is_enforced


def prepare(spec: CamPrediction, drive: CamDrive) -> Plan:
    """Return the plan. Raises ``InputError``: table [shaft] is missing or does not fit the law, drive or loads are wrong."""
    if drive.shaft is None:
        raise InputError(
            "shaft",
            None,
            "the table [shaft] is missing: the inertias of shaft and output, and what drives them",
            code="missing",
        )
    table, motion_law = drive.shaft, drive.motion_law
    output_inertia = table.moving_inertia(motion_law.unit)
    driving = table.camshaft_drive(drive.folder)
    shaft = table.camshaft(driving, motion_law.unit)
    output = None if table.elastic is None else table.elastic.output(output_inertia, motion_law.unit)
    dwells = (_dwell_on_arc(motion_law, spec.dwell),) if spec.dwell is not None else dwells_of(motion_law)
    low, high = spec.speeds or tuple(share * shaft.mean_speed for share in _ABOUT)
    if low <= 0:
        raise InputError("study.speeds", spec.speeds and list(spec.speeds), "must be above zero")
    if output is not None and not dwells:
        raise InputError("study.dwell", None, "the law has no dwell: give the start and end of the dwell")
    speeds = np.linspace(low, high, spec.speed_points)
    is_enforced = driving is not None and driving.is_enforced
    return Plan(
        motion_law=motion_law,
        shaft=shaft,
        driving=driving,
        purity=Purity.from_law(motion_law.function, motion_law.count),
        shown_orders=min(max(3 * (motion_law.count or spec.orders), _FEWEST), _MOST),
        record=None if drive.speed_fit is None else drive.shaft_motion,
        points=spec.points,
        cuts=0 if is_enforced else spec.cuts,
        turns=0 if is_enforced else spec.simulate,
        output=output,
        twisting=table.twisting(),
        dwells=dwells,
        speeds=speeds,
    )


def _dwell_on_arc(motion_law: MotionLaw, arc: tuple[float, float]) -> Dwell:
    """Return the dwell on the arc of the spec, with the mean of the law as its value."""
    try:
        return Dwell(*arc, float(motion_law.function(np.linspace(*arc, 1000)).mean()))
    except InputError as error:
        raise error.with_prefix("study") from None


_AVERAGE_POINTS = 4096  # points of a turn, for means


@dataclass(frozen=True)
class Eigenmotion:
    """Motion of the shaft at a mean speed with neither drive nor loads: its energy in J is constant."""

    mean_speed: float
    period: float
    energy: float
    fluctuation: float


@dataclass(frozen=True, eq=False)
class ShaftPrediction:
    """Predicted motion of the shaft with a cam.

    acceleration: of the output by orders, per s^2. deviation: of the output from its law over time. multiplier: of a
    disturbance of the energy over a turn: below 1 the motion is stable. drive (points + 1): torque of the drive over tau.
    eigenmotion: at the same mean speed, None where there is none.
    """

    shaft: ShaftMotion
    acceleration: FourierSeries
    deviation: Deviation
    multiplier: float
    drive: np.ndarray
    eigenmotion: Eigenmotion | None


@dataclass(frozen=True, eq=False)
class CutTrial:
    """Residual with a cam, see ``Purity.share``, and the motion of the shaft that is measured with it; where none is obtained,
    the failure."""

    residual: float = math.nan
    shaft: ShaftMotion | None = None
    failure: str = ""


@dataclass(frozen=True, eq=False)
class Findings:
    """Predictions with both cams, cams cut by measurement, simulations and springs.

    tau (N,): from 0 to 2 pi. cam (4, N): the corrected law over the cam angle, at the same angles, with derivatives.
    constant_speed_power (N,): power that output and loads take from a shaft that turns evenly. cuts: residuals of cams cut one
    after the other; failure: reason why there are no more of them.
    """

    tau: np.ndarray
    original_cam: ShaftPrediction
    corrected_cam: ShaftPrediction
    cam: np.ndarray
    constant_speed_power: np.ndarray
    cuts: np.ndarray
    failure: str
    confirmations: tuple[Confirmation, ...]
    vibrations: Vibrations | None
    twists: Twists | None


_CUTS_END, _SIMULATIONS_END = 0.35, 0.95  # of the work, of which the simulations are most


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compute both motions of the shaft, cuts, simulations, springs. Raises ``RunError`` where there is no motion."""
    law, tau = plan.motion_law.function, np.linspace(0, 2 * math.pi, plan.points + 1)
    work.report(0.0, "motion of the shaft")
    original_cam = work.unit("original cam", lambda: _shaft_prediction(plan, law, _shaft_motion(plan, law, False), tau, False))
    work.report(0.02, "motion of the shaft with the corrected cam")
    motion = work.unit("corrected cam", lambda: _shaft_motion(plan, law, True))
    cam = CorrectedLaw(law, motion)
    corrected_cam = work.unit("turning with the corrected cam", lambda: _shaft_prediction(plan, cam, motion, tau, True))
    profile = np.array([cam(tau, order) for order in range(4)])
    cuts, failure = _cut_residuals(plan, work.part("cuts", 0.05, _CUTS_END if plan.turns else _SIMULATIONS_END))
    confirmations = []
    if plan.turns:
        for n, (one, shaft) in enumerate(((law, original_cam.shaft), (cam, motion))):
            middle = (_CUTS_END + _SIMULATIONS_END) / 2
            part = work.part("simulation", *((_CUTS_END, middle), (middle, _SIMULATIONS_END))[n])
            report_share = partial(_report_simulation, part)
            confirmations.append(part.unit(f"{n}", partial(confirmation, plan.shaft, one, shaft, plan.turns, report_share)))
    work.report(_SIMULATIONS_END, "springs")
    shaft_motions, output, twisting = (original_cam.shaft, motion), plan.output, plan.twisting
    output_vibrations = shaft_twists = None
    if output is not None:
        output_vibrations = work.unit(
            "output", lambda: vibrations(output, plan.motion_law, *shaft_motions, plan.dwells, plan.speeds)
        )
    if twisting is not None:
        inertia = plan.shaft.output_inertia
        shaft_twists = work.unit("twist", lambda: twists(twisting, law, plan.purity, inertia, *shaft_motions))
    yield Findings(
        tau,
        original_cam,
        corrected_cam,
        profile,
        _constant_speed_power(plan, motion.mean),
        cuts,
        failure,
        tuple(confirmations),
        output_vibrations,
        shaft_twists,
    )


def _report_simulation(work: Work, share: float) -> None:
    work.report(share, "simulation in time")


def _shaft_motion(plan: Plan, law: Law, is_corrected: bool) -> ShaftMotion:
    """Return the motion of the shaft, uniform where the drive enforces its speed."""
    if plan.is_enforced:
        return ShaftMotion(FourierSeries.of(plan.shaft.mean_speed))
    motion = plan.shaft.motion_with_corrected_cam(law) if is_corrected else plan.shaft.motion_with_cam(law)
    if plan.driving is not None and (stands := plan.driving.stall_reason(motion.mean)):
        raise RunError(f"from the expected mean_speed the shaft comes to {motion.mean:.3g} rad/s: {stands}", code="stands")
    return motion


def _shaft_prediction(plan: Plan, cam: Law, shaft: ShaftMotion, tau: np.ndarray, is_corrected: bool) -> ShaftPrediction:
    motion, omega = MotionOverTime(cam, shaft), shaft.mean
    spectrum = orders(motion)
    acceleration = FourierSeries(0.0, omega**2 * spectrum.cosine, omega**2 * spectrum.sine)
    multiplier, drive, free = (
        _energy_multiplier(plan, cam, shaft),
        _drive_torque(plan, cam, shaft, tau),
        _eigenmotion(plan, shaft, is_corrected),
    )
    return ShaftPrediction(shaft, acceleration, plan.purity.deviation(motion), multiplier, drive, free)


def _eigenmotion(plan: Plan, shaft: ShaftMotion, is_corrected: bool) -> Eigenmotion | None:
    law, omega, free = plan.motion_law.function, shaft.mean, plan.shaft.without_torque(shaft.mean)
    try:
        solve = free.motion_with_corrected_cam if is_corrected else free.motion_with_cam
        motion = shaft if plan.driving is None else solve(law)
    except RunError:
        return None
    cam = CorrectedLaw(law, motion) if is_corrected else law
    return Eigenmotion(omega, 2 * math.pi / omega, free.energy(cam, motion), motion.fluctuation)


def _energy_multiplier(plan: Plan, cam: Law, shaft: ShaftMotion) -> float:
    """Return exp of the integral of dT/dphi'/J over the time of a turn: the Floquet multiplier of dE/dphi = T(phi')."""
    if plan.shaft.torque is None:
        return math.nan if plan.is_enforced else 1.0
    tau = even_angles(_AVERAGE_POINTS)
    inertia = plan.shaft.inertia + plan.shaft.output_inertia * cam(shaft.angle(tau), 1) ** 2
    slope = plan.shaft.torque(shaft.speed(tau))[1]
    return float(np.exp(2 * math.pi / shaft.mean * (slope / inertia).mean()))


def _drive_torque(plan: Plan, cam: Law, shaft: ShaftMotion, tau: np.ndarray) -> np.ndarray:
    """Return the torque of the drive; where it enforces the speed, the torque needed for that."""
    if plan.driving is None:
        return np.zeros(len(tau))
    drive, load = plan.driving.torques(shaft.speed(tau))[0]
    if not plan.is_enforced:
        return np.asarray(drive)
    return np.asarray(load + plan.shaft.output_inertia * shaft.mean**2 * cam(tau, 1) * cam(tau, 2))


def _constant_speed_power(plan: Plan, omega: float) -> np.ndarray:
    """Return the power at constant speed, at the mean speed with the corrected cam, see ``Findings``."""
    law, points = plan.motion_law.function, plan.points
    output = plan.shaft.output_inertia * omega**3 * law(even_angles(points), 1) * law(even_angles(points), 2)
    load = 0.0 if plan.driving is None else omega * float(plan.driving.torques(np.array([omega]))[0][1][0])
    return np.append(output, output[0]) + load


def _cut_residuals(plan: Plan, work: Work) -> tuple[np.ndarray, str]:
    residuals, cam = list[float](), plan.motion_law.function
    for n in range(plan.cuts):
        work.report(n / plan.cuts, f"cut and measured: cam {n + 1}")
        one = work.unit(f"cam {n + 1}", partial(_cut_trial, plan, cam))
        if one.shaft is None:
            return np.array(residuals), f"with cam {n + 1}, cut for the speed measured with the one before: {one.failure}"
        residuals.append(one.residual)
        cam = CorrectedLaw(plan.motion_law.function, one.shaft)
    return np.array(residuals), ""


def _cut_trial(plan: Plan, cam: Law) -> CutTrial:
    try:
        return CutTrial(*plan.shaft.residual_with_cam(cam, plan.purity))
    except RunError as error:
        return CutTrial(failure=str(error))
