"""Findings -> the Dataset of an activation."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.switching import switchable, switching
from wucht.machines.operation import natural_frequencies
from wucht.results.conventions import answered, variable
from wucht.studies.activation.prepare import BALANCED, NONE, RIGID, SWITCHABLE, Plan
from wucht.studies.activation.run import CURVE, Done, Findings

if TYPE_CHECKING:
    import xarray as xr

_CLOSED = 1e-6  # an energy residual beyond it is reported as a warning
_PEAKS = {
    "peak": "largest amplitude",
    "peak_before": "largest amplitude before the first opening",
    "peak_after": "largest amplitude from the first opening on",
}
Cell = tuple[str, int, int, int]


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of an activation.

    peak, peak_before, peak_after, final_amplitude, opened_at, orientation_at_activation, energy_residual, outcome
    (activation_speed, orientation, phase); balanced_peak, rigid_peak (orientation, phase); none_peak; curve_speed,
    curve_amplitude (curve, point): of none, and of the first phase of each orientation at the first activation speed, of each
    variant.
    NaN where a run is missing.
    """
    import xarray as xr_

    done = {(r.of, r.speed, r.orientation, r.phase): findings.done[r.name] for r in plan.runs if r.name in findings.done}
    spec, length, unit = plan.spec, plan.machine.orbit_unit, plan.machine.units.speed
    shape = (len(plan.speeds), len(spec.orientations), len(plan.phases))

    def table(key: str, of: str = SWITCHABLE) -> np.ndarray:
        """A number of each run, (speeds, orientations, phases)."""
        values = np.full(shape if of == SWITCHABLE else (1, *shape[1:]), math.nan)
        for (kind, i, j, k), d in done.items():
            if kind == of:
                values[max(i, 0), j, k] = getattr(d, key)
        return values

    every, runs = "activation_speed orientation phase", {c: d for c, d in done.items() if c[0] == SWITCHABLE}
    outcome = np.full(shape, "", "U24")
    opened = np.full(shape, math.nan)
    for (_, i, j, k), d in runs.items():
        outcome[i, j, k], opened[i, j, k] = d.outcome, np.mean(d.opened_at)
    none = done.get((NONE, -1, -1, -1))
    labels, curves = _curves(plan, done)
    data = {key: variable(every, table(key), text, length) for key, text in _PEAKS.items()} | {
        "final_amplitude": variable(every, table("final_amplitude"), "amplitude at the end", length),
        "opened_at": variable(every, opened, "mean speed of the pendulums as they open", unit),
        "orientation_at_activation": variable(every, table("orientation"), "angle between the first two as one opens", "rad"),
        "energy_residual": variable(every, table("energy_residual"), "energy residual, relative"),
        "outcome": variable(every, outcome, "outcome"),
        "balanced_peak": variable(
            "orientation phase", table("peak", BALANCED)[0], "largest amplitude without permanent unbalances", length
        ),
        "rigid_peak": variable("orientation phase", table("peak", RIGID)[0], "largest amplitude, rigid pendulums", length),
        "none_peak": variable("", none.peak if none else None, "largest amplitude without pendulums", length),
        "curve_speed": variable("curve point", curves[:, 0], "speed of the rotor", unit),
        "curve_amplitude": variable("curve point", curves[:, 1], "amplitude of the axis", length),
    }
    coordinates = {
        "activation_speed": variable("activation_speed", list(plan.speeds), "activation speed", unit),
        "orientation": variable("orientation", list(spec.orientations), "orientation at the start", "rad"),
        "phase": variable("phase", list(plan.phases), "mean phase at the start", "rad"),
        "curve": variable("curve", labels or np.empty(0, "U1"), "run"),
    }
    summary = _summary(plan, done)
    result = xr_.Dataset(dict(data), coords=coordinates)
    failure = next((d.failure for d in done.values() if d.failure), None)
    return answered(result, summary, summary["sentence"], _warnings(plan, done), failure)


def _curves(plan: Plan, done: dict[Cell, Done]) -> tuple[list[str], np.ndarray]:
    """Labels (n) and curves (n, 2, CURVE)."""
    found: list[tuple[str, np.ndarray]] = []
    if (NONE, -1, -1, -1) in done:
        found.append(("without pendulums", done[NONE, -1, -1, -1].curve))
    for of, i in ((SWITCHABLE, 0), (BALANCED, -1), (RIGID, -1)):
        for j, angle in enumerate(plan.spec.orientations):
            if (of, i, j, 0) in done:
                found.append((f"{of}, {math.degrees(angle):.4g}°", done[of, i, j, 0].curve))
    return [name for name, _ in found], np.array([c for _, c in found]).reshape(len(found), 2, CURVE)


