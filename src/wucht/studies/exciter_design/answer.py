"""The answer on a design: the target, candidates and runs, the design with its spectrum, and what it was compared with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wucht.dynamics.exciters.design_search import nearest_that_beats
from wucht.dynamics.exciters.design_trials import (
    METRICS,
    Candidates,
    CheckedCandidate,
    DesignTrials,
    damage_weighted_cycles,
    spectrum_distances,
)
from wucht.dynamics.exciters.slow_beats import MOTIONS
from wucht.dynamics.run_ups.machine_signals import MachineSignal
from wucht.dynamics.sampling.choice import Cliff
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import amplitudes_at, cycle_shares, spectrum_form
from wucht.results.formatting import decimal_text, number_text
from wucht.studies.answer import Answer

_HOUR = 3600.0
_CLASSES, _MOST_ROWS = 100, 200  # of the spectrum in the summary, where it has more different ranges
_QUANTILES = {"q05": 0.05, "median": 0.5, "q95": 0.95}
_DISTANCE_MEANINGS = {
    "amplitude": "of its largest amplitude, on average",
    "cumulative": "of the cycles, at most",
    "damage": "of the damage, at most",
}
_BEATING_SHARE = 0.9  # share of exciters within tolerances that beat: a smaller one is warned of
_DISTANCE_RATIO = 1.5  # of the distances in the full and the averaged equations: a larger ratio is warned of
_MISSED_SHARE = 1e-3  # of the target's cycles: more cycles above the largest reached amplitude are warned of


def state_design(
    a: Answer,
    trials: DesignTrials,
    nominal: np.ndarray,
    target: LoadCycles,
    signal: MachineSignal,
    doubts: Sequence[str],
    step: float,
    spread: float,
    reach: Sequence[Candidates] = (),
    search: Sequence[Candidates] = (),
    optima: Sequence[tuple[np.ndarray, float]] = (),
    runs: Sequence[CheckedCandidate] = (),
    checks: Sequence[CheckedCandidate] = (),
    cliff: Cliff | None = None,
    tolerances: Sequence[Candidates] = (),
    is_complete: bool = False,
) -> None:
    """State what is known of a design.

    nominal: values of the variables (k,) as they are. doubts: about the averaged equations. step: relative distance of the
    neighbours. spread: of the exciters within tolerances. reach, search: random points and generations. optima: of local
    searches. runs: candidates in the full equations, those of corrections last. checks: the best of these, its neighbours and
    the nominal exciter, by later beats; cliff: of the design.
    """
    design, candidates = nearest_that_beats(checks or runs, trials.metric), [*reach, *search]
    a.warn(*doubts)
    _state_spectra(a, target, signal, design)
    _state_variables(a, trials, nominal, signal)
    _state_beat(a, signal, design)
    for name, along, batches in (
        ("reach", "point", reach),
        ("tried", "candidate", candidates),
        ("tolerance", "sample", tolerances),
    ):
        _state_candidates(a, trials, batches, name, along, signal.unit)
    motions = _state_motions(a, candidates)
    _state_reach(a, reach, signal.unit)
    _state_runs(a, trials, target, runs, optima)
    a.curve("motion", np.array(MOTIONS, str), "motion in the averaged equations")
    if design is None:
        a.sentence = "none of the candidates beats" if is_complete else "no exciter that beats so far"
        if is_complete:
            a.warn(
                f"no candidate beats: {motions}; try other ranges, a pendulum whose unbalance is not that of the rotor, or a "
                "weaker motor"
            )
    else:
        metric, distance = METRICS[trials.metric], design.distances[trials.metric]
        a.sentence = f"the spectrum is met within {100 * distance:.2f} % {_DISTANCE_MEANINGS[metric]}, in the full equations"
    _state_design(a, trials, target, signal, design)
    a.sentence += _state_comparison(a, trials, nominal, design, checks, cliff, step)
    _state_tolerances(a, trials, tolerances, spread)


def _form_parts(unit: str) -> dict[str, tuple[str, str]]:
    return {
        "upper": ("largest amplitude", unit),
        "ratio": ("smallest over largest amplitude", ""),
        "fullness": ("position of the mean between the smallest and the largest amplitude", ""),
    }


def _state_spectra(a: Answer, target: LoadCycles, signal: MachineSignal, design: CheckedCandidate | None) -> None:
    """State the amplitudes that shares of the cycles reach or exceed, and the form of the target."""
    shares, unit, total = cycle_shares(target.total), signal.unit, target.total
    slow = full = np.full(len(shares), np.nan)
    if design is not None:
        slow, full = (amplitudes_at(cycles, shares) for cycles in (design.slow.cycles, design.cycles))
    a.curve("share", shares, "share of the cycles")
    a.curve("amplitude_wanted", amplitudes_at(target, shares), "amplitude", unit, "share")
    a.curve("amplitude_slow", slow, "amplitude in the averaged equations", unit, "share")
    a.curve("amplitude_full", full, "amplitude in the full equations", unit, "share")
    upper, ratio, fullness = spectrum_form(target)
    a.curve("wanted_upper", upper, "largest amplitude of the target", unit, "")
    a.curve("wanted_ratio", ratio, "smallest over largest amplitude of the target", "", "")
    a.curve("wanted_fullness", fullness, "fullness of the target", "", "")
    a.curve("wanted_cycles", total, "cycles of the target", "", "")
    form = {"upper": upper, "ratio": ratio, "fullness": fullness, "cycles": total}
    parts = _form_parts(unit) | {"cycles": ("number of cycles", "")}
    a.number("target", {k: _finite_or_none(x) for k, x in form.items()}, "form of the target", parts=parts)
    name = signal.name[:1].upper() + signal.name[1:]
    a.attribute(signal=name)
    a.line("signal", "{name}", name=name)
    smallest = number_text(ratio * upper, unit) or ""
    a.line("target", "{target.cycles:.4g} cycles, amplitudes {smallest} to {target.upper}", smallest=smallest)


def _state_variables(a: Answer, trials: DesignTrials, nominal: np.ndarray, signal: MachineSignal) -> None:
    """State the variables, and the counted signal."""
    variables = trials.variables
    a.curve("variable", np.array([v.name for v in variables], str), "variable")
    ranges = {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in variables}
    a.number("variables", ranges, "variables with their ranges", parts={v.name: (v.name, v.unit) for v in variables})
    a.number("as_it_is", _values_by_name(trials, nominal), "nominal parameters of the machine")
    a.number("metric", METRICS[trials.metric], "measure of the distance")
    a.number("signal", signal.name, "counted signal")
    a.number("unit", signal.unit, "unit of the signal")


def _values_by_name(trials: DesignTrials, numbers: np.ndarray) -> dict[str, float]:
    return {v.name: float(x) for v, x in zip(trials.variables, numbers, strict=True)}


def _state_beat(a: Answer, signal: MachineSignal, design: CheckedCandidate | None) -> None:
    """State a beat in the averaged equations, and the turning points of one in the full equations."""
    times = amplitudes = rates = turning_times = turning_values = np.empty(0)
    if design is not None:
        times, amplitudes, rates = design.slow.time, design.slow.amplitude, design.slow.rate
        turning_times, turning_values = design.beat_time, design.beat_values
    a.curve("beat_time", times, "time", "time", "place", coordinate=True)
    a.curve("beat_amplitude", amplitudes, "amplitude", signal.unit, "place")
    a.curve("beat_rate", rates, "cycles per unit of time", "1/time", "place")
    a.curve("turning_time", turning_times, "time", "time", "turn", coordinate=True)
    a.curve("turning_value", turning_values, signal.name, signal.unit, "turn")


def _state_candidates(a: Answer, trials: DesignTrials, batches: Sequence[Candidates], name: str, along: str, unit: str) -> None:
    """State evaluated candidates."""
    keys = ("numbers", "distances", "motion", "upper", "ratio", "fullness")
    numbers, distances, motion, upper, ratio, fullness = ([x for b in batches for x in getattr(b, key)] for key in keys)
    a.curve(f"{name}_value", _stack(numbers, len(trials.variables)), "values, in SI", "", f"{along} variable")
    column = _stack(distances, len(METRICS))[:, trials.metric]
    a.curve(f"{name}_distance", column, f"distance from the target, {METRICS[trials.metric]}", "", along)
    a.curve(f"{name}_motion", np.array(motion, int), "place in motion", "", along)
    a.curve(f"{name}_upper", np.array(upper, float), "largest amplitude", unit, along)
    a.curve(f"{name}_ratio", np.array(ratio, float), "smallest over largest amplitude", "", along)
    a.curve(f"{name}_fullness", np.array(fullness, float), "fullness", "", along)


def _stack(rows: Sequence[np.ndarray], width: int) -> np.ndarray:
    return np.array(rows, float).reshape(len(rows), width)


def _state_motions(a: Answer, candidates: Sequence[Candidates]) -> str:
    """State how many candidates have each motion, and return that in words."""
    count = a.number("candidates", sum(len(b.motion) for b in candidates), "number of candidates")
    motions = _motions(candidates)
    a.number("motions", motions, "number of candidates by their motion in the averaged equations")
    words = ", ".join(f"{n} {name}" for name, n in motions.items() if n)
    a.line("search", f"{count} candidates with the averaged equations: {words}")
    return words


def _motions(batches: Sequence[Candidates]) -> dict[str, int]:
    motion = np.concatenate([b.motion for b in batches]) if batches else np.empty(0, int)
    return {name: int((motion == k).sum()) for k, name in enumerate(MOTIONS)}


def _state_reach(a: Answer, reach: Sequence[Candidates], unit: str) -> None:
    """State the share of the random points that beat, and the limits of their spectra."""
    motions, of_reach = _motions(reach), None
    parts = _form_parts(unit) | {"modulated": ("share of the exciters that beat", "")}
    if reach:
        share = motions["modulated"] / sum(motions.values())
        of_reach = {"modulated": share} | {
            key: _limits(reach, key) if share else None for key in ("upper", "ratio", "fullness")
        }
    a.number("reach", of_reach, "spectra of random points of the ranges", parts=parts)
    if motions["modulated"]:
        amplitudes = "{reach.upper[0]} to {reach.upper[1]}, the smallest {reach.ratio[0]:.2f} to {reach.ratio[1]:.2f} of it"
        a.line("reach", "{reach.modulated:.0f%} of the points beat; largest amplitudes " + amplitudes)


def _limits(batches: Sequence[Candidates], key: str) -> list[float]:
    values = np.concatenate([getattr(b, key) for b in batches])
    return [float(np.nanmin(values)), float(np.nanmax(values))]


def _state_runs(
    a: Answer,
    trials: DesignTrials,
    target: LoadCycles,
    runs: Sequence[CheckedCandidate],
    optima: Sequence[tuple[np.ndarray, float]],
) -> None:
    """State the runs of the full equations, and the designs before them."""
    if steady_runs := [c for c in runs if not c.beats]:
        outcomes = ", ".join(dict.fromkeys(c.outcome for c in steady_runs))
        a.warn(f"{len(steady_runs)} of {len(runs)} candidates do not beat in the full equations: {outcomes}")
    a.warn(*(f"a run of the full equations ended early: {c.reason}" for c in runs if c.reason))
    slow = [float(spectrum_distances(c.slow.cycles, target, trials.slope)[trials.metric]) for c in runs]
    full = [float(c.distances[trials.metric]) for c in runs]
    in_slow, in_full = "distance in the averaged equations", "distance in the full equations"
    a.table(
        "runs", "runs of the full equations",
        parameters=([_values_by_name(trials, c.numbers) for c in runs], "parameters"),
        slow=(slow, in_slow), full=([_finite_or_none(x) for x in full], in_full),
        outcome=([c.outcome for c in runs], "outcome in the full equations"),
    )  # fmt: skip
    a.curve("run_slow", np.array(slow, float), in_slow, "", "run")
    a.curve("run_full", np.array(full, float), in_full, "", "run")
    local_optima = [_values_by_name(trials, numbers) | {"distance": distance} for numbers, distance in optima]
    a.number("polished", local_optima, "parameters after the local search, and their distance in the averaged equations")
    a.curve("run_value", _stack([c.numbers for c in runs], len(trials.variables)), "values, in SI", "", "run variable")
    beats = np.array([c.beats for c in runs], np.int8)
    a.curve("run_beats", beats, "1 where it beats in the full equations", "", "run")


def _finite_or_none(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _state_design(
    a: Answer, trials: DesignTrials, target: LoadCycles, signal: MachineSignal, design: CheckedCandidate | None
) -> None:
    """State the best exciter, and the distance of its spectrum from the target."""
    parameters = distance = distances = None
    ranges = means = counts = np.empty(0)
    if design is not None:
        slow_distances = spectrum_distances(design.slow.cycles, target, trials.slope)
        parameters, distance = _values_by_name(trials, design.numbers), float(design.distances[trials.metric])
        distances = {"full": _values_by_metric(design.distances), "slow": _values_by_metric(slow_distances)}
        cycles = design.cycles
        if len(cycles.ranges) > _MOST_ROWS:
            cycles, _ = cycles.group_by_range(cycles.largest / _CLASSES)
        ranges, means, counts = cycles.ranges, cycles.means, cycles.counts * target.total / cycles.total
    units = {v.name: v.unit for v in trials.variables}
    a.number("parameters", parameters, "parameters of the design", parts={name: (name, unit) for name, unit in units.items()})
    for k, (name, value) in enumerate((parameters or {}).items()):
        a.line("" if k else "design", "{name} = " + f"{value:.5g} {units[name]}".rstrip(), name=name)
    what = "distance of its spectrum from the target, in the full equations"
    a.number("distance", distance, what, headline=True)
    a.table(
        "spectrum", "its ranges, with as many cycles as the target has",
        range=(ranges, "range", signal.unit), mean=(means, "mean", signal.unit), count=(counts, "cycles"),
    )  # fmt: skip
    parts = {"full": ("in the full equations", ""), "slow": ("in the averaged equations", "")}
    a.number("distances", distances, "its distances from the target by each metric", parts=parts)
    if design is not None:
        beyond = _state_design_spectrum(a, target, signal.unit, design, trials.slope)
        _warn_of_design(a, trials, design, slow_distances[trials.metric], beyond, target.total)


def _values_by_metric(distances: Sequence[float] | np.ndarray) -> dict[str, float | None]:
    return {metric: _finite_or_none(x) for metric, x in zip(METRICS, distances, strict=True)}


def _state_design_spectrum(a: Answer, target: LoadCycles, unit: str, design: CheckedCandidate, slope: float) -> float:
    """State beat, duration, largest amplitude and damage of the design. Return the number of larger cycles of the target."""
    cycles = design.cycles
    a.number("beat", design.slow.period, "period of a beat, in the averaged equations", "time")
    a.number("cycles_per_beat", design.slow.cycles.total, "number of cycles in a beat")
    duration = target.total / (cycles.total / design.duration)
    a.number("duration", duration, "duration of all cycles of the target", "time")
    duration_text = f"{{duration:.4g}} ({decimal_text(duration / _HOUR)} h)"
    a.line("beat", "{beat:.4g}, {cycles_per_beat:.3g} cycles; all cycles of the target take " + duration_text)
    averaged = "(averaged equations {distances.slow.amplitude:.2f%})"
    a.line("amplitudes", "mean deviation {distances.full.amplitude:.2f%} of the largest " + averaged)
    averaged = "(averaged equations {distances.slow.cumulative:.2f%})"
    a.line("counts", "largest deviation {distances.full.cumulative:.2f%} of all cycles " + averaged)
    a.number("outcome", design.outcome, "outcome in the full equations")
    a.number("upper", cycles.largest / 2, "largest amplitude in the full equations", unit)
    beyond = float(target.counts[target.ranges > cycles.largest].sum())
    a.number("beyond", beyond, "number of larger cycles of the target")
    a.line("largest", "{upper}; {beyond:.3g} cycles of the target are larger")
    ours, theirs = (damage_weighted_cycles(c, target, slope).total / c.total for c in (cycles, target))
    a.number("damage_ratio", ours / theirs, "damage of a cycle, relative to that of the target")
    off = "off by up to {distances.full.damage:.2f%} of it, counted from above"
    a.line("damage", "{damage_ratio:.3f} times that of the target; " + off)
    return beyond


def _warn_of_design(
    a: Answer, trials: DesignTrials, design: CheckedCandidate, slow: float, beyond: float, total: float
) -> None:
    """Warn of a design far from the target, or at an end of the ranges.

    slow: its distance in the averaged equations. beyond: larger cycles of the target, of ``total``.
    """
    full = design.distances[trials.metric]
    if full > _DISTANCE_RATIO * slow:
        a.warn(
            f"the full equations are farther from the target than the averaged ones, {100 * full:.2f} % and "
            f"{100 * slow:.2f} %: more corrections, or smaller unbalances, may help"
        )
    if beyond > _MISSED_SHARE * total:
        a.warn(f"{decimal_text(beyond, 3)} cycles of the target exceed the largest reached amplitude")
    shares = zip(trials.variables, trials.shares(design.numbers), strict=True)
    at_end = [v.name for v, x in shares if not 1e-3 < x < 1 - 1e-3]
    if at_end:
        a.warn(f"{', '.join(at_end)} {'lies' if len(at_end) == 1 else 'lie'} at an end of the range: a wider one may do better")


def _state_comparison(
    a: Answer,
    trials: DesignTrials,
    nominal: np.ndarray,
    design: CheckedCandidate | None,
    checks: Sequence[CheckedCandidate],
    cliff: Cliff | None,
    step: float,
) -> str:
    """State what the design was compared with over the same later beats, the nearest first, and its cliff.

    Return the clause on its neighbours and the cliff.
    """
    words = {"as it is": "present exciter", "neighbour": "neighbours", "other": "others"}
    relations = [_relation(check, design, nominal, step) for check in checks]
    distances = [_finite_or_none(check.distances[trials.metric]) if check.beats else None for check in checks]
    a.table(
        "compared", "exciters compared over the same beats in the full equations",
        what=(relations, "what it is"),
        parameters=([_values_by_name(trials, check.numbers) for check in checks], "parameters"),
        distance=(distances, "distance in the full equations, over beats that the search has not counted"),
        outcome=([check.outcome for check in checks], "outcome in the full equations"),
    )  # fmt: skip
    texts, clause = list[str](), ""
    for relation in filter(relations.__contains__, words):
        percents = [100 * x for what, x in zip(relations, distances, strict=True) if what == relation and x is not None]
        ends = " to ".join(dict.fromkeys(f"{x:.2f}" for x in (min(percents), max(percents)))) if percents else ""
        texts.append(f"{words[relation]} {ends} %" if percents else f"{words[relation]} none that beats")
        if percents and relation == "neighbour":
            clause = f"; {100 * step:.2g} % away from it within {ends} %"
    if texts and design is not None:
        first = f"over the same beats, not counted before: design {100 * design.distances[trials.metric]:.2f} %"
        a.line("compared", ", ".join([first, *texts]))
    if cliff is not None:
        change = f"{100 * abs(cliff.distance):.2g} % {'less' if cliff.distance < 0 else 'more'} {cliff.parameter}"
        clause += f"; with {change} it does not beat" if design is not None else ""
    of_cliff = cliff and {key: getattr(cliff, key) for key in ("parameter", "value", "distance", "inside")}
    a.number("cliff", of_cliff, "nearest value at which it does not beat, in the averaged equations")
    return clause


def _relation(check: CheckedCandidate, design: CheckedCandidate | None, nominal: np.ndarray, step: float) -> str:
    """Return what an exciter is to the design."""
    if check is design:
        return "design"
    if np.array_equal(check.numbers, nominal):
        return "as it is"
    if design is None:
        return "other"
    is_changed = ~np.isclose(check.numbers, design.numbers, rtol=1e-3 * step, atol=0.0)
    is_near = np.allclose(check.numbers, design.numbers, rtol=1.01 * step)
    return "neighbour" if is_changed.sum() == 1 and is_near else "other"


def _state_tolerances(a: Answer, trials: DesignTrials, batches: Sequence[Candidates], spread: float) -> None:
    """State quantiles of the distance of exciters within tolerances; one that does not beat counts as infinitely far."""
    of_tolerances: dict[str, Any] | None = None
    if batches:
        far = np.concatenate([b.distances[:, trials.metric] for b in batches])
        quantiles = np.quantile(np.where(np.isfinite(far), far, np.inf), list(_QUANTILES.values()), method="higher")
        beating = float(np.isfinite(far).mean())
        of_tolerances = {"spread": spread, "modulated": beating}
        of_tolerances |= dict(zip(_QUANTILES, map(_finite_or_none, quantiles), strict=True))
        middle, worst = ("none" if of_tolerances[q] is None else f"{100 * of_tolerances[q]:.2f} %" for q in ("median", "q95"))
        distances = f"median distance {middle}, 95 % quantile {worst}"
        a.line("tolerances", "within {tolerances.spread:.1f%} {tolerances.modulated:.0f%} beat; " + distances)
        if beating < _BEATING_SHARE:
            a.warn(f"{100 * (1 - beating):.0f} % of the exciters within tolerances of {100 * spread:.1f} % do not beat")
    parts = {
        "spread": ("spread of the parameters", ""),
        **{name: (f"distance that {100 * share:.0f} % of the exciters have at most", "") for name, share in _QUANTILES.items()},
        "modulated": ("share of the exciters that beat", ""),
    }
    a.number("tolerances", of_tolerances, "distance of exciters within tolerances", parts=parts)
