"""Plan -> findings: the motion over time, cam tables, contours, what is left where something is otherwise, and the proof."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import FlatFacedCam, RollerCam
from wucht.cams.correction import MotionOverTime, Residual, orders, residuals
from wucht.cams.laws.law import Law
from wucht.cams.milled import MilledCam
from wucht.cams.undercut import cut_away
from wucht.cams.workshop.closed_curve import ClosedCurve, distances
from wucht.cams.workshop.points import chord_deviation
from wucht.errors import WuchtError
from wucht.numerics.harmonics import Harmonics, even_angles
from wucht.numerics.valleys import GRID, valleys
from wucht.studies.cam_correction.prepare import Plan, left_by_errors
from wucht.studies.work import Work

TIMES = 721  # at which the motion over time is given, the first again at the end
_RECOVERED = 1024  # times at which the follower on the milled points is looked for
_OFF = 2e-3  # of the stroke: it is looked for beside where it should be
_FASTER = 1.1  # times the mean speed, with the same fluctuation in rad/s


@dataclass(frozen=True, eq=False)
class Contour:
    """Of a cam at the cam angles (N,): points and normals (away from the centre) complex in m, curvature in 1/m, pressure angle
    in rad, uncut: 0 at an edge. chord: by how much in m chords between the points leave the contour. moved: how far the points
    are from the original contour. convex, hollow: the least radii of curvature in m, largest_roller in m; missing: the share of
    the turn that is cut away. What there is not is NaN.
    """

    points: np.ndarray
    normals: np.ndarray
    curvature: np.ndarray
    pressure_angle: np.ndarray
    uncut: np.ndarray
    chord: float
    moved: float
    convex: float
    hollow: float
    largest_roller: float
    missing: float


@dataclass(frozen=True, eq=False)
class Findings:
    """Each pair is of the original and of the corrected cam.

    tau (T,): time as an angle. output, acceleration: over tau, the latter in the output's unit/s^2. spectrum: of the latter,
    over omega^2, impurity: its share above N. table, lever: derivatives 0 to 3 (4, N) by the cam angle of output and follower.
    contours: by the name of the cam. recovered, rounded: the acceleration over omega^2 of the corrected cam from its points,
    and from these rounded, by the name of the cam. from_errors: what the standard errors of the record leave.
    """

    tau: np.ndarray
    output: tuple[np.ndarray, np.ndarray]
    acceleration: tuple[np.ndarray, np.ndarray]
    spectrum: tuple[Harmonics, Harmonics]
    impurity: tuple[float, float]
    angles: np.ndarray
    table: tuple[np.ndarray, np.ndarray]
    lever: tuple[np.ndarray, np.ndarray]
    contours: tuple[Mapping[str, Contour], Mapping[str, Contour]]
    recovered: Mapping[str, Harmonics]
    rounded: Mapping[str, Harmonics]
    residuals: tuple[Residual, ...]
    from_errors: float | None
    notes: tuple[str, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """All at once: it takes a second or two."""
    work.report(0.0, "motion over time")
    laws = (plan.law, plan.corrected)
    over_time = [MotionOverTime(law, plan.shaft) for law in laws]
    found = [orders(motion) for motion in over_time]
    tau, angles = np.linspace(0, 2 * np.pi, TIMES), even_angles(plan.spec.points)
    scale = plan.shaft.mean**2
    left, shares = _left(plan)
    work.report(0.3, "contours")
    contours = tuple(
        {name: _contour(plan, name, cam, angles) for name, cam in cams.items()} for cams in (plan.before, plan.after)
    )
    work.report(0.7, "motion from the points")
    recovered, rounded, notes = _from_points(plan, angles, {n: c.points for n, c in contours[1].items()})
    yield Findings(
        tau=tau,
        output=(over_time[0](tau), over_time[1](tau)),
        acceleration=(scale * over_time[0](tau, 2), scale * over_time[1](tau, 2)),
        spectrum=(found[0], found[1]),
        impurity=(plan.purity.share(found[0]), plan.purity.share(found[1])),
        angles=angles,
        table=(_derivatives(plan.law, angles), _derivatives(plan.corrected, angles)),
        lever=(_derivatives(plan.levers[0], angles), _derivatives(plan.levers[1], angles)),
        contours=(contours[0], contours[1]),
        recovered=recovered,
        rounded=rounded,
        residuals=left,
        from_errors=left_by_errors(plan, shares),
        notes=(*plan.notes, *notes, *_notes(plan, contours[0], contours[1])),
    )


def _derivatives(law: Law, angles: np.ndarray) -> np.ndarray:
    return np.array([law(angles, order) for order in range(4)])


def _left(plan: Plan) -> tuple[tuple[Residual, ...], dict[int, float]]:
    """What is left where something is not as the cam was made for, and of this what each order of the speed left out leaves."""
    found = residuals(plan.law, plan.purity.count, plan.shaft)
    faster = orders(MotionOverTime(plan.corrected, plan.shaft.scaled(1 / _FASTER)))
    what = f"a mean speed {_FASTER - 1:.0%} higher, the fluctuation the same in rad/s"
    kept = tuple(r for r in found if r.what != "as measured")
    shares = {int(r.what.split()[1]): r.share for r in kept if r.what.startswith("order ")}
    return (*kept, Residual(what, plan.purity.share(faster))), shares


def _contour(plan: Plan, name: str, cam: RollerCam | FlatFacedCam, angles: np.ndarray) -> Contour:
    if isinstance(cam, FlatFacedCam):
        _, radii = valleys(cam.radius)
        convex, hollow, largest, missing = float(radii.min()), math.nan, math.nan, float(np.mean(cam.radius(GRID) <= 0))
    else:
        cut = plan.cut[name] if cam is plan.after[name] else cut_away(cam)
        convex, hollow = (math.nan if at is None else at.radius for at in (cut.convex, cut.hollow))
        largest, missing = cut.largest_roller, sum(end - begin for begin, end in cut.missing) / (2 * math.pi)
    curve, points = _curve(cam), cam.contour(angles)
    return Contour(
        points=points,
        normals=cam.normal(angles),
        curvature=cam.curvature(angles),
        pressure_angle=cam.pressure_angle(angles),
        uncut=cam.undercut(angles),
        chord=chord_deviation(curve, angles),
        moved=float(distances(_curve(plan.before[name]), points).max()),
        convex=convex,
        hollow=hollow,
        largest_roller=largest,
        missing=missing,
    )


def _curve(cam: RollerCam | FlatFacedCam) -> ClosedCurve:
    return lambda phi, order=0: cam.contour(np.asarray(phi), order)


def _from_points(
    plan: Plan, angles: np.ndarray, points: Mapping[str, np.ndarray]
) -> tuple[dict[str, Harmonics], dict[str, Harmonics], list[str]]:
    """The acceleration of the output from the points of each corrected cam, and from these rounded."""
    found: tuple[dict[str, Harmonics], dict[str, Harmonics]] = ({}, {})
    notes: list[str] = []
    step = 1e-3 * 10.0**-plan.spec.decimals
    for name, exact in points.items():
        milled = (exact, step * (np.round(exact.real / step) + 1j * np.round(exact.imag / step)))
        for by_name, contour in zip(found, milled, strict=True):
            try:
                by_name[name] = _recovered(plan, plan.after[name], contour)
            except WuchtError as error:
                notes.append(f"No motion could be found from {len(angles)} points of the contour ({name}): {error}; take more.")
    return *found, notes


def _recovered(plan: Plan, cam: RollerCam | FlatFacedCam, points: np.ndarray) -> Harmonics:
    """Points -> contact with the follower -> linkage -> psi(t): a way that knows nothing of the law."""
    phi = plan.shaft.angle(even_angles(_RECOVERED))
    nearly = plan.levers[1](phi)
    beside = nearly + _OFF * float(np.ptp(nearly)) * np.cos(phi)
    moved = MilledCam(points, cam.follower, cam.clockwise).motion(phi, beside)
    output = moved if plan.closure is None else plan.closure.output_at(moved)
    # Twice differentiated, the rounding of orders far above those that are looked at would be all that is seen.
    acceleration, most = Harmonics.sampled(output).derivative(2), max(plan.orders, 3 * (plan.purity.count or 0))
    return Harmonics(0.0, acceleration.cosine[:most], acceleration.sine[:most])


def _notes(plan: Plan, before: Mapping[str, Contour], after: Mapping[str, Contour]) -> list[str]:
    notes = [
        f"The follower cuts {contour.missing:.1%} of the original contour ({name}) away; the corrected one is whole."
        for name, contour in before.items()
        if contour.missing > 0
    ]
    worst = max((contour.chord for contour in after.values()), default=0.0)
    if worst > plan.spec.chord_tolerance:
        needed = math.ceil(1.01 * plan.spec.points * math.sqrt(worst / plan.spec.chord_tolerance))
        notes.append(
            f"Chords between {plan.spec.points} points leave the contour by {1e6 * worst:.3g} um, more than the tolerance of "
            f"{1e6 * plan.spec.chord_tolerance:.3g} um: take points = {needed}, or leave the curve between them to a spline."
        )
    return notes
