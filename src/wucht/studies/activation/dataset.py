"""Findings -> the quantities of an activation, and its lines in a report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.switching import switchable, switching
from wucht.dynamics.sampling.choice import Line, Scores, nearest_cliff, sides_on_grid
from wucht.machines.operation import natural_frequencies
from wucht.results.formatting import ReportLines, formats
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.activation.computation import (
    BALANCED_VARIANT,
    CURVE,
    NO_PENDULUMS,
    RIGID,
    SWITCHABLE,
    ActivationRun,
    Findings,
    Plan,
)

if TYPE_CHECKING:
    import xarray as xr


_RESIDUAL_LIMIT = 1e-6  # a larger energy residual is reported as a warning
_AXES = ("activation_speed", "orientation")
Cell = tuple[str, int, int, int]
Group = dict[str, Any]


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of an activation, with NaN where a run is missing."""
    results = {
        (r.of, r.speed, r.orientation, r.phase): findings.results[r.name] for r in plan.runs if r.name in findings.results
    }
    groups = {of: _groups(plan, results, of) for of in (SWITCHABLE, BALANCED_VARIANT, RIGID)}
    bare_run, length = results.get((NO_PENDULUMS, -1, -1, -1)), plan.machine.orbit_unit
    quantities = [
        *_group_quantities(plan, groups, bare_run),
        *_pendulum_quantities(plan),
        Quantity(
            "energy_residual", max((d.energy_residual for d in results.values()), default=None), "largest energy residual"
        ),
        Quantity("runs", len(results), "number of completed runs"),
        *_run_quantities(plan, results),
        Quantity("none_peak", bare_run and bare_run.peak, "largest amplitude without pendulums", length, ""),
        *_curve_quantities(plan, results),
    ]
    failure = next((d.failure for d in results.values() if d.failure), None)
    sentence = _sentence(groups, bare_run, *((1e3, "mm") if length == "m" else (1.0, length)))
    return result_dataset(quantities, sentence, _warnings(plan, results), (), failure)


def _run_quantities(plan: Plan, results: dict[Cell, ActivationRun]) -> list[Quantity]:
    """Quantities of each run."""
    length, every = plan.machine.orbit_unit, "activation_speed orientation phase"

    def run_array(reading: Callable[[ActivationRun], Any], of: str = SWITCHABLE, kind: type | str = float) -> np.ndarray:
        """Array of a reading of each run (speeds, orientations, phases)."""
        shape = len(plan.speeds) if of == SWITCHABLE else 1, len(plan.spec.orientations), len(plan.phases)
        values = np.full(shape, math.nan if kind is float else "", kind)
        for (_, i, j, k), d in ((cell, d) for cell, d in results.items() if cell[0] == of):
            values[max(i, 0), j, k] = reading(d)
        return values

    words = _words(plan)
    simple = ("peak", "peak_before", "peak_after", "final_amplitude", "energy_residual")
    opening_speed, separation = run_array(lambda d: np.mean(d.opened_at)), run_array(attrgetter("orientation"))
    balanced_peak, rigid_peak = (run_array(attrgetter("peak"), of)[0] for of in (BALANCED_VARIANT, RIGID))
    return [
        Quantity("activation_speed", list(plan.speeds), *words["activation_speed"], "activation_speed"),
        Quantity("orientation", list(plan.spec.orientations), *words["orientation"], "orientation"),
        Quantity("phase", list(plan.phases), "mean phase at the start", "rad", "phase"),
        *(Quantity(name, run_array(attrgetter(name)), *words[name], every) for name in simple),
        Quantity("opened_at", opening_speed, *words["opened_at"], every),
        Quantity("orientation_at_activation", separation, "angle between the first two as one opens", "rad", every),
        Quantity("outcome", run_array(attrgetter("outcome"), kind="U24"), "outcome", "", every),
        Quantity("balanced_peak", balanced_peak, "largest amplitude without permanent unbalances", length, "orientation phase"),
        Quantity("rigid_peak", rigid_peak, "largest amplitude, rigid pendulums", length, "orientation phase"),
    ]


