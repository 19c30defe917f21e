"""Question and variants -> plan -> findings: the study of each variant, checked before the first is begun."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.studies.comparison.compared import Compared, compared, refused
from wucht.studies.comparison.spec import Comparison
from wucht.studies.comparison.variants import Variant, Variants
from wucht.studies.registry import Study, study_of
from wucht.studies.room import refuse_turns


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
