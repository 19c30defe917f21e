"""Plan -> findings: the branches of steady states."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.branches.bifurcation_diagram import BranchFindings, follow_branches
from wucht.dynamics.work import Work
from wucht.studies.speed_curve.prepare import Plan


def run(plan: Plan, work: Work) -> Iterator[BranchFindings]:
    """The findings after each branch."""
    return follow_branches(plan.case, work)
