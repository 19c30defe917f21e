"""Findings -> the quantities of a probability over a parameter and of the sensitivity, and their lines in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.sampling.ensemble_run import RunAdvice
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.sampling.searches import certain_fall, smallest_value
from wucht.results.formatting import percent, report_lines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.capture_probability.computation import Findings, Plan, ProbabilityPoint
from wucht.studies.capture_probability.distributions import KINDS, REPLICATES

if TYPE_CHECKING:
    import xarray as xr


_MOST_FAILURES, _MOST_NAMED = 3, 6  # runs that failed; values without a probability


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a probability over a parameter; for a sensitivity with the indices of the random quantities."""
    quantities = [*_point_quantities(plan, findings), *_index_quantities(plan, findings), *_summary_quantities(plan, findings)]
    return result_dataset(quantities, _sentence(plan, findings, _is_complete(plan, findings)), _warnings(plan, findings))


def _level(plan: Plan) -> str:
    return f"with {100 * plan.spec.confidence:g} % confidence"


def _point_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    points, along, level, by = findings.points, plan.along, _level(plan), "parameter"
    return [
        Quantity("parameter", [p.value for p in points], along.full_name, along.unit, by),
        Quantity("estimate", [p.estimate for p in points], "probability", "", by),
        Quantity("low", [p.bounds.low for p in points], f"lower bound of the probability {level}", "", by),
        Quantity("high", [p.bounds.high for p in points], f"upper bound of the probability {level}", "", by),
        Quantity("not_identified", [_open_share(p) for p in points], "share of runs without a verdict", "", by),
        Quantity("searched", np.array([p.is_from_search for p in points], np.int8), "part of the search", "", by),
    ]


def _index_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    indices, by = findings.indices, "quantity"
    if indices is None:
        return []
    off = f"uncertainty of the index {_level(plan)}"
    return [
        Quantity("quantity", [v.name for v in plan.random_quantities], "random quantity", "", by),
        Quantity("first_order", indices.first, "first-order Sobol' index", "", by),
        Quantity("first_order_off", indices.first_off, off, "", by),
        Quantity("total", indices.total, "total Sobol' index", "", by),
        Quantity("total_off", indices.total_off, off, "", by),
    ]


def _open_share(point: ProbabilityPoint) -> float:
    return float(point.open.sum()) / len(point.members.outcome)


def _is_complete(plan: Plan, findings: Findings) -> bool:
    return sum(not p.is_from_search for p in findings.points) == len(plan.grid)


def _summary_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    spec, points, along = plan.spec, findings.points, plan.along
    search_count, target = sum(p.is_from_search for p in points), spec.probability
    at = smallest_value(findings.bounds, target) if target is not None and _is_complete(plan, findings) else None
    runs = sum(len(p.members.outcome) for p in points) + (0 if findings.cross is None else len(findings.cross.outcome))
    rows, advice = [{along.path: p.value} | _numbers(p) for p in points], _advice(findings)
    parts = {
        along.path: (along.full_name, along.unit),
        "estimate": ("probability", ""),
        "low": ("its lower bound", ""),
        "high": ("its upper bound", ""),
        "not_identified": ("share of runs without a verdict", ""),
        "fractions": ("shares of the runs by outcome", ""),
        "advice": ("why no run has a verdict", ""),
        "advised_time": ("sufficient time of a run", plan.machine.units.time),
    }
    return [
        Quantity("along", along.path, "parameter"),
        Quantity("unit", along.unit, "its unit"),
        Quantity("range", [plan.grid[0], plan.grid[-1]], "its least and greatest value", along.unit),
        Quantity("outcome", list(spec.outcome), "counted outcomes"),
        Quantity("confidence", spec.confidence, "confidence of the bounds"),
        Quantity("wanted", target, "target probability"),
        Quantity("smallest", at, "smallest value from which it is reached", along.unit),
        *table("probability", rows, "probability at each value", parts),
        Quantity(
            "random",
            {name: _distribution_in_words(definition) for name, definition in spec.random.items()},
            "random quantities",
        ),
        Quantity("samples", spec.samples, "number of runs at each value"),
        Quantity("replicates", REPLICATES, "number of independent sets of random points"),
        Quantity("searched", search_count, "number of values of the search"),
        Quantity("runs", runs, "number of runs"),
        Quantity("values", [len(points) - search_count, len(plan.grid)], "number of computed values, and of all"),
        Quantity("sensitivity", _sensitivity(plan, findings), "shares of the variance of the outcome, by random quantity"),
        Quantity("advice", advice and advice.sentence, "advice, where all runs of a value are undecided"),
        Quantity("advised_time", advice and advice.needed_time, "sufficient time of a run", plan.machine.units.time),
        Quantity("model", spec.model, "equations"),
        Quantity("integration", plan.way, "method of integration"),
    ]


def _numbers(point: ProbabilityPoint) -> dict[str, Any]:
    counts, total = point.members.counts(), len(point.members.outcome)
    return {
        "estimate": None if math.isnan(point.estimate) else point.estimate,
        "low": point.bounds.low,
        "high": point.bounds.high,
        "not_identified": _open_share(point),
        "fractions": {str(outcome): k / total for outcome, k in counts.items()},
        **({} if point.advice is None else {"advice": point.advice.sentence, "advised_time": point.advice.needed_time}),
    }


