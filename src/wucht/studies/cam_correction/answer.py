"""What is stated of a cam's correction: shaft, orders, positions, proofs, residuals, contours, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from wucht.cams.corrected_contours import CheckedContour, Proof
from wucht.cams.correction import Deviation, MotionOverTime, Purity, residual_of_all
from wucht.cams.drive import CamDrive
from wucht.cams.drive_cams import DriveCams
from wucht.cams.dwells import dwells_of, position_error
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import CAM_LABELS, Shape, largest_pressure_angle, least_convex_radius, pressure_angle_remarks
from wucht.cams.undercut import RadiusAt
from wucht.cams.workshop.heading import CAM_VERSIONS
from wucht.errors import InputError
from wucht.measurements.order_checks import OmittedOrder
from wucht.measurements.shaft_signal import TURN
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import (
    angle_text,
    demand_text,
    distance_text,
    length_text,
    pad_orders,
    power_numbers,
    state_cam_curves,
    state_common_pressure_angle,
    state_rollers,
    watts_text,
)
from wucht.studies.cam_correction.record_answer import percent_text

_CLEAN = 1e-12  # of order 1: exact but for rounding
_CLEAN_SHARE = 1e-9  # from the points
_LEFT_OUT = 0.01  # share of order 1, from orders of the speed that are left out
_MOST = 6  # orders listed at most
_CURVES = ("contour_x", "contour_y", "normal_x", "normal_y", "curvature", "pressure_angle", "uncut")
_VERSION_KEYS = dict(zip(CAM_VERSIONS, ("before", "after"), strict=True))


def state_shaft(a: Answer, shaft: ShaftMotion, tau: np.ndarray) -> None:
    """State the motion of the shaft over time."""
    a.curve("time", tau / shaft.mean, "time", "s", "tau", coordinate=True)
    a.curve("shaft_angle", shaft.angle(tau), "angle of the camshaft", "rad", "tau")
    a.curve("shaft_speed", shaft.speed(tau), "speed of the camshaft", "rad/s", "tau")
    a.number("mean_speed", shaft.mean, "mean speed of the camshaft", "rad/s")
    period = a.number("period", 2 * math.pi / shaft.mean, "period of a turn", "s")
    fluctuation = a.number("fluctuation", shaft.fluctuation, "fluctuation of the speed, as a share of its mean")
    a.number("min_speed", shaft.speed.bounds[0], "least speed of the camshaft", "rad/s")
    a.number("max_speed", shaft.speed.bounds[1], "greatest speed of the camshaft", "rad/s")
    there = [order for order, amplitude in enumerate(shaft.speed.amplitudes, 1) if amplitude > 0]
    orders = ", ".join(map(str, there[:_MOST])) + (f" and {len(there) - _MOST} more" if len(there) > _MOST else "")
    turns = f"fluctuates by {100 * fluctuation:.2f} % in orders {orders}" if there else "turns evenly"
    a.line("shaft", f"{{mean_speed}}, a turn in {1e3 * period:.5g} ms; it {turns}")


def state_motions_over_time(
    a: Answer, motions: Sequence[MotionOverTime], law: Law, tau: np.ndarray, unit: str
) -> list[np.ndarray]:
    """State the motion of the output over time with both cams, and how far it is off the law. Returns the accelerations."""
    over, accelerations = "version tau", [motion.shaft.mean**2 * motion(tau, 2) for motion in motions]
    a.curve("output_over_time", [motion(tau) for motion in motions], "motion of the output", unit, over)
    a.curve("acceleration", accelerations, "acceleration of the output", f"{unit}/s^2", over)
    a.curve("position_error", [motion(tau) - law(tau) for motion in motions], "output less its law over time", unit, over)
    return accelerations


def state_orders(
    a: Answer, spectra: Sequence[FourierSeries], shaft: ShaftMotion, unit: str, shown_count: int, listed_count: int
) -> None:
    """State the orders of the acceleration with both cams.

    spectra: of it over omega^2. shown_count, listed_count: number of orders in the variables and in the summary.
    """
    scale, per, over = shaft.mean**2, f"{unit}/s^2", "version order"
    cosines, sines, amplitudes = (
        [pad_orders(scale * getattr(series, part), shown_count) for series in spectra]
        for part in ("cosine", "sine", "amplitudes")
    )
    a.curve("cosine", cosines, "cosine coefficient of the acceleration", per, over)
    a.curve("sine", sines, "sine coefficient of the acceleration", per, over)
    a.curve("amplitude", amplitudes, "acceleration, amplitude", per, over)
    for (version, key), series in zip(_VERSION_KEYS.items(), spectra, strict=True):
        of_version = (scale * series.amplitudes[:listed_count]).tolist()
        a.number(f"orders_{key}", of_version, f"amplitudes of the acceleration, {version} cam", per)


def state_positions(
    a: Answer,
    drive: CamDrive,
    motions: Sequence[MotionOverTime],
    accelerations: Sequence[np.ndarray],
    deviations: Sequence[Deviation],
    stroke: float,
) -> None:
    """State the largest accelerations, and how far the output is off its law and its dwells over time."""
    unit, arm, dwells = drive.motion_law.unit, drive.output_arm, dwells_of(drive.motion_law)
    a.number("unit", unit, "unit of the output")

    peaks, off, in_dwell = list[float](), list[str](), list[str]()
    a.number("dwells", [[d.begin, d.last] for d in dwells], "arcs of tau on which the output is to rest", "rad")
    a.number("output_arm", arm, "length of the output's arm", "m")
    for k, (version, key) in enumerate(_VERSION_KEYS.items()):
        peak = float(np.abs(accelerations[k]).max())
        peaks.append(a.number(f"peak_{key}", peak, f"largest acceleration, {version} cam", f"{unit}/s^2"))
        what = f"largest distance of the output from its law over time, {version} cam"
        largest = distance_text(a.number(f"position_error_{key}", deviations[k].position, what, unit), unit, stroke)
        what = f"root mean square of this distance, {version} cam"
        rms = distance_text(a.number(f"position_error_rms_{key}", deviations[k].rms, what, unit), unit, stroke)
        off.append(f"{largest} (rms {rms})")
        error = position_error(motions[k], dwells) if dwells else None
        factor = 1.0 if unit == "m" else arm
        travel = None if error is None or factor is None else factor * error
        a.number(f"dwell_error_{key}", error, f"largest position error in the dwell, {version} cam", unit)
        a.number(f"dwell_travel_{key}", travel, f"the same at the end of the output's arm, {version} cam", "m")
        if error is not None:
            place = " at the end of the arm" if key == "after" else ""
            at_arm = "" if unit == "m" or arm is None else f" ({distance_text(arm * error, 'm', arm * stroke)}{place})"
            in_dwell.append(distance_text(error, unit, stroke) + at_arm)
    per = f"{unit}/s^2"
    a.line("acceleration", f"at most {peaks[1]:.4g} {per}; of the original cam {peaks[0]:.4g} {per}")
    a.line("position", f"off the law over time by at most {off[1]}; with the original cam by {off[0]}")
    if in_dwell:
        a.line("dwell", f"position off by at most {in_dwell[1]}; with the original cam by {in_dwell[0]}")


def state_camshaft_powers(a: Answer, drive: CamDrive, motions: Sequence[MotionOverTime], tau: np.ndarray) -> None:
    """State the power that output and loads take from the camshaft, where the table [shaft] states them."""
    try:
        powers = drive.camshaft_powers(motions, tau)
    except InputError as error:  # the table is that of another study, so that nothing else depends on it
        powers = []
        a.warn(f"no power of the camshaft: {error}")
    if powers:
        a.curve("camshaft_power", powers, "power that output and loads take from the camshaft", "W", "version tau")
    demands = list[dict[str, float]]()
    for k, (version, key) in enumerate(_VERSION_KEYS.items()):
        power = power_numbers(powers[k]) if powers else None
        demands += [power] if power else []
        a.number(f"camshaft_power_{key}", power, f"power that output and loads take from the camshaft, {version} cam", "W")
    if powers:
        before, after = demands
        original = f"{watts_text(before['peak'])} and {watts_text(before['mean_positive'])}"
        a.line("camshaft", f"output and loads take {demand_text(after)}; with the original cam {original}")


def state_proofs(
    a: Answer,
    purity: Purity,
    proofs: Mapping[str, Proof],
    scale: float,
    unit: str,
    shown_count: int,
    count: int,
    point_count: int,
    decimals: int,
) -> list[float]:
    """State the orders that were recovered from points, also rounded ones. Returns the shares above N of those recovered.

    scale: omega^2. shown_count: number of orders in the variables. count: number of those examined.
    """
    count = max(count, 3 * (purity.count or 0))  # among more orders rounding would dominate

    def share(recovered: FourierSeries) -> float:
        return purity.share(FourierSeries(0.0, recovered.cosine[:count], recovered.sine[:count]))

    shares = dict[str, dict[str, float]]()
    for name, point_words, origin in (
        ("recovered", "the points", "the points of the corrected cam"),
        ("rounded", "rounded points", "these points rounded"),
    ):
        spectra: dict[str, FourierSeries | None] = {cam: getattr(proof, name) for cam, proof in proofs.items()}
        rows = [pad_orders(scale * (series or FourierSeries.of(0.0)).amplitudes, shown_count) for series in spectra.values()]
        what = f"acceleration from {point_words}, amplitude"
        a.curve(name, np.array(rows).reshape(-1, shown_count), what, f"{unit}/s^2", "cam order")
        shares[name] = {cam: share(series) for cam, series in spectra.items() if series is not None}
        a.number(name, shares[name], f"{purity.name}, from {origin}")
    a.number("points", point_count, "number of points of a contour")
    a.number("decimals", decimals, "decimals of rounded points")
    if exact := shares["recovered"]:
        exact_shares = ", ".join(f"{name} {share:.2g}" for name, share in exact.items())
        rounded_shares = ", ".join(f"{share:.2g}" for share in shares["rounded"].values())
        fine = f"rounded to {decimals} decimals of a mm {rounded_shares}"
        a.line("from points", f"{exact_shares} of order {purity.reference}; {fine}")
    a.warn(*(note for proof in proofs.values() for note in proof.notes))
    return [*exact.values()]


def state_purity(
    a: Answer,
    purity: Purity,
    deviations: Sequence[Deviation],
    shares: Sequence[float],
    left_out: Mapping[OmittedOrder, float],
    point_count: int,
) -> None:
    """State the verdict: orders above N after the correction and before it, and those obtained from points of the contour."""
    (before, after), has_all_orders = [deviation.orders for deviation in deviations], purity.count is None
    a.number("harmonics", purity.count, "number N of harmonics of the law")
    a.number("reference_order", purity.reference, "reference order of the comparison")
    a.number("before", before, f"{purity.name}, original cam")
    a.number("after", after, f"{purity.name}, corrected cam")
    subject = "orders differ from the law's by" if has_all_orders else f"orders above {purity.count} are"
    residual = f"{'less than' if has_all_orders else 'below'} {_CLEAN:.0e}" if after < _CLEAN else f"{after:.2g}"
    clean = "CLEAN" if purity.is_clean(deviations[1], _CLEAN_SHARE) else "NOT CLEAN"
    a.sentence = f"{clean}: {subject} {residual} of order {purity.reference} (before: {before:.2g})"
    if shares:
        more = "" if max(shares) < _CLEAN_SHARE else ", which more points reduce"
        a.sentence += f"; from {point_count} points of the contour {max(shares):.2g}{more}"
    if (omitted_share := residual_of_all(left_out)) >= _LEFT_OUT:
        a.sentence += f"; but orders of the record that are not corrected leave about {omitted_share:.2g}"


def state_residuals(a: Answer, shares: Mapping[str, float]) -> None:
    """State the residuals under deviating conditions; the orders left out in one line."""
    rows = [{"what": condition, "share": share} for condition, share in shares.items()]
    a.number("residuals", rows, "residuals", parts={"what": ("deviation that causes it", ""), "share": ("share", "")})
    orders = [condition for condition in shares if condition.startswith("order ")]
    for condition, share in shares.items():
        if condition not in orders:
            a.line("deviation", f"{condition} leaves {percent_text(share)}")
    largest_orders = sorted(orders, key=lambda condition: -shares[condition])[:_MOST]
    if orders:
        order_shares = ", ".join(f"{percent_text(shares[one])} ({one.split()[1]})" for one in largest_orders)
        a.line("deviation", f"an order of the speed left out leaves {order_shares}")


def state_contours(
    a: Answer,
    cam_pair: tuple[DriveCams, DriveCams],
    before: Mapping[str, CheckedContour],
    after: Mapping[str, CheckedContour],
    follower_unit: str,
    angles: np.ndarray,
    chord_tolerance: float,
) -> None:
    """State the contours of the original and the corrected cams at cam angles (N,), their sizes, and what to check of them."""
    contours, cams, point_count = [*before.values(), *after.values()], cam_pair[1].cams, len(angles)
    sizes, drawn_cams = (len(CAM_VERSIONS), len(cams)), [cam for version in cam_pair for cam in version.cams.values()]
    state_cam_curves(a, _CURVES, drawn_cams, angles, "version cam cam_angle", (*sizes, point_count))
    distance = np.array([contour.displacement for contour in after.values()]).reshape(len(cams), point_count)
    a.curve("moved", distance, "corrected contour, outwards", "m", "cam cam_angle")
    for name, what, get_size in _SIZES:
        a.curve(name, np.array([get_size(one.shape) for one in contours], float).reshape(sizes), what, "m", "version cam")
    state_common_pressure_angle(a, follower_unit)
    places = np.array([complex(cam.follower.place(cam.law(0.0))) for cam in cams.values()], complex)
    a.curve("follower_x", places.real, "roller or face at cam angle 0, x", "m", "cam")
    a.curve("follower_y", places.imag, "roller or face at cam angle 0, y", "m", "cam")
    state_rollers(a, cams.values())
    shapes = [contour.shape for contour in after.values()]
    least, angle = least_convex_radius(shapes), largest_pressure_angle(shapes).value if shapes else None
    what = "least radius of curvature of a corrected cam, convex"
    a.number("min_curvature_radius", None if least is None else least.radius, what, "m", headline=True)
    a.number("max_pressure_angle", angle, "largest pressure angle of a corrected cam", "rad", headline=True)
    a.number("undercut", False if shapes else None, "true if a follower cuts off parts of a corrected contour")
    hint = 'this key belongs to study.kind = "cam-contour", with study.corrected = true'
    remarks = pressure_angle_remarks(shapes, follower_unit) if shapes else []
    a.warn(*(f"Corrected cam: {remark}; {hint}" for remark in remarks))
    with a.group("contours", "sizes of each cam, original and corrected"):
        for name, contour in after.items():
            with a.group(name, "sizes of a cam"):
                _state_cam(a, name, before[name], contour, cams[name].roller_radius)
    worst = max((contour.chord for contour in after.values()), default=0.0)
    if worst > chord_tolerance:
        required_points = math.ceil(1.01 * point_count * math.sqrt(worst / chord_tolerance))
        a.warn(
            f"Chords between {point_count} points leave the contour by {1e6 * worst:.3g} um, more than the tolerance of "
            f"{1e6 * chord_tolerance:.3g} um: take points = {required_points}, or join them by a spline."
        )


_SIZES: tuple[tuple[str, str, Callable[[Shape], float | None]], ...] = (
    ("least_radius", "least radius of curvature, convex", lambda shape: _radius(shape.convex)),
    ("hollow_radius", "least radius of curvature, hollow", lambda shape: _radius(shape.hollow)),
    ("largest_roller", "largest roller without undercut", lambda shape: shape.largest_roller or None),
    ("base_radius", "least radius of the contour", lambda shape: shape.base.value),
)


def _state_cam(a: Answer, name: str, before: CheckedContour, after: CheckedContour, roller_radius: float | None) -> None:
    for version, contour in zip(CAM_VERSIONS, (before, after), strict=True):
        shape = contour.shape
        with a.group(version, f"{version} cam"):
            a.number("max_pressure_angle", shape.pressure_angle.value, "largest pressure angle", "rad")
            a.number("max_pressure_angle_at", shape.pressure_angle.phi, "cam angle there", "rad")
            a.number("largest_roller", shape.largest_roller, "largest roller without undercut", "m")
            a.number("min_curvature_radius", _radius(shape.convex), "least radius of curvature, convex", "m")
            a.number("min_hollow_radius", _radius(shape.hollow), "least radius of curvature, hollow", "m")
            a.number("face_length", shape.face_length, "least length of the face", "m")
            a.number("largest_wheel", _radius(shape.wheel), "largest grinding wheel", "m")
    distance = a.number("moved", float(np.abs(after.displacement).max()), "largest displacement of the contour", "m")
    a.number("chord", after.chord, "largest distance of chords between points", "m")
    missing = sum(end - begin for begin, end in before.shape.missing) / TURN
    if a.number("missing_before", missing, "share of a turn without a contour, original cam") > 0:
        a.warn(f"The follower cuts {100 * missing:.1f} % of the original contour ({name}) away; the corrected one is intact.")
    a.number("roller_radius", roller_radius, "radius of the roller", "m")
    old, new = before.shape, after.shape
    old_angle, new_angle = (f"{math.degrees(shape.pressure_angle.value):.3g}°" for shape in (old, new))
    old_radius, new_radius = (length_text(_radius(shape.convex)) for shape in (old, new))
    angles = f"pressure angle at most {new_angle} at {angle_text(new.pressure_angle.phi)} (original {old_angle}), "
    has_angle = new.pressure_angle.value != 0  # a flat face has none
    face = f", face at least {length_text(new.face_length)} ({length_text(old.face_length)})" if new.face_length else ""
    a.line(CAM_LABELS[name], f"{angles if has_angle else ''}least radius of curvature {new_radius} ({old_radius}){face}")
    has_limit = new.largest_roller is not None and math.isfinite(new.largest_roller)
    roller = f", largest roller {length_text(new.largest_roller)}" if has_limit else ""
    wheel = f", largest grinding wheel {length_text(new.wheel.radius)}" if new.wheel is not None else ""
    a.line("", f"moved by {_mm(distance)} at most, not undercut{roller}{wheel}")


def _radius(at: RadiusAt | None) -> float | None:
    return None if at is None else at.radius


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
