"""Effect of springs on the prediction: an elastic output behind the cam's lever, an elastic shaft behind its flywheel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.correction import CorrectedLaw, MotionOverTime, Purity
from wucht.cams.elastic_output import (
    Dwell,
    ElasticOutput,
    Excitation,
    Levers,
    ranked_excitations,
    truncate_law,
)
from wucht.cams.elastic_shaft import CorrectedCam, ElasticShaft, OriginalCam, OutputLoad
from wucht.cams.laws import Law
from wucht.cams.laws.cam_segments import RiseAndReturn
from wucht.cams.laws.standard_laws import standard_law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.motion_law import MotionLaw
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries, even_angles

_SAMPLES = 2048
_MOST_ORDERS, _SMALL = 40, 1e-9  # of a lever's motion: those that matter
_STANDARD = ("3-4-5", "4-5-6-7", "modified-sine", "inclined-sine")
_FEWEST, _MOST = 256, 1024  # points of a turn at which the cam behind its shaft is balanced
RIGID_SHAFT_CAM, TWIST_CAM = "corrected cam", "corrected for the twist too"  # cams behind an elastic shaft
_NEAR = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])  # about a resonance, so that no peak falls between two speeds


@dataclass(frozen=True, eq=False)
class Vibrations:
    """Vibrations of an elastic output.

    speeds: rad/s (M,). deviation, acceleration: by each cam of ``names`` at these, see ``ElasticOutput.residual`` (L, M).
    orders, resonances: of the corrected cam, see ``ElasticOutput.resonances`` (R,). excitations: by each cam, and by other laws
    with the same stroke and dwell, those with the least vibration first. notes: computations that were not possible.
    """

    names: tuple[str, ...]
    speeds: np.ndarray
    deviation: np.ndarray
    acceleration: np.ndarray
    orders: np.ndarray
    resonances: np.ndarray
    excitations: tuple[Excitation, ...]
    notes: tuple[str, ...]


def vibrations(
    output: ElasticOutput,
    motion_law: MotionLaw,
    original_motion: ShaftMotion,
    corrected_motion: ShaftMotion,
    dwells: tuple[Dwell, ...],
    speeds: np.ndarray,
) -> Vibrations:
    """Compute the vibrations with the original cam, the corrected one, and one tuned to the natural frequency.

    Each lever is assumed to move alike over tau at all mean speeds: exact without a drive, where the fluctuation is
    proportional to the speed.
    """
    law, omega, notes = motion_law.function, corrected_motion.mean, list[str]()
    clean = motion_law.series or truncate_law(law, _MOST_ORDERS)
    time_dwells = tuple(
        Dwell(float(original_motion.time(d.begin)), float(original_motion.time(d.end)), d.value) for d in dwells
    )
    levers = {"original cam": (_series(MotionOverTime(law, original_motion)), time_dwells), "corrected cam": (clean, dwells)}
    try:
        levers["corrected and tuned cam"] = output.tuned_lever(clean, omega), dwells
    except InputError as error:
        notes.append(f"no cam is tuned to the output: {error.explanation}")
    speeds = _with_resonances(output, clean.count, speeds)
    residuals = [output.residual_over_speed(lever, speeds, at) for lever, at in levers.values()]
    deviation, acceleration = (np.array(values) for values in zip(*residuals, strict=True))
    orders, resonances = output.resonances(clean, speeds.min(), speeds.max())
    excitations = ranked_excitations(output, {**levers, **_standard_levers(law, dwells)}, omega)
    return Vibrations(tuple(levers), speeds, deviation, acceleration, orders, resonances, excitations, tuple(notes))


def _series(law: Law) -> FourierSeries:
    whole = FourierSeries.from_samples(law(even_angles(_SAMPLES))).without_rounding(_SMALL)
    return FourierSeries(whole.mean, whole.cosine[:_MOST_ORDERS], whole.sine[:_MOST_ORDERS])


def _with_resonances(output: ElasticOutput, count: int, speeds: np.ndarray) -> np.ndarray:
    """Add speeds about omega_0/k; not without damping, where there is no steady motion."""
    if not output.damping:
        return speeds
    peaks = output.natural_frequency / np.arange(1, count + 1)
    near = np.ravel(peaks[:, None] * (1 + _NEAR))
    return np.unique(np.append(speeds, near[(near >= speeds[0]) & (near <= speeds[-1])]))


def _standard_levers(law: Law, dwells: tuple[Dwell, ...]) -> Levers:
    """Return standard laws with the same stroke and dwell, rise and return in equal times, where there is one dwell."""
    if len(dwells) != 1:
        return {}
    (dwell,) = dwells
    begin, end = dwell.end, dwell.begin + 2 * math.pi
    middle = (begin + end) / 2
    away = law(even_angles(_SAMPLES)) - dwell.value
    stroke = float(away[np.abs(away).argmax()])
    levers = dict[str, tuple[FourierSeries, tuple[Dwell, ...]]]()
    for name in _STANDARD:
        rise_and_return = RiseAndReturn(standard_law(name), stroke, (begin, middle), (middle, end))
        series = truncate_law(rise_and_return, _MOST_ORDERS)
        lever = FourierSeries(series.mean + dwell.value, series.cosine, series.sine)
        levers[f"law {name}"] = lever, dwells
    return levers


@dataclass(frozen=True, eq=False)
class Twist:
    """Motion behind an elastic shaft, with the name of the cam.

    above: how far the orders of the output's acceleration are from the law's, see ``Purity.share``. torque: largest in the
    shaft, in N m. twist: largest of the shaft, in rad.
    """

    name: str
    above: float
    torque: float
    twist: float


def cam_twists(
    shaft: ElasticShaft, inertia: float, purity: Purity, original_motion: ShaftMotion, corrected_motion: ShaftMotion
) -> tuple[tuple[Twist, ...], tuple[str, ...]]:
    """Compute the motion of cams behind an elastic shaft whose flywheel turns as predicted for a rigid shaft.

    inertia: of the output, in kg m^2 or kg. Returns that of each cam with a periodic motion, and the reasons for the others.
    """
    law = purity.law
    corrected_law = CorrectedLaw(law, corrected_motion)
    rigid = FourierSeries.from_samples(corrected_law(even_angles(_SAMPLES))).without_rounding()
    cams: list[tuple[str, OutputLoad, ShaftMotion]] = [
        ("original cam", OriginalCam(law, inertia), original_motion),
        (RIGID_SHAFT_CAM, OriginalCam(rigid, inertia), corrected_motion),
        (TWIST_CAM, CorrectedCam(law, inertia), corrected_motion),
    ]
    twists, notes = list[Twist](), list[str]()
    for name, load, flywheel in cams:
        points = min(max(_FEWEST, 4 * flywheel.speed.count), _MOST)
        drive = FourierSeries.from_samples(flywheel.angle(even_angles(points)) - even_angles(points)).without_rounding()
        try:
            turning = shaft.periodic_motion(load, drive, flywheel.mean, points)
        except RunError as error:
            notes.append(f"on the elastic shaft, {name}: {error}")
            continue
        torque = float(np.abs(turning.torque(even_angles(_SAMPLES))).max())
        lag = drive(even_angles(_SAMPLES)) - turning.fluctuation(even_angles(_SAMPLES))
        twists.append(Twist(name, purity.share(turning.output.derivative(2)), torque, float(np.abs(lag).max())))
    return tuple(twists), tuple(notes)
