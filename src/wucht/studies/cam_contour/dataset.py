"""Findings -> the quantities of a cam's contour, and its lines in a report."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.followers.follower import Outline
from wucht.cams.shape import COMMON, Shape, largest_pressure_angle, pressure_angle_remarks
from wucht.cams.undercut import RadiusAt
from wucht.cams.workshop.heading import cam_version
from wucht.numerics.angles import Arc
from wucht.results.formatting import report_lines
from wucht.results.quantities import Quantity, group, result_dataset
from wucht.studies.cam_contour.computation import Curves, Findings, Plan, contour_verdict
from wucht.studies.cam_contour.contact_load import ContactHistory

if TYPE_CHECKING:
    import xarray as xr


_MOTIONS = ("", "_velocity", "_acceleration")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a cam's contour, in the plane that turns with the cam; numbers that do not apply are NaN."""
    outcome, sentence = contour_verdict(plan, findings)
    if version := cam_version(plan.shaft, plan.spec.corrected):
        sentence += f"; {version} cam"
    quantities = [
        Quantity("cam", list(plan.cams), "cam", "", "cam"),
        Quantity("cam_angle", findings.angles, "cam angle", "rad", "cam_angle"),
        *_curve_quantities(plan, findings),
        *_motion_quantities(plan, findings),
        *_arc_quantities(plan, findings),
        *_mill_quantities(findings),
        *_layout_quantities(plan),
        *_summary_quantities(plan, findings, outcome),
    ]
    return result_dataset(quantities, sentence, [*findings.notes, *_pressure_angle_notes(plan)])


def _curve_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    missing = np.full(len(f.angles), np.nan)

    def rows(of: Callable[[Curves], np.ndarray | None]) -> np.ndarray:
        return np.array([missing if (row := of(curves)) is None else row for curves in f.curves.values()])

    def contact(of: Callable[[ContactHistory], Any]) -> np.ndarray:
        return np.array(
            [missing if f.contact_history is None else of(f.contact_history).get(name, missing) for name in plan.cams]
        )

    def pitch(curves: Curves) -> np.ndarray:
        return missing + 0j if curves.pitch is None else curves.pitch

    dimensions = "cam cam_angle"
    torque = missing if f.contact_history is None else f.contact_history.torque
    return [
        Quantity("contour_x", rows(lambda c: c.contour.real), "contour, x", "m", dimensions),
        Quantity("contour_y", rows(lambda c: c.contour.imag), "contour, y", "m", dimensions),
        Quantity("pitch_x", rows(lambda c: pitch(c).real), "pitch curve, x", "m", dimensions),
        Quantity("pitch_y", rows(lambda c: pitch(c).imag), "pitch curve, y", "m", dimensions),
        Quantity("normal_x", rows(lambda c: c.normal.real), "normal, x", "", dimensions),
        Quantity("normal_y", rows(lambda c: c.normal.imag), "normal, y", "", dimensions),
        Quantity("curvature", rows(lambda c: c.curvature), "curvature of the contour", "1/m", dimensions),
        Quantity("uncut", rows(lambda c: c.uncut), "margin against undercut, 0 at an edge", "", dimensions),
        Quantity("pressure_angle", rows(lambda c: c.pressure_angle), "pressure angle", "rad", dimensions),
        Quantity("contact_force", contact(lambda p: p.force), "contact force", "N", dimensions),
        Quantity("contact_pressure", contact(lambda p: p.pressure), "contact pressure", "Pa", dimensions),
        Quantity("camshaft_torque", torque, "torque of the camshaft", "N m", "cam_angle"),
    ]


def _motion_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    quantities = []
    for name, unit, motion in (("output", plan.drive.motion_law.unit, f.output), ("follower", plan.unit, f.lever)):
        for suffix, per, values in zip(_MOTIONS, ("", "/rad", "/rad^2"), motion, strict=True):
            quantities.append(Quantity(name + suffix, values, f"{name}{suffix.replace('_', ', ')}", unit + per, "cam_angle"))
    transmission = np.full(len(f.angles), np.nan) if f.transmission is None else f.transmission
    return [*quantities, Quantity("transmission_angle", transmission, "transmission angle", "rad", "cam_angle")]


