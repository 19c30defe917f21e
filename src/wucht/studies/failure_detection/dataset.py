"""Findings -> the Dataset of a failure and of how it is seen, and its summary."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.exciters.averaged_speeds import UNSTABLE
from wucht.dynamics.exciters.speed_readings import Readings
from wucht.results.conventions import answered, variable
from wucht.studies.failure_detection.prepare import Plan, Varied
from wucht.studies.failure_detection.report_words import counted_from, duration, within
from wucht.studies.failure_detection.run import Findings, Place

if TYPE_CHECKING:
    import xarray as xr

_CLOSED = 1e-6  # an energy residual beyond it is reported as a warning
_APART = 0.05  # of the speed: averaged equations that differ more are reported
_SURE = (0.5, 0.95)
_CHANCE = 0.5  # of the time between false alarms: an alarm that comes later in the mean is as good as one of them


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset.

    Over reading: speed (mean over the sensor's interval), reading (with noise), highest, lowest (of the load in that interval),
    reading_time (its end). Over sample: time, stiffness (share), damage, energy_residual, stiffness_work. Over alarm:
    alarm_time (since the failure; each of the first readings, beyond 5,000 some of them), seen (probability). Over along (and
    second): signal, change.
    """
    import xarray as xr_

    own, units, sensor = findings.own, plan.machine.units, plan.spec.sensor
    course, readings = own.run.course, own.readings
    noise = np.random.default_rng(sensor.seed).normal(0.0, sensor.noise, len(readings.speed))
    load = (plan.signal.name, plan.signal.unit)
    data = {
        "reading_time": variable("reading", readings.time, "time", units.time),
        "speed": variable("reading", readings.speed, "mean speed of the main rotor", units.speed),
        "reading": variable("reading", readings.speed + noise, "reading of the sensor", units.speed),
        "time": variable("sample", course.time, "time", units.time),
        "stiffness": variable("sample", course.stiffness, "share of the stiffness"),
        "damage": variable("sample", course.damage, "damage"),
        "highest": variable("reading", _over_readings(np.fmax, course.highest, readings), f"largest {load[0]}", load[1]),
        "lowest": variable("reading", _over_readings(np.fmin, course.lowest, readings), f"smallest {load[0]}", load[1]),
        "energy_residual": variable("sample", course.residual, "residual of the energy balance"),
        "stiffness_work": variable("sample", course.work, "work of the changing stiffness", units.energy),
        "failure_time": variable("", own.windows.failed, "time of the failure", units.time),
    }
    summary = _summary(plan, findings)
    if (detection := findings.detection) is not None:
        after, probability = detection.curve()
        data["alarm_time"] = variable("alarm", after, f"time since {counted_from(summary)}", units.time)
        data["seen"] = variable("alarm", probability, "probability that the failure has been seen")
    coordinates, more = _places(plan, findings.places)
    result = xr_.Dataset(data | more, coords=coordinates)
    failure = own.run.failure
    return answered(
        result, summary, _sentence(summary, plan), _warnings(plan, findings, summary), failure,
        outcome=summary["after"]["outcome"], signal=load[0],
    )  # fmt: skip


def _over_readings(extreme: np.ufunc, samples: np.ndarray, readings: Readings) -> np.ndarray:
    """The extreme of values since the sample before (N,) over each reading (n,)."""
    count = len(readings.speed)
    every = (len(samples) - 1) // max(count, 1)
    return np.asarray(extreme.reduce(samples[1 : 1 + count * every].reshape(count, every), axis=1, initial=np.nan))


