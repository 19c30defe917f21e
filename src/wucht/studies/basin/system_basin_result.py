"""A map of the attractors of equations: findings -> quantities, and the lines of its report."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.limit_sets.basins import DIVERGES, FAILED, NEUTRAL, NOT_SETTLED
from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.sampling.label_maps import share, uncertainty
from wucht.results.attributes import text_in
from wucht.results.formatting import percent, report_lines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.basin.system_basin import SystemBasinFindings, SystemBasinPlan

if TYPE_CHECKING:
    import xarray as xr

_WITHOUT_ATTRACTOR = {NOT_SETTLED: "unsettled", DIVERGES: "diverges", FAILED: "failed", NEUTRAL: "neutral"}
_MOST_FAILURES = 3  # that are named
_NO_AREA = "reached from a set without area"
_MOST_PLACES = 20_001
_TWO_SIGMA = 2.0
_PARTS = {
    "label": ("label of the attractor", ""), "kind": ("kind of the attractor", ""), "share": ("share of the starts", ""),
    "standard_error": ("standard error of the share", ""), "stable": ("whether nearby motions tend to it", ""),
    "state": ("states of the equilibrium", ""), "eigenvalues": ("eigenvalues of the equilibrium", ""),
    "period": ("period of the orbit", ""), "turns": ("turns of the angles in a period", ""),
    "multipliers": ("Floquet multipliers of the orbit", ""),
    "lyapunov_exponent": ("largest Lyapunov exponent with its 95 % interval", ""),
    "min": ("least value of each state", ""), "max": ("largest value of each state", ""),
    "mean": ("mean value of each state", ""),
}  # fmt: skip


def system_basin_dataset(findings: SystemBasinFindings) -> xr.Dataset:
    """Return the Dataset of a map of attractors."""
    plan, attractors, cells = findings.plan, findings.attractors, findings.labels
    names, labels = plan.subject.system.state_names, _labels(findings)
    inside = {labels[k]: cells == k for k in np.unique(cells).tolist()}
    fractions = {name: share(mask) for name, mask in inside.items()}
    errors = {labels[k]: _standard_error(findings, k, mask) for k, mask in zip(np.unique(cells), inside.values(), strict=True)}
    entries = [
        {"label": labels[k], "kind": str(one.kind), "share": fractions.get(labels[k], 0.0),
         "standard_error": errors.get(labels[k], 0.0), **numbers_of(one, names)}
        for k, one in enumerate(attractors)
    ]  # fmt: skip
    order = sorted(range(len(entries)), key=lambda k: -entries[k]["share"])
    flags = [*_WITHOUT_ATTRACTOR, *range(len(attractors))]
    attributes = {"flag_values": np.array(flags, np.int16), "flag_meanings": " ".join(labels[k] for k in flags)}
    axes = {a.name: {"range": [a.low, a.high], "cells": a.cells, "periodic": a.is_periodic} for a in plan.axes}
    quantities = [
        Quantity("axes", axes, "axes of the map"),
        Quantity("fractions", fractions, "shares of the starts by attractor"),
        Quantity("standard_errors", errors, "standard errors of the shares"),
        Quantity("uncertainty", {n: _TWO_SIGMA * e for n, e in errors.items()}, "uncertainty of the shares, in 19 of 20 cases"),
        *table("attractors", [entries[k] for k in order], "attractors, that of most starts first", _PARTS),
        Quantity("runs", findings.runs, "number of runs"),
        Quantity("failures", len(findings.failures), "number of runs without a result"),
        *_map_quantities(plan, findings.coarsest, 0, attributes),
        *(_map_quantities(plan, cells, findings.halvings, attributes) if findings.halvings else []),
        Quantity("state", list(names), "state", "", "state"),
        *_samples(attractors, [labels[k] for k in range(len(attractors))], len(names)),
    ]
    ranking = sorted(fractions, key=lambda name: -fractions[name])
    unstable = {labels[k] for k, one in enumerate(attractors) if one.attracts is False}
    parts = [f"{n} {percent(fractions[n], _TWO_SIGMA * errors[n])}" for n in ranking if n not in unstable]
    parts += [f"{percent(fractions[n])} of the starts end in the saddle {n}" for n in ranking if n in unstable]
    more: dict[str, Any] = {"subject": "system"} | {
        f"{k}_{word}": value
        for k, a in zip("xy", plan.axes, strict=True)
        for word, value in {"axis": a.name, "low": a.low, "high": a.high, "is_angle": int(a.is_angle)}.items()
    }
    sentences = [
        f"{labels[k]}: {sentence_of(one.kind, one, names)}" + (f": {_NO_AREA}" if one.attracts is False else "")
        for k, one in enumerate(attractors)
    ]
    more["attractor_sentences"] = "\n".join(sentences)
    return result_dataset(quantities, ", ".join(parts), _warnings(findings, fractions), **more)


def _map_quantities(plan: SystemBasinPlan, labels: np.ndarray, halvings: int, flags: dict[str, Any]) -> list[Quantity]:
    """Return a map with its coordinates; their names begin with ``refined_`` where cells were halved."""
    prefix = "refined_" if halvings else ""
    return [
        *(
            Quantity(f"{prefix}{k}", axis.centres(halvings), axis.name, "", f"{prefix}{k}")
            for k, axis in zip("xy", plan.axes, strict=True)
        ),
        Quantity(f"{prefix}outcome", labels.astype(np.int16), "attractor", "", f"{prefix}y {prefix}x", attributes=flags),
    ]


def _labels(findings: SystemBasinFindings) -> dict[int, str]:
    """Return the label of each number: the kind, numbered where there are several of it, that of most starts first."""
    attractors, cells = findings.attractors, findings.labels
    labels = dict(_WITHOUT_ATTRACTOR)
    for kind in {one.kind for one in attractors}:
        of_kind = sorted((k for k, one in enumerate(attractors) if one.kind == kind), key=lambda k: -(cells == k).sum())
        labels |= {k: f"{kind}-{i + 1}" if len(of_kind) > 1 else str(kind) for i, k in enumerate(of_kind)}
    return labels


def _standard_error(findings: SystemBasinFindings, number: int, inside: np.ndarray) -> float:
    """Return the standard error of a share: of a grid by its border, of random starts that of a binomial distribution.

    Cells that are labelled with an unstable equilibrium belong by their area to other basins: by as much all shares may be off.
    """
    plan, unstable = findings.plan, [k for k, one in enumerate(findings.attractors) if one.attracts is False]
    without_area = share(np.isin(findings.labels, unstable)) if number >= 0 else 0.0
    if number in unstable:
        return share(inside) / _TWO_SIGMA
    if plan.spec.ranges:
        p = share(inside)
        return math.sqrt(p * (1 - p) / inside.size) + without_area / _TWO_SIGMA
    return (uncertainty(inside, plan.periodic) + without_area) / _TWO_SIGMA


def _samples(attractors: tuple[LimitSet, ...], labels: list[str], count: int) -> list[Quantity]:
    """Return samples of the attractors, padded with NaN."""
    curves = [a.samples(_MOST_PLACES)[1] for a in attractors]
    longest = max((s.shape[1] for s in curves), default=0)
    samples = np.full((len(attractors), count, longest), np.nan)
    for k, states in enumerate(curves):
        samples[k, :, : states.shape[1]] = states
    return [
        Quantity("attractor", labels, "attractor", "", "attractor"),
        Quantity("attractor_states", samples, "state on the attractor", "", "attractor state place"),
    ]


def _warnings(findings: SystemBasinFindings, fractions: dict[str, float]) -> list[str]:
    warnings = []
    if NOT_SETTLED in findings.labels:
        left = f"{100 * fractions['unsettled']:.3g} % of the starts lead to no motion that could be identified"
        warnings.append(f"{left}; a run-up from one of them shows it")
    if NEUTRAL in findings.labels:
        warnings.append(f"{100 * fractions['neutral']:.3g} % of the starts lead to families of motions, which have no basins")
    names = findings.plan.subject.system.state_names
    for start, reason in findings.failures[:_MOST_FAILURES]:
        place = ", ".join(f"{name} = {x:.6g}" for name, x in zip(names, start.tolist(), strict=True))
        warnings.append(f"the run from {place} has no result: {reason}")
    if len(findings.failures) > _MOST_FAILURES:
        warnings.append(f"{len(findings.failures) - _MOST_FAILURES} more runs have no result")
    return warnings


def system_basin_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a map of attractors."""
    s = result.wucht.summary
    finest = result["refined_outcome" if "refined_outcome" in result else "outcome"]
    cells = " x ".join(str(count) for count in finest.shape[::-1])
    lines: list[tuple[str, Any]] = [("map", f"{cells} cells over {' and '.join(s['axes'])}"), ("runs", str(s["runs"]))]
    sentences = text_in(result, "attractor_sentences").split("\n")
    lines += [("saddle" if _NO_AREA in line else "attractor", line) for line in sentences if line]
    lines.append(("shares", "± holds in 19 of 20 cases"))
    return report_lines(result, s["sentence"], lines)