def _arc_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    arcs: list[tuple[str, str, Arc]] = []
    for name, shape in plan.shapes.items():
        arcs += [(name, "undercut", arc) for arc in shape.undercut] + [(name, "missing", arc) for arc in shape.missing]
        arcs += [(name, "lift-off", arc) for arc in (f.dense_history.lift_off[name] if f.dense_history is not None else ())]
    return [
        Quantity("arc_cam", [name for name, _, _ in arcs], "cam of an arc", "", "arc"),
        Quantity("arc_of", [event for _, event, _ in arcs], "kind of an arc: undercut, missing or lift-off", "", "arc"),
        Quantity("arc_begin", [arc[0] for _, _, arc in arcs], "start of an arc", "rad", "arc"),
        Quantity("arc_end", [arc[1] for _, _, arc in arcs], "end of an arc", "rad", "arc"),
    ]


def _mill_quantities(f: Findings) -> list[Quantity]:
    lists = list(f.points_to_mill.values())
    counts = [len(points.phi) for points in lists]
    phi = np.concatenate([np.zeros(0), *(points.phi for points in lists)])
    position = np.concatenate([np.zeros(0, complex), *(points.position for points in lists)])
    normal = np.concatenate([np.zeros(0, complex), *(points.normal for points in lists)])
    return [
        Quantity("mill_cam", np.repeat(np.arange(len(lists)), counts), "number of the cam, from 0", "", "mill_point"),
        Quantity("mill_angle", phi, "cam angle of a point to mill", "rad", "mill_point"),
        Quantity("mill_x", position.real, "point to mill, x", "m", "mill_point"),
        Quantity("mill_y", position.imag, "point to mill, y", "m", "mill_point"),
        Quantity("mill_normal_x", normal.real, "outward normal there, x", "", "mill_point"),
        Quantity("mill_normal_y", normal.imag, "outward normal there, y", "", "mill_point"),
    ]


def _layout_quantities(plan: Plan) -> list[Quantity]:
    follower, constraints, spec = plan.drive.follower, plan.spec.permitted, plan.spec
    outline = Outline() if follower is None else follower.outline(plan.lever)
    radii = [math.nan if cam.roller_radius is None else cam.roller_radius for cam in plan.cams.values()]
    limits = (
        (constraints.pressure_angle, constraints.least_radius, constraints.contact_pressure) if constraints else (None,) * 3
    )
    return [
        Quantity("roller_radius", radii, "radius of the roller", "m", "cam"),
        Quantity("base_radius", [shape.base.value for shape in plan.shapes.values()], "radius of the base circle", "m", "cam"),
        Quantity("pivot", outline.pivot, "pivot of the lever, x", "m", ""),
        Quantity("rod_offset", outline.rod_offset, "offset of the rod", "m", ""),
        Quantity("face_from", outline.face_from, "least y at which the face is touched", "m", ""),
        Quantity("face_to", outline.face_to, "greatest y at which the face is touched", "m", ""),
        Quantity("face_at", outline.face_at, "face, x", "m", ""),
        Quantity("permitted_pressure_angle", limits[0], "permitted pressure angle", "rad", ""),
        Quantity("common_pressure_angle", COMMON[plan.unit], "usual upper limit of the pressure angle", "rad", ""),
        Quantity("permitted_radius", limits[1], "permitted radius of curvature", "m", ""),
        Quantity("permitted_contact_pressure", limits[2], "permitted contact pressure", "Pa", ""),
        Quantity("wheel_radius", spec.wheel_radius, "radius of the grinding wheel", "m", ""),
    ]


