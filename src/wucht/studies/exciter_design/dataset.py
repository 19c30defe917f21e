"""Findings -> the Dataset of a design: spectra, a beat, reachable spectra, the search, tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.exciters.design_trials import (
    METRICS,
    Candidates,
    CheckedCandidate,
    damage_weighted_cycles,
    spectrum_distances,
)
from wucht.dynamics.exciters.slow_beats import MOTIONS
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import amplitudes_at
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.exciter_design.computation import Findings
from wucht.studies.exciter_design.design_plan import Plan
from wucht.studies.exciter_design.neighbour_check import step_of

if TYPE_CHECKING:
    import xarray as xr

_CLASSES, _MOST_ROWS = 100, 200  # of the spectrum in the summary, where it has more different ranges
_SHARES, _FEW = 400, 120  # of the cycles, at which amplitudes are given; and a few more, evenly by their logarithm
_QUANTILES = {"q05": 0.05, "median": 0.5, "q95": 0.95}
_DISTANCE_MEANINGS = {
    "amplitude": "of its largest amplitude, on average",
    "cumulative": "of the cycles, at most",
    "damage": "of the damage, at most",
}
_BEATING = {"modulated": ("share of the exciters that beat", "")}
_TOLERANCES = {
    "spread": ("spread of the parameters", ""),
    **{name: (f"distance that {100 * share:.0f} % of the exciters have at most", "") for name, share in _QUANTILES.items()},
}
_BEATING_SHARE = 0.9  # share of exciters within tolerances that beat: a smaller one is warned of
_DISTANCE_RATIO = 1.5  # of the distances in the full and the averaged equations: a larger ratio is warned of
_MISSED_SHARE = 1e-3  # of the target's cycles: more cycles above the largest reached amplitude are warned of


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of a design."""
    design, name = findings.design(plan.trials.metric), plan.signal[:1].upper() + plan.signal[1:]
    candidates, tolerances = (*findings.reach, *findings.search), _tolerances(plan, findings)
    quantities = [
        *_design_quantities(plan, design),
        *_spectrum_quantities(plan, design),
        *_question_quantities(plan),
        *_beat_quantities(plan, design),
        *_candidate_quantities(plan, findings.reach, "reach", "point"),
        *_candidate_quantities(plan, candidates, "tried", "candidate"),
        *_candidate_quantities(plan, findings.tolerances, "tolerance", "sample"),
        *_run_quantities(plan, findings),
        *_comparison_quantities(plan, findings, design),
        Quantity("motion", np.array(MOTIONS, str), "motion in the averaged equations", "", "motion"),
        Quantity("candidates", sum(len(b.motion) for b in candidates), "number of candidates"),
        Quantity("motions", _motions(candidates), "number of candidates by their motion in the averaged equations"),
        Quantity("reach", _reach(findings), "spectra of random points of the ranges", parts=_form_parts(plan) | _BEATING),
        Quantity("tolerances", tolerances, "distance of exciters within tolerances", parts=_TOLERANCES | _BEATING),
    ]
    return result_dataset(
        quantities, _sentence(plan, findings, design), _warnings(plan, findings, design, tolerances), signal=name
    )


def _form_parts(plan: Plan) -> dict[str, tuple[str, str]]:
    return {
        "upper": ("largest amplitude", plan.unit),
        "ratio": ("smallest over largest amplitude", ""),
        "fullness": ("position of the mean between the smallest and the largest amplitude", ""),
    }


