"""Plan -> findings: motion over time, cam tables, contours, residuals under deviating conditions, and the proof."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.correction import Deviation, MotionOverTime, Residual, orders, residual_of_extra_order, residuals
from wucht.cams.dwells import position_error
from wucht.cams.laws import Law
from wucht.cams.milled_cam import MilledCam
from wucht.cams.shape import CAM_LABELS, Shape, pressure_angle_remarks, shapes
from wucht.cams.workshop.closed_curve import CamCurve, curve_distances
from wucht.cams.workshop.points import chord_deviation
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.measurements.shaft_signal import TURN
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.studies.cam_correction.prepare import Cams, Plan

TIMES = 721  # at which the motion over time is given, the first again at the end
_RECOVERY_TIMES = 1024  # times at which the follower on the milled points is computed
_SEARCH_OFFSET = 2e-3  # of the stroke: the search begins beside the expected position
_ERRORS = 3.0  # standard errors: a larger order that is left out is significant
_MOST, _NOTHING = 6, 1e-4  # largest of them that are examined; of order 1: a residual that does not matter
_SAMPLES = 3000  # of a record, shown in the figure


@dataclass(frozen=True, eq=False)
class Contour:
    """Contour of a cam at the cam angles (N,): points and normals (away from the centre) complex in m, curvature in 1/m.

    Curvature is positive where the contour is convex; pressure angle in rad; uncut: 0 at an edge. displacement: distance in m
    of the points outside the original contour. chord: largest distance in m between chords and contour. shape: its sizes.
    """

    points: np.ndarray
    normals: np.ndarray
    curvature: np.ndarray
    pressure_angle: np.ndarray
    uncut: np.ndarray
    displacement: np.ndarray
    chord: float
    shape: Shape


@dataclass(frozen=True, eq=False)
class Proof:
    """Acceleration over omega^2 from the points of a corrected cam, and from these rounded; None where it fails, with
    notes."""

    recovered: FourierSeries | None
    rounded: FourierSeries | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class LeftOut:
    """Order of the speed in a record that is not corrected. amplitude, error: in rad/s. share: its residual."""

    order: int
    amplitude: float
    error: float
    share: float


@dataclass(frozen=True, eq=False)
class Findings:
    """Motion, contours and residuals; each pair is for the original and the corrected cam.

    tau (T,): time as an angle. output, acceleration: over tau, the latter in the output's unit/s^2. spectrum: of the latter,
    over omega^2. deviation: of the output from its law over time. table, lever: derivatives 0 to 3 (4, N) by the cam angle of
    output and follower. contours, proofs: by the name of the cam. from_errors, left_out: residuals of the record's standard
    errors, and of orders that are not corrected. dwell_errors: largest distances of the output from its dwells, None without.
    samples: tau (S,) and measured acceleration (S,) of a record, folded over a turn.
    """

    tau: np.ndarray
    output: tuple[np.ndarray, np.ndarray]
    acceleration: tuple[np.ndarray, np.ndarray]
    spectrum: tuple[FourierSeries, FourierSeries]
    deviation: tuple[Deviation, Deviation]
    angles: np.ndarray
    table: tuple[np.ndarray, np.ndarray]
    lever: tuple[np.ndarray, np.ndarray]
    contours: tuple[Mapping[str, Contour], Mapping[str, Contour]]
    proofs: Mapping[str, Proof]
    residuals: tuple[Residual, ...]
    from_errors: float | None
    left_out: tuple[LeftOut, ...]
    samples: tuple[np.ndarray, np.ndarray]
    notes: tuple[str, ...]
    dwell_errors: tuple[float | None, float | None] = (None, None)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings once. Raises ``InputError`` (follower...) where the corrected cam would be cut away."""
    work.report(0.0, "motion over time")
    over_time = [MotionOverTime(law, plan.shaft) for law in (plan.law, plan.corrected_law)]
    spectra = [orders(motion) for motion in over_time]
    tau, angles = np.linspace(0, 2 * np.pi, TIMES), even_angles(plan.spec.points)
    scale = plan.shaft.mean**2
    residual_list = work.unit("what is left", lambda: _residuals(plan))
    left_out = work.unit("orders left out", lambda: _left_out(plan))
    after = _contours(plan, work.part("corrected", 0.1, 0.5), plan.after, angles)
    before = _contours(plan, work.part("original", 0.5, 0.8), plan.before, angles)
    proofs: dict[str, Proof] = {}
    for i, (name, contour) in enumerate(after.items()):
        work.report(0.8 + 0.2 * i / len(after), f"motion from the points of the corrected {CAM_LABELS[name]}")
        proofs[name] = work.unit(f"proof of {name}", partial(_proof, plan, name, contour.points))
    proof_notes = (note for proof in proofs.values() for note in proof.notes)
    yield Findings(
        tau=tau,
        output=(over_time[0](tau), over_time[1](tau)),
        acceleration=(scale * over_time[0](tau, 2), scale * over_time[1](tau, 2)),
        spectrum=(spectra[0], spectra[1]),
        deviation=(plan.purity.deviation(over_time[0]), plan.purity.deviation(over_time[1])),
        angles=angles,
        table=(_derivatives(plan.law, angles), _derivatives(plan.corrected_law, angles)),
        lever=(_derivatives(plan.levers[0], angles), _derivatives(plan.levers[1], angles)),
        contours=(before, after),
        proofs=proofs,
        residuals=residual_list,
        from_errors=_residual_of_errors(plan, residual_list),
        left_out=left_out,
        samples=_folded_samples(plan),
        notes=(*plan.notes, *proof_notes, *_notes(plan, before, after)),
        dwell_errors=_dwell_errors(plan, over_time),
    )