def _summary_quantities(plan: Plan, f: Findings, outcome: str) -> list[Quantity]:
    convex = [s.convex.radius for s in plan.shapes.values() if s.convex is not None]
    hollow = [s.hollow.radius for s in plan.shapes.values() if s.hollow is not None]
    follower, cam, spec, speed = plan.drive.follower, plan.shapes["cam"], plan.spec, _speed_table(plan)
    transmission = None if f.transmission is None else float(f.transmission.min())
    smallest, pressure_angle = plan.smallest and plan.smallest.summary(), largest_pressure_angle(plan.shapes.values()).value
    return [
        Quantity("outcome", outcome, "outcome"),
        Quantity("follower", follower and follower.kind, "kind of follower"),
        Quantity("clockwise", follower is not None and follower.clockwise, "true if the cam turns clockwise"),
        Quantity("min_curvature_radius", min(convex, default=None), "least convex radius of curvature", "m", headline=True),
        Quantity("min_hollow_radius", min(hollow, default=None), "least hollow radius of curvature", "m"),
        Quantity("max_pressure_angle", pressure_angle, "largest pressure angle", "rad", headline=True),
        Quantity("undercut", not plan.is_whole, "true if the follower cuts off parts of the contour"),
        Quantity("base_radius", cam.base.value, "radius of the base circle", "m", headline=True),
        Quantity("largest_radius", cam.blank.value, "largest radius of the contour", "m", headline=True),
        group("cams", [_cam_group(shape, name, f) for name, shape in plan.shapes.items()], "each cam"),
        Quantity("min_transmission_angle", transmission, "least transmission angle of the linkage", "rad"),
        Quantity("corrected", speed if spec.corrected else None, "speed of the shaft for which the cam is corrected", "rad/s"),
        Quantity("cam_version", cam_version(plan.shaft, spec.corrected) or None, "original or corrected cam"),
        Quantity("speed", speed, "speed of the shaft, of the table [speed] or as predicted for a corrected cam", "rad/s"),
        Quantity("fluctuation", plan.shaft and plan.shaft.fluctuation, "fluctuation of this speed, as a share of its mean"),
        Quantity("chord_tolerance", spec.chord_tolerance, "largest distance of chords between points to mill", "m"),
        Quantity("spacing", spec.spacing, "distance of points to mill", "m"),
        Quantity("decimals", spec.decimals, "decimals of the points to mill"),
        _contact_group(plan, f.dense_history),
        Quantity("smallest", smallest, "smallest cam within the permitted limits", parts=_SMALLEST_PARTS),
    ]


_AT = {"at": ("cam angle", "rad")}
_SMALLEST_PARTS = {
    "follower": ("position of the follower", "m"),
    "angle": ("angle of the lever", "rad"),
    "base_radius": ("radius of the base circle", "m"),
    "largest_radius": ("largest radius of the contour", "m"),
    "min_curvature_radius": ("least convex radius of curvature", "m"),
    "max_pressure_angle": ("largest pressure angle", "rad"),
    "face": ("least and greatest y at which the face is touched", "m"),
}


def _cam_group(shape: Shape, name: str, f: Findings) -> Quantity:
    def radius(key: str, at: RadiusAt | None, description: str) -> Quantity:
        value = None if at is None else {"radius": at.radius, "at": at.phi}
        return Quantity(key, value, description, parts={"radius": ("radius", "m")} | _AT)

    angle = {"angle": shape.pressure_angle.value, "at": shape.pressure_angle.phi}
    undercut, missing = ([list(arc) for arc in arcs] for arcs in (shape.undercut, shape.missing))
    count = len(f.points_to_mill[name].phi) if name in f.points_to_mill else 0
    numbers = [
        radius("min_curvature", shape.convex, "least convex radius of curvature"),
        radius("min_hollow", shape.hollow, "least hollow radius of curvature"),
        radius("largest_wheel", shape.wheel, "largest grinding wheel"),
        Quantity("largest_roller", shape.largest_roller, "largest roller without undercut", "m"),
        Quantity("max_pressure_angle", angle, "largest pressure angle", parts={"angle": ("angle", "rad")} | _AT),
        Quantity("base_radius", shape.base.value, "radius of the base circle", "m"),
        Quantity("largest_radius", shape.blank.value, "largest radius of the contour", "m"),
        Quantity("undercut", undercut, "arcs cut off by the follower", "rad"),
        Quantity("missing", missing, "arcs without a contour", "rad"),
        Quantity("points_to_mill", count, "number of points to mill"),
    ]
    return group(name, numbers, _CAM_NAMES[name])


