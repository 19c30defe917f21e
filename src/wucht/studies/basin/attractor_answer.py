"""What the answer of a map of equations states further: the attractors, their numbers and their samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.dynamics.limit_sets.attractor_runs import AttractorRuns
from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.sampling.outcome_maps import Level
from wucht.studies.answer import Answer
from wucht.studies.basin.answer import Labels, Shares
from wucht.studies.limit_set_variables import EXPONENT, LIMIT_SET_NUMBERS, STATE_RANGES

_NO_AREA = "reached from a set without area"
_MOST_PLACES = 20_001
_PARTS = {
    "label": ("label of the attractor", ""), "kind": ("kind of the attractor", ""), "share": ("share of the starts", ""),
    "standard_error": ("standard error of the share", ""),
    **LIMIT_SET_NUMBERS, "lyapunov_exponent": (EXPONENT, ""), **STATE_RANGES,
}  # fmt: skip


def state_attractors(a: Answer, runs: AttractorRuns, last: Level, labels: Labels, shares: Shares) -> None:
    """State the attractors, that of most starts first, and warn of starts without one."""
    names, attractors = runs.subject.system.state_names, runs.known_sets
    fractions, errors = shares["fractions"], shares["uncertainty"]
    entries = [
        {"label": labels[k], "kind": str(one.kind), "share": fractions.get(labels[k], 0.0),
         "standard_error": errors.get(labels[k], 0.0) / 2, **numbers_of(one, names)}
        for k, one in enumerate(attractors)
    ]  # fmt: skip
    entries.sort(key=lambda entry: -entry["share"])
    parts = {name: (words, a.unit(unit)) for name, (words, unit) in _PARTS.items()}
    a.number("attractors", entries, "attractors, that of most starts first", parts=parts)
    a.curve("state", list(names), "state")
    _state_samples(a, attractors, labels, len(names))
    sentences = list[str]()
    for k, one in enumerate(attractors):
        no_area = f": {_NO_AREA}" if one.attracts is False else ""
        sentences.append(f"{labels[k]}: {sentence_of(one.kind, one, names)}{no_area}")
        a.line("saddle" if no_area else "attractor", "{sentence}", sentence=sentences[-1])
    a.attribute(subject="system", attractor_sentences="\n".join(sentences))
    if "unsettled" in fractions:
        left = f"{100 * fractions['unsettled']:.3g} % of the starts lead to no motion that could be identified"
        a.warn(f"{left}; a run-up from one of them shows it")
    if "neutral" in fractions:
        a.warn(f"{100 * fractions['neutral']:.3g} % of the starts lead to families of motions, which have no basins")


def _state_samples(a: Answer, attractors: Sequence[LimitSet], labels: Labels, count: int) -> None:
    """State samples of the attractors, padded with NaN."""
    curves = [one.samples(_MOST_PLACES)[1] for one in attractors]
    longest = max((s.shape[1] for s in curves), default=0)
    samples = np.full((len(attractors), count, longest), np.nan)
    for k, states in enumerate(curves):
        samples[k, :, : states.shape[1]] = states
    a.curve("attractor", [labels[k] for k in range(len(attractors))], "attractor")
    a.curve("attractor_states", samples, "state on the attractor", "", "attractor state place")
