"""Findings -> the Dataset of a cam's correction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.shape import COMMON, Shape, largest_pressure_angle
from wucht.cams.undercut import RadiusAt
from wucht.measurements.order_residual import LeftOutOrder
from wucht.numerics.harmonics import Harmonics
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.cam_correction.cleanliness import left_by_left_out, sentence
from wucht.studies.cam_correction.prepare import Plan, explained
from wucht.studies.cam_correction.run import Contour, Findings, Proof

if TYPE_CHECKING:
    import xarray as xr

_NAMES = ("", "_velocity", "_acceleration", "_jerk")
_PER = ("", "/rad", "/rad^2", "/rad^3")
VERSIONS = ("original", "corrected")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a correction. The unit of the output is rad or m; contours in the plane that turns with the cam.

    Coordinates: version (``original``, ``corrected``: the cam), tau (T, time as an angle), cam_angle (N), order (K, from 1),
    speed_order (from 1), cam (``cam``, ``counter``, ``outer``; without a follower none), residual (in words).
    Over tau: time, shaft_angle, shaft_speed; output_over_time, acceleration (version, tau).
    Of the acceleration: cosine, sine, amplitude (version, order); recovered, rounded (cam, order): from the points of the
    corrected cam, and from these rounded as the list for the workshop. Of the speed: speed_cosine, speed_sine, speed_amplitude;
    of a record their standard errors speed_cosine_error, speed_sine_error, speed_error, and the orders that are not corrected
    for, left_out_amplitude, left_out_error (left_out_order).
    The cam table: output, output_velocity, output_acceleration, output_jerk (version, cam_angle), derivatives by the cam angle;
    likewise follower, which without a linkage is the same.
    Contours: contour_x, contour_y, normal_x, normal_y (away from the centre), curvature, pressure_angle, uncut (1: straight, 0:
    an edge) (version, cam, cam_angle); moved (cam, cam_angle): the corrected contour, outwards from the original one;
    least_radius, hollow_radius, largest_roller, base_radius (version, cam); at cam angle 0 follower_x, follower_y,
    roller_radius (cam; NaN of a flat face); common_pressure_angle.
    share (residual). measured_acceleration (tau): of the orders fitted; sample_tau, sample_acceleration (sample): some of the
    record's samples; measured_amplitude, computed_amplitude (order). NaN, or no samples, without a record.
    """
    import xarray as xr_

    f, u = findings, plan.unit
    pairs = "version tau"
    data = {
        "time": variable("tau", f.tau / plan.shaft.mean, "time", "s"),
        "shaft_angle": variable("tau", plan.shaft.angle(f.tau), "angle of the camshaft", "rad"),
        "shaft_speed": variable("tau", plan.shaft.speed(f.tau), "speed of the camshaft", "rad/s"),
        "output_over_time": variable(pairs, f.output, "motion of the output", u),
        "acceleration": variable(pairs, f.acceleration, "acceleration of the output", f"{u}/s^2"),
        "share": variable("residual", [r.share for r in f.residuals], "what is left, as a share"),
        **_tables(plan, f),
        **_orders(plan, f),
        **_speed(plan),
        **_contours(plan, f),
        **_measured(plan, f),
    }
    coordinates = {
        "version": variable("version", list(VERSIONS), "cam"),
        "tau": variable("tau", f.tau, "time as an angle, omega t", "rad"),
        "cam_angle": variable("cam_angle", f.angles, "cam angle", "rad"),
        "order": variable("order", np.arange(1, _count(plan) + 1), "order"),
        "speed_order": variable("speed_order", np.arange(1, plan.shaft.speed.count + 1), "order of the speed"),
        "left_out_order": variable("left_out_order", [o.order for o in _left_out(plan)], "order of the speed left out"),
        "cam": variable("cam", np.array(list(plan.after), dtype=str), "cam"),
        "residual": variable("residual", [r.what for r in f.residuals], "what is not as the cam was made for"),
    }
    summary = _summary(plan, findings)
    return answered(xr_.Dataset(dict(data), coords=coordinates), summary, summary["sentence"], findings.notes)


def _count(plan: Plan) -> int:
    """The orders in the Dataset: those shown, and all that are measured."""
    return max(plan.orders, plan.measured.comparison.measured.count if plan.measured is not None else 0)


def _padded(values: np.ndarray, count: int) -> np.ndarray:
    return np.append(values[:count], np.full(max(0, count - len(values)), np.nan))


def _tables(plan: Plan, f: Findings) -> dict[str, Variable]:
    made = (
        ("output", plan.unit, "motion of the output", f.table),
        ("follower", plan.lever_unit, "motion of the follower", f.lever),
    )
    return {
        name + suffix: variable("version cam_angle", [t[k] for t in both], what + suffix.replace("_", ", "), unit + _PER[k])
        for name, unit, what, both in made
        for k, suffix in enumerate(_NAMES)
    }