def _contact_group(plan: Plan, history: ContactHistory | None) -> Quantity:
    description = "largest values of the contact"
    if history is None or plan.contact is None:
        return Quantity("contact", None, description)

    def peak(values: np.ndarray) -> dict[str, float]:
        k = int(np.argmax(values))
        return {"value": float(values[k]), "at": float(history.phi[k])}

    forces, pressures = ({name: peak(one) for name, one in of.items()} for of in (history.force, history.pressure))
    torque, lift_off = (
        peak(np.abs(history.torque)),
        {name: [list(arc) for arc in arcs] for name, arcs in history.lift_off.items()},
    )
    preload_unit = "N m" if plan.unit == "rad" else "N"
    numbers = [
        Quantity("mean_speed", plan.contact.mean_speed, "mean speed of the camshaft", "rad/s"),
        Quantity("max_force", forces, "largest contact force of each cam", "N", parts=_AT),
        Quantity("max_pressure", pressures or None, "largest contact pressure of each cam", "Pa", parts=_AT),
        Quantity("max_torque", torque, "largest torque of the camshaft", "N m", parts=_AT),
        Quantity("lift_off", lift_off, "arcs without contact", "rad"),
        Quantity("least_preload", history.least_preload, "least preload that keeps contact", preload_unit),
    ]
    return group("contact", numbers, description)


def _pressure_angle_notes(plan: Plan) -> list[str]:
    """Warn of uncommonly large pressure angles where the study permits none."""
    constraints = plan.spec.permitted
    has_limit = constraints is not None and constraints.pressure_angle is not None
    return [] if has_limit else pressure_angle_remarks(plan.shapes.values(), plan.unit)


def _speed_table(plan: Plan) -> dict[str, Any] | None:
    """Return the speed of the shaft in rad/s."""
    if plan.shaft is None:
        return None
    speed = plan.shaft.speed
    return {"mean": speed.mean, "cosine": speed.cosine.tolist(), "sine": speed.sine.tolist()}


_VERSIONS = {
    "original": "original cam: it makes the law over the cam angle",
    "corrected": "corrected cam: at this speed it makes the law over time",
}
_DECIMALS = 9  # of lengths in mm: smaller differences are rounding
_CAM_NAMES = {"cam": "cam", "counter": "counter cam", "outer": "outer flank"}


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a cam's contour."""
    s = result.wucht.summary
    lines = _shaft_lines(s)
    for name, cam in s["cams"].items():
        lines += _cam_lines(_CAM_NAMES[name], cam)
    if s["min_transmission_angle"] is not None:
        lines.append(("transmission", f"angle of the linkage at least {_degrees(s['min_transmission_angle'])}"))
    if s["contact"] is not None:
        lines += _contact_lines(s["contact"], "N m" if result.follower.attrs["units"] == "rad" else "N")
    if s["smallest"] is not None:
        lines.append(("smallest cam", _smallest_cam_text(s["smallest"])))
    count = sum(cam["points_to_mill"] for cam in s["cams"].values())
    if count:
        tolerance = f"chords within {1e6 * s['chord_tolerance']:.4g} um, {s['decimals']} decimals in mm"
        lines.append(("to mill", f"{count} points, {tolerance}"))
    return report_lines(result, s["sentence"], lines)


