"""Findings -> the quantities of a failure and its detection, and its lines in a report."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.exciters.speed_readings import UNSTABLE, Readings
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, StudyResult
from wucht.studies.failure_detection.computation import Findings, ParameterAxis, Plan
from wucht.studies.failure_detection.parameter_points import (
    NEAR,
    ParameterPoint,
    best_index,
    cliff_at,
    neighbours_of,
    safe_index,
)

if TYPE_CHECKING:
    import xarray as xr

_HOUR = 3600.0  # s
_ENERGY_TOLERANCE = 1e-6  # a larger energy residual is reported as a warning
_SPEED_TOLERANCE = 0.05  # of the speed: a larger difference of the averaged equations is reported
_SIGNAL = "change of speed over standard deviation of the readings"
_ALARM_PROBABILITIES = (0.5, 0.95)
_POINT_KEYS = ("signal", "change", "outcome", "neighbours", "cliff")
_FALSE_ALARM_SHARE = 0.5  # of the time between false alarms: a later mean alarm is not distinguishable from a false one


def duration_in_words(time: float, unit: str) -> str:
    """Return a time in its unit, from an hour on in hours too: ``5770 s (1.6 h)``."""
    hours = f" ({time / _HOUR:.3g} h)" if unit == "s" and abs(time) >= _HOUR else ""
    return f"{float(f'{time:.4g}'):g} {unit}".rstrip() + hours  # 17260, not 1.726e+04


def readings_in_words(readings: int, time: float, unit: str) -> str:
    """Return the observed span in words: ``within 5,080 readings, 2540 s``."""
    return f"within {readings:,} readings, {duration_in_words(time, unit)}"


def delay_origin(failure_time: float | None) -> str:
    """Return the event from which a delay counts, in words."""
    return "the failure" if failure_time is not None else "the chart begins"


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a failure."""
    quantities = [
        *_run_quantities(plan, findings),
        *_reading_quantities(plan, findings),
        *_speed_quantities(plan, findings),
        *_detection_quantities(plan, findings),
        *_point_quantities(plan, findings.points),
        *_largest_signal(plan, findings.points),
    ]
    draft, run = StudyResult(quantities, ""), findings.nominal_run.run
    s = draft.summary
    return replace(
        draft, sentence=_sentence(s, plan) + _largest_clause(plan, s), warnings=_warnings(plan, findings, s),
        failure=run.failure, attributes={"outcome": str(run.verdict.outcome), "signal": plan.signal.name},
    ).to_dataset()  # fmt: skip


def _run_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the stiffness and the damage over the run, and at its end."""
    course, units, damage = findings.nominal_run.run.course, plan.machine.units, findings.nominal_run.run.state.damage
    failure_time, residual, work = findings.nominal_run.windows.failure_time, course.residual, "work of the changing stiffness"
    return [
        Quantity("time", course.time, "time", units.time, "sample", coordinate=True),
        Quantity("stiffness", course.stiffness, "share of the stiffness", "", "sample"),
        Quantity("damage", course.damage, "damage", "", "sample"),
        Quantity("energy_residual", residual, "residual of the energy balance", "", "sample"),
        Quantity("stiffness_work", course.work, work, units.energy, "sample"),
        Quantity("failure_time", failure_time, "time of the failure", units.time, "", in_summary=True),
        Quantity("damage", None if damage is None else damage.total, "damage at the end"),
        Quantity("stiffness", float(course.stiffness[-1]), "remaining share of the stiffness at the end"),
        Quantity("stiffness_work", float(course.work[-1]), f"{work}, total", units.energy),
        Quantity("energy_residual", float(residual.max()), "largest residual of the energy balance"),
    ]


def _reading_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the readings of the sensor, and the limits of the load between two readings."""
    course, readings, sensor = findings.nominal_run.run.course, findings.nominal_run.readings, plan.spec.sensor
    noise = np.random.default_rng(sensor.seed).normal(0.0, sensor.noise, len(readings.speed))
    time, speed, load, unit = plan.machine.units.time, plan.machine.units.speed, plan.signal.name, plan.signal.unit
    return [
        Quantity("reading_time", readings.time, "time", time, "reading", coordinate=True),
        Quantity("speed", readings.speed, "mean speed of the main rotor", speed, "reading"),
        Quantity("reading", readings.speed + noise, "reading of the sensor", speed, "reading"),
        Quantity("highest", _reading_extremes(np.fmax, course.highest, readings), f"largest {load}", unit, "reading"),
        Quantity("lowest", _reading_extremes(np.fmin, course.lowest, readings), f"smallest {load}", unit, "reading"),
        Quantity("deviation", readings.deviation(sensor.noise), "standard deviation of the readings", speed),
        Quantity("signal", readings.signal(sensor.noise), _SIGNAL),
    ]


