"""Where the torques balance: 002 (3.51), figure 3.2b."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.analysis.working_points import WorkingPoint
from wucht.studies.torque_balance.prepare import Plan
from wucht.studies.work import Work

Findings = list[WorkingPoint]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The working points; they take milliseconds, and come at once."""
    work.report(0.0, "working points")
    yield plan.curves.working_points