def _shaft_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the line on the speed of the shaft, and whether the cam is corrected for it."""
    if (speed := s.get("speed")) is None:  # results of earlier versions lack it
        return []
    motion = f"fluctuates by {100 * s['fluctuation']:.4g} %" if s["fluctuation"] else "is constant"
    return [("shaft", f"its speed of {speed['mean'] * 30 / math.pi:.4g} rpm {motion}; {_VERSIONS[s['cam_version']]}")]


def _cam_lines(name: str, cam: dict[str, Any]) -> list[tuple[str, str]]:
    least = "least radius" if name == _CAM_NAMES["outer"] else "base circle"
    circles = f"{least} {_millimetres(cam['base_radius'])}, largest radius {_millimetres(cam['largest_radius'])}"
    angle = cam["max_pressure_angle"]
    if angle["angle"]:
        circles += f", pressure angle at most {_degrees(angle['angle'])} at {_degrees(angle['at'])}"
    lines = [(name, circles), ("", f"convex {_radius_text(cam['min_curvature'])}; hollow {_radius_text(cam['min_hollow'])}")]
    if cam["largest_roller"] is not None:
        lines.append(("", f"roller at most {_millimetres(cam['largest_roller'])} without cutting the contour away"))
    if cam["largest_wheel"] is not None:
        wheel = cam["largest_wheel"]
        lines.append(("", f"grinding wheel at most {_millimetres(wheel['radius'])} (at {_degrees(wheel['at'])})"))
    return lines


def _contact_lines(contact: dict[str, Any], unit: str) -> list[tuple[str, str]]:
    forces = contact["max_force"].items()
    preload = f"at least {contact['least_preload']:.4g} {unit} to"
    if not any(p["value"] for _, p in forces):
        return [("contact", "none: the follower does not touch its cam"), ("preload", f"{preload} keep contact")]
    force_clause = ", ".join(
        f"{_cam_prefix(name, forces)}at most {p['value']:.4g} N at {_degrees(p['at'])}" for name, p in forces
    )
    lines = [("contact", f"{force_clause}, at {contact['mean_speed'] * 30 / math.pi:.4g} rpm")]
    if contact["max_pressure"]:
        peaks = contact["max_pressure"].items()
        pressures = (
            f"{_cam_prefix(name, peaks)}at most {p['value'] / 1e6:.4g} MPa at {_degrees(p['at'])}" for name, p in peaks
        )
        lines.append(("Hertz", ", ".join(pressures)))
    torque = contact["max_torque"]
    lines.append(("camshaft", f"torque at most {torque['value']:.4g} N m at {_degrees(torque['at'])}"))
    purpose = "stay on the inner flank" if "outer" in contact["max_force"] else "keep contact over the whole turn"
    lines.append(("preload", f"{preload} {purpose}"))
    return lines


def _cam_prefix(name: str, cams: Any) -> str:
    return f"{_CAM_NAMES[name]} " if len(cams) > 1 else ""


def _smallest_cam_text(cam: dict[str, Any]) -> str:
    follower = ", ".join(
        f"{key} {_degrees(value) if key == 'angle' else _millimetres(value)}" for key, value in cam["follower"].items()
    )
    angle = f", pressure angle {_degrees(cam['max_pressure_angle'])}" if "max_pressure_angle" in cam else ""
    return (
        f"{follower}: base circle {_millimetres(cam['base_radius'])}{angle}, least "
        f"{_least_radius_text(cam['min_curvature_radius'])}"
    )


def _radius_text(radius_at: dict[str, float] | None) -> str:
    return (
        "none" if radius_at is None else f"radius at least {_millimetres(radius_at['radius'])} at {_degrees(radius_at['at'])}"
    )


def _least_radius_text(radius: float | None) -> str:
    return "radius none" if radius is None else f"radius {_millimetres(radius)}"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.4g}°"


def _millimetres(length: float) -> str:
    return f"{round(1e3 * length, _DECIMALS) + 0.0:.4g} mm"
