"""Spec and cam drive -> plan -> findings: cams, their contours, and if they can be cut within the permitted limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.correction import CorrectedLaw
from wucht.cams.demands import format_millimetres
from wucht.cams.drive import CamDrive
from wucht.cams.followers.follower import Follower
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import CAM_LABELS, Shape, format_cam_angle, largest_pressure_angle, shapes
from wucht.cams.sizing.size_limits import CamLimits, Size, SizedCam
from wucht.cams.workshop.cam_files import WorkshopCurve
from wucht.cams.workshop.points import PointList, chord_points, rounding_warning
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.angles import Arc
from wucht.studies.cam_contour.contact_load import (
    ContactHistory,
    ContactLoad,
    contact_history,
    contact_load,
    dense_contact_history,
)
from wucht.studies.cam_contour.spec import CamContour

_LIMIT_TOLERANCE = 1e-6  # of a limit: a smallest cam lies at its limit up to rounding, which is no violation
_MOST_ARCS = 3


@dataclass(frozen=True, eq=False)
class Plan:
    """Cams of a study, checked.

    output: its law over the cam angle. lever: that of the follower. shaft: motion of the shaft, None where no table states it,
    or, without a correction, where it is to be predicted. shapes: sizes and undercut of each cam. notes: warnings for the
    result."""

    spec: CamContour
    drive: CamDrive
    output: Law
    lever: Law
    cams: Mapping[str, Cam]
    shapes: Mapping[str, Shape]
    contact: ContactLoad | None
    smallest: SizedCam | None
    notes: tuple[str, ...] = ()
    shaft: ShaftMotion | None = None

    @property
    def unit(self) -> str:
        """Unit of the follower's motion: rad or m."""
        return self.drive.follower.unit if self.drive.follower is not None else "rad"

    @property
    def is_whole(self) -> bool:
        """True if no part of any contour is cut away."""
        return not any(shape.missing or shape.undercut for shape in self.shapes.values())


def prepare(spec: CamContour, drive: CamDrive) -> Plan:
    """Return the plan. Raises ``InputError`` where there is no such cam: which key, and what to do."""
    law, shaft = drive.motion_law.function, _shaft_motion(spec, drive)
    if spec.corrected and shaft is not None:
        law = CorrectedLaw(law, shaft)
    notes = _correction_notes(spec, shaft)
    cams = drive.make_cams(law)
    lever, follower = drive.follower_law(law), drive.follower
    unit = follower.unit if follower is not None else "rad"
    contact = contact_load(spec, drive, unit)
    if contact is not None and drive.linkage is not None and not contact.load.output_inertia:
        key = "output_inertia" if drive.motion_law.unit == "rad" else "output_mass"
        notes.append(f"contact forces are those of the lever alone: study.contact.{key} adds what the linkage moves")
    try:
        smallest = smallest_cam(lever, follower, spec.permitted, spec.smallest)
        notes += obstacles(drive, law, smallest) if smallest is not None else []
    except RunError as error:
        smallest = None
        notes.append(f"no smallest cam: {error}")
    return Plan(spec, drive, law, lever, cams, _shapes(cams, spec), contact, smallest, tuple(notes), shaft)


def _shaft_motion(spec: CamContour, drive: CamDrive) -> ShaftMotion | None:
    if spec.corrected:
        return drive.corrected_shaft_motion
    return None if drive.speed is None else drive.shaft_motion


def _correction_notes(spec: CamContour, shaft: ShaftMotion | None) -> list[str]:
    """Return a note where the speed fluctuates and the study does not say whether the cam is corrected for it."""
    if shaft is None or "corrected" in spec.model_fields_set or not shaft.fluctuation > 0:
        return []
    return [
        f"this is the original cam, for a shaft that turns evenly, but the speed of [speed] fluctuates by "
        f"{100 * shaft.fluctuation:.4g} %: study.corrected = true makes the cam that is corrected for this speed, "
        "study.corrected = false keeps the original one"
    ]


def _shapes(cams: Mapping[str, Cam], spec: CamContour) -> dict[str, Shape]:
    try:
        return shapes(cams, allow_undercut=spec.allow_undercut, wheel_radius=spec.wheel_radius)
    except InputError as error:
        raise error.with_prefix("study") if error.location == "wheel_radius" else error from None


