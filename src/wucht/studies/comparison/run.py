"""Plan -> findings: the study of each variant, and of its result what is compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.studies.comparison.compared import Compared, compared, refused
from wucht.studies.comparison.prepare import Case, Plan


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
