"""What is stated of a cam's contour: shapes, points to mill, contact, the smallest cam, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.contact_history import ContactHistory, ContactLoad
from wucht.cams.correction import MotionOverTime
from wucht.cams.demands import format_millimetres
from wucht.cams.drive_cams import DriveCams
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import (
    CAM_LABELS,
    Shape,
    format_cam_angle,
    largest_pressure_angle,
    least_convex_radius,
    pressure_angle_remarks,
)
from wucht.cams.sizing.size_limits import CamLimits, SmallestCam
from wucht.cams.undercut import RadiusAt
from wucht.cams.workshop.points import PointList
from wucht.errors import InputError, RunError
from wucht.numerics.angles import Arc, valleys
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import angle_text, demand_text, length_text, state_common_pressure_angle, state_rollers

_LIMIT_TOLERANCE = 1e-6  # of a limit: a smallest cam lies at its limit up to rounding, which is no violation
_MOST_ARCS = 3
_AT = {"at": ("cam angle", "rad")}
_VERSIONS = {
    "original": "original cam: it makes the law over the cam angle",
    "corrected": "corrected cam: at this speed it makes the law over time",
}


def state_version(a: Answer, cams: DriveCams, is_chosen: bool) -> None:
    """State the speed of the shaft, and whether the cam is corrected for it."""
    shaft = cams.shaft
    speed = None if shaft is None else shaft.speed.to_table()
    a.number("speed", speed, "speed of the shaft, of the table [speed] or as predicted for a corrected cam", "rad/s")
    of_corrected = "speed of the shaft for which the cam is corrected"
    a.number("corrected", speed if cams.is_corrected else None, of_corrected, "rad/s")
    a.number("cam_version", cams.version or None, "original or corrected cam")
    of_mean = "fluctuation of this speed, as a share of its mean"
    fluctuation = a.number("fluctuation", None if shaft is None else shaft.fluctuation, of_mean)
    if shaft is None or fluctuation is None:
        return
    motion = f"fluctuates by {100 * fluctuation:.4g} %" if fluctuation else "is constant"
    a.line("shaft", f"its speed of {shaft.mean * 30 / math.pi:.4g} rpm {motion}; {_VERSIONS[cams.version]}")
    if fluctuation > 0 and not is_chosen:
        a.warn(
            "this is the original cam, for a shaft that turns evenly, but the speed of [speed] fluctuates by "
            f"{100 * fluctuation:.4g} %: study.corrected = true makes the cam that is corrected for this speed, "
            "study.corrected = false keeps the original one"
        )


def state_contact_curves(a: Answer, cams: Mapping[str, Cam], angles: np.ndarray, history: ContactHistory | None) -> None:
    """State the contact over the cam angle; not numbers where there is none."""
    nowhere = np.full(len(angles), np.nan)
    for name, what, unit, of_cams in (
        ("contact_force", "contact force", "N", {} if history is None else history.force),
        ("contact_pressure", "contact pressure", "Pa", {} if history is None else history.pressure),
    ):
        a.curve(name, np.array([of_cams.get(cam, nowhere) for cam in cams]), what, unit, "cam cam_angle")
    torque, power = (nowhere, nowhere) if history is None else (history.torque, history.power)
    a.curve("camshaft_torque", torque, "torque of the camshaft", "N m", "cam_angle")
    a.curve("camshaft_power", power, "power of the camshaft", "W", "cam_angle")


def state_arcs(a: Answer, shapes: Mapping[str, Shape], history: ContactHistory | None) -> None:
    """State the arcs that are cut away, and those without contact."""
    arcs: list[tuple[str, str, Arc]] = []
    for name, shape in shapes.items():
        arcs += [(name, "undercut", arc) for arc in shape.undercut] + [(name, "missing", arc) for arc in shape.missing]
        arcs += [(name, "lift-off", arc) for arc in (history.lift_off[name] if history is not None else ())]
    a.curve("arc_cam", [name for name, _, _ in arcs], "cam of an arc", "", "arc")
    a.curve("arc_of", [event for _, event, _ in arcs], "kind of an arc: undercut, missing or lift-off", "", "arc")
    a.curve("arc_begin", [arc[0] for _, _, arc in arcs], "start of an arc", "rad", "arc")
    a.curve("arc_end", [arc[1] for _, _, arc in arcs], "end of an arc", "rad", "arc")


def state_points(a: Answer, points: Mapping[str, PointList]) -> None:
    """State the points to mill of all cams, in a row."""
    lists, over = list(points.values()), "mill_point"
    position = np.concatenate([np.zeros(0, complex), *(of_cam.position for of_cam in lists)])
    normal = np.concatenate([np.zeros(0, complex), *(of_cam.normal for of_cam in lists)])
    numbers = np.repeat(np.arange(len(lists)), [len(of_cam.phi) for of_cam in lists])
    a.curve("mill_cam", numbers, "number of the cam, from 0", "", over)
    phi = np.concatenate([np.zeros(0), *(of_cam.phi for of_cam in lists)])
    a.curve("mill_angle", phi, "cam angle of a point to mill", "rad", over)
    a.curve("mill_x", position.real, "point to mill, x", "m", over)
    a.curve("mill_y", position.imag, "point to mill, y", "m", over)
    a.curve("mill_normal_x", normal.real, "outward normal there, x", "", over)
    a.curve("mill_normal_y", normal.imag, "outward normal there, y", "", over)


def state_layout(
    a: Answer, cams: DriveCams, shapes: Mapping[str, Shape], permitted: CamLimits | None, wheel_radius: float | None
) -> None:
    """State the follower at cam angle 0, and the limits."""
    follower, limits = cams.drive.required_follower, permitted or CamLimits()
    outline = follower.outline(cams.follower_law)
    state_rollers(a, cams.cams.values())
    a.curve("base_radius", [shape.base.value for shape in shapes.values()], "radius of the base circle", "m", "cam")
    a.curve("pivot", outline.pivot, "pivot of the lever, x", "m", "")
    a.curve("rod_offset", outline.rod_offset, "offset of the rod", "m", "")
    a.curve("face_from", outline.face_from, "least y at which the face is touched", "m", "")
    a.curve("face_to", outline.face_to, "greatest y at which the face is touched", "m", "")
    a.curve("face_at", outline.face_at, "face, x", "m", "")
    a.curve("permitted_pressure_angle", limits.pressure_angle, "permitted pressure angle", "rad", "")
    state_common_pressure_angle(a, follower.unit)
    a.curve("permitted_radius", limits.least_radius, "permitted radius of curvature", "m", "")
    a.curve("permitted_contact_pressure", limits.contact_pressure, "permitted contact pressure", "Pa", "")
    a.curve("wheel_radius", wheel_radius, "radius of the grinding wheel", "m", "")
    a.number("follower", follower.kind, "kind of follower")
    a.number("clockwise", follower.clockwise, "true if the cam turns clockwise")


def state_cams(a: Answer, shapes: Mapping[str, Shape], points: Mapping[str, PointList]) -> None:
    """State the sizes of each cam, and the least and the largest of them."""
    convex, hollow = least_convex_radius(shapes.values()), [s.hollow.radius for s in shapes.values() if s.hollow is not None]
    least = None if convex is None else convex.radius
    a.number("min_curvature_radius", least, "least convex radius of curvature", "m", headline=True)
    a.number("min_hollow_radius", min(hollow, default=None), "least hollow radius of curvature", "m")
    pressure_angle = largest_pressure_angle(shapes.values()).value
    a.number("max_pressure_angle", pressure_angle, "largest pressure angle", "rad", headline=True)
    is_cut_away = any(shape.missing or shape.undercut for shape in shapes.values())
    a.number("undercut", is_cut_away, "true if the follower cuts off parts of the contour")
    a.number("base_radius", shapes["cam"].base.value, "radius of the base circle", "m", headline=True)
    a.number("largest_radius", shapes["cam"].blank.value, "largest radius of the contour", "m", headline=True)
    if a.number("face_length", shapes["cam"].face_length, "least length of the face", "m"):
        a.line("face", "at least {face_length} long, across the rod")
    with a.group("cams", "each cam"):
        for name, shape in shapes.items():
            with a.group(name, CAM_LABELS[name]):
                _state_cam(a, name, shape, len(points[name].phi) if name in points else 0)


def _state_cam(a: Answer, name: str, shape: Shape, point_count: int) -> None:
    angle = shape.pressure_angle
    _state_radius(a, "min_curvature", shape.convex, "least convex radius of curvature")
    _state_radius(a, "min_hollow", shape.hollow, "least hollow radius of curvature")
    _state_radius(a, "largest_wheel", shape.wheel, "largest grinding wheel")
    a.number("largest_roller", shape.largest_roller, "largest roller without undercut", "m")
    parts = {"angle": ("angle", "rad")} | _AT
    a.number("max_pressure_angle", {"angle": angle.value, "at": angle.phi}, "largest pressure angle", parts=parts)
    a.number("base_radius", shape.base.value, "radius of the base circle", "m")
    a.number("largest_radius", shape.blank.value, "largest radius of the contour", "m")
    a.number("undercut", [list(arc) for arc in shape.undercut], "arcs cut off by the follower", "rad")
    a.number("missing", [list(arc) for arc in shape.missing], "arcs without a contour", "rad")
    a.number("points_to_mill", point_count, "number of points to mill")
    least = "least radius" if name == "outer" else "base circle"
    circles = f"{least} {length_text(shape.base.value)}, largest radius {length_text(shape.blank.value)}"
    steepest = f", pressure angle at most {angle_text(angle.value)} at {angle_text(angle.phi)}" if angle.value else ""
    a.line(CAM_LABELS[name], circles + steepest)
    a.line("", f"convex {_radius_text(shape.convex)}; hollow {_radius_text(shape.hollow)}")
    if shape.largest_roller is not None and math.isfinite(shape.largest_roller):
        a.line("", f"roller at most {length_text(shape.largest_roller)} without cutting the contour away")
    if shape.wheel is not None:
        a.line("", f"grinding wheel at most {length_text(shape.wheel.radius)} (at {angle_text(shape.wheel.phi)})")


def _state_radius(a: Answer, name: str, at: RadiusAt | None, what: str) -> None:
    value = None if at is None else {"radius": at.radius, "at": at.phi}
    a.number(name, value, what, parts={"radius": ("radius", "m")} | _AT)


def _radius_text(at: RadiusAt | None) -> str:
    return "none" if at is None else f"radius at least {length_text(at.radius)} at {angle_text(at.phi)}"


def state_acceleration(a: Answer, law: Law, shaft: ShaftMotion | None, unit: str) -> None:
    """State the largest acceleration of the output where a speed is stated."""
    what, per = "largest acceleration of the output at this speed", f"{unit}/s^2"
    if shaft is None:
        a.number("peak_acceleration", None, what, per)
        return
    motion = MotionOverTime(law, shaft)
    peak = -float(valleys(lambda tau: -np.abs(motion(tau, 2)))[1].min())
    a.number("peak_acceleration", shaft.mean**2 * peak, what, per)
    a.line("acceleration", f"of the output at most {{peak_acceleration}}, at {shaft.mean * 30 / math.pi:.4g} rpm")


def state_contact(a: Answer, contact: ContactLoad | None, history: ContactHistory | None, effort_unit: str) -> None:
    """State the largest values of the contact. history: at angles that are dense enough for them."""
    what = "largest values of the contact"
    if contact is None or history is None:
        a.number("contact", None, what)
        return
    with a.group("contact", what):
        mean_speed = a.number("mean_speed", contact.mean_speed, "mean speed of the camshaft", "rad/s")
        forces, pressures = (
            {name: _peak(history, values) for name, values in of.items()} for of in (history.force, history.pressure)
        )
        torque = _peak(history, np.abs(history.torque))
        a.number("max_force", forces, "largest contact force of each cam", "N", parts=_AT)
        a.number("max_pressure", pressures or None, "largest contact pressure of each cam", "Pa", parts=_AT)
        a.number("max_torque", torque, "largest torque of the camshaft", "N m", parts=_AT)
        lift_off = {name: [list(arc) for arc in arcs] for name, arcs in history.lift_off.items()}
        # The mean over time is that over the angle of torque times mean speed: power dt = torque dphi.
        positive = np.maximum(history.torque, 0.0)
        means = (contact.mean_speed * float(over_turn.mean()) for over_turn in (history.torque, positive))
        power = dict(zip(("peak", "mean", "mean_positive"), (float(history.power.max()), *means), strict=True))
        a.number("power", power, "power of the camshaft", "W")
        a.number("lift_off", lift_off, "arcs without contact", "rad")
        a.number("least_preload", history.least_preload, "least preload that keeps contact", effort_unit)
    preload = f"at least {history.least_preload:.4g} {effort_unit} to"
    if not any(force["value"] for force in forces.values()):
        a.line("contact", "none: the follower does not touch its cam")
        a.line("preload", f"{preload} keep contact")
        return
    a.line("contact", f"{_peaks_text(forces, 1.0, 'N')}, at {mean_speed * 30 / math.pi:.4g} rpm")
    if pressures:
        a.line("Hertz", _peaks_text(pressures, 1e6, "MPa"))
    a.line("camshaft", f"torque at most {torque['value']:.4g} N m at {angle_text(torque['at'])}")
    a.line("", f"power {demand_text(power)}")
    purpose = "stay on the inner flank" if "outer" in forces else "keep contact over the whole turn"
    a.line("preload", f"{preload} {purpose}")


def _peak(history: ContactHistory, values: np.ndarray) -> dict[str, float]:
    k = int(np.argmax(values))
    return {"value": float(values[k]), "at": float(history.phi[k])}


def _peaks_text(peaks: Mapping[str, Mapping[str, float]], size: float, unit: str) -> str:
    """Return the largest values of each cam in words, in a unit of this size."""
    owners = {name: f"{CAM_LABELS[name]} " if len(peaks) > 1 else "" for name in peaks}
    return ", ".join(
        f"{owners[name]}at most {peak['value'] / size:.4g} {unit} at {angle_text(peak['at'])}" for name, peak in peaks.items()
    )


_SMALLEST_PARTS = {
    "follower": ("position of the follower", "m"),
    "angle": ("angle of the lever", "rad"),
    "base_radius": ("radius of the base circle", "m"),
    "largest_radius": ("largest radius of the contour", "m"),
    "min_curvature_radius": ("least convex radius of curvature", "m"),
    "max_pressure_angle": ("largest pressure angle", "rad"),
    "face": ("least and greatest y at which the face is touched", "m"),
}


def state_smallest_cam(a: Answer, smallest: SmallestCam | RunError | None) -> None:
    """State the smallest cam, if limits that determine it are given and one was found."""
    size = None if smallest is None or isinstance(smallest, RunError) else smallest.summary()
    a.number("smallest", size, "smallest cam within the permitted limits", parts=_SMALLEST_PARTS)
    if size is None:
        return
    follower = ", ".join(
        f"{key} {angle_text(value) if key == 'angle' else length_text(value)}" for key, value in size["follower"].items()
    )
    angle = f", pressure angle {angle_text(size['max_pressure_angle'])}" if "max_pressure_angle" in size else ""
    radius = length_text(size["min_curvature_radius"])
    a.line("smallest cam", f"{follower}: base circle {length_text(size['base_radius'])}{angle}, least radius {radius}")


def warn_of_smallest_cam(a: Answer, cams: DriveCams, smallest: SmallestCam | RunError | None) -> None:
    """Warn where there is no smallest cam, or obstacles to making it."""
    if isinstance(smallest, RunError):
        a.warn(f"no smallest cam: {smallest}")
    elif smallest is not None:
        follower, anew = cams.drive.required_follower.with_placement(smallest.placement)
        a.warn(*anew)
        try:
            for cam in replace(cams.drive, follower=follower).make_cams(cams.law).values():
                if smallest.face is None:  # a face's least radius shows that nothing is cut away
                    cam.check(format_millimetres)
        except InputError as error:
            a.warn(f"the smallest permitted cam cannot be made: {error.explanation}")


def state_tolerances(a: Answer, points: Mapping[str, PointList], chord_tolerance: float, spacing: float, decimals: int) -> None:
    """State how exact the points to mill are."""
    a.number("chord_tolerance", chord_tolerance, "largest distance of chords between points to mill", "m")
    a.number("spacing", spacing, "distance of points to mill", "m")
    a.number("decimals", decimals, "decimals of the points to mill")
    if count := sum(len(of_cam.phi) for of_cam in points.values()):
        a.line("to mill", f"{count} points, chords within {1e6 * chord_tolerance:.4g} um, {decimals} decimals in mm")


def state_verdict(
    a: Answer, cams: DriveCams, shapes: Mapping[str, Shape], permitted: CamLimits | None, history: ContactHistory | None
) -> None:
    """State whether the cam can be cut within the permitted limits, and warn of pressure angles that none was given for."""
    follower_unit = cams.drive.required_follower.unit
    lift_offs = list(_lift_off_clauses(shapes, history, "N m" if follower_unit == "rad" else "N"))
    if cut_away := list(_undercut_clauses(shapes)):
        outcome, sentence = "undercut", f"undercut: {'; '.join(cut_away)}"
    elif permitted is not None and (violations := list(_violation_clauses(permitted, shapes, history))):
        outcome, violation = "not-permitted", f"cuttable, but outside the permitted limits: {', '.join(violations)}"
        sentence = "; ".join([violation, *lift_offs])
    else:
        outcome, sentence = ("lifts-off" if lift_offs else "cuttable"), "; ".join([_sizes_text(shapes), *lift_offs])
    a.number("outcome", outcome, "outcome")
    a.sentence = sentence + (f"; {cams.version} cam" if cams.version else "")
    if permitted is None or permitted.pressure_angle is None:
        a.warn(*pressure_angle_remarks(shapes.values(), follower_unit))


def _sizes_text(shapes: Mapping[str, Shape]) -> str:
    least = least_convex_radius(shapes.values())
    radius = f"least convex radius {length_text(least.radius)} at {format_cam_angle(least.phi)}" if least else ""
    text = f"cuttable: {radius or 'the contour is nowhere convex'}"
    if any(shape.pressure_angle.value > 0 for shape in shapes.values()):
        angle = largest_pressure_angle(shapes.values())
        text += f", pressure angle at most {format_cam_angle(angle.value)} at {format_cam_angle(angle.phi)}"
    return text


def _undercut_clauses(shapes: Mapping[str, Shape]) -> Iterator[str]:
    for name, shape in shapes.items():
        if shape.missing or shape.undercut:
            yield f"the {shape.part} cuts the {CAM_LABELS[name]} away {_arcs_text(shape.missing or shape.undercut)}"


def _violation_clauses(limits: CamLimits, shapes: Mapping[str, Shape], history: ContactHistory | None) -> Iterator[str]:
    angle = largest_pressure_angle(shapes.values())
    if limits.pressure_angle is not None and angle.value > limits.pressure_angle * (1 + _LIMIT_TOLERANCE):
        angle_clause = f"pressure angle {format_cam_angle(angle.value)} at {format_cam_angle(angle.phi)}"
        yield f"{angle_clause} (permitted {format_cam_angle(limits.pressure_angle)})"
    convex = least_convex_radius(shapes.values())
    if limits.least_radius is not None and convex and convex.radius < limits.least_radius * (1 - _LIMIT_TOLERANCE):
        yield f"least radius {length_text(convex.radius)} (permitted {length_text(limits.least_radius)})"
    base = min(shape.base.value for shape in shapes.values())
    if limits.shaft_radius is not None and base < limits.shaft_radius * (1 - _LIMIT_TOLERANCE):
        yield f"base circle {length_text(base)} (permitted {length_text(limits.shaft_radius)}, that of the shaft)"
    if limits.contact_pressure is not None and history is not None:
        largest = max(float(pressure.max()) for pressure in history.pressure.values())
        if largest > limits.contact_pressure:
            yield f"contact pressure {largest / 1e6:.4g} MPa (permitted {limits.contact_pressure / 1e6:.4g} MPa)"


def _lift_off_clauses(shapes: Mapping[str, Shape], history: ContactHistory | None, effort_unit: str) -> Iterator[str]:
    """Yield where a roller lifts off its cam; in a groove it passes to the opposite flank."""
    if history is None or "outer" in shapes:
        return
    for name, arcs in history.lift_off.items():
        if arcs:
            owner = "" if len(shapes) == 1 else f" of the {CAM_LABELS[name]}"
            preload = f"{history.least_preload:.4g} {effort_unit}"
            yield f"the {shapes[name].part}{owner} lifts off {_arcs_text(arcs)} (a preload of {preload} holds it)"


def _arcs_text(arcs: tuple[Arc, ...]) -> str:
    intervals = " and ".join(f"from {format_cam_angle(begin)} to {format_cam_angle(end)}" for begin, end in arcs[:_MOST_ARCS])
    return intervals + (f" and on {len(arcs) - _MOST_ARCS} more arcs" if len(arcs) > _MOST_ARCS else "")