def _orders(plan: Plan, f: Findings) -> dict[str, Variable]:
    count, scale, unit = _count(plan), plan.shaft.mean**2, f"{plan.unit}/s^2"

    def both(of: Callable[[Harmonics], np.ndarray]) -> list[np.ndarray]:
        return [_padded(scale * of(series), count) for series in f.spectrum]

    def by_cam(of: Callable[[Proof], Harmonics | None]) -> np.ndarray:
        rows = [_padded(scale * (of(proof) or Harmonics.of(0.0)).amplitudes, count) for proof in f.proofs.values()]
        return np.array(rows).reshape(-1, count)

    along = "version order"
    return {
        "cosine": variable(along, both(lambda s: s.cosine), "cosine coefficient of the acceleration", unit),
        "sine": variable(along, both(lambda s: s.sine), "sine coefficient of the acceleration", unit),
        "amplitude": variable(along, both(lambda s: s.amplitudes), "acceleration, amplitude", unit),
        "recovered": variable("cam order", by_cam(lambda p: p.recovered), "acceleration from the points, amplitude", unit),
        "rounded": variable("cam order", by_cam(lambda p: p.rounded), "acceleration from rounded points, amplitude", unit),
    }


def _left_out(plan: Plan) -> tuple[LeftOutOrder, ...]:
    return plan.fit.left_out if plan.fit is not None else ()


def _speed(plan: Plan) -> dict[str, Variable]:
    speed, fit, left = plan.shaft.speed, plan.fit, _left_out(plan)
    errors = np.full((3, speed.count), np.nan)
    if fit is not None:
        errors[:, np.array(fit.orders) - 1] = [*np.split(fit.standard_errors[1:], 2), fit.amplitude_errors]
    along, others, error = "speed_order", "left_out_order", "standard error of the"
    return {
        "speed_cosine": variable(along, speed.cosine, "cosine coefficient of the speed", "rad/s"),
        "speed_sine": variable(along, speed.sine, "sine coefficient of the speed", "rad/s"),
        "speed_amplitude": variable(along, speed.amplitudes, "speed, amplitude", "rad/s"),
        "speed_cosine_error": variable(along, errors[0], f"{error} cosine coefficient", "rad/s"),
        "speed_sine_error": variable(along, errors[1], f"{error} sine coefficient", "rad/s"),
        "speed_error": variable(along, errors[2], f"{error} amplitude", "rad/s"),
        "left_out_amplitude": variable(others, [o.amplitude for o in left], "speed left out, amplitude", "rad/s"),
        "left_out_error": variable(others, [o.error for o in left], f"{error} amplitude left out", "rad/s"),
    }


def _contours(plan: Plan, f: Findings) -> dict[str, Variable]:
    shape = (len(VERSIONS), len(plan.after))

    def over_turn(of: Callable[[Contour], np.ndarray]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours]).reshape(*shape, len(f.angles))

    def once(of: Callable[[Contour], float]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours], float).reshape(shape)

    def radius(of: Callable[[Shape], RadiusAt | None]) -> np.ndarray:
        return once(lambda c: math.nan if (found := of(c.shape)) is None else found.radius)

    places = [complex(cam.follower.place(cam.law(0.0))) for cam in plan.after.values()]
    radii = [math.nan if cam.roller_radius is None else cam.roller_radius for cam in plan.after.values()]
    along, each = "version cam cam_angle", "version cam"
    return {
        "contour_x": variable(along, over_turn(lambda c: c.points.real), "contour, x", "m"),
        "contour_y": variable(along, over_turn(lambda c: c.points.imag), "contour, y", "m"),
        "normal_x": variable(along, over_turn(lambda c: c.normals.real), "normal, x"),
        "normal_y": variable(along, over_turn(lambda c: c.normals.imag), "normal, y"),
        "curvature": variable(along, over_turn(lambda c: c.curvature), "curvature of the contour", "1/m"),
        "pressure_angle": variable(along, over_turn(lambda c: c.pressure_angle), "pressure angle", "rad"),
        "uncut": variable(along, over_turn(lambda c: c.uncut), "what the roller leaves, 0: an edge"),
        "moved": variable("cam cam_angle", over_turn(lambda c: c.moved)[1], "corrected contour, outwards", "m"),
        "least_radius": variable(each, radius(lambda s: s.convex), "least radius of curvature, convex", "m"),
        "hollow_radius": variable(each, radius(lambda s: s.hollow), "least radius of curvature, hollow", "m"),
        "largest_roller": variable(
            each, once(lambda c: c.shape.largest_roller or math.nan), "largest roller that cuts nothing away", "m"
        ),
        "base_radius": variable(each, once(lambda c: c.shape.base.value), "least radius of the contour", "m"),
        "common_pressure_angle": variable("", COMMON[plan.lever_unit], "common pressure angle, at most", "rad"),
        "follower_x": variable("cam", np.array([p.real for p in places], float), "roller or face at cam angle 0, x", "m"),
        "follower_y": variable("cam", np.array([p.imag for p in places], float), "roller or face at cam angle 0, y", "m"),
        "roller_radius": variable("cam", np.array(radii, float), "radius of the roller", "m"),
    }


