"""The answer: the probability at each value of the parameter, where the target is reached, what matters, and doubts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wucht.dynamics.sampling.arrangements import PREFIX, UNIFORM
from wucht.dynamics.sampling.distributions import Indices, replicate_count
from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.sampling.random_runs import ProbabilityPoint, RandomRuns
from wucht.dynamics.sampling.smallest_value import certain_fall, smallest_value
from wucht.results.formatting import percent
from wucht.studies.answer import Answer

# Runs, values of the parameter, samples (q, M), the value for the sensitivity with its samples (q, K), and warnings.
Prepared = tuple[RandomRuns, list[float], np.ndarray, tuple[float, np.ndarray] | None, tuple[str, ...]]
Cross = tuple[MemberOutcomes, Indices] | None  # runs of the sensitivity

_MOST_FAILURES, _MOST_NAMED = 3, 6  # runs that failed; values without a probability, and quantities of a run


def state_probabilities(a: Answer, prepared: Prepared, points: Sequence[ProbabilityPoint]) -> None:
    """State the probability at each value, with its band."""
    runs, grid, *_ = prepared
    along, level, by = runs.along, _level(runs), "parameter"
    a.curve("parameter", [p.value for p in points], along.full_name, along.unit)
    a.curve("estimate", [p.estimate for p in points], "probability", "", by)
    a.curve("low", [p.low for p in points], f"lower bound of the probability {level}", "", by)
    a.curve("high", [p.high for p in points], f"upper bound of the probability {level}", "", by)
    a.curve("not_identified", [p.open_share for p in points], "share of runs without a verdict", "", by)
    a.curve("searched", np.isin([p.value for p in points], grid, invert=True).astype(np.int8), "part of the search", "", by)
    rows = list[dict[str, Any]]()
    for k, p in enumerate(points):
        shares = {str(outcome): count / len(p.members.outcome) for outcome, count in p.members.counts().items()}
        estimate = None if p.is_undecided else p.estimate
        row = {along.path: p.value, "estimate": estimate, "low": p.low, "high": p.high, "not_identified": p.open_share}
        rows.append({**row, "fractions": shares})
        if p.impossible_share:
            rows[-1] |= {"impossible": p.impossible_share}
        if p.is_undecided:
            rows[-1] |= {"advice": p.advice, "advised_time": p.needed_time}
        share = "not known" if estimate is None else f"{100 * estimate:.3g} %"
        open_clause = f", {percent(p.open_share)} without a verdict" if p.open_share else ""
        rest_clause = f"; {percent(p.impossible_share)} of the runs cannot be made" if p.impossible_share else ""
        a.line("" if k else "probability", f"{_place(runs, p.value)}: {share} ({_band(p)}){open_clause}{rest_clause}")
    a.number("probability", rows, "probability at each value", parts={
        along.path: (along.full_name, along.unit),
        "estimate": ("probability", ""),
        "low": ("its lower bound", ""),
        "high": ("its upper bound", ""),
        "not_identified": ("share of runs without a verdict", ""),
        "fractions": ("shares of the runs by outcome", ""),
        "impossible": ("share of the runs that cannot be made", ""),
        "advice": ("why no run has a verdict", ""),
        "advised_time": ("sufficient time of a run", a.unit("time")),
    })  # fmt: skip


def state_target(a: Answer, prepared: Prepared, points: Sequence[ProbabilityPoint], target: float | None) -> None:
    """State the value from which the target probability is reached, and the answer in one sentence."""
    runs, grid, *_ = prepared
    along, known_points = runs.along, [p for p in points if not p.is_undecided]
    is_complete = len(points) >= len(grid)
    reached_value = smallest_value(points, target) if target is not None and is_complete else None
    a.number("wanted", target, "target probability")
    a.number("smallest", reached_value, "smallest value from which it is reached", along.unit)
    if not known_points:
        count = sum(len(p.members.outcome) for p in points)
        values = f"{len(points)} values of {along.sentence_name}"
        if not any(p.possible_count for p in points):
            a.sentence = f"there is no probability: none of {count} runs at {values} can be made ({points[0].advice})"
            return
        a.sentence = f"there is no probability: none of {count} runs at {values} has a verdict"
        return
    if target is not None and is_complete:
        a.sentence = _target_sentence(runs, points, target, reached_value)
        return
    first, last = known_points[0], known_points[-1]
    last_clause = "" if last is first else f", {_band(last)} at {along.value_text(last.value, 5)}"
    missing = len(points) - len(known_points)
    gaps = f"; no probability at {missing} of {len(points)} values" if missing else ""
    a.sentence = f"{_level(runs)} {_band(first)} {_ends(runs)} at {along.value_text(first.value, 5)}{last_clause}{gaps}"


def _target_sentence(runs: RandomRuns, points: Sequence[ProbabilityPoint], target: float, reached_value: float | None) -> str:
    along, last, sure = runs.along, points[-1], _level(runs)
    if last.is_undecided:
        return f"whether {target:g} is reached is not known: no run at {along.value_text(last.value, 5)} has a verdict"
    if (fall := certain_fall(points)) is not None:
        before, after = (f"{_band(x)} at {along.value_text(x.value, 5)}" for x in fall)
        falls = f"the share that ends as {' or '.join(runs.counted_outcomes)} falls from {before} to {after}"
        return f"no smallest {along.sentence_name}: {sure} {falls}"
    if reached_value is None:
        there = f"there {sure} {_band(last)} {_ends(runs)}"
        return f"{target:g} is not reached up to {along.value_text(last.value, 5)}: {there}"
    note = ", the lowest computed value" if reached_value == points[0].value else ""
    return f"{sure} at least {target:g} {_ends(runs)} from {along.value_text(reached_value, 5)} on{note}"


def state_runs(a: Answer, prepared: Prepared, points: Sequence[ProbabilityPoint], cross: Cross, names: Sequence[str]) -> None:
    """State how many runs were made, the influence of each random quantity, and how long runs without a verdict must be.

    names: of the random quantities.
    """
    runs, grid, samples, *_ = prepared
    search_count, missing = max(len(points) - len(grid), 0), sum(p.is_undecided for p in points)
    count = sum(len(p.members.outcome) for p in points) + (0 if cross is None else len(cross[0].outcome))
    size = a.number("samples", samples.shape[1], "number of runs at each value")
    a.number("replicates", replicate_count(samples.shape[1]), "number of independent sets of random points")
    a.number("searched", search_count, "number of values of the search")
    a.number("runs", count, "number of runs")
    a.number("impossible", sum(len(p.members.outcome) - p.possible_count for p in points), "number of runs that cannot be made")
    a.number("values", [len(points) - search_count, len(grid)], "number of computed values, and of all")
    search_clause = f", {search_count} of them for the search" if search_count else ""
    incomplete = [p for p in points if len(p.members.outcome) < size]
    fewer = f"; fewer at {missing} of them, where none has a verdict" if incomplete else ""
    if any(not p.is_undecided for p in incomplete):
        fewer = f"; fewer so far at {len(incomplete)} of them"
    a.line("runs", f"{count}: {size} at each of {len(points)} values{search_clause}{fewer}")
    _state_sensitivity(a, prepared, cross, names)
    longest = _longest_undecided(points)
    a.number("advice", longest and longest.advice, "advice, where all runs of a value are undecided")
    a.number("advised_time", longest and longest.needed_time, "sufficient time of a run", "time")
    a.number("model", runs.question.model, "equations")
    a.line("integrated", a.number("integration", integration_note(runs.question_at(grid[0])), "method of integration"))


def _state_sensitivity(a: Answer, prepared: Prepared, cross: Cross, names: Sequence[str]) -> None:
    runs, _, _, sensitivity, _ = prepared
    what = "shares of the variance of the outcome, by random quantity"
    if cross is None or sensitivity is None:
        a.number("sensitivity", None, what)
        return
    (members, sobol), at = cross, _place(runs, sensitivity[0])
    off = f"uncertainty of the index {_level(runs)}"
    columns = {
        "first_order": (sobol.first, "first-order Sobol' index"),
        "first_order_off": (sobol.first_off, off),
        "total": (sobol.total, "total Sobol' index"),
        "total_off": (sobol.total_off, off),
    }
    a.curve("quantity", list(names), "random quantity")
    for key, (values, words) in columns.items():
        a.curve(key, values, words, "", "quantity")
    by_name = {name: {key: float(values[k]) for key, (values, _) in columns.items()} for k, name in enumerate(names)}
    is_known = np.isfinite(sobol.first).all()
    numbers = {"at": sensitivity[0], "runs": len(members.outcome), "used": [sobol.used_points, sobol.count]}
    a.number("sensitivity", numbers | {"indices": by_name if is_known else None}, what)
    if not is_known:
        a.line("sensitivity", f"at {at} no random quantity matters: all runs have the same outcome")
        return
    share = f"share of the variance of the outcome, alone and with interactions ({len(members.outcome)} runs)"
    a.line("sensitivity", f"at {at}, {share}")
    for name, i in sorted(by_name.items(), key=lambda one: -one[1]["total"]):
        alone, together = (f"{i[key]:.2f} ± {i[f'{key}_off']:.2f}" for key in ("first_order", "total"))
        a.line("", f"{name}: {alone} alone, {together} with interactions")


def warn(a: Answer, prepared: Prepared, points: Sequence[ProbabilityPoint], cross: Cross) -> None:
    """Warn of values that are not computed, of runs without a verdict, and of those that failed."""
    runs, grid, _, sensitivity, omissions = prepared
    along, undecided_points = runs.along, [p for p in points if p.is_undecided]
    a.warn(*omissions)
    if (missing := len(grid) - len(points)) > 0:
        a.warn(f"{missing} of the {len(grid)} values of {along.sentence_name} are not computed yet")
    if impossible := [p for p in points if p.impossible_share]:
        worst = max(impossible, key=lambda p: p.impossible_share)
        words = f"up to {percent(worst.impossible_share)} of the runs (at {along.value_text(worst.value, 5)}) cannot be made"
        tracks = [f"{PREFIX}{track.name}" for track in runs.question.machine.tracks]
        undrawn = [name for name in tracks if not any(v.name.startswith(f"{name}.") for v in runs.quantities)]
        hint = f'; random = {{ "{undrawn[0]}" = "{UNIFORM}" }} draws arrangements in which no bodies overlap' if undrawn else ""
        a.warn(f"{words}: they are left out, and the probability is that of the other ones{hint}")
    if undecided_points:
        a.warn(_undecided_in_words(a, runs, undecided_points))
    if sensitivity is not None and len(undecided_points) == len(points):
        a.warn("the sensitivity is not computed: no run at any value has a verdict")
    if open_points := [p for p in points if p.open.any() and not p.is_undecided]:
        worst = max(open_points, key=lambda p: p.open_share)
        longer = "; a longer study.until may identify them" if runs.question.until is not None else ""
        words = f"up to {percent(worst.open_share)} of the runs (at {along.value_text(worst.value, 5)}) have no verdict"
        a.warn(f"{words}: they may count or not, which widens the band{longer}")
    if cross is not None and sensitivity is not None:
        sobol = cross[1]
        if np.isnan(sobol.first).any():
            nothing = "all runs with a verdict have one outcome: no random quantity matters there"
            a.warn(f"at {along.value_text(sensitivity[0], 5)} {nothing}")
        if sobol.used_points < sobol.count:
            share = percent(1 - sobol.used_points / sobol.count)
            a.warn(f"{share} of the sensitivity's points have runs without a verdict and are left out of the indices")
    _warn_of_failures(a, prepared, points, cross)


def _undecided_in_words(a: Answer, runs: RandomRuns, points: Sequence[ProbabilityPoint]) -> str:
    """Name the values at which no run has a verdict, and what to change: the advice of a run that needs the longest time."""
    longest, along = _longest_undecided(points), runs.along
    values = ", ".join(f"{p.value:.5g}" for p in points[:_MOST_NAMED])
    more = f" and {len(points) - _MOST_NAMED} more values" if len(points) > _MOST_NAMED else ""
    places = f"{along.sentence_name} = {values}{more}" + f" {along.unit}".rstrip()
    reason = f" ({longest.advice})" if longest is not None and longest.advice else ""
    remedy = "give study.until" if runs.question.until is None else f"give a longer study.until than {runs.question.until:g}"
    unit = f" {a.unit('time')}".rstrip()
    longer = remedy if longest is None or longest.needed_time is None else f"{remedy}, as {longest.needed_time:g}{unit}"
    return f"there is no probability at {places}: no run there has a verdict{reason}, and any share is possible; {longer}"


def _warn_of_failures(a: Answer, prepared: Prepared, points: Sequence[ProbabilityPoint], cross: Cross) -> None:
    runs, _, samples, sensitivity, _ = prepared
    columns = samples.reshape(len(samples), replicate_count(samples.shape[1]), -1)  # of a point those of its first runs
    run_sets = [
        (p.value, p.members, columns[:, :, : len(p.members.outcome) // columns.shape[1]].reshape(len(samples), -1))
        for p in points
    ]
    if cross is not None and sensitivity is not None:
        run_sets.append((sensitivity[0], cross[0], sensitivity[1]))
    failures = [(value, places[:, m], reason) for value, members, places in run_sets for m, reason in members.failures]
    for value, place, reason in failures[:_MOST_FAILURES]:
        values = [f"{v.name} = {x:.6g}" for v, x in zip(runs.quantities, place, strict=True)]
        location = ", ".join(values[:_MOST_NAMED]) + (" and more" if len(values) > _MOST_NAMED else "")
        a.warn(f"the run at {runs.along.value_text(value, 5)}, {location} failed: {reason}")
    if len(failures) > _MOST_FAILURES:
        a.warn(f"{len(failures) - _MOST_FAILURES} more runs failed")


def _longest_undecided(points: Sequence[ProbabilityPoint]) -> ProbabilityPoint | None:
    """Return the point without a verdict that needs the longest runs; None where there is no such point."""
    return max((p for p in points if p.is_undecided), key=lambda p: p.needed_time or 0.0, default=None)


def _level(runs: RandomRuns) -> str:
    return f"with {100 * runs.confidence:g} % confidence"


def _place(runs: RandomRuns, value: float) -> str:
    return f"{runs.along.path} = {value:.5g} {runs.along.unit}".rstrip()


def _band(point: ProbabilityPoint) -> str:
    return f"{100 * point.low:.3g} to {100 * point.high:.3g} %"


def _ends(runs: RandomRuns) -> str:
    states = {v.state is not None for v in runs.quantities}
    noun = "runs" if len(states) > 1 else "starts" if True in states else "machines"
    return f"of the {noun} end as {' or '.join(runs.counted_outcomes)}"