def _summary(plan: Plan, done: dict[Cell, Done]) -> dict[str, Any]:
    none = done.get((NONE, -1, -1, -1))
    groups = [_group(plan, done, SWITCHABLE, i, j) for i in range(len(plan.speeds)) for j in range(len(plan.spec.orientations))]
    balanced, rigid = (
        [g for j in range(len(plan.spec.orientations)) if (g := _group(plan, done, of, -1, j))] for of in (BALANCED, RIGID)
    )
    switchable = [g for g in groups if g]
    best = min(switchable, key=lambda g: float(g["peak_amplitude"]), default=None)
    made: dict[str, Any] = {
        "switchable": switchable,
        "balanced": balanced,
        "rigid": rigid,
        "none": None if none is None else {"peak_amplitude": none.peak, "peak_speed": none.peak_speed, "outcome": none.outcome},
        "pendulums": [_switching(plan, k) for k in range(len(plan.pendulums))],
        "natural_frequencies": natural_frequencies(plan.machine),
        "energy_residual": max((d.energy_residual for d in done.values()), default=None),
        "runs": len(done),
        "best": best,
    }
    length = plan.machine.orbit_unit
    return made | {"sentence": _sentence(made, *((1e3, "mm") if length == "m" else (1.0, length)))}


def _group(plan: Plan, done: dict[Cell, Done], of: str, i: int, j: int) -> dict[str, Any] | None:
    """What the runs of all phases have in common; None where none is done."""
    runs = [done[cell] for k in range(len(plan.phases)) if (cell := (of, i, j, k)) in done]
    if not runs:
        return None
    peaks = [d.peak for d in runs]
    group: dict[str, Any] = {
        "orientation": plan.spec.orientations[j],
        "peak_amplitude": max(peaks),
        "mean_peak": float(np.mean(peaks)),
        "outcomes": dict(Counter(d.outcome for d in runs)),
    }
    if of in (SWITCHABLE, BALANCED):
        opened = [d for d in runs if not math.isnan(d.peak_after)]
        group |= {
            "activation_speed": plan.speeds[i]
            if of == SWITCHABLE
            else switching(plan.machine, switchable(plan.machine)[0]).opening,
            "peak_before": max((d.peak_before for d in opened), default=None),
            "peak_after": max((d.peak_after for d in opened), default=None),
            "opened_at": float(np.nanmean([d.opened_at for d in opened])) if opened else None,
            "orientations_at_activation": [None if math.isnan(d.orientation) else d.orientation for d in runs],
            "all_open": sum(all(d.open_at_end) for d in runs),
        }
    return group


def _switching(plan: Plan, k: int) -> dict[str, Any]:
    each = [s[k] for s in plan.switching]
    return {
        "name": plan.pendulums[k],
        "opening": [s.opening for s in each],
        "closing": [s.closing for s in each],
        "after_opening": [s.after for s in each],
        "snaps": [s.snaps for s in each],
        "stays_open": [s.stays_open for s in each],
    }


def _sentence(s: dict[str, Any], scale: float, unit: str) -> str:
    names = {SWITCHABLE: "switchable pendulums", BALANCED: "balanced ones", RIGID: "rigid ones"}
    peaks = {name: [scale * g["peak_amplitude"] for g in s[of]] for of, name in names.items() if s[of]}
    ends = {name: dict.fromkeys((f"{min(p):.4g}", f"{max(p):.4g}")) for name, p in peaks.items()}
    texts = [f"{name} {' to '.join(both)} {unit}" for name, both in ends.items()]
    texts += [f"none {scale * s['none']['peak_amplitude']:.4g} {unit}"] if s["none"] else []
    return f"peak with {', '.join(texts)}" if texts else "no run is finished"


def _warnings(plan: Plan, done: dict[Cell, Done]) -> list[str]:
    warnings = []
    for name, each in zip(plan.pendulums, zip(*plan.switching, strict=True), strict=True):
        for s in each:
            if s.snaps and not s.stays_open:
                slower = f"as its mass moves out it slows down from {s.opening:.4g} to {s.after:.4g} rad/s, and it closes"
                cure = "more frame inertia, less stiffness or a shorter stroke keep it open"
                warnings.append(f"{name!r} may open and close again and again: {slower} below {s.closing:.4g} rad/s; {cure}")
    closed = sum(not all(d.open_at_end) for (of, *_), d in done.items() if of in (SWITCHABLE, BALANCED))
    if closed:
        warnings.append(f"in {closed} runs not all pendulums are open at the end")
    worst = max((d.energy_residual for d in done.values()), default=0.0)
    if not worst <= _CLOSED:
        warnings.append(f"the energy balance closes only to {worst:.1e}: give a smaller study.tolerance")
    missing = len(plan.runs) - len(done)
    return [*warnings, *([f"{missing} of {len(plan.runs)} runs are missing"] if missing else [])]