def _dwell_errors(plan: Plan, over_time: list[MotionOverTime]) -> tuple[float | None, float | None]:
    if not plan.dwells:
        return None, None
    return position_error(over_time[0], plan.dwells), position_error(over_time[1], plan.dwells)


def _derivatives(law: Law, angles: np.ndarray) -> np.ndarray:
    return np.array([law(angles, order) for order in range(4)])


def _residuals(plan: Plan) -> tuple[Residual, ...]:
    """Return the residuals where one condition deviates from the assumptions of the cam."""
    return tuple(r for r in residuals(plan.law, plan.purity.count, plan.shaft) if r.condition != "as measured")


def _residual_of_errors(plan: Plan, residual_list: tuple[Residual, ...]) -> float | None:
    """Return the residual due to the standard errors of the record's orders.

    The residual of an order is proportional to it, and errors of different orders are independent: the root of the squares.
    """
    if plan.fit is None:
        return None
    shares = {int(r.condition.split()[1]): r.share for r in residual_list if r.condition.startswith("order ")}
    errors = zip(plan.fit.orders, plan.fit.amplitude_errors, strict=True)
    amplitudes = plan.fit.speed.amplitudes
    return float(np.linalg.norm([shares[j] * error / amplitudes[j - 1] for j, error in errors if j in shares]))


def _left_out(plan: Plan) -> tuple[LeftOut, ...]:
    """Return the significant orders of the record that are not corrected and matter, the largest first."""
    significant = [] if plan.fit is None else [one for one in plan.fit.omitted_orders if one.amplitude > _ERRORS * one.error]
    left_out: list[LeftOut] = []
    for one in sorted(significant, key=lambda one: -one.amplitude)[:_MOST]:
        with suppress(InputError):  # the shaft would turn back with it
            share = residual_of_extra_order(plan.law, plan.purity.count, plan.shaft, one.order, one.amplitude)
            left_out.append(LeftOut(one.order, one.amplitude, one.error, share))
    return tuple(one for one in left_out if one.share > _NOTHING)


def _contours(plan: Plan, work: Work, cams: Cams, angles: np.ndarray) -> dict[str, Contour]:
    """Return the contours by name, each a unit of work."""
    contours: dict[str, Contour] = {}
    for i, (name, cam) in enumerate(cams.items()):
        work.report(i / len(cams), f"{work.name.rstrip('/')} {CAM_LABELS[name]}")
        contours[name] = work.unit(name, partial(_contour, plan, name, cam, angles))
    return contours


def _contour(plan: Plan, name: str, cam: Cam, angles: np.ndarray) -> Contour:
    """Return a checked contour. Raises ``InputError`` where a corrected cam is cut away; the original one may be."""
    new = cam is plan.after[name]
    original, points, normals = _curve(plan.before[name]), cam.contour(angles), cam.normal(angles)
    shape = shapes({name: cam}, allow_undercut=not new)[name]
    return Contour(
        points=points,
        normals=normals,
        curvature=cam.material * cam.curvature(angles),
        pressure_angle=cam.pressure_angle(angles),
        uncut=cam.undercut(angles),
        displacement=_displacement(original, points, normals) if new else np.zeros(len(angles)),
        chord=chord_deviation(_curve(cam), angles),
        shape=shape,
    )