def _speed_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the speeds before and after the failure, and those of the averaged equations."""
    run, readings, unit, averaged_speeds = (
        findings.nominal_run.run,
        findings.nominal_run.readings,
        plan.machine.units.speed,
        findings.averaged_speeds,
    )
    before, after = (None, None) if averaged_speeds is None else (a.speed for a in averaged_speeds)
    kinds = None if averaged_speeds is None else [a.kind for a in averaged_speeds]
    averaged_numbers = {"before": before, "after": after, "change": _change(before, after), "kinds": kinds}
    outcomes = None if run.verdict_before is None else str(run.verdict_before.outcome), str(run.verdict.outcome)
    parts = {"speed": ("mean speed of the main rotor", unit), "outcome": ("outcome", "")}
    speeds = {
        "before": ("before the failure", unit), "after": ("after the failure", unit), "change": ("change", unit),
        "kinds": ("kinds of the steady motions before and after the failure", ""),
    }  # fmt: skip
    return [
        Quantity("before", {"speed": readings.before, "outcome": outcomes[0]}, "motion before the failure", parts=parts),
        Quantity("after", {"speed": readings.after, "outcome": outcomes[1]}, "motion after the failure", parts=parts),
        Quantity("change", _change(readings.before, readings.after), "change of speed", unit),
        Quantity("averaged", averaged_numbers, "mean speeds by the averaged equations", parts=speeds),
    ]


def _change(before: float | None, after: float | None) -> float | None:
    return None if before is None or after is None else after - before


def _detection_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the control chart of the speed, and the delay of its alarm."""
    detection, time, speed = findings.detection, plan.machine.units.time, plan.machine.units.speed
    parts = {
        "mean": ("mean speed before the failure", speed),
        "reference": ("reference value subtracted from each reading", speed),
        "threshold": ("cumulative sum at which it gives an alarm", speed),
    }
    of_delay = {
        "mean": ("mean time", time), "half": ("time within which half of the failures are detected", time),
        "nearly_all": ("time within which 95 % are detected", time), "horizon": ("horizon of this computation", time),
        "readings": ("number of readings in that time", ""), "probability": ("probability of an alarm in that time", ""),
    }  # fmt: skip
    chart, delay, curve = None, None, list[Quantity]()
    if detection is not None:
        after, probability = detection.curve()
        chart = {"mean": detection.learnt, "reference": detection.chart.reference, "threshold": detection.chart.threshold}
        delay = {
            "mean": detection.mean, "half": detection.quantile(_ALARM_PROBABILITIES[0]),
            "nearly_all": detection.quantile(_ALARM_PROBABILITIES[1]),
            "horizon": detection.horizon, "readings": detection.readings, "probability": float(probability[-1]),
        }  # fmt: skip
        since = delay_origin(findings.nominal_run.windows.failure_time)
        curve = [
            Quantity("alarm_time", after, f"time since {since}", time, "alarm"),
            Quantity("seen", probability, "probability that the failure has been detected", "", "alarm"),
        ]
    return [
        Quantity("chart", chart, "chart of cumulative sums", parts=parts),
        Quantity("delay", delay, "time until the chart gives an alarm", parts=of_delay),
        *curve,
    ]


