"""Findings -> the Dataset of a cam's contour."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.followers.follower import Outline
from wucht.cams.shape import COMMON, Shape, beyond_common, largest_pressure_angle
from wucht.numerics.valleys import Arc
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.cam_contour.contact_load import Pressed
from wucht.studies.cam_contour.judgement import judged
from wucht.studies.cam_contour.prepare import Plan
from wucht.studies.cam_contour.run import Curves, Findings

if TYPE_CHECKING:
    import xarray as xr

_MOTIONS = ("", "_velocity", "_acceleration")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a cam's contour. Lengths in m, in the plane that turns with the cam.

    Coordinates: cam (``cam``, with a counter cam ``counter``, of a groove ``outer``: its outer flank), cam_angle (N).
    contour_x, contour_y, pitch_x, pitch_y (of the roller's centre), normal_x, normal_y (away from the centre), curvature
    (positive where the material bulges), uncut (1: straight, 0: an edge, less: undercut), pressure_angle, contact_force,
    contact_pressure (cam, cam_angle). output, follower, each also _velocity and _acceleration (derivatives by the cam angle),
    transmission_angle, camshaft_torque (0 where nothing touches) (cam_angle). What does not apply is NaN. roller_radius,
    base_radius (cam).
    Arcs of the cam angle: arc_cam, arc_of (``undercut``, ``missing``, ``lift-off``), arc_begin, arc_end (arc).
    Points to mill, of all cams in a row: mill_cam (number of the cam), mill_angle, mill_x, mill_y, mill_normal_x, mill_normal_y
    (mill_point), the normals outwards of what the contour encloses.
    The drive as it is drawn at cam angle 0: pivot, rod_offset, face_from, face_to, face_at. Limits: permitted_pressure_angle,
    common_pressure_angle, permitted_radius, permitted_contact_pressure, wheel_radius.
    """
    import xarray as xr_

    coordinates = {
        "cam": variable("cam", list(plan.cams), "cam"),
        "cam_angle": variable("cam_angle", findings.angles, "cam angle", "rad"),
    }
    data = {
        **_over_turn(plan, findings),
        **_motions(plan, findings),
        **_arcs(plan, findings),
        **_to_mill(findings),
        **_layout(plan),
    }
    outcome, sentence = judged(plan, findings)
    summary = _summary(plan, findings, outcome, sentence)
    notes = [*findings.notes, *_beyond_common(plan)]
    return answered(xr_.Dataset(dict(data), coords=coordinates), summary, sentence, notes)


def _over_turn(plan: Plan, f: Findings) -> dict[str, Variable]:
    missing = np.full(len(f.angles), np.nan)

    def rows(of: Callable[[Curves], np.ndarray | None]) -> np.ndarray:
        return np.array([missing if (row := of(curves)) is None else row for curves in f.curves.values()])

    def contact(of: Callable[[Pressed], Any]) -> np.ndarray:
        return np.array([missing if f.pressed is None else of(f.pressed).get(name, missing) for name in plan.cams])

    def pitch(curves: Curves) -> np.ndarray:
        return missing + 0j if curves.pitch is None else curves.pitch

    along = "cam cam_angle"
    torque = missing if f.pressed is None else f.pressed.torque
    return {
        "contour_x": variable(along, rows(lambda c: c.contour.real), "contour, x", "m"),
        "contour_y": variable(along, rows(lambda c: c.contour.imag), "contour, y", "m"),
        "pitch_x": variable(along, rows(lambda c: pitch(c).real), "pitch curve, x", "m"),
        "pitch_y": variable(along, rows(lambda c: pitch(c).imag), "pitch curve, y", "m"),
        "normal_x": variable(along, rows(lambda c: c.normal.real), "normal, x"),
        "normal_y": variable(along, rows(lambda c: c.normal.imag), "normal, y"),
        "curvature": variable(along, rows(lambda c: c.curvature), "curvature of the contour", "1/m"),
        "uncut": variable(along, rows(lambda c: c.left), "what the roller leaves, 0: an edge"),
        "pressure_angle": variable(along, rows(lambda c: c.pressure_angle), "pressure angle", "rad"),
        "contact_force": variable(along, contact(lambda p: p.force), "contact force", "N"),
        "contact_pressure": variable(along, contact(lambda p: p.pressure), "contact pressure", "Pa"),
        "camshaft_torque": variable("cam_angle", torque, "torque of the camshaft", "N m"),
    }


