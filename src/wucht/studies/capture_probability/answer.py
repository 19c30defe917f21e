"""Findings -> the quantities of a probability over a parameter and of the sensitivity, and their lines in a report."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.sampling.searches import fall_of, smallest
from wucht.results.formatting import in_lines, percent
from wucht.results.quantities import Quantity, answer, table
from wucht.studies.capture_probability.computation import Findings, Plan, Point
from wucht.studies.capture_probability.distributions import KINDS, REPLICATES

if TYPE_CHECKING:
    import xarray as xr


_MOST_FAILURES = 3  # listed individually


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a probability over a parameter; for a sensitivity with the indices of the random quantities."""
    quantities = [*_of_points(plan, findings), *_of_indices(plan, findings), *_summary(plan, findings)]
    return answer(quantities, _sentence(plan, findings, _complete(plan, findings)), _warnings(plan, findings))


def _level(plan: Plan) -> str:
    return f"with {100 * plan.spec.confidence:g} % confidence"


def _of_points(plan: Plan, findings: Findings) -> list[Quantity]:
    points, along, level, by = findings.points, plan.along, _level(plan), "parameter"
    return [
        Quantity("parameter", [p.value for p in points], along.words, along.unit, by),
        Quantity("estimate", [p.estimate for p in points], "probability", "", by),
        Quantity("low", [p.bounds.low for p in points], f"lower bound of the probability {level}", "", by),
        Quantity("high", [p.bounds.high for p in points], f"upper bound of the probability {level}", "", by),
        Quantity("not_identified", [_open(p) for p in points], "share of runs without a verdict", "", by),
        Quantity("searched", np.array([p.searched for p in points], np.int8), "part of the search", "", by),
    ]


def _of_indices(plan: Plan, findings: Findings) -> list[Quantity]:
    indices, by = findings.indices, "quantity"
    if indices is None:
        return []
    off = f"uncertainty of the index {_level(plan)}"
    return [
        Quantity("quantity", [v.name for v in plan.varied], "random quantity", "", by),
        Quantity("first_order", indices.first, "first-order Sobol' index", "", by),
        Quantity("first_order_off", indices.first_off, off, "", by),
        Quantity("total", indices.total, "total Sobol' index", "", by),
        Quantity("total_off", indices.total_off, off, "", by),
    ]


def _open(point: Point) -> float:
    return float(point.open.sum()) / len(point.members.outcome)


def _complete(plan: Plan, findings: Findings) -> bool:
    return sum(not p.searched for p in findings.points) == len(plan.grid)


def _summary(plan: Plan, findings: Findings) -> list[Quantity]:
    spec, points, along = plan.spec, findings.points, plan.along
    searched, wanted = sum(p.searched for p in points), spec.probability
    at = smallest(findings.bounds, wanted) if wanted is not None and _complete(plan, findings) else None
    runs = sum(len(p.members.outcome) for p in points) + (0 if findings.cross is None else len(findings.cross.outcome))
    rows = [{along.path: p.value} | _numbers(p) for p in points]
    parts = {
        along.path: (along.words, along.unit),
        "estimate": ("probability", ""),
        "low": ("its lower bound", ""),
        "high": ("its upper bound", ""),
        "not_identified": ("share of runs without a verdict", ""),
        "fractions": ("shares of the runs by outcome", ""),
    }
    return [
        Quantity("along", along.path, "parameter"),
        Quantity("unit", along.unit, "its unit"),
        Quantity("range", [plan.grid[0], plan.grid[-1]], "its least and greatest value", along.unit),
        Quantity("outcome", list(spec.outcome), "counted outcomes"),
        Quantity("confidence", spec.confidence, "confidence of the bounds"),
        Quantity("wanted", wanted, "target probability"),
        Quantity("smallest", at, "smallest value from which it is reached", along.unit),
        *table("probability", rows, "probability at each value", parts),
        Quantity("random", {name: _in_words(given) for name, given in spec.random.items()}, "random quantities"),
        Quantity("samples", spec.samples, "number of runs at each value"),
        Quantity("replicates", REPLICATES, "number of independent sets of random points"),
        Quantity("searched", searched, "number of values of the search"),
        Quantity("runs", runs, "number of runs"),
        Quantity("values", [len(points) - searched, len(plan.grid)], "number of computed values, and of all"),
        Quantity("sensitivity", _sensitivity(plan, findings), "shares of the variance of the outcome, by random quantity"),
        Quantity("model", spec.model, "equations"),
        Quantity("integration", plan.way, "method of integration"),
    ]


def _numbers(point: Point) -> dict[str, Any]:
    counts, total = point.members.counts(), len(point.members.outcome)
    return {
        "estimate": None if math.isnan(point.estimate) else point.estimate,
        "low": point.bounds.low,
        "high": point.bounds.high,
        "not_identified": _open(point),
        "fractions": {str(outcome): k / total for outcome, k in counts.items()},
    }


def _in_words(given: dict[str, Any]) -> str:
    """A distribution in words: ``uniform: low 0 deg, high 360 deg``."""
    kind = next(k for k in given if k in KINDS)
    named = ", ".join(f"{name} {value}" for name, value in zip(KINDS[kind], given[kind], strict=True))
    return f"{kind}: {named}" + (", between {} and {}".format(*given["between"]) if "between" in given else "")