def _reading_extremes(extreme: np.ufunc, samples: np.ndarray, readings: Readings) -> np.ndarray:
    """Return the extreme over each reading (n,) of values since the previous sample (N,)."""
    count = len(readings.speed)
    every = (len(samples) - 1) // max(count, 1)
    return np.asarray(extreme.reduce(samples[1 : 1 + count * every].reshape(count, every), axis=1, initial=np.nan))


def _point_quantities(plan: Plan, points: tuple[ParameterPoint, ...]) -> list[Quantity]:
    """Return the signal and the change of speed at other values: on the grid, for one parameter in its order."""
    if plan.along is None or not points:
        return []
    if plan.second is None:
        axes, dimensions = [np.array([p.values[0] for p in points])], "along"
    else:
        axes, dimensions = [np.array(plan.along.values), np.array(plan.second.values)], "along second"
    signal, change = (np.full([len(a) for a in axes], np.nan) for _ in range(2))
    for point in points:
        at = tuple(int(np.flatnonzero(a == v)[0]) for a, v in zip(axes, point.values, strict=True))
        if point.signal is not None and point.before is not None and point.after is not None:
            signal[at], change[at] = point.signal, point.after - point.before
    labelled_axes = zip(dimensions.split(), axes, (v.parameter for v in _parameter_axes(plan)), strict=True)
    return [
        *(Quantity(name, axis, parameter.path, parameter.unit, name) for name, axis, parameter in labelled_axes),
        Quantity("signal", signal, _SIGNAL, "", dimensions),
        Quantity("change", change, "change of speed", plan.machine.units.speed, dimensions),
    ]


def _parameter_axes(plan: Plan) -> list[ParameterAxis]:
    return [v for v in (plan.along, plan.second) if v is not None]


def _largest_signal(plan: Plan, points: tuple[ParameterPoint, ...]) -> list[Quantity]:
    """Return the point with the largest signal, its neighbours and its cliff, and the best point away from cliffs."""
    axes = {v.parameter.path: (v.parameter.path, v.parameter.unit) for v in _parameter_axes(plan)}
    of_point = axes | {
        "signal": (_SIGNAL, ""), "change": ("change of speed", plan.machine.units.speed), "outcome": ("outcome", ""),
        "neighbours": ("neighbours of it", ""), "cliff": ("nearest value at which less than half of the signal is left", ""),
    }  # fmt: skip
    best = best_index(points)
    safe = None if best is None else safe_index(points, list(axes))
    rows = [None if k is None else _point_row(points, k, list(axes)) for k in (best, safe)]
    return [
        Quantity("largest", rows[0], "other values with the largest signal", parts=of_point),
        Quantity("largest_safe", rows[1], f"the same, at least {100 * NEAR:g} % from a cliff", parts=of_point),
    ]


def _point_row(points: tuple[ParameterPoint, ...], k: int, paths: list[str]) -> dict[str, Any]:
    """Return a point, the neighbours with which it is compared, and its nearest cliff."""
    point, cliff = points[k], cliff_at(points, k, paths)
    beside = [points[indices[0]] for _, indices in neighbours_of(points, k) if indices]

    def values_of(one: ParameterPoint) -> dict[str, Any]:
        return dict(zip(paths, one.values, strict=True))

    return values_of(point) | {
        "signal": point.signal, "change": _change(point.before, point.after), "outcome": point.outcome,
        "neighbours": [values_of(p) | {"signal": p.signal} for p in beside],
        "cliff": None if cliff is None else {
            "parameter": cliff.parameter, "value": cliff.value, "distance": cliff.distance, "inside": cliff.inside,
            "signal": 1 / cliff.cost,
        },
    }  # fmt: skip


