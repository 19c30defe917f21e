"""Spec and cam drive -> plan -> findings: law, shaft and springs, and the motion of the shaft with either cam."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.cams.correction import CorrectedLaw, MotionOverTime, above, orders
from wucht.cams.drive import CamDrive
from wucht.cams.elastic_output import Dwell, ElasticOutput
from wucht.cams.elastic_shaft import ElasticShaft
from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import Driving
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.harmonics import Harmonics, even_angles
from wucht.studies.cam_prediction.confirmation import Confirmation, confirmation
from wucht.studies.cam_prediction.elasticity import Twists, Vibrations, twists, vibrations
from wucht.studies.cam_prediction.spec import CamPrediction

_STILL = 1e-9  # of the largest velocity
_LOOKED_AT, _SHORTEST = 3600, 36  # cam angles at which a law without restrictions is scanned, and the fewest of a dwell
_ABOUT = (0.5, 1.5)  # times the mean speed


@dataclass(frozen=True, eq=False)
class Plan:
    """Law, shaft and springs of a prediction.

    count: N, the highest order of the law. output, twisting: elastic output and shaft, None where rigid. speeds: for the
    vibration of the output, rad/s.
    """

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
        """True if the drive holds the shaft's speed, whatever torque that takes."""
        return self.driving is not None and self.driving.enforced


def prepare(spec: CamPrediction, drive: CamDrive) -> Plan:
    """Return the plan. Raises ``InputError``: table [shaft] is missing or does not fit the law, drive or loads are wrong."""
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
        raise InputError("study.dwell", None, "the law has no dwell: give begin and end of the dwell")
    speeds = np.linspace(low, high, spec.speed_points)
    count, turns = motion.count or spec.orders, 0 if driving is not None and driving.enforced else spec.simulate
    cuts = 0 if driving is not None and driving.enforced else spec.cuts
    return Plan(motion, shaft, driving, count, spec.points, cuts, turns, output, table.twisting(), dwells, speeds)


def dwells_of(motion: MotionLaw) -> tuple[Dwell, ...]:
    """Return the dwells that a law prescribes; without any, the arcs on which it rests."""
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
    """Return the dwell on the arc of the spec, with the mean of the law as its value."""
    try:
        return Dwell(*arc, float(motion.law(np.linspace(*arc, 1000)).mean()))
    except InputError as error:
        raise error.within("study") from None


_AVERAGED = 4096  # points of a turn, for means


@dataclass(frozen=True)
class Eigenmotion:
    """Motion of the shaft at a mean speed with neither drive nor loads: its energy in J is constant."""

    mean_speed: float
    period: float
    energy: float
    fluctuation: float


@dataclass(frozen=True, eq=False)
class Turning:
    """Predicted motion of the shaft with a cam.

    acceleration: of the output by orders, per s^2. above: its largest order above N, as a share of order 1. multiplier: of a
    disturbance of the energy over a turn: below 1 the motion is stable. drive (points + 1): torque of the drive over tau.
    eigenmotion: at the same mean speed, None where there is none.
    """

    shaft: ShaftMotion
    acceleration: Harmonics
    above: float
    left: float
    drive: np.ndarray
    eigenmotion: Eigenmotion | None


@dataclass(frozen=True, eq=False)
class Cut:
    """Residual above order N with a cam, and the motion of the shaft that is measured with it; where none is
    obtained, the failure."""

    left: float = math.nan
    shaft: ShaftMotion | None = None
    failure: str = ""


