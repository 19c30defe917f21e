"""A run of equations of a table ``[system]``: findings -> quantities, and the lines of its report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.results.formatting import report_lines
from wucht.results.quantities import Quantity, group, result_dataset
from wucht.studies.run_up.system_run import SystemRunFindings

if TYPE_CHECKING:
    import xarray as xr

_MOST_PLACES = 20_001  # samples of what the motion tends to
_LONG_NAMES = {
    "stable": "whether nearby motions tend to it",
    "state": "states of the equilibrium",
    "eigenvalues": "eigenvalues of the equilibrium",
    "period": "period of the orbit",
    "turns": "turns of the angles in a period",
    "multipliers": "Floquet multipliers of the orbit, without that of its phase",
    "min": "least value of each state, of what the motion tends to",
    "max": "largest value of each state, of what the motion tends to",
    "mean": "mean value of each state, of what the motion tends to",
}
_EXPONENT = {
    "value": "largest Lyapunov exponent",
    "low": "lower end of its 95 % interval",
    "high": "upper end of its 95 % interval",
    "duration": "time over which it is a mean",
}


def system_run_dataset(findings: SystemRunFindings) -> xr.Dataset:
    """Return the Dataset of a run of equations."""
    plan, run, names = findings.plan, findings.run, findings.plan.subject.system.state_names
    turning = [int(s in plan.subject.system.angles) for s in plan.subject.system.states]
    thin = max(1, -(-(len(run.time) - 1) // ((plan.spec.stored_samples or len(run.time)) - 1 or 1)))
    sentence = sentence_of(run.kind, run.limit_set, names)
    quantities = [
        Quantity("outcome", str(run.kind), "outcome of the run"),
        Quantity("end_time", run.end_time, "time until which the motion was integrated"),
        Quantity("settling_time", run.settling_time, "time after which the motion is near to what it tends to", headline=True),
        Quantity("advised_time", run.advised_time, "duration of a run that may tell"),
        *_limit_quantities(run.limit_set, names),
        Quantity("time", run.time[::thin], "time", "", "time"),
        Quantity("state", list(names), "state", "", "state"),
        Quantity("is_angle", turning, "1 of an angle", "", "state", coordinate=True),
        Quantity("states", run.states[:, ::thin], "value of the state", "", "state time"),
        *_limit_samples(run.limit_set, len(names)),
    ]
    warnings = [
        f"the run until {run.end_time:.5g} is too short to tell what the motion tends to; study.until = {run.advised_time:.4g} "
        "may tell"
    ] if run.advised_time is not None else []  # fmt: skip
    if run.limit_set is not None and run.limit_set.attracts is False:
        warnings.append("the start lies on an unstable equilibrium: any disturbance leads away from it")
    attributes = {"outcome": str(run.kind), "engine": run.engine, "tolerance": plan.spec.tolerance, "subject": "system"}
    return result_dataset(quantities, sentence, warnings, (), run.failure, **attributes)


def _limit_quantities(limit_set: LimitSet | None, names: tuple[str, ...]) -> list[Quantity]:
    numbers = dict.fromkeys([*_LONG_NAMES, "lyapunov_exponent"]) if limit_set is None else numbers_of(limit_set, names)
    exponent: dict[str, Any] = numbers["lyapunov_exponent"] or dict.fromkeys(_EXPONENT)
    parts = [Quantity(name, exponent[name], long_name) for name, long_name in _EXPONENT.items()]
    return [
        *(Quantity(name, numbers[name], long_name, headline=name == "period") for name, long_name in _LONG_NAMES.items()),
        group("lyapunov_exponent", parts, "largest Lyapunov exponent with its 95 % interval, per unit of time"),
    ]


def _limit_samples(limit_set: LimitSet | None, count: int) -> list[Quantity]:
    times, states = (np.empty(0), np.empty((count, 0))) if limit_set is None else (limit_set.times, limit_set.states)
    thin = max(1, -(-len(times) // _MOST_PLACES))
    return [
        Quantity("limit_time", times[::thin], "time on what the motion tends to", "", "place"),
        Quantity("limit_states", states[:, ::thin], "state on what the motion tends to", "", "state place"),
    ]


def system_run_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a run of equations."""
    s = result.wucht.summary
    lines = [("run", f"until t = {s['end_time']:.6g}")]
    if s["settling_time"] is not None:
        lines.append(("settled", f"after t = {s['settling_time']:.4g}"))
    for name, key in (("eigenvalues", "eigenvalues"), ("multipliers", "multipliers")):
        if s[key]:
            lines.append((name, ", ".join(f"{a:.5g}" if not b else f"{a:.5g}{b:+.5g}i" for a, b in s[key])))
    if s["turns"]:
        lines.append(("turns", ", ".join(f"{name} {turns:+d}" for name, turns in s["turns"].items()) + " a period"))
    exponent = s["lyapunov_exponent"]
    if exponent["value"] is not None:
        interval = f"{exponent['low']:.5g} to {exponent['high']:.5g}, in 19 of 20 cases"
        lines.append(("exponent", f"{exponent['value']:.5g} ({interval}; mean over a time of {exponent['duration']:.4g})"))
    if s["min"] and s["outcome"] != "equilibrium":
        lines += [("range", f"{name} {low:.6g} to {s['max'][name]:.6g}") for name, low in s["min"].items()]
    return report_lines(result, f"{s['outcome'].upper()}, {s['sentence']}", lines)
