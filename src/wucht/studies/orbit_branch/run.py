"""Plan -> findings: steady states, and branches of orbits."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.branches.orbit_diagram import OrbitFindings, follow_orbits
from wucht.dynamics.work import Work
from wucht.studies.orbit_branch.prepare import Plan


def run(plan: Plan, work: Work) -> Iterator[OrbitFindings]:
    """The findings after each step."""
    return follow_orbits(plan.case, work)