def _sensitivity(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    found = findings.indices
    if found is None or findings.cross is None:
        return None
    each = zip(plan.varied, found.first, found.first_off, found.total, found.total_off, strict=True)
    known = np.isfinite(found.first).all()
    return {
        "at": plan.at,
        "runs": len(findings.cross.outcome),
        "used": [found.used, found.count],
        "indices": {
            v.name: {"first_order": float(a), "first_order_off": float(b), "total": float(c), "total_off": float(d)}
            for v, a, b, c, d in each
        }
        if known
        else None,
    }


def _at(plan: Plan, value: float) -> str:
    return plan.along.at(value, 5)


def _whose(plan: Plan) -> str:
    states = {v.state is not None for v in plan.varied}
    return "runs" if len(states) > 1 else "starts" if True in states else "machines"


def _sentence(plan: Plan, findings: Findings, complete: bool) -> str:
    if not findings.points:
        return ""
    spec, first, last = plan.spec, findings.points[0], findings.points[-1]
    sure, wanted = f"with {100 * spec.confidence:g} % confidence", spec.probability
    ends = f"of the {_whose(plan)} end as {' or '.join(spec.outcome)}"
    if wanted is None or not complete:
        others = "" if last is first else f", {_share(last)} at {_at(plan, last.value)}"
        return f"{sure} {_share(first)} {ends} at {_at(plan, first.value)}{others}"
    seen = findings.bounds
    if (fall := fall_of(seen)) is not None:
        before, after = (
            f"{100 * x.low:.3g} to {100 * x.high:.3g} % at {_at(plan, x.value)}" for x in (fall.before, fall.after)
        )
        falls = f"the share that ends as {' or '.join(spec.outcome)} falls from {before} to {after}"
        return f"no smallest {plan.along.called}: {sure} {falls}"
    found = smallest(seen, wanted)
    if found is None:
        return f"{wanted:g} is not reached up to {_at(plan, last.value)}: there {sure} {_share(last)} {ends}"
    note = ", the lowest computed value" if found == first.value else ""
    return f"{sure} at least {wanted:g} {ends} from {_at(plan, found)} on{note}"


def _share(point: Point) -> str:
    return f"{100 * point.bounds.low:.3g} to {100 * point.bounds.high:.3g} %"


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    warnings, points = list(plan.warnings), findings.points
    if (missing := len(plan.grid) - sum(not p.searched for p in points)) > 0:
        warnings.append(f"{missing} of the {len(plan.grid)} values of {plan.along.called} are not computed yet")
    if (unknown := [p for p in points if p.open.any()]) != []:
        worst = max(unknown, key=_open)
        longer = "; a longer study.until may identify them" if plan.spec.until is not None else ""
        words = f"up to {percent(_open(worst))} of the runs (at {_at(plan, worst.value)}) have no verdict"
        warnings.append(f"{words}: they may count or not, which widens the band{longer}")
    if (found := findings.indices) is not None and plan.at is not None:
        if np.isnan(found.first).any():
            warnings.append(
                f"at {_at(plan, plan.at)} all runs with a verdict have one outcome: no random quantity matters there"
            )
        if found.used < found.count:
            share = percent(1 - found.used / found.count)
            warnings.append(f"{share} of the sensitivity's points have runs without a verdict and are left out of the indices")
    return [*warnings, *_failures(plan, findings)]


def _failures(plan: Plan, findings: Findings) -> list[str]:
    told: list[tuple[float, MemberOutcomes, np.ndarray]] = [(p.value, p.members, plan.samples) for p in findings.points]
    if findings.cross is not None and plan.cross is not None and plan.at is not None:
        told.append((plan.at, findings.cross, plan.cross))
    failures = [(value, samples[:, m], why) for value, members, samples in told for m, why in members.failures]
    sentences = []
    for value, place, why in failures[:_MOST_FAILURES]:
        where = ", ".join(f"{v.name} = {x:.6g}" for v, x in zip(plan.varied, place, strict=True))
        sentences.append(f"the run at {_at(plan, value)}, {where} failed: {why}")
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
    searched = f", {s['searched']} of them for the search" if s["searched"] else ""
    lines.append(("runs", f"{s['runs']}: {s['samples']} at each of {len(s['probability'])} values{searched}"))
    lines += _sensitivity_lines(s)
    lines.append(("integrated", s["integration"]))
    return in_lines(result, s["sentence"] or "nothing is computed yet", lines)


def _share_in_words(one: dict[str, Any]) -> str:
    estimate = "not known" if one["estimate"] is None else f"{100 * one['estimate']:.3g} %"
    unknown = f", {percent(one['not_identified'])} without a verdict" if one["not_identified"] else ""
    return f"{estimate} ({100 * one['low']:.3g} to {100 * one['high']:.3g} %){unknown}"


def _sensitivity_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    asked = s["sensitivity"]
    if asked is None:
        return []
    at = f"at {s['along']} = {asked['at']:.5g}" + (f" {s['unit']}" if s["unit"] else "")
    if asked["indices"] is None:
        return [("sensitivity", f"{at} no random quantity matters: all runs have the same outcome")]
    order = sorted(asked["indices"].items(), key=lambda one: -one[1]["total"])
    lines = [("sensitivity", f"{at}, share of the variance of the outcome, alone and with interactions ({asked['runs']} runs)")]
    for name, i in order:
        alone, together = (f"{i[key]:.2f} ± {i[f'{key}_off']:.2f}" for key in ("first_order", "total"))
        lines.append(("", f"{name}: {alone} alone, {together} with interactions"))
    return lines
