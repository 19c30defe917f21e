"""Findings -> the Dataset of a design: spectra, a beat, what can be reached, the search, tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.exciters.design_trials import METRICS, Checked, Tried, damaging, distances
from wucht.dynamics.exciters.slow_beats import MOTIONS
from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.cumulative_spectra import amplitudes_at
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.exciter_design.prepare import Plan
from wucht.studies.exciter_design.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_CLASSES, _MOST_ROWS = 100, 200  # of the spectrum in the summary, where it has more different ranges
_SHARES, _FEW = 400, 120  # of the cycles, at which amplitudes are given; and few of them, evenly by their logarithm
_QUANTILES = {"q05": 0.05, "median": 0.5, "q95": 0.95}
_OF = {
    "amplitude": "of its largest amplitude, on the mean",
    "cumulative": "of the cycles, at most",
    "damage": "of the damage, at most",
}
_HARD = 0.9  # exciters within tolerances that beat: if fewer do, it is warned of
_APART = 1.5  # times the distance in the averaged equations: if that in the full ones is larger, it is warned of
_MISSED = 1e-3  # of the target's cycles: if more are larger than any that is reached, it is warned of


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a design.

    Over share (of the cycles): amplitude_wanted, amplitude_slow, amplitude_full: what this share reaches or exceeds. Over place
    (of a beat): beat_time, beat_amplitude, beat_rate, in the averaged equations. Over point: reach_value (point, variable),
    reach_motion (place in the coordinate motion), reach_upper (largest amplitude), reach_ratio (smallest over largest),
    reach_fullness (where their mean lies between). Over candidate (all that were tried): tried_value, tried_distance,
    tried_motion. Over run (of the full equations): run_value, run_slow, run_full (distances), run_beats. Over sample:
    tolerance_value, tolerance_distance. wanted_upper, wanted_ratio, wanted_fullness: of the target.
    """
    import xarray as xr_

    metric, unit = plan.trials.metric, plan.unit
    design = findings.design(metric)
    shares = _shares(plan.target.total)
    none = np.full(len(shares), np.nan)
    slow = none if design is None else amplitudes_at(design.slow.cycles, shares)
    full = none if design is None else amplitudes_at(design.cycles, shares)
    tried = [*findings.reach, *findings.search]
    upper, ratio, fullness = _form(plan.target)
    data: dict[str, Variable] = {
        "amplitude_wanted": variable("share", amplitudes_at(plan.target, shares), "amplitude", unit),
        "amplitude_slow": variable("share", slow, "amplitude in the averaged equations", unit),
        "amplitude_full": variable("share", full, "amplitude in the full equations", unit),
        "wanted_upper": variable("", upper, "largest amplitude of the target", unit),
        "wanted_ratio": variable("", ratio, "smallest over largest amplitude of the target"),
        "wanted_fullness": variable("", fullness, "fullness of the target"),
        "wanted_cycles": variable("", plan.target.total, "cycles of the target"),
        **_of_beat(plan, design),
        **_of_tried(plan, findings.reach, "reach", "point"),
        **_of_tried(plan, tuple(tried), "tried", "candidate"),
        **_of_tried(plan, findings.tolerances, "tolerance", "sample"),
        **_of_runs(plan, findings),
    }
    coordinates: dict[str, Any] = {
        "share": variable("share", shares, "share of the cycles"),
        "variable": variable("variable", np.array([v.name for v in plan.trials.variables], str), "what is varied"),
        "motion": variable("motion", np.array(MOTIONS, str), "motion in the averaged equations"),
    }
    summary = _summary(plan, findings, design)
    name = plan.signal[:1].upper() + plan.signal[1:]
    return answered(
        xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], _warnings(plan, findings, design), signal=name
    )


def _shares(total: float) -> np.ndarray:
    few = np.geomspace(1 / total, 1.0, _FEW)
    return np.unique(np.concatenate([few, np.linspace(0.0, 1.0, _SHARES + 1)[1:]]))


def _form(cycles: Cycles) -> tuple[float, float, float]:
    """Largest amplitude, smallest over largest, and where the mean lies between them (nan where they are one)."""
    low, high = float(cycles.ranges.min()) / 2, cycles.largest / 2
    mean = float(np.average(cycles.ranges, weights=cycles.counts)) / 2
    return high, low / high, (mean - low) / (high - low) if high > low else np.nan


def _stack(rows: list[np.ndarray], width: int) -> np.ndarray:
    return np.array(rows, float).reshape(len(rows), width)