def _curve(cam: Cam) -> CamCurve:
    return lambda phi, order=0: cam.contour(np.asarray(phi), order)


def _displacement(curve: CamCurve, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the distance in m of points (N,) from a curve, positive outside."""
    far = curve_distances(curve, points)
    return np.where(curve_distances(curve, points - far * normals) <= far, far, -far)


def _folded_samples(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Return samples (S,) of the measured acceleration about its mean: tau within a turn, and the output's unit/s^2."""
    if (record := plan.measurement) is None:
        return np.zeros(0), np.zeros(0)
    channel = record.channel
    # At random: every n-th sample would always lie at the same phase of a turn if the shaft gave the clock.
    indices = np.random.default_rng(0).permutation(len(channel.time))[:_SAMPLES]
    speed = TURN * record.turns / float(np.ptp(channel.time))
    return np.mod(speed * (channel.time[indices] - plan.zero), TURN), channel.values[
        indices
    ] - record.comparison.measured_orders.mean


def _proof(plan: Plan, name: str, exact: np.ndarray) -> Proof:
    """Recover the motion from the points of a corrected cam, and from these rounded."""
    step, spectra, notes = 1e-3 * 10.0**-plan.spec.decimals, list[FourierSeries | None](), list[str]()
    for points in (exact, step * (np.round(exact.real / step) + 1j * np.round(exact.imag / step))):
        try:
            spectra.append(_recovered_acceleration(plan, plan.after[name], points))
        except WuchtError as error:
            spectra.append(None)
            notes.append(f"No motion could be recovered from {len(exact)} points of the contour ({name}): {error}; take more.")
    return Proof(spectra[0], spectra[1], tuple(notes))


def _recovered_acceleration(plan: Plan, cam: Cam, points: np.ndarray) -> FourierSeries:
    """Recover psi(t) from points by contact with the follower and the linkage: a computation independent of the law."""
    phi = plan.shaft.angle(even_angles(_RECOVERY_TIMES))
    expected_motion = plan.levers[1](phi)
    first_guess = expected_motion + _SEARCH_OFFSET * float(np.ptp(expected_motion)) * np.cos(phi)
    lever_motion = MilledCam(points, cam.follower, cam.clockwise).motion(phi, first_guess)
    output = lever_motion if plan.closure is None else plan.closure.output_at(lever_motion)
    # Twice differentiated, the rounding of orders far above the examined ones would dominate.
    acceleration = FourierSeries.from_samples(output).derivative(2)
    most = max(plan.shown_orders, 3 * (plan.purity.count or 0))
    return FourierSeries(0.0, acceleration.cosine[:most], acceleration.sine[:most])


def _notes(plan: Plan, before: Mapping[str, Contour], after: Mapping[str, Contour]) -> list[str]:
    notes = _pressure_angle_notes(plan, after)
    for name, contour in before.items():
        missing = sum(end - begin for begin, end in contour.shape.missing) / TURN
        if missing > 0:
            notes.append(
                f"The follower cuts {100 * missing:.1f} % of the original contour ({name}) away; the corrected one is intact."
            )
    worst = max((contour.chord for contour in after.values()), default=0.0)
    if worst > plan.spec.chord_tolerance:
        required_points = math.ceil(1.01 * plan.spec.points * math.sqrt(worst / plan.spec.chord_tolerance))
        notes.append(
            f"Chords between {plan.spec.points} points leave the contour by {1e6 * worst:.3g} um, more than the tolerance of "
            f"{1e6 * plan.spec.chord_tolerance:.3g} um: take points = {required_points}, or join them by a spline."
        )
    return notes


def _pressure_angle_notes(plan: Plan, after: Mapping[str, Contour]) -> list[str]:
    """Return the notes of a cam-contour on the pressure angle of the corrected cams."""
    if not after:
        return []
    hint = 'this key belongs to study.kind = "cam-contour", with study.corrected = true'
    notes = pressure_angle_remarks((contour.shape for contour in after.values()), plan.lever_unit)
    return [f"Corrected cam: {note}; {hint}" for note in notes]
