"""Runs of equations of a table ``[system]``: findings -> quantities, and the lines of its report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.limit_sets.conservation import CONSERVATIVE_MOTION, preserves_volume
from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind
from wucht.dynamics.limit_sets.long_run import LongRun
from wucht.files.user_system import UserSystem
from wucht.results.formatting import report_lines
from wucht.results.quantities import Quantity, StudyResult, group, table
from wucht.studies.run_up.system_run import SystemRunFindings, SystemRunPlan

if TYPE_CHECKING:
    import xarray as xr

_MOST_SAMPLES, _MOST_PLACES = 1_000_000, 20_001  # of all runs together, and of what motions tend to
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
    """Return the Dataset of one run of equations, or of many, with the dimension ``case``."""
    plan = findings.plan
    most = (plan.spec.stored_samples or _MOST_SAMPLES) // len(plan.cases)
    results = [_run_result(plan, case.subject, run, max(most, 2)) for case, run in zip(plan.cases, findings.runs, strict=False)]
    return _gathered_dataset(plan, results) if plan.several else results[0].to_dataset()


def _run_result(plan: SystemRunPlan, subject: UserSystem, run: LongRun, most: int) -> StudyResult:
    """Return the result of one run. most: samples."""
    system, names = subject.system, subject.system.state_names
    turning = [int(s in system.angles) for s in system.states]
    thin = max(1, -(-(len(run.time) - 1) // (most - 1)))
    quantities = [
        Quantity("outcome", str(run.kind), "outcome of the run"),
        Quantity("end_time", run.end_time, "time until which the motion was integrated"),
        Quantity(
            "settling_time", _settling_time(run), "time after which the motion is near to what it tends to", headline=True
        ),
        Quantity("advised_time", run.advised_time, "duration of a run that may tell"),
        *_limit_quantities(run.limit_set, names),
        Quantity("time", run.time[::thin], "time", "", "time"),
        Quantity("state", list(names), "state", "", "state"),
        Quantity("is_angle", turning, "1 of an angle", "", "state", coordinate=True),
        Quantity("states", run.states[:, ::thin], "value of the state", "", "state time"),
        *_limit_samples(run.limit_set, len(names), _MOST_PLACES // len(plan.cases)),
    ]
    warnings = [
        f"the run until {run.end_time:.5g} is too short to tell what the motion tends to; study.until = {run.advised_time:.4g} "
        "may tell"
    ] if run.advised_time is not None else []  # fmt: skip
    warnings += _unstable_warnings(run)
    attributes = {"outcome": str(run.kind), "engine": run.engine, "tolerance": plan.spec.tolerance, "subject": "system"}
    sentence = sentence_of(run.kind, run.limit_set, names)
    if run.limit_set is not None and run.limit_set.attracts is None and preserves_volume(subject):
        sentence += f"; {CONSERVATIVE_MOTION}"
    return StudyResult(quantities, sentence, warnings, (), run.failure, attributes)


def _settling_time(run: LongRun) -> float | None:
    """Return the time after which a motion is near to what it tends to; a chaotic one may end, and tends to nothing known."""
    return None if run.kind is MotionKind.CHAOTIC else run.settling_time


def _unstable_warnings(run: LongRun) -> list[str]:
    """Return warnings of a start on an unstable equilibrium, or of a motion that ends in one."""
    at = run.start_equilibrium
    if run.limit_set is not None and run.limit_set.attracts is False:
        if at is not None:
            return ["the start lies on an unstable equilibrium: any disturbance leads away from it"]
        return ["the motion ends in an unstable equilibrium, which is reached from few starts only: any disturbance leads away"]
    if at is not None and at.attracts is False:
        return [
            "the start lies on an unstable equilibrium: the motion leaves it by rounding alone, so that where it leads is not "
            "determined; start beside it"
        ]
    return []


def _gathered_dataset(plan: SystemRunPlan, results: Sequence[StudyResult]) -> xr.Dataset:
    """Return many runs as one Dataset; its summary has a list ``cases``."""
    pairs = list(zip(plan.cases, results, strict=False))  # a run may be missing
    names = plan.subject.system.state_names
    cases = [
        {"label": c.label, "start": dict(zip(names, c.start.tolist(), strict=True)), "value": c.value} | r.summary
        for c, r in pairs
    ]
    count = Counter(case["outcome"] for case in cases)
    is_complete = len(pairs) == len(plan.cases)
    outcome = next(iter(count)) if len(count) == 1 and is_complete else None
    warnings = [f"{c.label}: {w}" for c, r in pairs for w in r.warnings]
    if not is_complete:
        warnings.append(f"{len(pairs)} of {len(plan.cases)} runs are finished")
    by_name = [{q.name: q for q in r.quantities} for r in results]
    parts = {q.name: (q.long_name, q.unit) for q in results[0].quantities if q.dimensions is None}
    parts |= {
        "label": ("label of the run", ""), "start": ("states at the start", ""), "value": ("value of the parameter", ""),
        "sentence": ("what the motion tends to", ""),
    }  # fmt: skip
    quantities = [
        Quantity("outcome", outcome, "outcome, where all have the same"),
        Quantity("outcomes", dict(count), "number of runs of each outcome"),
        Quantity("along", plan.spec.along, "parameter that differs"),
        *table("cases", cases, "the runs", parts),
        Quantity("case", [case["label"] for case in cases], "run", "", "case"),
        by_name[0]["state"], by_name[0]["is_angle"],
        *(
            Quantity(name, _stack_padded([q[name].value for q in by_name]), by_name[0][name].long_name, "", f"case {inner}")
            for name, inner in (
                ("time", "sample"), ("states", "state sample"), ("limit_time", "place"), ("limit_states", "state place")
            )
        ),
    ]  # fmt: skip
    sentence = ", ".join(f"{n} {name}" for name, n in count.most_common())
    failure = next((r.failure for r in results if r.failure), None)
    attributes = {**results[0].attributes, "outcome": outcome or "several"}
    return StudyResult(quantities, sentence, warnings, (), failure, attributes).to_dataset()


def _stack_padded(arrays: Sequence[Any]) -> np.ndarray:
    """Stack arrays (..., N) of different lengths, padded with NaN."""
    longest = max(np.shape(a)[-1] for a in arrays)
    return np.stack([
        np.pad(np.asarray(a, float), [(0, 0)] * (np.ndim(a) - 1) + [(0, longest - np.shape(a)[-1])], constant_values=np.nan)
        for a in arrays
    ])  # fmt: skip


def _limit_quantities(limit_set: LimitSet | None, names: tuple[str, ...]) -> list[Quantity]:
    numbers = dict.fromkeys([*_LONG_NAMES, "lyapunov_exponent"]) if limit_set is None else numbers_of(limit_set, names)
    exponent: dict[str, Any] = numbers["lyapunov_exponent"] or dict.fromkeys(_EXPONENT)
    parts = [Quantity(name, exponent[name], long_name) for name, long_name in _EXPONENT.items()]
    return [
        *(Quantity(name, numbers[name], long_name, headline=name == "period") for name, long_name in _LONG_NAMES.items()),
        group("lyapunov_exponent", parts, "largest Lyapunov exponent with its 95 % interval, per unit of time"),
    ]


def _limit_samples(limit_set: LimitSet | None, count: int, most: int) -> list[Quantity]:
    times, states = (np.empty(0), np.empty((count, 0))) if limit_set is None else limit_set.samples(most)
    return [
        Quantity("limit_time", times, "time on what the motion tends to", "", "place"),
        Quantity("limit_states", states, "state on what the motion tends to", "", "state place"),
    ]


def system_run_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a run of equations."""
    s = result.wucht.summary
    if "cases" in s:
        return report_lines(result, s["sentence"], [("run", f"{c['label']}: {c['sentence']}") for c in s["cases"]])
    is_longer = s["outcome"] == "chaotic"  # examined beyond the stored states, for the time in the sentence
    lines = [("run", f"{'stored ' if is_longer else ''}until t = {s['end_time']:.6g}")]
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
