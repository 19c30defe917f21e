"""The answer of a comparison: each number of the summaries over ``variant`` by its path, and the curves of all variants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from wucht.plots.result_curves import CurveKind
from wucht.results.formatting import value_in_words
from wucht.studies.answer import Answer
from wucht.studies.comparison.compared_result import ComparedResult
from wucht.studies.comparison.variants import Variant, VariedKey


def state_comparison(
    a: Answer, all_variants: Sequence[Variant], results: Sequence[ComparedResult], vary: Mapping[str, Sequence[Any]]
) -> None:
    """State the results of the first variants."""
    variants, outcomes = all_variants[: len(results)], Counter(r.outcome for r in results if r.outcome)
    ready = (
        f"{len(results)} variants" if len(results) == len(all_variants) else f"{len(results)} of {len(all_variants)} variants"
    )
    a.sentence = ": ".join(
        [ready, *([", ".join(f"{n} {outcome}" for outcome, n in outcomes.most_common())] if outcomes else [])]
    )
    labels = [variant.label for variant in variants]
    a.warn(*_merged_sentences(labels, [r.wucht.warnings for r in results]))
    a.assume(*_merged_sentences(labels, [r.wucht.assumed for r in results]))
    unitless = [label for label, variant in zip(labels, variants, strict=True) if variant.dimensionless]
    if len(unitless) < len(variants):
        a.warn(*(f"{one}: dimensionless; its numbers have no units and cannot be compared with others" for one in unitless))
    coordinates = _state_variants(a, labels, variants)
    names = list(dict.fromkeys(name for r in results for name in r.numbers))
    words = {name: (_path_label(name), _unit_of(name, results)) for name in names}
    texts = {
        "study": ("study", [variant.kind for variant in variants]),
        "machine": ("machine", [variant.title for variant in variants]),
        "outcome": ("outcome", [r.outcome for r in results]),
        "sentence": ("verdict", [r.wucht.sentence for r in results]),
        "failure": ("reason for a failure", [r.wucht.failure for r in results]),
    }
    for name, (what, values) in texts.items():
        if name not in coordinates and name not in words:
            a.curve(name, np.array(values, str), what, "", "variant")
    for name in names:
        if name not in coordinates:
            a.curve(name, [r.numbers.get(name, np.nan) for r in results], *words[name], "variant")
    for k, kind in enumerate(dict.fromkeys(kind for r in results for kind in r.curves), 1):
        _state_curves(a, k, kind, results)
    keys = variants[0].keys
    rows = [
        {
            "label": label, "source": variant.source, "varied": dict(variant.varied_values), "study": variant.kind,
            "machine": variant.title, "outcome": r.outcome, "failure": r.wucht.failure or None, "summary": r.wucht.summary,
        }
        for label, variant, r in zip(labels, variants, results, strict=True)
    ]  # fmt: skip
    parts = {key.path: (key.description, key.unit or "") for key in keys} | words
    a.number("variants", rows, "the variants, each with its summary", parts=parts)
    a.number("outcomes", dict(outcomes), "number of variants of each outcome")
    a.number("failed", sum(bool(r.wucht.failure) for r in results), "number of variants that failed")
    a.number("vary", {path: list(values) for path, values in vary.items()}, "values of each varied key")
    key_facts = {key.path: {"what": key.description, "unit": key.unit} for key in keys}
    a.number("varied", key_facts, "description and unit of each varied key")
    headlines = list(dict.fromkeys(name for r in results for name in r.wucht.headlines if name in words))
    a.number("headline", headlines or names, "numbers shown first")


def _state_variants(a: Answer, labels: Sequence[str], variants: Sequence[Variant]) -> set[str]:
    """State the coordinates, the labels of the variants and the values of varied keys, and return their names."""
    a.curve("variant", np.array(labels, str), "variant")
    names, sources = (np.array([getattr(variant, key) for variant in variants], str) for key in ("name", "source"))
    a.curve("name", names, "name without varied values", "", "variant", coordinate=True)
    a.curve("source", sources, "file", "", "variant", coordinate=True)
    a.curve("variant_number", np.arange(1, len(variants) + 1), "number of the variant", "", "variant", coordinate=True)
    for key in variants[0].keys:
        _state_varied_key(a, key, [variant.varied_values[key.path] for variant in variants])
    return {"variant", "name", "source", "variant_number", *(key.path for key in variants[0].keys)}


def _state_varied_key(a: Answer, key: VariedKey, values: Sequence[Any]) -> None:
    """State the values of a key in all variants, in SI: numbers, or texts where one of them is no number."""
    factor, unit = key.printed_scale
    if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        print_attributes = {"printed_units": unit, "printed_factor": factor} if key.written_unit else {}
        a.curve(key.path, values, key.description, key.unit or "", "variant", coordinate=True, attributes=print_attributes)
    else:
        texts = np.array([value_in_words(v, factor, unit) for v in values])
        a.curve(key.path, texts, key.description, "", "variant", coordinate=True)


def _state_curves(a: Answer, number: int, kind: CurveKind, results: Sequence[ComparedResult]) -> None:
    """State the curves of one kind, of all variants, padded to the length of the longest."""
    curves = [r.curves.get(kind) for r in results]
    longest = max(len(curve[0]) for curve in curves if curve is not None)
    coordinates = np.full((2, len(curves), longest), np.nan)
    for k, curve in enumerate(curves):
        if curve is not None:
            coordinates[:, k, : len(curve[0])] = curve
    for i, axis in enumerate(("x", "y")):
        name, dimensions = f"curve_{number}_{axis}", f"variant sample_{number}"
        a.curve(name, coordinates[i], kind[i], kind[2 + i], dimensions, coordinate=axis == "x")


def _path_label(path: str) -> str:
    """Return the path of a number of a summary as a label, such as ``final phases, p1``."""
    name, _, of = path.partition(".")
    return f"{name.replace('_', ' ')}{f', {of}' if of else ''}"


def _unit_of(name: str, results: Sequence[ComparedResult]) -> str:
    """Return the unit of a number: results of earlier versions do not know it."""
    return next((r.wucht.unit_at(name) for r in results if name in r.numbers and r.wucht.quantities), "")


def _merged_sentences(labels: Sequence[str], sentences: Sequence[Sequence[str]]) -> list[str]:
    """Return sentences on each variant, those common to all of them once."""
    count = Counter(sentence for of_variant in sentences for sentence in of_variant)
    common = [sentence for sentence, n in count.items() if n == len(sentences)]
    pairs = [(label, sentence) for label, of_variant in zip(labels, sentences, strict=True) for sentence in of_variant]
    return [*common, *(f"{label}: {sentence}" for label, sentence in pairs if sentence not in common)]
