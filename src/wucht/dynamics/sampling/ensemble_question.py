"""What is asked of each member of an ensemble."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from wucht.machines.machine import Machine

Report = Callable[[float], None]  # is told the share that is done, 0 to 1; may raise ``KeyboardInterrupt``


def part_of(report: Report, begin: float, share: float) -> Report:
    """What tells how far a part of the work is, which begins when a share is done and is as large a share of all."""
    return lambda done: report(begin + share * done)


@dataclass(frozen=True)
class EnsembleQuestion:
    """Run up each member of an ensemble of one machine, and tell what becomes of it.

    varied: paths of the parameters that differ from member to member. model, inertia, order: as of a run-up. until: how long
    each member is followed; None: until it has settled, at most ``longest`` turns. tolerance: of the integration.
    """

    machine: Machine
    varied: tuple[str, ...] = ()
    model: Literal["full", "slow"] = "full"
    inertia: bool | None = None
    order: Literal[1, 2] = 1
    until: float | None = None
    longest: float = 25_000.0
    tolerance: float = 1e-6
