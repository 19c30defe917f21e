"""The answer of a map of the attractors of equations: basins, shares and attractors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.limit_sets.attractor_maps import AttractorLabels, AttractorMap
from wucht.dynamics.limit_sets.basins import DIVERGES, FAILED, NEUTRAL, NOT_SETTLED
from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.sampling.label_maps import share, uncertainty
from wucht.results.formatting import percent
from wucht.studies.answer import Answer

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


def state_attractors(map_: AttractorMap, has_random_starts: bool, labels_of: AttractorLabels, a: Answer) -> None:
    """State the answer with the labels of the cells; has_random_starts: further states are drawn at random."""
    attractors, cells = labels_of.attractors, labels_of.labels
    names, labels = map_.subject.system.state_names, _labels(labels_of)
    inside = {k: cells == k for k in np.unique(cells).tolist()}
    fractions = {labels[k]: share(mask) for k, mask in inside.items()}
    errors = {labels[k]: _standard_error(map_, has_random_starts, labels_of, k, mask) for k, mask in inside.items()}
    axes = {
        axis.name: {"range": [axis.low, axis.high], "cells": axis.cells, "periodic": axis.is_periodic} for axis in map_.axes
    }
    a.number("axes", axes, "axes of the map")
    a.number("fractions", fractions, "shares of the starts by attractor")
    a.number("standard_errors", errors, "standard errors of the shares")
    double_errors = {name: _TWO_SIGMA * error for name, error in errors.items()}
    a.number("uncertainty", double_errors, "uncertainty of the shares, in 19 of 20 cases")
    entries = [
        {"label": labels[k], "kind": str(one.kind), "share": fractions.get(labels[k], 0.0),
         "standard_error": errors.get(labels[k], 0.0), **numbers_of(one, names)}
        for k, one in enumerate(attractors)
    ]  # fmt: skip
    entries.sort(key=lambda entry: -entry["share"])
    a.number("attractors", entries, "attractors, that of most starts first", parts=_PARTS)
    rows, columns = cells.shape
    a.line("map", f"{columns} x {rows} cells over {' and '.join(axes)}")
    a.line("runs", str(a.number("runs", labels_of.runs, "number of runs")))
    a.number("failures", len(labels_of.failures), "number of runs without a result")
    _state_map(a, map_, labels_of.coarsest, 0, labels)
    if labels_of.halvings:
        _state_map(a, map_, cells, labels_of.halvings, labels)
    a.curve("state", list(names), "state")
    _state_samples(a, attractors, labels, len(names))
    ranking = sorted(fractions, key=lambda name: -fractions[name])
    unstable = {labels[k] for k, one in enumerate(attractors) if one.attracts is False}
    clauses = [f"{n} {percent(fractions[n], double_errors[n])}" for n in ranking if n not in unstable]
    clauses += [f"{percent(fractions[n])} of the starts end in the saddle {n}" for n in ranking if n in unstable]
    a.sentence = ", ".join(clauses)
    sentences = list[str]()
    for k, one in enumerate(attractors):
        without_area = f": {_NO_AREA}" if one.attracts is False else ""
        sentences.append(f"{labels[k]}: {sentence_of(one.kind, one, names)}{without_area}")
        a.line("saddle" if without_area else "attractor", "{sentence}", sentence=sentences[-1])
    a.attribute(subject="system", attractor_sentences="\n".join(sentences))
    for letter, axis in zip("xy", map_.axes, strict=True):
        ends = {"axis": axis.name, "low": axis.low, "high": axis.high, "is_angle": int(axis.is_angle)}
        a.attribute(**{f"{letter}_{word}": value for word, value in ends.items()})
    a.line("shares", "± holds in 19 of 20 cases")
    _warn(a, map_, labels_of, fractions)


def _state_map(a: Answer, map_: AttractorMap, cells: np.ndarray, halvings: int, labels: dict[int, str]) -> None:
    """State a map with its coordinates; their names begin with ``refined_`` where cells were halved."""
    prefix = "refined_" if halvings else ""
    flags = {"flag_values": np.array(list(labels), np.int16), "flag_meanings": " ".join(labels.values())}
    for k, axis in zip("xy", map_.axes, strict=True):
        a.curve(f"{prefix}{k}", axis.centres(halvings), axis.name)
    a.curve(f"{prefix}outcome", cells.astype(np.int16), "attractor", "", f"{prefix}y {prefix}x", attributes=flags)


def _labels(labels_of: AttractorLabels) -> dict[int, str]:
    """Return the label of each number: the kind, numbered where there are several of it, that of most starts first."""
    attractors, cells = labels_of.attractors, labels_of.labels
    labels = dict(_WITHOUT_ATTRACTOR)
    for kind in {one.kind for one in attractors}:
        of_kind = sorted((k for k, one in enumerate(attractors) if one.kind == kind), key=lambda k: -(cells == k).sum())
        labels |= {k: f"{kind}-{i + 1}" if len(of_kind) > 1 else str(kind) for i, k in enumerate(of_kind)}
    return {k: labels[k] for k in (*_WITHOUT_ATTRACTOR, *range(len(attractors)))}


def _standard_error(
    map_: AttractorMap, has_random_starts: bool, labels_of: AttractorLabels, number: int, inside: np.ndarray
) -> float:
    """Return the standard error of a share: of a grid by its border, of random starts that of a binomial distribution.

    Cells that are labelled with an unstable equilibrium belong by their area to other basins: by as much all shares may be off.
    """
    unstable = [k for k, one in enumerate(labels_of.attractors) if one.attracts is False]
    without_area = share(np.isin(labels_of.labels, unstable)) if number >= 0 else 0.0
    if number in unstable:
        return share(inside) / _TWO_SIGMA
    if has_random_starts:
        p = share(inside)
        return math.sqrt(p * (1 - p) / inside.size) + without_area / _TWO_SIGMA
    return (uncertainty(inside, map_.periodic) + without_area) / _TWO_SIGMA


def _state_samples(a: Answer, attractors: Sequence[LimitSet], labels: dict[int, str], count: int) -> None:
    """State samples of the attractors, padded with NaN."""
    curves = [one.samples(_MOST_PLACES)[1] for one in attractors]
    longest = max((s.shape[1] for s in curves), default=0)
    samples = np.full((len(attractors), count, longest), np.nan)
    for k, states in enumerate(curves):
        samples[k, :, : states.shape[1]] = states
    a.curve("attractor", [labels[k] for k in range(len(attractors))], "attractor")
    a.curve("attractor_states", samples, "state on the attractor", "", "attractor state place")


def _warn(a: Answer, map_: AttractorMap, labels_of: AttractorLabels, fractions: dict[str, float]) -> None:
    if NOT_SETTLED in labels_of.labels:
        left = f"{100 * fractions['unsettled']:.3g} % of the starts lead to no motion that could be identified"
        a.warn(f"{left}; a run-up from one of them shows it")
    if NEUTRAL in labels_of.labels:
        a.warn(f"{100 * fractions['neutral']:.3g} % of the starts lead to families of motions, which have no basins")
    names = map_.subject.system.state_names
    for start, reason in labels_of.failures[:_MOST_FAILURES]:
        place = ", ".join(f"{name} = {x:.6g}" for name, x in zip(names, start.tolist(), strict=True))
        a.warn(f"the run from {place} has no result: {reason}")
    if len(labels_of.failures) > _MOST_FAILURES:
        a.warn(f"{len(labels_of.failures) - _MOST_FAILURES} more runs have no result")
