"""Comparison of machines or variants side by side: the study of each, all checked before the first begins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import date, time
from functools import partial
from itertools import product, takewhile
from math import prod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator

from wucht.dynamics.work import TaskReport, Work
from wucht.errors import InputError, WuchtError
from wucht.file_names import printable
from wucht.results.comparison_table import comparison_report
from wucht.schema import Composite, composite
from wucht.studies.answer import Answer
from wucht.studies.comparison.answer import state_comparison
from wucht.studies.comparison.compared_result import ComparedResult
from wucht.studies.comparison.figure import figure
from wucht.studies.comparison.variants import ComparedVariants, Variant
from wucht.studies.resource_limits import refuse_turns
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Prepared = tuple[tuple[Variant, Any], ...]  # each variant, with what its study has prepared


def _sources(raw: Any) -> Any:
    texts = isinstance(raw, list | tuple) and raw and all(isinstance(g, str) and g.strip() for g in raw)
    if not texts:
        raise ValueError('must be a list of study files, catalogue names and folders of results: of = ["A", "B"]')
    for name in raw:
        if printable(name) != name:
            raise InputError("study.of", name, "must be a name in UTF-8 without control characters: it is stored in the result")
    return tuple(raw)


def _table(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table: set = { PATH = VALUE, ... }")
    return _flat(raw)


def _lists(raw: Any) -> Any:
    if not isinstance(raw, Mapping):
        raise ValueError("must be a table of lists: vary = { PATH = [VALUE, ...], ... }")
    table = _flat(raw)
    for path, values in table.items():
        if not isinstance(values, list | tuple) or not values:
            raise InputError(f"study.vary.{path}", values, "must be a list of values")
        for i, value in enumerate(values):
            if (moment := _date_in(value)) is not None:
                raise InputError(f"study.vary.{path}[{i}]", moment, "must be a number or a text, not a date")
    return {path: tuple(values) for path, values in table.items()}


def _date_in(value: Any) -> date | time | None:
    """Return a date or a time of day in a value, as TOML has them; None if there is none."""
    if isinstance(value, date | time):
        return value
    inside = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return next((moment for one in inside if (moment := _date_in(one)) is not None), None)


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the values by path: TOML reads ``b1.damping = 3`` as a table within a table."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) and value else {prefix + key: value}
    return flat


class Comparison(Study):
    """Comparison of machines or variants side by side: the study of each, in one result."""

    kind = "comparison"
    subject = "wucht.studies.comparison.variant_files:VARIANTS"
    tiled = True
    most_varied: ClassVar[int] = 2
    fewest: ClassVar[int] = 2
    most: ClassVar[int] = 500

    of: Composite[Annotated[tuple[str, ...], BeforeValidator(_sources)]] = composite(
        title="compared files", description="study files, catalogue names, and folders of existing results"
    )
    set: Composite[Annotated[dict[str, Any], BeforeValidator(_table)]] = composite(
        default_factory=dict,
        title="keys set in all variants",
        description="keys set in all variants, by path; those of the study begin with `study.`",
    )
    vary: Composite[Annotated[dict[str, tuple[Any, ...]], BeforeValidator(_lists)]] = composite(
        default_factory=dict,
        title="values of varied keys",
        description="values of one or two keys; every combination is a variant of each file",
    )

    def check(self) -> None:
        """Check that there are at least two variants, and not too many to read."""
        if len(self.vary) > self.most_varied:
            raise InputError("study.vary", sorted(self.vary), f"at most {self.most_varied} parameters are varied at once")
        count = len(self.of) * prod(map(len, self.vary.values()))
        if not self.fewest <= count <= self.most:
            requirement = f"there must be {self.fewest} to {self.most} variants, files times values; these are {count}"
            raise InputError("study.vary" if self.vary else "study.of", None, requirement)
        if duplicates := sorted(set(self.vary) & set(self.set)):
            raise InputError(f"study.vary.{duplicates[0]}", None, "this key is also in set; give it once")

    @property
    def combinations(self) -> tuple[dict[str, Any], ...]:
        """Varied values of each variant of a file, the last key changing fastest."""
        return tuple(dict(zip(self.vary, values, strict=True)) for values in product(*self.vary.values()))

    def prepare(self, subject: ComparedVariants, watch: Callable[[], None]) -> Prepared:
        """Return the variants with what their studies prepare; the error of one that cannot be run is its refusal.

        Raises ``InputError`` where none can.
        """
        prepared, errors = [], list[InputError]()
        for variant in subject.variants:
            try:
                prepared.append((variant, _prepared_study(variant, watch)))
            except InputError as error:
                errors.append(error)
                prepared.append((replace(variant, refusal=str(error)), None))
        if errors and all(variant.refusal for variant, _ in prepared):
            raise errors[0]
        return tuple(prepared)

    def stored_numbers(self, prepared: Prepared) -> float:
        """The largest number of values stored at once: one study runs after the other."""
        studies = [(variant.study_file, preparation) for variant, preparation in prepared if not variant.refusal]
        return max((file.spec.stored_numbers(preparation) for file, preparation in studies if file is not None), default=0.0)

    def solve(self, subject: ComparedVariants, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Run the studies one after the other, or those of several variants at once where several processes compute."""
        if work.cluster is not None:
            yield from self._solve_at_once(subject, prepared, work)
            return
        results, count = list[ComparedResult](), len(prepared)
        for k, (variant, preparation) in enumerate(prepared):
            part = work.part(f"variant {k + 1}", k / count, (k + 1) / count)
            part.report(0.0, variant.label)
            results.append(part.unit("answer", partial(_result_of, variant, preparation, part)))
            state = partial(state_comparison, all_variants=subject.variants, results=tuple(results), vary=self.vary)
            yield Answer(fill=state)

    def _solve_at_once(self, subject: ComparedVariants, prepared: Prepared, work: Work) -> Iterator[Answer]:
        tasks = {f"variant {k}/answer": partial(_result_from_task, variant) for k, (variant, _) in enumerate(prepared, 1)}
        results: dict[str, ComparedResult] = {}
        for name, result in work.units(tasks, "variants"):
            results[name] = result
            first = tuple(results[one] for one in takewhile(results.__contains__, tasks))
            if first:
                yield Answer(fill=partial(state_comparison, all_variants=subject.variants, results=first, vary=self.vary))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the curves of all variants in common panels, and numbers over the varied keys."""
        return figure(result)

    def report(self, result: xr.Dataset) -> list[str]:
        """Return the table of the variants, whose columns are variables of the result."""
        return comparison_report(result)


def _prepared_study(variant: Variant, watch: Callable[[], None]) -> Any:
    """Return what the study of a variant prepares. Raises ``InputError``."""
    if variant.study_file is None:
        return None
    spec, subject = variant.study_file.spec, variant.study_file.subject
    try:
        if variant.dimensionless:
            spec.refuse_units()
        refuse_turns(spec, subject)
        return spec.prepare_watched(subject, watch)
    except InputError as error:
        raise error.with_file(variant.study_file.path) from None


def _result_of(variant: Variant, preparation: Any, work: Work) -> ComparedResult:
    """Run a variant. A failure is a result, too; the units of its study are stored with those of the comparison."""
    if variant.result is not None:
        return ComparedResult.from_dataset(variant.result, variant.kind)
    if variant.study_file is None or variant.refusal:
        return ComparedResult.from_failure(variant.refusal)
    spec, subject = variant.study_file.spec, variant.study_file.subject
    try:
        for answer in spec.solve(subject, preparation, work):  # noqa: B007
            pass
        return ComparedResult.from_dataset(answer.to_dataset(), spec.kind)
    except WuchtError as error:
        return ComparedResult.from_failure(str(error))


def _result_from_task(variant: Variant, report: TaskReport) -> ComparedResult:
    """Prepare and run a variant in a process of its own."""
    preparation = None if variant.refusal else _prepared_study(variant, partial(report, 0.0))
    return _result_of(variant, preparation, Work(reporter=lambda share, _label: report(share)))