def _words(plan: Plan) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of runs and of groups of runs."""
    length, speed = plan.machine.orbit_unit, plan.machine.units.speed
    return {
        "activation_speed": ("activation speed", speed),
        "orientation": ("orientation at the start", "rad"),
        "peak": ("largest amplitude", length),
        "peak_before": ("largest amplitude before the first opening", length),
        "peak_after": ("largest amplitude from the first opening on", length),
        "peak_amplitude": ("largest amplitude", length),
        "peak_speed": ("mean speed of the rotor over the turn there", speed),
        "mean_peak": ("mean of the largest amplitudes", length),
        "final_amplitude": ("amplitude at the end", length),
        "opened_at": ("mean speed of the pendulums as they open", speed),
        "orientations_at_activation": ("angles between the first two as one opens", "rad"),
        "all_open": ("number of runs at whose end all are open", ""),
        "energy_residual": ("energy residual, relative", ""),
        "neighbours": ("groups beside it", ""),
        "cliff": ("nearest value at which the largest amplitude is more than twice as large", ""),
        "outcome": ("outcome", ""),
        "outcomes": ("number of runs of each outcome", ""),
    }


def _curve_quantities(plan: Plan, results: dict[Cell, ActivationRun]) -> list[Quantity]:
    """Curves without pendulums, and of the first phase of each orientation at the first activation speed, of each variant."""
    curves = {"without pendulums": results[NO_PENDULUMS, -1, -1, -1].curve} if (NO_PENDULUMS, -1, -1, -1) in results else {}
    for of, i in ((SWITCHABLE, 0), (BALANCED_VARIANT, -1), (RIGID, -1)):
        for j, angle in enumerate(plan.spec.orientations):
            if (of, i, j, 0) in results:
                curves[f"{of}, {math.degrees(angle):.4g}\u00b0"] = results[of, i, j, 0].curve
    values, units = np.array([*curves.values()]).reshape(len(curves), 2, CURVE), plan.machine.units
    return [
        Quantity("curve", list(curves) or np.empty(0, "U1"), "run", "", "curve"),
        Quantity("curve_speed", values[:, 0], "speed of the rotor", units.speed, "curve point"),
        Quantity("curve_amplitude", values[:, 1], "amplitude of the axis", plan.machine.orbit_unit, "curve point"),
    ]


def _group_quantities(plan: Plan, groups: dict[str, list[Group]], bare_run: ActivationRun | None) -> list[Quantity]:
    """Numbers over the runs of all phases, of each variant."""
    words = _words(plan)
    run = bare_run and {
        "peak_amplitude": bare_run.peak,
        "peak_speed": None if math.isnan(bare_run.peak_speed) else bare_run.peak_speed,
        "outcome": bare_run.outcome,
    }
    best = _best_group(groups[SWITCHABLE])
    return [
        *(q for of, rows in groups.items() for q in table(of, rows, f"{of} pendulums by their orientation", words)),
        Quantity("none", run, "machine without pendulums", parts=words),
        Quantity("best", best, "switchable pendulums whose largest amplitude is smallest", parts=words),
    ]


def _best_group(groups: list[Group]) -> Group | None:
    """The group with the smallest peak, those beside it, and the nearest value at which the peak is twice as large."""
    if not groups:
        return None
    peaks = np.array([[float(g["peak_amplitude"])] for g in groups])
    values = np.array([[g[name] for name in _AXES] for g in groups], float)
    scores = Scores(peaks, np.zeros(peaks.shape, bool))
    k = int(scores.order[0])
    sides = sides_on_grid(values, k)
    lines = [Line(_AXES[axis], values[beside, axis].tolist(), beside) for axis, beside in sides]
    cliff = nearest_cliff(scores, k, dict(zip(_AXES, values[k].tolist(), strict=True)), lines)
    nearest = [groups[beside[0]] for _, beside in sides if beside]
    return groups[k] | {
        "neighbours": [{name: g[name] for name in (*_AXES, "peak_amplitude")} for g in nearest],
        "cliff": None if cliff is None else {
            "parameter": cliff.parameter, "value": cliff.value, "inside": cliff.inside, "peak_amplitude": cliff.cost
        },
    }  # fmt: skip


def _groups(plan: Plan, results: dict[Cell, ActivationRun], of: str) -> list[Group]:
    """The groups of a variant for each activation speed and orientation with completed runs."""
    speeds = range(len(plan.speeds)) if of == SWITCHABLE else (-1,)
    candidates = (_group(plan, results, of, i, j) for i in speeds for j in range(len(plan.spec.orientations)))
    return [group for group in candidates if group]


def _group(plan: Plan, results: dict[Cell, ActivationRun], of: str, i: int, j: int) -> Group | None:
    """Numbers over the runs of all phases; None if no run is completed."""
    runs = [results[cell] for k in range(len(plan.phases)) if (cell := (of, i, j, k)) in results]
    if not runs:
        return None
    peaks = [d.peak for d in runs]
    group: Group = {
        "orientation": plan.spec.orientations[j],
        "peak_amplitude": max(peaks),
        "mean_peak": float(np.mean(peaks)),
        "outcomes": dict(Counter(d.outcome for d in runs)),
    }
    if of in (SWITCHABLE, BALANCED_VARIANT):
        opening_runs = [d for d in runs if not math.isnan(d.peak_after)]
        group |= {
            "activation_speed": plan.speeds[i]
            if of == SWITCHABLE
            else switching(plan.machine, switchable(plan.machine)[0]).opening,
            "peak_before": max((d.peak_before for d in opening_runs), default=None),
            "peak_after": max((d.peak_after for d in opening_runs), default=None),
            "opened_at": float(np.nanmean([d.opened_at for d in opening_runs])) if opening_runs else None,
            "orientations_at_activation": [None if math.isnan(d.orientation) else d.orientation for d in runs],
            "all_open": sum(all(d.open_at_end) for d in runs),
        }
    return group


def _pendulum_quantities(plan: Plan) -> list[Quantity]:
    """Speeds at which each pendulum opens and closes, at each activation speed."""
    speed = plan.machine.units.speed
    columns = {
        "opening": ("speeds at which it opens", speed),
        "closing": ("speeds at which it closes", speed),
        "after_opening": ("speeds at which it continues once it is open", speed),
        "snaps": ("whether its mass goes from stop to stop", ""),
        "stays_open": ("whether it then remains open", ""),
    }
    attributes = {part: part for part in columns} | {"after_opening": "open_speed"}
    rows = [
        {"name": name} | {part: [getattr(s, attributes[part]) for s in switchings] for part in columns}
        for name, switchings in zip(plan.pendulums, zip(*plan.switching, strict=True), strict=True)
    ]
    natural = Quantity("natural_frequencies", natural_frequencies(plan.machine), "natural frequencies by mode", speed)
    return [*table("pendulums", rows, "switchable pendulums", {"name": ("name of the pendulum", "")} | columns), natural]


def _sentence(groups: dict[str, list[Group]], bare_run: ActivationRun | None, scale: float, unit: str) -> str:
    names = {SWITCHABLE: "switchable pendulums", BALANCED_VARIANT: "balanced ones", RIGID: "rigid ones"}
    peaks = {name: [scale * g["peak_amplitude"] for g in groups[of]] for of, name in names.items() if groups[of]}
    ends = {name: dict.fromkeys((f"{min(p):.4g}", f"{max(p):.4g}")) for name, p in peaks.items()}
    texts = [f"{name} {' to '.join(limits)} {unit}" for name, limits in ends.items()]
    texts += [f"none {scale * bare_run.peak:.4g} {unit}"] if bare_run else []
    return f"peak with {', '.join(texts)}" if texts else "no run is finished"


def _warnings(plan: Plan, results: dict[Cell, ActivationRun]) -> list[str]:
    warnings = []
    for name, switchings in zip(plan.pendulums, zip(*plan.switching, strict=True), strict=True):
        for s in switchings:
            if s.snaps and not s.stays_open:
                slower = (
                    f"as its mass moves out the speed falls from {s.opening:.4g} to {s.open_speed:.4g} rad/s, and it closes"
                )
                cure = "more frame inertia, less stiffness or a shorter stroke keep it open"
                warnings.append(f"{name!r} may open and close repeatedly: {slower} below {s.closing:.4g} rad/s; {cure}")
    closed_runs = sum(not all(d.open_at_end) for (of, *_), d in results.items() if of in (SWITCHABLE, BALANCED_VARIANT))
    if closed_runs:
        warnings.append(f"in {closed_runs} runs not all pendulums are open at the end")
    worst = max((d.energy_residual for d in results.values()), default=0.0)
    if not worst <= _RESIDUAL_LIMIT:
        warnings.append(f"the energy balance closes only to {worst:.1e}: give a smaller study.tolerance")
    missing = len(plan.runs) - len(results)
    return [*warnings, *([f"{missing} of {len(plan.runs)} runs are missing"] if missing else [])]


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an activation."""
    s, (speed, _), lines = result.wucht.summary, formats(result), ReportLines(result)
    alike: dict[str, list[str]] = {}
    for p in s["pendulums"]:
        for opening, closing, snaps in zip(p["opening"], p["closing"], p["snaps"], strict=True):
            behaviour = f"opens at {speed(opening)}, closes at {speed(closing)}{'' if snaps else ': gradually in between'}"
            alike.setdefault(behaviour, []).append(p["name"])
    for behaviour, names in alike.items():
        lines.add(", ".join(names), behaviour)
    lines.add("none", "{none.peak_amplitude} at {none.peak_speed}")
    for name in ("rigid", "balanced", "switchable"):
        for group in s[name]:
            after = "" if name == "rigid" else ", none opens"
            if group.get("peak_after") is not None:
                after = ", {peak_after} from the opening on"
            at = "at {activation_speed:.5g}, " if name != "rigid" and len(result.activation_speed) > 1 else ""
            outcomes = ", ".join(f"{n} {outcome}" for outcome, n in group["outcomes"].items())
            lines.add(name, f"{at}{{orientation}} apart: {{peak_amplitude}} at most{after}; {outcomes}", group, name)
    lines.add("energy", "balance closed to {energy_residual:.1e} in all runs")
    return lines.report(s["sentence"])