def _measured(plan: Plan, f: Findings) -> dict[str, Variable]:
    count, unit, none = _count(plan), f"{plan.unit}/s^2", Harmonics.of(math.nan)
    comparison = plan.measured.comparison if plan.measured is not None else None
    seen, computed = (comparison.measured, comparison.computed) if comparison is not None else (none, none)
    over_time = seen(f.tau) - seen.mean if seen.count else f.tau + math.nan
    return {
        "measured_acceleration": variable("tau", over_time, "measured acceleration, orders fitted", unit),
        "sample_tau": variable("sample", f.samples[0], "time of a sample within a turn, as an angle", "rad"),
        "sample_acceleration": variable("sample", f.samples[1], "measured acceleration, samples", unit),
        "measured_amplitude": variable("order", _padded(seen.amplitudes, count), "measured acceleration, amplitude", unit),
        "computed_amplitude": variable("order", _padded(computed.amplitudes, count), "computed acceleration, amplitude", unit),
    }


def _summary(plan: Plan, f: Findings) -> dict[str, Any]:
    scale, shaft = plan.shaft.mean**2, plan.shaft
    shown = max(plan.orders, plan.purity.count or 0)
    rows = [(scale * s.amplitudes[:shown]).tolist() for s in f.spectrum]
    contours = f.contours[1]
    found = [c.shape for c in contours.values()]
    return {
        "sentence": sentence(plan, f),
        "unit": plan.unit,
        "harmonics": plan.purity.count,
        "reference_order": plan.purity.reference,
        "orders_before": rows[0],
        "orders_after": rows[1],
        "before": f.impurity[0],
        "after": f.impurity[1],
        "recovered": _shares(plan, {name: proof.recovered for name, proof in f.proofs.items()}),
        "rounded": _shares(plan, {name: proof.rounded for name, proof in f.proofs.items()}),
        "points": plan.spec.points,
        "decimals": plan.spec.decimals,
        "peak_before": float(np.abs(f.acceleration[0]).max()),
        "peak_after": float(np.abs(f.acceleration[1]).max()),
        "mean_speed": shaft.mean,
        "period": 2 * math.pi / shaft.mean,
        "fluctuation": shaft.fluctuation,
        "min_speed": shaft.speed.bounds[0],
        "max_speed": shaft.speed.bounds[1],
        "residuals": [{"what": r.what, "share": r.share} for r in f.residuals],
        "record": _record(plan, f),
        "min_curvature_radius": min((s.convex.radius for s in found if s.convex is not None), default=None),
        "max_pressure_angle": largest_pressure_angle(found).value if found else None,
        "undercut": False if contours else None,
        "contours": {name: _of_cam(plan, f, name) for name in contours},
        "measured": _comparison(plan),
    }


def _shares(plan: Plan, found: Mapping[str, Harmonics | None]) -> dict[str, float]:
    return {name: plan.purity.share(series) for name, series in found.items() if series is not None}


def _record(plan: Plan, f: Findings) -> dict[str, Any] | None:
    fit = plan.fit
    if fit is None:
        return None
    return {
        "orders": list(fit.orders),
        "turns": fit.turns,
        "samples": fit.samples,
        "explained": fit.explained,
        "residual_rms": fit.residual_rms,
        "unit": fit.unit,
        "mean_error": float(fit.standard_errors[0]),
        "zero": fit.origin,
        "left_by_errors": f.from_errors,
        "left_by_left_out": left_by_left_out(f),
        "left_out": [asdict(one) for one in f.left_out],
    }


def _of_cam(plan: Plan, f: Findings, name: str) -> dict[str, Any]:
    before, after = (by[name] for by in f.contours)
    sizes = {key: _size(c.shape) for key, c in zip(VERSIONS, (before, after), strict=True)}
    missing = sum(end - begin for begin, end in before.shape.missing) / (2 * math.pi)
    moved = float(np.abs(after.moved).max())
    return {
        **sizes,
        "moved": moved,
        "chord": after.chord,
        "missing_before": missing,
        "roller_radius": plan.after[name].roller_radius,
    }


def _size(shape: Shape) -> dict[str, float | None]:
    radii = {"min_curvature_radius": shape.convex, "min_hollow_radius": shape.hollow, "largest_wheel": shape.wheel}
    return {
        "max_pressure_angle": shape.pressure_angle.value,
        "max_pressure_angle_at": shape.pressure_angle.phi,
        "largest_roller": shape.largest_roller,
        **{key: None if at is None else at.radius for key, at in radii.items()},
    }


def _comparison(plan: Plan) -> dict[str, Any] | None:
    """explained: of the whole record about its mean, explained_orders: of the orders that are fitted."""
    m = plan.measured
    if m is None:
        return None
    of_orders = float((m.comparison.measured.amplitudes**2).sum()) / 2
    delay, without = (None, None) if plan.delay is None else plan.delay
    return {
        "cam": m.cam,
        "explained": explained(m, m.comparison.share),
        "explained_orders": m.comparison.share,
        "noise_rms": m.noise,
        "rms": math.sqrt(of_orders + m.noise**2),
        "turns": m.turns,
        "orders": m.comparison.measured.count,
        "zero": plan.zero,
        "delay": delay,
        "explained_without_delay": without,
    }
