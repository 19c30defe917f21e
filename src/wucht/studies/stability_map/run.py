"""Plan -> findings: of all motions, or of how the modulated motion ends."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.work import Work
from wucht.studies.stability_map.ending_map import EndingFindings, run_endings
from wucht.studies.stability_map.prepare import Plan
from wucht.studies.stability_map.state_map import StateFindings, run_states

Findings = StateFindings | EndingFindings


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The findings, each more complete than those before."""
    stage = run_states(plan, work) if plan.plane is None else run_endings(plan, work)
    last = yield from stage
    work.report(1.0)
    yield last
