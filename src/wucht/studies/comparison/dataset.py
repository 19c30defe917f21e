"""Findings -> the Dataset of a comparison: a table over ``variant``, and the curves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import answered, assuming, variable
from wucht.results.style import value_in_words
from wucht.results.summary_units import unit_of_number
from wucht.studies.comparison.compared import Compared
from wucht.studies.comparison.prepare import Case, Plan
from wucht.studies.comparison.run import Findings
from wucht.studies.comparison.varied_key import VariedKey

if TYPE_CHECKING:
    import xarray as xr

_WORDS = {
    "study": "study", "machine": "machine", "outcome": "outcome", "sentence": "answer in words", "failure": "why it failed",
}  # fmt: skip


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset, of the variants that are finished.

    Coordinates (variant): variant (its label), name (without what is varied), source (the file), and each varied key by its
    path, in SI. Variables
    (variant): study, machine, outcome, sentence, failure, and each number of the summaries by its path in them. curve_1_x,
    curve_1_y (variant, sample_1) and so on: curves of one kind each; variants may lack them.
    """
    import xarray as xr_

    done = findings.compared
    cases = plan.cases[: len(done)]
    names = list(dict.fromkeys(name for c in done for name in c.numbers))
    amplitude = next((str(c.summary["amplitude_unit"]) for c in done if c.summary.get("amplitude_unit")), "m")
    bare = all(case.variant.dimensionless for case in cases)
    data = {key: variable("variant", np.array([getattr(c, key) for c in done], str), what) for key, what in _WORDS.items()}
    for name in names:
        numbers = [c.numbers.get(name, np.nan) for c in done]
        unit = next((c.units[name] for c in done if name in c.units), None)
        unit = unit_of_number(name, amplitude, bare) if unit is None else unit
        data[name] = variable("variant", numbers, _in_words(name), unit)
    for k, kind in enumerate(dict.fromkeys(curve.kind for c in done for curve in c.curves), 1):
        data |= _curves(k, kind, done)
    labels = np.array([case.variant.label for case in cases], str)
    coordinates = {
        "variant": variable("variant", labels, "variant"),
        "name": variable("variant", np.array([case.variant.name for case in cases], str), "name"),
        "source": variable("variant", np.array([case.variant.source for case in cases], str), "file"),
    } | {key.path: _varied(key, cases) for key in _keys(cases)}
    result = xr_.Dataset({k: v for k, v in data.items() if k not in coordinates}, coordinates)
    warnings, assumed = (_together(cases, said) for said in ([c.warnings for c in done], [c.assumed for c in done]))
    if not bare:
        bare_ones = [case.variant.label for case in cases if case.variant.dimensionless]
        warnings += [
            f"{one}: dimensionless; its numbers have no units and cannot be set against the others'" for one in bare_ones
        ]
    return assuming(answered(result, _summary(plan, done, names), _sentence(plan, done), warnings), assumed)


def _curves(number: int, kind: tuple[str, ...], done: Sequence[Compared]) -> dict[str, Any]:
    """Of one kind, of all variants, filled up to the length of the longest."""
    own = [next((curve for curve in c.curves if curve.kind == kind), None) for c in done]
    longest = max(len(curve.x) for curve in own if curve is not None)
    filled = np.full((2, len(own), longest), np.nan)
    for k, curve in enumerate(own):
        if curve is not None:
            filled[:, k, : len(curve.x)] = curve.x, curve.y
    dims = f"variant sample_{number}"
    return {f"curve_{number}_{axis}": variable(dims, filled[i], kind[i], kind[2 + i]) for i, axis in enumerate(("x", "y"))}


def _in_words(path: str) -> str:
    """A number of a summary by its path: ``final phases, p1`` of a table."""
    name, _, of = path.partition(".")
    return f"{name.replace('_', ' ')}{f', {of}' if of else ''}"


def _keys(cases: Sequence[Case]) -> tuple[VariedKey, ...]:
    """What is varied: the same in all of them."""
    return cases[0].variant.keys if cases else ()


def _varied(key: VariedKey, cases: Sequence[Case]) -> Any:
    """What a key was in each variant: numbers, or texts where one of them is none."""
    values = [case.variant.varied[key.path] for case in cases]
    numeric = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    if not numeric:
        return variable("variant", np.array([value_in_words(v, *key.printed) for v in values]), key.what)
    dims, numbers, attributes = variable("variant", values, key.what, key.unit or "")
    factor, unit = key.printed
    return dims, numbers, attributes | ({"printed_units": unit, "printed_factor": factor} if key.written else {})


def _summary(plan: Plan, done: Sequence[Compared], names: Sequence[str]) -> dict[str, Any]:
    shown = list(dict.fromkeys(name for c in done for name in c.shown if name in names))
    return {
        "variants": [
            {
                "label": case.variant.label, "source": case.variant.source, "varied": dict(case.variant.varied),
                "study": c.study, "machine": c.machine, "outcome": c.outcome, "failure": c.failure or None,
                "summary": c.summary,
            }
            for case, c in zip(plan.cases, done, strict=False)
        ],
        "outcomes": dict(Counter(c.outcome for c in done if c.outcome)),
        "failed": sum(bool(c.failure) for c in done),
        "vary": {path: list(values) for path, values in plan.spec.vary.items()},
        "varied": {key.path: {"what": key.what, "unit": key.unit} for key in _keys(plan.cases)},
        "headline": shown or list(names),
    }  # fmt: skip


def _sentence(plan: Plan, done: Sequence[Compared]) -> str:
    count = Counter(c.outcome for c in done if c.outcome)
    outcomes = ", ".join(f"{n} {outcome}" for outcome, n in count.most_common())
    ready = f"{len(done)} variants" if len(done) == len(plan.cases) else f"{len(done)} of {len(plan.cases)} variants"
    return f"{ready}{f': {outcomes}' if outcomes else ''}"


def _together(cases: Sequence[Case], said: Sequence[tuple[str, ...]]) -> list[str]:
    """Sentences on each variant; what is said of all of them once."""
    count = Counter(sentence for own in said for sentence in own)
    every = [sentence for sentence, n in count.items() if n == len(said)]
    pairs = [(case.variant.label, sentence) for case, own in zip(cases, said, strict=True) for sentence in own]
    return [*every, *(f"{label}: {sentence}" for label, sentence in pairs if sentence not in every)]
