"""Findings -> the Dataset of a cam's correction, and the verdict on how clean the motion becomes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wucht.cams.shape import COMMON, Shape, largest_pressure_angle
from wucht.cams.undercut import RadiusAt
from wucht.cams.workshop.heading import CAM_VERSIONS
from wucht.measurements.order_checks import OmittedOrder
from wucht.numerics.fourier_series import FourierSeries
from wucht.results.quantities import Quantity, group, result_dataset, table
from wucht.studies.cam_correction.prepare import Plan, explained_share
from wucht.studies.cam_correction.run import Contour, Findings, Proof

if TYPE_CHECKING:
    import xarray as xr

CLEAN = 1e-12  # of order 1: exact but for rounding
_CLEAN_SHARE = 1e-9  # from the points
_MATTERS = 0.01  # share of order 1, from orders of the speed that are left out
_NAMES = ("", "_velocity", "_acceleration", "_jerk")
_PER = ("", "/rad", "/rad^2", "/rad^3")


def sentence(plan: Plan, findings: Findings) -> str:
    """Return the verdict: orders above N after the correction and before it, and those obtained from points of the contour."""
    purity, before, after = plan.purity, findings.deviation[0].orders, findings.deviation[1].orders
    has_all_orders = purity.count is None
    subject = "orders differ from the law's by" if has_all_orders else f"orders above {purity.count} are"
    residual = f"{'less than' if has_all_orders else 'below'} {CLEAN:.0e}" if after < CLEAN else f"{after:.2g}"
    clean = "CLEAN" if purity.is_clean(findings.deviation[1], _CLEAN_SHARE) else "NOT CLEAN"
    text = f"{clean}: {subject} {residual} of order {purity.reference} (before: {before:.2g})"
    shares = [_share_of_points(plan, proof.recovered) for proof in findings.proofs.values() if proof.recovered is not None]
    if shares:
        more = "" if max(shares) < _CLEAN_SHARE else ", which more points reduce"
        text += f"; from {plan.spec.points} points of the contour {max(shares):.2g}{more}"
    omitted_share = residual_of_omitted_orders(findings)
    return (
        text
        if omitted_share < _MATTERS
        else f"{text}; but orders of the record that are not corrected leave about {omitted_share:.2g}"
    )


def residual_of_omitted_orders(findings: Findings) -> float:
    """Return the residual of all orders of the record that are not corrected: about the root of the sum of squares."""
    return math.hypot(*(one.share for one in findings.left_out))


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a correction; contours in the plane that turns with the cam, numbers that do not apply are NaN."""
    f, u, pairs = findings, plan.unit, "version tau"
    shares = [{"what": r.condition, "share": r.share} for r in f.residuals]
    quantities = [
        Quantity("version", list(CAM_VERSIONS), "cam", "", "version"),
        Quantity("tau", f.tau, "time as an angle, omega t", "rad", "tau"),
        Quantity("cam_angle", f.angles, "cam angle", "rad", "cam_angle"),
        Quantity("order", np.arange(1, plan.shown_orders + 1), "order", "", "order"),
        Quantity("cam", np.array(list(plan.after), dtype=str), "cam", "", "cam"),
        Quantity("time", f.tau / plan.shaft.mean, "time", "s", "tau", coordinate=True),
        Quantity("shaft_angle", plan.shaft.angle(f.tau), "angle of the camshaft", "rad", "tau"),
        Quantity("shaft_speed", plan.shaft.speed(f.tau), "speed of the camshaft", "rad/s", "tau"),
        Quantity("output_over_time", f.output, "motion of the output", u, pairs),
        Quantity("acceleration", f.acceleration, "acceleration of the output", f"{u}/s^2", pairs),
        Quantity("residual", [r.condition for r in f.residuals], "deviation from the assumptions of the cam", "", "residual"),
        Quantity("share", [r.share for r in f.residuals], "residual as a share", "", "residual"),
        *table("residuals", shares, "residuals", {"what": ("deviation that causes it", ""), "share": ("share", "")}),
        *_table_quantities(plan, f),
        *_order_quantities(plan, f),
        *_speed_quantities(plan),
        *_contour_quantities(plan, f),
        *_measurement_quantities(plan, f),
        *_summary_quantities(plan, f),
    ]
    return result_dataset(quantities, sentence(plan, f), f.notes)


