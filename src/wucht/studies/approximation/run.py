"""Plan -> findings: each comparison of both models, then the error of the slow equations at smaller epsilon."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from wucht.studies.approximation.comparison import Comparison, comparison
from wucht.studies.approximation.order import Errors, UnmeasuredError, errors
from wucht.studies.approximation.prepare import Plan
from wucht.studies.work import Work


@dataclass(frozen=True)
class Findings:
    """comparisons: of the machine as it is, then of each value. unmeasured: why there is no order of the error."""

    comparisons: tuple[Comparison, ...] = ()
    measured: Errors | None = None
    unmeasured: str = ""

    @property
    def own(self) -> Comparison | None:
        """That of the machine as it is."""
        return self.comparisons[0] if self.comparisons else None

    @property
    def along(self) -> tuple[Comparison, ...]:
        """Those of the values, in order."""
        return self.comparisons[1:]

    @property
    def complete(self) -> bool:
        """Whether nothing is left to be done."""
        return self.measured is not None or bool(self.unmeasured)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compare and measure; what is found after each comparison."""
    findings = Findings()
    yield findings
    count = len(plan.cases) + 1
    for k in range(len(plan.cases)):
        part = work.part(f"comparison {k + 1}", k / count, (k + 1) / count)
        part.report(0.0)
        one = part.unit("both models", partial(comparison, plan, k, part))
        findings = Findings((*findings.comparisons, one))
        yield findings
    part = work.part("order", 1 - 1 / count, 1.0)
    part.report(0.0)
    try:
        yield replace(findings, measured=errors(plan.spec, plan.machine, part))
    except UnmeasuredError as error:
        yield replace(findings, unmeasured=str(error))
