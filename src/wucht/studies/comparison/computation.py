"""Spec and variants -> plan -> findings: each variant's study, all checked before the first begins."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.plots.curves import thin_curve
from wucht.plots.time_courses import shown_until
from wucht.studies.comparison.spec import Comparison
from wucht.studies.comparison.variants import ComparedVariants, Variant
from wucht.studies.registry import study_of
from wucht.studies.resource_limits import refuse_turns

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class VariantCurve:
    """Curve of y over x (N,), with labels and units of both; NaN between its parts."""

    labels: tuple[str, str]
    unit: tuple[str, str]
    x: np.ndarray
    y: np.ndarray

    @property
    def kind(self) -> tuple[str, ...]:
        """Labels and units: curves of one kind are drawn in one panel."""
        return (*self.labels, *self.unit)


@dataclass(frozen=True)
class VariantResult:
    """Result of one variant. numbers, units: of its summary, those in tables by path. headlines: numbers shown first."""

    study: str
    machine: str
    outcome: str
    sentence: str
    failure: str
    summary: Mapping[str, Any] = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    headlines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    curves: tuple[VariantCurve, ...] = ()


def failed_result(variant: Variant, failure: str) -> VariantResult:
    """Return the result of a variant whose study failed."""
    kind = "" if variant.study_file is None else variant.study_file.spec.kind
    return VariantResult(kind, variant.title, "failed", failure, failure)


def variant_result(variant: Variant, result: xr.Dataset) -> VariantResult:
    """Return the result of a variant from the Dataset of its study."""
    kind = str(result.attrs["study"]) if variant.study_file is None else variant.study_file.spec.kind
    spec, summary, failure = study_of(kind).study, result.wucht.summary, str(result.attrs["failure"])
    outcome = str(summary.get("outcome") or ("failed" if failure else ""))
    numbers = _numbers_by_path(summary)
    units = {path: result.wucht.unit_at(path) for path in numbers} if result.wucht.quantities else {}
    pairs = spec.curves_of_equations if result.attrs.get("subject") == "system" else spec.curves
    curves = [c for x, y in pairs if (c := _curve(result, x, y, summary)) is not None]
    headlines = tuple(result.wucht.headlines)
    return VariantResult(
        kind, variant.title, outcome, str(result.attrs["sentence"]), failure, summary, numbers, units, headlines,
        tuple(result.wucht.warnings), tuple(result.wucht.assumed), tuple(curves),
    )  # fmt: skip


def _numbers_by_path(summary: Mapping[str, Any], prefix: str = "") -> dict[str, float]:
    """Return the numbers by path; lists are not compared."""
    by_path: dict[str, float] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            by_path |= _numbers_by_path(value, f"{prefix}{key}.")
        elif isinstance(value, int | float):
            by_path[prefix + key] = float(value)
    return by_path


def _stable_values(result: xr.Dataset, of: xr.DataArray) -> xr.DataArray:
    """Return the values of steady configurations that are stable and without overlapping bodies."""
    if "configuration" not in of.dims or "stable" not in result:
        return of
    stable = of.where((result["stable"] == 1) & (result.get("overlapping", 0) == 0))
    return stable if bool(stable.notnull().any()) else of


def _drawn_state(result: xr.Dataset, of: xr.DataArray, summary: Mapping[str, Any]) -> xr.DataArray:
    """Return a variable of states of equations for the one that is drawn, by default the first."""
    names = [str(name) for name in result["state_name" if "state_name" in result.coords else "state"].values]
    name = str(summary.get("show") or names[0])
    of = of.isel(state=names.index(name))
    long_name = str(of.attrs["long_name"])
    return of.assign_attrs(long_name=long_name.replace("the state", name) if "the state" in long_name else name)


def _curve(result: xr.Dataset, x: str, y: str, summary: Mapping[str, Any]) -> VariantCurve | None:
    """Return a variable over another, None where the result lacks one of them.

    Of several bodies, cams or runs the first is taken. Several directions, or steady configurations (the stable ones, if any
    is), follow each other like the branches of a curve. summary: of the result; until its settling time a run has its detail.
    """
    if x not in result or y not in result or "case" in result[y].dims:
        return None
    at, of = result[x], _stable_values(result, result[y])
    if "state" in of.dims:
        of = _drawn_state(result, of, summary)
    if "configuration" in of.dims:
        at = at.expand_dims(configuration=of.sizes["configuration"])
    if not at.size or not of.size or not set(at.dims) <= set(of.dims):
        return None
    of = of.isel(dict.fromkeys(set(of.dims) - set(at.dims), 0)).transpose(*at.dims)
    rows = np.atleast_2d(at.values.astype(float)), np.atleast_2d(of.values.astype(float))
    if "branch" in result and result["branch"].dims == at.dims:
        ends = np.flatnonzero(np.diff(result["branch"].values)) + 1
        parts = list(zip(*(np.split(row[0], ends) for row in rows), strict=True))
    else:
        parts = list(zip(*rows, strict=True))
    until = shown_until([summary], float(np.nanmax(at.values))) if x == "time" else np.inf
    thinned_parts = [_thin_both(part[0], part[1], until) for part in parts]
    coordinates = [np.concatenate([piece for pair in thinned_parts for piece in (pair[k], [np.nan])])[:-1] for k in range(2)]
    words = [(str(a.get("long_name", n)), str(a.get("units", ""))) for n, a in ((x, at.attrs), (y, of.attrs))]
    return VariantCurve((words[0][0], words[1][0]), (words[0][1], words[1][1]), *coordinates)


def _thin_both(x: np.ndarray, y: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Thin a curve up to an abscissa, and beyond: the part that is drawn keeps its detail."""
    k = int(np.count_nonzero(x <= until))
    pieces = [thin_curve(x[part], y[part]) for part in (slice(k), slice(k, None)) if len(x[part])]
    return np.concatenate([piece[0] for piece in pieces]), np.concatenate([piece[1] for piece in pieces])


