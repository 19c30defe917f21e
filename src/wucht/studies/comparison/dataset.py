"""Findings -> the quantities of a comparison: a table over ``variant``, and the curves; and its lines in a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.formatting import label, printed_unit, value_in_words, wrap_text
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.comparison.computation import Case, Findings, Plan, VariantResult
from wucht.studies.comparison.variants import VariedKey

if TYPE_CHECKING:
    import xarray as xr


_DESCRIPTIONS = {
    "study": "study", "machine": "machine", "outcome": "outcome", "sentence": "verdict", "failure": "reason for a failure",
}  # fmt: skip


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the Dataset of the finished variants: each number of their summaries by its path, and their curves."""
    done = findings.results
    cases = plan.cases[: len(done)]
    names = list(dict.fromkeys(name for c in done for name in c.numbers))
    coordinates = _coordinates(cases)
    coordinate_names = {q.name for q in coordinates}
    numbers = [_number_quantity(name, done) for name in names if name not in coordinate_names]
    descriptions = {
        key: description for key, description in _DESCRIPTIONS.items() if key not in coordinate_names and key not in names
    }
    texts = [
        Quantity(key, np.array([getattr(c, key) for c in done], str), description, "", "variant")
        for key, description in descriptions.items()
    ]
    kinds = dict.fromkeys(curve.kind for c in done for curve in c.curves)
    curves = [q for k, kind in enumerate(kinds, 1) for q in _curve_quantities(k, kind, done)]
    warnings, assumptions = (_merged_sentences(cases, of) for of in ([c.warnings for c in done], [c.assumptions for c in done]))
    if not all(case.variant.dimensionless for case in cases):
        dimensionless = [case.variant.label for case in cases if case.variant.dimensionless]
        warnings += [
            f"{one}: dimensionless; its numbers have no units and cannot be compared with others" for one in dimensionless
        ]
    quantities = [*coordinates, *texts, *numbers, *curves, *_summary_quantities(plan, done, names)]
    return result_dataset(quantities, _sentence(plan, done), warnings, assumptions)


def _number_quantity(name: str, done: Sequence[VariantResult]) -> Quantity:
    """Return a number of the summaries, of all variants."""
    unit = next((c.units[name] for c in done if name in c.units), "")
    return Quantity(name, [c.numbers.get(name, np.nan) for c in done], _path_label(name), unit, "variant")


def _coordinates(cases: Sequence[Case]) -> list[Quantity]:
    """Return the labels of the variants, and the values of varied keys, in SI."""
    labels, names, sources = (
        np.array([getattr(case.variant, key) for case in cases], str) for key in ("label", "name", "source")
    )
    coordinates = [
        Quantity("variant", labels, "variant", "", "variant"),
        Quantity("name", names, "name without varied values", "", "variant", coordinate=True),
        Quantity("source", sources, "file", "", "variant", coordinate=True),
        Quantity("variant_number", np.arange(1, len(cases) + 1), "number of the variant", "", "variant", coordinate=True),
    ]
    return [*coordinates, *(_varied_quantity(key, cases) for key in _varied_keys(cases))]


def _curve_quantities(number: int, kind: tuple[str, ...], done: Sequence[VariantResult]) -> list[Quantity]:
    """Return the curves of one kind, of all variants, padded to the length of the longest."""
    variant_curves = [next((curve for curve in c.curves if curve.kind == kind), None) for c in done]
    longest = max(len(curve.x) for curve in variant_curves if curve is not None)
    coordinates = np.full((2, len(variant_curves), longest), np.nan)
    for k, curve in enumerate(variant_curves):
        if curve is not None:
            coordinates[:, k, : len(curve.x)] = curve.x, curve.y
    dims, axes = f"variant sample_{number}", enumerate(("x", "y"))
    return [
        Quantity(f"curve_{number}_{axis}", coordinates[i], kind[i], kind[2 + i], dims, coordinate=axis == "x")
        for i, axis in axes
    ]


def _path_label(path: str) -> str:
    """Return the path of a number of a summary as a label, such as ``final phases, p1``."""
    name, _, of = path.partition(".")
    return f"{name.replace('_', ' ')}{f', {of}' if of else ''}"


def _varied_keys(cases: Sequence[Case]) -> tuple[VariedKey, ...]:
    """Return the varied keys, the same in all cases."""
    return cases[0].variant.keys if cases else ()


def _varied_quantity(key: VariedKey, cases: Sequence[Case]) -> Quantity:
    """Return the values of a key in all variants: numbers, or texts where one of them is no number."""
    values = [case.variant.varied_values[key.path] for case in cases]
    if not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        texts = np.array([value_in_words(v, *key.printed_scale) for v in values])
        return Quantity(key.path, texts, key.description, "", "variant", coordinate=True)
    factor, unit = key.printed_scale
    print_attributes = {"printed_units": unit, "printed_factor": factor} if key.written_unit else {}
    return Quantity(key.path, values, key.description, key.unit or "", "variant", coordinate=True, attributes=print_attributes)


def _summary_quantities(plan: Plan, done: Sequence[VariantResult], names: Sequence[str]) -> list[Quantity]:
    headlines = list(dict.fromkeys(name for c in done for name in c.headlines if name in names))
    variants = [
        {
            "label": case.variant.label, "source": case.variant.source, "varied": dict(case.variant.varied_values),
            "study": c.study, "machine": c.machine, "outcome": c.outcome, "failure": c.failure or None,
            "summary": c.summary,
        }
        for case, c in zip(plan.cases, done, strict=False)
    ]  # fmt: skip
    key_facts = {key.path: {"what": key.description, "unit": key.unit} for key in _varied_keys(plan.cases)}
    return [
        Quantity("variants", variants, "the variants, each with its summary", parts=_variant_parts(plan, done, names)),
        Quantity("outcomes", dict(Counter(c.outcome for c in done if c.outcome)), "number of variants of each outcome"),
        Quantity("failed", sum(bool(c.failure) for c in done), "number of variants that failed"),
        Quantity("vary", {path: list(values) for path, values in plan.spec.vary.items()}, "values of each varied key"),
        Quantity("varied", key_facts, "description and unit of each varied key"),
        Quantity("headline", headlines or list(names), "numbers shown first"),
    ]