def _design_quantities(plan: Plan, design: CheckedCandidate | None) -> list[Quantity]:
    """Return the best exciter, and the distance of its spectrum from the target."""
    target, slope, of_parameters = plan.target, plan.spec.slope, {v.name: (v.name, v.unit) for v in plan.trials.variables}
    parameters = distance = apart = None
    of_one, rows = list[Quantity](), list[dict[str, float]]()
    if design is not None:
        cycles = design.cycles
        parameters, distance = _values_by_name(plan, design.numbers), float(design.distances[plan.trials.metric])
        apart = {
            "full": _values_by_metric(design.distances),
            "slow": _values_by_metric(spectrum_distances(design.slow.cycles, target, slope)),
        }
        rows, time = _rows(design, target.total), plan.machine.units.time
        ours, theirs = (damage_weighted_cycles(c, target, slope).total / c.total for c in (cycles, target))
        duration = target.total / (cycles.total / design.duration)
        of_one = [
            Quantity("beat", design.slow.period, "period of a beat, in the averaged equations", time),
            Quantity("cycles_per_beat", design.slow.cycles.total, "number of cycles in a beat"),
            Quantity("duration", duration, "duration of all cycles of the target", time),
            Quantity("outcome", design.outcome, "outcome in the full equations"),
            Quantity("upper", cycles.largest / 2, "largest amplitude in the full equations", plan.unit),
            Quantity("beyond", _missed_cycles(plan, design), "number of larger cycles of the target"),
            Quantity("damage_ratio", ours / theirs, "damage of a cycle, relative to that of the target"),
        ]
    of_rows = {"range": ("range", plan.unit), "mean": ("mean", plan.unit), "count": ("cycles", "")}
    parts = {"full": ("in the full equations", ""), "slow": ("in the averaged equations", "")}
    return [
        Quantity("parameters", parameters, "parameters of the design", parts=of_parameters),
        Quantity("distance", distance, "distance of its spectrum from the target, in the full equations", headline=True),
        Quantity("spectrum", rows, "its ranges, with as many cycles as the target has", parts=of_rows),
        Quantity("distances", apart, "its distances from the target by each metric", parts=parts),
        *of_one,
    ]


def _spectrum_quantities(plan: Plan, design: CheckedCandidate | None) -> list[Quantity]:
    """Return the amplitudes that shares of the cycles reach or exceed, and the form of the target."""
    shares, unit, total = _shares(plan.target.total), plan.unit, plan.target.total
    no_amplitudes, (upper, ratio, fullness) = np.full(len(shares), np.nan), _form(plan.target)
    slow, full = (
        (no_amplitudes, no_amplitudes)
        if design is None
        else (amplitudes_at(c, shares) for c in (design.slow.cycles, design.cycles))
    )
    form = {
        "upper": _finite_or_none(upper),
        "ratio": _finite_or_none(ratio),
        "fullness": _finite_or_none(fullness),
        "cycles": total,
    }
    parts = _form_parts(plan) | {"cycles": ("number of cycles", "")}
    return [
        Quantity("share", shares, "share of the cycles", "", "share"),
        Quantity("amplitude_wanted", amplitudes_at(plan.target, shares), "amplitude", unit, "share"),
        Quantity("amplitude_slow", slow, "amplitude in the averaged equations", unit, "share"),
        Quantity("amplitude_full", full, "amplitude in the full equations", unit, "share"),
        Quantity("wanted_upper", upper, "largest amplitude of the target", unit, ""),
        Quantity("wanted_ratio", ratio, "smallest over largest amplitude of the target", "", ""),
        Quantity("wanted_fullness", fullness, "fullness of the target", "", ""),
        Quantity("wanted_cycles", total, "cycles of the target", "", ""),
        Quantity("target", form, "form of the target", parts=parts),
    ]


def _question_quantities(plan: Plan) -> list[Quantity]:
    """Return the variables, and the counted signal."""
    variables = plan.trials.variables
    ranges = {v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in variables}
    return [
        Quantity("variable", np.array([v.name for v in variables], str), "variable", "", "variable"),
        Quantity("variables", ranges, "variables with their ranges", parts={v.name: (v.name, v.unit) for v in variables}),
        Quantity("as_it_is", _values_by_name(plan, plan.numbers), "nominal parameters of the machine"),
        Quantity("metric", plan.spec.metric, "measure of the distance"),
        Quantity("signal", plan.signal, "counted signal"),
        Quantity("unit", plan.unit, "unit of the signal"),
    ]


