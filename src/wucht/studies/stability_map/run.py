"""Plan -> findings: of all motions, or of how the modulated motion ends."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.work import Work
from wucht.studies.stability_map.map_parts import F, MapPlan


def run(plan: MapPlan[F], work: Work) -> Iterator[F]:
    """The findings, each more complete than those before."""
    return plan.run(work)