def _motions(plan: Plan, f: Findings) -> dict[str, Variable]:
    data: dict[str, Variable] = {}
    for name, unit, motion in (("output", plan.drive.motion.unit, f.output), ("follower", plan.unit, f.lever)):
        for order, suffix in enumerate(_MOTIONS):
            of = f"{name}{suffix.replace('_', ', ')}"
            per = ("", "/rad", "/rad^2")[order]
            data[name + suffix] = variable("cam_angle", motion[order], of, unit + per)
    transmission = np.full(len(f.angles), np.nan) if f.transmission is None else f.transmission
    return data | {"transmission_angle": variable("cam_angle", transmission, "transmission angle", "rad")}


def _arcs(plan: Plan, f: Findings) -> dict[str, Variable]:
    arcs: list[tuple[str, str, Arc]] = []
    for name, shape in plan.shapes.items():
        arcs += [(name, "undercut", arc) for arc in shape.undercut] + [(name, "missing", arc) for arc in shape.missing]
        arcs += [(name, "lift-off", arc) for arc in (f.largest.off[name] if f.largest is not None else ())]
    return {
        "arc_cam": variable("arc", [name for name, _, _ in arcs], "cam of an arc"),
        "arc_of": variable("arc", [what for _, what, _ in arcs], "what happens on an arc"),
        "arc_begin": variable("arc", [arc[0] for _, _, arc in arcs], "begin of an arc", "rad"),
        "arc_end": variable("arc", [arc[1] for _, _, arc in arcs], "end of an arc", "rad"),
    }


def _to_mill(f: Findings) -> dict[str, Variable]:
    lists = list(f.to_mill.values())
    counts = [len(points.phi) for points in lists]
    phi = np.concatenate([np.zeros(0), *(points.phi for points in lists)])
    position = np.concatenate([np.zeros(0, complex), *(points.position for points in lists)])
    normal = np.concatenate([np.zeros(0, complex), *(points.normal for points in lists)])
    return {
        "mill_cam": variable("mill_point", np.repeat(np.arange(len(lists)), counts), "number of the cam, from 0"),
        "mill_angle": variable("mill_point", phi, "cam angle of a point to mill", "rad"),
        "mill_x": variable("mill_point", position.real, "point to mill, x", "m"),
        "mill_y": variable("mill_point", position.imag, "point to mill, y", "m"),
        "mill_normal_x": variable("mill_point", normal.real, "outward normal there, x"),
        "mill_normal_y": variable("mill_point", normal.imag, "outward normal there, y"),
    }


def _layout(plan: Plan) -> dict[str, Variable]:
    follower, permitted, spec = plan.drive.follower, plan.spec.permitted, plan.spec
    drawn = Outline() if follower is None else follower.outline(plan.lever)
    radii = [math.nan if cam.roller_radius is None else cam.roller_radius for cam in plan.cams.values()]
    limits = (permitted.pressure_angle, permitted.least_radius, permitted.contact_pressure) if permitted else (None,) * 3
    return {
        "roller_radius": variable("cam", radii, "radius of the roller", "m"),
        "base_radius": variable("cam", [shape.base.value for shape in plan.shapes.values()], "radius of the base circle", "m"),
        "pivot": variable("", drawn.pivot, "pivot of the lever, x", "m"),
        "rod_offset": variable("", drawn.rod_offset, "offset of the rod", "m"),
        "face_from": variable("", drawn.face_from, "least y at which the face is touched", "m"),
        "face_to": variable("", drawn.face_to, "greatest y at which the face is touched", "m"),
        "face_at": variable("", drawn.face_at, "face, x", "m"),
        "permitted_pressure_angle": variable("", limits[0], "permitted pressure angle", "rad"),
        "common_pressure_angle": variable("", COMMON[plan.unit], "common pressure angle, at most", "rad"),
        "permitted_radius": variable("", limits[1], "permitted radius of curvature", "m"),
        "permitted_contact_pressure": variable("", limits[2], "permitted contact pressure", "Pa"),
        "wheel_radius": variable("", spec.wheel_radius, "radius of the grinding wheel", "m"),
    }