def _share_of_points(plan: Plan, recovered: FourierSeries) -> float:
    """Return the share of orders above N from points of a contour: among more orders their rounding would dominate."""
    count = max(plan.orders, 3 * (plan.purity.count or 0))
    return plan.purity.share(FourierSeries(0.0, recovered.cosine[:count], recovered.sine[:count]))


def _pad_row(values: np.ndarray, count: int) -> np.ndarray:
    return np.append(values[:count], np.full(max(0, count - len(values)), np.nan))


def _table_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    motions = (
        ("output", plan.unit, "motion of the output", f.table),
        ("follower", plan.lever_unit, "motion of the follower", f.lever),
    )
    return [
        Quantity(
            name + suffix, [t[k] for t in tables], description + suffix.replace("_", ", "), unit + per, "version cam_angle"
        )
        for name, unit, description, tables in motions
        for k, (suffix, per) in enumerate(zip(_NAMES, _PER, strict=True))
    ]


def _order_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    count, scale, unit = plan.shown_orders, plan.shaft.mean**2, f"{plan.unit}/s^2"

    def version_rows(of: Callable[[FourierSeries], np.ndarray]) -> list[np.ndarray]:
        return [_pad_row(scale * of(series), count) for series in f.spectrum]

    def cam_rows(of: Callable[[Proof], FourierSeries | None]) -> np.ndarray:
        rows = [_pad_row(scale * (of(proof) or FourierSeries.of(0.0)).amplitudes, count) for proof in f.proofs.values()]
        return np.array(rows).reshape(-1, count)

    dimensions = "version order"
    return [
        Quantity("cosine", version_rows(lambda s: s.cosine), "cosine coefficient of the acceleration", unit, dimensions),
        Quantity("sine", version_rows(lambda s: s.sine), "sine coefficient of the acceleration", unit, dimensions),
        Quantity("amplitude", version_rows(lambda s: s.amplitudes), "acceleration, amplitude", unit, dimensions),
        Quantity("recovered", cam_rows(lambda p: p.recovered), "acceleration from the points, amplitude", unit, "cam order"),
        Quantity("rounded", cam_rows(lambda p: p.rounded), "acceleration from rounded points, amplitude", unit, "cam order"),
    ]


def _left_out(plan: Plan) -> tuple[OmittedOrder, ...]:
    return plan.fit.omitted_orders if plan.fit is not None else ()


def _speed_quantities(plan: Plan) -> list[Quantity]:
    speed, fit, left_out = plan.shaft.speed, plan.fit, _left_out(plan)
    errors = np.full((3, speed.count), np.nan)
    if fit is not None:
        errors[:, np.array(fit.orders) - 1] = [*np.split(fit.standard_errors[1:], 2), fit.amplitude_errors]
    speed_dimension, left_out_dimension, error = "speed_order", "left_out_order", "standard error of the"
    return [
        Quantity("speed_order", np.arange(1, speed.count + 1), "order of the speed", "", speed_dimension),
        Quantity("left_out_order", [o.order for o in left_out], "order of the speed left out", "", left_out_dimension),
        Quantity("speed_cosine", speed.cosine, "cosine coefficient of the speed", "rad/s", speed_dimension),
        Quantity("speed_sine", speed.sine, "sine coefficient of the speed", "rad/s", speed_dimension),
        Quantity("speed_amplitude", speed.amplitudes, "speed, amplitude", "rad/s", speed_dimension),
        Quantity("speed_cosine_error", errors[0], f"{error} cosine coefficient", "rad/s", speed_dimension),
        Quantity("speed_sine_error", errors[1], f"{error} sine coefficient", "rad/s", speed_dimension),
        Quantity("speed_error", errors[2], f"{error} amplitude", "rad/s", speed_dimension),
        Quantity(
            "left_out_amplitude", [o.amplitude for o in left_out], "speed left out, amplitude", "rad/s", left_out_dimension
        ),
        Quantity("left_out_error", [o.error for o in left_out], f"{error} amplitude left out", "rad/s", left_out_dimension),
    ]