def _of_beat(plan: Plan, design: Checked | None) -> dict[str, Variable]:
    time, none = plan.machine.units.time, np.empty(0)
    beat = None if design is None else design.slow
    return {
        "beat_time": variable("place", none if beat is None else beat.time, "time", time),
        "beat_amplitude": variable("place", none if beat is None else beat.amplitude, "amplitude", plan.unit),
        "beat_rate": variable(
            "place", none if beat is None else beat.rate, "cycles per unit of time", f"1/{time}" if time else ""
        ),
    }


def _of_tried(plan: Plan, batches: tuple[Tried, ...], name: str, along: str) -> dict[str, Variable]:
    width = len(plan.trials.variables)
    joined = {
        key: [x for b in batches for x in getattr(b, key)] for key in ("distances", "motion", "upper", "ratio", "fullness")
    }
    column = _stack(joined["distances"], len(METRICS))[:, plan.trials.metric]
    return {
        f"{name}_value": variable(f"{along} variable", _stack([r for b in batches for r in b.numbers], width), "values, in SI"),
        f"{name}_distance": variable(along, column, f"distance from the target, {plan.spec.metric}"),
        f"{name}_motion": variable(along, np.array(joined["motion"], int), "place in motion"),
        f"{name}_upper": variable(along, np.array(joined["upper"], float), "largest amplitude", plan.unit),
        f"{name}_ratio": variable(along, np.array(joined["ratio"], float), "smallest over largest amplitude"),
        f"{name}_fullness": variable(along, np.array(joined["fullness"], float), "fullness"),
    }


def _of_runs(plan: Plan, findings: Findings) -> dict[str, Variable]:
    runs, metric = findings.checked, plan.trials.metric
    slow = [distances(c.slow.cycles, plan.target, plan.spec.slope)[metric] for c in runs]
    return {
        "run_value": variable("run variable", _stack([c.numbers for c in runs], len(plan.trials.variables)), "values, in SI"),
        "run_slow": variable("run", np.array(slow, float), "distance in the averaged equations"),
        "run_full": variable("run", np.array([c.distances[metric] for c in runs], float), "distance in the full equations"),
        "run_beats": variable("run", np.array([c.beats for c in runs], np.int8), "whether it beats in the full equations"),
    }


def _named(plan: Plan, numbers: np.ndarray) -> dict[str, float]:
    return {v.name: float(x) for v, x in zip(plan.trials.variables, numbers, strict=True)}


def _each(values: tuple[float, ...] | np.ndarray) -> dict[str, float | None]:
    return {m: float(x) if np.isfinite(x) else None for m, x in zip(METRICS, values, strict=True)}


def _summary(plan: Plan, findings: Findings, design: Checked | None) -> dict[str, Any]:
    metric = plan.trials.metric
    tried = [*findings.reach, *findings.search]
    summary: dict[str, Any] = {
        "sentence": "",
        "parameters": None if design is None else _named(plan, design.numbers),
        "distance": None if design is None else float(design.distances[metric]),
        "spectrum": [] if design is None else _rows(design, plan.target.total),
        "metric": plan.spec.metric,
        "distances": None
        if design is None
        else {"full": _each(design.distances), "slow": _each(distances(design.slow.cycles, plan.target, plan.spec.slope))},
        "signal": plan.signal,
        "unit": plan.unit,
        "target": dict(zip(("upper", "ratio", "fullness"), map(_number, _form(plan.target)), strict=True))
        | {"cycles": plan.target.total},
        "as_it_is": _named(plan, plan.numbers),
        "variables": {
            v.name: {"paths": list(v.paths), "range": [v.low, v.high], "unit": v.unit} for v in plan.trials.variables
        },
        "runs": [
            {
                "parameters": _named(plan, c.numbers),
                "slow": float(distances(c.slow.cycles, plan.target, plan.spec.slope)[metric]),
                "full": _number(c.distances[metric]),
                "outcome": c.outcome,
            }
            for c in findings.checked
        ],
        "polished": [_named(plan, p.numbers) | {"distance": p.distance} for p in findings.polished],
        "candidates": sum(len(b.motion) for b in tried),
        "motions": _motions(tuple(tried)),
        "reach": _reach(findings),
        "tolerances": _tolerances(plan, findings),
    }
    if design is not None:
        begun = design.cycles.total / design.duration
        ours, theirs = (damaging(c, plan.target, plan.spec.slope).total / c.total for c in (design.cycles, plan.target))
        summary |= {
            "beat": design.slow.period,
            "cycles_per_beat": design.slow.cycles.total,
            "duration": plan.target.total / begun,
            "outcome": design.outcome,
            "upper": design.cycles.largest / 2,
            "beyond": float(plan.target.counts[plan.target.ranges > design.cycles.largest].sum()),
            "damage_ratio": ours / theirs,
        }
    return summary | {"sentence": _sentence(findings, summary)}