def _summary(plan: Plan, f: Findings, outcome: str, sentence: str) -> dict[str, Any]:
    convex = [s.convex.radius for s in plan.shapes.values() if s.convex is not None]
    hollow = [s.hollow.radius for s in plan.shapes.values() if s.hollow is not None]
    follower = plan.drive.follower
    return {
        "sentence": sentence,
        "outcome": outcome,
        "follower": None if follower is None else follower.kind,
        "clockwise": follower is not None and follower.clockwise,
        "min_curvature_radius": min(convex, default=None),
        "min_hollow_radius": min(hollow, default=None),
        "max_pressure_angle": largest_pressure_angle(plan.shapes.values()).value,
        "undercut": not plan.whole,
        "base_radius": plan.shapes["cam"].base.value,
        "largest_radius": plan.shapes["cam"].blank.value,
        "cams": {name: _of_cam(shape, name, f) for name, shape in plan.shapes.items()},
        "min_transmission_angle": None if f.transmission is None else float(f.transmission.min()),
        "corrected": _shaft(plan),
        "chord_tolerance": plan.spec.chord_tolerance,
        "spacing": plan.spec.spacing,
        "decimals": plan.spec.decimals,
        "contact": _contact(plan, f.largest),
        "smallest": None if plan.smallest is None else plan.smallest.summary(),
    }


def _of_cam(shape: Shape, name: str, f: Findings) -> dict[str, Any]:
    at = {"convex": shape.convex, "hollow": shape.hollow, "wheel": shape.wheel}
    radii = {key: None if found is None else {"radius": found.radius, "at": found.phi} for key, found in at.items()}
    return {
        "min_curvature": radii["convex"],
        "min_hollow": radii["hollow"],
        "largest_wheel": radii["wheel"],
        "largest_roller": shape.largest_roller,
        "max_pressure_angle": {"angle": shape.pressure_angle.value, "at": shape.pressure_angle.phi},
        "base_radius": shape.base.value,
        "largest_radius": shape.blank.value,
        "undercut": [list(arc) for arc in shape.undercut],
        "missing": [list(arc) for arc in shape.missing],
        "points_to_mill": len(f.to_mill[name].phi) if name in f.to_mill else 0,
    }


def _contact(plan: Plan, largest: Pressed | None) -> dict[str, Any] | None:
    if largest is None or plan.contact is None:
        return None

    def peak(values: np.ndarray) -> dict[str, float]:
        k = int(np.argmax(values))
        return {"value": float(values[k]), "at": float(largest.phi[k])}

    return {
        "mean_speed": plan.contact.mean_speed,
        "max_force": {name: peak(force) for name, force in largest.force.items()},
        "max_pressure": {name: peak(pressure) for name, pressure in largest.pressure.items()} or None,
        "max_torque": peak(np.abs(largest.torque)),
        "lift_off": {name: [list(arc) for arc in arcs] for name, arcs in largest.off.items()},
        "least_preload": largest.least_preload,
    }


def _beyond_common(plan: Plan) -> list[str]:
    """Where nobody has permitted a pressure angle."""
    permitted = plan.spec.permitted
    given = permitted is not None and permitted.pressure_angle is not None
    return [] if given else beyond_common(plan.shapes.values(), plan.unit)


def _shaft(plan: Plan) -> dict[str, Any] | None:
    """The speed of the shaft in rad/s for which the cam was corrected."""
    if not plan.spec.corrected:
        return None
    speed = plan.drive.turning_with_corrected_cam.speed
    return {"mean": speed.mean, "cosine": speed.cosine.tolist(), "sine": speed.sine.tolist()}