def _shares(total: float) -> np.ndarray:
    few = np.geomspace(1 / total, 1.0, _FEW)
    return np.unique(np.concatenate([few, np.linspace(0.0, 1.0, _SHARES + 1)[1:]]))


def _form(cycles: LoadCycles) -> tuple[float, float, float]:
    """Return largest amplitude, smallest over largest, and the position of the mean between (nan if they coincide)."""
    low, high = float(cycles.ranges.min()) / 2, cycles.largest / 2
    mean = float(np.average(cycles.ranges, weights=cycles.counts)) / 2
    return high, low / high, (mean - low) / (high - low) if high > low else np.nan


def _stack(rows: list[np.ndarray], width: int) -> np.ndarray:
    return np.array(rows, float).reshape(len(rows), width)


def _beat_quantities(plan: Plan, design: CheckedCandidate | None) -> list[Quantity]:
    time, empty = plan.machine.units.time, np.empty(0)
    times, amplitudes, rates = (empty,) * 3 if design is None else (design.slow.time, design.slow.amplitude, design.slow.rate)
    return [
        Quantity("beat_time", times, "time", time, "place", coordinate=True),
        Quantity("beat_amplitude", amplitudes, "amplitude", plan.unit, "place"),
        Quantity("beat_rate", rates, "cycles per unit of time", f"1/{time}" if time else "", "place"),
        Quantity("turning_time", empty if design is None else design.beat_time, "time", time, "turn", coordinate=True),
        Quantity("turning_value", empty if design is None else design.beat_values, plan.signal, plan.unit, "turn"),
    ]


def _comparison_quantities(plan: Plan, findings: Findings, design: CheckedCandidate | None) -> list[Quantity]:
    """Return what the design was compared with over the same later beats, the nearest first, and its cliff."""
    rows, metric = list[dict[str, Any]](), plan.trials.metric
    for check in findings.checks:
        assert design is not None
        distance = float(check.distances[metric]) if check.beats else np.nan
        what = "design" if check is design else _relation(plan, check.numbers, design.numbers)
        parameters = _values_by_name(plan, check.numbers)
        rows.append({"what": what, "parameters": parameters, "distance": _finite_or_none(distance), "outcome": check.outcome})
    parts = {
        "what": ("what it is", ""), "parameters": ("parameters", ""), "outcome": ("outcome in the full equations", ""),
        "distance": ("distance in the full equations, over beats that the search has not counted", ""),
    }  # fmt: skip
    cliff, of_cliff = findings.cliff, None
    if cliff is not None:
        of_cliff = {
            "parameter": cliff.parameter, "value": cliff.value, "distance": cliff.distance, "inside": cliff.inside
        }  # fmt: skip
    return [
        Quantity("compared", rows, "exciters compared over the same beats in the full equations", parts=parts),
        Quantity("cliff", of_cliff, "nearest value at which it does not beat, in the averaged equations"),
    ]


def _relation(plan: Plan, numbers: np.ndarray, design: np.ndarray) -> str:
    """Return what an exciter is to the design."""
    if np.array_equal(numbers, plan.numbers):
        return "as it is"
    is_changed = ~np.isclose(numbers, design, rtol=1e-3 * step_of(plan), atol=0.0)
    return "neighbour" if is_changed.sum() == 1 and np.allclose(numbers, design, rtol=1.01 * step_of(plan)) else "other"


def _candidate_quantities(plan: Plan, batches: tuple[Candidates, ...], name: str, along: str) -> list[Quantity]:
    keys = ("numbers", "distances", "motion", "upper", "ratio", "fullness")
    numbers, apart, motion, *form = ([x for b in batches for x in getattr(b, key)] for key in keys)
    column = _stack(apart, len(METRICS))[:, plan.trials.metric]
    values = _stack(numbers, len(plan.trials.variables))
    upper, ratio, fullness = (np.array(x, float) for x in form)
    return [
        Quantity(f"{name}_value", values, "values, in SI", "", f"{along} variable"),
        Quantity(f"{name}_distance", column, f"distance from the target, {plan.spec.metric}", "", along),
        Quantity(f"{name}_motion", np.array(motion, int), "place in motion", "", along),
        Quantity(f"{name}_upper", upper, "largest amplitude", plan.unit, along),
        Quantity(f"{name}_ratio", ratio, "smallest over largest amplitude", "", along),
        Quantity(f"{name}_fullness", fullness, "fullness", "", along),
    ]