def _contour_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    shape = (len(CAM_VERSIONS), len(plan.after))

    def curves(of: Callable[[Contour], np.ndarray]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours]).reshape(*shape, len(f.angles))

    def scalars(of: Callable[[Contour], float]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours], float).reshape(shape)

    def radius(of: Callable[[Shape], RadiusAt | None]) -> np.ndarray:
        return scalars(lambda c: math.nan if (radius_at := of(c.shape)) is None else radius_at.radius)

    places = [complex(cam.follower.place(cam.law(0.0))) for cam in plan.after.values()]
    radii = [math.nan if cam.roller_radius is None else cam.roller_radius for cam in plan.after.values()]
    roller = scalars(lambda c: c.shape.largest_roller or math.nan)
    dimensions, cam_dimensions = "version cam cam_angle", "version cam"
    return [
        Quantity("contour_x", curves(lambda c: c.points.real), "contour, x", "m", dimensions),
        Quantity("contour_y", curves(lambda c: c.points.imag), "contour, y", "m", dimensions),
        Quantity("normal_x", curves(lambda c: c.normals.real), "normal, x", "", dimensions),
        Quantity("normal_y", curves(lambda c: c.normals.imag), "normal, y", "", dimensions),
        Quantity("curvature", curves(lambda c: c.curvature), "curvature of the contour", "1/m", dimensions),
        Quantity("pressure_angle", curves(lambda c: c.pressure_angle), "pressure angle", "rad", dimensions),
        Quantity("uncut", curves(lambda c: c.uncut), "margin against undercut, 0 at an edge", "", dimensions),
        Quantity("moved", curves(lambda c: c.displacement)[1], "corrected contour, outwards", "m", "cam cam_angle"),
        Quantity("least_radius", radius(lambda s: s.convex), "least radius of curvature, convex", "m", cam_dimensions),
        Quantity("hollow_radius", radius(lambda s: s.hollow), "least radius of curvature, hollow", "m", cam_dimensions),
        Quantity("largest_roller", roller, "largest roller without undercut", "m", cam_dimensions),
        Quantity("base_radius", scalars(lambda c: c.shape.base.value), "least radius of the contour", "m", cam_dimensions),
        Quantity("common_pressure_angle", COMMON[plan.lever_unit], "usual upper limit of the pressure angle", "rad", ""),
        Quantity("follower_x", np.array([p.real for p in places], float), "roller or face at cam angle 0, x", "m", "cam"),
        Quantity("follower_y", np.array([p.imag for p in places], float), "roller or face at cam angle 0, y", "m", "cam"),
        Quantity("roller_radius", np.array(radii, float), "radius of the roller", "m", "cam"),
    ]


def _measurement_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    count, unit, no_orders = plan.shown_orders, f"{plan.unit}/s^2", FourierSeries.of(math.nan)
    comparison = plan.measurement.comparison if plan.measurement is not None else None
    measured_orders, computed_orders = (
        (comparison.measured_orders, comparison.computed_orders) if comparison is not None else (no_orders, no_orders)
    )
    over_time = measured_orders(f.tau) - measured_orders.mean if measured_orders.count else f.tau + math.nan
    return [
        Quantity("measured_acceleration", over_time, "measured acceleration, orders fitted", unit, "tau"),
        Quantity("sample_tau", f.samples[0], "time of a sample within a turn, as an angle", "rad", "sample"),
        Quantity("sample_acceleration", f.samples[1], "measured acceleration, samples", unit, "sample"),
        Quantity(
            "measured_amplitude", _pad_row(measured_orders.amplitudes, count), "measured acceleration, amplitude", unit, "order"
        ),
        Quantity(
            "computed_amplitude", _pad_row(computed_orders.amplitudes, count), "computed acceleration, amplitude", unit, "order"
        ),
    ]