def smallest_cam(law: Law, follower: Follower | None, constraints: CamLimits | None, size: Size) -> SizedCam | None:
    """Return the smallest cam for the follower's law; None where no limit is given that determines it.

    Without a permitted least radius no undercut is allowed; without a shaft radius the base circle must not be negative.
    Raises ``InputError`` (study.permitted...), ``RunError``.
    """
    if constraints is None or follower is None:
        return None
    try:
        return follower.smallest_cam(law, constraints, size)
    except InputError as error:
        raise error.with_prefix("study.permitted") if error.location in CamLimits.model_fields else error from None


def obstacles(drive: CamDrive, output: Law, smallest: SizedCam) -> list[str]:
    """Return obstacles to making the smallest cam, in sentences. output: the law that it is to make."""
    if drive.follower is None:
        return []
    follower, anew = drive.follower.with_placement(smallest.placement)
    notes, smallest_drive = list(anew), replace(drive, follower=follower)
    try:
        for cam in smallest_drive.make_cams(output).values():
            if not smallest.whole:
                cam.check(format_millimetres)
    except InputError as error:
        notes.append(f"the smallest permitted cam cannot be made: {error.explanation}")
    return notes


@dataclass(frozen=True, eq=False)
class Curves:
    """Curves of a cam over cam angles (N,): contour, pitch (None for a flat face), normal: complex, in m; curvature in 1/m,
    positive where the contour is convex; uncut: margin against undercut, see ``Cam.undercut``; pressure_angle in rad."""

    contour: np.ndarray
    pitch: np.ndarray | None
    normal: np.ndarray
    curvature: np.ndarray
    uncut: np.ndarray
    pressure_angle: np.ndarray