def _number(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def _rows(design: Checked, total: float) -> list[dict[str, float]]:
    """As in ``load-spectrum``, with as many cycles as the target has."""
    cycles = design.cycles
    if len(cycles.ranges) > _MOST_ROWS:
        cycles, _ = cycles.by_range(cycles.largest / _CLASSES)
    counts = cycles.counts * total / cycles.total
    columns = (cycles.ranges.tolist(), cycles.means.tolist(), counts.tolist())
    return [dict(zip(("range", "mean", "count"), row, strict=True)) for row in zip(*columns, strict=True)]


def _motions(batches: tuple[Tried, ...]) -> dict[str, int]:
    motion = np.concatenate([b.motion for b in batches]) if batches else np.empty(0, int)
    return {name: int((motion == k).sum()) for k, name in enumerate(MOTIONS)}


def _reach(findings: Findings) -> dict[str, Any] | None:
    """Of the random points: how many beat, and between which limits."""
    motions = _motions(findings.reach)
    if not motions["modulated"]:
        return None if not findings.reach else {"modulated": 0.0, "upper": None, "ratio": None, "fullness": None}
    limits = {}
    for key in ("upper", "ratio", "fullness"):
        values = np.concatenate([getattr(b, key) for b in findings.reach])
        limits[key] = [float(np.nanmin(values)), float(np.nanmax(values))]
    return {"modulated": motions["modulated"] / sum(motions.values()), **limits}


def _tolerances(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    """Quantiles of the distance over the exciters within tolerances; one that does not beat is farther than any."""
    if not findings.tolerances:
        return None
    far = np.concatenate([b.distances[:, plan.trials.metric] for b in findings.tolerances])
    found = np.quantile(np.where(np.isfinite(far), far, np.inf), list(_QUANTILES.values()), method="higher")
    beat = float(np.isfinite(far).mean())
    return {"spread": plan.spec.spread, "modulated": beat, **dict(zip(_QUANTILES, map(_number, found), strict=True))}


def _sentence(findings: Findings, summary: dict[str, Any]) -> str:
    if summary["distance"] is None:
        return "no exciter that beats is known yet" if not findings.complete else "no exciter was found that beats"
    return f"the spectrum is met to {summary['distance']:.2%} {_OF[summary['metric']]}, in the full equations"


def _warnings(plan: Plan, findings: Findings, design: Checked | None) -> list[str]:
    warnings, metric = list(plan.warnings), plan.trials.metric
    lost = [c for c in findings.checked if not c.beats]
    if lost:
        outcomes = ", ".join(dict.fromkeys(c.outcome for c in lost))
        warnings.append(f"{len(lost)} of {len(findings.checked)} candidates do not beat in the full equations: {outcomes}")
    warnings += [f"a run of the full equations ended early: {c.why}" for c in findings.checked if c.why]
    if design is None:
        if findings.complete:
            motions = ", ".join(f"{n} {name}" for name, n in _motions((*findings.reach, *findings.search)).items() if n)
            warnings.append(f"no candidate beats: {motions}; try other ranges, a pendulum whose unbalance is not that of the "
                            "rotor, or a weaker motor")  # fmt: skip
        return warnings
    slow = distances(design.slow.cycles, plan.target, plan.spec.slope)[metric]
    full = design.distances[metric]
    if full > _APART * slow:
        apart = f"the full equations are farther from the target than the averaged ones, {full:.2%} and {slow:.2%}"
        warnings.append(f"{apart}: more corrections, or smaller unbalances, may help")
    summary = _summary(plan, findings, design)
    if summary["beyond"] > _MISSED * plan.target.total:
        warnings.append(f"{summary['beyond']:.3g} cycles of the target are larger than any that is reached")
    at_end = [
        v.name
        for v, x in zip(plan.trials.variables, plan.trials.shares(design.numbers), strict=True)
        if not 1e-3 < x < 1 - 1e-3
    ]
    if at_end:
        warnings.append(
            f"{', '.join(at_end)} {'lies' if len(at_end) == 1 else 'lie'} at an end of the range: a wider one may do better"
        )
    tolerances = summary["tolerances"]
    if tolerances is not None and tolerances["modulated"] < _HARD:
        share = 1 - tolerances["modulated"]
        warnings.append(f"{share:.0%} of the exciters within tolerances of {tolerances['spread']:.1%} do not beat")
    return warnings