@dataclass(frozen=True)
class Case:
    """Variant with what its study has prepared; one that is not to run has a result, or a reason of refusal."""

    variant: Variant
    is_to_run: bool
    prepared: Any
    refusal: str


@dataclass(frozen=True)
class Plan:
    """All cases of a comparison."""

    spec: Comparison
    title: str
    cases: tuple[Case, ...]


def prepare(spec: Comparison, subject: ComparedVariants, watch: Callable[[], None] | None = None) -> Plan:
    """Return the plan. Raises ``InputError`` where no variant is valid; errors of single variants are recorded.

    watch: called often.
    """
    cases, errors = [], list[InputError]()
    for variant in subject.variants:
        try:
            cases.append(_case(variant, watch))
        except InputError as error:
            errors.append(error)
            cases.append(Case(variant, False, None, str(error)))
    if errors and all(case.refusal for case in cases):
        raise errors[0]
    return Plan(spec, subject.title, tuple(cases))


def _case(variant: Variant, watch: Callable[[], None] | None) -> Case:
    study_file = variant.study_file
    if study_file is None:
        return Case(variant, False, None, variant.refusal)
    try:
        if variant.dimensionless:
            study_file.spec.refuse_units()
        refuse_turns(study_file.spec, study_file.subject)
        return Case(variant, True, study_file.spec.prepare_watched(study_file.subject, watch or (lambda: None)), "")
    except InputError as error:
        raise error.with_file(study_file.path) from None


def numbers(plan: Plan) -> float:
    """Return the largest number of values stored at once: one study runs after the other."""
    cases = [(case.variant.study_file, case.prepared) for case in plan.cases if case.is_to_run]
    return max((file.spec.stored_numbers(prepared) for file, prepared in cases if file is not None), default=0.0)


@dataclass(frozen=True)
class Findings:
    """Answers of the finished variants, in their order."""

    results: tuple[VariantResult, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Run the studies one after the other, and yield the findings after each."""
    done, count = list[VariantResult](), len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"variant {k + 1}", k / count, (k + 1) / count)
        part.report(0.0, case.variant.label)
        done.append(part.unit("answer", partial(_run_case, case, part)))
        yield Findings(tuple(done))


def _run_case(case: Case, work: Work) -> VariantResult:
    """Run one case. A failure is recorded; the units of its study are stored with those of the comparison."""
    variant = case.variant
    if variant.result is not None:
        return variant_result(variant, variant.result)
    if variant.study_file is None or not case.is_to_run:
        return failed_result(variant, case.refusal)
    try:
        for answer in variant.study_file.spec.solve(variant.study_file.subject, case.prepared, work):  # noqa: B007
            pass
        return variant_result(variant, answer.to_dataset())
    except WuchtError as error:
        return failed_result(variant, str(error))