def _largest_clause(plan: Plan, s: dict[str, Any]) -> str:
    """Return where the signal is largest, and how near its cliff is."""
    if (largest := s["largest"]) is None:
        return ""
    at = ", ".join(f"{v.parameter.path} = {largest[v.parameter.path]:.4g}" for v in _parameter_axes(plan))
    present = "" if s["signal"] is None else f" ({s['signal']:.3g} as it is)"
    clause = f"; the signal is largest, {largest['signal']:.3g}{present}, at {at}"
    if (cliff := largest["cliff"]) is None:
        return clause
    side = "below" if cliff["distance"] < 0 else "above"
    return f"{clause}, and {100 * abs(cliff['distance']):.2g} % {side} that {cliff['signal']:.3g}"


def _cliff_warning(plan: Plan, s: dict[str, Any]) -> list[str]:
    """Return a warning where the largest signal lies at a cliff, with the best value away from it."""
    largest, safe = s["largest"], s["largest_safe"]
    if largest is None or largest["cliff"] is None or abs(largest["cliff"]["distance"]) >= NEAR:
        return []
    cliff, units = largest["cliff"], {v.parameter.path: v.parameter.unit for v in _parameter_axes(plan)}
    path, unit = cliff["parameter"], units[cliff["parameter"]]
    side = "below" if cliff["distance"] < 0 else "above"
    warning = (
        f"the largest signal, {largest['signal']:.3g} at {path} = {largest[path]:.5g} {unit}".rstrip()
        + f", lies at a cliff: {100 * abs(cliff['distance']):.2g} % {side}, at {cliff['value']:.5g} {unit}".rstrip()
        + f", it is {cliff['signal']:.3g}"
    )
    if safe is None:
        return [warning]
    at = ", ".join(f"{p} = {safe[p]:.5g} {u}".rstrip() for p, u in units.items())
    return [f"{warning}; at least {100 * NEAR:g} % away from it {at} is best, {safe['signal']:.3g}"]


def _sentence(s: dict[str, Any], plan: Plan) -> str:
    units = plan.machine.units
    if s["failure_time"] is None:
        failure_clause = "the specimen does not fail" + (f": damage {s['damage']:.4g}" if s["damage"] is not None else "")
        if s["change"] is None:
            return failure_clause
    else:
        failure_clause = f"the specimen fails at {s['failure_time']:.6g} {units.time}".rstrip()
    if s["change"] is None:
        return f"{failure_clause}; there are too few readings to determine the change of speed"
    change_clause = f"{failure_clause}, the speed changes by {s['change']:.4g} {units.speed}".rstrip()
    if s["delay"] is None:
        return f"{change_clause}; no control chart monitors it"
    delay = s["delay"]
    if (mean := delay["mean"]) is None:
        horizon = readings_in_words(delay["readings"], delay["horizon"], units.time)
        return f"{change_clause}, which is detected {horizon} with a probability of {delay['probability']:.3g}"
    delay_clause = duration_in_words(abs(mean), units.time) + (" later" if mean >= 0 else " before it")
    if s["failure_time"] is None:
        delay_clause = f"{duration_in_words(mean, units.time)} after {delay_origin(s['failure_time'])}"
    return f"{change_clause}, which is detected {delay_clause} on average"