def _summary_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    scale, shaft, purity = plan.shaft.mean**2, plan.shaft, plan.purity
    unit, contours, position = f"{plan.unit}/s^2", f.contours[1], "largest distance of the output from its law over time"
    count = max(plan.orders, purity.count or 0, plan.last_order)
    before, after = ((scale * s.amplitudes[:count]).tolist() for s in f.spectrum)
    shapes = [c.shape for c in contours.values()]
    recovered_shares, rounded_shares = (
        _shares(plan, {name: getattr(proof, of) for name, proof in f.proofs.items()}) for of in ("recovered", "rounded")
    )
    radius = min((s.convex.radius for s in shapes if s.convex is not None), default=None)
    angle = largest_pressure_angle(shapes).value if shapes else None
    return [
        Quantity("unit", plan.unit, "unit of the output"),
        Quantity("harmonics", purity.count, "number N of harmonics of the law"),
        Quantity("reference_order", purity.reference, "reference order of the comparison"),
        Quantity("orders_before", before, "amplitudes of the acceleration, original cam", unit),
        Quantity("orders_after", after, "amplitudes of the acceleration, corrected cam", unit),
        Quantity("before", f.deviation[0].orders, f"{purity.name}, original cam"),
        Quantity("after", f.deviation[1].orders, f"{purity.name}, corrected cam"),
        Quantity("position_error_before", f.deviation[0].position, f"{position}, original cam", plan.unit),
        Quantity("position_error_after", f.deviation[1].position, f"{position}, corrected cam", plan.unit),
        Quantity("recovered", recovered_shares, f"{purity.name}, from the points of the corrected cam"),
        Quantity("rounded", rounded_shares, f"{purity.name}, from these points rounded"),
        Quantity("points", plan.spec.points, "number of points of a contour"),
        Quantity("decimals", plan.spec.decimals, "decimals of rounded points"),
        Quantity("peak_before", float(np.abs(f.acceleration[0]).max()), "largest acceleration, original cam", unit),
        Quantity("peak_after", float(np.abs(f.acceleration[1]).max()), "largest acceleration, corrected cam", unit),
        *_dwell_quantities(plan, f),
        Quantity("mean_speed", shaft.mean, "mean speed of the camshaft", "rad/s"),
        Quantity("period", 2 * math.pi / shaft.mean, "period of a turn", "s"),
        Quantity("fluctuation", shaft.fluctuation, "fluctuation of the speed, as a share of its mean"),
        Quantity("min_speed", shaft.speed.bounds[0], "least speed of the camshaft", "rad/s"),
        Quantity("max_speed", shaft.speed.bounds[1], "greatest speed of the camshaft", "rad/s"),
        _record_group(plan, f),
        Quantity("min_curvature_radius", radius, "least radius of curvature of a corrected cam, convex", "m", headline=True),
        Quantity("max_pressure_angle", angle, "largest pressure angle of a corrected cam", "rad", headline=True),
        Quantity("undercut", False if contours else None, "true if a follower cuts off parts of a corrected contour"),
        group("contours", [_cam_group(plan, f, name) for name in contours], "sizes of each cam, original and corrected"),
        _comparison_group(plan),
    ]


def _dwell_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """Return how far the output is off its dwells over time, by its motion and along the circle of its arm."""
    arm, slides = plan.drive.output_arm, plan.unit == "m"
    quantities = [
        Quantity("dwells", [[d.begin, d.last] for d in plan.dwells], "arcs of tau on which the output is to rest", "rad")
    ]
    for version, name, error in zip(CAM_VERSIONS, ("before", "after"), f.dwell_errors, strict=True):
        factor = 1.0 if slides else arm
        travel = None if error is None or factor is None else factor * error
        quantities += [
            Quantity(f"dwell_error_{name}", error, f"largest position error in the dwell, {version} cam", plan.unit),
            Quantity(f"dwell_travel_{name}", travel, f"the same at the end of the output's arm, {version} cam", "m"),
        ]
    return [*quantities, Quantity("output_arm", arm, "length of the output's arm", "m")]


def _shares(plan: Plan, spectra: Mapping[str, FourierSeries | None]) -> dict[str, float]:
    return {name: _share_of_points(plan, series) for name, series in spectra.items() if series is not None}