def _variant_parts(plan: Plan, done: Sequence[VariantResult], names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of a variant, by path."""
    parts = {key.path: (key.description, key.unit or "") for key in _varied_keys(plan.cases)}
    return parts | {name: (q.long_name, q.unit) for name in names for q in [_number_quantity(name, done)]}


def _sentence(plan: Plan, done: Sequence[VariantResult]) -> str:
    count = Counter(c.outcome for c in done if c.outcome)
    outcomes = ", ".join(f"{n} {outcome}" for outcome, n in count.most_common())
    ready = f"{len(done)} variants" if len(done) == len(plan.cases) else f"{len(done)} of {len(plan.cases)} variants"
    return f"{ready}{f': {outcomes}' if outcomes else ''}"


def _merged_sentences(cases: Sequence[Case], sentences: Sequence[tuple[str, ...]]) -> list[str]:
    """Return sentences on each variant, those common to all of them once."""
    count = Counter(sentence for variant_sentences in sentences for sentence in variant_sentences)
    common = [sentence for sentence, n in count.items() if n == len(sentences)]
    pairs = [
        (case.variant.label, sentence)
        for case, variant_sentences in zip(cases, sentences, strict=True)
        for sentence in variant_sentences
    ]
    return [*common, *(f"{label}: {sentence}" for label, sentence in pairs if sentence not in common)]


_EQUAL = 1e-5  # of the largest value: what differs by less is printed with the same digits
_COLUMNS, _MOST_LINES, _CELL_WIDTH = 6, 60, 60
_HEAD_WIDTH = 16  # letters of a line of a column's head, where words allow it


@dataclass(frozen=True)
class _Column:
    """Column of the table. is_left_aligned: true for texts."""

    head: str
    cells: list[str]
    is_left_aligned: bool = True


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht compare`` prints: headline numbers first, and those that differ."""
    s, names, outcomes = result.wucht.summary, variant_names(result), list(map(str, result.outcome.values))
    columns = [_Column("", [_shorten(name) for name in names])] if any(names) else []
    columns += [_column(result, path) for path in s["vary"]]
    columns += [_Column("outcome", outcomes)] if any(outcomes) else []
    numbers = [_column(result, name) for name in shown_numbers(result)[:_COLUMNS]]
    if not numbers:  # no numbers for columns: the verdict of each variant
        numbers = [_Column("", list(map(str, result.sentence.values)))]
    more = [f"and {result.sizes['variant'] - _MOST_LINES} more"] if result.sizes["variant"] > _MOST_LINES else []
    failures = [f"{v['label']}: {v['failure']}" for v in s["variants"] if v["failure"]]
    return [
        result.attrs["title"],
        f"verdict: {result.attrs['sentence']}",
        *(f"  {line}" for line in [*_table_lines([*columns, *numbers]), *more, *failures]),
    ]


def variant_names(result: xr.Dataset) -> list[str]:
    """Return the names of the variants without varied values."""
    return [str(v) for v in result.get("name", result.variant).values]


def shown_numbers(result: xr.Dataset) -> list[str]:
    """Return the headline numbers of the summaries, those equal in all variants last."""
    s = result.wucht.summary
    numbers = [n for n in result.data_vars if result[n].dims == ("variant",) and result[n].dtype.kind == "f"]
    headlines = [n for n in s["headline"] if n in numbers and np.isfinite(result[n].values).any()]
    return sorted(headlines, key=lambda name: is_constant(result[name].values))


def is_constant(values: np.ndarray) -> bool:
    """True if all values, two or more, are equal as they are printed."""
    return len(values) > 1 and bool(np.ptp(values) <= _EQUAL * np.abs(values).max())


def _column(result: xr.Dataset, name: str) -> _Column:
    """Return a column with label, unit and values."""
    (factor, unit), values = printed_unit(result, name), result[name].values
    numeric = values.dtype.kind == "f"
    cells = [_number_text(factor * float(v)) if numeric else _shorten(str(v)) for v in values]
    return _Column(label(result, name, unit), cells, not numeric)


def _table_lines(columns: Sequence[_Column]) -> list[str]:
    """Return the lines of a table, with heads of as many lines as they need."""
    heads = [[line.replace("\N{NO-BREAK SPACE}", " ") for line in wrap_text(column.head, _HEAD_WIDTH)] for column in columns]
    depth = max(map(len, heads)) if any(map(any, heads)) else 0
    cells = [
        ([""] * (depth - len(head)) + head)[:depth] + column.cells[:_MOST_LINES]
        for head, column in zip(heads, columns, strict=True)
    ]
    widths = [max(map(len, column_cells)) for column_cells in cells]
    sides = [str.ljust if column.is_left_aligned else str.rjust for column in columns]
    rows = zip(*cells, strict=True)
    return [
        "  ".join(side(*of) for side, of in zip(sides, zip(row, widths, strict=True), strict=True)).rstrip() for row in rows
    ]


def _number_text(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.5g}"


def _shorten(text: str) -> str:
    return text if len(text) <= _CELL_WIDTH else f"{text[: _CELL_WIDTH - 3]}..."