@dataclass(frozen=True, eq=False)
class Findings:
    """Predictions with both cams, cams cut by measurement, simulations and springs.

    tau (N,): from 0 to 2 pi. cam (4, N): the corrected law over the cam angle, at the same angles, with derivatives.
    constant_speed_power (N,): power that output and loads take from a shaft that turns evenly. clean: orders of the law itself
    above N. cuts: residuals of cams cut one after the other; failure: reason why there are no more of them.
    """

    tau: np.ndarray
    original: Turning
    corrected: Turning
    cam: np.ndarray
    constant: np.ndarray
    clean: float
    cuts: np.ndarray
    failure: str
    confirmed: tuple[Confirmation, ...]
    vibrations: Vibrations | None
    twists: Twists | None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compute both motions of the shaft, cuts, simulations, springs. Raises ``RunError`` where there is no motion."""
    law, tau = plan.motion.law, np.linspace(0, 2 * math.pi, plan.points + 1)
    work.report(0.0, "motion of the shaft")
    original = work.unit("original cam", lambda: _turning(plan, law, _shaft(plan, law, False), tau, False))
    work.report(0.1, "motion of the shaft with the corrected cam")
    motion = work.unit("corrected cam", lambda: _shaft(plan, law, True))
    cam = CorrectedLaw(law, motion)
    corrected = work.unit("turning with the corrected cam", lambda: _turning(plan, cam, motion, tau, True))
    profile = np.array([cam(tau, order) for order in range(4)])
    cuts, failure = _cuts(plan, work.part("cuts", 0.2, 0.5))
    confirmed = []
    if plan.turns:
        for n, (one, shaft) in enumerate(((law, original.shaft), (cam, motion))):
            part = work.part("simulation", 0.5 + 0.15 * n, 0.65 + 0.15 * n)
            told = partial(_told, part)
            confirmed.append(part.unit(f"{n}", partial(confirmation, plan.shaft, one, shaft, plan.turns, told)))
    work.report(0.8, "springs")
    both, output, twisting = (original.shaft, motion), plan.output, plan.twisting
    swung = twisted = None
    if output is not None:
        swung = work.unit("output", lambda: vibrations(output, plan.motion, *both, plan.dwells, plan.speeds))
    if twisting is not None:
        inertia = plan.shaft.output_inertia
        twisted = work.unit("twist", lambda: twists(twisting, law, plan.count, inertia, *both))
    constant, clean = _constant(plan, motion.mean), above(orders(law), plan.count)
    yield Findings(tau, original, corrected, profile, constant, clean, cuts, failure, tuple(confirmed), swung, twisted)


def _told(work: Work, share: float) -> None:
    work.report(share, "simulation in time")


def _shaft(plan: Plan, law: Law, corrected: bool) -> ShaftMotion:
    """Return the motion of the shaft, uniform where the drive enforces its speed."""
    if plan.enforced:
        return ShaftMotion(Harmonics.of(plan.shaft.mean_speed))
    motion = plan.shaft.with_corrected_cam(law) if corrected else plan.shaft.with_cam(law)
    if plan.driving is not None and (stands := plan.driving.standing(motion.mean)):
        raise RunError(f"from the expected mean_speed the shaft comes to {motion.mean:.3g} rad/s: {stands}", code="stands")
    return motion


def _turning(plan: Plan, cam: Law, shaft: ShaftMotion, tau: np.ndarray, corrected: bool) -> Turning:
    spectrum, omega = orders(MotionOverTime(cam, shaft)), shaft.mean
    acceleration = Harmonics(0.0, omega**2 * spectrum.cosine, omega**2 * spectrum.sine)
    left, drive, free = _left(plan, cam, shaft), _drive(plan, cam, shaft, tau), _eigenmotion(plan, shaft, corrected)
    return Turning(shaft, acceleration, above(spectrum, plan.count), left, drive, free)


def _eigenmotion(plan: Plan, shaft: ShaftMotion, corrected: bool) -> Eigenmotion | None:
    law, omega, free = plan.motion.law, shaft.mean, plan.shaft.free(shaft.mean)
    try:
        found = free.with_corrected_cam if corrected else free.with_cam
        motion = shaft if plan.driving is None else found(law)
    except RunError:
        return None
    cam = CorrectedLaw(law, motion) if corrected else law
    return Eigenmotion(omega, 2 * math.pi / omega, free.energy(cam, motion), motion.fluctuation)


def _left(plan: Plan, cam: Law, shaft: ShaftMotion) -> float:
    """Return exp of the integral of dT/dphi'/J over the time of a turn: the Floquet multiplier of dE/dphi = T(phi')."""
    if plan.shaft.torque is None:
        return math.nan if plan.enforced else 1.0
    tau = even_angles(_AVERAGED)
    reduced = plan.shaft.inertia + plan.shaft.output_inertia * cam(shaft.angle(tau), 1) ** 2
    slope = plan.shaft.torque(shaft.speed(tau))[1]
    return float(np.exp(2 * math.pi / shaft.mean * (slope / reduced).mean()))


def _drive(plan: Plan, cam: Law, shaft: ShaftMotion, tau: np.ndarray) -> np.ndarray:
    """Return the torque of the drive; where it enforces the speed, the torque needed for that."""
    if plan.driving is None:
        return np.zeros(len(tau))
    drive, load = plan.driving.torques(shaft.speed(tau))[0]
    if not plan.enforced:
        return np.asarray(drive)
    return np.asarray(load + plan.shaft.output_inertia * shaft.mean**2 * cam(tau, 1) * cam(tau, 2))


def _constant(plan: Plan, omega: float) -> np.ndarray:
    """Return the power at constant speed, at the mean speed with the corrected cam, see ``Findings``."""
    law, points = plan.motion.law, plan.points
    output = plan.shaft.output_inertia * omega**3 * law(even_angles(points), 1) * law(even_angles(points), 2)
    load = 0.0 if plan.driving is None else omega * float(plan.driving.torques(np.array([omega]))[0][1][0])
    return np.append(output, output[0]) + load


def _cuts(plan: Plan, work: Work) -> tuple[np.ndarray, str]:
    left, cam = list[float](), plan.motion.law
    for n in range(plan.cuts):
        work.report(n / plan.cuts, f"cut and measured: cam {n + 1}")
        one = work.unit(f"cam {n + 1}", partial(_cut, plan, cam))
        if one.shaft is None:
            return np.array(left), f"with cam {n + 1}, cut for the speed measured with the one before: {one.failure}"
        left.append(one.left)
        cam = CorrectedLaw(plan.motion.law, one.shaft)
    return np.array(left), ""


def _cut(plan: Plan, cam: Law) -> Cut:
    try:
        return Cut(*plan.shaft.left_by(cam, plan.count))
    except RunError as error:
        return Cut(failure=str(error))
