"""Findings -> the Dataset of a comparison: a table over ``variant``, and the curves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import answered, assuming, variable
from wucht.results.summary_units import unit_of_number
from wucht.studies.comparison.compared import Compared
from wucht.studies.comparison.prepare import Case, Plan
from wucht.studies.comparison.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_WORDS = {
    "study": "study", "machine": "machine", "outcome": "outcome", "sentence": "answer in words", "failure": "why it failed",
}  # fmt: skip


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset, of the variants that are finished.

    Coordinates (variant): variant (its label), source (the file), and each varied parameter by its path, in SI. Variables
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
        data[name] = variable("variant", numbers, name.replace("_", " "), unit_of_number(name, amplitude, bare))
    for k, kind in enumerate(dict.fromkeys(curve.kind for c in done for curve in c.curves), 1):
        data |= _curves(k, kind, done)
    labels = np.array([case.variant.label for case in cases], str)
    coordinates = {
        "variant": variable("variant", labels, "variant"),
        "source": variable("variant", np.array([case.variant.source for case in cases], str), "file"),
    } | {path: _varied(path, cases) for path in plan.spec.vary}
    result = xr_.Dataset({k: v for k, v in data.items() if k not in coordinates}, coordinates)
    warnings, assumed = (_together(cases, said) for said in ([c.warnings for c in done], [c.assumed for c in done]))
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


def _varied(path: str, cases: Sequence[Case]) -> Any:
    """What a key was in each variant: numbers, or texts where one of them is none."""
    values = [case.variant.varied.get(path) for case in cases]
    unit = ""
    for case in cases:
        parameters = getattr(case.variant.asked.subject, "parameters", {}) if case.variant.asked is not None else {}
        unit = getattr(parameters.get(path), "unit", unit) if isinstance(parameters, dict) else unit
    numeric = all(v is None or (isinstance(v, int | float) and not isinstance(v, bool)) for v in values)
    stored = (
        [np.nan if v is None else v for v in values] if numeric else np.array(["" if v is None else str(v) for v in values])
    )
    return variable("variant", stored, path, unit)


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
