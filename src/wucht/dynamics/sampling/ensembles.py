"""An ensemble: what is asked of each member, and what became of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
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


_ARRAYS = ("outcome", "settling_time", "peak_amplitude", "end_time")


@dataclass(frozen=True)
class MemberOutcomes:
    """What became of M members, each array (M,).

    outcome: its place in ``OUTCOMES``. settling_time: nan where it has not settled. peak_amplitude: the largest of the main
    rotor's axis from where it rests. end_time: how far the member was followed. failures: a sentence for each that failed, by
    the member's index.
    """

    outcome: np.ndarray
    settling_time: np.ndarray
    peak_amplitude: np.ndarray
    end_time: np.ndarray
    failures: tuple[tuple[int, str], ...] = ()

    @classmethod
    def joined(cls, parts: Sequence[MemberOutcomes]) -> MemberOutcomes:
        """Of several ensembles in a row."""
        begins = np.cumsum([0, *(len(p.outcome) for p in parts)])
        failures = tuple((int(begin) + i, why) for begin, p in zip(begins, parts, strict=False) for i, why in p.failures)
        return cls(**{name: np.concatenate([getattr(p, name) for p in parts]) for name in _ARRAYS}, failures=failures)

    def with_failures(self, failures: Mapping[int, str]) -> MemberOutcomes:
        """With the sentences of those that failed, by their index."""
        return replace(self, failures=tuple(sorted(failures.items())))

    def replaced(self, members: np.ndarray, seen: MemberOutcomes) -> MemberOutcomes:
        """With what became of some members (k,), by their numbers."""
        arrays = {name: getattr(self, name).copy() for name in _ARRAYS}
        for name, values in arrays.items():
            values[members] = getattr(seen, name)
        failures = dict(self.failures) | {int(members[i]): why for i, why in seen.failures}
        return MemberOutcomes(**arrays, failures=tuple(sorted(failures.items())))

    def taken(self, members: np.ndarray) -> MemberOutcomes:
        """What became of some members, by their numbers (k,)."""
        place = {int(member): i for i, member in enumerate(members)}
        failures = sorted((place[i], why) for i, why in self.failures if i in place)
        return MemberOutcomes(**{name: getattr(self, name)[members] for name in _ARRAYS}, failures=tuple(failures))

    def counts(self) -> dict[Outcome, int]:
        """How many members have each outcome that occurs, in the order of ``OUTCOMES``."""
        numbers = np.bincount(self.outcome, minlength=len(OUTCOMES))
        return {o: int(k) for o, k in zip(OUTCOMES, numbers, strict=True) if k}