def _record_group(plan: Plan, f: Findings) -> Quantity:
    description, fit = "orders fitted to the record", plan.fit
    if fit is None:
        return Quantity("record", None, description)
    of_left_out = {
        "amplitude": ("amplitude of the speed", "rad/s"),
        "error": ("standard error of the amplitude", "rad/s"),
    }
    left_out = [asdict(one) for one in f.left_out]
    numbers = [
        Quantity("orders", list(fit.orders), "orders fitted"),
        Quantity("turns", fit.turns, "number of turns"),
        Quantity("samples", fit.samples, "number of samples"),
        Quantity("explained", fit.explained_share, "explained share of the variance"),
        Quantity("residual_rms", fit.residual_rms, "root mean square of the residual", fit.unit),
        Quantity("unit", fit.unit, "unit of the record"),
        Quantity("mean_error", float(fit.standard_errors[0]), "standard error of the mean speed", "rad/s"),
        Quantity("zero", fit.origin, "time at which the first turn begins", "s"),
        Quantity("left_by_errors", f.from_errors, "residual due to the standard errors, as a share"),
        Quantity("left_by_left_out", residual_of_omitted_orders(f), "residual due to the orders left out, as a share"),
        Quantity("left_out", left_out, "orders left out", parts=of_left_out),
    ]
    return group("record", numbers, description)


def _cam_group(plan: Plan, f: Findings, name: str) -> Quantity:
    before, after = (by[name] for by in f.contours)
    missing = sum(end - begin for begin, end in before.shape.missing) / (2 * math.pi)
    numbers = [
        *(_size_group(version, c.shape) for version, c in zip(CAM_VERSIONS, (before, after), strict=True)),
        Quantity("moved", float(np.abs(after.displacement).max()), "largest displacement of the contour", "m"),
        Quantity("chord", after.chord, "largest distance of chords between points", "m"),
        Quantity("missing_before", missing, "share of a turn without a contour, original cam"),
        Quantity("roller_radius", plan.after[name].roller_radius, "radius of the roller", "m"),
    ]
    return group(name, numbers, "sizes of a cam")


def _size_group(version: str, shape: Shape) -> Quantity:
    def radius(key: str, at: RadiusAt | None, description: str) -> Quantity:
        return Quantity(key, None if at is None else at.radius, description, "m")

    numbers = [
        Quantity("max_pressure_angle", shape.pressure_angle.value, "largest pressure angle", "rad"),
        Quantity("max_pressure_angle_at", shape.pressure_angle.phi, "cam angle there", "rad"),
        Quantity("largest_roller", shape.largest_roller, "largest roller without undercut", "m"),
        radius("min_curvature_radius", shape.convex, "least radius of curvature, convex"),
        radius("min_hollow_radius", shape.hollow, "least radius of curvature, hollow"),
        radius("largest_wheel", shape.wheel, "largest grinding wheel"),
    ]
    return group(version, numbers, f"{version} cam")


def _comparison_group(plan: Plan) -> Quantity:
    description, unit, m = "measured acceleration, and the explained share", f"{plan.unit}/s^2", plan.measurement
    if m is None:
        return Quantity("measured", None, description)
    order_power = float((m.comparison.measured_orders.amplitudes**2).sum()) / 2
    delay, without = (None, None) if plan.delay is None else plan.delay
    record_share = explained_share(m, m.comparison.share)
    numbers = [
        Quantity("cam", m.cam, "cam of the measurement"),
        Quantity("explained", record_share, "explained share of the variance of the whole record"),
        Quantity("explained_orders", m.comparison.share, "explained share of the variance of the fitted orders"),
        Quantity("noise_rms", m.noise, "root mean square outside the fitted orders", unit),
        Quantity("rms", math.sqrt(order_power + m.noise**2), "root mean square of the record about its mean", unit),
        Quantity("turns", m.turns, "number of turns"),
        Quantity("orders", m.comparison.measured_orders.count, "number of orders fitted"),
        Quantity("zero", plan.zero, "time at which the cam angle is zero", "s"),
        Quantity("delay", delay, "delay against the computed motion, as an angle", "rad"),
        Quantity("explained_without_delay", without, "share of its orders explained without the delay"),
    ]
    return group("measured", numbers, description)