def _warnings(plan: Plan, findings: Findings, s: dict[str, Any]) -> list[str]:
    nominal_run = findings.nominal_run
    warnings = [*plan.case.horizon.warnings, *plan.case.models[0].warnings]
    warnings = [w for w in warnings if "samples a turn are stored" not in w]  # no samples are stored here
    warnings += [nominal_run.run.failure] if nominal_run.run.failure else []
    if s["failure_time"] is None and not nominal_run.run.failure:
        warnings.append("the specimen does not fail within study.until: run longer, or give it a shorter life (a smaller ND)")
    elif s["change"] is None and not nominal_run.run.failure:
        warnings.append("there are too few readings before or after the failure: run longer, or let the specimen fail later")
    if s["energy_residual"] > _ENERGY_TOLERANCE:
        warnings.append(f"the energy balance closes only to {s['energy_residual']:.1e}: the run is not accurate")
    if findings.no_detection:
        warnings.append(f"there is no control chart: {findings.no_detection}")
    if s["chart"] is not None and s["change"] is not None and abs(s["change"]) < 2 * s["chart"]["reference"]:
        warnings.append(
            f"the chart is designed for changes of {2 * s['chart']['reference']:.3g}, and this one is smaller: a smaller "
            "study.sensor.change detects it sooner"
        )
    if s["delay"] is not None and (s["delay"]["mean"] or 0.0) > _FALSE_ALARM_SHARE * plan.spec.sensor.false_alarm_every:
        warnings.append("an alarm comes hardly any sooner than a false one: the chart does not detect this failure")
    if nominal_run.run.verdict.advice and s["change"] is not None:
        warnings.append(f"after the failure {nominal_run.run.verdict.advice}")
    warnings += _cliff_warning(plan, s)
    for period, averaged_speed in zip(("before", "after"), findings.averaged_speeds or (), strict=False):
        speed = s[period]["speed"]
        if averaged_speed.speed is None:
            warnings.append(f"the averaged equations give no speed {period} the failure: {averaged_speed.reason}")
        elif averaged_speed.kind == UNSTABLE:
            stable_clause = (
                "" if averaged_speed.next_stable is None else f"; the nearest stable one has {averaged_speed.next_stable:.5g}"
            )
            warnings.append(
                f"the steady state {period} the failure is unstable: the run stays there because nothing disturbs it, but a "
                f"machine would not{stable_clause}. This happens with identical bodies: make one of them slightly different"
            )
        elif abs(averaged_speed.speed - speed) > _SPEED_TOLERANCE * abs(speed):
            warnings.append(
                f"the averaged equations have {averaged_speed.speed:.5g} {period} the failure, the full "
                f"ones {speed:.5g}: the speed is "
                "still changing, the averaged motion is a different one, or the averaging is too coarse"
            )
    return warnings


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a failure."""
    s, lines = result.wucht.summary, ReportLines(result)
    for name in ("before", "after"):
        averaged_clause = "" if s["averaged"][name] is None else f"; averaged equations {{averaged.{name}:.6g}}"
        lines.add(name, f"{{{name}.speed:.6g}}, {s[name]['outcome'] or 'not classified'}{averaged_clause}")
    spread = "{signal:.4g} times the standard deviation of the readings, {deviation:.4g}"
    lines.add("change", "{change:.5g}, " + spread)
    if s["chart"] is not None:
        lines.add("chart", f"cumulative sum, k = {s['chart']['reference']:.4g}, h = {{chart.threshold:.4g}}")
        delay, alarm, unit = s["delay"], result["alarm_time"], result["time"].attrs["units"]
        horizon, mean = readings_in_words(alarm.size, float(alarm[-1]), unit), "not with certainty"
        if delay["mean"] is not None:
            mean = f"{duration_in_words(delay['mean'], unit)} after {delay_origin(s['failure_time'])} on average"
        lines.add("detection", f"{mean}; {_detection_times(delay, horizon, unit)}")
    lines.add("damage", "{damage:.5g} at the end")
    lines.add("stiffness", "{stiffness:.4g} of the intact specimen's at the end, its work {stiffness_work:.4g}")
    lines.add("energy", "closes to {energy_residual:.1e}")
    if s["largest"] is not None:
        at = [f"{path} = {x:.5g}" for path, x in s["largest"].items() if path not in _POINT_KEYS]
        there = "change {largest.change:.5g}, then {largest.outcome}"
        lines.add("largest", "signal {largest.signal:.4g} at {at}: " + there, at=", ".join(at))
    return lines.report(result.wucht.sentence)


def _detection_times(delay: dict[str, float | None], horizon: str, unit: str) -> str:
    """Return the times within which half, and nearly all, failures are detected. horizon: of this computation, in words."""
    words = (("half", "half of them"), ("nearly_all", "19 of 20"))
    times = [(name, delay[key]) for key, name in words]
    return ", ".join(f"{name} {f'not {horizon}' if t is None else f'within {duration_in_words(t, unit)}'}" for name, t in times)
