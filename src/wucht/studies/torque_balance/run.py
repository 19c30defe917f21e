"""Where the torques balance: 002 (3.51), figure 3.2b."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.averaged_stability import AveragedStability, Stability
from wucht.analysis.configurations.configuration import Configuration, Describer
from wucht.analysis.configurations.search import Search, all_states
from wucht.analysis.working_points import WorkingPoint
from wucht.dynamics.work import Work
from wucht.studies.torque_balance.prepare import Plan

_NOT_ASKED = Stability.undecided("the full equations are not asked")


@dataclass(frozen=True)
class Findings:
    """The working points, and of bodies in steady phases the configuration of each; search: how they were found."""

    points: tuple[WorkingPoint, ...]
    configurations: tuple[Configuration, ...] = ()
    search: Search | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The working points: of held bodies where the curves cross, of others all steady phase configurations."""
    work.report(0.0, "working points")
    torques = plan.steady.torques
    if torques is None:
        yield Findings(tuple(plan.curves[0].working_points))
        return
    search = work.unit(
        "search", lambda: all_states(torques, *plan.searched, partial(work.report, 0.0, "working points"), prove=False)
    )
    describer = Describer(AveragedStability(torques, averaged_machine(torques.machine)))
    found = sorted((describer.described(state, _NOT_ASKED) for state in search.states), key=lambda c: c.speed)
    points = (plan.curves[0].point(c.speed, c.slow.stable is True) for c in found)
    yield Findings(tuple(points), tuple(found), search)
