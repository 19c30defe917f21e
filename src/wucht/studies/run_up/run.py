"""Plan -> findings: each run integrated leg by leg, and the verdict on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wucht.dynamics.run_ups.run_up import Motion, run_up
from wucht.dynamics.work import Work
from wucht.studies.run_up.prepare import Plan


@dataclass(frozen=True)
class Findings:
    """The motions of each run, of the full equations first. finished: how many runs are."""

    motions: tuple[tuple[Motion, ...], ...]
    finished: int


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; the findings after each leg."""
    done: list[tuple[Motion, ...]] = []
    count = len(plan.cases)
    for k, case in enumerate(plan.cases):
        part = work.part(f"run {k + 1}", k / count, (k + 1) / count) if plan.several else work
        motions: tuple[Motion, ...] = ()
        for motions in run_up(case.run, part):
            if not done:  # of later runs only whole ones are shown: they would be taken for finished
                yield Findings((motions,), 0)
        done.append(motions)
        yield Findings(tuple(done), len(done))