@dataclass(frozen=True, eq=False)
class Findings:
    """Contours, points to mill and contact forces.

    angles (N,) in rad. output, lever (3, N): the motions and their first two derivatives by the cam angle. transmission (N,):
    angle of the linkage in rad, or None. points_to_mill: of each cam, none where some of the contour is cut away.
    contact_history: over the angles; dense_history: at denser angles, for the largest values. notes: warnings."""

    angles: np.ndarray
    output: np.ndarray
    lever: np.ndarray
    transmission: np.ndarray | None
    curves: Mapping[str, Curves]
    points_to_mill: Mapping[str, PointList]
    contact_history: ContactHistory | None
    dense_history: ContactHistory | None
    notes: tuple[str, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the findings once: the whole computation takes a second."""
    work.report(0.0, "contours")
    angles = np.linspace(0, 2 * np.pi, plan.spec.points + 1)
    curves = {name: _curves(cam, angles) for name, cam in plan.cams.items()}
    work.report(0.3, "points to mill")
    mill_points, notes = _points_to_mill(plan)
    work.report(0.8, "contact")
    history = dense_history = None
    if plan.contact is not None and plan.is_whole:
        history, dense_history = (
            contact_history(plan.contact, plan.cams, angles),
            dense_contact_history(plan.contact, plan.cams),
        )
    elif plan.contact is not None:
        notes.append("no contact forces: part of the contour is cut away, so that the follower does not move by its law")
    closure = plan.drive.closure
    transmission = None if closure is None else closure.transmission_angle(plan.lever(angles))
    output, lever = _derivatives(plan.output, angles), _derivatives(plan.lever, angles)
    yield Findings(angles, output, lever, transmission, curves, mill_points, history, dense_history, (*plan.notes, *notes))


def _derivatives(law: Law, angles: np.ndarray) -> np.ndarray:
    return np.array([law(angles, order) for order in range(3)])


def _curves(cam: Cam, angles: np.ndarray) -> Curves:
    pitch = None if cam.pitch_curve is None else cam.pitch_curve(angles, 0)
    curvature = cam.material * cam.curvature(angles)
    return Curves(cam.contour(angles), pitch, cam.normal(angles), curvature, cam.undercut(angles), cam.pressure_angle(angles))


def _points_to_mill(plan: Plan) -> tuple[dict[str, PointList], list[str]]:
    """Return the points of each cam, and warnings about their rounding. Raises ``InputError`` (study.chord_tolerance)."""
    if not plan.is_whole:
        return {}, ["no points to mill: part of the contour is cut away"]
    spec, points, notes = plan.spec, dict[str, PointList](), list[str]()
    for name, cam in plan.cams.items():
        contour = WorkshopCurve(cam.contour)
        try:
            points[name] = chord_points(contour, spec.chord_tolerance, spec.spacing)
        except InputError as error:
            key = f"study.{'chord_tolerance' if error.location == 'tolerance' else error.location}"
            raise InputError(key, error.value, error.explanation) from None
        coarse = rounding_warning(contour, points[name], 1e-3 * 10.0**-spec.decimals)
        notes += [f"{name}: {coarse}"] if coarse else []
    return points, notes


def contour_verdict(plan: Plan, findings: Findings) -> tuple[str, str]:
    """Return the label (``cuttable``, ``undercut``, ``not-permitted``, ``lifts-off``) and the sentence."""
    if not plan.is_whole:
        return "undercut", f"undercut: {'; '.join(_undercut_clauses(plan))}"
    violations, lift_offs = list(_violation_clauses(plan, findings)), list(_lift_off_clauses(plan, findings))
    if violations:
        return "not-permitted", "; ".join([f"cuttable, but outside the permitted limits: {', '.join(violations)}", *lift_offs])
    clauses = [f"cuttable: {_radius(plan)}"]
    if any(s.pressure_angle.value > 0 for s in plan.shapes.values()):
        angle = largest_pressure_angle(plan.shapes.values())
        clauses[0] += f", pressure angle at most {format_cam_angle(angle.value)} at {format_cam_angle(angle.phi)}"
    return ("lifts-off" if lift_offs else "cuttable"), "; ".join([*clauses, *lift_offs])


def _radius(plan: Plan) -> str:
    convex = [s.convex for s in plan.shapes.values() if s.convex is not None]
    if not convex:
        return "the contour is nowhere convex"
    least = min(convex, key=lambda radius: radius.radius)
    return f"least convex radius {_millimetres(least.radius)} at {format_cam_angle(least.phi)}"


def _undercut_clauses(plan: Plan) -> Iterator[str]:
    for name, shape in plan.shapes.items():
        if shape.missing or shape.undercut:
            yield f"the {shape.part} cuts the {CAM_LABELS[name]} away {_arcs_text(shape.missing or shape.undercut)}"


def _violation_clauses(plan: Plan, findings: Findings) -> Iterator[str]:
    constraints = plan.spec.permitted
    if constraints is None:
        return
    angle = largest_pressure_angle(plan.shapes.values())
    if constraints.pressure_angle is not None and angle.value > constraints.pressure_angle * (1 + _LIMIT_TOLERANCE):
        angle_clause = f"pressure angle {format_cam_angle(angle.value)} at {format_cam_angle(angle.phi)}"
        yield f"{angle_clause} (permitted {format_cam_angle(constraints.pressure_angle)})"
    convex = [s.convex.radius for s in plan.shapes.values() if s.convex is not None]
    if constraints.least_radius is not None and convex and min(convex) < constraints.least_radius * (1 - _LIMIT_TOLERANCE):
        yield f"least radius {_millimetres(min(convex))} (permitted {_millimetres(constraints.least_radius)})"
    base = min(shape.base.value for shape in plan.shapes.values())
    if constraints.shaft_radius is not None and base < constraints.shaft_radius * (1 - _LIMIT_TOLERANCE):
        yield f"base circle {_millimetres(base)} (permitted {_millimetres(constraints.shaft_radius)}, that of the shaft)"
    if constraints.contact_pressure is not None and findings.dense_history is not None:
        largest = max(float(pressure.max()) for pressure in findings.dense_history.pressure.values())
        if largest > constraints.contact_pressure:
            yield f"contact pressure {largest / 1e6:.4g} MPa (permitted {constraints.contact_pressure / 1e6:.4g} MPa)"


def _lift_off_clauses(plan: Plan, findings: Findings) -> Iterator[str]:
    """Yield where a roller lifts off its cam; in a groove it passes to the opposite flank."""
    if findings.dense_history is None or "outer" in plan.cams:
        return
    for name, arcs in findings.dense_history.lift_off.items():
        if arcs:
            owner = "" if len(plan.cams) == 1 else f" of the {CAM_LABELS[name]}"
            unit = "N m" if plan.unit == "rad" else "N"
            part = plan.shapes[name].part
            yield (
                f"the {part}{owner} lifts off {_arcs_text(arcs)} (a preload of "
                f"{findings.dense_history.least_preload:.4g} {unit} holds it)"
            )


def _arcs_text(arcs: tuple[Arc, ...]) -> str:
    intervals = " and ".join(f"from {format_cam_angle(begin)} to {format_cam_angle(end)}" for begin, end in arcs[:_MOST_ARCS])
    return intervals + (f" and on {len(arcs) - _MOST_ARCS} more arcs" if len(arcs) > _MOST_ARCS else "")


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