def _advice(findings: Findings) -> RunAdvice | None:
    """Return the advice of the value without a verdict that needs the longest runs; None where there is no such value."""
    advice = [p.advice for p in findings.points if p.advice is not None]
    return max(advice, key=lambda a: a.needed_time or 0.0, default=None)


def _distribution_in_words(definition: dict[str, Any]) -> str:
    """A distribution in words: ``uniform: low 0 deg, high 360 deg``."""
    kind = next(k for k in definition if k in KINDS)
    numbers = ", ".join(f"{name} {value}" for name, value in zip(KINDS[kind], definition[kind], strict=True))
    return f"{kind}: {numbers}" + (", between {} and {}".format(*definition["between"]) if "between" in definition else "")


def _sensitivity(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    indices = findings.indices
    if indices is None or findings.cross is None:
        return None
    rows = zip(plan.random_quantities, indices.first, indices.first_off, indices.total, indices.total_off, strict=True)
    is_known = np.isfinite(indices.first).all()
    return {
        "at": plan.at,
        "runs": len(findings.cross.outcome),
        "used": [indices.used_points, indices.count],
        "indices": {
            v.name: {"first_order": float(a), "first_order_off": float(b), "total": float(c), "total_off": float(d)}
            for v, a, b, c, d in rows
        }
        if is_known
        else None,
    }


def _value_in_words(plan: Plan, value: float) -> str:
    return plan.along.value_text(value, 5)


def _sample_word(plan: Plan) -> str:
    states = {v.state is not None for v in plan.random_quantities}
    return "runs" if len(states) > 1 else "starts" if True in states else "machines"


def _sentence(plan: Plan, findings: Findings, complete: bool) -> str:
    if not findings.points:
        return ""
    if findings.is_undecided:
        count = sum(len(p.members.outcome) for p in findings.points)
        values = f"{len(findings.points)} values of {plan.along.sentence_name}"
        return f"there is no probability: none of {count} runs at {values} has a verdict"
    if plan.spec.probability is not None and complete:
        return _target_sentence(plan, findings, plan.spec.probability)
    known_points = [p for p in findings.points if not p.is_undecided]
    first, last = known_points[0], known_points[-1]
    last_clause = "" if last is first else f", {_share(last)} at {_value_in_words(plan, last.value)}"
    missing = len(findings.points) - len(known_points)
    unknown = f"; no probability at {missing} of {len(findings.points)} values" if missing else ""
    return f"{_level(plan)} {_share(first)} {_ends(plan)} at {_value_in_words(plan, first.value)}{last_clause}{unknown}"


def _ends(plan: Plan) -> str:
    return f"of the {_sample_word(plan)} end as {' or '.join(plan.spec.outcome)}"


def _target_sentence(plan: Plan, findings: Findings, target: float) -> str:
    """Say from which value on the target probability is reached, if it is."""
    bounds, first, last, sure = findings.bounds, findings.points[0], findings.points[-1], _level(plan)
    if last.is_undecided:
        return f"whether {target:g} is reached is not known: no run at {_value_in_words(plan, last.value)} has a verdict"
    if (fall := certain_fall(bounds)) is not None:
        before, after = (
            f"{100 * x.low:.3g} to {100 * x.high:.3g} % at {_value_in_words(plan, x.value)}" for x in (fall.before, fall.after)
        )
        falls = f"the share that ends as {' or '.join(plan.spec.outcome)} falls from {before} to {after}"
        return f"no smallest {plan.along.sentence_name}: {sure} {falls}"
    reached_value = smallest_value(bounds, target)
    if reached_value is None:
        return f"{target:g} is not reached up to {_value_in_words(plan, last.value)}: there {sure} {_share(last)} {_ends(plan)}"
    note = ", the lowest computed value" if reached_value == first.value else ""
    return f"{sure} at least {target:g} {_ends(plan)} from {_value_in_words(plan, reached_value)} on{note}"


def _share(point: ProbabilityPoint) -> str:
    return f"{100 * point.bounds.low:.3g} to {100 * point.bounds.high:.3g} %"


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    warnings, points = list(plan.warnings), findings.points
    if (missing := len(plan.grid) - sum(not p.is_from_search for p in points)) > 0:
        warnings.append(f"{missing} of the {len(plan.grid)} values of {plan.along.sentence_name} are not computed yet")
    if (undecided_points := [p for p in points if p.is_undecided]) != []:
        warnings.append(_undecided_in_words(plan, undecided_points, _advice(findings)))
    if plan.cross is not None and points and findings.is_undecided:
        warnings.append("the sensitivity is not computed: no run at any value has a verdict")
    if (unknown := [p for p in points if p.open.any() and not p.is_undecided]) != []:
        worst = max(unknown, key=_open_share)
        longer = "; a longer study.until may identify them" if plan.spec.until is not None else ""
        words = f"up to {percent(_open_share(worst))} of the runs (at {_value_in_words(plan, worst.value)}) have no verdict"
        warnings.append(f"{words}: they may count or not, which widens the band{longer}")
    if (indices := findings.indices) is not None and plan.at is not None:
        if np.isnan(indices.first).any():
            warnings.append(
                f"at {_value_in_words(plan, plan.at)} all runs with a verdict have one outcome: no random "
                "quantity matters there"
            )
        if indices.used_points < indices.count:
            share = percent(1 - indices.used_points / indices.count)
            warnings.append(f"{share} of the sensitivity's points have runs without a verdict and are left out of the indices")
    return [*warnings, *_failure_sentences(plan, findings)]


def _undecided_in_words(plan: Plan, points: Sequence[ProbabilityPoint], advice: RunAdvice | None) -> str:
    """Name the values at which no run has a verdict, and what to change: the advice of a run that needs the longest time."""
    values = ", ".join(f"{p.value:.5g}" for p in points[:_MOST_NAMED])
    more = f" and {len(points) - _MOST_NAMED} more values" if len(points) > _MOST_NAMED else ""
    places = f"{plan.along.sentence_name} = {values}{more}" + f" {plan.along.unit}".rstrip()
    reason = f" ({advice.sentence})" if advice is not None and advice.sentence else ""
    remedy = "give study.until" if plan.spec.until is None else f"give a longer study.until than {plan.spec.until:g}"
    unit = f" {plan.machine.units.time}".rstrip()
    longer = remedy if advice is None or advice.needed_time is None else f"{remedy}, as {advice.needed_time:g}{unit}"
    return f"there is no probability at {places}: no run there has a verdict{reason}, and any share is possible; {longer}"


def _failure_sentences(plan: Plan, findings: Findings) -> list[str]:
    runs: list[tuple[float, MemberOutcomes, np.ndarray]] = [
        (p.value, p.members, plan.samples[:, :: plan.replicate_size // p.replicate_size]) for p in findings.points
    ]
    if findings.cross is not None and plan.cross is not None and plan.at is not None:
        runs.append((plan.at, findings.cross, plan.cross))
    failures = [(value, samples[:, m], reason) for value, members, samples in runs for m, reason in members.failures]
    sentences = []
    for value, place, reason in failures[:_MOST_FAILURES]:
        location = ", ".join(f"{v.name} = {x:.6g}" for v, x in zip(plan.random_quantities, place, strict=True))
        sentences.append(f"the run at {_value_in_words(plan, value)}, {location} failed: {reason}")
    if len(failures) > _MOST_FAILURES:
        sentences.append(f"{len(failures) - _MOST_FAILURES} more runs failed")
    return sentences


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a probability."""
    s = result.wucht.summary
    lines = [("random" if not k else "", f"{name} {words}") for k, (name, words) in enumerate(s["random"].items())]
    for k, one in enumerate(p for p in s["probability"] if p is not None):
        value = f"{s['along']} = {one[s['along']]:.5g}" + (f" {s['unit']}" if s["unit"] else "")
        lines.append(("" if k else "probability", f"{value}: {_share_in_words(one)}"))
    search_clause = f", {s['searched']} of them for the search" if s["searched"] else ""
    lines.append(("runs", _runs_in_words(s, search_clause)))
    lines += _sensitivity_lines(s)
    lines.append(("integrated", s["integration"]))
    return report_lines(result, s["sentence"] or "nothing is computed yet", lines)


def _runs_in_words(s: dict[str, Any], search_clause: str) -> str:
    values, missing = len(s["probability"]), sum(p["estimate"] is None for p in s["probability"])
    fewer = f"; fewer at {missing} of them, where none has a verdict" if s["runs"] < s["samples"] * values else ""
    return f"{s['runs']}: {s['samples']} at each of {values} values{search_clause}{fewer}"


def _share_in_words(one: dict[str, Any]) -> str:
    estimate = "not known" if one["estimate"] is None else f"{100 * one['estimate']:.3g} %"
    unknown = f", {percent(one['not_identified'])} without a verdict" if one["not_identified"] else ""
    return f"{estimate} ({100 * one['low']:.3g} to {100 * one['high']:.3g} %){unknown}"


def _sensitivity_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    sensitivity = s["sensitivity"]
    if sensitivity is None:
        return []
    at = f"at {s['along']} = {sensitivity['at']:.5g}" + (f" {s['unit']}" if s["unit"] else "")
    if sensitivity["indices"] is None:
        return [("sensitivity", f"{at} no random quantity matters: all runs have the same outcome")]
    order = sorted(sensitivity["indices"].items(), key=lambda one: -one[1]["total"])
    lines = [
        ("sensitivity", f"{at}, share of the variance of the outcome, alone and with interactions ({sensitivity['runs']} runs)")
    ]
    for name, i in order:
        alone, together = (f"{i[key]:.2f} ± {i[f'{key}_off']:.2f}" for key in ("first_order", "total"))
        lines.append(("", f"{name}: {alone} alone, {together} with interactions"))
    return lines