def _places(plan: Plan, places: tuple[Place, ...]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Coordinates and variables of what was found at other values: on the grid, of one parameter in its order."""
    if plan.along is None or not places:
        return {}, {}
    units = plan.machine.units
    if plan.second is None:
        axes, dimensions = [np.array([p.values[0] for p in places])], "along"
    else:
        axes, dimensions = [np.array(plan.along.values), np.array(plan.second.values)], "along second"
    grid = {name: np.full([len(a) for a in axes], np.nan) for name in ("signal", "change")}
    for place in places:
        at = tuple(int(np.flatnonzero(a == v)[0]) for a, v in zip(axes, place.values, strict=True))
        if place.signal is not None and place.before is not None and place.after is not None:
            grid["signal"][at], grid["change"][at] = place.signal, place.after - place.before
    coordinates = {
        name: variable(name, axis, of.parameter.path, of.parameter.unit)
        for name, axis, of in zip(dimensions.split(), axes, _varied(plan), strict=True)
    }
    return coordinates, {
        "signal": variable(dimensions, grid["signal"], "change of speed over standard deviation of the readings"),
        "change": variable(dimensions, grid["change"], "change of speed", units.speed),
    }


def _varied(plan: Plan) -> list[Varied]:
    return [v for v in (plan.along, plan.second) if v is not None]


def _summary(plan: Plan, findings: Findings) -> dict[str, Any]:
    own, noise = findings.own, plan.spec.sensor.noise
    readings, windows, run = own.readings, own.windows, own.run
    before, after = readings.before, readings.after
    change = None if before is None or after is None else after - before
    averaged = findings.averaged
    speeds = (None, None) if averaged is None else (averaged[0].speed, averaged[1].speed)
    detection, standing = findings.detection, run.standing
    return {
        "failure_time": windows.failed,
        "before": {"speed": before, "outcome": None if run.before is None else str(run.before.outcome)},
        "after": {"speed": after, "outcome": str(run.verdict.outcome)},
        "change": change,
        "deviation": readings.deviation(noise),
        "signal": readings.signal(noise),
        "averaged": {
            "before": speeds[0],
            "after": speeds[1],
            "change": None if speeds[0] is None or speeds[1] is None else speeds[1] - speeds[0],
            "kinds": None if averaged is None else [a.kind for a in averaged],
        },
        "chart": None
        if detection is None
        else {
            "mean": detection.learnt,
            "reference": detection.chart.reference,
            "threshold": detection.chart.threshold,
        },
        "delay": None
        if detection is None
        else {
            "mean": detection.mean,
            "half": detection.quantile(_SURE[0]),
            "nearly_all": detection.quantile(_SURE[1]),
            "horizon": detection.horizon,
            "readings": detection.readings,
            "probability": float(detection.curve()[1][-1]),
        },
        "damage": None if standing.damage is None else standing.damage.total,
        "stiffness": float(run.course.stiffness[-1]),
        "stiffness_work": float(run.course.work[-1]),
        "energy_residual": float(run.course.residual.max()),
        "largest": _largest(plan, findings.places),
    }


def _largest(plan: Plan, places: tuple[Place, ...]) -> dict[str, Any] | None:
    """The place with the largest signal."""
    seen = [p for p in places if p.signal is not None]
    if not seen:
        return None
    best = max(seen, key=lambda p: p.signal or 0.0)
    values = {v.parameter.path: x for v, x in zip(_varied(plan), best.values, strict=True)}
    assert best.before is not None and best.after is not None
    return values | {"signal": best.signal, "change": best.after - best.before, "outcome": best.outcome}


def _sentence(s: dict[str, Any], plan: Plan) -> str:
    units = plan.machine.units
    if s["failure_time"] is None:
        said = "the specimen does not fail" + (f": damage {s['damage']:.4g}" if s["damage"] is not None else "")
        if s["change"] is None:
            return said
    else:
        said = f"the specimen fails at {s['failure_time']:.6g} {units.time}".rstrip()
    if s["change"] is None:
        return f"{said}; there are too few readings to tell the change of speed"
    told = f"{said}, the speed changes by {s['change']:.4g} {units.speed}".rstrip()
    if s["delay"] is None:
        return f"{told}; there is no chart that watches it"
    delay = s["delay"]
    if (mean := delay["mean"]) is None:
        horizon = within(delay["readings"], delay["horizon"], units.time)
        return f"{told}, which is seen {horizon}, with a probability of {delay['probability']:.3g}"
    when = duration(abs(mean), units.time) + (" later" if mean >= 0 else " before that")
    if s["failure_time"] is None:
        when = f"{duration(mean, units.time)} after {counted_from(s)}"
    return f"{told}, which is seen {when} in the mean"


def _warnings(plan: Plan, findings: Findings, s: dict[str, Any]) -> list[str]:
    own = findings.own
    warnings = [*plan.case.horizon.warnings, *plan.case.models[0].warnings]
    warnings = [w for w in warnings if "samples a turn are stored" not in w]  # nothing is stored here
    warnings += [own.run.failure] if own.run.failure else []
    if s["failure_time"] is None and not own.run.failure:
        warnings.append("the specimen does not fail within study.until: run longer, or give it a shorter life (a smaller ND)")
    elif s["change"] is None and not own.run.failure:
        warnings.append("there are too few readings before or after the failure: run longer, or fail later")
    if s["energy_residual"] > _CLOSED:
        warnings.append(f"the energy balance closes only to {s['energy_residual']:.1e}: the run is not accurate")
    if findings.undetected:
        warnings.append(f"there is no chart: {findings.undetected}")
    if s["chart"] is not None and s["change"] is not None and abs(s["change"]) < 2 * s["chart"]["reference"]:
        warnings.append(
            f"the chart is made for changes of {2 * s['chart']['reference']:.3g}, and this one is smaller: a smaller "
            "study.sensor.change sees it sooner"
        )
    if s["delay"] is not None and (s["delay"]["mean"] or 0.0) > _CHANCE * plan.spec.sensor.false_alarm_every:
        warnings.append("an alarm comes hardly sooner than a false one: the chart does not see this failure")
    if own.run.verdict.advice and s["change"] is not None:
        warnings.append(f"after the failure {own.run.verdict.advice}")
    for when, averaged in zip(("before", "after"), findings.averaged or (), strict=False):
        speed = s[when]["speed"]
        if averaged.speed is None:
            warnings.append(f"the averaged equations give no speed {when} the failure: {averaged.reason}")
        elif averaged.kind == UNSTABLE:
            other = "" if averaged.next_stable is None else f"; the nearest stable one has {averaged.next_stable:.5g}"
            warnings.append(
                f"the steady state {when} the failure is unstable: the run stands there because nothing disturbs it, a machine "
                f"does not stay{other}. Bodies that are exactly alike do that: make one of them a little different"
            )
        elif abs(averaged.speed - speed) > _APART * abs(speed):
            warnings.append(
                f"the averaged equations have {averaged.speed:.5g} {when} the failure, the full ones {speed:.5g}: the speed is "
                "still changing, the averaged motion is another one, or the averaging is too coarse there"
            )
    return warnings
