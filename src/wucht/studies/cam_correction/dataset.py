"""Findings -> the Dataset of a cam's correction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.followers import FlatFaced
from wucht.numerics.harmonics import Harmonics
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.cam_correction.cleanliness import sentence
from wucht.studies.cam_correction.prepare import Plan
from wucht.studies.cam_correction.run import Contour, Findings

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
    corrected cam, and from these rounded as the list for the workshop. Of the speed: speed_cosine, speed_sine, speed_amplitude,
    speed_error (of a record).
    The cam table: output, output_velocity, output_acceleration, output_jerk (version, cam_angle), derivatives by the cam angle;
    likewise follower, which without a linkage is the same.
    Contours: contour_x, contour_y, normal_x, normal_y (away from the centre), curvature, pressure_angle, uncut (1: straight, 0:
    an edge) (version, cam, cam_angle); least_radius, hollow_radius, largest_roller, base_radius (version, cam); at cam angle 0
    follower_x, follower_y, roller_radius (cam; NaN of a flat face).
    share (residual). measured_acceleration (tau), measured_amplitude, computed_amplitude (order): NaN without a record.
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

    def by_cam(found: Mapping[str, Harmonics]) -> np.ndarray:
        none = Harmonics.of(0.0)
        rows = [_padded(scale * found.get(name, none).amplitudes, count) for name in plan.after]
        return np.array(rows).reshape(-1, count)

    along = "version order"
    return {
        "cosine": variable(along, both(lambda s: s.cosine), "cosine coefficient of the acceleration", unit),
        "sine": variable(along, both(lambda s: s.sine), "sine coefficient of the acceleration", unit),
        "amplitude": variable(along, both(lambda s: s.amplitudes), "acceleration, amplitude", unit),
        "recovered": variable("cam order", by_cam(f.recovered), "acceleration from the points, amplitude", unit),
        "rounded": variable("cam order", by_cam(f.rounded), "acceleration from rounded points, amplitude", unit),
    }


def _speed(plan: Plan) -> dict[str, Variable]:
    speed, errors = plan.shaft.speed, np.full(plan.shaft.speed.count, np.nan)
    if plan.fit is not None:
        errors[np.array(plan.fit.orders) - 1] = plan.fit.amplitude_errors
    along = "speed_order"
    return {
        "speed_cosine": variable(along, speed.cosine, "cosine coefficient of the speed", "rad/s"),
        "speed_sine": variable(along, speed.sine, "sine coefficient of the speed", "rad/s"),
        "speed_amplitude": variable(along, speed.amplitudes, "speed, amplitude", "rad/s"),
        "speed_error": variable(along, errors, "standard error of the amplitude", "rad/s"),
    }


def _contours(plan: Plan, f: Findings) -> dict[str, Variable]:
    shape = (len(VERSIONS), len(plan.after))

    def over_turn(of: Callable[[Contour], np.ndarray]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours]).reshape(*shape, len(f.angles))

    def once(of: Callable[[Contour], float]) -> np.ndarray:
        return np.array([[of(by[name]) for name in plan.after] for by in f.contours], float).reshape(shape)

    at = {name: (cam.law(0.0), cam.follower) for name, cam in plan.after.items()}
    places = [complex(fo.distance + float(s)) if isinstance(fo, FlatFaced) else complex(fo.place(s)) for s, fo in at.values()]
    radii = [math.nan if isinstance(fo, FlatFaced) else fo.roller_radius for _, fo in at.values()]
    along, each = "version cam cam_angle", "version cam"
    return {
        "contour_x": variable(along, over_turn(lambda c: c.points.real), "contour, x", "m"),
        "contour_y": variable(along, over_turn(lambda c: c.points.imag), "contour, y", "m"),
        "normal_x": variable(along, over_turn(lambda c: c.normals.real), "normal, x"),
        "normal_y": variable(along, over_turn(lambda c: c.normals.imag), "normal, y"),
        "curvature": variable(along, over_turn(lambda c: c.curvature), "curvature of the contour", "1/m"),
        "pressure_angle": variable(along, over_turn(lambda c: c.pressure_angle), "pressure angle", "rad"),
        "uncut": variable(along, over_turn(lambda c: c.uncut), "what the roller leaves, 0: an edge"),
        "least_radius": variable(each, once(lambda c: c.convex), "least radius of curvature, convex", "m"),
        "hollow_radius": variable(each, once(lambda c: c.hollow), "least radius of curvature, hollow", "m"),
        "largest_roller": variable(each, once(lambda c: c.largest_roller), "largest roller that cuts nothing away", "m"),
        "base_radius": variable(each, once(lambda c: float(np.abs(c.points).min())), "least radius of the contour", "m"),
        "follower_x": variable("cam", np.array([p.real for p in places], float), "roller or face at cam angle 0, x", "m"),
        "follower_y": variable("cam", np.array([p.imag for p in places], float), "roller or face at cam angle 0, y", "m"),
        "roller_radius": variable("cam", np.array(radii, float), "radius of the roller", "m"),
    }


def _measured(plan: Plan, f: Findings) -> dict[str, Variable]:
    count, unit, none = _count(plan), f"{plan.unit}/s^2", Harmonics.of(math.nan)
    comparison = plan.measured.comparison if plan.measured is not None else None
    seen, computed = (comparison.measured, comparison.computed) if comparison is not None else (none, none)
    return {
        "measured_acceleration": variable("tau", seen(f.tau) - seen.mean if seen.count else f.tau + math.nan,
                                          "measured acceleration, fitted", unit),
        "measured_amplitude": variable("order", _padded(seen.amplitudes, count), "measured acceleration, amplitude", unit),
        "computed_amplitude": variable("order", _padded(computed.amplitudes, count), "computed acceleration, amplitude", unit),
    }  # fmt: skip


def _summary(plan: Plan, f: Findings) -> dict[str, Any]:
    scale, shaft = plan.shaft.mean**2, plan.shaft
    shown = max(plan.orders, plan.purity.count or 0)
    rows = [(scale * s.amplitudes[:shown]).tolist() for s in f.spectrum]
    contours = f.contours[1]
    radii = [c.convex for c in contours.values() if math.isfinite(c.convex)]
    return {
        "sentence": sentence(plan, f),
        "unit": plan.unit,
        "harmonics": plan.purity.count,
        "reference_order": plan.purity.reference,
        "orders_before": rows[0],
        "orders_after": rows[1],
        "before": f.impurity[0],
        "after": f.impurity[1],
        "recovered": {name: plan.purity.share(found) for name, found in f.recovered.items()},
        "rounded": {name: plan.purity.share(found) for name, found in f.rounded.items()},
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
        "min_curvature_radius": min(radii, default=None),
        "max_pressure_angle": max((float(np.abs(c.pressure_angle).max()) for c in contours.values()), default=None),
        "undercut": False if contours else None,
        "contours": {name: _of_cam(plan, f, name) for name in contours},
        "measured": _comparison(plan),
    }


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
        "zero": fit.origin,
        "left_by_errors": f.from_errors,
    }


def _of_cam(plan: Plan, f: Findings, name: str) -> dict[str, Any]:
    before, after = (by[name] for by in f.contours)
    sizes = {
        key: [float(np.abs(c.pressure_angle).max()), c.convex, c.hollow, c.largest_roller]
        for key, c in zip(VERSIONS, (before, after), strict=True)
    }
    names = ("max_pressure_angle", "min_curvature_radius", "min_hollow_radius", "largest_roller")
    found = {key: dict(zip(names, values, strict=True)) for key, values in sizes.items()}
    radius = getattr(plan.after[name].follower, "roller_radius", None)
    return {**found, "moved": after.moved, "chord": after.chord, "missing_before": before.missing, "roller_radius": radius}


def _comparison(plan: Plan) -> dict[str, Any] | None:
    m = plan.measured
    if m is None:
        return None
    return {"cam": m.cam, "explained": m.comparison.share, "noise_rms": m.noise, "turns": m.turns,
            "orders": m.comparison.measured.count}  # fmt: skip
