"""Question and variants -> plan: the study of each, checked before the first is begun."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from wucht.errors import InputError
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
