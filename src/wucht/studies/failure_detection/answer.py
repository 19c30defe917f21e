"""The answer on a failure: run and readings, the speeds before and after it, its detection, and the signal at other values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from wucht.dynamics.exciters.failing_machine import FailingRun, FailureCourse
from wucht.dynamics.exciters.signal_points import NEAR, SignalPoint, best_index, cliff_at, neighbours_of, safe_index
from wucht.dynamics.exciters.speed_readings import UNSTABLE, AveragedSpeed, Detection, Readings
from wucht.dynamics.run_ups.machine_signals import MachineSignal
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.results.formatting import decimal_text
from wucht.schema import Parameter
from wucht.studies.answer import Answer
from wucht.studies.failure_detection.failure_tables import Sensor

_HOUR = 3600.0  # s
_ENERGY_TOLERANCE = 1e-6  # a larger energy residual is reported as a warning
_SPEED_TOLERANCE = 0.05  # of the speed: a larger difference of the averaged equations is reported
_SIGNAL = "change of speed over standard deviation of the readings"
_FALSE_ALARM_SHARE = 0.5  # of the time between false alarms: a later mean alarm is not distinguishable from a false one

Axes = Sequence[tuple[Parameter, tuple[float, ...]]]


def state_failure(
    a: Answer,
    case: RunUpCase,
    signal: MachineSignal,
    axes: Axes,
    sensor: Sensor,
    run: FailingRun,
    readings: Readings,
    detection: Detection | str | None = None,
    averaged_speeds: Mapping[str, AveragedSpeed] | None = None,
    points: Sequence[SignalPoint] = (),
) -> None:
    """State what is known of a failure.

    detection: of its alarm, or the reason why there is none. averaged_speeds: before and after it. points: at other values.
    """
    failure_time = readings.windows.failure_time
    change, averaged_speeds = _change(readings.before, readings.after), averaged_speeds or {}
    a.failure = run.failure
    a.attribute(outcome=str(run.verdict.outcome), signal=signal.name)
    a.warn(*(w for w in (*case.horizon.warnings, *case.models[0].warnings) if "samples a turn are stored" not in w))
    if run.failure:
        a.warn(run.failure)
    elif failure_time is None:
        a.warn("the specimen does not fail within study.until: run longer, or give it a shorter life (a smaller ND)")
    elif change is None:
        a.warn("there are too few readings before or after the failure: run longer, or let the specimen fail later")
    _state_course(a, run.course, failure_time)
    _state_readings(a, run.course, readings, signal, sensor)
    _state_speeds(a, run, readings, change, sensor, averaged_speeds)
    alarm_clause = _state_detection(a, detection, failure_time, change, sensor)
    if run.verdict.advice and change is not None:
        a.warn(f"after the failure {run.verdict.advice}")
    damage_clause = _state_damage(a, run)
    a.sentence = "the specimen does not fail" + damage_clause
    if failure_time is not None:
        a.sentence = f"the specimen fails at {failure_time:.6g} {a.unit('time')}".rstrip()
    if change is not None:
        a.sentence += f", the speed changes by {a.number_in_words(change, 'speed')}{alarm_clause}"
    elif failure_time is not None:
        a.sentence += "; there are too few readings to determine the change of speed"
    a.sentence += _state_points(a, axes, points, readings.signal(sensor.noise))
    for period, speed in (("before", readings.before), ("after", readings.after)):
        if period in averaged_speeds and speed is not None:
            _warn_of_averaged_speed(a, period, averaged_speeds[period], speed)


def _change(before: float | None, after: float | None) -> float | None:
    return None if before is None or after is None else after - before


def _state_course(a: Answer, course: FailureCourse, failure_time: float | None) -> None:
    """State stiffness, damage and energy over the run."""
    a.curve("time", course.time, "time", "time", "sample", coordinate=True)
    a.curve("stiffness", course.stiffness, "share of the stiffness", "", "sample")
    a.curve("damage", course.damage, "damage", "", "sample")
    a.curve("energy_residual", course.residual, "residual of the energy balance", "", "sample")
    a.curve("stiffness_work", course.work, "work of the changing stiffness", "energy", "sample")
    a.curve("failure_time", failure_time, "time of the failure", "time", "", in_summary=True)
    residual = a.number("energy_residual", float(course.residual.max()), "largest residual of the energy balance")
    if residual > _ENERGY_TOLERANCE:
        a.warn(f"the energy balance closes only to {residual:.1e}: the run is not accurate")


def _state_readings(a: Answer, course: FailureCourse, readings: Readings, signal: MachineSignal, sensor: Sensor) -> None:
    """State the readings of the sensor, and the limits of the load between two readings."""
    noise = np.random.default_rng(sensor.seed).normal(0.0, sensor.noise, len(readings.speed))
    a.curve("reading_time", readings.time, "time", "time", "reading", coordinate=True)
    a.curve("speed", readings.speed, "mean speed of the main rotor", "speed", "reading")
    a.curve("reading", readings.speed + noise, "reading of the sensor", "speed", "reading")
    for name, extreme, samples, word in (
        ("highest", np.fmax, course.highest, "largest"), ("lowest", np.fmin, course.lowest, "smallest"),
    ):  # fmt: skip
        a.curve(name, _reading_extremes(extreme, samples, readings), f"{word} {signal.name}", signal.unit, "reading")


def _reading_extremes(extreme: np.ufunc, samples: np.ndarray, readings: Readings) -> np.ndarray:
    """Return the extreme over each reading (n,) of values since the previous sample (N,)."""
    count = len(readings.speed)
    every = (len(samples) - 1) // max(count, 1)
    return np.asarray(extreme.reduce(samples[1 : 1 + count * every].reshape(count, every), axis=1, initial=np.nan))


def _state_speeds(
    a: Answer,
    run: FailingRun,
    readings: Readings,
    change: float | None,
    sensor: Sensor,
    averaged_speeds: Mapping[str, AveragedSpeed],
) -> None:
    """State the speeds before and after the failure, and those of the averaged equations."""
    averaged = {period: averaged_speed.speed for period, averaged_speed in averaged_speeds.items()}
    for period, speed, verdict in (("before", readings.before, run.verdict_before), ("after", readings.after, run.verdict)):
        with a.group(period, f"motion {period} the failure"):
            a.number("speed", speed, "mean speed of the main rotor", "speed")
            outcome = a.number("outcome", None if verdict is None else str(verdict.outcome), "outcome")
        averaged_clause = "" if averaged.get(period) is None else f"; averaged equations {{averaged.{period}}}"
        a.line(period, f"{{{period}.speed}}, {outcome or 'not classified'}{averaged_clause}")
    a.number("change", change, "change of speed", "speed")
    a.number("deviation", readings.deviation(sensor.noise), "standard deviation of the readings", "speed")
    a.number("signal", readings.signal(sensor.noise), _SIGNAL)
    a.line("change", "{change}, {signal:.4g} times the standard deviation of the readings, {deviation}")
    with a.group("averaged", "mean speeds by the averaged equations"):
        before, after = (
            a.number(period, averaged.get(period), f"{period} the failure", "speed") for period in ("before", "after")
        )
        a.number("change", _change(before, after), "change", "speed")
        kinds = [averaged_speed.kind for averaged_speed in averaged_speeds.values()] or None
        a.number("kinds", kinds, "kinds of the steady motions before and after the failure")


def _state_detection(
    a: Answer, detection: Detection | str | None, failure_time: float | None, change: float | None, sensor: Sensor
) -> str:
    """State the control chart of the speed, and the delay of its alarm. Return the clause on it."""
    chart, delay, clause = None, None, "; no control chart monitors it"
    if isinstance(detection, str):
        a.warn(f"there is no control chart: {detection}")
    elif detection is not None:
        origin = "the failure" if failure_time is not None else "the chart begins"
        after, probability = detection.curve()
        a.curve("alarm_time", after, f"time since {origin}", "time", "alarm")
        a.curve("seen", probability, "probability that the failure has been detected", "", "alarm")
        mean, half, nearly_all = detection.mean, detection.quantile(0.5), detection.quantile(0.95)
        reference = detection.chart.reference
        chart = {"mean": detection.learnt, "reference": reference, "threshold": detection.chart.threshold}
        delay = {
            "mean": mean, "half": half, "nearly_all": nearly_all, "horizon": detection.horizon,
            "readings": detection.readings, "probability": float(probability[-1]),
        }  # fmt: skip
        a.line("chart", f"cumulative sum, k = {reference:.4g}, h = {{chart.threshold:.4g}}")
        time_unit = a.unit("time")
        on_average = "not with certainty" if mean is None else f"{_duration(mean, time_unit)} after {origin} on average"
        within = _span_in_words(after.size, float(after[-1]), time_unit)
        times = ", ".join(
            f"{name} {f'not {within}' if t is None else f'within {_duration(t, time_unit)}'}"
            for name, t in (("half of them", half), ("19 of 20", nearly_all))
        )
        a.line("detection", f"{on_average}; {times}")
        if mean is None:
            within = _span_in_words(detection.readings, detection.horizon, time_unit)
            clause = f", which is detected {within} with a probability of {probability[-1]:.3g}"
        elif failure_time is None:
            clause = f", which is detected {_duration(mean, time_unit)} after {origin} on average"
        else:
            clause = f", which is detected {_duration(abs(mean), time_unit)} {'later' if mean >= 0 else 'before it'} on average"
        if change is not None and abs(change) < 2 * reference:
            a.warn(
                f"the chart is designed for changes of {2 * reference:.3g}, and this one is smaller: a smaller "
                "study.sensor.change detects it sooner"
            )
        if (mean or 0.0) > _FALSE_ALARM_SHARE * sensor.false_alarm_every:
            a.warn("an alarm comes hardly any sooner than a false one: the chart does not detect this failure")
    a.number("chart", chart, "chart of cumulative sums", parts={
        "mean": ("mean speed before the failure", a.unit("speed")),
        "reference": ("reference value subtracted from each reading", a.unit("speed")),
        "threshold": ("cumulative sum at which it gives an alarm", a.unit("speed")),
    })  # fmt: skip
    a.number("delay", delay, "time until the chart gives an alarm", parts={
        "mean": ("mean time", a.unit("time")),
        "half": ("time within which half of the failures are detected", a.unit("time")),
        "nearly_all": ("time within which 95 % are detected", a.unit("time")),
        "horizon": ("horizon of this computation", a.unit("time")),
        "readings": ("number of readings in that time", ""),
        "probability": ("probability of an alarm in that time", ""),
    })  # fmt: skip
    return clause


def _duration(time: float, unit: str) -> str:
    """Return a time in its unit, from an hour on in hours too: ``5770 s (1.6 h)``."""
    hours = f" ({time / _HOUR:.3g} h)" if unit == "s" and abs(time) >= _HOUR else ""
    return f"{decimal_text(time)} {unit}".rstrip() + hours


def _span_in_words(readings: int, time: float, unit: str) -> str:
    """Return the observed span in words: ``within 5,080 readings, 2540 s``."""
    return f"within {readings:,} readings, {_duration(time, unit)}"


def _state_damage(a: Answer, run: FailingRun) -> str:
    """State damage and stiffness at the end of the run. Return the clause on the damage."""
    course, state = run.course, run.state
    damage = a.number("damage", None if state.damage is None else state.damage.total, "damage at the end")
    a.line("damage", "{damage:.5g} at the end")
    a.number("stiffness", float(course.stiffness[-1]), "remaining share of the stiffness at the end")
    a.number("stiffness_work", float(course.work[-1]), "work of the changing stiffness, total", "energy")
    a.line("stiffness", "{stiffness:.4g} of the intact specimen's at the end, its work {stiffness_work:.4g}")
    a.line("energy", "closes to {energy_residual:.1e}")
    return "" if damage is None else f": damage {damage:.4g}"


def _state_points(a: Answer, axes: Axes, points: Sequence[SignalPoint], present_signal: float | None) -> str:
    """State the signal at other values, where it is largest, and how near its cliff is. Return the clause on that."""
    if points:
        _state_signals(a, axes, points)
    units = {parameter.path: parameter.unit for parameter, _ in axes}
    paths, best = list(units), best_index(points)
    safe = None if best is None else safe_index(points, paths)
    parts = {path: (path, unit) for path, unit in units.items()} | {
        "signal": (_SIGNAL, ""), "change": ("change of speed", a.unit("speed")), "outcome": ("outcome", ""),
        "neighbours": ("neighbours of it", ""), "cliff": ("nearest value at which less than half of the signal is left", ""),
    }  # fmt: skip
    largest, largest_safe = (None if k is None else _point_row(points, k, paths) for k in (best, safe))
    a.number("largest", largest, "other values with the largest signal", parts=parts)
    a.number("largest_safe", largest_safe, f"the same, at least {100 * NEAR:g} % from a cliff", parts=parts)
    if largest is None:
        return ""
    places = ", ".join(f"{path} = {largest[path]:.5g}" for path in paths)
    there = "change {largest.change:.5g}, then {largest.outcome}"
    a.line("largest", f"signal {{largest.signal:.4g}} at {{places}}: {there}", places=places)
    at, present = ", ".join(f"{path} = {largest[path]:.4g}" for path in paths), ""
    if present_signal is not None:
        present = f" ({present_signal:.3g} at present)"
    clause, cliff = f"; the signal is largest, {largest['signal']:.3g}{present}, at {at}", largest["cliff"]
    if cliff is None:
        return clause
    distance = f"{100 * abs(cliff['distance']):.2g} % {'below' if cliff['distance'] < 0 else 'above'}"
    if abs(cliff["distance"]) < NEAR:
        path, unit = cliff["parameter"], units[cliff["parameter"]]
        warning = (
            f"the largest signal, {largest['signal']:.3g} at {path} = {largest[path]:.5g} {unit}".rstrip()
            + f", lies at a cliff: {distance}, at {cliff['value']:.5g} {unit}".rstrip()
            + f", it is {cliff['signal']:.3g}"
        )
        if largest_safe is not None:
            safe_places = ", ".join(f"{p} = {largest_safe[p]:.5g} {u}".rstrip() for p, u in units.items())
            warning += f"; at least {100 * NEAR:g} % away from it {safe_places} is best, {largest_safe['signal']:.3g}"
        a.warn(warning)
    return f"{clause}, and {distance} that {cliff['signal']:.3g}"


def _state_signals(a: Answer, axes: Axes, points: Sequence[SignalPoint]) -> None:
    """State signal and change of speed at other values: on the grid, for one parameter in its order."""
    grid = [np.array(values) for _, values in axes] if len(axes) > 1 else [np.array([p.values[0] for p in points])]
    signal, change = (np.full([len(values) for values in grid], np.nan) for _ in range(2))
    for point in points:
        at = tuple(int(np.flatnonzero(values == v)[0]) for values, v in zip(grid, point.values, strict=True))
        if point.signal is not None and point.before is not None and point.after is not None:
            signal[at], change[at] = point.signal, point.after - point.before
    names = ("along", "second")[: len(axes)]
    for name, values, (parameter, _) in zip(names, grid, axes, strict=True):
        a.curve(name, values, parameter.path, parameter.unit, name)
    a.curve("signal", signal, _SIGNAL, "", " ".join(names))
    a.curve("change", change, "change of speed", "speed", " ".join(names))


def _point_row(points: Sequence[SignalPoint], k: int, paths: Sequence[str]) -> dict[str, Any]:
    """Return a point, the neighbours with which it is compared, and its nearest cliff."""
    point, cliff = points[k], cliff_at(points, k, paths)
    beside = [points[indices[0]] for _, indices in neighbours_of(points, k) if indices]

    def values_of(one: SignalPoint) -> dict[str, Any]:
        return dict(zip(paths, one.values, strict=True))

    return values_of(point) | {
        "signal": point.signal, "change": _change(point.before, point.after), "outcome": point.outcome,
        "neighbours": [values_of(p) | {"signal": p.signal} for p in beside],
        "cliff": None if cliff is None else {
            "parameter": cliff.parameter, "value": cliff.value, "distance": cliff.distance, "inside": cliff.inside,
            "signal": 1 / cliff.cost,
        },
    }  # fmt: skip


def _warn_of_averaged_speed(a: Answer, period: str, averaged_speed: AveragedSpeed, speed: float) -> None:
    """Warn where the averaged equations have no such speed as the full ones, or an unstable or a different one."""
    if averaged_speed.speed is None:
        a.warn(f"the averaged equations give no speed {period} the failure: {averaged_speed.reason}")
    elif averaged_speed.kind == UNSTABLE:
        next_stable = averaged_speed.next_stable
        stable_clause = "" if next_stable is None else f"; the nearest stable one has {next_stable:.5g}"
        a.warn(
            f"the steady state {period} the failure is unstable: the run stays there because nothing disturbs it, but a "
            f"machine would not{stable_clause}. This happens with identical bodies: make one of them slightly different"
        )
    elif abs(averaged_speed.speed - speed) > _SPEED_TOLERANCE * abs(speed):
        a.warn(
            f"the averaged equations have {a.number_in_words(averaged_speed.speed, 'speed')} {period} the failure, the full "
            f"ones {a.number_in_words(speed, 'speed')}: the speed is "
            "still changing, the averaged motion is a different one, or the averaging is too coarse"
        )
