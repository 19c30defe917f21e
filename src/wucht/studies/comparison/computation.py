"""Question and variants -> plan -> findings: each variant's study, checked before the first is begun; what is kept of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.plots.curves import thinned
from wucht.studies.comparison.spec import Comparison
from wucht.studies.comparison.variants import Variant, Variants
from wucht.studies.registry import Study, study_of
from wucht.studies.room import refuse_turns

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Curve:
    """y over x (N,), both with what they are and their unit; not a number between the parts of one."""

    what: tuple[str, str]
    unit: tuple[str, str]
    x: np.ndarray
    y: np.ndarray

    @property
    def kind(self) -> tuple[str, ...]:
        """Curves of one kind are drawn in one panel."""
        return (*self.what, *self.unit)


@dataclass(frozen=True)
class Compared:
    """Of one variant. numbers, units: of its summary, those in tables by path. shown: those that are looked at first."""

    study: str
    machine: str
    outcome: str
    sentence: str
    failure: str
    summary: Mapping[str, Any] = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    shown: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    curves: tuple[Curve, ...] = ()


def refused(variant: Variant, failure: str) -> Compared:
    """Of a variant that could not be answered."""
    kind = "" if variant.asked is None else variant.asked.spec.kind
    return Compared(kind, variant.title, "failed", failure, failure)


def compared(variant: Variant, result: xr.Dataset) -> Compared:
    """Of a result."""
    kind = str(result.attrs["study"]) if variant.asked is None else variant.asked.spec.kind
    spec, summary, failure = study_of(kind).spec, result.wucht.summary, str(result.attrs["failure"])
    outcome = str(summary.get("outcome") or ("failed" if failure else ""))
    numbers = _numbers(summary)
    units = {path: result.wucht.unit_at(path) for path in numbers} if result.wucht.quantities else {}
    pairs = [c for x, y in spec.curves if (c := _curve(result, x, y)) is not None]
    shown = tuple(result.wucht.headlines)
    return Compared(
        kind, variant.title, outcome, str(result.attrs["sentence"]), failure, summary, numbers, units, shown,
        tuple(result.wucht.warnings), tuple(result.wucht.assumed), tuple(pairs),
    )  # fmt: skip


def _numbers(summary: Mapping[str, Any], prefix: str = "") -> dict[str, float]:
    """The numbers by path; lists are no numbers to compare."""
    found: dict[str, float] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            found |= _numbers(value, f"{prefix}{key}.")
        elif isinstance(value, int | float):
            found[prefix + key] = float(value)
    return found


def _where_stable(result: xr.Dataset, of: xr.DataArray) -> xr.DataArray:
    """Values of steady configurations where they are stable, and of no bodies that would stand in each other's place."""
    if "configuration" not in of.dims or "stable" not in result:
        return of
    stable = of.where((result["stable"] == 1) & (result.get("overlapping", 0) == 0))
    return stable if bool(stable.notnull().any()) else of


def _curve(result: xr.Dataset, x: str, y: str) -> Curve | None:
    """A variable over another, None where the result has them not.

    Of several bodies, cams or runs the first. What is given for several directions, or steady configurations (as far as these
    are stable, if any is), follows each other, as the branches of a curve do.
    """
    if x not in result or y not in result or "case" in result[y].dims:
        return None
    at, of = result[x], _where_stable(result, result[y])
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
    drawn = [thinned(*part) for part in parts]
    joined = [np.concatenate([piece for pair in drawn for piece in (pair[k], [np.nan])])[:-1] for k in range(2)]
    words = [(str(a.get("long_name", n)), str(a.get("units", ""))) for n, a in ((x, at.attrs), (y, of.attrs))]
    return Curve((words[0][0], words[1][0]), (words[0][1], words[1][1]), *joined)


@dataclass(frozen=True)
class Case:
    """A variant with its study and that study's plan; without a plan there is a result, or it is refused."""

    variant: Variant
    study: Study | None
    plan: Any
    refused: str


@dataclass(frozen=True)
class Plan:
    """All of them."""

    spec: Comparison
    title: str
    cases: tuple[Case, ...]


def prepare(spec: Comparison, subject: Variants) -> Plan:
    """The plan. Raises ``InputError`` where none of the variants can be asked; what is wrong with some is recorded."""
    cases, errors = [], list[InputError]()
    for variant in subject.variants:
        try:
            cases.append(_case(variant))
        except InputError as error:
            errors.append(error)
            cases.append(Case(variant, None, None, str(error)))
    if errors and all(case.refused for case in cases):
        raise errors[0]
    return Plan(spec, subject.title, tuple(cases))


def _case(variant: Variant) -> Case:
    asked = variant.asked
    if asked is None:
        return Case(variant, None, None, variant.refused)
    study = study_of(asked.spec.kind)
    try:
        if variant.dimensionless:
            asked.spec.refuse_units()
        refuse_turns(asked.spec, asked.subject)
        return Case(variant, study, study.prepare(asked.spec, asked.subject), "")
    except InputError as error:
        raise error.in_file(asked.path) from None


def numbers(plan: Plan) -> float:
    """At most how many numbers are stored at once: one study after the other."""
    return max((case.study.numbers(case.plan) for case in plan.cases if case.study is not None), default=0.0)


@dataclass(frozen=True)
class Findings:
    """Of the variants that are finished, in their order."""

    compared: tuple[Compared, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Answer one after the other; the findings after each."""
    done, count = list[Compared](), len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"variant {k + 1}", k / count, (k + 1) / count)
        part.report(0.0, case.variant.label)
        done.append(part.unit("answer", partial(_answered, case, part)))
        yield Findings(tuple(done))


def _answered(case: Case, work: Work) -> Compared:
    """Of one. What fails is recorded; the units of its study are remembered with those of the comparison."""
    variant = case.variant
    if variant.result is not None:
        return compared(variant, variant.result)
    if case.study is None or variant.asked is None:
        return refused(variant, case.refused)
    findings = None
    try:
        for findings in case.study.run(case.plan, work):  # noqa: B007
            pass
        return compared(variant, case.study.dataset(case.plan, findings))
    except WuchtError as error:
        return refused(variant, str(error))
