"""Plan -> findings: each comparison of both models, then the error of the averaged equations at smaller epsilon."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from wucht.dynamics.work import Work
from wucht.studies.approximation.comparison import Comparison, comparison
from wucht.studies.approximation.order import Errors, UnmeasuredError, errors
from wucht.studies.approximation.prepare import Plan


@dataclass(frozen=True)
class Findings:
    """compared: the machine as it is, then each value in order. unmeasured: why there is no order of the error."""

    compared: tuple[Comparison, ...] = ()
    measured: Errors | None = None
    unmeasured: str = ""

    @property
    def complete(self) -> bool:
        """Whether nothing is left to be done."""
        return self.measured is not None or bool(self.unmeasured)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compare and measure; the findings after each comparison."""
    findings, count = Findings(), len(plan.cases) + 1
    yield findings
    for k in range(len(plan.cases)):
        part = work.part(f"comparison {k + 1}", k / count, (k + 1) / count)
        part.report(0.0)
        findings = Findings((*findings.compared, part.unit("both models", partial(comparison, plan, k, part))))
        yield findings
    part = work.part("order", 1 - 1 / count, 1.0)
    part.report(0.0)
    try:
        yield replace(findings, measured=errors(plan.spec, plan.machine, part))
    except UnmeasuredError as error:
        yield replace(findings, unmeasured=str(error))