def _run_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Return the runs of the full equations, and the designs before them."""
    runs, metric = findings.full_runs, plan.trials.metric
    slow = [float(spectrum_distances(c.slow.cycles, plan.target, plan.spec.slope)[metric]) for c in runs]
    rows = [
        {
            "parameters": _values_by_name(plan, c.numbers),
            "slow": x,
            "full": _finite_or_none(c.distances[metric]),
            "outcome": c.outcome,
        }
        for c, x in zip(runs, slow, strict=True)
    ]
    parts = {
        "parameters": ("parameters", ""),
        "slow": ("distance in the averaged equations", ""),
        "full": ("distance in the full equations", ""),
        "outcome": ("outcome in the full equations", ""),
    }
    optima = [_values_by_name(plan, p.numbers) | {"distance": p.distance} for p in findings.local_optima]
    values, beats = _stack([c.numbers for c in runs], len(plan.trials.variables)), [c.beats for c in runs]
    return [
        Quantity("runs", rows, "runs of the full equations", parts=parts),
        Quantity("run_slow", np.array(slow, float), parts["slow"][0], "", "run"),
        Quantity("run_full", np.array([c.distances[metric] for c in runs], float), parts["full"][0], "", "run"),
        Quantity("polished", optima, "parameters after the local search, and their distance in the averaged equations"),
        Quantity("run_value", values, "values, in SI", "", "run variable"),
        Quantity("run_beats", np.array(beats, np.int8), "1 where it beats in the full equations", "", "run"),
    ]


def _values_by_name(plan: Plan, numbers: np.ndarray) -> dict[str, float]:
    return {v.name: float(x) for v, x in zip(plan.trials.variables, numbers, strict=True)}


def _values_by_metric(values: tuple[float, ...] | np.ndarray) -> dict[str, float | None]:
    return {m: float(x) if np.isfinite(x) else None for m, x in zip(METRICS, values, strict=True)}


def _missed_cycles(plan: Plan, design: CheckedCandidate) -> float:
    """Return the number of cycles of the target above the largest reached amplitude."""
    return float(plan.target.counts[plan.target.ranges > design.cycles.largest].sum())


def _finite_or_none(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _rows(design: CheckedCandidate, total: float) -> list[dict[str, float]]:
    """Return the rows of the spectrum as in ``load-spectrum``, scaled to the number of cycles of the target."""
    cycles = design.cycles
    if len(cycles.ranges) > _MOST_ROWS:
        cycles, _ = cycles.group_by_range(cycles.largest / _CLASSES)
    counts = cycles.counts * total / cycles.total
    columns = (cycles.ranges.tolist(), cycles.means.tolist(), counts.tolist())
    return [dict(zip(("range", "mean", "count"), row, strict=True)) for row in zip(*columns, strict=True)]


def _motions(batches: tuple[Candidates, ...]) -> dict[str, int]:
    motion = np.concatenate([b.motion for b in batches]) if batches else np.empty(0, int)
    return {name: int((motion == k).sum()) for k, name in enumerate(MOTIONS)}


def _reach(findings: Findings) -> dict[str, Any] | None:
    """Return the share of the random points that beat, and the limits of their spectra."""
    motions = _motions(findings.reach)
    if not motions["modulated"]:
        return None if not findings.reach else {"modulated": 0.0, "upper": None, "ratio": None, "fullness": None}
    limits = {}
    for key in ("upper", "ratio", "fullness"):
        values = np.concatenate([getattr(b, key) for b in findings.reach])
        limits[key] = [float(np.nanmin(values)), float(np.nanmax(values))]
    return {"modulated": motions["modulated"] / sum(motions.values()), **limits}


def _tolerances(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    """Return quantiles of the distance of exciters within tolerances; one that does not beat counts as infinitely far."""
    if not findings.tolerances:
        return None
    far = np.concatenate([b.distances[:, plan.trials.metric] for b in findings.tolerances])
    quantiles = np.quantile(np.where(np.isfinite(far), far, np.inf), list(_QUANTILES.values()), method="higher")
    beat = float(np.isfinite(far).mean())
    return {
        "spread": plan.spec.spread,
        "modulated": beat,
        **dict(zip(_QUANTILES, map(_finite_or_none, quantiles), strict=True)),
    }


def _sentence(plan: Plan, findings: Findings, design: CheckedCandidate | None) -> str:
    if design is None:
        return "no exciter that beats so far" if not findings.complete else "none of the candidates beats"
    distance = design.distances[plan.trials.metric]
    meaning = _DISTANCE_MEANINGS[plan.spec.metric]
    sentence = f"the spectrum is met within {100 * distance:.2f} % {meaning}, in the full equations"
    rows = _comparison_quantities(plan, findings, design)[0].value
    beside = [r["distance"] for r in rows if r["what"] == "neighbour" and r["distance"] is not None]
    if beside:
        ends = " to ".join(dict.fromkeys(f"{100 * x:.2f}" for x in (min(beside), max(beside))))
        sentence += f"; {100 * step_of(plan):.2g} % away from it within {ends} %"
    if (cliff := findings.cliff) is not None:
        change = f"{100 * abs(cliff.distance):.2g} % {'less' if cliff.distance < 0 else 'more'} {cliff.parameter}"
        sentence += f"; with {change} it does not beat"
    return sentence


def _warnings(plan: Plan, findings: Findings, design: CheckedCandidate | None, tolerances: dict[str, Any] | None) -> list[str]:
    warnings, metric = list(plan.warnings), plan.trials.metric
    steady_runs = [c for c in findings.full_runs if not c.beats]
    if steady_runs:
        outcomes = ", ".join(dict.fromkeys(c.outcome for c in steady_runs))
        warnings.append(
            f"{len(steady_runs)} of {len(findings.full_runs)} candidates do not beat in the full equations: {outcomes}"
        )
    warnings += [f"a run of the full equations ended early: {c.reason}" for c in findings.full_runs if c.reason]
    if design is None:
        if findings.complete:
            motions = ", ".join(f"{n} {name}" for name, n in _motions((*findings.reach, *findings.search)).items() if n)
            warnings.append(f"no candidate beats: {motions}; try other ranges, a pendulum whose unbalance is not that of the "
                            "rotor, or a weaker motor")  # fmt: skip
        return warnings
    slow = spectrum_distances(design.slow.cycles, plan.target, plan.spec.slope)[metric]
    full = design.distances[metric]
    if full > _DISTANCE_RATIO * slow:
        apart = (
            f"the full equations are farther from the target than the averaged ones, {100 * full:.2f} % and {100 * slow:.2f} %"
        )
        warnings.append(f"{apart}: more corrections, or smaller unbalances, may help")
    missed_count = _missed_cycles(plan, design)
    if missed_count > _MISSED_SHARE * plan.target.total:
        warnings.append(f"{missed_count:.3g} cycles of the target exceed the largest reached amplitude")
    shares = zip(plan.trials.variables, plan.trials.shares(design.numbers), strict=True)
    at_end = [v.name for v, x in shares if not 1e-3 < x < 1 - 1e-3]
    if at_end:
        warnings.append(
            f"{', '.join(at_end)} {'lies' if len(at_end) == 1 else 'lie'} at an end of the range: a wider one may do better"
        )
    if tolerances is not None and tolerances["modulated"] < _BEATING_SHARE:
        share = 1 - tolerances["modulated"]
        warnings.append(
            f"{100 * share:.0f} % of the exciters within tolerances of {100 * tolerances['spread']:.1f} % do not beat"
        )
    return warnings
